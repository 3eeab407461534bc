"""The step in which a fluid and rods that feel it exchange momentum: it follows from what the scene states and from slips in the run, whatever is
written, and what ends a run names the key that helps."""

import unittest

from driver import FLUID_OF_RODS, DriverTest, rods_in_a_fluid

WORM = """
title = "worm in a box"
[time]
duration = 2.0
[fluid]
cells = [64, 32, 32]
spacing = 0.04
density = 1.0
viscosity = 0.002
along_x = "free_slip"
along_y = "free_slip"
along_z = "free_slip"
[[rods]]
name = "worm"
material = {density = 1.0, youngs_modulus = 3e4}
section = {radius = 0.05}
shape = {length = 1.0, elements = 32}
placement = {origin = [0.8, 0.64, 0.64], tangent = [1.0, 0.0, 0.0]}
[constants]
T = {value = 1.0, unit = "s"}
[output]
series = 0.05
"""
MUSCLE = """
[[load]]
kind = "muscle_formula"
curvature = ["0", "RAMP*4*sin(2*pi*(s/L - t/T))", "0"]
"""
RAMPED, ABRUPT = (WORM + MUSCLE.replace("RAMP*", ramp) for ramp in ("min(t/T,1)*", ""))
THROWN = """
title = "rods and a fluid"
[time]
duration = 0.06
""" + FLUID_OF_RODS + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0]) + """
[output]
series = 0.02
checkpoint = 0.02
"""
COARSE = ["--set", "fluid.cells=[32,16,16]", "--set", "fluid.spacing=0.08"]  # where no figure of the motion is looked at


class Exchange(DriverTest):
    def test_a_ramped_wave_swims_equally_far_whatever_the_settings(self):
        """A second of two; at e5abb03 25 % apart."""
        self.scene.write_text(RAMPED)
        far = {}
        for name, keys in {"none": [], "expected": ["fluid.expected_speed=6"], "rows": ["output.series=0.25"]}.items():
            self.run_skein(name, "--until", "1.0", *(word for key in keys for word in ("--set", key)))
            series = self.series(name)
            far[name] = abs(series["centre_xm"][-1] - series["centre_xm"][0])
        self.assertLess(max(far.values()), 1.03 * min(far.values()), far)

    def test_slips_shorten_steps_alike_on_any_ranks_and_threads_and_after_a_stop(self):
        self.scene.write_text(THROWN)
        self.run_skein("one")
        plan = self.plan()
        self.assertGreater(self.series("one")["fluid_steps"][-1], 1.5 * plan["steps"] / plan["fluid"]["meets_rods_every"])
        self.run_skein("ranks", ranks=3)
        self.run_skein("threads", threads=2)
        self.run_skein("parts", "--until", "0.03", ranks=2)
        self.assertIn("Resuming from", self.run_skein("parts").stdout)
        for out in ("ranks", "threads", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)

    def test_the_plan_names_what_moves_first(self):
        for scene, keys, by in ((ABRUPT, [], "the curvature of 'worm' that begins at t = 0"), (RAMPED, [], "the muscles of 'worm'"),
                                (WORM, ["rods.worm.shape.velocity=[20,0,0]"], "the velocity at the start of 'worm'"),
                                (ABRUPT, ["fluid.expected_speed=3"], "the curvature of 'worm' that begins at t = 0"),
                                (RAMPED, ["fluid.expected_speed=3"], "fluid.expected_speed")):
            self.scene.write_text(scene)
            fluid = self.plan(*(word for key in keys for word in ("--set", key)))["fluid"]
            self.assertEqual(fluid["speed_by"], by)
        self.scene.write_text(ABRUPT)
        self.assertIn("differ from the shape at t = 0", self.plan_text())

    def test_a_rod_that_begins_fast_runs(self):
        self.scene.write_text(WORM)
        self.run_skein("fast", *COARSE, "--set", "rods.worm.shape.velocity=[0,20,0]", "--until", "0.002")

    def test_what_outputs_ask_for_does_not_set_the_step_of_the_fluid(self):
        self.scene.write_text(RAMPED)
        steps = {self.plan("--set", f"output.series={interval}", "--set", "time.dt=2e-5")["fluid"]["meets_rods_every"] for interval in (0.001, 0.05, 2.0)}
        self.assertEqual(len(steps), 1, steps)

    def test_large_slip_at_the_end_is_a_warning(self):
        self.scene.write_text(RAMPED)
        errors = self.run_skein("slips", *COARSE, "-q", "--set", "fluid.largest_slip=1e-5", "--set", "time.dt=5e-5", "--until", "0.1").stderr
        self.assertIn("warning: velocities of fluid and rods differ by", errors)
        self.assertIn("time.dt", errors)
        slip = self.summary("slips")["slip"]
        self.assertGreater(slip["share"], slip["allowed"])
        self.assertIn(slip["warning"], errors)


if __name__ == "__main__":
    unittest.main()
