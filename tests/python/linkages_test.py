"""Classical mechanisms of bodies, rods and joints against closed forms, ordinary differential equations and the rod in one piece.

Joints are springs of stiffness k, so a mechanism tends to the rigid one as 1/k: ten times k leaves a tenth of the error.
"""

import os
import unittest

import numpy as np

from package import skein

GRAVITY = 9.81
WEIGHT = [{"kind": "gravity", "acceleration": [0.0, -GRAVITY, 0.0]}]
STEPS = 1000000 if os.environ.get("SKEIN_LONG") else 100000  # of the undamped run


def point(radius, angle):
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def inertia(mass, length):
    return mass * length**2 / 12


def bar(name, start, end, mass):
    """A slender bar in the plane of x and y."""
    start, end = np.array([*start, 0.0]), np.array([*end, 0.0])
    about = inertia(mass, np.linalg.norm(end - start))
    return {"name": name, "mass": mass, "inertia": [0.1 * about, about, about], "spheres": {"radii": [0.01]},
            "placement": {"origin": list(0.5 * (start + end)), "normal": list(end - start), "tangent": [0.0, 0.0, 1.0]}}


def hinge(first, second, place, k, **keys):
    return {"kind": "hinge", "between": [first, second], "place": [*place, 0.0], "axis": [0.0, 0.0, 1.0], "stiffness": k, "torsional_stiffness": 0.1 * k, **keys}


def one_turn(duration, stiffness):
    """A motor that makes one turn from rest to rest, without a jump of its acceleration."""
    return {"kind": "position", "value": f"2*pi*t/{duration} - sin(2*pi*t/{duration})", "stiffness": stiffness}


def scene(bodies, joints, duration, dt, **tables):
    return {"time": {"duration": duration, "dt": dt}, "bodies": bodies, "joint": joints, **tables}


def opened(tables):
    return skein.Simulation(skein.Scene("linkage", **tables), threads=1)


