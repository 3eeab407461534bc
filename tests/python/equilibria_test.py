"""skein.equilibrium, skein.modes, skein.path: beside closed forms, relaxed runs and shooting; refusals; their plots."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from package import APPS, SKEIN, skein

from PIL import Image
from skein.solution_plots import parts

CANTILEVER, COLUMN, FRAME = APPS / "recipes/cantilever.toml", APPS / "statics/column.toml", APPS / "statics/lee_frame.toml"
LOAD, WEIGHT = "constants.load.value", "constants.weight.value"
LENGTH, RADIUS, YOUNG, DENSITY = 0.5, 1e-3, 2.1e11, 7850.0  # of COLUMN, SI
EI, PER_LENGTH = YOUNG * np.pi * RADIUS**4 / 4, DENSITY * np.pi * RADIUS**2
EULER = np.pi**2 * EI / (4 * LENGTH**2)
LIMITS = 18545.0, 5e-3  # N, of FRAME by shooting with stretch and shear; error with 20 elements a side

ROD = """
time.duration = 1.0
[[rods]]
name = "rod"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 8}
"""
PUSHED = ROD + """
start = "clamped"
[[load]]
kind = "formula"
at = "end"
force = ["1e-4*t", "0", "0"]
"""


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class Equilibria(InFolder):
    def test_tip_of_the_relaxed_run(self):
        found = skein.equilibrium(CANTILEVER)
        relaxed = skein.run(CANTILEVER, self.folder / "run", quiet=True, threads=1)
        np.testing.assert_allclose(found.positions["arm"], relaxed["arm"].state["position"], atol=1e-9)
        self.assertTrue(found.stable)
        self.assertLess(found.residual, 1e-6)
        self.assertGreater(found.iterations, 0)
        self.assertEqual((found.pieces, found.unstable, found.neutral, found.load_steps), (1, 0, 0, 1))
        self.assertIsNone(found.directory)

    def test_directors_are_those_of_frames(self):
        found = skein.equilibrium(COLUMN, out=self.folder / "out", **{"output.directors": True})
        written = skein.open(self.folder / "out")
        np.testing.assert_allclose(found.directors["column"], written["column"].directors[-1], atol=1e-6)
        np.testing.assert_allclose(found.positions["column"], written["column"].position[-1], atol=1e-6)
        self.assertEqual(found.directory, self.folder / "out")
        with self.assertRaisesRegex(FileExistsError, "overwrite=True"):
            skein.equilibrium(COLUMN, out=self.folder / "out")
        self.assertAlmostEqual(found["tip_z"], found.positions["column"][0, -1, 2], places=14)
        self.assertEqual(found.units["tip_z"], "m")
        with self.assertRaisesRegex(KeyError, "did you mean 'tip_z'"):
            found["tipz"]

    def test_a_file_its_text_and_a_scene(self):
        tips = [skein.equilibrium(scene)["tip_z"] for scene in (COLUMN, str(COLUMN), COLUMN.read_text(), skein.Scene(str(COLUMN)))]
        self.assertEqual(len(set(tips)), 1)

    def test_beyond_the_critical_load(self):
        found = skein.equilibrium(COLUMN, **{LOAD: 1.1 * EULER})
        self.assertEqual((found.stable, found.unstable), (False, 1))
        with self.assertRaisesRegex(skein.RunFailed, "unstable, 1 of 1 pieces") as failed:
            skein.equilibrium(COLUMN, stable=True, **{LOAD: 1.1 * EULER})
        self.assertEqual(failed.exception.code, 10)
        self.assertTrue(skein.equilibrium(COLUMN, stable=True, **{LOAD: 0.9 * EULER}).stable)

    def test_loads_without_a_potential(self):
        twisted = PUSHED.replace('force = ["1e-4*t", "0", "0"]', 'couple = ["1e-5", "1e-5", "1e-5"]')
        found = skein.equilibrium(twisted)
        self.assertIsNone(found.stable)
        self.assertEqual((found.unstable, found.unknown), (0, 1))
        with self.assertRaisesRegex(skein.RunFailed, "^error: the stability of the equilibrium: not known") as failed:
            skein.equilibrium(twisted, stable=True)
        self.assertEqual(failed.exception.code, 10)
        path = skein.path(twisted, "rods.rod.material.youngs_modulus", to=3e6)
        self.assertEqual((set(path.negative), path.stable.any(), path.unit), ({-1}, False, "Pa"))

    def test_free_motions_are_neutral(self):
        self.assertEqual(skein.equilibrium(ROD).neutral, 6)

    def test_a_pendulum_hangs(self):
        """It falls from the horizontal, to where no direction lets its energy fall."""
        found = skein.equilibrium(APPS / "gallery/pendulum.toml", stable=True)
        self.assertEqual(found.neutral, 1)
        self.assertLess(abs(found.positions["bar"][0, -1] - [0, 0, -1]).max(), 1e-5)

    def test_time_of_loads(self):
        tips = [skein.equilibrium(PUSHED, time=time).positions["rod"][0, -1, 0] for time in (0.0, 0.5, 1.0)]
        self.assertAlmostEqual(tips[0], 0)
        self.assertAlmostEqual(tips[1] / tips[2], 0.5, delta=1e-2)

    def test_refusals_are_the_programs(self):
        for scene, words, code in ((APPS / "nest/nest_110.toml", "a wall that moves with friction", 2), (ROD + "[[load]]\nkind = 'gravity'\n", "nothing balances the loads on the translation", 4),
                                   (self.folder / "none.toml", "there is no such file", 2), (ROD.replace("radius", "radios"), "did you mean", 2)):
            with self.subTest(scene=str(scene)[:40]):
                with self.assertRaisesRegex(skein.RunFailed, words) as failed:
                    skein.equilibrium(scene)
                self.assertEqual(failed.exception.code, code)
                self.assertNotIn("Newton:", str(failed.exception))


class Modes(InFolder):
    def test_of_a_clamped_rod(self):
        found = skein.modes(COLUMN, count=3, **{LOAD: 0.0})
        exact = np.array([3.51602, 22.0345, 61.6972]) * np.sqrt(EI / (PER_LENGTH * LENGTH**4)) / (2 * np.pi)
        np.testing.assert_allclose(found.frequencies, exact, rtol=1e-2)
        np.testing.assert_allclose(found.eigenvalues, (2 * np.pi * found.frequencies)**2)
        self.assertEqual((found.neutral, found.names), (0, ["column"] * 3))
        self.assertLess(found.residuals.max(), 1e-8)

    def test_of_a_column_under_load(self):
        """The lowest eigenvalue falls nearly linearly with the load, to zero at Euler's, and the motion grows beyond."""
        half, beyond = (skein.modes(COLUMN, count=1, **{LOAD: share * EULER}) for share in (0.5, 1.2))
        none = skein.modes(COLUMN, count=1, **{LOAD: 0.0})
        self.assertAlmostEqual(half.eigenvalues[0] / none.eigenvalues[0], 0.5, delta=0.02)
        self.assertLess(beyond.eigenvalues[0], 0)
        self.assertLess(beyond.frequencies[0], 0)

    def test_with_damping(self):
        """The decay of a rod with one rate of damping is half of it; without it the modes are those of the rod alone."""
        damped = self.folder / "damped.toml"
        damped.write_text(ROD.replace('name = "rod"', 'name = "rod"\nstart = "clamped"') + '[[damping]]\nkind = "uniform"\nrate = 3.0\n')
        found, alone = skein.modes(damped, count=2, movies=1), skein.modes(damped, count=2, undamped=True)
        np.testing.assert_allclose(found.decays, 1.5, rtol=1e-6)
        np.testing.assert_allclose(found.eigenvalues, alone.eigenvalues, rtol=1e-6)
        np.testing.assert_allclose(found.damping_ratios, 1.5 / np.sqrt(alone.eigenvalues), rtol=1e-6)
        np.testing.assert_allclose(found.frequencies, np.sqrt(alone.eigenvalues - 1.5**2) / (2 * np.pi), rtol=1e-6)
        self.assertFalse(alone.decays.any())
        self.assertGreater(np.abs(found.shapes[0]["rod"]).max(), 0)

    def test_neutral_motions_are_no_modes(self):
        found = skein.modes(ROD, count=4, **{"rods.rod.shape.elements": 24})
        self.assertEqual(found.neutral, 6)
        area, inertia = np.pi * 3e-3**2, np.pi * 3e-3**4 / 4
        free = 22.3733 * np.sqrt(2e6 * inertia / (1200 * area * 0.2**4)) / (2 * np.pi)
        np.testing.assert_allclose(found.frequencies[:2], free, rtol=0.02)

    def test_shapes(self):
        found = skein.modes(COLUMN, count=2, movies=2, amplitude=0.02, out=self.folder / "modes", **{LOAD: 0.0})
        self.assertEqual([shape["column"].shape for shape in found.shapes], [(1, 41, 3)] * 2)
        first, second = (shape["column"][0, :, 0] for shape in found.shapes)
        self.assertAlmostEqual(np.abs(first).max(), 0.02 * LENGTH, delta=1e-6)
        self.assertEqual((np.sum(np.diff(np.sign(first[2:])) != 0), np.sum(np.diff(np.sign(second[2:])) != 0)), (0, 1), "nodes of the modes")
        swing = skein.open(self.folder / "modes/mode_1")["column"].position[:, 0, -1, 0]
        self.assertAlmostEqual(swing.max(), -swing.min(), delta=1e-6)

    def test_wrong_input(self):
        for keys in ({"count": 0}, {"count": 3, "amplitude": -1.0}, {"scene": self.folder / "none.toml"}):
            with self.assertRaises(skein.RunFailed):
                skein.modes(**{"scene": COLUMN, **keys})


