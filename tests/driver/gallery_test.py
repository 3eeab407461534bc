"""Every scene with [[expect]] finds its values, with tolerances near the errors that are measured; without its loads, contact, fluid, joints or motions
it misses them. SKEIN_ONLY: name of the one scene to look at."""

import concurrent.futures
import copy
import json
import os
import pathlib
import subprocess
import tempfile
import tomllib
import unittest

from driver import SKEIN
from scene_text import scene_text

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
LARGEST = 3.0  # tolerance over the error that is measured
FLOOR = 1e-11  # of tolerances: what differs by rounding alone
NOT_MET = 9
# Cause of a value: keys that are taken out with it.
CAUSES = {
    "load": ["load"],
    "contact": ["contact"],
    "fluid": ["fluid", "fluid_output", "obstacle", "output.fields"],
    "joint": ["joint"],
    "start_motion": ["rods.start_motion"],
    "end_motion": ["rods.end_motion"],
    "velocity": ["rods.shape.velocity", "bodies.velocity"],
    "angular_velocity": ["rods.shape.angular_velocity", "bodies.angular_velocity"],
    "wall": ["wall"],
    "rest_curvature": ["rods.shape.rest_curvature"],
    "obstacle": ["obstacle"],
    "acceleration": ["fluid.acceleration"],
    "start_of_fluid": ["fluid.velocity_formula"],
    "inflow": ["fluid.inflow", "fluid.along_x"],
    "moving_wall": ["fluid.lower_wall_velocity", "fluid.frequency"],
}
# Causes that a value outlives: a load that chooses the way in which a rod buckles, which rounding does too; the link of a ring at any rest shape;
# weight on a dish, which rods carry that pass through each other too.
NOT_NEEDED = {("plectoneme", "load"), ("minicircle", "rest_curvature"), ("dish", "contact")}


def without(scene, path):
    """The scene without a key; whether it had it."""
    head, _, tail = path.partition(".")
    if not tail:
        return scene.pop(head, None) is not None
    tables = scene.get(head, [])
    return any([without(table, tail) for table in (tables if isinstance(tables, list) else [tables])])


def expect(scene, *words):
    with tempfile.TemporaryDirectory() as out:
        return subprocess.run([SKEIN, "expect", str(scene), "--out", f"{out}/run", "--threads", "1", *words], capture_output=True, text=True, check=False)


class Gallery(unittest.TestCase):
    def setUp(self):
        only = os.environ.get("SKEIN_ONLY")
        self.scenes = [path for path in sorted(APPS.rglob("*.toml")) if "[[expect]]" in path.read_text() and only in (None, path.stem)]
        self.pool = concurrent.futures.ThreadPoolExecutor(2)
        self.addCleanup(self.pool.shutdown)

    def test_values_are_found(self):
        self.assertTrue(self.scenes)
        for scene, done in zip(self.scenes, self.pool.map(lambda scene: expect(scene, "--json"), self.scenes)):
            with self.subTest(scene=scene.stem):
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                for row in json.loads(done.stdout):
                    error, rounding = abs(row["difference"]), FLOOR * max(abs(row["expected"]), 1)
                    self.assertLessEqual(row["allowed"], max(LARGEST * error, rounding), f"{row['column']}: {error:.3g} off, {row['allowed']:.3g} allowed")

    def test_values_are_missed_without_their_cause(self):
        with tempfile.TemporaryDirectory() as directory:
            cases = []
            for path in self.scenes:
                whole = tomllib.loads(path.read_text())
                for cause, keys in CAUSES.items():
                    scene = copy.deepcopy(whole)
                    if (path.stem, cause) in NOT_NEEDED or not any([without(scene, key) for key in keys]):
                        continue
                    changed = pathlib.Path(directory, f"{path.stem}_{cause}", path.name)
                    changed.parent.mkdir()
                    for beside in path.parent.iterdir():
                        if beside != path: (changed.parent / beside.name).symlink_to(beside)
                    changed.write_text(scene_text(scene))
                    cases.append((path.stem, cause, changed))
            missed = set()
            for (name, cause, _), done in zip(cases, self.pool.map(lambda case: expect(case[2]), cases)):
                with self.subTest(scene=name, without=cause):
                    self.assertNotEqual(done.returncode, 0, "the values do not depend on it")
                    if done.returncode == NOT_MET: missed.add(name)
            self.assertEqual({path.stem for path in self.scenes} - missed, set(), "scenes without a cause")

    def test_page_shows_every_scene(self):
        gallery = APPS / "gallery"
        page = (gallery / "README.md").read_text()
        for scene in sorted(gallery.glob("*.toml")):
            with self.subTest(scene=scene.stem):
                self.assertIn(f"skein expect apps/gallery/{scene.name}", page)
                self.assertIn(f"](../../docs/images/gallery/{scene.stem}.png)", page)
                self.assertTrue((APPS.parent / "docs/images/gallery" / f"{scene.stem}.png").exists())


if __name__ == "__main__":
    unittest.main()
