"""Runs that begin with the state of another one: `skein branch`, start.from, changed keys, ancestry."""

import json
import re
import shutil
import unittest

import h5py
import numpy

from contact_test import SCENE as CONTACT_SCENE
from driver import SCENE, DriverTest

# Held at one end, curved, let go under its weight; its fastest modes, which no step resolves, die out.
SWING = """
[time]
duration = 0.16
dt = {dt}
[[rods]]
name = "arm"
start = "clamped"
[rods.material]
density = 1200.0
youngs_modulus = 1e6
[rods.section]
kind = "{section}"
radius = 0.006
{radius_2}
[rods.shape]
length = 0.2
elements = 8
rest_curvature = [2.0, 1.0, 3.0]
[rods.placement]
tangent = [1.0, 0.0, 0.0]
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 30.0
[output]
trajectory = 0.16
precision = "double"
checkpoint = 0.08
"""


class BranchTest(DriverTest):
    def branch(self, start, new, *arguments, ranks=1, expect=0):
        return self.skein_says("branch", self.directory / start, self.directory / new, *arguments, ranks=ranks, expect=expect)

    def go_on(self, directory, *arguments, ranks=1, expect=0):
        return self.skein_says("run", self.directory / directory, "--threads", "1", *arguments, ranks=ranks, expect=expect)

    def newest(self, directory):
        return sorted((self.directory / directory).glob("checkpoint_*.h5"))[-1]

    def step_of(self, checkpoint):
        return int(checkpoint.stem.split("_")[1])


class Branch(BranchTest):
    def test_without_changes_it_is_the_same_run(self):
        self.run_skein("whole")
        self.run_skein("first", "--until", "7.2")
        step = self.step_of(self.newest("first"))
        for ranks, start in ((1, f"first@{step}"), (2, "first")):
            new = f"second{ranks}"
            self.assertIn(f"begins with step {step}", self.branch(start, new, ranks=ranks).stdout)
            self.go_on(new, ranks=ranks)
            self.assertEqual(self.digest(new), self.digest("whole"))
            mine, theirs = self.frames(new, "tips"), self.frames("whole", "tips")
            late = theirs["step"] >= step  # it begins with the frame of its first step
            self.assertTrue(late.any())
            self.assertTrue(numpy.array_equal(mine["groups/cilia/position"], theirs["groups/cilia/position"][late]))
            self.assertTrue(numpy.array_equal(mine["time"], theirs["time"][late]))

    def test_ancestry_is_kept(self):
        self.run_skein("first", "--until", "3.6")
        step = self.step_of(self.newest("first"))
        with h5py.File(self.newest("first")) as file:
            digest = f"{int(file.attrs['digest']):016x}"
        self.branch("first", "second", "--set", "damping.0.rate=0.7")
        self.go_on("second", "--until", "7.2")
        with h5py.File(self.newest("second")) as file:
            kept = file.attrs["ancestry"].decode() if isinstance(file.attrs["ancestry"], bytes) else str(file.attrs["ancestry"])
        for ancestry in (json.loads(kept), self.summary("second")["ancestry"],
                         json.loads((self.directory / "second" / "physics.json").read_text())["ancestry"]):
            self.assertEqual((ancestry["step"], ancestry["digest"]), (step, digest))
            self.assertTrue(ancestry["parent"].endswith("first"))
            self.assertEqual(ancestry["changes"], [{"key": "damping.0.rate", "was": "0.5", "now": "0.7"}])
        # A branch of a branch keeps both; the parent is no longer needed once a branch has begun.
        self.branch("second", "third")
        shutil.rmtree(self.directory / "first")
        self.go_on("second", "--until", "9")
        self.go_on("third", "--until", "9")
        self.assertEqual(self.digest("third"), self.digest("second"))
        self.assertEqual(self.summary("third")["ancestry"]["ancestry"]["digest"], digest)

    def test_start_from_in_a_scene(self):
        self.run_skein("whole")
        self.run_skein("first", "--until", "7.2")
        step = self.step_of(self.newest("first"))
        self.scene.write_text(f"start.from = 'first@{step}'\n" + SCENE)
        self.run_skein("second", ranks=2)
        self.assertEqual(self.digest("second"), self.digest("whole"))
        self.scene.write_text("start.from = 'first'\nstart.time = 'zero'\n" + SCENE)
        self.run_skein("anew", "--until", "1.8")
        self.assertAlmostEqual(self.summary("anew")["time_s"], 1.8, delta=1e-12)
        first = self.frames("anew", "trajectory")
        self.assertEqual((first["step"][0], first["time"][0]), (0, 0.0))
        whole = self.frames("whole", "trajectory")
        at = list(whole["step"]).index(step)
        apart = numpy.abs(first["groups/cilia/position"][0] - whole["groups/cilia/position"][at]).max()
        self.assertLess(apart, 1e-6)  # single precision, but the same place
        self.scene.write_text("start.time = 'zero'\n" + SCENE)
        self.assertIn("without 'from'", self.run_skein("none", expect=2).stderr)
        self.scene.write_text("start.from = 'first@x'\n" + SCENE)
        self.assertIn("DIRECTORY@STEP", self.run_skein("none", expect=2).stderr)
        self.scene.write_text("start.from = 'first@7'\n" + SCENE)
        self.assertIn(f"{step}", self.run_skein("none", expect=2).stderr)

    def test_what_may_not_change(self):
        self.run_skein("first", "--until", "3.6")
        for change, key in (("rods.cilia.section.radius=0.16", "rods.0.section.radius: was 0.15, now 0.16"),
                            ("rods.cilia.shape.elements=11", "rods.0.shape.elements: was 10, now 11"),
                            ("rods.cilia.placement.counts=[5,4]", "rods.0.placement.counts.1: was 5, now 4"),
                            ("rods.leaning.shape.length=1.5", "rods.1.shape.length: was 1.0, now 1.5"),
                            ("rods.leaning.section.taper=0.5", "rods.1.section.taper: was 0.6, now 0.5")):
            done = self.branch("first", "second", "--set", change, expect=2)
            self.assertIn(key, done.stderr)
            self.assertFalse((self.directory / "second").exists())
        # A scene with start.from is refused alike.
        self.scene.write_text("start.from = 'first'\n" + SCENE)
        self.assertIn("rods.0.section.radius", self.run_skein("third", "--set", "rods.cilia.section.radius=0.16", expect=2).stderr)
        self.assertIn("beyond the stable limit", self.branch("first", "second", "--set", "time.dt=0.5", expect=2).stderr)
        self.assertIn("no checkpoint of that step", self.branch("first@1", "second", expect=2).stderr)
        self.assertIn("is over", self.run_skein("third", "--set", "time.duration=3.6", expect=2).stderr)
        (self.directory / "second").mkdir()
        (self.directory / "second" / "thesis.txt").write_text("mine")
        self.assertIn("exists already", self.branch("first", "second", expect=5).stderr)
        self.assertEqual([path.name for path in (self.directory / "second").iterdir()], ["thesis.txt"])

    def test_outputs_fall_on_the_same_times(self):
        self.run_skein("first", "--steps", "1003")
        began = self.summary("first")["time_s"]
        dt = 0.36 / 1478
        self.branch("first", "second", "--set", f"time.dt={dt}")
        self.go_on("second", "--until", "7.2")
        with h5py.File(self.newest("second")) as file:
            shift = file.attrs["shift"]
        self.assertGreater(abs(shift), 1e-3 * dt)
        self.assertAlmostEqual((began - shift) / dt, round((began - shift) / dt), delta=1e-6)
        self.assertAlmostEqual(self.summary("second")["time_s"], 7.2 + shift, delta=1e-9)
        times = self.frames("second", "tips")["time"]
        self.assertLess(numpy.abs(times - shift - 0.36 * numpy.arange(2, 21)).max(), 1e-9)

    def test_contact_memory_walls_and_audit(self):
        scene = CONTACT_SCENE.replace('observables = ["knots", "angular_momentum"]', "audit = true")
        self.scene.write_text(scene)
        self.run_skein("whole")
        self.run_skein("first", "--until", "0.2", ranks=2)
        for ranks in (1, 2):
            new = f"second{ranks}"
            self.branch("first", new)
            self.go_on(new, ranks=ranks)
            self.assertEqual(self.digest(new), self.digest("whole"))
            mine, theirs = (self.summary(out)["observables"] for out in (new, "whole"))
            for name in ("lid_height[m]", "lid_work[J]", "lid_turns[-]", "work_loads[J]", "dissipated[J]"):
                self.assertEqual(mine[name], theirs[name], name)
        self.branch("first", "harder", "--set", "wall.lid.servo.turn_back_above=400", "--set", "contact.kinetic_friction=0.3", "--set", "time.dt=4e-5")
        self.go_on("harder", ranks=2)
        self.assertIn("wall.2.point", self.branch("first", "other", "--set", "wall.lid.point=[0, 0, 0.3]", expect=2).stderr)


