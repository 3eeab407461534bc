"""Rods from a file: the same run as from a list, whatever the format, ranks, lanes and mapping; restarts; what is refused."""

import pathlib
import re
import subprocess
import sys
import unittest

import h5py
import numpy

from driver import MPIRUN, SKEIN, DriverTest

RODS = 37
HEAD = """
title = "rods of their own directions"
[time]
duration = 0.02
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 0.5
[output]
trajectory = 0.01
series = 0.005
checkpoint = 0.01
precision = "double"
"""
GROUP = """
[[rods]]
name = "{name}"
start = "clamped"
end = "{end}"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.01
taper = 0.7
[rods.shape]
length = 0.5
elements = 6
rest_curvature = [0.4, 0.1, 0.2]
[rods.magnetisation]
pattern = "wave_x"
strength = 100.0
wavelength_x = 0.7
[rods.placement]
{placement}
"""
FIELD = """
[[load]]
kind = "magnetic_field"
constant = [0.0, 0.01, 0.0]
"""


def rows(a):
    return "[" + ", ".join("[" + ", ".join(repr(float(x)) for x in row) + "]" for row in a) + "]"


class RodFiles(DriverTest):
    def setUp(self):
        super().setUp()
        random = numpy.random.default_rng(5)
        self.origin = random.uniform(-1, 1, (RODS, 3))
        self.tangent = random.normal(size=(RODS, 3))
        self.normal = random.normal(size=(RODS, 3))
        self.end = "free"

    def write(self, placement, *, field=True, more=""):
        self.scene.write_text(HEAD + (FIELD if field else "") + GROUP.format(name="traced", end=self.end, placement=placement) + more)

    def write_list(self, **options):
        self.write(f'kind = "list"\norigin = [0.25, 0.0, 0.0]\norigins = {rows(self.origin)}\ntangents = {rows(self.tangent)}\n'
                   f"normals = {rows(self.normal)}", **options)

    def write_file(self, name="rods.h5", **datasets):
        data = {"origin": self.origin, "tangent": self.tangent, "normal": self.normal, **datasets}
        if name.endswith(".h5"):
            with h5py.File(self.directory / name, "w") as file:
                for key, value in data.items():
                    if value is not None:
                        file[key] = value
        else:
            columns = {"origin": "x,y,z", "tangent": "tx,ty,tz", "normal": "nx,ny,nz"}
            data = {key: value for key, value in data.items() if value is not None}
            lines = [",".join(columns[key] for key in data)]
            lines += [",".join(repr(float(x)) for value in data.values() for x in value[i]) for i in range(len(self.origin))]
            (self.directory / name).write_text("\n".join(lines) + "\n")
        self.write(f'kind = "file"\norigin = [0.25, 0.0, 0.0]\nfile = "{name}"')

    def test_a_file_is_a_list(self):
        for end in ("free", "clamped"):
            with self.subTest(end=end):
                self.end = end
                self.write_list()
                self.run_skein(f"list_{end}")
                digest = self.digest(f"list_{end}")
                for name in ("rods.h5", "rods.csv"):
                    self.write_file(name)
                    for layout, arguments in (({}, ()), ({"ranks": 3}, ()), ({"threads": 2}, ("--lanes", "1")), ({}, ("--mapping", "along"))):
                        out = f"{end}_{name}_{layout}_{arguments}".replace(" ", "")
                        self.run_skein(out, *arguments, **layout)
                        self.assertEqual(self.digest(out), digest, (name, layout, arguments))
                        mine, theirs = self.frames(out, "trajectory"), self.frames(f"list_{end}", "trajectory")
                        for dataset in theirs:
                            self.assertTrue(numpy.array_equal(mine[dataset], theirs[dataset]), dataset)

    def test_each_rod_moves_as_a_group_of_its_own(self):
        """But for round-off, since its start shape is turned and not worked out in its own frame."""
        self.end = "clamped"
        self.write_list(field=False)
        self.run_skein("list")
        together = self.frames("list", "trajectory")["groups/traced/position"][-1]
        groups = "".join(GROUP.format(name=f"r{i}", end=self.end, placement=f"origin = {list(self.origin[i] + [0.25, 0, 0])}\n"
                                      f"tangent = {list(self.tangent[i])}\nnormal = {list(self.normal[i])}") for i in range(RODS))
        self.scene.write_text(HEAD + groups)
        self.run_skein("groups")
        alone = self.frames("groups", "trajectory")
        for i in range(RODS):
            self.assertLess(numpy.abs(alone[f"groups/r{i}/position"][-1][0] - together[i]).max(), 1e-12, i)
        energy = [numpy.genfromtxt(self.directory / out / "observables.csv", delimiter=",", skip_header=1)[-1] for out in ("list", "groups")]
        self.assertTrue(numpy.allclose(*energy, rtol=1e-9, atol=1e-12), energy)

    def test_a_run_goes_on_with_its_own_file_alone(self):
        self.write_file()
        self.run_skein("whole")
        self.run_skein("halves", "--until", "0.01", ranks=2)
        (self.directory / "elsewhere").mkdir()
        (self.directory / "rods.h5").rename(self.directory / "elsewhere/same.h5")
        self.scene.write_text(self.scene.read_text().replace("rods.h5", "elsewhere/same.h5"))
        self.run_skein("halves", ranks=3)
        self.assertEqual(self.digest("halves"), self.digest("whole"))
        self.run_skein("changed", "--until", "0.01")
        moved = self.origin.copy()
        moved[3, 1] += 1e-12
        self.write_file(origin=moved)
        said = self.run_skein("changed", expect=2).stderr
        self.assertIn("placement.file", said)

    def refused(self, said, name="rods.h5", **datasets):
        self.write_file(name, **datasets)
        done = subprocess.run([SKEIN, "check", str(self.scene)], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(said, done.stderr)
        done = subprocess.run([MPIRUN, "-n", "3", SKEIN, "run", str(self.scene), "--out", str(self.directory / "none")],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertEqual(done.stderr.count(said), 1, done.stderr)
        self.assertFalse((self.directory / "none").exists())

    def test_what_is_refused(self):
        def with_row(a, i, row):
            b = a.copy()
            b[i] = row
            return b

        for name in ("rods.h5", "rods.csv"):
            at = (lambda quantity, i: f"dataset '{quantity}', row {i}: ") if name == "rods.h5" else \
                 (lambda quantity, i: f"row {i + 1} below the names: {quantity}: ")
            self.refused(name + ": " + at("origin", 5) + "not a finite number", name, origin=with_row(self.origin, 5, numpy.nan))
            self.refused(name + ": " + at("tangent", 36) + "has no direction", name, tangent=with_row(self.tangent, 36, 0))
            self.refused(name + ": " + at("normal", 20) + "is parallel to the tangent", name,
                         normal=with_row(self.normal, 20, -2 * self.tangent[20]))
            self.refused("'normal' without 'tangent'", name, tangent=None)
            self.refused("'origin' is missing", name, origin=None)
        self.refused("dataset 'tangent' has 36 rows, but 'origin' has 37", tangent=self.tangent[1:])
        self.refused("dataset 'origin' has the shape [37, 2]; it must be [rods, 3]", origin=self.origin[:, :2])
        self.refused("unknown dataset 'tangents'; a file of rods takes origin, tangent, normal", tangents=self.tangent)
        self.refused("dataset 'origin' does not hold numbers", origin=[b"a", b"b"])
        self.write('kind = "file"\nfile = "nowhere.h5"')
        said = subprocess.run([SKEIN, "check", str(self.scene)], capture_output=True, text=True, timeout=60).stderr
        self.assertIn("there is no file of rods", said)
        for text, told in (("x,y\n1,2\n", "of origin only 2 of three columns"), ("x,y,z,w\n", "unknown column 'w'"),
                           ("x,y,z\n1,2\n", "row 1 below the names: origin: expected 3 values"),
                           ("x,y,z\n1,2,three\n", "'z' is not a number"), ("x,y,z\n", "there is no rod in it"), ("x,y,x\n", "two columns 'x'")):
            (self.directory / "bad.csv").write_text(text)
            self.write('kind = "file"\nfile = "bad.csv"')
            said = subprocess.run([SKEIN, "check", str(self.scene)], capture_output=True, text=True, timeout=60)
            self.assertEqual(said.returncode, 2, said.stdout)
            self.assertIn("bad.csv:", said.stderr)
            self.assertIn(told, said.stderr)

    def test_the_example_of_the_page(self):
        page = (pathlib.Path(__file__).parents[2] / "docs/files.md").read_text()
        section = page[page.index("## Files of rods"):]
        example, scene = re.search(r"```python\n(.*?)```", section, re.S)[1], re.search(r"```toml\n(.*?)```", section, re.S)[1]
        subprocess.run([sys.executable, "-c", example], cwd=self.directory, check=True, timeout=60)
        self.scene.write_text(scene)
        self.run_skein("page", "--steps", "64")


if __name__ == "__main__":
    unittest.main()
