"""Rods that relax: the end is told, and is the same for any ranks, threads, lanes and restarts; what cannot be relaxed is refused."""

import subprocess
import unittest

from driver import SKEIN, DriverTest

RODS = """
title = "Relaxation"
[time]
duration = {duration}
relax = true
[[rods]]
name = "beams"
start = "clamped"
[rods.material]
density = 1000.0
youngs_modulus = 1e9
[rods.section]
radius = 0.0002
[rods.shape]
length = 1.0
elements = 50
[rods.placement]
kind = "line"
counts = [9]
spacing = [0.1]
[[rods]]
name = "chains"
start = "pinned"
end = "pinned"
[rods.material]
density = 1000.0
youngs_modulus = 1e7
[rods.section]
kind = "elliptic"
radius = 0.01
radius_2 = 0.02
[rods.shape]
length = 1.0
elements = 30
rest_curvature = [2.0, 0.0, 0.0]
[rods.placement]
kind = "line"
counts = [3]
spacing = [0.1]
origin = [0.0, 5.0, 0.0]
tangent = [1.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]
[[load]]
kind = "gravity"
rods = ["chains"]
[[load]]
kind = "end_force"
rods = ["beams"]
end = [1e-6, 2e-6, 0.0]
[output]
checkpoint = 64.0
series = 100.0
"""

CROSSED = """
title = "Two cantilevers that cross, above a floor"
[time]
{time}
[[rods]]
name = "lower"
start = "clamped"
[rods.material]
density = 1000.0
youngs_modulus = 1e7
[rods.section]
radius = 0.01
[rods.shape]
length = 0.5
elements = 20
[rods.placement]
origin = [-0.4, 0.0, 0.06]
tangent = [1.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
[[rods]]
name = "upper"
start = "clamped"
[rods.material]
density = 1000.0
youngs_modulus = 1e7
[rods.section]
radius = 0.01
[rods.shape]
length = 0.5
elements = 20
[rods.placement]
origin = [0.0, -0.4, 0.083]
tangent = [0.0, 1.0, 0.0]
normal = [0.0, 0.0, 1.0]
[[load]]
kind = "gravity"
[contact]
stiffness = 2e3
law = "linear"
damping = 2.0
{friction}
[[wall]]
name = "floor"
kind = "plane"
stiffness = 2e3
law = "linear"
damping = 2.0
{friction}
[output]
series = {series}
{damping}
"""


