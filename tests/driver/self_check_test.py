"""`skein check --self`: the same digest on any ranks, threads, levels of instructions, and processors."""

import os
import shutil
import subprocess
import unittest

from driver import MPIRUN, SKEIN

PROCESSORS = {"Nehalem": "(x86-64)", "Haswell": "(x86-64-v3)"}  # as QEMU plays them: what kernels must be chosen


def self_check(*arguments, launch=(), environment={}):
    return subprocess.run([*launch, SKEIN, "check", "--self", *arguments], capture_output=True, text=True, env=os.environ | environment)


class SelfCheck(unittest.TestCase):
    def assert_good(self, done, text="self-check: good"):
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(text, done.stdout)

    def test_lanes(self):
        for lanes in "1248":
            with self.subTest(lanes=lanes):
                done = self_check("--lanes", lanes)
                self.assert_good(done)
                if f", {lanes} lane" not in done.stdout: self.skipTest(f"kernels of {lanes} lanes are not built, or not for this processor")

    def test_ranks_and_threads(self):
        for ranks, threads in ((1, 2), (2, 1), (3, 2)):
            with self.subTest(ranks=ranks, threads=threads):
                self.assert_good(self_check("-t", str(threads), launch=(MPIRUN, "-n", str(ranks))), f"good on {ranks} x {threads}")

    def test_environment_limits_the_lanes(self):
        if ", 2 lanes" not in self_check("--lanes", "2").stdout: self.skipTest("kernels of 2 lanes are not built")
        self.assert_good(self_check(environment={"SKEIN_LANES": "2"}), "2 lanes (x86-64)")
        done = self_check(environment={"SKEIN_LANES": "3"})
        self.assertEqual(done.returncode, 2)
        self.assertIn("SKEIN_LANES must be 1, 2, 4 or 8", done.stderr)

    def test_older_processors(self):
        if os.environ.get("SKEIN_PORTABLE") == "OFF":
            self.skipTest("built with flags like -march=native: for processors like this one alone")
        qemu = shutil.which("qemu-x86_64")
        if not qemu:
            self.skipTest("no qemu-x86_64 (package qemu-user)")
        for processor, kernels in PROCESSORS.items():
            with self.subTest(processor=processor):
                self.assert_good(self_check("-t", "1", launch=(qemu, "-cpu", processor)), kernels)


if __name__ == "__main__":
    unittest.main()
