"""Commands that solve scenes: what they refuse before any work, what they write, and what they say of stability."""

import csv
import json
import subprocess
import unittest

from driver import DriverTest, FLUID_OF_RODS, MPIRUN, SKEIN, launch, rods_in_a_fluid

ROD = """
time.duration = 1.0
[[rods]]
name = "rod"
start = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 8}
[[load]]
kind = "end_force"
end = [0.0, 0.0, -1e-3]
"""
LAYER = """
[[rods]]
name = "layer_{i}"
start = "clamped"
material = {{density = 1200.0, youngs_modulus = 5e6}}
section.radius = 1.5e-3
shape = {{length = 0.2, elements = 20}}
placement = {{kind = "lattice", counts = [1, 10], spacing = [1.0, 4e-3], origin = [0.0, 0.0, {height}], tangent = [1.0, {across}, 0.0]}}
"""
TANGLE = """
time.duration = 1.0
contact = {stiffness = "auto", friction = "none"}
load = [{kind = "gravity", acceleration = [0.0, 0.0, -9.81]}]
""" + "".join(LAYER.format(i=i, height=3.2e-3 * i, across=0.07 * (-1)**i) for i in range(10)) # hair that slides long
FREE = ROD.replace('start = "clamped"\n', "")
TWISTED = ROD.replace('kind = "end_force"\nend = [0.0, 0.0, -1e-3]', 'kind = "formula"\nat = "end"\ncouple = ["1e-5", "1e-5", "1e-5"]')
ALONG = ("--along", "load.0.end.2", "--to", "-0.002")
COMMANDS = {"equilibrium": (), "modes": ("--count", "2"), "path": ALONG}


