"""What tests of faults share: how many of them are run, draws that can be repeated, ends of processes with a limit of time."""

import os
import random
import subprocess

from contact_test import SCENE as TOUCHING
from driver import REFUSED, SCENE as FREE, DriverTest

ALL = os.environ.get("SKEIN_LONG") == "1"  # all trials, as jobscripts/faults.sh asks; otherwise some of them
SEED = os.environ.get("SKEIN_SEED", "1")
PATIENCE = 300  # s, after which a run hangs: ranks may share their cores with other tests


class FaultTest(DriverTest):
    SCENE = TOUCHING
    KEYS = ()

    def setUp(self):
        super().setUp()
        self.draw = random.Random(f"{SEED} {self.id()}")
        self.scene.write_text(self.SCENE)

    def start(self, out, *arguments, ranks=1, threads=1, **keys):
        """A rank by itself needs no launcher."""
        command = self.command(out, *self.KEYS, *arguments, ranks=ranks, threads=threads)
        process = subprocess.Popen(command[3:] if ranks == 1 else command, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **keys})
        self.addCleanup(self.stop, process)
        return process

    @staticmethod
    def stop(process):
        """Leaves nothing running behind a test that failed."""
        if process.poll() is None:
            process.terminate()
            try:
                process.communicate(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()

    def end_of(self, process, seconds=PATIENCE):
        """Exit code, output, errors."""
        try:
            out, err = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            states = subprocess.run(["ps", "-eo", "pid,ppid,stat,wchan:24,etimes,times,args"], capture_output=True, text=True).stdout
            process.kill()
            told = process.communicate()
            self.fail(f"{' '.join(map(str, process.args))} hangs\n{told}\n" + "\n".join(line for line in states.splitlines() if str(self.directory) in line))
        return process.returncode, out, err

    def run_to_end(self, out, *arguments, expect=0, ranks=1, **keys):
        """Output and errors. Nothing befalls it but what it finds."""
        environment = REFUSED if ranks > 1 and expect else None
        code, told, errors = self.end_of(self.start(out, *arguments, ranks=ranks, **{"env": environment, **keys}))
        self.assertEqual(code, expect, told + errors)
        return told, errors

    def checkpoints(self, out):
        return sorted((self.directory / out).glob("checkpoint_*.h5"))


__all__ = ["ALL", "FREE", "TOUCHING", "FaultTest"]
