"""Rods from a file: the same run as from a list, whatever the format, ranks, lanes and mapping; restarts; what is refused."""

import pathlib
import re
import subprocess
import sys
import unittest

import h5py
import numpy

from driver import SKEIN, DriverTest, launch

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

    def write_file(self, name="rods.h5", options={}, **datasets):
        data = {"origin": self.origin, "tangent": self.tangent, "normal": self.normal, **datasets}
        self.write_data(name, data)
        self.write(f'kind = "file"\norigin = [0.25, 0.0, 0.0]\nfile = "{name}"', **options)

    def write_data(self, name, data):
        if name.endswith(".h5"):
            with h5py.File(self.directory / name, "w") as file:
                for key, value in data.items():
                    if value is not None:
                        file[key] = value
        else:
            columns = {"origin": "x,y,z", "tangent": "tx,ty,tz", "normal": "nx,ny,nz", "length": "length", "radius": "radius"}
            data = {key: value for key, value in data.items() if value is not None}
            lines = [",".join(columns[key] for key in data)]
            lines += [",".join(repr(float(x)) for value in data.values() for x in numpy.atleast_1d(value[i])) for i in range(len(self.origin))]
            (self.directory / name).write_text("\n".join(lines) + "\n")

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

    def test_tables_of_spreadsheets(self):
        self.end = "free"
        self.write_file("rods.csv")
        self.run_skein("plain")
        table = self.directory / "rods.csv"
        names, *rows = table.read_text().splitlines()
        names = ", ".join(f'"{name}"' for name in names.split(","))
        table.write_bytes(b"\xef\xbb\xbf" + "\r\n".join([names, *rows, "", ""]).encode())
        self.run_skein("spreadsheet")
        self.assertEqual(self.digest("spreadsheet"), self.digest("plain"))

    def test_rods_that_touch(self):
        """Their weight, and so an automatic stiffness, is that of all rods on every rank."""
        touch = '[contact]\nstiffness = "auto"\nallow_overlap = true\n'
        self.origin[:, 2] *= 0.05
        self.write_list(more=touch)
        self.run_skein("list")
        self.write_file(options={"more": touch})
        for ranks in 1, 3:
            self.run_skein(f"file_{ranks}", ranks=ranks)
            self.assertEqual(self.digest(f"file_{ranks}"), self.digest("list"))

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

    def final(self, out, group):
        return self.frames(out, "trajectory")[f"groups/{group}/position"][-1]

    def energies(self, out):
        return numpy.genfromtxt(self.directory / out / "observables.csv", delimiter=",", skip_header=1)

    def test_sizes_that_are_alike_change_no_bit(self):
        self.end = "clamped"
        self.write_list()
        self.run_skein("list")
        self.write_file(length=numpy.full(RODS, 0.5), radius=numpy.full(RODS, 0.01))
        for arguments in ((), ("--lanes", "1"), ("--mapping", "across")):
            out = "file" + "".join(arguments)
            self.run_skein(out, *arguments)
            self.assertEqual(self.digest(out), self.digest("list"), arguments)
            self.assertTrue(numpy.array_equal(self.energies(out), self.energies("list")))

    def test_rods_of_their_own_sizes_move_as_groups_of_their_own(self):
        random = numpy.random.default_rng(7)
        length, radius = random.uniform(0.2, 1.5, RODS), random.uniform(0.005, 0.03, RODS)
        for case, end in (("free", "free"), ("clamped", "clamped"), ("sliding", 'free"\nstart_free = "xz')):
            self.end = end
            self.write_file(length=length, radius=radius)
            self.run_skein(f"file_{case}")
            for name, layout, arguments in (("rods.h5", {"ranks": 3}, ()), ("rods.csv", {"threads": 2}, ("--lanes", "1")),
                                            ("rods.h5", {"ranks": 2}, ("--lanes", "4"))):
                self.write_file(name, length=length, radius=radius)
                out = f"file_{case}_{layout}{arguments}{name}".replace(" ", "")
                self.run_skein(out, *arguments, **layout)
                self.assertEqual(self.digest(out), self.digest(f"file_{case}"), (layout, arguments))
                self.assertTrue(numpy.array_equal(self.energies(out), self.energies(f"file_{case}")))
                mine, theirs = self.frames(out, "trajectory"), self.frames(f"file_{case}", "trajectory")
                for dataset in theirs:
                    self.assertTrue(numpy.array_equal(mine[dataset], theirs[dataset]), dataset)
            # The magnetisation of groups alone is measured from their own corners.
            self.write_file(options={"field": False}, length=length, radius=radius)
            self.run_skein(f"alone_{case}")
            groups = ""
            for i in range(RODS):
                group = GROUP.format(name=f"r{i}", end=end, placement=f"origin = {list(self.origin[i] + [0.25, 0, 0])}\n"
                                     f"tangent = {list(self.tangent[i])}\nnormal = {list(self.normal[i])}")
                groups += group.replace("length = 0.5\n", f"length = {length[i]}\n").replace("radius = 0.01\n", f"radius = {radius[i]}\n")
            self.scene.write_text(HEAD + groups)
            self.run_skein(f"groups_{case}")
            twin = self.frames(f"groups_{case}", "trajectory")
            mine = self.frames(f"alone_{case}", "trajectory")
            self.assertTrue(numpy.array_equal(mine["time"], twin["time"]))  # of one step, the least of all limits
            for i in range(RODS):
                self.assertLess(numpy.abs(twin[f"groups/r{i}/position"][-1][0] - mine["groups/traced/position"][-1][i]).max(), 1e-12, i)
                self.assertTrue(numpy.array_equal(twin[f"groups/r{i}/radius"], mine["groups/traced/radius"][i]))
            self.assertTrue(numpy.allclose(self.energies(f"alone_{case}"), self.energies(f"groups_{case}"), rtol=1e-9, atol=1e-12))
            summaries = [self.summary(f"{run}_{case}") for run in ("alone", "groups")]
            self.assertEqual(*(summary["steps"] for summary in summaries))

    def traced(self):
        """Helices of their own pitch and length, unevenly cut into six elements."""
        random = numpy.random.default_rng(11)
        nodes = []
        for i in range(RODS):
            s = numpy.sort(random.uniform(0.05, 0.95, 5) * 0.2 + 0.8 * numpy.linspace(0.1, 0.9, 5))
            s = numpy.concatenate([[0], s, [1]]) * random.uniform(0.5, 2)
            nodes.append(self.origin[i] + numpy.stack([0.4 * numpy.cos(s) - 0.4, 0.4 * numpy.sin(s), random.uniform(-0.3, 0.3) * s], axis=1))
        return numpy.array(nodes)

    def test_traced_rods(self):
        nodes, random = self.traced(), numpy.random.default_rng(3)
        radii = random.uniform(0.01, 0.02, nodes.shape[:2])
        quiet = {"field": False}
        for end in ("free", "clamped"):
            self.end = end
            file = {"origin": None, "tangent": None, "normal": None, "nodes": nodes, "radii": radii}
            self.write_file(options=quiet, **file)
            text = self.scene.read_text().replace('kind = "gravity"', 'kind = "gravity"\nacceleration = [0.0, 0.0, 0.0]')
            self.scene.write_text(text)
            self.run_skein(f"rest_{end}")
            trajectory = self.frames(f"rest_{end}", "trajectory")
            for frame in trajectory["groups/traced/position"]:  # at rest where they were traced
                self.assertLess(numpy.abs(frame - [0.25, 0, 0] - nodes).max(), 1e-12)
            inner = 0.25 * (radii[:, :-2] + 2 * radii[:, 1:-1] + radii[:, 2:])
            self.assertLess(numpy.abs(trajectory["groups/traced/radius"][:, 1:-1] - inner).max(), 1e-15)
            self.run_skein(f"rest3_{end}", "--lanes", "2", ranks=3)
            self.assertEqual(self.digest(f"rest3_{end}"), self.digest(f"rest_{end}"))
            self.scene.write_text(text.replace('file = "rods.h5"', 'file = "rods.h5"\ntrace = "start"'))
            self.run_skein(f"start_{end}")
            frames = self.frames(f"start_{end}", "trajectory")["groups/traced/position"]
            self.assertLess(numpy.abs(frames[0] - [0.25, 0, 0] - nodes).max(), 1e-12)
            self.assertGreater(numpy.abs(frames[-1] - frames[0]).max(), 1e-4)  # towards the curvature of the scene
        # What a run has written is traced again, with its directors.
        self.write_file(options=quiet, **file)
        self.scene.write_text(self.scene.read_text().replace("[output]", "[output]\ndirectors = true"))
        self.run_skein("sagging")
        sagging = self.frames("sagging", "trajectory")
        file = {**file, "nodes": sagging["groups/traced/position"][-1] - [0.25, 0, 0], "directors": sagging["groups/traced/directors"][-1]}
        self.write_file(options=quiet, **file)
        self.scene.write_text(self.scene.read_text().replace("[output]", "[output]\ndirectors = true").replace(
            'kind = "gravity"', 'kind = "gravity"\nacceleration = [0.0, 0.0, 0.0]'))
        self.run_skein("again")
        again = self.frames("again", "trajectory")
        self.assertLess(numpy.abs(again["groups/traced/position"][-1] - sagging["groups/traced/position"][-1]).max(), 1e-12)
        across = numpy.einsum("rki,rki->rk", again["groups/traced/directors"][-1][:, :, 0], sagging["groups/traced/directors"][-1][:, :, 0])
        self.assertGreater(across.min(), 0.9999)  # but for shear, as directors of a file follow its edges

    def test_a_run_goes_on_with_its_own_file_alone(self):
        length = numpy.linspace(0.3, 0.9, RODS)
        self.write_file(length=length)
        self.run_skein("whole")
        self.run_skein("halves", "--until", "0.01", ranks=2)
        (self.directory / "elsewhere").mkdir()
        (self.directory / "rods.h5").rename(self.directory / "elsewhere/same.h5")
        self.scene.write_text(self.scene.read_text().replace("rods.h5", "elsewhere/same.h5"))
        self.run_skein("halves", ranks=3)
        self.assertEqual(self.digest("halves"), self.digest("whole"))
        self.write_file(length=length)
        self.run_skein("changed", "--until", "0.01")
        moved = self.origin.copy()
        moved[3, 1] += 1e-12
        for change in ({"origin": moved, "length": length}, {"length": numpy.nextafter(length, 1)}):
            self.write_file(**change)
            self.assertIn("placement/digest", self.run_skein("changed", expect=2).stderr)

    def test_formulas_are_tried_at_the_start_of_the_rods(self):
        """Whichever rank reads the rod that a formula fails at, all refuse before anything is written; so does check."""
        load = '\n[[load]]\nkind = "formula"\nforce = ["1/(rod - {})", "0", "0"]\n'
        for rod, lengths in ((5, None), (RODS - 1, numpy.linspace(0.3, 0.9, RODS))):
            self.write_file(length=lengths, options={"more": load.format(rod)})
            for ranks in (1, 2, 3):
                self.assertIn("divides by 0", self.run_skein("none", ranks=ranks, expect=2).stderr)
                self.assertFalse((self.directory / "none").exists())
            self.assertIn(f"of rod {rod} of 'traced'", self.skein_says("check", self.scene, expect=2).stderr)
        self.write_file(options={"more": load.format(-5)})
        self.run_skein("sound", "--until", "0.001", ranks=2)

    def test_branches_and_verification(self):
        length = numpy.linspace(0.3, 0.9, RODS)
        self.write_file(length=length)
        self.run_skein("whole", ranks=2)
        whole = self.directory / "whole"
        self.assertIn("the same bits", self.skein_says("verify", whole, ranks=3).stdout)
        step = min(int(path.stem.split("_")[1]) for path in whole.glob("checkpoint_*.h5") if not path.stem.endswith("_0"))
        self.skein_says("branch", f"{whole}@{step}", self.directory / "deep/er/same")  # the file is found from there
        self.skein_says("run", self.directory / "deep/er/same", ranks=2)
        self.assertEqual(self.digest("deep/er/same"), self.digest("whole"))
        self.skein_says("branch", f"{whole}@{step}", self.directory / "light", "--set", "load.gravity.acceleration=[0,0,-1]")
        self.skein_says("run", self.directory / "light")
        self.assertNotEqual(self.digest("light"), self.digest("whole"))
        (self.directory / "rods.h5").rename(self.directory / "same.h5")
        text = self.scene.read_text().replace('"rods.h5"', '"same.h5"')
        self.scene.write_text(text + f'[start]\nfrom = "whole@{step}"\n')
        self.run_skein("started", ranks=2)
        self.assertEqual(self.digest("started"), self.digest("whole"))
        self.assertIn("there is no rod file", self.skein_says("verify", whole, expect=2).stderr)
        # Another geometry under the same name has no such state.
        self.write_file(length=numpy.nextafter(length, 1))
        self.assertIn("placement.digest", self.skein_says("verify", whole, expect=2).stderr)
        self.assertIn("placement.digest", self.skein_says("branch", whole, self.directory / "other", expect=2).stderr)
        self.assertFalse((self.directory / "other").exists())
        self.scene.write_text(self.scene.read_text() + f'[start]\nfrom = "whole@{step}"\n')
        self.assertIn("placement.digest", self.run_skein("other", expect=2).stderr)

    def refused(self, said, name="rods.h5", **datasets):
        self.write_file(name, **datasets)
        done = subprocess.run([SKEIN, "check", str(self.scene)], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(said, done.stderr)
        done = launch("run", self.scene, "--out", self.directory / "none", ranks=3, refused=True, timeout=60)
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
            self.refused(name + ": " + at("length", 3) + "must be above 0", name, length=with_row(numpy.ones(RODS), 3, -1))
            self.refused(name + ": " + at("radius", 36) + "not a finite number", name, radius=with_row(numpy.ones(RODS), 36, numpy.inf))
        self.refused("the rest curvature of rod 3 of 'traced', 50 m long by file 'rods.h5', turns element 1 against element 0 by 3.82 rad",
                     length=with_row(numpy.ones(RODS), 3, 50))
        self.refused("dataset 'tangent' has 36 rows, but 'origin' has 37", tangent=self.tangent[1:])
        self.refused("dataset 'origin' has the shape [37, 2]; it must be [rods, 3]", origin=self.origin[:, :2])
        self.refused("unknown dataset 'tangents'; a rod file has origin, tangent, normal", tangents=self.tangent)
        self.refused("dataset 'origin' does not hold numbers", origin=[b"a", b"b"])
        nodes, none = self.traced(), {"origin": None, "tangent": None, "normal": None}
        twice = nodes.copy()
        twice[4, 3] = twice[4, 2]
        back = nodes.copy()
        back[9, 3] = back[9, 1]
        directors = numpy.zeros((RODS, 6, 3, 3))
        self.refused("dataset 'nodes', row 4: nodes 2 and 3 are one point", **none, nodes=twice)
        self.refused("dataset 'nodes', row 9: turns back at node 2", **none, nodes=back)
        self.refused("dataset 'directors', row 0: d1 of element 0 is not across the rod", **none, nodes=nodes, directors=directors)
        self.refused("has rods of 5 elements, but others have 6", **none, nodes=nodes, directors=directors[:, 1:])
        self.refused("is of rods of 5 elements, but shape.elements of 'traced' is 6", **none, nodes=nodes[:, 1:])
        self.refused("'tangent' conflicts with 'nodes'", origin=None, normal=None, nodes=nodes)
        self.refused("'directors' without 'nodes'", normal=None, directors=directors)
        self.refused("dataset 'nodes' has the shape [37, 7, 2]; it must be [rods, elements + 1, 3]", **none, nodes=nodes[:, :, :2])
        self.refused("'radius' conflicts with 'radii'", radius=numpy.ones(RODS), radii=numpy.ones((RODS, 7)))
        self.write('kind = "file"\nfile = "nowhere.h5"')
        said = subprocess.run([SKEIN, "check", str(self.scene)], capture_output=True, text=True, timeout=60).stderr
        self.assertIn("there is no rod file", said)
        for text, told in (("x,y\n1,2\n", "origin has only 2 of three columns"), ("x,y,z,w\n", "unknown column 'w'"),
                           ("x,y,z\n1,2\n", "row 1 below the names: origin: expected 3 values"),
                           ("x,y,z\n1,2,three\n", "'z': 'three' is not a number"), ("x,y,z\n", "it contains no rods"), ("x,y,x\n", "two columns 'x'")):
            (self.directory / "bad.csv").write_text(text)
            self.write('kind = "file"\nfile = "bad.csv"')
            said = subprocess.run([SKEIN, "check", str(self.scene)], capture_output=True, text=True, timeout=60)
            self.assertEqual(said.returncode, 2, said.stdout)
            self.assertIn("bad.csv:", said.stderr)
            self.assertIn(told, said.stderr)

    def test_the_shipped_traces_are_those_of_their_program(self):
        folder = pathlib.Path(__file__).parents[2] / "apps/traced"
        subprocess.run([sys.executable, str(folder / "make_traces.py"), "--file", str(self.directory / "traces.h5")], check=True, timeout=60)
        with h5py.File(folder / "traces.h5") as shipped, h5py.File(self.directory / "traces.h5") as made:
            self.assertEqual(set(shipped), {"nodes", "radii"})
            for name in shipped:
                self.assertTrue(numpy.array_equal(shipped[name][:], made[name][:]), name)

    def test_the_example_of_the_page(self):
        page = (pathlib.Path(__file__).parents[2] / "docs/files.md").read_text()
        section = page[page.index("## Files of rods"):]
        example, scene = re.search(r"```python\n(.*?)```", section, re.S)[1], re.search(r"```toml\n(.*?)```", section, re.S)[1]
        subprocess.run([sys.executable, "-c", example], cwd=self.directory, check=True, timeout=60)
        self.scene.write_text(scene)
        self.run_skein("page", "--steps", "64")


if __name__ == "__main__":
    unittest.main()
