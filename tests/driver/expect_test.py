"""Probes, [[expect]] tables and `skein expect`: columns of single places, compared with known values."""

import csv
import json
import subprocess
import unittest

import h5py
import numpy
from driver import SKEIN, DriverTest

SCENE = """
[time]
duration = 0.4
[[rods]]
name = "beams"
start = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 5e-3
shape = {length = 0.3, elements = 8}
placement = {kind = "line", counts = [5], spacing = [0.1], tangent = [0.0, 1.0, 0.0]}
[[bodies]]
name = "top"
mass = 1.0
inertia = [0.1, 0.2, 0.3]
capsules = {from = [[0, 0, -0.1]], to = [[0, 0, 0.1]], radii = [0.02]}
placement.origin = [0.0, 0.0, 3.0]
angular_velocity = [0.1, 0.2, 3.0]
[[load]]
kind = "gravity"
[output]
trajectory = 0.1
precision = "double"
series = 0.1
"""
PROBES = """
[[probe]]
name = "tip"
of = "beams"
number = 3
[[probe]]
name = "middle"
of = "beams"
number = 4
at = 0.4375            # half-way along element 3
quantity = "velocity"
[[probe]]
name = "way"
of = "beams"
at = 0.3
quantity = "direction"
[[probe]]
name = "bend"
of = "beams"
number = 2
at = 0.25
quantity = "curvature"
[[probe]]
name = "top"
of = "top"
[[probe]]
name = "turning"
of = "top"
quantity = "spin"
"""
EXPECTED = """
[[expect]]
column = "top_z"
value = 2.2152         # 3 - g t^2/2
tolerance = 1e-3
reference = "free fall"
[[expect]]
column = "top_z"
take = "mean"
from = 0.1
until = 0.3
value = 2.77116        # 3 - g (0.1^2 + 0.2^2 + 0.3^2)/6
tolerance = 1e-3
reference = "free fall"
[[expect]]
column = "momentum_x"
take = "largest"
value = 0.0
scale = 1.0
tolerance = 1e-6
reference = "nothing pushes along x"
"""


class Expect(DriverTest):
    def series(self, out):
        header, *rows = csv.reader((self.directory / out / "observables.csv").read_text().splitlines())
        return {name: numpy.array([float(row[i]) for row in rows]) for i, name in enumerate(header)}

    def expect(self, *arguments, code=0):
        done = subprocess.run([SKEIN, "expect", self.scene, "--out", self.directory / "e", "--overwrite", *arguments], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_probes_are_places_of_the_trajectory(self):
        self.scene.write_text(SCENE + PROBES)
        self.run_skein("one")
        series = self.series("one")
        with h5py.File(next((self.directory / "one").glob("trajectory_*.h5"))) as file:
            beams = file["groups/beams/position"][:]
            top = file["groups/top/position"][:]
        for i, axis in enumerate("xyz"):
            numpy.testing.assert_allclose(series[f"tip_{axis}[m]"], beams[:, 3, -1, i], rtol=0, atol=1e-15)
            numpy.testing.assert_array_equal(series[f"top_{axis}[m]"], top[:, 0, 0, i])
        way = beams[:, 0, 3] - beams[:, 0, 2]  # of the element at 0.3
        seen = numpy.stack([series[f"way_{axis}[-]"] for axis in "xyz"], axis=1)
        self.assertLess(numpy.linalg.norm(numpy.cross(way, seen), axis=1).max(), 1e-2 * 0.3 / 8)  # the shear
        self.assertGreater(numpy.einsum("ij,ij->i", way, seen).min(), 0)
        self.assertGreater(series["bend[1/m]"][-1], 0.1)
        self.assertLess(series["middle_z[m/s]"][1], 0)
        spin = numpy.stack([series[f"turning_{axis}[rad/s]"] for axis in "xyz"], axis=1)
        numpy.testing.assert_allclose(spin[0], [0.1, 0.2, 3.0], atol=1e-6)
        self.run_skein("three", ranks=3)
        self.assertEqual((self.directory / "one/observables.csv").read_bytes(), (self.directory / "three/observables.csv").read_bytes())

    def test_probes_change_no_bit_and_may_come_and_go(self):
        self.scene.write_text(SCENE)
        self.run_skein("without")
        self.run_skein("later", "--until", "0.2")
        self.scene.write_text(SCENE + PROBES)
        self.run_skein("with")
        self.assertEqual(self.summary("without")["digest"], self.summary("with")["digest"])

    def test_expected_values(self):
        self.scene.write_text(SCENE + PROBES + EXPECTED)
        said = self.expect().stdout
        self.assertEqual(len(said.splitlines()), 4)
        self.assertNotIn("NOT MET", said)
        said = self.expect("--json").stdout
        rows = json.loads(said[said.index("[\n"):])
        self.assertTrue(all(row["met"] for row in rows))
        self.assertEqual([row["take"] for row in rows], ["end", "mean", "largest"])

    def test_other_values(self):
        self.scene.write_text(SCENE + PROBES + EXPECTED.replace("2.2152 ", "2.25 "))
        said = self.expect(code=9).stdout
        self.assertEqual(said.count("NOT MET"), 1)
        self.scene.write_text(SCENE.replace('[[load]]\nkind = "gravity"\n', "") + PROBES + EXPECTED)
        self.assertEqual(self.expect(code=9).stdout.count("NOT MET"), 2)

    def test_faults(self):
        for change, message in (
            (("column = \"momentum_x\"", "column = \"momentum\""), "expect.column: this scene's series has no 'momentum'; it has "),
            (("scale = 1.0\n", ""), "'scale' is needed beside 'value' = 0"),
            (("take = \"mean\"\n", ""), "'from' has no use with 'take' = \"end\""),
            (("of = \"top\"\n\n", "of = \"tip\"\n\n"), "there is no group of rods 'tip'"),
            (("number = 3", "number = 5"), "the group 'beams' has 5, counted from 0"),
            (("name = \"bend\"\nof = \"beams\"\nnumber = 2\nat = 0.25", "name = \"bend\"\nof = \"top\""), "is a rigid body, which has no curvature"),
            (("name = \"way\"", "name = \"tip\""), "a probe 'tip' stands above already"),
            (('name = "top"\nof = "top"\n[[probe]]', 'name = "centre"\nof = "top"\n[[probe]]'), "the time series has two columns 'centre_x'"),
            (("series = 0.1\n", ""), "the scene has no time series: set 'series' in [output]"),
        ):
            text = SCENE + PROBES + EXPECTED
            if change[0].startswith("of ="):
                change = ('of = "top"', 'of = "tip"')
            self.assertIn(change[0], text)
            self.scene.write_text(text.replace(*change, 1))
            self.assertIn(message, self.expect(code=2).stderr)
        self.scene.write_text(SCENE)
        self.assertIn("the scene expects nothing; it has no [[expect]]", self.expect(code=2).stderr)


if __name__ == "__main__":
    unittest.main()