class Paths(InFolder):
    def test_branch_at_eulers_load(self):
        found = skein.path(COLUMN, LOAD, from_=0, to=2)
        self.assertEqual(len(found.branches), 1)
        self.assertAlmostEqual(found.branches[0] / EULER, 1, delta=0.02)
        self.assertTrue(found.complete)
        self.assertTrue(found.stable[found.value < 0.99 * EULER].all())
        self.assertFalse(found.stable[found.value > 1.01 * EULER].any())
        self.assertLess(np.abs(found["tip_x"]).max(), 1e-9)
        self.assertEqual((found.key, found.unit, found.units["tip_x"]), (LOAD, "N", "m"))

    def test_both_branches(self):
        """Mirror images, and the elastica's tip at 1.1 of Euler's load."""
        right, left = (skein.path(COLUMN, LOAD, from_=1.0, to=2.0, branch=side) for side in (1, -1))
        for found in (right, left):
            bent = found.branch == 1
            self.assertTrue(found.stable[bent].all())
            tip = np.interp(1.1 * EULER, found.value[bent], np.abs(found["tip_x"][bent]))
            self.assertAlmostEqual(tip / 0.254254531, 1, delta=5e-3)
            self.assertEqual(found.positions["column"].shape, (len(found), 1, 41, 3))
            self.assertEqual(found.directors["column"].shape, (len(found), 1, 40, 3, 3))
            np.testing.assert_allclose(found.positions["column"][:, 0, -1, 0], found["tip_x"], atol=1e-6)
        np.testing.assert_allclose(right["tip_x"][-1], -left["tip_x"][-1], rtol=1e-6)

    def test_limits_of_a_frame(self):
        found = skein.path(FRAME, WEIGHT, to=20000)
        self.assertEqual(list(found.place[found.place != "regular"]), ["limit", "limit", "end"])
        self.assertAlmostEqual(found.limits[0] / LIMITS[0], 1, delta=LIMITS[1])
        first, second = np.flatnonzero(found.place == "limit")
        self.assertTrue(found.stable[:first].all() and found.stable[second + 1:].all())
        self.assertFalse(found.stable[first + 1:second].any())
        self.assertTrue((np.diff(found.length) > 0).all())

    def test_long_steps_locate_a_branch_point_as_short_ones_do(self):
        loads = [skein.path(COLUMN, LOAD, from_=0, to=to, points=12).branches[0] for to in (4, 16, 64)]
        self.assertLess(np.ptp(loads), 1e-8 * loads[0])

    def test_a_path_that_is_cut_off(self):
        found = skein.path(COLUMN, LOAD, from_=0, to=4, points=5, step=0.1)
        self.assertEqual((len(found), found.complete), (5, False))
        self.assertAlmostEqual(found.value[1], 0.4, delta=1e-6)
        whole = skein.path(COLUMN, LOAD, from_=0, to=4)
        self.assertLess(whole.value[-2], 4 - 1e-3)
        self.assertEqual((whole.value[-1], whole.place[-1]), (4, "end"))
        short = skein.path(COLUMN, LOAD, from_=0, to=1.63)
        self.assertEqual(list(short.place[-2:]), ["branch", "end"], "a branch point within the last step")

    def test_a_path_goes_on(self):
        out = self.folder / "parts"
        cut = skein.path(COLUMN, LOAD, from_=0, to=4, points=5, out=out)
        found = skein.path(COLUMN, LOAD, from_=0, to=4, out=out, restart=True)
        whole = skein.path(COLUMN, LOAD, from_=0, to=4)
        self.assertEqual((len(cut), cut.complete, found.complete), (5, False, True))
        np.testing.assert_array_equal(found.value, whole.value)
        np.testing.assert_array_equal(found.positions["column"], whole.positions["column"])
        with self.assertRaisesRegex(skein.RunFailed, "the path is complete"):
            skein.path(COLUMN, LOAD, from_=0, to=4, out=out, restart=True)

    def test_a_force_of_a_load(self):
        found = skein.path(CANTILEVER, "load.0.end.2", to=-0.05)
        self.assertEqual(found.unit, "N")
        self.assertLess(found.positions["arm"][-1, 0, -1, 2], -0.2)

    def test_wrong_input(self):
        for keys, words in (({"along": "constants.loud.value"}, "is no number of"), ({"along": "load.0.kind"}, "is no number of"), ({"to": 0.5}, "where the path begins"),
                            ({"branch": 2}, "--branch"), ({"to": float("nan")}, "finite number")):
            with self.subTest(keys=keys), self.assertRaisesRegex(skein.RunFailed, words) as failed:
                skein.path(**{"scene": COLUMN, "along": LOAD, "to": 3.0, **keys})
            self.assertNotEqual(failed.exception.code, 0)


