"""Ranks that are killed, stopped, left without memory or without rods: all end or all go on, and the end has the bits of a run that met with nothing."""

import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import time
import unittest

from driver import MPIRUN, SKEIN
from faults import ALL, FREE, TOUCHING, FaultTest
from restart_test import ranks_of

# As TOUCHING, but nothing holds the rods together.
LOOSE = re.sub(r"(?ms)^\[\[wall\]\].*?(?=^\[output\])", "", TOUCHING)
FEW_FILES = ("--set", "output.trajectory=0", "--set", "output.tips=0")


def resident(pid, key):
    """VmSize, VmRSS, ... of a process, bytes."""
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return 1024 * int(line.split()[1])
    raise KeyError(key)


class Ranks(FaultTest):
    """In runs of seconds on fast machines too, so that each meets with its fault before the end."""

    SCENE = TOUCHING.replace("duration = 0.4", "duration = 1.2")
    KEYS = (*FEW_FILES, "--set", "output.checkpoint=0", "--set", "output.checkpoint_wall=0.1")

    def wait_for(self, condition, run):
        end = time.monotonic() + 60
        while not condition() and run.poll() is None and time.monotonic() < end:
            time.sleep(0.005)
        self.assertIsNone(run.poll(), "the run ended before it met with the fault")
        self.assertTrue(condition())

    def running(self, out, ranks, *arguments):
        """A run on so many ranks that has written a checkpoint, and its processes."""
        run = self.start(out, *arguments, ranks=ranks)
        self.wait_for(lambda: len(ranks_of(run)) == ranks and self.checkpoints(out), run)
        return run, ranks_of(run)

    def resume(self, out, ranks, *arguments):
        told = self.run_to_end(out, *arguments, ranks=ranks)[0]
        self.assertIn("Resuming from", told)
        self.assertEqual(self.digest(out), self.digest("whole"))
        self.assertTrue(self.summary(out)["finished"])
        self.assertFalse(list((self.directory / out).glob("*.tmp")))

    def test_a_killed_rank_ends_all(self):
        self.run_to_end("whole")
        for ranks in (2, 4):
            for victim in range(ranks) if ALL else (0, ranks - 1):
                out = f"killed_{ranks}_{victim}"
                run, processes = self.running(out, ranks)
                os.kill(processes[victim], signal.SIGKILL)
                began = time.monotonic()
                self.assertNotEqual(self.end_of(run)[0], 0)
                self.assertLess(time.monotonic() - began, 10, "mpirun hung after a rank was killed")
                self.assertFalse([pid for pid in processes if pathlib.Path(f"/proc/{pid}/exe").exists()], "a rank goes on alone")
                self.assertFalse((self.directory / out / "summary.json").exists())
                self.resume(out, self.draw.choice((1, 2, 3, 4)))

    def test_a_rank_that_sleeps_changes_nothing(self):
        self.run_to_end("whole")
        for ranks in (2, 3):
            out = f"slept_{ranks}"
            run, processes = self.running(out, ranks)
            for victim in processes:
                os.kill(victim, signal.SIGSTOP)
                time.sleep(5 if ALL else 0.5)
                self.assertIsNone(run.poll())
                os.kill(victim, signal.SIGCONT)
            self.assertEqual(self.end_of(run)[0], 0)
            self.assertEqual(self.digest(out), self.digest("whole"))

    def test_a_rank_without_memory_ends_all(self):
        """Its limit falls to what it has while it runs."""
        self.scene.write_text(FREE.replace("counts = [5, 5]", "counts = [60, 60]"))
        keys = ("--steps", "4000", "--set", "output.series=0")
        self.run_to_end("whole", *keys)
        ended = 0
        for ranks, victim in ((2, 1), (2, 0), (3, 1)) * (7 if ALL else 1):
            shutil.rmtree(self.directory / "starved", ignore_errors=True)
            run, processes = self.running("starved", ranks, *keys)
            most = resident(processes[victim], "VmSize")
            resource.prlimit(processes[victim], resource.RLIMIT_AS, (most, most))
            code, told, errors = self.end_of(run)
            if code != 0:  # otherwise what it had was enough
                ended += 1
                self.assertIn("memory", errors)
                self.assertRegex(errors, rf"rank {victim}\b", "the rank is not named")
                self.run_to_end("starved", *keys)
            self.assertEqual(self.digest("starved"), self.digest("whole"))
        self.assertGreater(ended, 0)

    def test_too_little_memory_for_one_rank_from_the_start(self):
        """Refused before rods are made, where the rank's limit is below what the plan says."""
        self.scene.write_text(FREE)
        run = [SKEIN, "run", str(self.scene), "--out", str(self.directory / "small"), "--threads", "1", "--set", "rods.0.placement.counts=[1500, 1500]"]
        for limited in (0, 1):
            parts = [["-n", "1", *(["prlimit", f"--as={600 << 20}"] if rank == limited else []), *run] for rank in (0, 1)]
            starved = subprocess.Popen([MPIRUN, *parts[0], ":", *parts[1]], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            code, told, errors = self.end_of(starved)
            self.assertNotEqual(code, 0, told + errors)
            self.assertRegex(errors, "needs [0-9.e+]+ GB .* GB are free|rank [01].*memory")
            self.assertFalse((self.directory / "small").exists())

    def same_on(self, name, ranks, *keys):
        self.run_to_end(f"{name}_1", *keys)
        for count in ranks:
            out = f"{name}_{count}"
            self.run_to_end(out, *keys, ranks=count)
            self.assertEqual(self.digest(out), self.digest(f"{name}_1"), out)
            self.assertEqual(self.summary(out)["rods"], self.summary(f"{name}_1")["rods"])

    def test_more_ranks_than_rods(self):
        for name, sticks, curls in (("two", 1, "[1, 1]"), ("five", 3, "[2, 1]")):
            self.same_on(name, (3, 8), "--set", f"rods.0.placement.count={sticks}", "--set", f"rods.1.placement.counts={curls}", "--steps", "250")

    def test_rods_in_one_corner(self):
        """All rods lie together but some, which are far away; or one is longer than the room that all others take."""
        self.scene.write_text(LOOSE)
        self.same_on("far", (2, 4, 8), "--set", "rods.1.placement.origin=[1e4, -1e4, 1e4]", "--steps", "250")
        self.same_on("long", (2, 4, 8), "--set", "rods.1.placement.counts=[1, 1]", "--set", "rods.1.shape.length=4", "--set", "rods.1.shape.elements=60",
                     "--set", "rods.1.shape.rest_curvature=[0.0, 0.0, 0.0]", "--steps", "250")

    def test_rods_that_fly_apart(self):
        """None is lost, whichever rank has it."""
        self.scene.write_text(LOOSE)
        self.same_on("fast", (2, 3), "--set", "rods.0.shape.velocity=[300.0, -200.0, 100.0]", "--steps", "1000")

    def test_places_that_are_none(self):
        self.scene.write_text(LOOSE)
        for ranks in (1, 2):
            for place, codes in (("inf", (2,)), ("1e300", (2, 4)), ("1e30", (0, 2, 4))):
                code, told, errors = self.end_of(self.start("nowhere", "--set", f"rods.1.placement.origin=[0.0, {place}, 0.0]", "--steps", "200", "--overwrite", ranks=ranks))
                self.assertIn(code, codes, told + errors)
                self.assertTrue(code == 0 or "error: " in errors, errors)


if __name__ == "__main__":
    unittest.main()
