"""A run that blows up says where it began, whatever the ranks, and what would have held; and goes on from there."""

import re
import shlex
import subprocess
import unittest

import h5py
import numpy

from branch_test import BranchTest
from contact_test import LAW
from driver import MPIRUN, SCENE, SKEIN

# A rod that is torn at its end, at a step of its own.
TORN = """
[[rods]]
name = "torn"
end = "clamped"
start = "clamped"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.05
[rods.shape]
length = 1.0
elements = 6
[rods.placement]
origin = [0.0, 20.0, 0.0]
[rods.end_motion]
times = [0.0, {before}, {after}]
translation = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 9.0]]
"""

# Balls of steel-hard contact, one of which is shot into the other so fast that it is through within a step.
SHOT = f"""
[time]
duration = 0.02
dt = 2e-5
force_dt = true
[[rods]]
name = "target"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.005
[rods.shape]
length = 0.1
elements = 6
[[rods]]
name = "bullet"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.005
[rods.shape]
length = 0.1
elements = 6
velocity = [0.0, 60.0, 0.0]
[rods.placement]
origin = [0.005, -0.12, 0.05]
tangent = [1.0, 0.0, 0.3]
[contact]
{LAW.replace("1e5", "1e9")}
[output]
checkpoint = 0.001
"""


def told_step(text):
    return int(re.search(r"at step (\d+)", text)[1])


def first_line(done):
    return re.search(r"error: (.*)", done.stderr)[1].split(" (t =")[0]


