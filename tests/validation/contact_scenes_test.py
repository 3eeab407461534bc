"""Scenes of apps/contact against closed forms: collisions, a rod on an incline, twist and writhe of rods that touch themselves, a knot."""

import math
import unittest

import h5py
import numpy

from single_runs import APPS, SingleRuns

SPEED, ELEMENTS = 0.1, 3
END_ON = ("rods.striker.placement.origin=[0.06501, 0.0, 0.0]", "rods.striker.placement.tangent=[1.0, 0.0, 0.0]",
          f"rods.striker.shape.velocity=[{-SPEED}, 0.0, 0.0]")
ASLANT = (f"rods.striker.shape.velocity=[{0.5 * SPEED}, {0.3 * SPEED}, {-SPEED}]",)
MU, G = 0.4, 9.81


class Impact(SingleRuns):
    def bounce(self, axis, *settings, elements=ELEMENTS):
        """Speed of parting over that of approach, and what share of the rods' energy in their common frame is in vibration."""
        self.run_alone("impact", *settings, scene=APPS / "contact/impact.toml")
        state, last = self.state("impact"), {name: column[-1] for name, column in self.series("impact").items()}
        self.assertEqual(last["contacts"], 0, "still touching")
        weight = numpy.array([0.5] + [1.0] * (elements - 1) + [0.5]) / elements
        velocity = {name: weight @ rod["state"][0][:, 3:6] for name, rod in state.items()}
        mass = 1000 * math.pi * 0.01**2 * 0.09
        energy = sum(last[part] for part in ("kinetic_translation", "kinetic_rotation", "elastic_stretch", "elastic_shear", "elastic_bend", "elastic_twist"))
        rigid = 0.5 * mass * sum(v @ v for v in velocity.values())
        return (velocity["striker"] - velocity["target"])[axis] / SPEED, (energy - rigid) / (0.25 * mass * SPEED**2)

    def test_restitution(self):
        """Side on, end on and aslant, whatever the number of elements."""
        for name, axis, settings in (("side on", 2, ()), ("end on", 0, END_ON), ("aslant", 2, ASLANT)):
            for elements in (2, 3, 9, 27):
                for wanted in (1.0, 0.9, 0.5, 0.3):
                    many = (f"rods.{rod}.shape.elements={elements}" for rod in ("target", "striker"))
                    e, vibration = self.bounce(axis, f"contact.restitution={wanted}", *many, *settings, elements=elements)
                    with self.subTest(name=name, elements=elements, wanted=wanted):
                        self.assertAlmostEqual(e / wanted, 1, delta=1.5e-2)
                        self.assertLessEqual(e, 1 + 1e-6)
                        self.assertLess(vibration, 1e-3)


class Incline(SingleRuns):
    MASS = 1000 * math.pi * 0.01**2 * 0.2

    def down(self, out, slope, *settings):
        gravity = f"load.gravity.acceleration=[{G * math.sin(slope)!r}, 0.0, {-G * math.cos(slope)!r}]"
        self.run_alone(out, gravity, *settings, scene=APPS / "contact/incline.toml")
        series = self.series(out)
        late = series["time"] > 0.499 * series["time"][-1]
        way = series["centre_x"][late]
        return way[-1] - way[0], numpy.polyfit(series["time"][late], series["momentum_x"][late] / self.MASS, 1)[0]

    def test_sticks(self):
        way, _ = self.down("sticks", math.atan(0.95 * MU))
        self.assertLess(abs(way), 1e-6 * 0.2)  # 1e-6 lengths a second, over one second

    def test_slides(self):
        slope = math.atan(1.05 * MU)
        ways = []
        for dt in (6e-5, 3e-5):
            way, acceleration = self.down("slides", slope, f"time.dt={dt}")
            self.assertAlmostEqual(acceleration / (G * (math.sin(slope) - MU * math.cos(slope))), 1, delta=1e-2)
            ways.append(way)
        self.assertAlmostEqual(ways[0] / ways[1], 1, delta=2e-2)

    def test_rolls(self):
        """Within what it sinks in, 0.5 % of the radius."""
        _, acceleration = self.down("rolls", 0.3, "rods.rod.placement.tangent=[0.0, 1.0, 0.0]")
        self.assertAlmostEqual(acceleration / (2 / 3 * G * math.sin(0.3)), 1, delta=1e-2)