class Order(BranchTest):
    """A step that changes half-way leaves the scheme at its order, as positions are moved to where the new step has them."""

    def end_of(self, out):
        return self.frames(out, "trajectory")["groups/arm/position"][-1]

    def run_at(self, section, dt):
        radius_2 = "radius_2 = 0.004" if section == "elliptic" else ""
        self.scene.write_text(SWING.format(dt=dt, section=section, radius_2=radius_2))
        self.run_skein(f"{section}_{dt}")
        return f"{section}_{dt}"

    def test_second_order(self):
        coarse = 8e-5
        for section in ("circular", "elliptic"):
            reference = self.end_of(self.run_at(section, coarse / 64))
            errors = []
            for dt in (coarse, coarse / 2, coarse / 4):
                parent = self.run_at(section, dt)
                new = f"{parent}_half"
                self.branch(f"{parent}@{round(0.08 / dt)}", new, "--set", f"time.dt={dt / 2}")
                self.go_on(new)
                self.assertEqual(self.summary(new)["steps"], round(0.16 / (dt / 2)))
                errors.append(numpy.abs(self.end_of(new) - reference).max())
            # From the first to the last: the fastest modes, which no step resolves, make single ones uneven. As it stands, the state
            # of the parent would give order 1 and errors of 6e-6.
            order = numpy.log2(errors[0] / errors[-1]) / 2
            self.assertGreater(order, 1.7, f"{section}: {errors}")
            self.assertLess(errors[0], 1e-8)

    def test_another_integrator(self):
        dt = 8e-5
        reference = self.end_of(self.run_at("circular", dt / 16))
        parent = self.run_at("circular", dt)
        alone = numpy.abs(self.end_of(parent) - reference).max()
        self.branch(f"{parent}@{round(0.08 / dt)}", "fourth", "--set", "time.integrator=pefrl")
        self.go_on("fourth")
        self.assertLess(numpy.abs(self.end_of("fourth") - reference).max(), alone)


if __name__ == "__main__":
    unittest.main()
