"""Rods of a file with lengths and radii of their own beside the same rods by keys, for every feature. The scene's own numbers are those of no rod."""

import re
import tempfile
import unittest
from copy import deepcopy
from pathlib import Path

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


if __name__ == "__main__":
    unittest.main()