class Relax(DriverTest):
    def scene_of(self, text, **numbers):
        self.scene.write_text(text.format(**numbers) if numbers else text)

    def test_settles_and_tells(self):
        self.scene_of(RODS, duration=20000.0)
        done = self.run_skein("out")
        self.assertIn("time counts steps", done.stdout)
        self.assertIn("Settled in", done.stdout)
        summary = self.summary("out")
        self.assertTrue(summary["relaxation"]["settled"])
        self.assertTrue(summary["finished"])
        self.assertLessEqual(summary["relaxation"]["correction"], 1e-9)
        self.assertLess(summary["steps"], 5000)
        self.assertEqual(summary["steps"] % 64, 0)
        again = self.run_skein("out")
        self.assertIn("Nothing to do", again.stdout)

    def test_bits_are_those_of_any_layout(self):
        self.scene_of(RODS, duration=20000.0)
        self.run_skein("one")
        self.run_skein("ranks", ranks=3)
        self.run_skein("threads", threads=2)
        self.run_skein("narrow", "--lanes", "1")
        self.run_skein("together", "--protocol", "synchronous")
        for other in ("ranks", "threads", "narrow", "together"):
            self.assertEqual(self.digest(other), self.digest("one"), other)
            self.assertEqual(self.summary(other)["steps"], self.summary("one")["steps"])
            self.assertEqual(self.summary(other)["relaxation"], self.summary("one")["relaxation"])
            self.assert_same_series(other, "one")

    def test_goes_on_after_a_stop(self):
        self.scene_of(RODS, duration=20000.0)
        self.run_skein("whole")
        for steps in (64, 100):  # at a look, and between two
            out = f"parts{steps}"
            self.run_skein(out, "--steps", str(steps))
            self.assertNotIn("Settled", self.run_skein(out, "--steps", str(steps + 30)).stdout)
            self.run_skein(out, ranks=2)
            self.assertEqual(self.digest(out), self.digest("whole"))
            self.assertEqual(self.summary(out)["relaxation"], self.summary("whole")["relaxation"])

    def test_too_few_steps_are_told(self):
        self.scene_of(RODS, duration=50.0)
        text = RODS.format(duration=50.0).replace("checkpoint = 64.0\nseries = 100.0", "checkpoint = 25.0")
        self.scene.write_text(text)
        for ranks in (1, 2):
            done = self.run_skein(f"short{ranks}", ranks=ranks, expect=8)
            self.assertEqual(done.stderr.count("not settled in the 50 steps of time.duration"), 1, done.stderr)
            self.assertNotIn("Settled", done.stdout)
            self.assertFalse(self.summary(f"short{ranks}")["relaxation"]["settled"])
        self.run_skein("short1", expect=8)  # nothing to do, and still not settled

    def test_rods_that_touch_come_to_balance(self):
        """Cantilevers that press each other and a floor end where damped motion ends; with friction in some balance."""
        relax = {"time": "duration = 20000.0\nrelax = true", "series": 64.0, "damping": ""}
        motion = {"time": "duration = 16.0", "series": 1.0, "damping": "[[damping]]\nkind = \"uniform\"\nrate = 15.0"}
        friction = "friction = \"memory\"\nstatic_friction = 0.3"
        ends = {}
        for name, numbers in (("relaxed", relax | {"friction": ""}), ("moved", motion | {"friction": ""}),
                              ("rubbed", relax | {"friction": friction})):
            self.scene_of(CROSSED, **numbers)
            self.run_skein(name)
            ends[name] = self.series(name)[-1]
            if name != "moved":
                self.assertTrue(self.summary(name)["relaxation"]["settled"])
                self.run_skein(name + "2", ranks=2, threads=2)
                self.assertEqual(self.digest(name + "2"), self.digest(name))
                self.run_skein(name + "3", "--steps", "100")
                self.run_skein(name + "3", ranks=2)
                self.assertEqual(self.digest(name + "3"), self.digest(name))
        for column in ("centre_xm", "centre_ym", "centre_zm", "max_overlap", "wall_overlap", "elastic_bendJ"):
            one, other = (ends[name][column] for name in ("relaxed", "moved"))
            self.assertLess(abs(one - other), 1e-6 * max(abs(other), 1e-2), column)
        self.assertGreater(ends["rubbed"]["wall_contacts"], 0)

    def test_motion_begins_at_rest(self):
        self.scene_of(RODS, duration=20000.0)
        self.run_skein("rest")
        at = self.directory / "motion"
        sets = [f"--set={change}" for change in ("time.relax=false", "time.dt=auto", "time.duration=5e-4", "start.time=zero",
                                                 "output.series=1e-4", "output.checkpoint=0")]
        for command in (["branch", str(self.directory / "rest"), str(at), *sets], ["run", str(at), "-q", "--threads", "1"]):
            done = subprocess.run([SKEIN, *command], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rest, motion = self.series("rest")[-1], self.series("motion")
        for name in ("centre_xm", "centre_ym", "centre_zm"):
            self.assertLess(abs(motion[name] - rest[name]).max(), 1e-9, name)
        self.assertLess(motion["kinetic_translationJ"].max(), 1e-9 * motion["elastic_bendJ"].max())

    def test_what_changes_with_time_is_refused(self):
        self.scene_of(RODS, duration=100.0)
        for change, words in (("time.dt=0.1", "'dt' has no use"), ("rods.beams.shape.velocity=[1,0,0]", "begins at rest"),
                              ("load.end_force.ramp=0.5", "'ramp' [s]"), ("rods.beams.material.rotary_inertia_scale=10", "leave it out"),
                              ("output.audit=true", "no audit")):
            done = subprocess.run([SKEIN, "check", str(self.scene), "--set", change], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, change + done.stdout)
            self.assertIn(words, done.stderr + done.stdout)


if __name__ == "__main__":
    unittest.main()