class Boxes(SingleRuns):
    """A stack of three, at rest until a plank arrives that flies as a parabola."""

    def test_bear_their_weights_until_they_are_knocked_off(self):
        self.run_alone("boxes", scene=APPS / "contact/boxes.toml")
        series = self.series("boxes")
        a, b, c, r = 0.023, 0.028, 0.013, 0.002  # half sides without the rounding, and that
        volume = 8 * a * b * c + 8 * r * (a * b + b * c + c * a) + 2 * math.pi * r**2 * (a + b + c) + 4 / 3 * math.pi * r**3
        weight, k = 600 * volume * G, 1e5
        at = numpy.argmin(abs(series["time"] - 0.2))
        self.assertAlmostEqual(series["contact_energy"][at] / (5 * weight**2 / (4 * k)), 1, delta=1e-3)  # four points make a face twice as stiff
        self.assertAlmostEqual(series["floor_force"][at] / (3 * weight), 1, delta=1e-3)
        self.assertLess(series["contact_friction_work"][at], 1e-12)
        arrival = (0.72 - 0.005 - 0.025) / 3.0
        hit = series["time"][numpy.argmax(series["contacts"] != 2 * (series["time"] > 0))]
        self.assertGreater(hit, arrival)
        self.assertLess(hit, arrival + 0.02)
        energy = sum(series[name] for name in ("kinetic_translation", "kinetic_rotation", "contact_energy", "contact_friction_work", "contact_viscous_work", "wall_energy",
                                               "wall_friction_work", "wall_viscous_work", "potential"))
        self.assertLess(abs(energy - energy[0]).max(), 1e-3 * energy[0], "books of energy")
        places = self.state("boxes")["boxes"]["state"][:, 0, :3]
        self.assertLess(numpy.linalg.norm(places[0] - [0, 0, 0.015]), 0.06, "the lowest stays")
        self.assertGreater(places[1:, 0].min(), 0.2, "the others have gone")
        self.assertLess(places[1:, 2].max(), 0.032, "and lie on the floor")


class RodsOnBox(SingleRuns):
    """Rods that fall across a box, lie on it and hang over its edges; with and without all that dissipates in contacts."""

    def test_keep_their_books(self):
        text = (APPS / "contact/rods_on_box.toml").read_text().replace("rate = 2.0 ", "rate = 0.0 ")
        self.assertIn("rate = 0.0", text)
        elastic = "\n".join(line for line in text.replace("damping = 1.0 ", "damping = 0.0 ").replace('friction = "memory"', "").splitlines() if "static_friction" not in line)
        for name, scene, most in (("damped", text, 1e-3), ("elastic", elastic, 5e-4)):
            path = self.directory / f"{name}.toml"
            path.write_text(scene)
            self.run_alone(name, "time.dt=1e-5", scene=path)
            series = self.series(name)
            stored = [column for column in series if column.startswith(("kinetic_", "elastic_"))]
            energy = sum(series[column] for column in stored + ["contact_energy", "contact_friction_work", "contact_viscous_work", "wall_energy", "wall_friction_work",
                                                                "wall_viscous_work", "potential"])
            self.assertLess(abs(energy - energy[0]).max(), most * energy[0], name)
            dissipated = series["contact_friction_work"][-1] + series["contact_viscous_work"][-1]
            self.assertEqual(dissipated > 0.1 * energy[0], name == "damped")


