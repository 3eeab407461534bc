"""Faults with the default keys: kill -9, hang-ups, full disks, damaged and foreign files. Little is lost, nothing of others is touched."""

import hashlib
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import time
import unittest

import h5py
import numpy

from driver import SKEIN, STICKS, DriverTest, launch
from restart_test import ranks_of

LONG = ("--set", "time.duration=360", "--set", "output.checkpoint=0")
OFTEN = ("--set", "output.checkpoint_wall=0.05")
OWN_NAMES = ("checkpoint_000000000064.h5", "checkpoint_999999999999.h5", "checkpoint_000000000064.h5.tmp", "trajectory_000000000000.h5", "trajectory_999999999999.h5",
             "trajectory_000000000000.h5.tmp", "tips_000000000000.h5", "tips_000000000000.h5.tmp", "contacts_000000000064.csv", "observables.csv", "observables.lost.csv",
             "observables.csv.tmp", "summary.json", "summary.json.tmp", "physics.json", "physics.json.tmp", "trajectory.xdmf", "trajectory.xdmf.tmp", "lost_tips_000000000000.h5", "failure.h5", "failure.xdmf",
             "rods.pvd", "walls.pvd", "rods.pvd.tmp", "vtp/rods_000000000000.vtp", "vtp/rods_000000000064.vtp.tmp", "vtp/walls_000000000000.vtp")
OTHER_NAMES = ("mydata.h5", "thesis.tmp", "other.xdmf", "checkpoint_best.h5", "trajectory.h5", "trajectory_64.h5", "tips_.h5", "my_checkpoint_000000000064.h5", "observables.csv.bak",
               "notes.txt", "summary.json~", "contacts_a.csv", "previous_1", "previous_2.tmp", ".hidden.h5", "x.h5.tmp", "a b.csv", "scene.toml",
               "rods_000000000000.vtp", "my.pvd", "vtp/notes.txt", "vtp/rods_0.vtp", "vtp/trajectory_000000000000.h5")


