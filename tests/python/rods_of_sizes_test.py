"""Rods of a file with lengths and radii of their own beside the same rods by keys, for every feature. The scene's own numbers are those of no rod."""

import re
import tempfile
import unittest
from copy import deepcopy
from pathlib import Path

import h5py
import numpy as np

from feature_rows import BASE, HEIGHT, RADIUS, group, rows_of, scene_of
from package import skein

# Axes of the two rods of the file do not cross, nor touch; the right rod of the base scene touches both.
FIRST = {"origin": [-0.1, 0.0, HEIGHT], "tangent": [1.0, 0.0, 0.0]}
SECOND = {"origin": [-0.1, 0.02, HEIGHT], "tangent": [1.0, 0.02, 0.0]}
LENGTH, THICK = 0.17, 1.02 * RADIUS
NOMINAL = {"length": 0.31, "radius": 1.7}  # m, and over the true one
# Sets of rows that say where rods are, or that name one rod alone.
ROUNDING = {"time.relax": 1e-11}  # m, where that of the file's directions grows: until a relaxation has converged
LEFT_OUT = {"placement": "the file takes its place", "probe": "of one rod"}


def twin(scene):
    """Adds to a scene a group `second` with all that `left` has."""
    one = deepcopy(group(scene, "left")) | {"name": "second"}
    group(scene, "left")["placement"], one["placement"] = FIRST, SECOND
    one["shape"]["length"] = LENGTH
    for key in ("radius", "radius_2"):
        if key in one["section"]: one["section"][key] *= THICK / RADIUS
    scene["rods"].insert(1, one)
    for table in scene.get("load", []) + scene.get("damping", []):
        if "left" in table.get("rods", []): table["rods"].append("second")
    for joint in list(scene.get("joint", [])):
        if joint["between"] == ["left", "world"] or (joint["between"] == ["left", "right"] and joint.get("pairs") != "listed"):
            scene["joint"].insert(scene["joint"].index(joint) + 1, joint | {"between": ["second", joint["between"][1]]})
    for pair in list(scene.get("contact_pair", [])): scene["contact_pair"].append(pair | {"between": ["second", "right"]})
    for stage in scene.get("stage", []):
        for change in list(stage.get("change", [])): stage["change"].append(change.replace("rods.left.", "rods.second."))
    return scene


class RodsOfSizes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        folder = Path(cls.folder.name)
        cls.rows = rows_of(folder)
        cls.file = folder / "unlike.csv"
        rows = [(*FIRST["origin"], *FIRST["tangent"], group(BASE, "left")["shape"]["length"], RADIUS), (*SECOND["origin"], *SECOND["tangent"], LENGTH, THICK)]
        cls.file.write_text("x,y,z,tx,ty,tz,length,radius\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def of_file(self, row):
        scene = scene_of((row, "left"))
        one = group(scene, "left")
        one["placement"] = {"kind": "file", "file": str(self.file)}
        one["shape"]["length"] = NOMINAL["length"]
        for key in ("radius", "radius_2"):
            if key in one["section"]: one["section"][key] *= NOMINAL["radius"]
        return scene

    def positions(self, scene, steps, threads=1):
        with skein.Simulation(skein.Scene("unlike", **scene), threads=threads) as run:
            run.step(steps)
            return {rods["name"]: np.array(run[rods["name"]].position) for rods in scene["rods"]}

    def test_as_by_keys(self):
        tried = 0
        for row in self.rows:
            if row.sets in LEFT_OUT or row.looks: continue
            with self.subTest(row.name):
                by_keys = self.positions(twin(scene_of((row, "left"))), row.steps)
                both = np.stack([by_keys["left"], by_keys.pop("second")], axis=1)  # by copy of an assembly
                by_keys["left"] = both.reshape(-1, *both.shape[2:])
                of_file = self.positions(self.of_file(row), row.steps)
                tried += 1
                for name, expected in by_keys.items():
                    np.testing.assert_allclose(of_file[name], expected, rtol=0, atol=ROUNDING.get(row.name, 3e-15), err_msg=name)
        self.assertGreater(tried, 110)

    def test_traced_rings_rest(self):
        """A ring through nodes that lie in no plane is at rest where it was traced, in contact and walls too; its last node is its first."""
        angle = np.linspace(0, 2 * np.pi, 25)
        nodes = np.stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), 0.02 * np.sin(2 * angle)], axis=1)
        nodes[-1] = nodes[0]
        file = Path(self.folder.name) / "rings.h5"
        with h5py.File(file, "w") as rings: rings["nodes"] = np.stack([nodes, nodes * 0.8])
        group = {"name": "rings", "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 1e-3}, "shape": {"length": 1.0, "elements": 24, "closed": True},
                 "placement": {"kind": "file", "file": str(file)}}
        touching = {"contact": {"law": "linear", "stiffness": 100.0}, "wall": [{"name": "floor", "kind": "plane", "point": [0.0, 0.0, -1.0], "stiffness": 100.0}]}
        for name, tables in {"alone": {}, "touching": touching}.items():
            with self.subTest(name), skein.Simulation(skein.Scene("rings", time={"duration": 0.1}, rods=[group], **tables), threads=1) as run:
                start = run["rings"].position.copy()
                np.testing.assert_allclose(start, np.stack([nodes, nodes * 0.8]), rtol=0, atol=1e-15)
                np.testing.assert_allclose(run.step(100)["rings"].position, start, rtol=0, atol=1e-11)
        with h5py.File(file, "w") as rings: rings["nodes"] = np.stack([nodes, nodes + np.eye(25)[-1][:, None] * 1e-3])
        with self.assertRaisesRegex(skein.RunFailed, "rod 1 of the file is to be a ring"): skein.Simulation(skein.Scene("open", time={"duration": 0.1}, rods=[group]))

    def test_formulas_along_rods_know_their_lengths(self):
        group = {"name": "left", "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 1e-3, "radius_formula": "1e-3*(2 - s/L)"},
                 "shape": {"length": 1.0, "elements": 8, "rest_curvature_formula": ["2*s/L", "10*s^2", "0"]}}
        file = Path(self.folder.name) / "lengths.csv"
        file.write_text("x,y,z,tx,ty,tz,length\n0,0,0,0,0,1,0.2\n0.5,0,0,0,0,1,0.3\n")
        scene = {"time": {"duration": 0.01}, "load": [{"kind": "gravity", "acceleration": [0.0, 1.0, 0.0]}]}
        for rod, (origin, length) in enumerate([([0.0, 0.0, 0.0], 0.2), ([0.5, 0.0, 0.0], 0.3)]):
            one = group | {"name": "one", "shape": group["shape"] | {"length": length}, "placement": {"origin": origin, "tangent": [0.0, 0.0, 1.0]}}
            dt = {"time": scene["time"] | {"dt": 1e-5}}
            with skein.Simulation(skein.Scene("by_keys", **(scene | dt | {"rods": [one]})), threads=1) as run: by_keys = run.step(40)["one"].position[0].copy()
            with skein.Simulation(skein.Scene("of_file", **(scene | dt | {"rods": [group | {"placement": {"kind": "file", "file": str(file)}}]})), threads=1) as run:
                np.testing.assert_allclose(run.step(40)["left"].position[rod], by_keys, rtol=0, atol=1e-14)


if __name__ == "__main__":
    unittest.main()