class Plectoneme(SingleRuns):
    """Wall to wall, twist + writhe is the rotation of the end. The series counts twist between the outermost elements' middles: of n cells
    one, two halves, is missing, in a rod at rest as twisted as the others."""

    TURNS, CELLS = 4.0, 80

    def link(self, out, *settings):
        self.run_alone(out, *settings, scene=APPS / "contact/plectoneme.toml")
        series = self.series(out)
        held = series["time"] >= 10.0
        return (series["twist"] * self.CELLS / (self.CELLS - 1) + series["writhe"])[held], series

    def test_link_is_kept(self):
        link, series = self.link("touching", "time.duration=24", "output.trajectory=0")
        self.assertLess(numpy.abs(link - self.TURNS).max(), 1e-2)
        self.assertGreater(series["writhe"][-1], 1.5)
        self.assertGreater(series["contacts"][-1], 4)

    def test_link_is_lost_without_contact(self):
        """Each passage through itself takes two turns."""
        link, series = self.link("passing", "time.duration=24", "contact.self=false", "output.trajectory=0")
        self.assertAlmostEqual(link[-1], self.TURNS - 2, delta=5e-2)


class Solenoid(SingleRuns):
    """Wall to wall again; but coils shear, their directors lean out of the centreline, and their cells count more twist than they are twisted by.
    What is even along the rod is the torque, so the wall's missing cell is taken from the energy of twist."""

    RADIUS, SHEAR_MODULUS, MODULUS = 0.025, 666666.7, 1e6
    AREA, TORSION, BENDING = math.pi * RADIUS**2, SHEAR_MODULUS * math.pi * RADIUS**4 / 2, MODULUS * math.pi * RADIUS**4 / 4

    def wound(self, out, turns, cells, *settings):
        """Directions of its elements at the end: angle to the axis, and angle round it, rad. Link is kept all the way."""
        self.run_alone(out, f"rods.rod.end_motion.rotation={[[2 * math.pi * t, 0.0, 0.0] for t in (0, 0, turns, turns)]}",
                       f"rods.rod.shape.elements={cells}", "output.trajectory=0", *settings, scene=APPS / "contact/solenoid.toml")
        series = self.series(out)
        cell = numpy.sqrt(2 * series["elastic_twist"] / self.TORSION) / (2 * math.pi * cells)
        given = numpy.interp(series["time"], (0, 2, 14, 18), (0, 0, turns, turns))
        held = series["time"] > 2.5
        self.assertLess(numpy.abs(series["twist"] + series["writhe"] + cell - given)[held].max(), 3e-2)
        self.assertLess(series["max_overlap"].max(), 0.05)
        self.assertLess(series["kinetic_translation"][-1], 1e-4)
        edge = numpy.diff(self.state(out)["rod"]["state"][0][:, :3], axis=0)
        return numpy.arccos(edge[:, 0] / numpy.linalg.norm(edge, axis=1)), numpy.unwrap(numpy.arctan2(edge[:, 2], edge[:, 1]))

    def test_coils_lie_side_by_side(self):
        lean, azimuth = self.wound("solenoid", 13, 80)
        coiled = numpy.flatnonzero(lean > math.pi / 6)
        self.assertGreater((azimuth[coiled[-1]] - azimuth[coiled[0]]) / (2 * math.pi), 4.5)  # 5.2
        self.assertLess(lean.max(), math.pi / 2)  # along the axis, never back

    def test_nearer_ends_let_it_wind_round_itself(self):
        lean, _ = self.wound("plectoneme", 10, 100, "rods.rod.end_motion.translation=[[0,0,0],[0.2,0,0],[-0.6,0,0],[-0.6,0,0]]")
        self.assertGreater(lean.max(), 2 * math.pi / 3)
        self.assertGreater(numpy.abs(self.state("plectoneme")["rod"]["state"][0][:, 1:3]).max(), 8 * self.RADIUS)

    def torque_of_buckling(self, stretch):
        """Of a clamped rod: 1/a - cot a = 1/b - cot b with a, b = (M +- sqrt(M^2 - 4 B T c)) L/4B.
        Without tension this is Greenhill's tan a = a. c = e - T/S: force and moment are of the stretched, sheared centreline."""
        tension = self.MODULUS * self.AREA * stretch
        c = 1 + stretch - tension / (27 / 28 * self.SHEAR_MODULUS * self.AREA)
        endless = 2 * math.sqrt(self.BENDING * tension * c)
        moment = endless * numpy.linspace(1.0005, 1.5, 10000)
        root = numpy.sqrt(moment**2 - endless**2)
        a, b = (moment + root) / (4 * self.BENDING), (moment - root) / (4 * self.BENDING)
        misfit = a * b * numpy.sin(a - b) / (a - b) - numpy.sin(a) * numpy.sin(b)
        return moment[numpy.flatnonzero(misfit[:-1] * misfit[1:] < 0)[0]]

    def test_buckles_where_theory_says(self):
        """Held at a tenth; fast to 5.6 turns, then slowly: it buckles 0.5 % late. An endless rod that neither stretches nor shears would 2 % later."""
        out, times, turns = "buckles", (0.0, 1.0, 3.0, 9.0), (0, 0, 5.6, 6.3)
        self.run_alone(out, "time.duration=9", f"rods.rod.end_motion.times={list(times)}", "output.trajectory=0", "output.series=0.02",
                       "rods.rod.end_motion.translation=[[0,0,0],[0.1,0,0],[0.1,0,0],[0.1,0,0]]",
                       f"rods.rod.end_motion.rotation={[[2 * math.pi * t, 0.0, 0.0] for t in turns]}", scene=APPS / "contact/solenoid.toml")
        series = self.series(out)
        late = series["time"] > 3
        onset = series["time"][late][numpy.argmax(series["writhe"][late] > 1e-3)]
        self.assertAlmostEqual(numpy.interp(onset, times, turns) * 2 * math.pi * self.TORSION / self.torque_of_buckling(0.1), 1, delta=1e-2)