class Faults(DriverTest):
    def path(self, out):
        return self.directory / out

    def checkpoints(self, out):
        return sorted(self.path(out).glob("checkpoint_*.h5"))

    def start(self, out, *arguments, launcher=False, **keys):
        """One rank, by itself or under mpirun."""
        command = self.command(out, *arguments)
        return subprocess.Popen(command if launcher else command[3:], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **keys)

    def wait_for(self, condition, process):
        end = time.monotonic() + 100
        while not condition() and time.monotonic() < end and process.poll() is None:
            time.sleep(0.01)
        self.assertIsNone(process.poll(), "the run ended before it could be interrupted")

    def end_of(self, process):
        text = process.communicate(timeout=100)[0]
        return process.returncode, text

    def assert_same_results(self, out, whole):
        self.assertEqual(self.digest(out), self.digest(whole))
        self.assertEqual(self.results(out)["observables.csv"], self.results(whole)["observables.csv"])
        self.assert_same_frames(out, whole, "cilia")

    # Kills.

    def test_kill_9_costs_no_more_than_the_wall_clock_says(self):
        """At random times, with no key of the scene but the interval, which is 15 min by default: what a checkpoint has is not computed again."""
        self.run_skein("whole", *LONG)
        draw = random.Random(3)
        for trial in range(3):
            out, steps = f"killed_{trial}", [0]
            for _ in range(3):
                before = len(self.checkpoints(out))
                run = self.start(out, *LONG, *OFTEN)
                count = before + draw.randint(1, 3)
                newest = lambda: int(self.checkpoints(out)[-1].stem[11:]) if self.checkpoints(out) else 0
                self.wait_for(lambda: newest() > steps[-1] and len(self.checkpoints(out)) >= min(count, 4), run)
                time.sleep(draw.uniform(0, 0.1))
                run.kill()
                run.communicate()
                steps.append(newest())
            self.assertEqual(steps, sorted(set(steps)), "a resumed run began anew")
            resumed = self.run_skein(out, *LONG, ranks=draw.choice((1, 2)))
            self.assertIn(f"step {steps[-1]},", resumed.stdout)
            self.assert_same_results(out, "whole")

    def test_rows_after_the_checkpoint_are_kept_when_a_run_is_killed(self):
        out = "killed"
        run = self.start(out, *LONG, *OFTEN)
        self.wait_for(lambda: self.checkpoints(out), run)
        run.kill()
        run.communicate()
        for newer in self.checkpoints(out)[1:]:
            newer.unlink()  # so that there are rows to lose
        before = (self.path(out) / "observables.csv").read_text().splitlines()
        first = int(self.checkpoints(out)[0].stem[11:])
        frames = self.frames(out, "trajectory")["step"] if list(self.path(out).glob("trajectory_*.h5")) else []
        done = self.run_skein(out, *LONG, "--steps", str(first + 64))
        kept = (self.path(out) / "observables.csv").read_text().splitlines()
        lost = self.path(out) / "observables.lost.csv"
        lost = lost.read_text().splitlines() if lost.exists() else []
        for row in before[1:]:
            step = int(row.split(",")[0])
            self.assertIn(row, kept if step <= first else lost)
        for step in frames:
            if step > first:
                self.assertTrue(any(step in h5py.File(name)["step"][:] for name in self.path(out).glob("lost_trajectory_*.h5")), done.stdout + done.stderr)

    def test_milestones(self):
        self.run_skein("out", "--set", "output.checkpoint=0.36", "--set", "time.duration=36", "--set", "output.keep=3")
        steps = [int(path.stem[11:]) for path in self.checkpoints("out")]
        every = steps[-1] - steps[-2]
        self.assertEqual(steps[-3:], [steps[-1] - 2 * every, steps[-1] - every, steps[-1]])
        self.assertEqual(steps[0], every)
        self.assertLess(len(steps), 15)
        self.run_skein("two", "--set", "output.checkpoint=0.36", "--set", "output.milestones=false")
        self.assertEqual(len(self.checkpoints("two")), 2)

    # Signals.

    def test_signals_stop_with_a_checkpoint(self):
        for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
            out = f"stopped_{number}"
            run = self.start(out, "--set", "time.duration=7200", "--set", "output.checkpoint=0")
            self.wait_for(lambda: (self.path(out) / "observables.csv").exists(), run)
            run.send_signal(number)
            code, text = self.end_of(run)
            self.assertEqual(code, 3, text)
            self.assertEqual(len(self.checkpoints(out)), 1)

    def test_nohup_is_respected(self):
        run = self.start("out", *LONG, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        self.wait_for(lambda: (self.path("out") / "observables.csv").exists(), run)
        run.send_signal(signal.SIGHUP)
        self.assertEqual(self.end_of(run)[0], 0)

    def test_a_reader_that_goes_does_not_end_a_run(self):
        errors = self.directory / "errors.txt"
        with errors.open("w") as file:
            run = subprocess.Popen(self.command("out", "--set", "time.duration=36")[3:], stdout=subprocess.PIPE, stderr=file)
            run.stdout.readline()
            run.stdout.close()
            self.assertEqual(run.wait(timeout=100), 0)
        self.assertIn("standard output is gone", errors.read_text())
        self.assertTrue(self.summary("out")["finished"])

    def test_a_second_interrupt_ends_a_run_at_once(self):
        """In set-up of many rods, where nothing else looks."""
        run = self.start("out", "--set", "rods.0.placement.counts=[1000, 1000]", "--set", "rods.0.shape.elements=8")
        time.sleep(0.7)
        run.send_signal(signal.SIGINT)
        time.sleep(0.5)
        self.assertIsNone(run.poll())
        run.send_signal(signal.SIGINT)
        self.assertEqual(self.end_of(run)[0], -signal.SIGINT)

    def test_packing_is_stopped(self):
        self.scene.write_text(STICKS + """
[rods.placement]
kind = "packing"
count = 100000
region = "box"
lower = [0.0, 0.0, 0.0]
upper = [1.0, 1.0, 0.91]
attempts = 100000000
[time]
duration = 1.0
[output]
series = 0.1
""")
        for launcher in (False, True):
            run = self.start("out", launcher=launcher)
            time.sleep(2)
            for process in ranks_of(run) if launcher else [run.pid]:
                os.kill(process, signal.SIGTERM)
            code, text = self.end_of(run)
            self.assertEqual(code, 3, text)
            self.assertIn("while rods were packed", text)
            self.assertFalse(self.path("out").exists())

    # Input and output.

    def limited(self, out, most, *arguments):
        """A run whose files may have `most` bytes."""
        run = self.start(out, *arguments)
        self.wait_for(lambda: (self.path(out) / ".lock").exists(), run)  # MPI has files of its own before
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (most, most))
        return self.end_of(run)

    def test_a_disk_that_is_full_at_a_frame_costs_frames_and_no_work(self):
        keys = ("--set", "output.checkpoint=3.6", "--set", "output.trajectory=0.036", "--set", "output.tips=0", "--set", "output.directors=true")
        self.run_skein("whole", *keys)
        code, text = self.limited("full", 300_000, *keys)
        self.assertEqual(code, 5, text)
        self.assertIn("kept in a last checkpoint", text)
        self.assertEqual(len(self.checkpoints("full")), 1)
        last = int(self.checkpoints("full")[0].stem[11:])
        lost = [step for step in self.frames("whole", "trajectory")["step"] if step < last]
        self.assertIn(f"trajectory frames of steps {lost[0]} to {lost[-1]} are lost", text)
        done = self.run_skein("full", *keys)
        self.assertIn(f"step {last},", done.stdout)
        self.assertEqual(self.digest("full"), self.digest("whole"))
        self.assertEqual(self.results("full")["observables.csv"], self.results("whole")["observables.csv"])
        whole, found = self.frames("whole", "trajectory"), self.frames("full", "trajectory")
        self.assertEqual(list(found["step"]), [step for step in whole["step"] if step >= last])
        self.assertTrue(numpy.array_equal(found["groups/cilia/position"], whole["groups/cilia/position"][-len(found["step"]):]))

    def test_a_disk_that_is_full_at_a_row_costs_nothing(self):
        keys = ("--set", "output.trajectory=0", "--set", "output.tips=0", "--set", "output.checkpoint=0", "--set", "output.series=0.0072", "--set", "output.observables=[]", "--set", "time.duration=10.8")
        self.run_skein("whole", *keys)
        size = (self.path("whole") / "observables.csv").stat().st_size
        self.assertGreater(size, 300_000)
        code, text = self.limited("full", 200_000, *keys)
        self.assertEqual(code, 5, text)
        self.assertIn("kept in a last checkpoint", text)
        done = self.run_skein("full", *keys)
        self.assertIn("Resuming from", done.stdout)
        self.assertEqual(self.digest("full"), self.digest("whole"))
        self.assertEqual(self.results("full")["observables.csv"], self.results("whole")["observables.csv"])

    def damaged(self, out, keys, damage):
        """What a run says that goes on after three parts, the files of which are damaged."""
        if not self.path("parts").exists():
            for steps in (1000, 2000, 3000):
                self.run_skein("parts", *keys, "--steps", str(steps))
        shutil.copytree(self.path("parts"), self.path(out))
        damage(self.path(out))
        return self.run_skein(out, *keys, ranks=2).stderr

    def test_damaged_frames_and_rows_are_told_and_put_aside(self):
        keys = ("--set", "time.duration=2.4", "--set", "output.checkpoint=0", "--set", "output.trajectory=0.18", "--set", "output.series=0.18")
        self.run_skein("whole", *keys)

        def flip(path, at):
            content = bytearray(path.read_bytes())
            content[at] ^= 0x10
            path.write_bytes(content)

        def segments(folder):
            end = folder / "end.json"  # a run that goes on takes back what it names, damaged or not
            taken_back = end.read_text() if end.exists() else ""
            return [path for path in sorted(folder.glob("trajectory_*.h5")) if path.name not in taken_back]

        def flip_position(folder):
            path = segments(folder)[-1]
            with h5py.File(path) as file:
                at = file["groups/cilia/position"].id.get_chunk_info(0).byte_offset
            flip(path, at + 100)

        csv = lambda folder: folder / "observables.csv"
        cases = {
            "truncated": (lambda f: segments(f)[0].write_bytes(segments(f)[0].read_bytes()[:3000]), "renamed to"),
            "empty": (lambda f: segments(f)[-1].write_bytes(b""), "renamed to"),
            "flipped": (flip_position, "is damaged"),
            "gone": (lambda f: segments(f)[1].unlink(), "are missing"),
            "last_gone": (lambda f: segments(f)[-1].unlink(), "are missing"),
            "row_flipped": (lambda f: flip(csv(f), 700), "its rows were changed"),
            "rows_cut": (lambda f: csv(f).write_bytes(csv(f).read_bytes()[:900]), "it has 900 bytes of"),
            "csv_gone": (lambda f: csv(f).unlink(), "it is missing"),
        }
        for out, (damage, words) in cases.items():
            told = self.damaged(out, keys, damage)
            self.assertIn(words, told)
            self.assertEqual(self.digest(out), self.digest("whole"))
            self.assertTrue(self.summary(out)["finished"])
            self.assertEqual(bool(list(self.path(out).glob("*.damaged"))), "gone" not in out, out)
        self.assertEqual(self.damaged("well", keys, lambda folder: None), "")
        self.assert_same_results("well", "whole")

    # Files of others.

    def foreign(self, folder, names):
        folder.mkdir(parents=True, exist_ok=True)
        found = {}
        for name in names:
            content = f"{name} of another program\n".encode() * 3
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)
            found[name] = hashlib.sha256(content).hexdigest()
        return found

    def contents(self, out):
        return {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in self.path(out).rglob("*") if path.is_file()}

    def commands(self, out):
        """Every way to start in a directory; those of which the outcome is known, with it."""
        yield "--until", "3.6"
        yield "--until", "7.2", "--overwrite"
        yield "--set", "damping.0.rate=0.6"
        yield "--until", "9"
        yield ()
        yield ()
        yield "--set", "time.duration=18"
        yield "--overwrite", "--until", "0.36", "--no-checkpoint"
        yield "--until", "0.72"
        for command in ("plan", "check", "describe", "info"):
            subprocess.run([os.path.abspath(SKEIN), command, str(self.scene)], stdout=subprocess.DEVNULL, cwd=self.path(out))

    def test_files_of_others_survive_every_command(self):
        others, own = self.foreign(self.path("out"), OTHER_NAMES), self.foreign(self.path("out"), OWN_NAMES)
        before = self.contents("out")
        done = self.run_skein("out", expect=5)
        self.assertIn("previous", done.stderr + "previous")
        self.assertEqual({path: digest for path, digest in self.contents("out").items() if path.name != ".lock"}, before, "a refused run changed files")
        for arguments in self.commands("out"):
            launch(*self.command("out", *arguments)[4:])
            after = self.contents("out")
            for name, digest in others.items():
                self.assertEqual(after.get(self.path("out") / name), digest, f"{name} after {arguments}")
            for name, digest in own.items():
                self.assertIn(digest, after.values(), f"{name} after {arguments}")

    def test_files_of_others_survive_beside_results(self):
        """Under names that the run is about to use."""
        self.run_skein("out", "--until", "3.6", "--set", "output.trajectory=0", "--set", "output.tips=0", "--set", "output.series=0")
        used = ("summary.json", "physics.json", self.checkpoints("out")[-1].name)
        foreign = self.foreign(self.path("out"), [name for name in OWN_NAMES if name not in used and not name.startswith("observables.csv")] + list(OTHER_NAMES))
        for arguments in (("--until", "7.2"), (), ("--overwrite",)):
            launch(*self.command("out", *arguments)[4:])
            after = self.contents("out")
            for name, digest in foreign.items():
                self.assertIn(digest, after.values(), f"{name} after {arguments}")
        self.assertTrue(self.summary("out")["finished"])

    def test_overwrite_moves_results(self):
        self.run_skein("out", "--until", "3.6")
        contents = lambda out: {path.relative_to(self.path(out)): digest for path, digest in self.contents(out).items() if path.name != ".lock"}
        before = contents("out")
        self.assertTrue(any(path.parent.name == "vtp" for path in before))
        self.run_skein("out", "--until", "7.2", "--overwrite")
        self.assertEqual(contents("out/previous_1"), before)
        self.run_skein("out", "--until", "3.6", "--overwrite")
        self.assertTrue((self.path("out") / "previous_2").is_dir())

    # Words.

    def state_of(self, out):
        return {path.name: (path.stat().st_mtime_ns, path.stat().st_ino) for path in self.path(out).iterdir() if path.name != ".lock"}

    def test_a_finished_run_is_left_alone(self):
        self.run_skein("out")
        before = self.state_of("out")
        done = self.run_skein("out", ranks=2)
        self.assertIn("Nothing to do", done.stdout)
        self.assertNotIn("has changed", done.stdout)
        done = self.run_skein("out", "--set", "output.series=0.36", "--set", "output.trajectory=0")
        self.assertIn("/output/series: was 0.72, now 0.36", done.stdout)
        self.assertIn("/output/trajectory: was 1.8, now 0", done.stdout)
        self.assertNotIn("/output/tips", done.stdout)
        self.assertEqual(self.state_of("out"), before)
        (self.path("out") / "summary.json").unlink()  # killed before it was written
        self.run_skein("out")
        self.assertTrue(self.summary("out")["finished"])

    def test_progress_in_logs_has_no_escapes(self):
        columns = ("--set", 'output.progress=["kinetic_translation", "max_speed"]')
        log = self.run_skein("log", *columns).stdout
        self.assertNotIn("\x1b", log)
        self.assertNotIn("\r", log)
        last = [line for line in log.splitlines() if line.startswith("step ")][0]
        value = self.summary("log")["observables"]
        name = next(key for key in value if key.startswith("kinetic_translation["))
        self.assertIn(f"kinetic_translation {value[name]:.4g}", last)
        self.assertIn("\x1b[K", self.run_skein("bar", *columns, "--progress", "bar").stdout)
        done = self.run_skein("none", "--set", 'output.progress=["kinetic_translatoin"]', expect=2)
        self.assertIn("kinetic_translation", done.stderr)

    def test_the_plan_says_what_a_failure_costs(self):
        plan = lambda *keys: subprocess.run([SKEIN, "plan", "-v", str(self.scene), *keys], capture_output=True, text=True).stdout
        self.assertIn("every 15 min of wall time", plan())
        self.assertIn("costs at most 15 min of work", plan("--set", "time.duration=7.2e7", "--set", "output.checkpoint=0"))
        self.assertIn("all there is to do", plan("--set", "time.duration=7.2e7", "--set", "output.checkpoint=0", "--set", "output.checkpoint_wall=0"))


if __name__ == "__main__":
    unittest.main()
