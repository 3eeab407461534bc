"""Forces and couples of a fluid on single rods, bodies and obstacles: columns for those that a scene asks for, closed forms, the same bits on any layout and
after a stop."""

import math
import unittest

import numpy

from driver import FLUID_OF_RODS, DriverTest, rods_in_a_fluid

BODIES = """
[[bodies]]
name = "balls"
density = 2.0
velocity = [1.0, 0.2, 0.0]
angular_velocity = [0.0, 1.0, 1.0]
[bodies.spheres]
radii = [0.25]
[bodies.placement]
kind = "lattice"
counts = [2, 1]
spacing = [0.52, 1.0]
origin = [1.3, 1.9, 1.5]
"""
BALL = """
[[obstacle]]
name = "still"
centre = [2.9, 2.2, 1.5]
radius = 0.25
"""
HEAD = 'title = "loads of a fluid"\n[time]\nduration = 0.2\n' + FLUID_OF_RODS + "largest_slip = 0\n"
OUTPUT = "[output]\nseries = 0.02\ncheckpoint = 0.04\n"
SCENE = HEAD + BALL + BODIES + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0]) + OUTPUT
EACH = 'fluid_forces = ["balls", "thick", "threads"]\n'
PROBES = """
[[probe]]
name = "push"
of = "threads"
number = 1
quantity = "fluid_force"
[[probe]]
name = "turn"
of = "threads"
number = 1
quantity = "fluid_couple"
"""
SHARP = '[immersion]\nbody_surface = "sharp"\nrod_surface = "sharp"\n'

# A ball that turns in a cube of 1 m with periods, slowly.
RADIUS, RATE = 0.125, 10.0
VOLUME = 4 / 3 * math.pi * RADIUS**3
STOKES = 8 * math.pi * RADIUS**3 / (1 - VOLUME)  # couple over viscosity and rate


def cube(cells, duration, speed, tables, series=0.01):
    return f"""
title = "a body turns in a fluid"
[time]
duration = {duration}
[fluid]
cells = [{cells}, {cells}, {cells}]
spacing = {1 / cells!r}
density = 1.0
viscosity = 1.0
courant = 0.5
expected_speed = {speed!r}
{tables}
[output]
series = {series}
"""


def free_ball(density, couple, keys=""):
    return f"""
[[bodies]]
name = "ball"
density = {density}
[bodies.spheres]
radii = [{RADIUS}]
[bodies.placement]
origin = [0.51, 0.5, 0.497]
[[load]]
kind = "uniform_couple"
couple = [0.0, 0.0, {couple!r}]
[[probe]]
name = "spin"
of = "ball"
quantity = "spin"
[[probe]]
name = "couple"
of = "ball"
quantity = "fluid_couple"
{keys}
"""