class Knot(SingleRuns):
    """An open overhand knot under tension T. Contact without friction only pushes across the rod, so that B k^2/2 + N = T all along it, with the
    curvature k and the tension N. In the loop N is small where the rod is thin, hence T R^2/B -> 1/2 (Audoly, Clauvelin, Neukirch 2007)."""

    TENSION, RADIUS, MODULUS = 8e-3, 0.003, 1e6
    BENDING = MODULUS * math.pi * RADIUS**4 / 4

    def pulled(self, out, duration, *settings):
        """Its end state: curvature at the inner vertices, and B k^2/2 + N over T there."""
        self.run_alone(out, f"time.duration={duration}", f"output.trajectory={duration}", *settings, scene=APPS / "contact/knot.toml")
        frames = []
        for segment in sorted((self.directory / out).glob("trajectory_*.h5")):
            with h5py.File(segment) as file:
                frames += list(next(iter(file["groups"].values()))["position"][:, 0])
        rest, edges = numpy.linalg.norm(frames[0][1] - frames[0][0]), numpy.diff(frames[-1], axis=0)
        lengths = numpy.linalg.norm(edges, axis=1)
        directions = edges / lengths[:, None]
        curvature = numpy.arccos(numpy.clip((directions[1:] * directions[:-1]).sum(axis=1), -1, 1)) / rest
        stretch = lengths / rest - 1
        tension = self.MODULUS * math.pi * self.RADIUS**2 * 0.5 * (stretch[1:] + stretch[:-1])
        return curvature, (0.5 * self.BENDING * curvature**2 + tension) / self.TENSION

    def test_loop_stays_and_carries_the_tension(self):
        curvature, share = self.pulled("tied", 25)
        self.assertAlmostEqual(share[0], 1, delta=1e-3)  # through the knot without loss
        self.assertAlmostEqual(share[-1], 1, delta=1e-3)
        self.assertLess(numpy.abs(share - 1).max(), 5e-2)  # loop and contacts: elements are straight, and corners rub
        loop = numpy.flatnonzero(curvature > 0.5 * curvature.max())
        mean = curvature[loop[0]:loop[-1] + 1].mean()
        r_over_R = self.RADIUS * math.sqrt(2 * self.TENSION / self.BENDING)
        self.assertAlmostEqual(self.TENSION / (self.BENDING * mean**2), 0.5, delta=3 * r_over_R)
        writhe = self.series("tied")["writhe"]
        self.assertLess(numpy.abs(writhe - 3).max(), 0.5)  # a passage would take 2

    def test_slips_open_without_contact(self):
        self.pulled("slips", 15, "contact.self=false")
        self.assertLess(abs(self.series("slips")["writhe"][-1]), 0.1)