class Plots(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        skein.path(COLUMN, LOAD, from_=0, to=4, step=0.1, out=cls.folder / "straight")
        skein.path(COLUMN, LOAD, from_=0, to=4, step=0.1, branch=1, out=cls.folder / "bent")
        skein.modes(COLUMN, count=4, out=cls.folder / "modes", **{LOAD: 1.2 * EULER})

    def plot(self, *words, code=0):
        done = subprocess.run([SKEIN, "plot", *map(str, words)], capture_output=True, text=True, timeout=100, cwd=self.folder, env=dict(os.environ, PYTHON=sys.executable))
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout if code == 0 else done.stderr

    def assert_drawn(self, name, colours=50):
        with Image.open(self.folder / name) as picture:
            self.assertGreater(len(set(picture.convert("RGB").getdata())), colours)
        self.assertFalse(list(self.folder.glob("**/part_*")))

    def test_of_a_path(self):
        self.assertEqual(self.plot("bent").strip(), "bent/path.png")
        self.assert_drawn("bent/path.png")
        self.plot("straight", "bent", "--columns", "tip_?", "max_axial_strain", "--to", "both.png")
        self.assert_drawn("both.png")
        self.plot("bent", "--columns", LOAD, "--against", "tip_x", "--to", "turned.svg")
        text = (self.folder / "turned.svg").read_text()
        self.assertIn("<!-- constants.load.value [N] -->", text)
        self.assertIn("<!-- tip_x [m] -->", text)
        self.assertIn("<!-- branch point -->", text)

    def test_the_column_that_moves_most(self):
        from skein.columns import path_columns
        from skein.solution_plots import most_moved
        self.assertEqual(most_moved(self.folder / "bent", path_columns(self.folder / "bent")), "tip_z")

    def test_parts(self):
        self.assertEqual(parts(["regular", "regular", "limit", "regular", "branch", "end"], [True, True, True, False, True, True]), [(0, 2, True), (2, 4, False), (4, 5, True)])
        self.assertEqual(parts(["regular", "branch", "regular"], [True, False, True]), [(0, 2, True)])
        self.assertEqual(parts(["regular"], [True]), [])

    def test_of_modes(self):
        self.assertEqual(self.plot("modes").strip(), "modes/modes.png")
        self.assert_drawn("modes/modes.png")
        self.plot("modes", "--to", "modes.svg")
        self.assertIn("<!-- frequency [Hz] -->", (self.folder / "modes.svg").read_text())
        self.plot("modes", "--columns", "eigenvalue", "--log", "--to", "log.png")
        self.assert_drawn("log.png", 20)

    def test_lists(self):
        rows = {row["column"]: row for row in json.loads(self.plot("bent", "--list", "--json"))}
        self.assertEqual((rows[LOAD]["unit"], rows[LOAD]["last"]), ("N", 4.0))
        self.assertNotIn("place", rows)
        self.assertEqual(len(json.loads(self.plot("modes", "--list", "--json"))), 7)

    def test_mistakes(self):
        self.assertIn("did you mean tip_z?", self.plot("bent", "--columns", "tipz", code=2))
        self.assertIn("no columns of path.csv called q", self.plot("bent", "--against", "q", code=2))
        self.assertIn("words in place of numbers", self.plot("bent", "--columns", "place", code=2))
        self.assertIn("results of one kind", self.plot("bent", "modes", code=2))
        broken = self.folder / "broken"
        broken.mkdir()
        (broken / "path.csv").write_text("point,branch\n1\n")
        self.assertIn("path.csv", self.plot(broken, code=5))


if __name__ == "__main__":
    unittest.main()