class Solving(DriverTest):
    def solve(self, command, *words, code=0, ranks=1, text=ROD, out="out"):
        self.scene.write_text(text)
        return self.skein_says(command, self.scene, "--out", self.directory / out, "--threads", "1", *words, expect=code, ranks=ranks)

    def table(self, name, out="out"):
        with (self.directory / out / name).open(newline="") as file:
            return list(csv.reader(file))

    def test_a_directory_with_results_is_refused(self):
        for command, words in COMMANDS.items():
            for ranks in (1, 2) if command != "path" else (1,):
                with self.subTest(command=command, ranks=ranks):
                    out = f"{command}_{ranks}"
                    self.solve(command, *words, ranks=ranks, out=out)
                    before = self.results(out)
                    said = self.solve(command, *words, ranks=ranks, out=out, code=2).stderr
                    self.assertIn(f"{out}' holds results", said)
                    self.assertIn("--overwrite", said)
                    self.assertEqual(said.count("error: "), 1)
                    self.assertEqual(self.results(out), before)
                    self.solve(command, *words, "--overwrite", ranks=ranks, out=out)
                    self.assertTrue((self.directory / out / "previous_1/summary.json").exists())

    def test_a_directory_of_a_run_is_refused(self):
        self.scene.write_text(ROD)
        self.run_skein("out", "--steps", "10", "--set", "time.duration=0.01")
        for command, words in COMMANDS.items():
            self.assertIn("holds results", self.solve(command, *words, code=2).stderr)

    def test_scenes_that_nothing_is_solved_of(self):
        flow = "time.duration = 0.1\n" + FLUID_OF_RODS
        for command, words in COMMANDS.items():
            if command == "path":
                words = ("--along", "fluid.viscosity", "--to", "1")
            self.assertIn("the scene has no rods or bodies to solve for", self.solve(command, *words, code=2, text=flow).stderr)
            both = flow + rods_in_a_fluid((3.0, 2e4), (3.0, 2e4), [0.0, 0.0, 0.0])
            self.assertIn("are a flow problem: run the scene instead", self.solve(command, *words, code=2, text=both).stderr)
        self.assertFalse((self.directory / "out").exists())

    def test_stability_that_is_not_known(self):
        document = json.loads(self.solve("equilibrium", "--json", text=TWISTED).stdout)
        self.assertEqual((document["unstable_pieces"], document["unknown_stability"]), (0, 1))
        said = self.solve("equilibrium", "--stable", "--overwrite", text=TWISTED, code=10)
        self.assertIn("error: the stability of the equilibrium: not known, as the loads or bearings have no potential", said.stderr)
        text = self.solve("path", "--along", "rods.rod.material.youngs_modulus", "--to", "3e6", text=TWISTED, out="path").stdout
        self.assertIn("stability not known", text)
        self.assertNotIn(" stable", text)

    def test_a_plan_costs_a_correction_and_writes_nothing(self):
        for ranks in (1, 2):
            plan = json.loads(self.solve("equilibrium", "--dry-run", "--json", ranks=ranks).stdout)
            self.assertEqual((plan["pieces"], plan["unknowns"], plan["factor"]), (1, 48, "band L D L^T"))
            self.assertEqual(plan["factor_bytes"], 8 * 48 * 12)  # the diagonal and 11 below: both slots of an element
            self.assertGreater(plan["seconds_per_correction"], 0)
            self.assertFalse((self.directory / "out").exists())
        document = json.loads(self.solve("equilibrium", "--json").stdout)
        self.assertEqual([document[key] for key in ("factor", "factor_bytes")], [plan[key] for key in ("factor", "factor_bytes")])

    def test_a_solution_stops_when_it_is_told(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.scene.write_text(TANGLE)
                command = [SKEIN, "equilibrium", self.scene, "--out", self.directory / "out", "--threads", "1"]
                running = subprocess.Popen([str(word) for word in ([MPIRUN, "-n", ranks] if ranks > 1 else []) + command],
                                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                line = ""
                while "Plan:" not in line:
                    line = running.stdout.readline()
                    self.assertTrue(line, "it ended before its plan")
                self.assertIn("corrections", running.stdout.readline())
                running.terminate()
                said = running.communicate(timeout=60)[0]
                self.assertEqual(running.returncode, 3 if ranks == 1 else 1, said)  # mpirun has its own
                self.assertIn("error: stopped by a signal while the equilibrium was looked for", said)
                self.assertEqual([file.name for file in (self.directory / "out").iterdir() if file.suffix == ".h5"], [])

    def test_points_of_a_path(self):
        text = self.solve("path", *ALONG, "--points", "3").stdout
        self.assertIn("The path ends: its 3 points are used up; --points allows more", text)
        self.assertTrue(self.summary("out")["finished"])
        heading, *rows = self.table("path.csv")
        self.assertEqual((heading[2], len(rows)), ("load.0.end.2[N]", 3))
        document = json.loads(self.solve("path", *ALONG, "--overwrite", "--json").stdout)
        self.assertEqual((document["key"], document["unit"], document["complete"], document["limits"]), ("load.0.end.2", "N", True, []))
        self.assertEqual(document["points"][-1], {"value": -0.002, "place": "end", "negative": 0, "branch": 0})
        self.assertTrue(self.summary("out")["finished"])

    def test_numbers_that_no_path_goes_along(self):
        self.solve("path", *ALONG)
        before = self.results("out")
        for key, to, words in (("rods.0.shape.elements", "16", "skein converge"), ("rods.0.name", "2", "is no number of"), ("load.0.end", "1", "is no number of"),
                               ("rods.0.section.radius", "-1", "must be above 0"), ("load.0.end.2", "-1e-3", "give another value")):
            with self.subTest(key=key):
                self.assertIn(words, self.solve("path", "--along", key, "--to", to, "--overwrite", code=2).stderr)
        self.assertEqual(self.results("out"), before)
        self.assertFalse((self.directory / "out/previous_1").exists())

    def test_names_of_modes_are_plain(self):
        document = json.loads(self.solve("modes", "--count", "2", "--json").stdout)
        self.assertEqual([mode["of"] for mode in document["modes"]], ["rod"] * 2)
        self.assertEqual([row[-1] for row in self.table("modes.csv")], ["of", "rod", "rod"])
        two = ROD.replace('name = "rod"', 'name = "rod"\nplacement = {kind = "line", counts = [2], spacing = [1.0]}')
        self.solve("modes", "--count", "2", text=two, out="two")
        self.assertEqual({row[-1] for row in self.table("modes.csv", "two")[1:]}, {"rod 0 of rod", "rod 1 of rod"})

    def test_a_failure_is_told_once_and_last(self):
        self.scene.write_text(FREE)
        done = launch("equilibrium", self.scene, "--out", self.directory / "out", "--json", "--threads", "1")
        self.assertEqual((done.returncode, done.stdout), (4, ""))
        self.assertEqual(done.stderr.count("Newton:"), 1)
        self.assertEqual(done.stderr.count("nothing balances"), 1)
        self.assertLess(done.stderr.index("Newton:"), done.stderr.index("error: "))
        self.assertNotIn("Stability:", done.stderr)


if __name__ == "__main__":
    unittest.main()
