"""Interrupted runs: kill -9, signals, limits, damaged checkpoints. The end is always that of the uninterrupted run."""

import os
import pathlib
import signal
import subprocess
import time
import unittest

import h5py
import numpy

from driver import SKEIN, DriverTest


def ranks_of(launcher):
    """Process ids of the skein ranks below an mpirun."""
    found = []
    for process in pathlib.Path("/proc").iterdir():
        if not process.name.isdigit():
            continue
        try:
            status = (process / "stat").read_text().rsplit(")", 1)[1].split()
            program = os.readlink(process / "exe")
        except OSError:
            continue
        if program == os.path.realpath(SKEIN) and int(status[1]) == launcher.pid:
            found.append(int(process.name))
    return found


class Restart(DriverTest):
    LONG = ("--set", "time.duration=108", "--set", "output.checkpoint=1.8")

    def checkpoints(self, out):
        return sorted((self.directory / out).glob("checkpoint_*.h5"))

    def start(self, out, *arguments, **layout):
        return subprocess.Popen(self.command(out, *arguments, **layout), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def wait_for_checkpoints(self, out, count, process):
        end = time.monotonic() + 100
        while len(self.checkpoints(out)) < count and time.monotonic() < end and process.poll() is None:
            time.sleep(0.01)
        self.assertIsNone(process.poll(), "the run ended before it could be interrupted")

    def assert_same_results(self, out, whole):
        self.assertEqual(self.digest(out), self.digest(whole))
        self.assertEqual(self.results(out)["observables.csv"], self.results(whole)["observables.csv"])
        self.assert_same_frames(out, whole, "cilia")

    def test_kill_9_of_a_rank(self):
        self.run_skein("whole", *self.LONG)
        killed = self.start("killed", *self.LONG, ranks=2)
        self.wait_for_checkpoints("killed", 2, killed)
        os.kill(ranks_of(killed)[-1], signal.SIGKILL)
        began = time.monotonic()
        self.assertNotEqual(killed.wait(timeout=30), 0)
        self.assertLess(time.monotonic() - began, 10, "mpirun hung after a rank was killed")
        killed.stdout.close()
        self.assertFalse((self.directory / "killed/summary.json").exists())
        resumed = self.run_skein("killed", *self.LONG, ranks=3)
        self.assertIn("Resuming from", resumed.stdout)
        self.assert_same_results("killed", "whole")

    def test_kill_9_before_the_first_checkpoint(self):
        late = ("--set", "time.duration=300", "--set", "output.checkpoint=0")  # 2 s on one core, of which the killed one has 0.1 s
        self.run_skein("whole", *late)
        killed = self.start("killed", *late, ranks=2)
        while not (self.directory / "killed/observables.csv").exists() and killed.poll() is None:
            time.sleep(0.01)
        time.sleep(0.1)
        os.kill(ranks_of(killed)[0], signal.SIGKILL)
        self.assertNotEqual(killed.wait(timeout=30), 0)
        killed.stdout.close()
        self.assertEqual(self.checkpoints("killed"), [])
        self.run_skein("killed", *late, "--set", "damping.0.rate=0.6", expect=5)
        again = self.run_skein("killed", *late)
        self.assertIn("starting again", again.stdout)
        self.assert_same_results("killed", "whole")

    def test_signal_stops_with_a_checkpoint(self):
        self.run_skein("whole", *self.LONG)
        stopped = self.start("stopped", *self.LONG, ranks=2)
        self.wait_for_checkpoints("stopped", 1, stopped)
        stopped.send_signal(signal.SIGUSR1)
        text = stopped.communicate(timeout=60)[0]
        self.assertEqual(stopped.returncode, 3, text)
        self.assertIn("the same command resumes", text)
        self.run_skein("stopped", *self.LONG)
        self.assert_same_results("stopped", "whole")

    def test_limits(self):
        self.run_skein("whole")
        self.run_skein("parts", "--steps", "333")
        self.assertEqual(self.summary("parts")["steps"], 333)
        self.run_skein("parts", "--until", "5.4", ranks=2)
        self.assertFalse(self.summary("parts")["finished"])
        self.run_skein("parts", threads=2)
        self.assertTrue(self.summary("parts")["finished"])
        self.assert_same_results("parts", "whole")
        self.assertEqual(self.run_skein("parts").stdout.count("100.0 % done"), 1, "nothing is left to do")
        self.assertEqual(self.digest("parts"), self.digest("whole"))

    AUDIT = ("--set", "output.audit=true")

    def test_an_audit_goes_on(self):
        self.run_skein("whole", *self.AUDIT)
        self.run_skein("parts", *self.AUDIT, "--steps", "333")
        self.run_skein("parts", *self.AUDIT, "--until", "5.4", ranks=2)
        resumed = self.run_skein("parts", *self.AUDIT, threads=2)
        self.assertNotIn("audit, which begins here", resumed.stdout)
        self.assert_same_results("parts", "whole")
        series = numpy.genfromtxt(self.directory / "parts/observables.csv", delimiter=",", names=True)
        self.assertGreater(abs(series["work_loadsJ"][-1]), 0)
        self.assertLess(numpy.abs(series["energy_defectJ"]).max(), 1e-2 * numpy.abs(series["work_loadsJ"]).max())

    def test_an_audit_begins_where_a_checkpoint_has_none(self):
        """Without series, whose columns must not change."""
        bare = ("--set", "output.series=0", "--set", "output.observables=[]")
        self.run_skein("out", *bare, "--until", "3.6")
        newest = self.checkpoints("out")[-1]
        with h5py.File(newest) as file:
            self.assertEqual((file.attrs["version"], file.attrs["audited"]), (9, 0))
        resumed = self.run_skein("out", *bare, *self.AUDIT, "--until", "7.2", ranks=2)
        self.assertIn("audit, which begins here", resumed.stdout)
        first = self.summary("out")["observables"]["work_loads[J]"]
        with h5py.File(self.checkpoints("out")[-1]) as file:
            self.assertEqual((file.attrs["version"], file.attrs["audited"]), (9, 1))
            self.assertAlmostEqual(sum(file[f"groups/{name}/works"][:, 0, 0].sum() for name in ("cilia", "leaning")), first, delta=1e-12 * abs(first))
        self.run_skein("out", *bare, *self.AUDIT)
        self.run_skein("whole", *bare, *self.AUDIT)
        self.assertEqual(self.digest("out"), self.digest("whole"))
        with h5py.File(self.checkpoints("out")[-1], "r+") as file:
            file.attrs["version"] = numpy.int64(10)
        self.assertIn("reads versions 2 to 9", self.run_skein("out", *bare, expect=2).stderr)

    def test_walltime(self):
        self.run_skein("short", "--set", "time.duration=7200", "--walltime", "3", expect=3)
        self.assertLess(self.summary("short")["wall_s"], 6)
        self.assertTrue(self.checkpoints("short"))

    def test_extended_duration_resumes(self):
        self.run_skein("whole")
        self.run_skein("longer", "--set", "time.duration=7.2")
        self.run_skein("longer")
        self.assert_same_results("longer", "whole")

    def test_damaged_checkpoints_are_named_and_the_previous_one_is_used(self):
        self.run_skein("whole")
        for damage in ("truncated", "flipped", "empty"):
            self.run_skein(damage, "--until", "7.2")
            newest = self.checkpoints(damage)[-1]
            content = bytearray(newest.read_bytes())
            if damage == "truncated":
                content = content[: len(content) // 2]
            elif damage == "flipped":
                content[-1000] ^= 0x10  # the state is the last and largest part of the file
            else:
                content = b""
            newest.write_bytes(content)
            done = self.run_skein(damage, ranks=2)
            self.assertIn("warning", done.stderr)
            self.assertIn(newest.name, done.stderr)
            self.assertIn("Resuming from", done.stdout)
            self.assertNotIn(f"Resuming from {newest}", done.stdout)
            self.assert_same_results(damage, "whole")

    def test_other_physics_is_refused(self):
        self.run_skein("out", "--until", "3.6")
        before = self.results("out")
        done = self.run_skein("out", "--set", "damping.0.rate=0.6", expect=2)
        self.assertIn("rate", done.stderr)
        self.assertEqual(self.results("out"), before, "a refused run changed results")
        self.run_skein("out", "--set", "damping.0.rate=0.6", "--overwrite", "--until", "3.6")
        self.assertNotEqual(self.results("out"), before)

    def test_results_without_checkpoint_are_not_overwritten(self):
        self.run_skein("out", "--until", "1.8")
        for checkpoint in self.checkpoints("out"):
            checkpoint.unlink()
        before = self.results("out")
        done = self.run_skein("out", expect=5)
        self.assertIn("--overwrite", done.stderr)
        self.assertEqual(self.results("out"), before)

    def test_a_directory_has_one_run(self):
        first = self.start("shared", "--set", "time.duration=7200")
        self.wait_for_checkpoints("shared", 1, first)
        done = self.run_skein("shared", expect=5)
        self.assertIn("shared", done.stderr)
        first.send_signal(signal.SIGTERM)
        first.communicate(timeout=60)


if __name__ == "__main__":
    unittest.main()
