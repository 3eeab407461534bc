"""Rods that touch each other, themselves, a tube, a floor and a lid that goes by its own reckoning: the same bits and restarts as rods alone."""

import unittest

import h5py
import numpy

from driver import SEARCH, STICKS, DriverTest, digest_of, text_digest

LAW = """law = "hertz"
stiffness = 1e5
damping = 10.0
friction = "memory"
static_friction = 0.4
kinetic_friction = 0.2
"""

SCENE = f"""
title = "Contact under a lid"
[time]
duration = 0.4
{STICKS}
[rods.placement]
kind = "packing"
count = 30
seed = 3
region = "cylinder"
radius = 0.08
height = 0.16
[[rods]]
name = "curls"
[rods.material]
density = 1200.0
youngs_modulus = 1e6
[rods.section]
radius = 0.004
[rods.shape]
length = 0.2
elements = 16
rest_curvature = [40.0, 0.0, 8.0]
[rods.placement]
kind = "lattice"
counts = [2, 2]
spacing = [0.05, 0.05]
origin = [-0.025, -0.03, 0.18]
tangent = [0.0, 1.0, 0.0]
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 2.0
[contact]
allow_overlap = true
{LAW}self = true
[[wall]]
name = "side"
kind = "tube"
radius = 0.08
allow_overlap = true
{LAW}
[[wall]]
name = "floor"
kind = "plane"
{LAW}
[[wall]]
name = "lid"
kind = "plane"
point = [0.0, 0.0, 0.24]
normal = [0.0, 0.0, -1.0]
from = 0.02
{LAW}
[wall.servo]
speed = 0.3
approach = 1.0
approach_to = 0.12
watch = "floor"
area = 0.02
turn_back_above = 300.0
turn_forth_below = 100.0
average = 1e-3
[output]
trajectory = 0.05
tips = 0.025
series = 0.0125
checkpoint = 0.05
observables = ["knots", "angular_momentum"]
"""

EARLIER_NAMES = {  # of columns that have been renamed
    "contact_friction_work[J]": "contact_rubbed[J]", "contact_viscous_work[J]": "contact_damped[J]",  # earlier names
    "wall_friction_work[J]": "wall_rubbed[J]", "wall_viscous_work[J]": "wall_damped[J]",  # earlier names
    "max_overlap[-]": "deepest_overlap[-]", "rebuilds[-]": "renewals[-]"}  # earlier names


class Contact(DriverTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(SCENE)

    def test_ranks_threads_and_lanes(self):
        self.run_skein("one")
        series = self.series("one")
        self.assertGreater(series["contacts"].max(), 60)
        self.assertGreater(series["lid_turns"].max(), 2)

        def same(out):
            self.assert_same_series(out, "one")
            self.assert_same_frames(out, "one", "curls")

        self.assert_layouts_give("one", same)
        for ranks, threads, seed in ((1, 2, 1), (2, 2, 7)):
            out = f"shuffled{seed}"
            self.run_skein(out, "--shuffle", str(seed), ranks=ranks, threads=threads)
            self.assertEqual(self.digest(out), self.digest("one"), out)

    def test_output_cadence_leaves_no_trace(self):
        quiet = [f"--set=output.{key}=0" for key in ("trajectory", "tips", "series", "checkpoint")] + ["--set=time.divide=0.0125"]
        self.run_skein("talkative")
        self.run_skein("silent", *quiet)
        self.assertEqual(self.digest("silent"), self.digest("talkative"))

    def test_restart(self):
        """In flight, under the lid as it goes down and as it comes up; springs of friction, the lid and its average go on."""
        self.run_skein("whole")
        self.run_skein("parts", "--steps", "1111")
        self.run_skein("parts", "--until", "0.15", ranks=2)
        self.run_skein("parts", "--until", "0.2", threads=2)
        self.run_skein("parts", ranks=3)
        self.assertEqual(self.digest("parts"), self.digest("whole"))
        self.assert_same_series("parts", "whole", besides=SEARCH)
        self.assert_same_frames("parts", "whole", "curls")

    def checkpoints(self, out):
        return sorted((self.directory / out).glob("checkpoint_*.h5"))

    def test_damaged_memory_is_noticed(self):
        """A flipped bit in the springs of contacts: the file is named, and the run goes on from the one before."""
        self.run_skein("whole", "--until", "0.2")
        self.run_skein("damaged", "--until", "0.15")
        newest = self.checkpoints("damaged")[-1]
        with h5py.File(newest, "r+") as file:
            rows = file["kept/contact_memory_rows"]
            self.assertGreater(len(rows), 20)
            self.assertTrue((numpy.diff(rows[:, 0]) >= 0).all(), "in order of pairs")
            rows[len(rows) // 2, 4] = numpy.nextafter(rows[len(rows) // 2, 4], 1)
        result = self.run_skein("damaged", "--until", "0.2", ranks=2)
        self.assertIn(f"{newest.name}: /kept/contact_memory_rows is damaged", result.stderr)
        self.assertEqual(self.digest("damaged"), self.digest("whole"))

    def test_springs_of_the_format_before_are_refused(self):
        """They were kept without their weight."""
        self.run_skein("old", "--until", "0.15")
        with h5py.File(self.checkpoints("old")[-1], "r+") as file:
            file.attrs["version"] = numpy.int64(3)
        self.assertIn("the format has version 3, which saved contacts, walls or rods in a fluid differently", self.run_skein("old", "--until", "0.2", expect=2).stderr)

    def test_series_of_a_run_that_began_with_an_earlier_program_goes_on(self):
        """Its columns had other names, which its header and the marks of its checkpoints have; a kill may come between the two."""
        self.run_skein("whole", "--until", "0.2")
        for state in ("as it was left", "killed with its columns renamed"):
            out = state.split()[0]
            self.run_skein(out, "--until", "0.15")
            series = self.directory / out / "observables.csv"
            today = series.read_text()
            header, rows = today.split("\n", 1)
            for now, earlier in EARLIER_NAMES.items():
                self.assertIn(now, header)
                header = header.replace(now, earlier)
            text = header + "\n" + rows
            if out == "as":
                series.write_text(text)
            for checkpoint in self.checkpoints(out):
                with h5py.File(checkpoint, "r+") as file:
                    size = int(file.attrs["series_bytes"]) + len(text) - len(today)
                    file.attrs.modify("series_bytes", numpy.uint64(size))
                    file.attrs.modify("series_digest", numpy.uint64(text_digest(text[:size])))
            result = self.run_skein(out, "--until", "0.2", ranks=2)
            self.assertNotIn("observables.csv", result.stderr, state)
            self.assertEqual(self.digest(out), self.digest("whole"), state)
            self.assert_same_series(out, "whole", besides=SEARCH)
            self.assertEqual(self.summary(out)["series_format"], 2)


if __name__ == "__main__":
    unittest.main()
