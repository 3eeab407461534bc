"""apps/school: statistics of swimmers whose motion is known, a run of six without a fluid against the program's own series, figures."""

import json
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import h5py
import numpy as np

from package import APPS, SKEIN, skein

sys.path.insert(0, str(APPS / "school"))
import school as schooling  # noqa: E402
import wakes  # noqa: E402

SWIMMERS, ELEMENTS = 6, 16


def scene():
    """The case's swimmers without their fluid: six that lie in two columns, a sixth of a period behind each other, in something that damps."""
    part, one = ((APPS / "school" / name).read_text() for name in ("swimmer.part", "one_swimmer.toml"))
    text = part[part.index("[constants]"):] + one[one.index("[[rods]]"):one.index("[output]")]
    origins = ", ".join(f"[{1.25 * (i % 2)}, {i // 2}.0, {i / 4}]" for i in range(SWIMMERS))
    for old, new in (("elements = 48", f"elements = {ELEMENTS}"), (r"t / period\)(?!,)", f"t / period - rod / {SWIMMERS})"),
                     (r"origin = \[.*?\]", f"kind = \"list\"\norigins = [{origins}]")):
        text, times = re.subn(old, new, text)
        assert times, old
    return f"""
title = "Six in the dry"
time.duration = 5.4
damping = [{{kind = "uniform", rate = 20.0}}]
output = {{series = 0.1, trajectory = 0.02, audit = true, paraview = "none"}}
{text}"""


