"""Restarts by the hundred, and checkpoints by the hundred in one run: memory and open files stay what they were, and the bits are those of
a run without a stop."""

import os
import pathlib
import time
import unittest

from faults import ALL, FREE, FaultTest

STEP = 8  # steps between restarts


def resident(pid):
    return 1024 * int(pathlib.Path(f"/proc/{pid}/status").read_text().split("VmRSS:")[1].split()[0])


class Soak(FaultTest):
    def test_restarts(self):
        """Each a process of its own; what it takes must not follow the number of those before it."""
        count = 500 if ALL else 12
        self.KEYS = ("--set", "output.trajectory=0", "--set", "output.tips=0", "--set", "output.checkpoint=0")
        self.run_to_end("whole", "--steps", str(STEP * count))
        peaks, files = [], []
        for k in range(1, count + 1):
            run = self.start("parts", "--steps", str(STEP * k), "--quiet")
            run.stdout.close()
            errors = run.stderr.read()
            _, status, usage = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
            run.stderr.close()
            self.assertEqual(run.returncode, 0, errors)
            peaks.append(1024 * usage.ru_maxrss)
            files.append(len(list((self.directory / "parts").iterdir())))
        self.assertEqual(self.digest("parts"), self.digest("whole"))
        third = count // 3
        first, last = sorted(peaks[:third])[third // 2], sorted(peaks[-third:])[third // 2]
        self.assertLess(last, first + (4 << 20), "memory grows with restarts")
        self.assertLess(files[-1], files[0] + 16, "files pile up")
        print(f"{count} restarts: {first >> 10} kB at first, {last >> 10} kB at last, {files[0]} to {files[-1]} files")

    def test_checkpoints_of_one_run(self):
        """A run that writes rows, frames and checkpoints all the time."""
        self.scene.write_text(FREE)
        keys = ("--set", "time.duration=72" if ALL else "time.duration=14.4", "--set", "output.checkpoint=0.036", "--set", "output.trajectory=0.036", "--set", "output.series=0.036")
        run = self.start("out", *keys, "--quiet")
        counts, sizes = [], []
        while run.poll() is None:
            time.sleep(0.05)
            try:
                if (self.directory / "out/observables.csv").exists():
                    look = len(list(pathlib.Path(f"/proc/{run.pid}/fd").iterdir())), resident(run.pid)
                    counts.append(look[0])
                    sizes.append(look[1])
            except (OSError, IndexError):
                continue  # a file was closed meanwhile, or the run has ended
        self.assertEqual(self.end_of(run)[0], 0)
        self.assertGreater(len(sizes), 12)
        third = len(sizes) // 3
        self.assertLessEqual(sorted(counts[-third:])[third // 2], sorted(counts[third:-third])[third // 2] + 1, "open files pile up")
        self.assertLess(sizes[-2], sizes[third] + (8 << 20), "memory grows")
        print(f"{len(sizes)} looks: {sizes[third] >> 10} kB after a third, {sizes[-2] >> 10} kB at the end; {max(counts)} open files at most")


if __name__ == "__main__":
    unittest.main()