class FluidLoads(DriverTest):
    def rows(self, out):
        return (self.directory / out / "observables.csv").read_bytes()

    def load(self, series, name, kind):
        unit = "N_m" if kind.endswith("couple") else "N"
        return numpy.array([series[f"{name}_{kind}_{axis}{unit}" if kind else f"{name}_{axis}{unit}"] for axis in "xyz"])

    def test_columns_of_each_sum_to_the_force_on_their_group(self):
        tapering = SCENE.replace("radius_2 = 0.2\n", "radius_2 = 0.2\ntaper = 0.1\n")
        self.assertNotEqual(tapering, SCENE)
        for out, scene, more in (("markers", SCENE, ""), ("sharp", SCENE, SHARP), ("tapering", tapering, SHARP), ("one_way", SCENE, '[immersion]\ncoupling = "one_way"\n')):
            self.scene.write_text(scene + EACH + PROBES + more)
            self.run_skein(out)
            series = self.series(out)
            self.assertEqual(len([name for name in series.dtype.names if "_fluid_couple_" in name]), 3 * 5)
            for group, count in (("balls", 2), ("thick", 1), ("threads", 2)):
                each = [self.load(series, f"{group}_{i}", "fluid_force") for i in range(count)]
                whole = self.load(series, group, "fluid_force")
                self.assertGreater(abs(whole).max(), 1e-3)
                self.assertLess(abs(sum(each) - whole).max(), 1e-12 * abs(whole).max(), (out, group))
                for i in range(count):
                    self.assertGreater(abs(self.load(series, f"{group}_{i}", "fluid_couple")).max(), 1e-4)
            for probe, kind in (("push", "fluid_force"), ("turn", "fluid_couple")):
                unit = "N_m" if probe == "turn" else "N"
                for axis in "xyz":
                    self.assertTrue(numpy.array_equal(series[f"{probe}_{axis}{unit}"], series[f"threads_1_{kind}_{axis}{unit}"]))

    def test_same_bits_on_any_layout_and_after_a_stop(self):
        for kind, more in (("markers", ""), ("sharp", SHARP)):
            self.scene.write_text(SCENE + EACH + PROBES + more)
            self.run_skein(kind)
            for out, arguments, layout in (("two", (), {"ranks": 2}), ("four", ("--set", "fluid.ranks_across=2"), {"ranks": 4}), ("threads", ("--lanes", "2"), {"threads": 2})):
                self.run_skein(out + kind, *arguments, **layout)
                self.assertEqual(self.rows(out + kind), self.rows(kind), out + kind)
            self.run_skein("parts" + kind, "--until", "0.1", ranks=2)
            self.assertIn("Resuming from", self.run_skein("parts" + kind).stdout)
            self.assertEqual(self.rows("parts" + kind), self.rows(kind))

    def test_no_bit_depends_on_them(self):
        self.scene.write_text(SCENE)
        self.run_skein("without")
        self.scene.write_text(SCENE + EACH + PROBES)
        self.assertRegex(self.plan_text(), r"loads +36 columns of forces and couples on 5 single rods and bodies")
        self.run_skein("with")
        self.assertEqual(self.digest("with"), self.digest("without"))
        mine, others = self.series("with"), self.series("without")
        for name in others.dtype.names:
            self.assertTrue(numpy.array_equal(mine[name], others[name]), name)

    def test_a_ball_that_is_turned_feels_the_couple_of_stokes(self):
        """Free or with a given motion; the mean of the whole cube turns back, by its share of the volume."""
        for surface, keys, bound in (("markers", "[immersion]\nretraction = 0.3\n", 0.035), ("sharp", '[immersion]\nbody_surface = "sharp"\n', 0.02)):
            couple = RATE * STOKES
            self.scene.write_text(cube(32, 0.1, 1.3, free_ball(1.0, couple, keys)))
            self.run_skein("free" + surface)
            series = self.series("free" + surface)
            self.assertLess(abs(series["couple_zN_m"][-1] / -couple - 1), 0.002, surface)
            self.assertLess(abs(series["spin_zrads"][-1] / RATE - 1), bound, surface)
            keys = "retraction = 0.3\n" if surface == "markers" else ""
            self.scene.write_text(cube(32, 0.1, 1.3, f'[[obstacle]]\nname = "it"\nsurface = "{surface}"\ncentre = [0.51, 0.5, 0.497]\nradius = {RADIUS}\nangular_velocity = [0.0, 0.0, {RATE}]\n{keys}'))
            self.run_skein("given" + surface)
            given = self.series("given" + surface)["it_couple_zN_m"][-1]
            self.assertLess(abs(given / -couple - 1), bound, surface)
            self.assertLess(abs(given * series["spin_zrads"][-1] / (RATE * series["couple_zN_m"][-1]) - 1), 0.003, "free and given motions agree")

    def test_a_cylinder_that_turns_feels_the_couple_of_its_vortex(self):
        """Of a square lattice, a vortex with a turning of the opposite sign around it: 4 pi mu a^2 a length over 1 less the share of the area."""
        area = math.pi * RADIUS**2
        couple = -4 * area * RATE / (1 - area)
        errors = {}
        for surface, keys in (("markers", "retraction = 0.3\n"), ("sharp", "")):
            for cells in (32, 64):
                text = cube(cells, 0.1, 1.3, f'[[obstacle]]\nname = "it"\nkind = "cylinder"\nsurface = "{surface}"\ncentre = [0.51, 0.5, 0.0]\nradius = {RADIUS}\nangular_velocity = [0.0, 0.0, {RATE}]\n{keys}')
                self.scene.write_text(text.replace(f"[{cells}, {cells}, {cells}]", f"[{cells}, {cells}, 1]"))
                self.run_skein(f"{surface}{cells}")
                found = self.load(self.series(f"{surface}{cells}"), "it", "couple")[:, -1]
                errors[surface, cells] = found[2] * cells / couple - 1
                self.assertLess(abs(found[:2]).max(), 1e-12 * abs(found[2]), "its centre is at half of the depth")
        self.assertLess(abs(errors["markers", 32]), 0.02, errors)
        self.assertLess(abs(errors["sharp", 32]), 0.01, errors)
        for surface in ("markers", "sharp"):
            self.assertLess(abs(errors[surface, 64]), 0.6 * abs(errors[surface, 32]), errors)

    def test_couples_turn_a_body_that_begins_to_turn(self):
        """Its moment of inertia less the displaced fluid's times its spin is the sum of all couples over time. A body with a sharp surface takes the couple of a
        step in the next one."""
        couple, density = RATE * STOKES, 3.0
        inertia = 0.4 * RADIUS**2 * VOLUME
        for surface, keys in (("markers", ""), ("sharp", '[immersion]\nbody_surface = "sharp"\n')):
            self.scene.write_text(cube(24, 0.06, 1.3, free_ball(density, couple, keys), series=2e-4))
            self.run_skein(surface)
            series = self.series(surface)
            length, of_fluid = numpy.diff(series["times"]), series["couple_zN_m"][1:]
            self.assertEqual(len(length), series["fluid_steps"][-1], "each row is the mean of a step")
            given = couple * series["times"][-1] + length @ of_fluid - (surface == "sharp") * length[-1] * of_fluid[-1]
            gained = (density - 1) * inertia * series["spin_zrads"][-1]
            self.assertGreater(series["spin_zrads"][-1], 9.0)
            self.assertLess(abs(given / gained - 1), 0.005, surface)

    def test_a_couple_on_a_rod_is_about_its_start(self):
        """A rod across a stream, in a plane of symmetry through its middle, carries its force there."""
        for surface, radius in (("markers", 0.06), ("sharp", 0.16)):
            self.scene.write_text('title = "rods across a stream"\n[time]\nduration = 0.2\n' + FLUID_OF_RODS + "largest_slip = 0\nacceleration = [3.0, 0.0, 0.0]\n" + f"""
[[rods]]
name = "bar"
start = "clamped"
[rods.material]
density = 10.0
youngs_modulus = 1e9
[rods.section]
radius = {radius}
[rods.shape]
length = 1.0
elements = 6
[rods.placement]
origin = [1.1, 1.0, 0.5]
[immersion]
coupling = "one_way"
rod_surface = "sharp"
[output]
series = 0.02
fluid_forces = ["bar"]
""")
            self.run_skein(surface)
            self.assertEqual("sharp surface" in self.plan_text(), surface == "sharp")
            series = self.series(surface)
            force, couple = (self.load(series, "bar_0", f"fluid_{kind}")[:, -1] for kind in ("force", "couple"))
            self.assertGreater(force[0], 0.1)
            self.assertLess(numpy.linalg.norm(couple - numpy.cross([0, 0, 0.5], force)), 1e-6 * force[0], surface)

    def test_faults_name_key_and_cure(self):
        several = BODIES.replace("counts = [2, 1]", "counts = [40, 40]").replace("radii = [0.25]", "radii = [0.01]").replace("spacing = [0.52, 1.0]", "spacing = [0.05, 0.05]")
        dry = 'title = "dry"\n[time]\nduration = 0.2\n' + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0])
        for text, words in {
            SCENE + 'fluid_forces = ["ball"]\n': "there is no group of rods 'ball'; did you mean 'balls'",
            SCENE + 'fluid_forces = ["balls", "balls"]\n': "the group 'balls' is named twice",
            HEAD + BALL + OUTPUT + 'fluid_forces = ["balls"]\n': "'fluid_forces' has no use without rods or bodies in a [fluid]",
            SCENE.replace("series = 0.02\n", "") + EACH: "forces on single rods and bodies are columns of the time series: set output.series [s]",
            dry + OUTPUT + EACH: "'fluid_forces' has no use without rods or bodies in a [fluid]",
            dry + PROBES: "a probe of \"fluid_force\" needs rods in a [fluid], and there is none",
            SCENE + PROBES.replace("number = 1", "number = 1\nat = 0.5"): "'at' has no use for a force or couple on a whole rod",
            SCENE + PROBES.replace("number = 1", "number = 2"): "'number' of the probe 'push' is 2; the group 'threads' has 2, counted from 0",
            HEAD + several + OUTPUT + 'fluid_forces = ["balls"]\n': "output.fluid_forces: its groups have 1600 rods and bodies, which would make 9600 columns: at most 1000 may have columns of their own; a [[probe]]",
            SCENE + EACH + PROBES.replace('"push"', '"balls_0_fluid_force"'): "the time series has two columns 'balls_0_fluid_force_x'",
        }.items():
            with self.subTest(words=words):
                self.scene.write_text(text)
                done = self.run_skein("bad", expect=2)
                self.assertIn(words, done.stderr)
                self.assertIn(str(self.scene), done.stderr) if "two columns" not in words else None


if __name__ == "__main__":
    unittest.main()