class Statistics(unittest.TestCase):
    def test_rates_are_means_over_a_period(self):
        """A drift under a beat that leaves nothing after a period."""
        time = np.arange(151) / 50
        places = np.stack([-0.3 * time + 0.05 * np.sin(2 * np.pi * time), 0.04 * time, 0.2 * np.cos(4 * np.pi * time) + 0.03 * time], axis=-1)[:, None]
        school = schooling.School("", time, places, None, None, None, None)
        when, forward, lateral = schooling.speeds(school)
        self.assertEqual((when[0], len(when)), (1.0, 101))
        np.testing.assert_allclose(forward, 0.3, rtol=1e-12)
        np.testing.assert_allclose(lateral, 0.05, rtol=1e-12)

    def test_correlations_of_waves_with_phases(self):
        """C_ij = cos(p_i - p_j), whatever wave all have in common and however strong the single ones are."""
        time, s = np.arange(100) / 50, np.arange(40) / 40
        phase = 2 * np.pi * np.arange(8) / 8
        wave = np.cos(2 * np.pi * (s - time[:, None, None]) + phase[:, None])
        common = 5 * np.sin(2 * np.pi * (s - time[:, None, None])) + s**2
        expected = np.cos(phase[:, None] - phase)
        np.testing.assert_allclose(schooling.correlations(wave + common), expected, atol=1e-12)
        size = np.where(np.arange(8) % 4 == 0, 2.0, 1.0)[:, None]  # opposite ones alike, so that the mean stays 0
        np.testing.assert_allclose(schooling.correlations(size * wave + common), expected, atol=1e-12)

    def test_separations_are_means_of_distances(self):
        """Not the distance of mean places, which would be 0 for two that circle each other."""
        angle = 2 * np.pi * np.arange(30) / 30
        one = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
        np.testing.assert_allclose(schooling.separations(np.stack([one, -one], axis=1)), [[0, 2], [2, 0]], atol=1e-12)

    def test_ranks_and_spearmans_rho(self):
        np.testing.assert_array_equal(schooling.ranks(np.array([3.0, 1.0, 3.0, 7.0, 3.0])), [3, 1, 3, 5, 3])
        self.assertAlmostEqual(schooling.spearman(np.array([1.0, 2, 2, 4]), np.array([1.0, 3, 2, 4])), 4.5 / np.sqrt(22.5), places=12)
        grows = np.array([0.1, 3.0, 0.2, 9.0, 0.5])
        self.assertAlmostEqual(schooling.spearman(grows, np.exp(grows)), 1, places=12)
        self.assertAlmostEqual(schooling.spearman(grows, -grows**3), -1, places=12)

    def networks_of(self, phase, places):
        time, s = np.arange(301) / 50, np.arange(20) / 20
        curvature = np.cos(2 * np.pi * (s - time[:, None, None]) + np.asarray(phase)[:, None])
        return schooling.networks(schooling.School("", time, np.tile(places, (301, 1, 1)), curvature, None, None, None))

    def test_networks(self):
        """Of eight on a line at places 0, 1, 3, 7, ... the 16 nearest pairs of 28 are those of the first six, and (5, 6)."""
        line = np.stack([2.0 ** np.arange(8), np.zeros(8), np.zeros(8)], axis=-1)
        found = self.networks_of(2 * np.pi * np.arange(8) / 8, line)
        near, similar = ({tuple(pair) for pair in found.pairs[network]} for network in (found.near, found.similar))
        self.assertEqual(near, {(i, j) for i in range(6) for j in range(i + 1, 6)} | {(5, 6)})
        self.assertEqual(len(similar), 16)
        for i, j in similar:  # on the circle of phases one or two apart: C = cos 45 degrees or 0
            self.assertIn((j - i) % 8, (1, 2, 6, 7))
        self.assertEqual({tuple(pair) for pair in found.pairs[found.common]}, near & similar)
        self.assertLess(len(found.common), 16)
        self.assertLess(abs(found.rho), 0.5)
        self.assertAlmostEqual(found.by_chance, 16 * 16 / 28)

    def test_networks_of_those_that_are_alike_where_they_are_near(self):
        """Places on a circle at the phases of what is left of the waves less their mean: D^2 = 2 - 2 C."""
        phase = np.array([0.0, 0.3, 0.9, 1.6, 2.9, 3.3, 4.7, 5.1])
        left = np.exp(1j * phase) - np.exp(1j * phase).mean()
        on_circle = left / np.abs(left)
        found = self.networks_of(phase, np.stack([on_circle.real, on_circle.imag, 0 * phase], axis=-1))
        self.assertEqual(len(found.common), 16)
        self.assertAlmostEqual(found.rho, 1, places=12)

    def test_no_networks_of_few_or_too_early(self):
        school = schooling.School("", np.arange(240) / 50, np.zeros((240, 8, 3)), np.ones((240, 8, 3)), None, None, None)
        self.assertIsNone(schooling.networks(school))
        school.time, school.places = school.time * 2, school.places[:, :4]
        self.assertIsNone(schooling.networks(school))

    def test_turns_about_the_second_director(self):
        """theory.md (5): the next frame is exp(-[v]) times the one before."""
        angle = np.array([0.3, -0.2, 1e-5, 0.05])
        directors = [np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])]
        for turn in angle:
            c, s = np.cos(turn), np.sin(turn)
            directors.append(np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ directors[-1])
        np.testing.assert_allclose(schooling.turns(np.array(directors)), angle, rtol=1e-9)

    def test_work_of_a_couple_that_leads(self):
        """A couple A cos(wt) on a turn B cos(wt - p): pi A B sin(p) a period."""
        time, lead = np.arange(101) / 50, 0.4
        couple = 3 * np.cos(2 * np.pi * 0.5 * (time[1:] + time[:-1]))[:, None]
        work = schooling.work_of(couple, 2 * np.cos(2 * np.pi * time - lead)[:, None])
        self.assertEqual(work.shape, (101,))
        np.testing.assert_allclose(work[100], 2 * np.pi * 6 * np.sin(lead), rtol=1e-3)
        self.assertEqual(work[0], 0)

    def test_centre_of_mass_of_a_flat_cone(self):
        """One half width falls to 0.2 of itself, the other to 0.5: integrals over the length in closed form."""
        n = 7
        a, b = (1 + (end - 1) * (np.arange(n) + 0.5) / n for end in (0.2, 0.5))
        shares = schooling.mass_shares(a, b)
        self.assertAlmostEqual(shares.sum(), 1, places=12)
        centre = shares @ np.linspace(0, 1, n + 1)
        self.assertAlmostEqual(centre, (1 / 2 - 1.3 / 3 + 0.4 / 4) / (1 - 1.3 / 2 + 0.4 / 3), delta=2e-3)
        self.assertGreater(abs(centre - 0.5), 0.05)

    def test_muscles_of_the_scene_bend_into_the_published_midline(self):
        part = tomllib.loads((APPS / "school/swimmer.part").read_text())
        load, constants = part["load"][0], {name: constant["value"] for name, constant in part["constants"].items()}
        s, step = np.linspace(0.1, 0.9, 9), 1e-4

        def y(s, t):
            return 0.125 * (0.03125 + s) / 1.03125 * np.sin(2 * np.pi * (s - t)) * (0.5 - 0.5 * np.cos(np.pi * t) if t < 1 else 1)
        for t in (0.3, 0.8, 1.37):
            slope, bend = (y(s + step, t) - y(s - step, t)) / (2 * step), (y(s + step, t) - 2 * y(s, t) + y(s - step, t)) / step**2
            np.testing.assert_allclose(schooling.formula(load["curvature"][1], **constants, s=s, t=t), bend / np.sqrt(1 - slope**2), atol=1e-5)
        with self.assertRaisesRegex(skein.NotResults, "tides.*may name"):
            schooling.formula("2 * tides(t)", t=1.0)

    def test_formulas_are_read_and_never_carried_out(self):
        """The grammar of scenes, and nothing else: what Python would carry out is refused with the text."""
        s = np.array([0.0, 0.5, 2.0])
        for text, expected in (("2*s^2 - -s", 2 * s**2 + s), ("-2^2", -4.0), ("2^3^2", 512.0), ("if(s < 1, s, 1)", np.minimum(s, 1)), ("min(s, 1, 0.25)", np.minimum(s, 0.25)),
                               ("mod(s, 0.75)", np.mod(s, 0.75)), ("ramp(s, 1)", np.clip(s, 0, 1)), ("step(s-0.5)", [0, 1, 1]), ("1/s", [np.inf, 2, 0.5]), ("1e-1 + .5*pi", 0.1 + np.pi / 2)):
            np.testing.assert_allclose(schooling.formula(text, s=s), expected, err_msg=text)
        marker = Path(tempfile.gettempdir()) / "carried_out"
        for text in (f"__import__('os').system('touch {marker}')", "().__class__.__base__.__subclasses__()", "[x for x in (1,)]", "s.__class__", "lambda: 1", "s if s else 1", "f'{s}'",
                     "(" * 500 + "s" + ")" * 500, "-" * 5000 + "1", "s" * 9000, "2 *", "sin(s", "sin(s, s)", "s s", "", "tides(s)"):
            with self.subTest(text=text[:40]), self.assertRaises(skein.NotResults):
                schooling.formula(text, s=s)
        self.assertFalse(marker.exists())

    def test_what_is_not_accepted_is_told(self):
        figures = {"forward": {"mean": 0.3, "range": 0.03}, "lateral": {"mean": 0.1, "range": 0.05}, "swimmers": 32, "rho": 0.1, "finite": True}
        self.assertTrue(all(good for _, good in schooling.acceptance(figures)))
        for change in ({"forward": {"mean": 0.2, "range": 0.03}}, {"forward": {"mean": 0.3, "range": 0.08}, "lateral": {"mean": 0.1, "range": 0.09}},
                       {"lateral": {"mean": 0.1, "range": 0.02}}, {"rho": -0.6}, {"finite": False}):
            with self.subTest(change=change):
                self.assertEqual(sum(not good for _, good in schooling.acceptance(figures | change)), 1)