def samples(tables, count, *figures):
    """Values of each figure at `count` times; a figure takes the run and the directors at the start."""
    found = []
    with opened(tables) as run:
        start = {name: run[name].directors[0, 0].copy() for name in run.groups}
        for _ in range(count):
            run.step(run.steps // count)
            found.append([figure(run, start) for figure in figures])
    return [np.array(values) for values in zip(*found)]


def turn(name, axis=(0, 0, 1)):
    """The angle of a body about an axis, from the start, between -pi and pi."""
    def figure(run, start):
        r = run[name].directors[0, 0].T @ start[name]
        return np.arctan2(np.dot(axis, [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]), np.trace(r) - 1)
    return figure


def place(*names):
    """The places of bodies in the plane, one after the other."""
    return lambda run, start: np.concatenate([run[name].position[0, 0, :2] for name in names])


def gap(run, start):
    return run.observables["joint_gap[m]"]


def energy(run):
    o = run.observables
    return o["kinetic_translation[J]"] + o["kinetic_rotation[J]"] + o["joint_energy[J]"]


def within_a_turn(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def solved(rates, y, end, steps, count=1):
    """States at `count` times by Runge and Kutta's fourth order."""
    h, found = end / steps, []
    for i in range(steps):
        a = rates(y)
        b = rates(y + 0.5 * h * a)
        c = rates(y + 0.5 * h * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rates(y + h * c))
        if (i + 1) % (steps // count) == 0: found.append(y)
    return np.array(found)


class Pendulum:
    """Two bars at rest, the upper one level, the lower one bent up; angles count from x."""
    LONG, SHORT, UPPER, LOWER, BENT = 0.6, 0.5, 1.0, 0.7, 0.5
    ABOUT_UPPER, ABOUT_LOWER = inertia(UPPER, LONG), inertia(LOWER, SHORT)
    ELBOW = np.array([LONG, 0.0])
    END = ELBOW + point(SHORT, BENT)
    DROP = GRAVITY * (UPPER * LONG / 2 + LOWER * (LONG + SHORT / 2))  # J: from level to hanging, the scale of energies

    @classmethod
    def scene(cls, k, dt, duration, **keys):
        return scene([bar("upper", [0, 0], cls.ELBOW, cls.UPPER), bar("lower", cls.ELBOW, cls.END, cls.LOWER)],
                     [hinge("upper", "world", [0.0, 0.0], k, **keys), hinge("upper", "lower", cls.ELBOW, k, **keys)], duration, dt, load=WEIGHT)

    @classmethod
    def rigid(cls, y):
        """Rates of both angles and their rates, of the rigid pendulum."""
        (q1, q2, u1, u2), half = y, cls.SHORT / 2
        coupling = cls.LOWER * cls.LONG * half
        mass = np.array([[cls.ABOUT_UPPER + cls.UPPER * cls.LONG**2 / 4 + cls.LOWER * cls.LONG**2, coupling * np.cos(q1 - q2)],
                         [coupling * np.cos(q1 - q2), cls.ABOUT_LOWER + cls.LOWER * half**2]])
        couples = [-coupling * np.sin(q1 - q2) * u2**2 - (cls.UPPER / 2 + cls.LOWER) * cls.LONG * GRAVITY * np.cos(q1),
                   coupling * np.sin(q1 - q2) * u1**2 - cls.LOWER * half * GRAVITY * np.cos(q2)]
        return np.array([u1, u2, *np.linalg.solve(mass, couples)])

    @classmethod
    def centres(cls, angles):
        return np.concatenate([point(cls.LONG / 2, angles[:, 0]), point(cls.LONG, angles[:, 0]) + point(cls.SHORT / 2, angles[:, 1])], axis=1)

    @classmethod
    def compliant(cls, k):
        """Rates of x, y and angle of both bars, and of their rates, with springs k between points that should meet."""
        def rates(y):
            arm1, arm2 = point(cls.LONG / 2, y[2]), point(cls.SHORT / 2, y[5])
            at_world, at_elbow = -k * (y[0:2] - arm1), k * (y[3:5] - arm2 - y[0:2] - arm1)  # forces on the upper bar

            def moment(arm, force):
                return arm[0] * force[1] - arm[1] * force[0]

            weight = np.array([0.0, -GRAVITY])
            return np.array([*y[6:], *((at_world + at_elbow) / cls.UPPER + weight), moment(arm1, at_elbow - at_world) / cls.ABOUT_UPPER,
                             *(weight - at_elbow / cls.LOWER), moment(arm2, at_elbow) / cls.ABOUT_LOWER])
        return rates


class FourBar:
    """A crank that turns round, a coupler and a rocker between two places of the world."""
    CRANK, COUPLER, ROCKER, START = 0.1, 0.3, 0.25, 0.7
    FOOT = np.array([0.3, 0.0])

    @classmethod
    def knee(cls, angle):
        """The upper intersection of the circle of the coupler about the crank's end with that of the rocker about its foot."""
        end = point(cls.CRANK, angle)
        between = cls.FOOT - end
        away = np.linalg.norm(between, axis=-1)[..., None]
        along = (away**2 + cls.COUPLER**2 - cls.ROCKER**2) / (2 * away)
        across = np.stack([-between[..., 1], between[..., 0]], axis=-1) / away
        return end + along * between / away + np.sqrt(cls.COUPLER**2 - along**2) * across

    @classmethod
    def rocker(cls, turned):
        """The rocker's turn from the crank's."""
        now, first = cls.knee(cls.START + turned) - cls.FOOT, cls.knee(cls.START) - cls.FOOT
        return np.arctan2(first[0] * now[:, 1] - first[1] * now[:, 0], now @ first)

    @classmethod
    def scene(cls, k, dt):
        end, knee = point(cls.CRANK, cls.START), cls.knee(cls.START)
        return scene([bar("crank", [0, 0], end, 0.5), bar("coupler", end, knee, 1.0), bar("rocker", cls.FOOT, knee, 1.0)],
                     [hinge("crank", "world", [0.0, 0.0], k, motor=one_turn(0.5, 1e4)), hinge("crank", "coupler", end, k),
                      hinge("coupler", "rocker", knee, k), hinge("rocker", "world", cls.FOOT, k)], 0.5, dt)


def slider_crank(k, dt, crank, rod, start):
    end, pin = point(crank, start), np.array([piston(crank, rod, start), 0.0])
    return scene([bar("crank", [0, 0], end, 0.5), bar("rod", end, pin, 1.0), bar("piston", pin - [0.02, 0.0], pin + [0.02, 0.0], 1.0)],
                 [hinge("crank", "world", [0.0, 0.0], k, motor=one_turn(0.5, 1e4)), hinge("crank", "rod", end, k), hinge("rod", "piston", pin, k),
                  {"kind": "slider", "between": ["piston", "world"], "axis": [1.0, 0.0, 0.0], "stiffness": k, "torsional_stiffness": 0.1 * k}], 0.5, dt)


def piston(crank, rod, angle):
    return crank * np.cos(angle) + np.sqrt(rod**2 - (crank * np.sin(angle))**2)


def shafts(k, dt, between):
    """Two shafts that meet at the origin at the angle `between`; the first is driven, the second is braked."""
    first, second = np.array([0.0, 0.0, 1.0]), np.array([np.sin(between), 0.0, np.cos(between)])

    def shaft(name, axis, origin, **keys):
        return ({"name": name, "mass": 1.0, "inertia": [2e-3, 2e-3, 3e-3], "spheres": {"radii": [0.02]}, "placement": {"origin": list(0.5 * origin), "tangent": list(axis)}},
                {"kind": "hinge", "between": [name, "world"], "place": list(origin), "axis": list(axis), "stiffness": k, "torsional_stiffness": 0.01 * k, **keys})

    (drive, bearing), (driven, brake) = shaft("drive", first, -0.2 * first, motor=one_turn(0.5, 1e3)), shaft("driven", second, 0.2 * second, axis_damping=0.05)
    cross = {"kind": "universal", "between": ["drive", "driven"], "place": [0.0, 0.0, 0.0], "axis": [0.0, 1.0, 0.0],
             "second_axis": [np.cos(between), 0.0, -np.sin(between)], "stiffness": k, "torsional_stiffness": 0.01 * k}
    return scene([drive, driven], [bearing, brake, cross], 0.5, dt), second


def chain(dt, steps):
    """Four bodies that fly and tumble, with a hinge, a spherical and a universal joint between them."""
    spins, speeds = [[3.0, 1, 2], [-1.0, 2, 0.5], [0.3, -2, 1], [1.0, 1, -3]], [[0.1, 0.2, 0.3], [-0.2, 0.5, 0.1], [0.3, -0.1, 0.2], [0.0, 0.4, -0.3]]
    kinds = [{"kind": "hinge", "axis": [0.0, 0.6, 0.8], "torsional_stiffness": 10.0}, {"kind": "spherical"},
             {"kind": "universal", "axis": [0.0, 1.0, 0.0], "second_axis": [0.0, 0.0, 1.0], "torsional_stiffness": 10.0}]
    bodies = [{"name": f"link{i}", "mass": 1 + 0.3 * i, "inertia": [0.02, 0.015, 0.01], "spheres": {"radii": [0.02]}, "placement": {"origin": [0.3 * i, 0.05 * i * i, 0.0]},
               "velocity": speeds[i], "angular_velocity": spins[i]} for i in range(4)]
    joints = [{"between": [f"link{i}", f"link{i + 1}"], "place": [0.3 * i + 0.15, 0.05 * i, 0.1], "stiffness": 1e4, **kind} for i, kind in enumerate(kinds)]
    return scene(bodies, joints, steps * dt, dt, output={"observables": ["angular_momentum"]})


def arm(links, elements):
    """A rod of 1 m in as many links end to end, its foot clamped, with a force at its tip."""
    young, radius = 1e6, 0.05
    force = young * np.pi * radius**4 / 4  # bends the tip by a third of the length in the linear theory

    def group(name, first, count, **keys):
        return {"name": name, "material": {"density": 1000.0, "youngs_modulus": young}, "section": {"radius": radius}, "shape": {"length": 1 / links, "elements": elements // links},
                "placement": {"kind": "list", "origins": [[(first + i) / links, 0.0, 0.0] for i in range(count)], "tangents": [[1.0, 0.0, 0.0]] * count}, **keys}

    rods, joints = [group("foot", 0, 1, start="clamped")], []
    if links > 1:
        rods.append(group("others", 1, links - 1))
        joints = [{"kind": "fixed", "between": ["foot", "others"], "pairs": "listed", "first": [0], "second": [0]}, {"kind": "fixed", "between": ["others", "others"], "pairs": "next"}]
    last = rods[-1]["name"]
    load = {"kind": "formula", "at": "end", "rods": [last], "force": ["0", "0", f"if(rod == {max(links - 2, 0)}, {force}, 0)"]}
    with opened({"time": {"duration": 12.0}, "damping": [{"kind": "uniform", "rate": 5.0}], "rods": rods, "joint": joints, "load": [load]}) as run:
        return run.step(run.steps)[last].position[-1, -1].copy()


class LeesFrame:
    """A column and a beam of one length, their far ends hinged to the world, pressed down at a fifth of the beam from the corner."""
    YOUNG, AREA, SECOND_MOMENT, LENGTH = 7.2e10, 6e-4, 2e-8, 1.2  # SI units: a section of 30 mm by 20 mm
    PUBLISHED = 1.8555e4  # N, limit load
    PRESS = 1e6  # N/m: of the spring that presses, above the steepest fall of the load after its limit

    @classmethod
    def scene(cls, n, first=0.485, last=0.525, swift=1.0, slow=3.0):
        """The spring's end goes down by `first` in the time `swift`, and on to `last` in the time `slow`; the limit is on the way. Inner nodes
        are held in the plane: free ones tip over sideways before the limit."""
        def rod(name, origin, tangent, length, elements):
            return {"name": name, "material": {"density": 2700.0, "youngs_modulus": cls.YOUNG, "law": "linear", "rotary_inertia_scale": 30.0},
                    "section": {"kind": "rectangular", "radius": 0.015, "radius_2": 0.01}, "shape": {"length": length, "elements": elements},
                    "placement": {"origin": origin, "tangent": tangent, "normal": [0.0, 0.0, 1.0]}, "hold": {"nodes": list(range(1, elements)), "directions": "z"}}

        at, side = cls.LENGTH / 5, cls.LENGTH
        rods = [rod("column", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], side, 5 * n), rod("inner", [0.0, side, 0.0], [1.0, 0.0, 0.0], at, n),
                rod("outer", [at, side, 0.0], [1.0, 0.0, 0.0], side - at, 4 * n)]
        support = {"kind": "hinge", "axis": [0.0, 0.0, 1.0], "stiffness": 1e8, "torsional_stiffness": 1e4}
        joints = [{"between": ["column", "world"], "at": [0.0], **support}, {"between": ["outer", "world"], "at": [1.0], **support},
                  {"kind": "fixed", "between": ["column", "inner"]}, {"kind": "fixed", "between": ["inner", "outer"]}]
        way = f"if(t < {swift}, {first / 2}*(1 - cos(pi*t/{swift})), {first} + {(last - first) / slow}*(t - {swift}))"
        press = {"kind": "formula", "rods": ["inner"], "at": "end", "force": ["0", f"{cls.PRESS}*({side} - {way} - y)", "0"]}
        return {"time": {"duration": swift + slow}, "damping": [{"kind": "uniform", "rate": 50.0}], "rods": rods, "joint": joints, "load": [press]}, \
            lambda t: first / 2 * (1 - np.cos(np.pi * t / swift)) if t < swift else first + (last - first) / slow * (t - swift)

    @classmethod
    def found(cls, n):
        """The largest load on the way, and the widest gap of hinges."""
        tables, way = cls.scene(n)
        load, gaps = samples(tables, 400, lambda run, start: cls.PRESS * (cls.LENGTH - way(run.time) - run["inner"].position[0, -1, 1]), gap)
        return -load.min(), gaps.max()

    @classmethod
    def shot(cls, unknown, down, stretch, shear, points):
        """What is missing at the far end, and from the way `down` of the load, with the reactions, angle at the foot and load `unknown`."""
        across, up, angle, load = unknown * [1e4, 1e4, 1.0, 1e4]

        def member(y, force, length, steps):
            def rates(y):
                c, s = np.cos(y[2]), np.sin(y[2])
                along, aside = 1 + stretch * (force[0] * c + force[1] * s), shear * (force[1] * c - force[0] * s)
                dx, dy = along * c - aside * s, along * s + aside * c
                return np.array([dx, dy, y[3] / (cls.YOUNG * cls.SECOND_MOMENT), dy * force[0] - dx * force[1]])
            return solved(rates, y, length, steps)[0]

        corner = member(np.array([0.0, 0.0, angle, 0.0]), (-across, -up), cls.LENGTH, points) - [0.0, 0.0, np.pi / 2, 0.0]
        under = member(corner, (-across, -up), cls.LENGTH / 5, points // 4)
        end = member(under, (-across, load - up), 0.8 * cls.LENGTH, points)
        return np.array([end[0] - cls.LENGTH, end[1] - cls.LENGTH, end[3] / (cls.YOUNG * cls.SECOND_MOMENT), cls.LENGTH - under[1] - down])

    @classmethod
    def limit(cls, stretch=0.0, shear=0.0, points=20):
        """The limit load by shooting and Newton's method at ways of the load; stretch and shear: compliances, 1/N."""
        unknown, loads, ways = np.array([0.01, 0.01, np.pi / 2, 0.01]), [], [*np.linspace(0.03, 0.45, 8), *np.linspace(0.47, 0.51, 5)]
        for down in ways:
            missing = cls.shot(unknown, down, stretch, shear, points)
            while np.abs(missing).max() > 1e-9:
                slope = [(cls.shot(unknown + 1e-6 * e, down, stretch, shear, points) - missing) / 1e-6 for e in np.eye(4)]
                unknown = unknown - np.linalg.solve(np.transpose(slope), missing)
                missing = cls.shot(unknown, down, stretch, shear, points)
            loads.append(1e4 * unknown[3])
        near = np.polyfit(np.array(ways[-5:]) - 0.49, loads[-5:], 4)
        return np.polyval(near, np.linspace(-0.02, 0.02, 401)).max()


class Linkages(unittest.TestCase):
    def assert_tenth(self, name, softer, stiffer, most):
        """Ten times k leaves a tenth; the next term of the series in 1/k is of 2 % in what is measured here."""
        print(f"{name}: {softer:.3e}, with ten times k {stiffer:.3e}")
        self.assertAlmostEqual(stiffer / softer, 0.1, delta=0.004, msg=name)
        self.assertLess(stiffer, most, name)

    def test_double_pendulum_is_of_second_order_in_the_step(self):
        k, duration, start = 1e4, 0.6, np.array([*0.5 * Pendulum.ELBOW, 0.0, *0.5 * (Pendulum.ELBOW + Pendulum.END), Pendulum.BENT, *[0.0] * 6])
        truth = solved(Pendulum.compliant(k), start, duration, 6000)[0][[0, 1, 3, 4]]
        off = [np.abs(samples(Pendulum.scene(k, dt, duration), 1, place("upper", "lower"))[0][0] - truth).max() for dt in (2e-4, 1e-4, 5e-5)]
        print("double pendulum from its differential equation, halved steps:", *(f"{error:.3e}" for error in off), "m")
        for coarse, fine in zip(off, off[1:]): self.assertAlmostEqual(coarse / fine, 4.0, delta=0.1)  # 3.99 and 4.00 measured
        self.assertLess(off[-1], 1e-7)  # m: 2.1e-8 measured, where the springs stretch by 6e-3

    def test_double_pendulum_tends_to_the_rigid_one(self):
        truth = Pendulum.centres(solved(Pendulum.rigid, np.array([0.0, Pendulum.BENT, 0.0, 0.0]), 0.6, 3000, 100))
        off = []
        for k, dt in ((1e5, 1.2e-5), (1e6, 4e-6), (1e7, 1.2e-6)):
            places, = samples(Pendulum.scene(k, dt, 0.6), 100, place("upper", "lower"))
            off.append(np.sqrt(np.mean((places - truth)**2)))
        self.assert_tenth("double pendulum from the rigid one, m", off[0], off[1], 1e-4)
        self.assert_tenth("the same", off[1], off[2], 1e-5)  # 4.0e-6 measured

    def test_four_bar_linkage(self):
        off, gaps = [], []
        for k, dt in ((1e6, 5e-6), (1e7, 2e-6)):
            crank, rocker, wide = samples(FourBar.scene(k, dt), 100, turn("crank"), turn("rocker"), gap)
            self.assertGreater(np.ptp(rocker), 0.89)  # rad: the rocker's whole way in one turn of the crank
            off.append(np.abs(rocker - FourBar.rocker(crank)).max())
            gaps.append(wide.max())
        self.assert_tenth("four-bar linkage, rad", *off, 2e-4)  # 1.1e-4 measured
        self.assert_tenth("four-bar linkage, joint_gap, m", *gaps, 2e-5)  # 8.2e-6 measured

    def test_slider_crank(self):
        off, gaps, sizes = [], [], (0.1, 0.3)
        for k, dt in ((1e6, 5e-6), (1e7, 2e-6)):
            crank, found, wide = samples(slider_crank(k, dt, *sizes, 0.7), 100, turn("crank"), place("piston"), gap)
            self.assertGreater(np.ptp(found[:, 0]), 0.199)  # m: the piston's whole way
            off.append(np.abs(found[:, 0] - piston(*sizes, 0.7 + crank)).max())
            gaps.append(wide.max())
        self.assert_tenth("slider-crank, m", *off, 5e-5)  # 2.6e-5 measured
        self.assert_tenth("slider-crank, joint_gap, m", *gaps, 2e-5)  # 1.1e-5 measured

    def test_universal_joint(self):
        """The first axis stands across the plane of the shafts at the start, so tan(q2) = cos(between) tan(q1)."""
        off, between = [], 0.6
        for k, dt in ((1e5, 5e-5), (1e6, 2e-5), (1e7, 5e-6)):
            tables, axis = shafts(k, dt, between)
            first, second = samples(tables, 100, turn("drive"), turn("driven", axis))
            self.assertGreater(np.abs(within_a_turn(second - first)).max(), 0.095)  # rad: the joint turns unevenly
            off.append(np.abs(within_a_turn(second - np.arctan2(np.cos(between) * np.sin(first), np.cos(first)))).max())
        self.assert_tenth("universal joint, rad", *off[:2], 1e-3)
        self.assert_tenth("the same", *off[1:], 1e-4)  # 3.3e-5 measured

    def test_momenta_of_a_free_chain(self):
        with opened(chain(5e-4, 2000)) as run:
            before = run.observables
            names = [[f"{kind}_{axis}[{unit}]" for axis in "xyz"] for kind, unit in (("momentum", "kg m/s"), ("angular_momentum", "kg m^2/s"))]
            most = [0.0, 0.0]
            while not run.finished:
                now = run.step(20).observables
                for i, three in enumerate(names):
                    size = np.linalg.norm([before[name] for name in three])
                    most[i] = max(most[i], np.linalg.norm([now[name] - before[name] for name in three]) / size)
        print(f"free chain, drift of momentum and angular momentum over their size: {most[0]:.1e}, {most[1]:.1e}")
        self.assertGreater(now["joint_gap[m]"], 1e-3)  # the joints pull: 4e-3 m measured
        self.assertLess(max(most), 1e-13)  # rounding of 2000 steps: 5e-15 measured, 1e-12 asked for

    def test_energy_of_many_steps(self):
        """An undamped pendulum with springs in its hinges keeps its energy at half the limit of the step."""
        with opened(Pendulum.scene(1e5, 2e-4, 2e-4 * STEPS, spring=3.0)) as run:
            def total(): return energy(run) + GRAVITY * (Pendulum.UPPER * run["upper"].position[0, 0, 1] + Pendulum.LOWER * run["lower"].position[0, 0, 1])

            first, found = total(), []
            while not run.finished: found.append((run.step(50).steps_done, (total() - first) / Pendulum.DROP))
        steps, off = np.transpose(found)
        slope = np.polyfit(steps[len(steps) // 2:], off[len(steps) // 2:], 1)[0]
        print(f"energy of the double pendulum over {STEPS} steps, off by {np.abs(off).max():.1e} of its scale, slope {slope:.1e} a step")
        self.assertGreater(np.abs(off).max(), 1e-9)  # it moves
        self.assertLess(np.abs(off).max(), 1e-4)  # 3.2e-7 and 4.6e-6 measured over 1e5 and 1e6 steps, while vibrations of the hinges grow; 1e-3 asked for
        self.assertLess(abs(slope), 1e-10)  # 9e-13 and -1.3e-12 measured over 1e5 and 1e6 steps; 1e-9 asked for

    def test_books(self):
        """Work of a motor and loss of a dashpot close the balance of energy to second order, from the first row to the last."""
        def off(dt, **keys):
            joint = {"kind": "hinge", "between": ["wheel", "world"], "place": [0.0, 0.0, 0.0], "axis": [0.0, 1.0, 0.0], "stiffness": 1e6, "torsional_stiffness": 1e4, **keys}
            wheel = {"name": "wheel", "mass": 1.0, "inertia": [0.02, 0.02, 0.02], "spheres": {"radii": [0.05]}, "angular_velocity": [0.0, 10.0, 0.0]}
            with skein.Simulation(skein.Scene("wheel", time={"duration": 0.1, "dt": dt}, bodies=[wheel], joint=[joint]), threads=1) as run:
                start, o = 0.5 * 0.02 * 100.0, run.step(run.steps).observables
                return o["kinetic_translation[J]"] + o["kinetic_rotation[J]"] + o["joint_energy[J]"] - start - o["joint_motor_work[J]"] + o["joint_loss[J]"]

        for keys in ({"motor": {"kind": "force", "value": "2.0 + 10*t"}}, {"axis_damping": 0.1}, {"motor": {"kind": "position", "value": "3*t", "stiffness": 5.0, "damping": 0.01}}):
            errors = np.array([off(dt, **keys) for dt in (4e-5, 2e-5, 1e-5)])
            print(f"books of {keys}: off by {errors} J of 1 J")
            self.assertLess(abs(errors[-1]), 1e-6)
            if abs(errors[0]) > 1e-10: self.assertGreater(errors[0] / errors[1], 3.5)

    def test_arm_of_four_links(self):
        """Fixed joints at one node make four links the rod in one piece. tests/validation/joined_rods.cpp compares two pieces under other loads."""
        counts = (8, 16, 32)
        whole, links = (np.array([arm(pieces, n) for n in counts]) for pieces in (1, 4))
        limit = whole[2] + (whole[2] - whole[1]) / 3
        for n, one, four in zip(counts, whole, links):
            own, off = np.linalg.norm(one - limit), np.linalg.norm(four - one)
            print(f"arm of {n} elements: tip {one[2]:.7f} m, off by {own:.1e} m; four links from one: {off:.1e} m")
            self.assertLess(off, 1e-9)  # m: rounding of 1e-15 measured
            self.assertLess(off, 0.01 * own)  # 1 % of the error in space asked for
        first, second = np.linalg.norm(links[0] - links[1]), np.linalg.norm(links[1] - links[2])
        self.assertAlmostEqual(np.log2(first / second), 2.0, delta=0.05)  # 2.00 measured

    TEAR = 0.02

    def torn(self, pull):
        """Force at the tip, which rises by `pull` N/s, when two links in one piece with a clamped foot tear."""
        def group(name, at, **keys):
            return {"name": name, "material": {"density": 1000.0, "youngs_modulus": 1e6, "law": "linear"}, "section": {"radius": 0.05}, "shape": {"length": 0.5, "elements": 8},
                    "placement": {"origin": [at, 0.0, 0.0], "tangent": [1.0, 0.0, 0.0]}, **keys}

        tables = {"time": {"duration": 1.3 * self.TEAR * 1e6 * np.pi * 0.05**2 / pull}, "damping": [{"kind": "uniform", "rate": 20.0}], "rods": [group("foot", 0.0, start="clamped"), group("tip", 0.5)],
                  "joint": [{"kind": "fixed", "between": ["foot", "tip"], "break_strain": self.TEAR}], "load": [{"kind": "formula", "at": "end", "rods": ["tip"], "force": [f"{pull}*t", "0", "0"]}]}
        with opened(tables) as run:
            while (run["tip"].position[0, 0] == run["foot"].position[0, -1]).all(): run.step(1)
            return pull * run.time

    def test_two_links_tear_at_their_strain(self):
        """Drawn slowly, they tear where the force is EA times that strain; the inertia of the tip adds a force that falls with the pull."""
        strength = self.TEAR * 1e6 * np.pi * 0.05**2
        off = np.array([self.torn(pull) / strength - 1 for pull in (80.0, 40.0, 20.0)])
        print(f"two links tear at a force that is off from EA times the strain, {strength:.1f} N, by {off} of it")
        self.assertLess(abs(off[-1]), 2e-3)  # 1.2e-3 measured
        self.assertLess(abs(2 * off[-1] - off[-2]), 2e-4)  # 3e-5 measured: the limit of slow motion

    def test_tearing_keeps_momenta_and_books_energy(self):
        """Two links that fly, spin and bend tear: momenta stay, and the balance of energy closes to second order."""
        def links(name, at, spin):
            speeds = {"velocity": [0.0, 0.0, 0.3], "angular_velocity": spin}
            return {"name": name, "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 0.02}, "shape": {"length": 0.5, "elements": 8, **speeds},
                    "placement": {"origin": [at, 0.0, 0.0], "tangent": [1.0, 0.0, 0.0]}}

        defects, losses = [], []
        for strain, dt in ((1e9, 5e-5), (self.TEAR, 5e-5), (self.TEAR, 2.5e-5), (self.TEAR, 1.25e-5)):
            joint = {"kind": "fixed", "between": ["one", "two"], "break_strain": strain}
            rods = [links("one", 0.0, [0.0, 12.0, 0.0]), links("two", 0.5, [0.0, 12.0, 4.0])]
            tables = {"time": {"duration": 0.2, "dt": dt}, "rods": rods, "joint": [joint], "output": {"observables": ["angular_momentum"], "audit": True}}
            with opened(tables) as run:
                run.step(1)
                before, after = run.observables, run.step(run.steps).observables
                apart = np.linalg.norm(run["two"].position[0, 0] - run["one"].position[0, -1])
            for name in before:
                if "momentum" in name: self.assertAlmostEqual(before[name], after[name], delta=1e-14, msg=name)  # of 0.38 kg m/s and 0.14 kg m^2/s; 2e-15 measured
            if strain == self.TEAR:
                defects.append(after["energy_defect[J]"])
                self.assertGreater(apart, 0.1)
                losses.append(after["joint_loss[J]"])
            else: self.assertEqual((apart, after["joint_loss[J]"]), (0.0, 0.0))
        print(f"torn links are {apart:.3f} m apart and have lost {losses} J; energy defects {defects} J")
        for coarse, fine in zip(defects, defects[1:]): self.assertAlmostEqual(np.log2(coarse / fine), 2.0, delta=0.1)
        for loss in losses[:-1]: self.assertAlmostEqual(loss, losses[-1], delta=0.01 * losses[-1])

    def test_lees_frame(self):
        shear = 1 / (27 / 28 * LeesFrame.YOUNG / 3 * LeesFrame.AREA)
        rigid, truth = LeesFrame.limit(), LeesFrame.limit(1 / (LeesFrame.YOUNG * LeesFrame.AREA), shear)
        (coarse, _), (fine, gaps) = (LeesFrame.found(n) for n in (2, 4))
        limit = fine + (fine - coarse) / 3
        print(f"Lee's frame, limit load: {coarse:.1f} and {fine:.1f} N with 10 and 20 elements a side, tends to {limit:.1f} N; by shooting {truth:.1f} N, "
              f"{rigid:.1f} N of the elastica; joint_gap {gaps:.1e} m")
        self.assertAlmostEqual(rigid, LeesFrame.PUBLISHED, delta=5e-4 * LeesFrame.PUBLISHED)  # four digits, 2e-4 measured
        self.assertAlmostEqual(np.log2((truth - coarse) / (truth - fine)), 2.0, delta=0.15)  # 2.05 measured: damping adds 2e-4 at this speed
        self.assertAlmostEqual(limit, truth, delta=5e-4 * truth)  # 1e-4 measured
        self.assertLess(gaps, 2e-4)  # m: 1.45e4 N over k


def rotation(v):
    """The matrix that turns by a rotation vector."""
    angle = np.linalg.norm(v)
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(0.5 * angle / np.pi)**2 * cross @ cross


def rotation_vector(r):
    sine = 0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    angle = np.arctan2(np.linalg.norm(sine), 0.5 * (np.trace(r) - 1))
    return sine / np.sinc(angle / np.pi)


def attitude(name="bob"):
    """The matrix that has turned a body since the start."""
    return lambda run, start: run[name].directors[0, 0].T @ start[name]


def on_the_spot(joint, duration, dt, inertia=(0.02, 0.03, 0.04), spin=(3.0, 1.0, 2.0), **tables):
    """A body that turns about its centre, where it is joined to the world, so that the spring between the points is at rest."""
    body = {"name": "bob", "mass": 1.0, "inertia": list(inertia), "spheres": {"radii": [0.05]}, "placement": {"origin": [0.0, 0.0, 0.0]}, "angular_velocity": list(spin)}
    return scene([body], [{"between": ["bob", "world"], "place": [0.0, 0.0, 0.0], "stiffness": 1e4, **joint}], duration, dt, **tables)


def turning(couple, duration, inertia=(0.02, 0.03, 0.04), spin=(3.0, 1.0, 2.0), steps=4000):
    """The attitude of a body under couple(t, attitude, spin), all in lab axes; d1, d2 and d3 are at x, y and z at the start."""
    def rates(y):
        r, w = y[1:10].reshape(3, 3), y[10:]
        about = r @ np.diag(inertia) @ r.T
        return np.concatenate([[1.0], (np.cross(w, r.T).T).ravel(), np.linalg.solve(about, couple(y[0], r, w) - np.cross(w, about @ w))])

    return solved(rates, np.concatenate([[0.0], np.eye(3).ravel(), spin]), duration, steps)[0][1:10].reshape(3, 3)


class FreeAxes(unittest.TestCase):
    SPRING, DASHPOT = {"spring": 3.0, "axis_damping": 0.02}, 0.02
    # Keys of a spherical joint to the world, and the couple on the body.
    BALLS = {
        "spring and dashpot": (SPRING, lambda t, r, w: -3.0 * rotation_vector(r) - 0.02 * w),
        "position": ({"motor": {"kind": "position", "values": ["0.5*sin(10*t)", "1.5*t", "0.2*sin(7*t)"], "stiffness": 5.0, "damping": 0.05}},
                     lambda t, r, w: FreeAxes.led(t, r, w)),
        "rate": ({"motor": {"kind": "rate", "values": ["5*t", "2", "-3*t"], "damping": 0.05}}, lambda t, r, w: 0.05 * (np.array([5 * t, 2.0, -3 * t]) - w)),
        "force": ({"motor": {"kind": "force", "values": ["0.1*sin(20*t)", "0.05", "-0.2*t"]}}, lambda t, r, w: np.array([0.1 * np.sin(20 * t), 0.05, -0.2 * t])),
    }

    @staticmethod
    def led(t, r, w):
        def target(at): return rotation(np.array([0.5 * np.sin(10 * at), 1.5 * at, 0.2 * np.sin(7 * at)]))

        h = 1e-5
        rate = rotation_vector(target(t + h) @ target(t - h).T) / (2 * h)
        return -5.0 * rotation_vector(r @ target(t).T) + 0.05 * (rate - w)

    def off(self, joint, duration, dt, truth):
        found, = samples(on_the_spot(joint, duration, dt), 1, attitude())
        return np.linalg.norm(rotation_vector(found[0] @ truth.T))

    def test_spherical_joints_are_of_second_order(self):
        """Springs, dashpots and motors turn a body of three moments of inertia as the differential equation says."""
        for name, (keys, couple) in self.BALLS.items():
            truth = turning(couple, 0.5)
            off = [self.off({"kind": "spherical", **keys}, 0.5, dt, truth) for dt in (2e-3, 1e-3, 5e-4)]
            print(f"spherical joint, {name}: off by", *(f"{error:.3e}" for error in off), "rad")
            with self.subTest(name):
                for coarse, fine in zip(off, off[1:]): self.assertAlmostEqual(coarse / fine, 4.0, delta=0.3)
                self.assertLess(off[-1], 1e-4)

    def test_stops_of_a_spherical_joint(self):
        """A ball with three equal moments of inertia strikes the cone, or the limit of its twist, and comes back as from a spring."""
        about, speed, stiffness = 0.02, 4.0, 50.0
        contact = np.pi * np.sqrt(about / stiffness)
        for name, axis, spin, limit in (("cone", [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], 0.4), ("twist", [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], 0.3), ("twist back", [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], 0.2)):
            stop = {"kind": "spherical", "axis": axis, "cone": 0.4, "limits": [-0.2, 0.3], "stop_stiffness": stiffness}
            tables = on_the_spot(stop, limit / speed + contact + 0.05, 1e-5, (about,) * 3, speed * np.array(spin))
            found, times = samples(tables, 20, lambda run, start: np.dot(spin, rotation_vector(attitude()(run, start))), lambda run, start: run.time)
            back = 2 * limit - speed * (times[-1] - contact)
            print(f"stop of a spherical joint, {name}: back at {found[-1]:.8f} rad, by the closed form {back:.8f} rad")
            with self.subTest(name):
                self.assertAlmostEqual(found[-1], back, delta=1e-6)
                self.assertLess(found.max(), limit + speed * np.sqrt(about / stiffness) + 1e-6)
                self.assertGreater(found.max(), limit + 0.5 * speed * np.sqrt(about / stiffness))

    def test_friction_of_a_spherical_joint(self):
        """Friction brings a ball to rest on the way of constant deceleration, whatever the axis, and holds it against a couple below its own."""
        about, speed, couple = 0.02, 9.0, 1.0
        axis = np.array([1.0, 2.0, 2.0]) / 3
        joint = {"kind": "spherical", "friction": couple, "friction_stiffness": 5e3, "friction_damping": 10.0,
                 "motor": {"kind": "force", "values": [f"if(t < 0.5, 0, {0.4 * c})" for c in (0.0, 1.0, -1.0)]}}
        placed, loss, work = samples(on_the_spot(joint, 1.5, 2e-5, (about,) * 3, speed * axis), 150, attitude(),
                                     lambda run, start: run.observables["joint_loss[J]"], lambda run, start: run.observables["joint_motor_work[J]"])
        way = 0.5 * about * speed**2 / couple
        turned, gives, creep = (rotation_vector(placed[i] @ placed[j].T) for i, j in ((45, 0), (-1, 45), (-1, 80)))
        turned = turned + rotation_vector(placed[0])  # about one axis
        np.testing.assert_allclose(turned, way * axis, atol=1e-3 * way)
        self.assertAlmostEqual(loss[45], 0.5 * about * speed**2, delta=1e-4)
        print(f"friction of a spherical joint: stops after {np.linalg.norm(turned):.6f} rad of {way:.6f}; gives way by {np.linalg.norm(gives):.4e} rad under a couple, then creeps by {np.abs(creep).max():.1e} rad")
        np.testing.assert_allclose(gives, np.array([0.0, 0.4, -0.4]) / 5e3, atol=1e-9)
        self.assertLess(np.abs(creep).max(), 1e-12)
        self.assertGreater(work[-1], 0.0)

    def test_universal_joint_with_laws(self):
        """Both axes as a hinge's: the body's angles follow Lagrange's equations, to second order in the step, up to a share of 1/torsional_stiffness."""
        first, second, (a, b, c) = (2.0, 0.01), (3.0, 0.02), (0.02, 0.03, 0.04)

        def rates(y):
            t, beta, alpha, u, v = y  # about the first axis, y, which the body carries, and about x of the world
            about, slope = a * np.cos(beta)**2 + c * np.sin(beta)**2, 2 * (c - a) * np.sin(beta) * np.cos(beta)
            motor = 4.0 * (0.5 * np.sin(10 * t) - alpha) + 0.03 * (5 * np.cos(10 * t) - v)
            return np.array([1.0, u, v, (0.5 * slope * v * v - first[0] * (beta - 0.1) - first[1] * u) / b,
                             (-slope * u * v - second[0] * alpha - second[1] * v + motor) / about])

        truth = solved(rates, np.array([0.0, 0.0, 0.0, 3.0, 2.0]), 0.5, 4000)[0][1:3]

        def angles(run, start):
            r = attitude()(run, start)
            return np.array([np.arctan2(r[0, 2], r[0, 0]), np.arctan2(r[2, 1], r[1, 1])])

        def found(turning, dt):
            joint = {"kind": "universal", "axis": [0.0, 1.0, 0.0], "second_axis": [1.0, 0.0, 0.0], "torsional_stiffness": turning, "spring": first[0], "spring_rest": 0.1,
                     "axis_damping": first[1], "about_second": {"spring": second[0], "axis_damping": second[1],
                                                                "motor": {"kind": "position", "value": "0.5*sin(10*t)", "stiffness": 4.0, "damping": 0.03}}}
            return samples(on_the_spot(joint, 0.5, dt, (a, b, c), (2.0, 3.0, 0.0)), 1, angles)[0][0]

        soft = [found(100.0, dt) for dt in (4e-4, 2e-4, 1e-4)]
        order = np.log2(np.linalg.norm(soft[0] - soft[1]) / np.linalg.norm(soft[1] - soft[2]))
        off = [np.abs(found(k, dt) - truth).max() for k, dt in ((1e3, 5e-5), (1e4, 2e-5))]
        print(f"universal joint with springs, dashpots and a motor: order {order:.3f}; off by {off[0]:.2e} rad, with ten times k {off[1]:.2e} rad")
        self.assertAlmostEqual(order, 2.0, delta=0.1)
        self.assertAlmostEqual(off[1] / off[0], 0.1, delta=0.02)

    def test_energy_and_momenta(self):
        """Of two bodies that tumble, with springs and stops of all axes: the energy swings by the square of the step, and momenta stay."""
        stops = {"limits": [-0.3, 0.25], "stop_stiffness": 20.0}
        joints = ({"kind": "universal", "axis": [0.0, 1.0, 0.0], "second_axis": [0.0, 0.0, 1.0], "torsional_stiffness": 5.0, "spring": 2.0, "about_second": {"spring": 1.0, **stops}},
                  {"kind": "spherical", "axis": [0.6, 0.0, 0.8], "cone": 0.3, "spring": 0.5, **stops})
        for joint in joints:
            swing = []
            for dt in (4e-5, 2e-5):
                bodies = [{"name": name, "mass": 1.0, "inertia": [0.02, 0.015, 0.01], "spheres": {"radii": [0.02]}, "placement": {"origin": [0.3 * i, 0.0, 0.0]}, "angular_velocity": spin}
                          for i, (name, spin) in enumerate((("one", [3.0, 1.0, 2.0]), ("two", [-1.0, 2.0, 0.5])))]
                tables = scene(bodies, [{"between": ["one", "two"], "place": [0.15, 0.0, 0.1], "stiffness": 1e3, **joint}], 1.0, dt, output={"observables": ["angular_momentum"]})
                with opened(tables) as run:
                    before, found = run.observables, [energy(run)]
                    while not run.finished: found.append(energy(run.step(100)))
                    after = run.observables
                for name in before:
                    if "momentum" in name: self.assertAlmostEqual(before[name], after[name], delta=2e-13, msg=name)
                swing.append(np.ptp(found) / found[0])
            print(f"energy with a {joint['kind']} joint of springs and stops swings by {swing[0]:.2e} and {swing[1]:.2e} of itself")
            with self.subTest(joint["kind"]):
                self.assertLess(swing[1], 1e-5)
                self.assertAlmostEqual(swing[0] / swing[1], 4.0, delta=0.6)

    def test_books_of_free_axes(self):
        """Works of motors and losses of dashpots close the balance of energy to second order."""
        def off(joint, dt):
            with opened(on_the_spot(joint, 0.3, dt, spin=(3.0, 2.0, 0.0))) as run:
                start, o = energy(run), run.step(run.steps).observables
                return energy(run) - start - o["joint_motor_work[J]"] + o["joint_loss[J]"]

        motor = {"kind": "position", "stiffness": 5.0, "damping": 0.05}
        joints = {"spherical": {"kind": "spherical", "spring": 1.0, "axis_damping": 0.02, "motor": motor | {"values": ["2*t", "sin(9*t)", "-1*t"]}},
                  "universal": {"kind": "universal", "axis": [0.0, 1.0, 0.0], "second_axis": [1.0, 0.0, 0.0], "torsional_stiffness": 50.0, "axis_damping": 0.02, "motor": motor | {"value": "2*t"},
                                "about_second": {"spring": 1.0, "axis_damping": 0.01, "motor": {"kind": "rate", "value": "-4*t", "damping": 0.1}}}}
        for name, joint in joints.items():
            errors = np.array([off(joint, dt) for dt in (4e-4, 2e-4, 1e-4)])
            print(f"books of a {name} joint: off by {errors} J")
            with self.subTest(name):
                self.assertLess(abs(errors[-1]), 1e-4)
                for coarse, fine in zip(errors, errors[1:]): self.assertAlmostEqual(coarse / fine, 4.0, delta=0.6)

    def test_hinges_count_whole_turns(self):
        """A wheel on a spring swings two turns each way; stops lie beyond a turn; and a motor winds up to its value."""
        about, spring, most = 0.02, 0.5, 4 * np.pi
        rate = np.sqrt(spring / about)
        wheel = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "torsional_stiffness": 10.0}

        def end(joint, duration, dt, spin):
            with opened(on_the_spot(wheel | joint, duration, dt, (about,) * 3, [0.0, spin, 0.0])) as run:
                angle, last, figure, start = 0.0, 0.0, turn("bob", (0, 1, 0)), {"bob": run["bob"].directors[0, 0].copy()}
                while not run.finished:
                    now = figure(run.step(run.steps // 200), start)
                    angle, last = angle + within_a_turn(now - last), now
                return angle

        off = [abs(end({"spring": spring}, 2.0, dt, most * rate) - most * np.sin(2.0 * rate)) for dt in (1e-3, 5e-4)]
        print(f"a wheel on a spring, two turns each way: off by {off[0]:.2e} and {off[1]:.2e} rad")
        self.assertAlmostEqual(off[0] / off[1], 4.0, delta=0.3)
        stopped = end({"limits": [-1.0, 10.0], "stop_stiffness": 50.0}, 1.2 + np.pi * np.sqrt(about / 50.0), 1e-5, 10.0)
        self.assertAlmostEqual(stopped, 8.0, delta=1e-4)
        wound = end({"motor": {"kind": "position", "value": "6*pi", "stiffness": 0.5, "damping": 0.2}}, 4.0, 1e-3, 0.0)
        self.assertAlmostEqual(wound, 6 * np.pi, delta=1e-3)

    def test_columns_of_a_joint(self):
        """A bob at rest on a named joint: its weight, and that over the stiffness."""
        joint = {"kind": "spherical", "name": "hook", "damping": 100.0}
        with opened(on_the_spot(joint, 2.0, 1e-4, spin=(0.0, 0.0, 0.0), load=WEIGHT)) as run:
            o = run.step(run.steps).observables
        self.assertAlmostEqual(o["hook_force[N]"], GRAVITY, delta=1e-9)
        self.assertAlmostEqual(o["hook_gap[m]"], GRAVITY / 1e4, delta=1e-12)

    def test_a_stage_ends_by_a_joint(self):
        """A bob falls into a spring, whose force is its weight times 1 - cos(100 t) by itself."""
        stages = [{"name": "fall", "until": "hook_force > 5", "check_every": 1e-4}, {"name": "rest"}]
        with opened(on_the_spot({"kind": "spherical", "name": "hook"}, 0.05, 1e-5, spin=(0.0, 0.0, 0.0), load=WEIGHT, stage=stages)) as run:
            while run.stage == "fall": run.step(1)
            self.assertAlmostEqual(run.time, np.arccos(1 - 5 / GRAVITY) / 100, delta=1.3e-4)


if __name__ == "__main__":
    unittest.main()
