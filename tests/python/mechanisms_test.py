"""Joints with free axes on bodies and rods: orders in the step against ordinary differential equations, momenta, energies, stops, friction, motors driven in a loop."""

import unittest

import numpy as np

from package import skein

GRAVITY, MASS, ARM, ABOUT_Y = 9.81, 1.0, 0.3, 0.02
INERTIA = ABOUT_Y + MASS * ARM**2
HINGE = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "stiffness": 1e6, "torsional_stiffness": 1e4}
SLOPE = np.array([0.6, 0.0, -0.8])
SLIDER = {"kind": "slider", "axis": list(SLOPE), "stiffness": 1e6, "torsional_stiffness": 1e4}
FLYING = {"angular_velocity": [3.0, 1.0, 2.0], "velocity": [0.1, 0.2, 0.3]}


def scene(joint, duration=0.2, dt=1e-5, gravity=True, bob=(), **tables):
    """A bob beside the origin, joined to the world there."""
    body = {"name": "bob", "mass": MASS, "inertia": [0.01, ABOUT_Y, 0.03], "spheres": {"radii": [0.05]}, "placement": {"origin": [ARM, 0.0, 0.0]}, **dict(bob)}
    return {"time": {"duration": duration, "dt": dt}, "bodies": [body], "joint": [{"between": ["bob", "world"], "place": [0.0, 0.0, 0.0], **joint}],
            "load": [{"kind": "gravity"}] if gravity else [], **tables}


def mates(joint, **keys):
    """Two bodies in free flight."""
    both = scene(joint | {"between": ["bob", "mate"]}, gravity=False, bob=FLYING, **keys)
    if joint["kind"] == "distance": del both["joint"][0]["place"]
    both["bodies"].append({"name": "mate", "mass": 2.0, "inertia": [0.02, 0.01, 0.03], "spheres": {"radii": [0.05]}, "placement": {"origin": [0.0, 0.0, 0.1]},
                           "angular_velocity": [-1.0, 2.0, 0.0]})
    return both


def opened(tables):
    return skein.Simulation(skein.Scene("mechanism", **tables), threads=1)


def angle(place):
    return np.arctan2(-place[2], place[0])


def energy(run):
    o = run.observables
    return o["kinetic_translation[J]"] + o["kinetic_rotation[J]"] + o["joint_energy[J]"]


def solved(acceleration, end, steps=20000):
    """Runge and Kutta's fourth order, from rest at 0."""
    h, y = end / steps, np.zeros(2)

    def rates(t, y):
        return np.array([y[1], acceleration(t, *y)])

    for i in range(steps):
        a = rates(i * h, y)
        b = rates((i + 0.5) * h, y + 0.5 * h * a)
        c = rates((i + 0.5) * h, y + 0.5 * h * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rates((i + 1) * h, y + h * c))
    return y[0]


def weight(q):
    return MASS * GRAVITY * ARM * np.cos(q)


# Keys of the axis, and the couple about a hinge or force along a slider that they make at (t, q, rate).
AXES = {
    "free": ({}, lambda t, q, u: 0.0),
    "spring": ({"spring": 50.0, "spring_rest": 0.02}, lambda t, q, u: -50 * (q - 0.02)),
    "dashpot": ({"axis_damping": 0.5}, lambda t, q, u: -0.5 * u),
    "force": ({"motor": {"kind": "force", "value": "2*sin(20*t)"}}, lambda t, q, u: 2 * np.sin(20 * t)),
    "position": ({"motor": {"kind": "position", "value": "0.5*sin(10*t)", "stiffness": 300.0, "damping": 3.0}},
                 lambda t, q, u: 300 * (0.5 * np.sin(10 * t) - q) + 3 * (5 * np.cos(10 * t) - u)),
    "rate": ({"motor": {"kind": "rate", "value": "5*t", "damping": 3.0, "most": 4.0}}, lambda t, q, u: np.clip(3 * (5 * t - u), -4, 4)),
}


