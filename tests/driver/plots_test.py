"""Figures of the cases (apps/*/plot.py): of their own results a picture, of anything else a sentence. Never a traceback."""

import os
import pathlib
import runpy
import subprocess
import sys
import tempfile
import traceback
import unittest

import h5py  # noqa: F401  (as the next one for plot_at_once)
import matplotlib.pyplot  # noqa: F401

from driver import launch

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
# Case: scene, options that make a run of a second, picture (none where the run ends before there is something to measure).
CASES = {
    "cilia_carpet": ("row_8.toml", ("--until", "72", "--set", "rods.cilia.shape.elements=4"), "carpet.png"),
    "contact": ("plectoneme.toml", ("--until", "0.2", "--set", "output.trajectory=0.1"), "rod.png"),
    "formulas": ("gusts.toml", ("--until", "0.02", "--set", "output.trajectory=0.01"), "formulas.png"),
    "gripper": ("gripper.toml", ("--until", "0.02"), None),
    "nest": ("nest_110.toml", ("--until", "0.002"), None),
    "traced": ("traced.toml", ("--until", "0.02", "--set", "output.trajectory=0.01"), "traced.png"),
}


class Plots(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._directory = tempfile.TemporaryDirectory()
        cls.directory = pathlib.Path(cls._directory.name)
        for case, (scene, options, _) in CASES.items():
            done = launch("run", APPS / case / scene, "--out", cls.directory / case, "-q", *options)
            assert done.returncode in (0, 3), done.stdout + done.stderr

    @classmethod
    def tearDownClass(cls):
        cls._directory.cleanup()

    def plot(self, program, out, **environment):
        return subprocess.run([sys.executable, str(APPS / program), str(out)], capture_output=True, text=True, timeout=100,
                              env=dict(os.environ, **environment))

    @staticmethod
    def plot_at_once(program, out):
        """As plot(), in a copy of this process, which has the packages that a program reads for most of a second before it looks at its results."""
        program = APPS / program
        with tempfile.TemporaryFile("w+") as told, tempfile.TemporaryFile("w+") as errors:
            sys.stdout.flush()
            sys.stderr.flush()
            copy = os.fork()
            if copy == 0:
                code = 1
                try:
                    os.dup2(told.fileno(), 1)
                    os.dup2(errors.fileno(), 2)
                    sys.stdout, sys.stderr = (open(number, "w", closefd=False) for number in (1, 2))
                    sys.argv, sys.path[0] = [str(program), str(out)], str(program.parent)
                    runpy.run_path(str(program), run_name="__main__")
                    code = 0
                except SystemExit as end:
                    if isinstance(end.code, str):
                        print(end.code, file=sys.stderr)
                    else:
                        code = end.code or 0
                except BaseException:
                    traceback.print_exc()
                finally:
                    sys.stdout.flush()
                    sys.stderr.flush()
                    os._exit(code)
            code = os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
            told.seek(0)
            errors.seek(0)
            return subprocess.CompletedProcess([str(program), str(out)], code, told.read(), errors.read())

    def assert_sentence(self, done, *words):
        """One line, which has these words, and an exit code that scripts notice."""
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_own_results_are_drawn(self):
        for case, (_, _, picture) in CASES.items():
            with self.subTest(case=case):
                done = self.plot(f"{case}/plot.py", self.directory / case)
                if picture:
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                    self.assertGreater((self.directory / case / picture).stat().st_size, 10000)
                else:
                    self.assert_sentence(done, {"nest": "the lid has touched no rod yet", "gripper": "ends before the ball has been carried"}[case])

    def test_a_nest_under_its_lid(self):
        """Thirty rods, one fast cycle, at two steps: every picture, and a table of what the steps cost."""
        small = ["--set=wall.lid.from=0.1", "--set=wall.lid.servo.speed=0.3", "--set=wall.lid.servo.cycles=1",
                 "--set=rods.sticks.placement.count=30", "--set=output.trajectory=0.02", "--set=output.contacts=0.02"]
        runs = {"4": self.directory / "nest_4us", "2": self.directory / "nest_2us"}
        for step, out in runs.items():
            launch("run", APPS / "nest/nest_110.toml", "--out", out, "-q", f"--set=time.dt={step}e-6", *small).check_returncode()
        one, other = (str(out) for out in runs.values())
        done = subprocess.run([sys.executable, str(APPS / "nest/plot.py"), one, "--beside", other, "--before", other], capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("1 cycles until", done.stdout)
        for picture in ("nest.png", "work.png", "cost.png"):
            self.assertGreater((runs["4"] / picture).stat().st_size, 10000)
        picture = self.directory / "steps.png"
        done = subprocess.run([sys.executable, str(APPS / "nest/steps.py"), one, other, "--to", str(picture)], capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = [line.split() for line in done.stdout.splitlines()[1:]]
        self.assertEqual([row[0] for row in rows], ["4", "2"])
        self.assertEqual([float(value) for value in rows[1][5::2]], [0, 0], "the finest step is what others are compared with")
        self.assertGreater(picture.stat().st_size, 10000)

    def test_results_of_another_case(self):
        for case in CASES:
            for other in set(CASES) - {case}:
                with self.subTest(case=case, results=other):
                    self.assert_sentence(self.plot_at_once(f"{case}/plot.py", self.directory / other), str(self.directory / other))

    def test_no_results(self):
        (self.directory / "empty").mkdir(exist_ok=True)
        for case in CASES:
            for out in ("empty", "absent"):
                with self.subTest(case=case, results=out):
                    self.assert_sentence(self.plot_at_once(f"{case}/plot.py", self.directory / out), str(self.directory / out))

    def test_python_without_a_package(self):
        for name in ("numpy", "h5py", "matplotlib"):
            stub = self.directory / f"no_{name}"
            stub.mkdir()
            (stub / f"{name}.py").write_text(f"raise ModuleNotFoundError('No module named {name}')\n")
            for case in CASES:
                with self.subTest(case=case, package=name):
                    self.assert_sentence(self.plot(f"{case}/plot.py", self.directory / case, PYTHONPATH=str(stub)), name, f"python3-{name}")


if __name__ == "__main__":
    unittest.main()
