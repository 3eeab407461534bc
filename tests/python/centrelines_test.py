"""Centrelines from Python: rods of arrays, SWC trees with their joints, export of frames and the way back."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from package import ROOT, SKEIN, skein
from skein.centrelines import ragged, write

KEYS = {"material": {"density": 1100.0, "youngs_modulus": 1e6}, "section": {"radius": 0.01}, "shape": {"length": 0.5, "elements": 8}}
TREE = """# a trunk, two branches, one of which branches again
1 1 0 0 0 2 -1
2 3 0 0 10 2 1
3 3 0 1 20 2 2
4 3 5 1 28 1 3
5 3 10 1 35 1 4
6 3 -5 1 28 1 3
7 3 -9 1 38 1 6
8 3 -15 1 44 1 7
9 3 -9 5 47 1 7
10 3 -9 8 58 1 9
"""


def curves():
    for k in range(4):
        u = np.linspace(0, 1, 6 + 3 * k)
        yield np.stack([0.3 * np.cos(u), 0.3 * np.sin(u) + k, 0.4 * u], axis=1)


class Centrelines(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def scene(self, given, **keys):
        scene = skein.Scene("traces", time={"duration": 0.002}, output={"trajectory": 0.001, "precision": "double"})
        return scene.rods_from("filaments", given, **KEYS, **keys)

    def run_of(self, scene, name):
        return skein.run(scene, self.folder / name, quiet=True)

    def test_files_read_back(self):
        given, radii = list(curves()), [0.01, 0.011, 0.012, np.linspace(0.01, 0.008, 15)]
        for suffix in (".csv", ".tsv", ".npz", ".h5", ".swc"):
            path = write(self.folder / f"rods{suffix}", given, radii, unit=1e-3)
            found, thick = skein.read_centrelines(path, unit=1e-3)
            self.assertEqual(len(found), 4, suffix)
            for curve, own, radius, read in zip(given, found, radii, thick):
                np.testing.assert_allclose(own, curve, rtol=1e-13)
                np.testing.assert_allclose(read, radius, rtol=1e-13)
        ring = np.array([[1, 0, 0], [0, 1, 0.25], [-1, 0, 0], [0, -1, 0.25], [1, 0, 0]]) / 8  # numbers of single precision
        found, thick = skein.read_centrelines(write(self.folder / "rods.bcc", [*given, ring], radii=0.01))
        self.assertIsNone(thick)
        for curve, own in zip([*given, ring], found):
            np.testing.assert_allclose(own, curve, rtol=1e-7, atol=1e-9)
        np.testing.assert_array_equal(found[4], ring)
        data = (self.folder / "rods.bcc").read_bytes()
        self.assertEqual(int.from_bytes(data[-52:-48], "little", signed=True), -4)  # closed: its first point stands once
        table = self.folder / "plane.txt"
        table.write_text("# from a microscope\nwhich;Diameter;Y;X\nb;2;1;0\na;4;3;2\nb;2;5;4\n\na;4;7;6\n")
        (b, a), thick = skein.read_centrelines(table, id="which")
        np.testing.assert_array_equal(b, [[0, 1, 0], [4, 5, 0]])
        np.testing.assert_array_equal(a, [[2, 3, 0], [6, 7, 0]])
        np.testing.assert_array_equal(thick[1], [2, 2])
        self.assertIsNone(skein.read_centrelines(write(self.folder / "bare.csv", given))[1])

    def test_units_of_columns_and_voxels(self):
        """Columns name their units, and arrays the sides of a voxel; the program finds the same rods."""
        table = self.folder / "voxels.csv"
        table.write_text("filament,x[0.5 um],Y [um],z[2um],radius[nm]\na,2,4,1,300\na,20,4,1,300\na,40,8,2,250\n")
        (curve,), (thick,) = skein.read_centrelines(table, unit=7.0)
        np.testing.assert_allclose(curve, 1e-6 * np.array([[1, 4, 2], [10, 4, 2], [20, 8, 4]]), rtol=1e-14)
        np.testing.assert_allclose(thick, [3e-7, 3e-7, 2.5e-7], rtol=1e-14)
        scaled = [curve / [0.5e-6, 1e-6, 2e-6] for curve in ([np.array(curve)] * 2)]
        np.savez(self.folder / "voxels.npz", points=np.stack(scaled), voxel=[0.5e-6, 1e-6, 2e-6], radii=np.full((2, 3), 0.3))
        found, thick = skein.read_centrelines(self.folder / "voxels.npz", unit=1e-6)
        np.testing.assert_allclose(found[1], curve, rtol=1e-14)
        np.testing.assert_allclose(thick[1], 3e-7, rtol=1e-14)
        given = [1e6 * np.array(one) for one in curves()]
        plain = self.run_of(self.scene([1e-6 * one for one in given]), "plain")
        voxels = self.run_of(self.scene([one * [2, 1, 4] for one in given], voxel=(0.5e-6, 1e-6, 0.25e-6)), "voxels")
        np.testing.assert_allclose(voxels["filaments"].position[-1], plain["filaments"].position[-1], rtol=0, atol=1e-12)

    def test_files_that_are_refused(self):
        for name, text, words in (("a.csv", "x,y\n1,2\n", "names a column of rods"), ("b.csv", "id,x,y\n1,2,three\n", "row 2"), ("c.csv", "id,x,y\n", "no points"),
                                  ("d.csv", "id,x,y\n1,2\n", "row 2"), ("e.obj", "", "a file of centrelines is"), ("f.bcc", "BCC", "is cut short"), ("g.bcc", "B" * 80, "is no BCC file")):
            (self.folder / name).write_text(text)
            with self.assertRaisesRegex(skein.NotResults, f"{name}.*{words}"):
                skein.read_centrelines(self.folder / name)
        for offsets in ([0, 1, 4], [1, 4], [0, 3]):
            np.savez(self.folder / "f.npz", points=np.zeros((4, 3)), offsets=offsets)
            with self.assertRaisesRegex(skein.NotResults, "f.npz: offsets"):
                skein.read_centrelines(self.folder / "f.npz")

    def test_rods_of_arrays(self):
        given = list(curves())
        run = self.run_of(self.scene(given, radii=[0.01, 0.011, 0.012, np.linspace(0.01, 0.008, 15)]), "list")
        nodes, radii = run["filaments"].centrelines(0)
        self.assertEqual((len(nodes), nodes[0].shape, radii[0].shape), (4, (9, 3), (9,)))
        for curve, found in zip(given, nodes):
            np.testing.assert_allclose(found[[0, -1]], curve[[0, -1]], atol=1e-12)
        np.testing.assert_allclose(radii[1], 0.011)
        self.assertGreater(radii[3][0], radii[3][-1])
        equal = np.stack([curve[:6] for curve in given])
        digests = [self.run_of(self.scene(array), name).summary["digest"] for name, array in (("array", equal), ("lists", list(equal)))]
        self.assertEqual(*digests)
        scaled = self.run_of(self.scene([curve * 2.0**20 for curve in given], radii=0.01 * 2.0**20, unit=2.0**-20), "scaled").summary["digest"]
        self.assertEqual(scaled, self.run_of(self.scene(given, radii=0.01), "plain").summary["digest"])
        self.run_of(self.scene(given, normals=[[0, 0, 1.0]] * 4), "normal")
        self.run_of(self.scene(given, normals=[np.tile([0, 0, 1.0], (len(curve), 1)) for curve in given]), "normals")

    def test_arrays_that_are_wrong(self):
        given = list(curves())
        for arrays, keys, words in ((given[:1] + [np.zeros((5, 2))], {}, r"centreline 1 has the shape \[5, 2\]"), ([], {}, "no centrelines"), ([np.zeros((1, 3))], {}, "fewer than two points"),
                                    (np.zeros((3, 3)), {}, r"\[rods, points, 3\]"), (given, {"radii": [1, 2]}, "radii of 2 rods beside 4"), (given, {"radii": [[1.0, 2.0]] * 4}, "of centreline 0 have the shape")):
            with self.assertRaisesRegex(ValueError, words):
                self.scene(arrays, **keys)
        with self.assertRaisesRegex(skein.RunFailed, "not a finite number"):
            self.scene([np.where(np.arange(18).reshape(6, 3) == 7, np.nan, given[0])]).check()

    def test_trees(self):
        path = self.folder / "tree.swc"
        path.write_text(TREE)
        tree = skein.SwcTree(path)
        self.assertEqual([list(tree.ids[rows]) for rows in tree.sections], [[1, 2, 3], [3, 4, 5], [3, 6, 7], [7, 8], [7, 9, 10]])
        self.assertEqual((tree.joints(), tree.roots()), ([([0, 0, 2, 2], [1, 2, 3, 4], [1.0, 0.0])], [0]))
        scene = skein.swc(path, "vessels", elements=6, joined=False, time={"duration": 1e-6, "dt": 1e-9}, output={"trajectory": 1e-6, "precision": "double"})
        nodes, radii = self.run_of(scene, "tree")["vessels"].centrelines(0)
        for rows, found in zip(tree.sections, nodes):  # the program's rods are these sections
            np.testing.assert_allclose(found[[0, -1]], 1e-6 * tree.points[rows[[0, -1]]], atol=1e-15)
        np.testing.assert_allclose(radii[1][-1], 1e-6, rtol=0.1)
        joined = skein.swc(path, "vessels", elements=6, material={"density": 1100.0, "youngs_modulus": 1e5}, time={"duration": 0.02}, load=[{"kind": "gravity", "acceleration": [3.0, 2.0, 1.0]}])
        with skein.Simulation(joined, threads=1) as run:
            start = run["vessels"].position.copy()
            places = run.step(100)["vessels"].position
        self.assertGreater(np.abs(places - start).max(), 1e-11)  # m, of a fall by 1e-10
        for first, second in ((0, 1), (0, 2), (2, 3), (2, 4)): np.testing.assert_array_equal(places[first, -1], places[second, 0], err_msg="sections stay joined")
        joint = skein.swc(path, "vessels", joint={"stiffness": 1.0, "torsional_stiffness": 1e-9})["joint.0"]
        self.assertEqual((joint["between"], joint["first"], joint["second"], joint["at"], joint["stiffness"]), (["vessels", "vessels"], [0, 0, 2, 2], [1, 2, 3, 4], [1.0, 0.0], 1.0))
        path.write_text("1 1 0 0 0 1 -1\n2 1 1 0 0 1 1\n3 1 0 1 0 1 1\n4 1 0 0 1 1 1\n")  # three sections from a root
        self.assertEqual(skein.SwcTree(path).joints(), [([0, 0], [1, 2], [0.0, 0.0])])
        for text, words in (("1 1 0 0 0 1 -1\n2 1 1 0 0 1 9\n", "tree.swc:2: point 2: its parent 9 is missing"), ("1 1 0 0 0 1 2\n2 1 1 0 0 1 1\n", "lead back to itself"), ("1 1 0 0\n", "expected 7 numbers"),
                            ("", "no points"), ("1 1 0 0 0 1 -1\n1 1 1 0 0 1 1\n", "has the id of line 1"), ("1 1 0 0 nan 1 -1\n", "must be finite")):
            path.write_text(text)
            with self.assertRaisesRegex(skein.Damaged, words):
                skein.SwcTree(path)

    def test_export_and_the_way_back(self):
        run = self.run_of(self.scene(list(curves()), radii=0.01), "out")
        nodes, radii = run["filaments"].centrelines()
        for suffix in (".csv", ".tsv", ".swc", ".npz", ".h5", ".bcc"):
            with self.subTest(suffix):
                file = self.folder / f"rods{suffix}"
                done = subprocess.run([SKEIN, "export", str(run.directory), "--to", str(file), "--unit", "1e-3", "--json"], capture_output=True, text=True, env=dict(os.environ, PYTHON=sys.executable))
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(json.loads(done.stdout)["rods"], 4)
                again = skein.Scene("again", time={"duration": 0.002}, output={"trajectory": 0.001, "precision": "double"})
                again.rods("filaments", **KEYS, placement={"kind": "file", "file": str(file), "unit": 1e-3})
                found, found_radii = self.run_of(again, f"again{suffix}")["filaments"].centrelines(0)
                np.testing.assert_allclose(found, nodes, atol=1e-4)  # resampled: nodes move along the curve
                np.testing.assert_allclose([f[[0, -1]] for f in found], [n[[0, -1]] for n in nodes], atol=1e-12 if suffix != ".bcc" else 1e-6)  # single precision
                np.testing.assert_allclose(found_radii, radii, rtol=1e-9)
        for words, told in ((("--to", "rods.xyz"), "a file of rods is one of"), (("--to", "rods.csv", "--group", "fil"), "no group of rods 'fil'"), (("--to", "rods.csv", "--unit", "0"), "above 0")):
            done = subprocess.run([SKEIN, "export", str(run.directory), *words], capture_output=True, text=True, cwd=self.folder, env=dict(os.environ, PYTHON=sys.executable))
            self.assertEqual(done.returncode, 2)
            self.assertIn(told, done.stderr)

    def test_the_example_of_the_page(self):
        example = next(text for text in re.findall(r"```python\n(.*?)```", (ROOT / "docs/traced_files.md").read_text(), re.S) if "rods_from" in text)
        try:
            import pandas  # noqa: F401
        except ModuleNotFoundError:
            example = "".join(line for line in example.splitlines(True) if "to_pandas" not in line)
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(self.folder)
        names = {}
        exec(example, names)
        self.assertEqual((len(names["nodes"]), names["nodes"][0].shape), (5, (21, 3)))

    def test_tables(self):
        try:
            import pandas  # noqa: F401
        except ModuleNotFoundError:
            self.skipTest("no pandas")
        run = self.run_of(self.scene(list(curves())), "out")
        table = run["filaments"].to_pandas()
        self.assertEqual((list(table), len(table)), (["rod", "node", "x", "y", "z", "radius"], 4 * 9))
        np.testing.assert_array_equal(table[table.rod == 2][["x", "y", "z"]], run["filaments"].position[-1][2])

    def test_formats_of_write(self):
        points, offsets = ragged(list(curves()))
        path = write(self.folder / "rods.npz", list(curves()), 0.01)
        with np.load(path) as found:
            np.testing.assert_array_equal(found["points"], points)
            np.testing.assert_array_equal(found["offsets"], offsets)
            np.testing.assert_array_equal(found["radii"], 0.01)
        with self.assertRaisesRegex(skein.NotResults, "SWC needs radii"):
            write(self.folder / "rods.swc", list(curves()))


if __name__ == "__main__":
    unittest.main()
