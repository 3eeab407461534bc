"""`skein converge`: its runs and files, what it refuses, that it goes on where it was stopped. How right its error bars are:
tests/validation/converge_test.py."""

import json
import pathlib
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "package"))
import pages  # noqa: E402  (from tests/package)
from driver import MPIRUN, SCENE, SKEIN, DriverTest

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
SHORT = ("--set", "time.duration=3.6", "--set", "rods.cilia.placement.counts=[2, 1]")


class Converge(DriverTest):
    def converge(self, out, *arguments, ranks=1, expect=0):
        done = subprocess.run([MPIRUN, "-n", str(ranks), SKEIN, "converge", str(self.scene), "-t", "1", "--out", str(self.directory / out), *SHORT,
                               *arguments], capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done

    def figures(self, out):
        return json.loads((self.directory / out / "converge.json").read_text())

    def test_runs_and_files(self):
        done = self.converge("all", "--tolerance", "1e-2")
        figures = self.figures("all")
        runs = figures["runs"]
        self.assertEqual([run["elements"] for run in runs], [10, 20, 40, 10])
        self.assertEqual(runs[3]["dt_s"], 0.5 * runs[0]["dt_s"])
        for run in runs:
            share = runs[0]["dt_s"] / run["dt_s"]
            self.assertAlmostEqual(share, round(share), delta=1e-9)
            summary = self.summary(f"all/{run['directory']}")
            self.assertEqual((summary["dt_s"], summary["steps"]), (run["dt_s"], run["steps"]))
            self.assertEqual(summary["rods"], 5)
            self.assertGreater(run["core_seconds"], 0)
        found = {o["name"]: o for o in figures["observables"]}
        for name in ("tip of cilia 0", "tip of cilia 1", "tip of leaning 0", "tip of leaning 2", "centre", "elastic_bend"):
            if name.startswith("tip of leaning"):
                self.assertNotIn(name, found)  # held at both ends, it does not move
                continue
            self.assertIn(name, done.stdout)
            self.assertGreaterEqual(found[name]["error_bar"]["total"], found[name]["errors"][0])
        self.assertNotIn("max_director_defect", found)
        self.assertIn("For 0.01 of the range", done.stdout)
        rows = (self.directory / "all" / "converge.csv").read_text().splitlines()
        self.assertEqual(len(rows), 1 + 4 * len(found))

        plot = subprocess.run([sys.executable, str(APPS / "figures" / "converge.py"), str(self.directory / "all")], capture_output=True, text=True,
                              timeout=100)
        self.assertEqual(plot.returncode, 0, plot.stderr)
        self.assertGreater((self.directory / "all" / "converge.png").stat().st_size, 10000)

        # The same command makes what is missing, and nothing else.
        shutil.rmtree(self.directory / "all" / runs[2]["directory"])
        stamps = {path: path.stat().st_mtime_ns for path in (self.directory / "all").glob("*/*.h5")}
        self.converge("all")
        self.assertTrue((self.directory / "all" / runs[2]["directory"] / "summary.json").exists())
        self.assertEqual({path: path.stat().st_mtime_ns for path in stamps}, stamps)
        again = {o["name"]: o for o in self.figures("all")["observables"]}
        self.assertEqual({n: o["errors"] for n, o in again.items()}, {n: o["errors"] for n, o in found.items()})

    def test_the_tour(self):
        """Its commands, as they stand there."""
        (self.directory / "apps").symlink_to(APPS)
        (self.directory / "build" / "bin").mkdir(parents=True)
        (self.directory / "build" / "bin" / "skein").symlink_to(pathlib.Path(SKEIN).resolve())
        lines = [line for block in pages.blocks(APPS.parent / "docs" / "tour.md", "### How large is my error?", "") for line in block.splitlines()]
        self.assertTrue(any("skein converge" in line for line in lines))
        for line in lines:
            done = subprocess.run(line.split(), cwd=self.directory, capture_output=True, text=True, timeout=200)
            self.assertEqual(done.returncode, 0, f"{line}: {done.stdout}{done.stderr}")
        self.assertTrue((self.directory / "out" / "magnetised_cantilever_converge" / "converge.json").exists())

    def test_any_ranks(self):
        self.converge("one", "--coarser", "--set", "rods.leaning.shape.elements=8")
        self.converge("two", "--coarser", "--set", "rods.leaning.shape.elements=8", ranks=2)
        self.assertEqual(self.figures("one")["observables"], self.figures("two")["observables"])
        self.assertEqual([run["elements"] for run in self.figures("two")["runs"]], [5, 10, 20, 10])

    def test_dry_run(self):
        done = self.converge("none", "--dry-run")
        self.assertIn("predicted core-seconds", done.stdout)
        self.assertIn("as given", done.stdout)
        self.assertFalse((self.directory / "none").exists())

    def test_nothing_of_others_is_written_over(self):
        (self.directory / "mine").mkdir()
        for name in ("converge.json", "converge.csv"):
            path = self.directory / "mine" / name
            path.write_text("a thesis")
            self.assertIn(name, self.converge("mine", expect=5).stderr)
            self.assertEqual([p.name for p in (self.directory / "mine").iterdir()], [name])
            self.assertEqual(path.read_text(), "a thesis")
            path.unlink()

    def test_what_is_refused(self):
        self.assertIn("shape.elements: 7 elements of 'leaning'", self.converge("none", "--coarser", expect=2).stderr)
        self.assertIn("hold.elements", self.converge("none", "--set", "rods.cilia.hold.elements=[4]", expect=2).stderr)
        self.scene.write_text("start.from = 'elsewhere'\n" + SCENE)
        self.assertIn("start.from", self.converge("none", expect=2).stderr)
        self.scene.write_text(SCENE)
        self.assertIn("--observable nothing", self.converge("other", "--tolerance", "1", "--observable", "nothing", expect=2).stderr)


if __name__ == "__main__":
    unittest.main()
