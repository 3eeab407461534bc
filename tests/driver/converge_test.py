"""`skein converge`: its runs and files, what it refuses, that it goes on where it was stopped. How right its error bars are:
tests/validation/converge_test.py."""

import json
import pathlib
import shutil
import subprocess
import sys
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "package"))
import pages  # noqa: E402  (from tests/package)
from driver import SCENE, SKEIN, STICKS, DriverTest, table

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
SHORT = ("--set", "time.duration=3.6", "--set", "rods.cilia.placement.counts=[2, 1]")

LAW = {"law": "hertz", "stiffness": 1e5, "damping": 10.0, "friction": "memory", "static_friction": 0.4}
# Sticks that fall into a heap.
HEAP = (table("[time]", {"duration": 0.24}) + STICKS
        + table("[rods.placement]", {"kind": "packing", "count": 8, "seed": 3, "region": "cylinder", "radius": 0.08, "height": 0.08,
                                      "elevation": [-20.0, 20.0]})
        + table("[[load]]", {"kind": "gravity"}) + table("[contact]", LAW)
        + table("[[wall]]", {"name": "side", "kind": "tube", "radius": 0.08} | LAW)
        + table("[[wall]]", {"name": "floor", "kind": "plane"} | LAW) + table("[output]", {"series": 0.02}))


class Converge(DriverTest):
    def converge(self, out, *arguments, ranks=1, expect=0, sets=SHORT):
        return self.skein_says("converge", self.scene, "-t", "1", "--out", self.directory / out, *sets, *arguments, ranks=ranks, expect=expect)

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

    def test_contact(self):
        """A heap is told to be not smooth; the bounds hold what runs of 4 and 8 times the elements say."""
        self.scene.write_text(HEAP)
        done = self.converge("heap", "--tolerance", "1e-2", sets=())
        self.assertIn("laws of contacts and walls stay as they are", done.stdout)
        self.assertIn("not smooth: a bound from the spread of the runs", done.stdout)
        found = {o["name"]: o for o in self.figures("heap")["observables"]}
        for name in ("contacts", "contact_energy", "floor_force", "elastic_bend"):
            self.assertEqual(found[name]["convergence"], "not smooth", name)
            self.assertIsNone(found[name]["richardson_at_end"])
        self.run_skein("finer", "--set", "rods.sticks.shape.elements=48")
        given, finer = self.series("heap/" + self.figures("heap")["runs"][0]["directory"]), self.series("finer")
        centre = lambda series: numpy.stack([series[f"centre_{axis}m"] for axis in "xyz"], axis=1)
        self.assertLess(numpy.linalg.norm(centre(given) - centre(finer), axis=1).max(), found["centre"]["error_bar"]["total"])
        self.assertLess(numpy.abs(given["potentialJ"] - finer["potentialJ"]).max(), found["potential"]["error_bar"]["total"])

    def test_a_run_that_ends_itself(self):
        """A lid ends its runs at times of their own: what all have is compared, and that is told."""
        lid = table("[[wall]]", {"name": "lid", "kind": "plane", "point": [0.0, 0.0, 0.1], "normal": [0.0, 0.0, -1.0]} | LAW)
        servo = table("[wall.servo]", {"speed": 0.5, "watch": "floor", "area": 0.0201, "turn_back_above": 300.0, "turn_forth_below": 45.0,
                                       "cycles": 1, "ends_run": True})
        self.scene.write_text(HEAP.replace("[output]", lid + servo + "[output]"))
        done = self.converge("lid", "--set", "output.series=0.005", "--set", "time.duration=1.0", sets=())
        self.assertEqual(done.stdout.count("ended early"), 4, done.stdout)
        ends = [self.series(f"lid/{run['directory']}")["times"][-1] for run in self.figures("lid")["runs"]]
        self.assertGreater(min(ends), 0.05)
        self.assertLess(max(ends), 0.995)
        self.assertIn(f"compared up to {min(ends):g} s", done.stdout)

    def test_progress(self):
        done = self.converge("all", "--progress", "lines", "--set", "time.duration=36")
        lines = [line for line in done.stdout.splitlines() if "ETA" in line]
        self.assertEqual([line.split("  ")[0] for line in lines],
                         [f"run {number} of 4: {n} elements" for number, n in ((1, 10), (2, 10), (3, 20), (4, 40))])
        for line in lines:
            self.assertRegex(line, r"step (\d+)/\1  100.0 %.*ETA 0.0 s, all runs ")
        self.assertIn("all runs 0.0 s", lines[-1])
        self.assertNotIn("all runs 0.0 s", lines[0])

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

    def test_a_run_names_its_method(self):
        self.assertEqual(json.loads(self.converge("none", "--dry-run", "--json").stdout)[3]["steps"] > 0, True)
        self.converge("all", "--coarser", "--set", "rods.leaning.shape.elements=8")
        self.assertEqual(self.figures("all")["method"], "steps")

    def test_overwrite(self):
        words = ("--coarser", "--set", "rods.leaning.shape.elements=8")
        self.converge("all", *words)
        self.converge("all", *words, "--overwrite")
        for run in self.figures("all")["runs"]:
            self.assertTrue((self.directory / "all" / run["directory"] / "previous_1").exists())