class Capstan(SingleRuns):
    """A rod is pulled over half a turn of a cylinder. The balance of moments about its axis makes the exponent mu pi R/(R + r)."""

    RADIUS, STRAIGHT, PULL = 0.2, 0.25, 0.01

    def ratio(self, radius, elements, *settings, friction="regularised", slip_speed=1e-3):
        """Tension at the end that is pulled over that at the end with the weight."""
        arc = math.pi * (self.RADIUS + radius)
        length = 2 * self.STRAIGHT + arc
        bent = int(arc / (length / elements))
        curvature = math.pi / bent / (length / elements)
        first = (elements - 1 - bent) // 2
        profile = [[curvature if first <= i < first + bent else 0.0, 0.0, 0.0] for i in range(elements - 1)]
        law = f'friction = "{friction}", ' + (f"slip_speed = {slip_speed}" if friction == "regularised" else "static_friction = 0.4")
        self.scene.write_text(f"""
time = {{duration = 1.8}}
load = [{{kind = "end_force", start = [0.0, 0.0, -1.0], ramp = 0.3}}]
damping = [{{kind = "uniform", rate = 10.0}}]
output = {{trajectory = 0.05, precision = "double"}}
wall = [{{name = "cylinder", kind = "tube", axis = [0, 1, 0], radius = {self.RADIUS}, side = "outside", law = "linear", stiffness = {4000 * 60 / elements}, damping = 0.5, kinetic_friction = 0.4, allow_overlap = true, {law}}}]
[[rods]]
name = "rope"
end = "pinned"
material = {{density = 1000.0, youngs_modulus = {1e7 * (0.003 / radius) ** 2}}}
section.radius = {radius}
shape = {{length = {length}, elements = {elements}, rest_curvature = [0.0, 0.0, 0.0], start_curvature_profile = {profile}}}
placement = {{origin = [{-self.RADIUS - radius}, 0.0, {-self.STRAIGHT}], tangent = [0.0, 0.0, 1.0], normal = [0.0, 1.0, 0.0]}}
end_motion.translation_formula = ["0", "0", "-{self.PULL}*max(t-0.6,0)"]
""")
        self.run_alone("rope", *settings)
        frames = self.frames("rope", "trajectory")
        x, late = frames["groups/rope/position"][:, 0], frames["time"] > 1.3
        stretch = numpy.linalg.norm(numpy.diff(x, axis=1), axis=2) * elements / length
        tension = (1 - 1 / stretch)[late].mean(axis=0)  # over EA
        return tension[-1] / tension[0]

    def test_of_regularised_friction_at_any_step_and_slip_speed(self):
        for radius, elements, settings, slip_speed in ((0.003, 60, (), 1e-3), (0.003, 60, ("time.dt=4e-6",), 1e-3), (0.003, 60, (), 1e-7), (0.0015, 120, (), 1e-4),
                                                       (0.0015, 120, (), 1e-3), (0.0015, 120, (), 4e-3)):
            with self.subTest(radius=radius, settings=settings, slip_speed=slip_speed):
                expected = math.exp(MU * math.pi * self.RADIUS / (self.RADIUS + radius))
                self.assertAlmostEqual(self.ratio(radius, elements, *settings, slip_speed=slip_speed) / expected, 1, delta=0.02)


if __name__ == "__main__":
    unittest.main()