class Failure(BranchTest):
    def oracle(self, fails_with, **layout):
        """The first step that a run to it is refused at, by bisection over runs that look at their last step alone."""
        good, bad = fails_with
        while bad - good > 1:
            middle = (good + bad) // 2
            out = f"oracle{middle}"
            done = subprocess.run(self.command(out, "--steps", str(middle), "--rewind", "never", "--no-checkpoint"), capture_output=True, text=True, timeout=100)
            self.assertIn(done.returncode, (0, 4), done.stderr)
            if done.returncode == 4:
                bad, message = middle, done
            else:
                good = middle
        return bad, message

    def test_a_field_switched_on_at_some_step(self):
        for rods, step in (("", 1280 + 37), ('rods = ["cilia"]', 1280 + 5)):
            scene = SCENE.replace('period = 7.2\n', f'period = 7.2\n{rods}\n')
            self.scene.write_text(scene)
            parent = f"first{step}"
            self.run_skein(parent, "--steps", str(step))
            self.scene.write_text(f"start.from = '{parent}@{step}'\n" + scene)
            strong = ("--set", "load.magnetic_field.rotating=1e3")
            done = {}
            for ranks in (1, 2, 3):
                done[ranks] = self.run_skein(f"strong{step}_{ranks}", *strong, ranks=ranks, expect=4)
            self.assertEqual(first_line(done[1]), first_line(done[2]))
            self.assertEqual(first_line(done[1]), first_line(done[3]))
            found = told_step(done[1].stderr)
            for until, code in ((found - 1, 0), (found, 4)):
                checked = self.run_skein(f"checked{step}_{until}", *strong, "--steps", str(until), "--rewind", "never", expect=code)
            # Rods of one phase of the field fail together: which of them a look names, to round-off, is not of interest.
            what = [first_line(run).split(" at step")[0].partition(", ")[2] for run in (checked, done[1])]
            self.assertEqual(what[0], what[1])
            for text in ("of 'cilia'", "pass 'magnetic_field'", "time.dt = "):
                self.assertIn(text, done[1].stderr)

    def test_one_rod_that_is_torn(self):
        self.scene.write_text(SCENE)
        dt = 0.36 / round(0.36 / self.dt_of_the_plan())
        at = 1280 + 21
        self.scene.write_text(SCENE.replace("duration = 14.4\n", f"duration = 14.4\ndt = {dt}\n") + "" + TORN.format(before=at * dt, after=(at + 1) * dt))
        failed = {ranks: self.run_skein(f"torn{ranks}", ranks=ranks, expect=4) for ranks in (1, 2)}
        self.assertEqual(first_line(failed[1]), first_line(failed[2]))
        self.assertIn("rod 0 of 'torn', element 5", failed[1].stderr)
        self.assertIn("a shorter step does not help", failed[1].stderr)  # the end is 54 lengths of an element away
        self.assertNotIn("time.dt=", failed[1].stderr)
        step, message = self.oracle((at - 10, at + 60))
        self.assertEqual(told_step(failed[1].stderr), step)
        self.assertIn("rod 0 of 'torn', element 5", message.stderr)
        for ranks in (1, 2):
            with h5py.File(self.directory / f"torn{ranks}" / "failure.h5") as file:
                self.assertEqual(list(file["step"]), [step])
                self.assertEqual(file["groups/torn/position"].shape, (1, 1, 7, 3))
                self.assertEqual(file["groups/cilia/directors"].shape, (1, 25, 10, 3, 3))
                self.assertGreater(file["groups/torn/position"][0, 0, -1, 2], 1.5)
                self.assertTrue(numpy.array_equal(file["groups/cilia/frames/0/position"][:], file["groups/cilia/position"][0]))
            self.assertTrue((self.directory / f"torn{ranks}" / "failure.xdmf").exists())
            self.assertFalse(list((self.directory / f"torn{ranks}").glob("*.tmp")))
        with h5py.File(self.directory / "torn1" / "failure.h5") as one, h5py.File(self.directory / "torn2" / "failure.h5") as two:
            for group in ("cilia", "leaning", "torn"):
                self.assertTrue(numpy.array_equal(one[f"groups/{group}/position"][:], two[f"groups/{group}/position"][:]))

    def test_a_failure_whose_frame_cannot_be_written_is_still_told(self):
        self.scene.write_text(SCENE)
        dt = 0.36 / round(0.36 / self.dt_of_the_plan())
        at = 1280 + 21
        self.scene.write_text(SCENE.replace("duration = 14.4\n", f"duration = 14.4\ndt = {dt}\n") + TORN.format(before=at * dt, after=(at + 1) * dt))
        self.run_skein("torn", "--steps", "1280")
        (self.directory / "torn" / "failure.xdmf").mkdir()  # in the way of the side-car
        failed = self.run_skein("torn", expect=4)
        for text in ("rod 0 of 'torn', element 5", "failure.h5 was not written", "the last good checkpoint is of step 1280"):
            self.assertIn(text, failed.stderr)
        self.assertEqual([path.name for path in (self.directory / "torn").glob("checkpoint_*")], ["checkpoint_000000001280.h5"])

    def dt_of_the_plan(self):
        plan = subprocess.run([SKEIN, "check", str(self.scene)], capture_output=True, text=True, timeout=60).stdout
        return float(re.search(r"steps of (\S+) s", plan)[1])

    def test_the_command_that_is_proposed_works(self):
        self.run_skein("first", "--until", "3.6")
        step = self.step_of(self.newest("first"))
        self.scene.write_text(f"start.from = 'first@{step}'\n" + SCENE)
        limit = float(re.search(r"of the limit (\S+) s", self.run_skein("plan", "--steps", "1").stdout)[1])
        failed = self.run_skein("strong", "--set", f"time.dt={1.02 * limit}", "--set", "time.force_dt=true", "--set", "time.duration=4", expect=4)
        self.assertIn("it was tried", failed.stderr)
        command = shlex.split(re.search(r"^ *(skein branch .*)$", failed.stderr, re.M)[1])
        done = subprocess.run([MPIRUN, "-n", "1", SKEIN, *command[1:]], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("time.dt", done.stdout)
        self.go_on("strong_2", ranks=2)
        self.assertTrue(self.summary("strong_2")["finished"])

    def test_who_touched_it(self):
        self.scene.write_text(SHOT)
        done = {ranks: self.run_skein(f"shot{ranks}", ranks=ranks, expect=4) for ranks in (1, 2)}
        self.scene.write_text(SHOT.replace("[rods.placement]\norigin = [0.005, -0.12, 0.05]", '[rods.placement]\nkind = "list"\norigins = [[0.005, -0.12, 0.05]]'))
        done["moved"] = self.run_skein("moved", "--balance", "always", ranks=2, expect=4)
        self.assertEqual(first_line(done[1]), first_line(done[2]))
        self.assertEqual(first_line(done[1]), first_line(done["moved"]))
        for ranks in (1, 2, "moved"):
            self.assertRegex(done[ranks].stderr, "touched: at step \\d+ its element \\d and element \\d of rod 0 of '(bullet|target)' press each other")
            self.assertIn("pass 'neighbour loads'", done[ranks].stderr)
            self.assertEqual(re.search("touched: .*", done[1].stderr)[0], re.search("touched: .*", done[ranks].stderr)[0])

    def test_a_copy_leaves_no_trace(self):
        self.run_skein("with", "--rewind", "always")
        self.run_skein("without", "--rewind", "never")
        self.assertEqual(self.results("with"), self.results("without"))


if __name__ == "__main__":
    unittest.main()
