"""Checkpoints that are being written when a run is killed or its disk is full; places where nothing can be written; logs on a full disk."""

import contextlib
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import time
import unittest

from faults import ALL, FREE, FaultTest
from restart_test import ranks_of


class Disk(FaultTest):
    SCENE = FREE.replace("counts = [5, 5]", "counts = [40, 40]")  # 1.8 MB of state, a checkpoint takes some 10 ms
    KEYS = ("--set", "output.trajectory=0", "--set", "output.tips=0", "--set", "output.series=0.36", "--set", "output.checkpoint=0", "--set", "output.checkpoint_wall=0.03", "--set", "output.milestones=false",
            "--set", "time.duration=3.6")

    def test_kill_9_while_a_checkpoint_is_written(self):
        """Again and again, at random moments after its temporary file appears; what is resumed is always whole, and progress is made."""
        self.run_to_end("whole")
        unfinished, last, kills = 0, 0, 20 if ALL else 6
        for _ in range(kills):
            ranks = self.draw.choice((1, 2))
            run = self.start("killed", ranks=ranks)
            writing = lambda: list((self.directory / "killed").glob("checkpoint_*.tmp"))
            before = self.checkpoints("killed")
            end = time.monotonic() + 60
            while not (writing() and self.checkpoints("killed")[-1:] != before[-1:]) and run.poll() is None and time.monotonic() < end:
                pass  # a checkpoint is written in a few ms
            time.sleep(self.draw.uniform(0, 0.02))
            if run.poll() is None:
                for process in ranks_of(run) if ranks > 1 else [run.pid]:
                    os.kill(process, signal.SIGKILL)
            code, told, errors = self.end_of(run)
            unfinished += bool(writing())
            if code == 0:  # so fast that it came to its end
                break
            newest = int(self.checkpoints("killed")[-1].stem[11:])
            self.assertGreater(newest, last, "the run began anew")
            self.assertNotIn("warning: " + str(self.directory), errors)
            last = newest
        told, errors = self.run_to_end("killed")
        self.assertNotIn("damaged", errors)
        self.assertEqual(self.digest("killed"), self.digest("whole"))
        self.assertEqual((self.directory / "killed/observables.csv").read_bytes(), (self.directory / "whole/observables.csv").read_bytes())
        self.assertFalse(writing())
        print(f"{kills} kills, {unfinished} of which left an unfinished checkpoint")

    def test_a_disk_that_is_full_at_a_checkpoint(self):
        """As a limit on the size of files has it."""
        self.run_to_end("whole")
        run = self.start("limited")
        end = time.monotonic() + 60
        while not self.checkpoints("limited") and time.monotonic() < end:
            time.sleep(0.005)
        self.assertIsNone(run.poll())
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (1 << 20, 1 << 20))
        self.assert_kept("limited", *self.end_of(run))

    def test_a_small_disk(self):
        disk = self.directory / "disk"
        disk.mkdir()
        made = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=12m", "tmpfs", str(disk)], capture_output=True, text=True)
        if made.returncode != 0:
            self.skipTest("no disk can be mounted here: " + made.stderr.strip())
        self.run_to_end("whole")
        run = self.start("disk/out", ranks=2)
        try:
            end = time.monotonic() + 60
            while not self.checkpoints("disk/out") and time.monotonic() < end:
                time.sleep(0.005)
            self.assertIsNone(run.poll())
            free = os.statvfs(disk)
            with contextlib.suppress(OSError):  # a checkpoint that is written meanwhile takes some of it: full is full
                (disk / "other").write_bytes(bytes(max(0, free.f_bavail * free.f_frsize - (1 << 20))))
            ended = self.end_of(run)
            (disk / "other").unlink()
            self.assert_kept("disk/out", *ended)
        finally:
            run.kill()
            subprocess.run(["umount", "--lazy", str(disk)], check=True)

    def assert_kept(self, out, code, told, errors):
        self.assertEqual(code, 5, told + errors)
        self.assertRegex(errors, r"error: .*(checkpoint_\d+\.h5|disk full: .*B needed, .*B available)")
        self.assertFalse(list((self.directory / out).glob("*.tmp")))
        self.assertTrue(self.checkpoints(out))
        told, errors = self.run_to_end(out)
        self.assertIn(f"Resuming from", told)
        self.assertEqual(errors, "")
        self.assertEqual(self.digest(out), self.digest("whole"))

    def test_places_where_nothing_can_be_written(self):
        (self.directory / "file").write_text("of others\n")
        for ranks in (1, 2):
            for place in (self.directory / "file", self.directory / "file" / "out", pathlib.Path("/proc/out")):
                code, told, errors = self.end_of(self.start(place, ranks=ranks))
                self.assertEqual(code, 5, told + errors)
                self.assertEqual(sum("error: " in line and str(place) in line for line in errors.splitlines()), 1, errors)
        self.assertEqual((self.directory / "file").read_text(), "of others\n")

    def test_a_full_disk_below_the_log(self):
        """What is told is lost, what is computed is not."""
        self.run_to_end("whole", "--steps", "300")
        for ranks in (1, 2):
            for streams in (("stdout",), ("stderr",), ("stdout", "stderr")):
                out = f"log_{ranks}_{len(streams)}_{streams[0]}"
                with open("/dev/full", "w") as full:
                    code, told, errors = self.end_of(self.start(out, "--steps", "300", ranks=ranks, **dict.fromkeys(streams, full)))
                self.assertEqual(self.digest(out), self.digest("whole"))
                self.assertTrue(self.checkpoints(out))
                if ranks == 1 and streams == ("stdout",):
                    self.assertIn("standard output", errors)

    def test_results_that_vanish(self):
        """While a run goes on."""
        run = self.start("gone")
        end = time.monotonic() + 60
        while not self.checkpoints("gone") and time.monotonic() < end:
            time.sleep(0.005)
        shutil.rmtree(self.directory / "gone")
        code, told, errors = self.end_of(run)
        self.assertEqual(code, 5, told + errors)
        self.assertIn("error: ", errors)


if __name__ == "__main__":
    unittest.main()
