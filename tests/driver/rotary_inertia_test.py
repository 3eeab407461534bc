"""rotary_inertia_for_dt = "auto": what it changes of bending, by modes and motion, what it gains, how it is told, and where it is refused."""

import json
import math
import unittest

import numpy

from driver import DriverTest

ENDS = {"clamped": 'start = "clamped"', "pinned": 'start = "pinned"\nend = "pinned"', "between clamps": 'start = "clamped"\nend = "clamped"',
        "pendulum": 'start = "pinned"', "guided": 'start = "clamped"\nend = "clamped"\nend_free = "xyz"'}
AUTO, CHOSEN = ("--set", "rods.rod.material.rotary_inertia_for_dt=auto"), "rods.rod.material.rotary_inertia_for_dt"


def scene(ends="clamped", elements=20, radius=0.004, shape="", more="", duration=1.0, output=""):
    """A thin rod along x; `more`: tables behind it."""
    return f"""
time.duration = {duration}
{output}
[[rods]]
name = "rod"
{ENDS.get(ends, ends)}
material = {{density = 1000.0, youngs_modulus = 1e6}}
section.radius = {radius}
shape = {{length = 1.0, elements = {elements}{shape}}}
placement.tangent = [1.0, 0.0, 0.0]
{more}
"""


class RotaryInertia(DriverTest):
    def frequencies(self, text, *options):
        """Of bending in one plane: every other mode of a round rod."""
        said = self.solve_scene("modes", "modes", "--undamped", "--count", "24", "--json", "--quiet", "--overwrite", *options, text=text).stdout
        return numpy.array([mode["frequency_Hz"] for mode in json.loads(said)["modes"]][1::2])

    def plan_of(self, text, *options):
        self.scene.write_text(text)
        return self.plan(*options)

    def exact(self, ends):
        """Of infinitely many elements, by two numbers of them."""
        coarse, fine = (self.frequencies(scene(ends, n)) for n in (80, 160))
        return (4 * fine - coarse) / 3

    def test_two_lowest_modes_change_by_less_than_a_fifth_of_their_error(self):
        for ends in ENDS:
            exact = self.exact(ends)
            for n in (10, 20, 40):
                with self.subTest(ends=ends, n=n):
                    plain, chosen = self.frequencies(scene(ends, n)), self.frequencies(scene(ends, n), *AUTO)
                    share = ((chosen - plain) / (plain - exact))[:2]
                    self.assertTrue((share < 0.2).all() and (share > 0).all(), share)
                    self.assertGreater(share.max(), 0.16, "more inertia would do")
                    printed = self.plan_of(scene(ends, n), *AUTO)["groups"][0]["automatic_inertia"]
                    self.assertAlmostEqual(printed["share_of_error"], share.max(), delta=0.3 / n)
                    # The highest mode that is right to 1 %.
                    right = numpy.abs(chosen / exact - 1) < 0.01
                    self.assertEqual(printed["highest_mode"], numpy.argmin(right), right)

    def test_the_step_grows_as_printed(self):
        for ends in ENDS:
            for n in (10, 20, 40):
                with self.subTest(ends=ends, n=n):
                    plain, chosen = self.plan_of(scene(ends, n)), self.plan_of(scene(ends, n), *AUTO)
                    gain = chosen["groups"][0]["automatic_inertia"]["gain"]
                    self.assertAlmostEqual(chosen["limit"] / plain["limit"], gain, delta=2e-3 * gain)
                    self.assertGreater(gain, 2)
                    self.assertTrue(any(f"steps {gain:.3g} times longer" in note for note in chosen["notes"]), chosen["notes"])
                    self.assertTrue(any('= "auto" of \'rod\' would take steps' in note for note in plain["notes"]), plain["notes"])
                    self.assertAlmostEqual(plain["steps"] / chosen["steps"], gain, delta=0.02 * gain)

    def test_motions_change_by_less_than_a_fifth_of_their_error(self):
        """A clamped rod that is let go in the shape of either of its two lowest modes: a(t + T) + a(t - T) = 2 cos(w T) a(t), with a the part of its
        deflection that has this shape."""
        for root in (1.8751040687, 4.6940911330):
            share = (math.cosh(root) + math.cos(root)) / (math.sinh(root) + math.sin(root))
            period, found = 2 * math.pi / (root**2 * 0.5 * 0.01 * math.sqrt(1e6 / 1000.0)), []
            for n, options in ((20, ()), (20, AUTO), (40, ()), (80, ())):
                y = root * numpy.arange(n + 1) / n
                bend = 0.01 * (numpy.cosh(y) + numpy.cos(y) - share * (numpy.sinh(y) + numpy.sin(y)))[1:-1]
                mode = numpy.cosh(y) - numpy.cos(y) - share * (numpy.sinh(y) - numpy.sin(y))
                mode[-1] *= 0.5 # half a mass
                shape = f", start_curvature_profile = {[[curvature, 0.0, 0.0] for curvature in bend.tolist()]}"
                self.scene.write_text(scene("clamped", n, 0.01, shape, duration=3 * period, output=f"output = {{trajectory = {0.01 * period}, precision = \"double\"}}"))
                self.run_skein("out", "--overwrite", *options)
                places, lag = self.frames("out", "trajectory")["groups/rod/position"][:, 0], 17
                a = places[:, :, numpy.argmax(numpy.ptp(places[:, -1], axis=0))] @ mode
                middle = a[lag:-lag]
                found.append(math.acos((middle * (a[2 * lag:] + a[:-2 * lag])).sum() / (2 * (middle**2).sum())))
            plain, chosen, finer, finest = found
            change = (chosen - plain) / (plain - (4 * finest - finer) / 3)
            self.assertLess(change, 0.2, root)
            self.assertGreater(change, 0.1, root)

    def test_elements_converge_at_second_order(self):
        errors = [abs(self.frequencies(scene("clamped", n), *AUTO)[:2] / self.exact("clamped")[:2] - 1) for n in (20, 40)]
        numpy.testing.assert_allclose(numpy.log2(errors[0] / errors[1]), 2, atol=0.05)
        self.scene.write_text(scene("clamped", 10))
        said = self.skein_says("converge", self.scene, "--modes", "4", "--out", self.directory / "converge", *AUTO).stdout
        self.assertIn("is chosen for each number of elements", said)

    def test_a_restart_has_the_number_in_use(self):
        text = scene("clamped", 10, 0.02, ", start_curvature = [0.1, 0.0, 0.0]", duration=4.0, output="time.divide = 1.0\noutput = {checkpoint = 1.0, keep = 9}")
        self.scene.write_text(text)
        self.run_skein("whole", *AUTO)
        number = self.plan(*AUTO)["groups"][0]["automatic_inertia"]["for_dt"]
        self.run_skein("parts", *AUTO, "--set", "time.duration=2")
        self.run_skein("parts", *AUTO)
        self.assertEqual(self.digest("whole"), self.digest("parts"))
        self.run_skein("given", "--set", f"{CHOSEN}={number!r}")
        self.assertEqual(self.digest("whole"), self.digest("given"))
        self.skein_says("verify", self.directory / "whole")
        self.skein_says("branch", self.directory / "whole", self.directory / "branch")

    def test_it_is_refused_where_that_inertia_is_the_physics(self):
        """Options or tables, and the reason."""
        floor = '[[wall]]\nname = "floor"\nkind = "plane"\npoint = [0.0, 0.0, -1.0]\nstiffness = 1e3\n'
        joined = '[[joint]]\nkind = "{kind}"\nbetween = ["rod", "world"]\nat = [1.0, 0.0]\naxis = [0.0, 1.0, 0.0]\nstiffness = 1e5\ntorsional_stiffness = 1.0\n'
        for text, why in (
                (scene("", 20), "free"),
                (scene(shape=", element_spin = [0.0, 0.0, 5.0]"), "spin"),
                (scene("pendulum", shape=", angular_velocity = [0.0, 1.0, 0.0]"), "'angular_velocity' makes its rods turn"),
                (scene(ENDS["clamped"] + '\nstart_motion = {times = [0.0, 1.0], rotation = [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]}'), "half a turn"),
                (scene(shape=", velocity = [0.0, 0.0, 1.0]"), "throws"),
                (scene(more="[contact]\nstiffness = 100.0\n"), "hit each other"),
                (scene(more=floor), "hit wall 'floor'"),
                (scene(more=joined.format(kind="hinge") + "limits = [-0.1, 0.1]\nstop_stiffness = 1.0\n"), "stops"),
                (scene(more=joined.format(kind="hinge") + "break_force = 5.0\n"), "break"),
                (scene(ENDS["clamped"] + '\nstart_motion = {amplitude = [0.0, 0.0, 0.01], period = 0.1}'), "of period 0.1 s drives it"),
                (scene(more='[[load]]\nkind = "muscle_wave"\namplitude = 1e-9\nperiod = 1e3\nwavelength = 0.2\n'), "of wavelength 0.2 m drives it"),
                (scene(more='[[load]]\nkind = "sinusoidal_end_force"\nend = 1e-6\nperiod = 0.5\n'), "of period 0.5 s drives it")):
            with self.subTest(why=why):
                self.scene.write_text(text)
                said = self.skein_says("plan", self.scene, *AUTO, expect=2).stderr
                self.assertIn(why, said)
                self.assertIn("rotary_inertia_for_dt", said)
                self.assertIn("leave the key out", said)
                self.assertNotIn("would take steps", self.plan_text())

    def test_slow_drives_and_loads_are_accepted(self):
        period = 3 / self.frequencies(scene())[0]
        load = '[[load]]\nkind = "{}"\n{}\n'
        for more in (load.format("gravity", ""), load.format("sinusoidal_end_force", f"end = 1e-6\nperiod = {period}"), load.format("end_force", "end = [0.0, 0.0, 1e-6]")):
            self.assertIn("automatic_inertia", self.plan_of(scene(more=more), *AUTO)["groups"][0])

    def test_thick_rods_get_none(self):
        plan = self.plan_of(scene("clamped", 40, 0.05), *AUTO)
        self.assertLess(plan["groups"][0]["automatic_inertia"]["gain"], 1.5)
        self.assertFalse(any("would take steps" in note for note in self.plan_of(scene("clamped", 40, 0.05))["notes"]))


if __name__ == "__main__":
    unittest.main()