# A cantilever under a load at its tip, and a column that buckles at 0.0194 N.
ROD = """
time.duration = 1.0
[[rods]]
name = "rod"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6, law = "linear"}
section.radius = 0.01
shape = {length = 1.0, elements = 8}
[[load]]
kind = "end_force"
end = [0.01, 0.0, -0.002]
"""
FREE = ROD.replace('start = "clamped"\n', "")
BUCKLING = ("--along", "load.0.end.2", "--to", "-0.025", "--set", "load.0.end=[0, 0, -0.01]")
METHODS = {"equilibrium": ("--equilibrium",), "modes": ("--modes", "3"), "path": BUCKLING}


class Solutions(DriverTest):
    def converge(self, out, *arguments, text=ROD, **layout):
        return self.solve_scene("converge", out, *arguments, text=text, **layout)

    def figures(self, out):
        figures = json.loads((self.directory / out / "converge.json").read_text())
        return figures, {o["name"]: o for o in figures["observables"]}

    def test_runs_are_solutions(self):
        """Three of them, without a step, that are what the command of the name finds."""
        for method, words in METHODS.items():
            with self.subTest(method=method):
                done = self.converge(method, *words, "--tolerance", "1e-2")
                figures, found = self.figures(method)
                self.assertEqual((figures["method"], figures["at_rest"]), (method, True))
                self.assertEqual([run["elements"] for run in figures["runs"]], [8, 16, 32])
                self.assertEqual([run["directory"] for run in figures["runs"]], [f"{n}_{method}" for n in (8, 16, 32)])
                self.assertNotIn("dt_s", figures["runs"][0] | figures["advice"])
                self.assertTrue(all(run["core_seconds"] > 0 for run in figures["runs"]))
                self.assertIn("by Newton's method", done.stdout)
                self.assertIn(f"For 0.01 of the range: {figures['advice']['elements']} elements, about", done.stdout)
                self.assertEqual({o["error_bar"]["time"] for o in found.values()}, {0})
                alone = ("--count", *words[1:]) if method == "modes" else words if method == "path" else ()
                self.solve_scene(method, "alone_" + method, *alone, "--set", "rods.rod.shape.elements=16", text=ROD)
                self.assertEqual(self.digest(f"{method}/16_{method}"), self.digest("alone_" + method))

    def test_figures_of_solutions(self):
        self.converge("rest", "--equilibrium")
        tip = self.figures("rest")[1]["tip of rod 0"]
        self.assertEqual(tip["convergence"], "second order")
        self.converge("modes", "--modes", "3")
        found = self.figures("modes")[1]
        self.assertEqual(list(found), ["frequency_1", "frequency_2", "frequency_3"])
        self.assertEqual({o["unit"] for o in found.values()}, {"Hz"})
        self.converge("path", *BUCKLING)
        found = self.figures("path")[1]
        euler = -numpy.pi**2 / 4 * 1e6 * numpy.pi * 0.01**4 / 4
        self.assertAlmostEqual(found["branch_1"]["richardson_at_end"][0] / euler, 1, delta=1e-3)
        self.assertEqual([name for name, o in found.items() if o["counts"]], [name for name in found if name.startswith("branch_")])
        self.assertEqual(found["branch_1"]["unit"], "N")

    def test_what_not_all_solutions_have(self):
        """Eight elements have 48 modes."""
        done = self.converge("modes", "--modes", "50")
        self.assertIn("note: not all solutions have frequency_49, ..., frequency_50\n", done.stdout)
        self.assertEqual(len(self.figures("modes")[1]), 48)

    def test_a_dry_run(self):
        done = self.converge("none", "--equilibrium", "--coarser", "--dry-run", "--json")
        self.assertEqual(json.loads(done.stdout), [{"name": f"{n}_equilibrium", "elements": n} for n in (4, 8, 16)])
        self.assertFalse((self.directory / "none").exists())

    def test_what_tolerance_asks_for_is_met(self):
        """By the solution of the elements that it says, against one of many."""
        self.converge("rest", "--equilibrium", "--tolerance", "1e-3", "--observable", "tip of rod 0")
        figures, found = self.figures("rest")
        tips = {}
        for n in (figures["advice"]["elements"], 512):
            self.solve_scene("equilibrium", f"n{n}", "--set", f"rods.rod.shape.elements={n}", "--set", "output.tips=1", "--set",
                             "output.precision=double", text=ROD)
            tips[n] = self.frames(f"n{n}", "tips")["groups/rod/position"][-1, 0]
        share = numpy.linalg.norm(numpy.subtract(*tips.values())) / found["tip of rod 0"]["range"]
        self.assertLess(share, 1e-3)
        self.assertGreater(share, 3e-4)

    def test_any_ranks(self):
        text = ROD.replace('name = "rod"', 'name = "rod"\nplacement = {kind = "line", counts = [3], spacing = [1.0]}')
        for method in ("equilibrium", "modes"):
            self.converge(method + "_1", *METHODS[method], text=text)
            self.converge(method + "_2", *METHODS[method], text=text, ranks=2)
            self.assertEqual(self.figures(method + "_1")[0]["observables"], self.figures(method + "_2")[0]["observables"])
        self.assertIn("start it without mpirun", self.converge("path", *BUCKLING, ranks=2, expect=2).stderr)

    def test_results_that_exist_are_safe(self):
        self.converge("rest", "--equilibrium")
        before = self.digest("rest/8_equilibrium")
        self.assertIn("8_equilibrium' holds results", self.converge("rest", "--equilibrium", expect=2).stderr)
        self.converge("rest", "--equilibrium", "--overwrite", "--set", "load.0.end.2=-0.003")
        self.assertNotEqual(self.digest("rest/8_equilibrium"), before)
        self.assertEqual(json.loads((self.directory / "rest/8_equilibrium/previous_1/summary.json").read_text())["digest"], before)

    def test_what_is_refused(self):
        self.assertIn("solution 8_equilibrium: no equilibrium was found", self.converge("out", "--equilibrium", text=FREE, expect=4).stderr)
        self.assertFalse((self.directory / "out/converge.json").exists())
        early = self.converge("early", *BUCKLING, "--points", "3", expect=4).stderr
        self.assertIn("solution 8_path: the path ends early: its 3 points are used up; --points allows more", early)
        for words, said in ((("--equilibrium", "--modes", "2"), "excludes"), (("--to", "1"), "--along"), (("--along", "load.0.end.2"), "--to"),
                            (("--equilibrium", *BUCKLING), "excludes"), (("--modes", "0"), "--modes")):
            self.assertIn(said, self.converge("none", *words, expect=2).stderr)
        stages = ROD + '[[stage]]\nname = "one"\nduration = 0.5\n[[stage]]\nname = "two"\n'
        self.assertIn("[[stage]]", self.converge("none", "--equilibrium", text=stages, expect=2).stderr)
        self.assertFalse((self.directory / "none").exists())


if __name__ == "__main__":
    unittest.main()
