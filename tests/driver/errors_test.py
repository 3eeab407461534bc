"""What goes wrong is told once, with its exit code, on any number of ranks, and nothing is written."""

import subprocess
import unittest

from driver import MPIRUN, SKEIN, DriverTest


class Errors(DriverTest):
    def test_bad_input(self):
        for ranks in (1, 3):
            done = self.run_skein("bad", "--set", "time.duratoin=3", ranks=ranks, expect=2)
            self.assertEqual(done.stderr.count("did you mean 'duration'"), 1)
            self.assertFalse((self.directory / "bad").exists())

    def test_step_beyond_the_limit(self):
        done = self.run_skein("far", "--set", "time.dt=0.1", ranks=2, expect=2)
        self.assertIn("beyond the stable limit", done.stderr)
        self.assertFalse((self.directory / "far").exists())

    def test_instability_is_stopped_and_named(self):
        stable = self.run_skein("forced", "--until", "3.6")
        self.assertIn("checkpoint", stable.stdout)
        for protocol in ("asynchronous", "synchronous"):
            done = self.run_skein(protocol, "--protocol", protocol, "--set", "time.dt=0.02", "--set", "time.force_dt=true", ranks=2, expect=4)
            for part in ("rod ", "element", "step", "likely cause", "limit"):
                self.assertIn(part, done.stderr)
            self.assertFalse(list((self.directory / protocol).glob("checkpoint_*")), "a broken state was kept")

    def test_no_checkpoint(self):
        self.run_skein("without", "--no-checkpoint", "--until", "3.6")
        self.assertFalse(list((self.directory / "without").glob("checkpoint_*")))
        self.assertAlmostEqual(self.summary("without")["time_s"], 3.6, delta=1e-12)  # steps times dt

    def test_command_line(self):
        for arguments, code in ((["--help"], 0), (["--version"], 0), (["describe", str(self.scene)], 0), (["run", "--help"], 0), ([], 2), (["run"], 2), (["fly", "scene.toml"], 2), (["run", "x.toml", "--lanes", "3"], 2), (["run", "x.toml", "--protocol", "loose"], 2),
                                (["check", str(self.directory / "none.toml")], 2), (["describe", "rods.materail"], 2), (["describe", "rods.material"], 0),
                                (["check", str(self.scene)], 0), (["plan", str(self.scene), "--json"], 0), (["info"], 0)):
            done = subprocess.run([SKEIN, *arguments], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, code, f"{arguments}: {done.stdout}{done.stderr}")

    def test_scenes_that_are_no_text(self):
        loop = self.directory / "loop.toml"
        loop.symlink_to(loop)
        deep = self.directory / "deep.toml"
        deep.write_text("title = " + "[" * 20000)
        for scene, said in ((loop, "symbolic links"), (deep, f"{deep}:1:265: arrays or tables within each other, more than 256 deep")):
            done = subprocess.run([SKEIN, "check", str(scene)], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)

    def test_rods_that_do_not_fit_are_refused_before_they_are_made(self):
        for ranks in (1, 2):
            done = self.run_skein("many", "--set", "rods.cilia.placement.counts=[1000000, 100000]", expect=2, ranks=ranks)
            self.assertRegex(done.stderr, r"needs [0-9.e+]+ GB on .*, of which [0-9.e+]+ GB are free: [0-9.e+]+ GB for 100000000003 rods with 1000000000021 elements")
            self.assertFalse((self.directory / "many").exists())

    def test_singleton_run_without_mpirun(self):
        done = subprocess.run([SKEIN, "run", str(self.scene), "--out", str(self.directory / "alone"), "--until", "0.36", "--quiet"],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, "")

    def test_too_many_threads_are_warned_about(self):
        done = subprocess.run([MPIRUN, "--bind-to", "core", "-n", "1", SKEIN, "run", str(self.scene), "--threads", "2", "--until", "0.36",
                               "--out", str(self.directory / "bound")], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("--map-by slot:PE=2", done.stderr)


if __name__ == "__main__":
    unittest.main()