class Mechanisms(unittest.TestCase):
    def orders(self, joint, where, acceleration):
        """Order of the end in the step, of a softer joint; and the distance from the equation, which falls as 1/stiffness."""
        def end(dt, times):
            changed = {key: times * value if key in ("stiffness", "torsional_stiffness") else value for key, value in joint.items()}
            with opened(scene(changed, dt=dt)) as run:
                return where(run.step(run.steps)["bob"].position[0, 0])

        ends = [end(dt, 0.1) for dt in (4e-5, 2e-5, 1e-5)]
        truth = solved(acceleration, 0.2)
        first, second = abs(ends[0] - ends[1]), abs(ends[1] - ends[2])
        return np.log2(first / second) if first > 1e-10 else None, abs(end(1e-5, 1) - truth), abs(end(5e-6, 10) - truth)

    def assert_orders(self, order, off, stiffer):
        """Where nothing but rounding is left there is no order."""
        if order is not None: self.assertAlmostEqual(order, 2.0, delta=0.15)
        self.assertLess(off, 1e-3)
        self.assertLess(stiffer, 0.15 * off + 1e-6)

    def test_hinge_on_the_world(self):
        for name, (keys, couple) in AXES.items():
            with self.subTest(name):
                order, off, stiffer = self.orders(HINGE | keys, angle, lambda t, q, u: (weight(q) + couple(t, q, u)) / INERTIA)
                self.assert_orders(order, off, stiffer)
                self.assertIsNotNone(order)

    def test_slider_on_the_world(self):
        for name, (keys, force) in AXES.items():
            with self.subTest(name):
                order, off, stiffer = self.orders(SLIDER | keys, lambda x: (x - [ARM, 0, 0]) @ SLOPE, lambda t, q, u: (0.8 * MASS * GRAVITY + force(t, q, u)) / MASS)
                self.assert_orders(order, off, stiffer)
                if name != "free": self.assertIsNotNone(order)

    def test_rope_pendulum(self):
        """A bob on a stiff rope swings as a point on a circle, and flies where the rope is loose."""
        rope = {"kind": "distance", "stiffness": 1e6, "rope": True}
        with opened(scene(rope)) as run:
            swung = angle(run.step(run.steps)["bob"].position[0, 0])
            gap = run.observables["joint_gap[m]"]
        self.assertAlmostEqual(swung, solved(lambda t, q, u: GRAVITY / ARM * np.cos(q), 0.2), delta=1e-4)
        self.assertTrue(0 < gap < 1e-4)
        with opened(scene(rope | {"length": 2.0})) as run:
            np.testing.assert_allclose(run.step(run.steps)["bob"].position[0, 0], [ARM, 0, -0.5 * GRAVITY * 0.04], rtol=1e-3)

    def test_energy_is_of_second_order(self):
        """Soft joints of a body that tumbles: the energy swings by an amount that falls as the square of the step."""
        for joint in (HINGE | {"stiffness": 1e4, "torsional_stiffness": 5.0, "spring": 20.0}, SLIDER | {"stiffness": 1e4, "torsional_stiffness": 5.0, "spring": 10.0},
                      {"kind": "universal", "axis": [0.0, 1.0, 0.0], "second_axis": [0.0, 0.0, 1.0], "stiffness": 1e4, "torsional_stiffness": 5.0}, {"kind": "distance", "stiffness": 1e4}):
            swing = []
            for dt in (4e-5, 2e-5):
                with opened(scene(joint, dt=dt, duration=0.5, gravity=False, bob=FLYING)) as run:
                    found = [energy(run.step(50)) for _ in range(run.steps // 50)]
                swing.append((max(found) - min(found)) / np.mean(found))
            with self.subTest(joint["kind"]):
                self.assertLess(swing[1], 5e-6)
                self.assertAlmostEqual(swing[0] / swing[1], 4.0, delta=0.4)

    def test_momenta_of_free_bodies(self):
        motor = {"kind": "position", "value": "0.1", "stiffness": 5.0, "damping": 0.1}
        for joint in (HINGE | {"torsional_stiffness": 5.0, "spring": 20.0, "motor": motor}, SLIDER | {"torsional_stiffness": 5.0, "friction": 1.0, "friction_stiffness": 1e3, "motor": motor},
                      {"kind": "universal", "axis": [0.0, 1.0, 0.0], "second_axis": [0.0, 0.0, 1.0], "stiffness": 1e4, "torsional_stiffness": 5.0, "torsional_damping": 0.01},
                      {"kind": "distance", "stiffness": 1e4, "rope": True, "length": 0.31}):
            with self.subTest(joint["kind"]), opened(mates(joint | {"stiffness": 1e4, "damping": 1.0}, dt=2e-5, duration=0.5, output={"observables": ["angular_momentum"]})) as run:
                before = run.observables
                after = run.step(run.steps).observables
                for heading in before:
                    if "momentum" in heading: self.assertAlmostEqual(before[heading], after[heading], delta=2e-13, msg=heading)

    def test_stops(self):
        """A pendulum falls on a stop, with any dashpot: its energy never rises by 1e-6 of what it fell, and what it loses is booked."""
        for damping in ({}, {"stop_damping": 1.0}, {"stop_damping": 20.0}):
            found, limits = [], {"limits": [-0.5, 0.7], "stop_stiffness": 2000.0}
            with self.subTest(damping), opened(scene(HINGE | limits | damping, duration=2.0, dt=1e-5)) as run:
                while not run.finished:
                    place = run.step(200)["bob"].position[0, 0]
                    found.append(energy(run) + MASS * GRAVITY * place[2])
                    self.assertLess(angle(place), 0.76)
                self.assertLess(np.max(found - np.minimum.accumulate(found)), 2e-6 * MASS * GRAVITY * ARM)
                lost = run.observables["joint_loss[J]"]
                self.assertAlmostEqual(found[0] - found[-1], lost, delta=1e-5)
                if damping: self.assertGreater(lost, 1.0)

    def test_friction_holds_and_stops(self):
        held = {"friction": 4.0, "friction_stiffness": 5e3, "friction_damping": 10.0}  # the weight's couple is 2.9 N m
        with opened(scene(HINGE | held, duration=3.0, dt=2e-5)) as run:
            first = angle(run.step(50000)["bob"].position[0, 0])
            self.assertLess(abs(angle(run.step(100000)["bob"].position[0, 0]) - first), 1e-12)
            self.assertLess(first, 1e-3)
        slides = {"friction": 1.0, "friction_stiffness": 5e3, "friction_damping": 20.0}
        with opened(scene(HINGE | slides, duration=0.8, dt=2e-5, gravity=False, bob={"angular_velocity": [0.0, 5.0, 0.0], "velocity": [0.0, 0.0, -1.5]})) as run:
            turned = []
            while not run.finished: turned.append(angle(run.step(50)["bob"].position[0, 0]))
        way, stop = 0.5 * INERTIA * 25 / 1.0, INERTIA * 5 / 1.0
        self.assertAlmostEqual(turned[-1], way, delta=1e-3 * way)
        self.assertLess(abs(turned[int(0.9 * stop / 1e-3)] - (way - 0.5 / INERTIA * (0.1 * stop)**2)), 1e-3 * way)

    def test_release(self):
        """A bob held to the world lets go, and falls as nothing else does; its joint's energy is booked."""
        held = {"kind": "fixed", "stiffness": 1e5, "torsional_stiffness": 1e4, "until": 0.1}
        with opened(scene(held, dt=1e-5, duration=0.3)) as run:
            run.step(9990)
            before, sag = energy(run) + MASS * GRAVITY * run["bob"].position[0, 0, 2], run["bob"].position[0, 0, 2]
            self.assertLess(abs(sag), 5e-4)
            run.step(20)
            self.assertEqual(run.observables["joint_energy[J]"], 0)
            after = energy(run) + MASS * GRAVITY * run["bob"].position[0, 0, 2]
            self.assertAlmostEqual(before - after, run.observables["joint_loss[J]"], delta=1e-3 * run.observables["joint_loss[J]"])
            place, velocity, time = run["bob"].position[0, 0].copy(), run["bob"].velocity[0, 0].copy(), run.time
            run.step(run.steps)
            fallen = run.time - time
            np.testing.assert_allclose(run["bob"].position[0, 0], place + velocity * fallen - [0, 0, 0.5 * GRAVITY * fallen**2], atol=1e-9)

    def test_catch(self):
        """Two bodies that fly are caught where they are: no force at first, then they go on as one; momenta stay."""
        for kind, keys in (("fixed", {"torsional_stiffness": 100.0}), ("hinge", {"axis": [0.0, 1.0, 0.0], "torsional_stiffness": 100.0, "axis_damping": 0.01}), ("spherical", {}), ("distance", {}),
                           ("slider", {"axis": [0.0, 1.0, 0.0], "torsional_stiffness": 100.0}), ("universal", {"axis": [0.0, 1.0, 0.0], "second_axis": [0.0, 0.0, 1.0], "torsional_stiffness": 100.0})):
            tables = mates({"kind": kind, "stiffness": 1e4, "from": 0.05, **keys}, dt=1e-5, duration=0.2, output={"observables": ["angular_momentum"]})
            with self.subTest(kind), opened(tables) as run:
                run.step(4999)
                before, total = run.observables, energy(run)
                run.step(2)
                self.assertLess(run.observables["joint_energy[J]"], 1e-5 * total, "free of strain where it is made")
                apart = run["bob"].position[0, 0] - run["mate"].position[0, 0]
                after = run.step(run.steps).observables
                for heading in before:
                    if "momentum" in heading: self.assertAlmostEqual(before[heading], after[heading], delta=2e-13, msg=heading)
                self.assertAlmostEqual(energy(run) + after["joint_loss[J]"], total, delta=2e-5)
                if kind in ("fixed", "distance"):
                    self.assertAlmostEqual(np.linalg.norm(run["bob"].position[0, 0] - run["mate"].position[0, 0]), np.linalg.norm(apart), delta=0.01)

    def test_break(self):
        """A rope bears a weight below its strength; above it breaks, and the weight falls."""
        rope = {"kind": "distance", "stiffness": 1e4, "damping": 30.0, "place": [ARM, 0.0, 0.2], "rope": True}
        for strength, holds in ((25.0, True), (15.0, False)):  # the weight of 9.81 N falls into it: up to 19.6 N
            with self.subTest(strength), opened(scene(rope | {"break_force": strength, "damping": 0.0}, dt=1e-5, duration=0.5)) as run:
                lowest = run.step(run.steps)["bob"].position[0, 0, 2]
                if holds: self.assertGreater(lowest, -3e-3)
                else:
                    self.assertLess(lowest, -1.0)
                    self.assertAlmostEqual(run.observables["joint_loss[J]"], 0.5 * strength**2 / 1e4, delta=1e-3 * strength**2 / 1e4)
                self.assertAlmostEqual(energy(run) + MASS * GRAVITY * lowest + run.observables["joint_loss[J]"], 0, delta=1e-4)

    def test_books_of_a_break(self):
        """Where a joint breaks or lets go, in a step of any length, what energies lack falls with the square of that length."""
        rope = {"kind": "distance", "stiffness": 1e3, "place": [ARM, 0.0, 0.2], "rope": True}
        point = {"kind": "spherical", "stiffness": 1e3}
        driven = HINGE | {"stiffness": 1e4, "torsional_stiffness": 100.0, "axis_damping": 0.3, "motor": {"kind": "force", "value": "3 + 20*t"}}
        for joint in (rope | {"until": 0.1}, rope | {"break_force": 15.0}, point | {"until": 0.1}, point | {"break_force": 8.0}, driven | {"until": 0.1}):
            lacks = []
            for dt in (4e-4, 2e-4, 1e-4):
                with opened(scene(joint, dt=dt, duration=0.2)) as run:
                    o = run.step(run.steps).observables
                    self.assertEqual(o["joint_energy[J]"], 0)
                    books = energy(run) + MASS * GRAVITY * run["bob"].position[0, 0, 2] + o["joint_loss[J]"] - o["joint_motor_work[J]"]
                    lacks.append(abs(books))
            with self.subTest(joint=joint, lacks=lacks): self.assertGreater(lacks[0] / lacks[2], 12)

    def test_motor_driven_in_a_loop(self):
        """A controller drives the table that a motor follows; the scene with the points it left repeats the run."""
        tables = scene(HINGE | {"motor": {"kind": "position", "value": "target(t)", "stiffness": 300.0, "damping": 8.0}}, duration=0.4)
        tables["table"] = [{"name": "target", "at": [0.0, 1e-5], "value": [0.0, 0.0], "unit": "rad"}]
        with opened(tables) as run:
            integral = 0.0
            while not run.finished:
                error = 0.3 - angle(run["bob"].position[0, 0])
                integral += 0.5 * error
                run.step(1)
                run.drive("target", integral + error, until=run.after(399))
                run.step(399)
            self.assertAlmostEqual(angle(run["bob"].position[0, 0]), 0.3, delta=5e-3)
            digest, (at, value) = run.digest, run.table("target")
        tables["table"] = [{"name": "target", "at": list(at), "value": list(value), "unit": "rad"}]
        with opened(tables) as run:
            self.assertEqual(run.step(run.steps).digest, digest)

    def test_motor_on_the_end_of_a_rod(self):
        """A couple at the end of a clamped rod turns its tip by M L/EI."""
        youngs, radius, length = 1e7, 5e-3, 0.2
        couple = 1e-3
        tables = {"time": {"duration": 2.0}, "damping": [{"kind": "uniform", "rate": 30.0}],
                  "rods": [{"name": "rod", "start": "clamped", "material": {"density": 1000.0, "youngs_modulus": youngs}, "section": {"radius": radius}, "shape": {"length": length, "elements": 10},
                            "placement": {"tangent": [1.0, 0.0, 0.0]}}],
                  "joint": [{"kind": "hinge", "between": ["rod", "world"], "at": [1.0], "axis": [0.0, 1.0, 0.0], "stiffness": 1e-9, "torsional_stiffness": 1e-9,
                             "motor": {"kind": "force", "value": str(couple)}}]}
        with opened(tables) as run:
            tip = run.step(run.steps)["rod"].position[0, -1]
        turn = couple * length / (youngs * np.pi * radius**4 / 4)
        self.assertAlmostEqual(tip[2], -length / turn * (1 - np.cos(turn)), delta=2e-3 * 0.5 * length * turn)

    def test_audit_of_bodies(self):
        """Loads, joints, contact and damping of bodies that tumble: the balance of energy closes to second order."""
        def defects(dt):
            body = {"mass": 1.0, "inertia": [0.01, 0.02, 0.03], "spheres": {"radii": [0.05]}}
            bodies = [{"name": "one", **body, "placement": {"origin": [0.0, 0.0, 0.3]}, "angular_velocity": [3.0, 1.0, 2.0]},
                      {"name": "two", **body, "placement": {"origin": [0.06, 0.0, 0.5]}, "velocity": [0.0, 0.0, -2.0]}]
            joint = {"kind": "distance", "between": ["one", "world"], "place": [0.0, 0.0, 0.6], "stiffness": 500.0, "damping": 1.0}
            tables = {"time": {"duration": 0.25, "dt": dt}, "bodies": bodies, "joint": [joint], "load": [{"kind": "gravity"}], "damping": [{"kind": "uniform", "rate": 0.5}],
                      "contact": {"law": "hertz", "stiffness": 1e6, "damping": 5.0}, "output": {"audit": True}}
            with opened(tables) as run:
                off, most, touched = [], 0.0, False
                for _ in range(50):
                    o = run.step(run.steps // 50).observables
                    off.append(o["energy_defect[J]"])
                    most, touched = max(most, abs(o["work_loads[J]"])), touched or o["touching_pairs[-]"] > 0
                self.assertTrue(touched)
                self.assertGreater(o["dissipated[J]"], 0.1)
                return np.max(np.abs(off)) / most

        coarse, fine = defects(2e-5), defects(1e-5)
        self.assertLess(fine, 1e-5)
        self.assertGreater(coarse / fine, 3.5)


if __name__ == "__main__":
    unittest.main()