class Run(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory()
        cls.out = Path(cls._folder.name, "out")
        written = Path(cls._folder.name, "six.toml")
        written.write_text(scene())
        subprocess.run([SKEIN, "run", str(written), "--out", str(cls.out), "-q"], check=True, timeout=200)
        cls.school, cls.run_ = schooling.read_school(cls.out), skein.open(cls.out)

    @classmethod
    def tearDownClass(cls):
        cls.run_.frames.close()
        cls._folder.cleanup()

    def test_against_the_programs_series(self):
        """Centre of mass; bending energy, with the dilatation of the cells; work of the muscles, the only loads."""
        school, series, group = self.school, self.run_.series, self.run_.rods[0]
        frames = [int(np.argmin(np.abs(school.time - t))) for t in series["time"]]
        np.testing.assert_allclose(school.time[frames], series["time"], atol=1e-9)
        centre = np.stack([series[f"centre_{axis}"] for axis in "xyz"], axis=-1)
        np.testing.assert_allclose(school.places[frames].mean(axis=1), centre, atol=1e-6)
        a, b = schooling.semi_axes(group, self.run_.constants, (np.arange(ELEMENTS) + 0.5) / ELEMENTS)
        stiffness = 22500 * np.pi / 4 * (schooling.at_nodes(a)**3 * schooling.at_nodes(b))[1:-1]
        along = np.einsum("frkx,frkx->frk", np.diff(group.position[:], axis=2), group.directors[:][..., 2, :]) * ELEMENTS
        energy = 0.5 * np.sum(stiffness * school.curvature**2 / (0.5 * (along[..., 1:] + along[..., :-1]))**3, axis=(1, 2)) / ELEMENTS
        np.testing.assert_allclose(energy[frames], series["elastic_bend"], rtol=1e-3, atol=1e-6 * series["elastic_bend"].max())
        work, most = school.work.sum(axis=1)[frames], series["work_loads"].max()
        self.assertGreater(series["dissipated"][-1], 0.1 * most)
        np.testing.assert_allclose(work, series["work_loads"], atol=5e-3 * most)

    def test_bodies_bend_as_their_muscles_do(self):
        """In stiff bodies the correlations are those of the muscles, by their phases."""
        settled = self.school.time > schooling.SETTLED
        phase = 2 * np.pi * np.arange(SWIMMERS) / SWIMMERS
        np.testing.assert_allclose(schooling.correlations(self.school.curvature[settled]), np.cos(phase[:, None] - phase), atol=0.02)

    def test_figures(self):
        to = Path(self._folder.name, "figures")
        done = subprocess.run([sys.executable, str(APPS / "school/plot.py"), str(self.out), "--to", str(to)], capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("NO  mean forward speed", done.stdout)  # there is no fluid to swim in
        self.assertRegex(done.stdout, r"networks +\d+ of 12 edges in both")
        figures = json.loads((to / "school.json").read_text())
        self.assertLess(abs(figures["forward"]["mean"]), 1e-3)
        for picture in ("path.png", "school.png", "power.png"):
            self.assertGreater((to / picture).stat().st_size, 10000)
        self.assertFalse((to / "flow.png").exists())

    def test_results_of_another_kind(self):
        """A sentence, and an exit code that scripts notice."""
        for program, words in (("plot.py", "no such directory"), ("wakes.py", "")):
            done = subprocess.run([sys.executable, str(APPS / "school" / program), str(self.out / "absent")], capture_output=True, text=True, timeout=100)
            self.assertEqual((done.returncode, len(done.stderr.strip().splitlines())), (1, 1), done.stderr)
            self.assertIn(words, done.stderr)


class Wakes(unittest.TestCase):
    def test_blocks_stand_where_they_belong_and_surfaces_go_through_them(self):
        """A ball in eight blocks of another size: a closed surface of its area, with normals outwards and the vorticity that is there."""
        edge, spacing, corner, radius, centre = 8, 0.1, np.array([-1.0, 0.5, 2.0]), 0.55, np.array([0.63, 2.11, 3.58])
        index = np.stack(np.meshgrid(*[np.arange(2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)[:, ::-1]  # by z, y and x
        lower = corner + spacing * edge * (index + 1)
        cell = np.stack(np.meshgrid(*[(np.arange(edge) + 0.5) * spacing] * 3, indexing="ij"), axis=-1)[..., ::-1]
        places = lower[:, None, None, None] + cell
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "fluid_wakes_000000000001.h5")
            with h5py.File(path, "w") as file:
                file["lower"], file["q"] = lower, (1 + radius**2 - np.sum((places - centre)**2, axis=-1)).astype("f4")
                file["vorticity"] = np.stack([0 * places[..., 0], 0 * places[..., 0], places[..., 0] + 2 * places[..., 1]], axis=-1).astype("f4")
                file.attrs["spacing"] = spacing
                for axis, value in zip("xyz", corner):
                    file.attrs[f"lower_{axis}"] = value
            q, vorticity, first, apart = wakes.vortices(path)
        self.assertEqual((q.shape, apart), ((18, 18, 18), spacing))
        np.testing.assert_allclose(first, corner + spacing * (edge - 0.5), atol=1e-12)
        self.assertEqual(np.abs(q[0]).max() + np.abs(q[..., -1]).max(), 0)
        try:
            import vtkmodules.vtkFiltersCore  # noqa: F401
        except ImportError:
            self.skipTest("no VTK for the surface")
        points, normals, triangles, values = wakes.surface(q, vorticity, first, apart, 1.0)
        outward = points - centre
        np.testing.assert_allclose(np.linalg.norm(outward, axis=1), radius, atol=0.01)
        self.assertGreater(np.min(np.sum(normals * outward, axis=1)) / radius, 0.9)
        np.testing.assert_allclose(values, points[:, 0] + 2 * points[:, 1], atol=1e-4)
        corners = points[triangles]
        area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        self.assertAlmostEqual(area / (4 * np.pi * radius**2), 1, delta=0.02)


if __name__ == "__main__":
    unittest.main()
