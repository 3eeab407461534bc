"""Rods from points along them: every format gives the same rods, whatever the ranks; the printed deviation bounds the true one; rods as by keys."""

import json
import re
import struct
import unittest

import h5py
import numpy

from driver import DriverTest

SCENE = """
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
[[rods]]
name = "traced"
start = "clamped"
material = {{density = 1000.0, youngs_modulus = 1e6}}
section.radius = 0.01
shape = {{length = 0.5, elements = {elements}{shape}}}
placement = {{{placement}}}
"""
RODS = 23


def curves():
    """Helices of 4 to 26 points at unequal distances."""
    random = numpy.random.default_rng(8)
    for rod in range(RODS):
        u = numpy.sort(numpy.concatenate([[0, 1], (numpy.arange(2 + rod) + random.uniform(0.2, 0.8, 2 + rod)) / (2 + rod)]))
        yield numpy.round(numpy.stack([0.3 * numpy.cos(1.5 * u), 0.3 * numpy.sin(1.5 * u), 0.2 * u * u + rod], axis=1), 9)


class RodPoints(DriverTest):
    def setUp(self):
        super().setUp()
        self.curves = list(curves())
        random = numpy.random.default_rng(9)
        self.radii = [numpy.round(random.uniform(0.008, 0.012, len(curve)), 9) for curve in self.curves]

    def write(self, name, scale=1.0, **data):
        """A file of these rods, of coordinates over `scale`."""
        path = self.directory / name
        if path.suffix in (".h5", ".npz"):
            data = {"points": numpy.concatenate(self.curves) / scale, "radii": numpy.concatenate(self.radii) / scale,
                    "offsets": numpy.concatenate([[0], numpy.cumsum([len(curve) for curve in self.curves])])} | data
            if path.suffix == ".npz":
                numpy.savez(path, **data)
                return
            with h5py.File(path, "w") as file:
                for key, values in data.items():
                    file[key] = values
            return
        rows = [(rod, k, *(repr(float(x)) for x in (*point / scale, radius / scale)))
                for rod, (curve, radii) in enumerate(zip(self.curves, self.radii)) for k, (point, radius) in enumerate(zip(curve, radii))]
        if path.suffix == ".swc":
            lines = [f"{number + 1} 3 {' '.join(row[2:])} {-1 if row[1] == 0 else number}" for number, row in enumerate(rows)]
        else:
            comma = "\t" if path.suffix == ".tsv" else ","
            if "mixed" in name:
                rows.sort(key=lambda row: row[1])
            lines = [comma.join(("filament", "x", "y", "z", "radius")), *(comma.join((f"rod {row[0]}", *row[2:])) for row in rows)]
        path.write_text("\n".join(lines) + "\n")

    def scene_of(self, name, more="", elements=9, shape=""):
        self.scene.write_text(SCENE.format(elements=elements, shape=shape, placement=f'kind = "file", file = "{name}"{more}'))

    def deviation(self, *options):
        """Line of the plan, and its numbers."""
        text = self.skein_says("plan", self.scene, *options).stdout
        line = re.search(r"resampled +'traced': from (.*) points each; at most (\S+) m from the line through them \((.*)\)", text)
        self.assertTrue(line, text)
        return line.groups()

    def test_every_format_gives_the_same_bits(self):
        self.write("rods.h5")
        self.scene_of("rods.h5")
        self.run_skein("h5")
        digest = self.digest("h5")
        for name in ("rods.npz", "rods.csv", "rods.tsv", "mixed.csv", "rods.swc"):
            self.write(name)
            self.scene_of(name)
            for ranks in (1, 3) if name in ("rods.csv", "mixed.csv") else (2,):
                with self.subTest(name, ranks=ranks):
                    self.run_skein(f"{name}_{ranks}", ranks=ranks)
                    self.assertEqual(self.digest(f"{name}_{ranks}"), digest)
        unit = 2.0**-20  # an exact product
        self.write("micro.csv", scale=unit)
        self.scene_of("micro.csv", f", unit = {unit!r}")
        self.run_skein("micro")
        self.assertEqual(self.digest("micro"), digest)
        self.scene_of("rods.csv", elements=14)  # any number of elements
        self.run_skein("finer")
        self.assertEqual(self.frames("finer", "trajectory")["groups/traced/position"].shape[1:], (RODS, 15, 3))

    def test_units_of_columns_and_voxels(self):
        """Columns with units of their own and voxels of unlike sides give the rods of plain metres; units that are none are refused."""
        voxel = numpy.array([2.0**-10, 2.0**-11, 3 * 2.0**-12])  # exact but for the division by 3 along z
        for curve in self.curves: curve[:, 2] = numpy.round(curve[:, 2] * 2.0**12 / 3) * 3 * 2.0**-12
        self.write("plain.h5")
        self.scene_of("plain.h5")
        self.run_skein("plain")
        digest = self.digest("plain")
        self.write("voxels.h5", points=numpy.concatenate(self.curves) / voxel, radii=1024 * numpy.concatenate(self.radii), voxel=voxel)
        self.scene_of("voxels.h5", f", unit = {2.0**-10!r}")
        self.run_skein("voxels")
        self.assertEqual(self.digest("voxels"), digest)
        names = f"filament,x[{voxel[0]!r} m],Y [{voxel[1]!r} m],z[{voxel[2]!r} m],diameter [m]".replace("np.float64(", "").replace(")", "")
        rows = [f"{rod}," + ",".join(repr(float(x)) for x in (*point / voxel, 2 * radius))
                for rod, (curve, radii) in enumerate(zip(self.curves, self.radii)) for point, radius in zip(curve, radii)]
        for unit in ("", ", unit = 0.125"):  # of columns without one, and there are none
            (self.directory / "columns.csv").write_text("\n".join([names, *rows]) + "\n")
            self.scene_of("columns.csv", unit)
            self.run_skein("columns", "--overwrite", ranks=2)
            self.assertEqual(self.digest("columns"), digest)
        short = [name + "\n" + "\n".join(rows) + "\n" for name in
                 ("filament,x[um],y[um],z[0.3um],radius[nm]", "filament,x [ 1 \u00b5m ],y[\u03bcm],z[0.3 um],radius[nm]", "filament,x[1e-3 mm],y[1e-4cm],z[300 nm],radius[1e-9 m]")]
        plans = set()
        for text in short:
            (self.directory / "columns.csv").write_text(text)
            self.scene_of("columns.csv")
            plans.add(round(self.plan()["dt"] * 1e13))
        self.assertEqual(len(plans), 1, plans)
        for name, told in (("x[furlong]", "the unit in brackets is none of m, cm"), ("x[um/s]", "is none of"), ("x[0 um]", "is none of"), ("x[-1 um]", "is none of"), ("x[nan um]", "is none of"),
                           ("x[]", "is none of"), ("x[pm]", "is none of")):
            (self.directory / "columns.csv").write_text(f"filament,{name},y,z,radius\n" + "\n".join(rows) + "\n")
            self.assertIn(told, self.skein_says("check", self.scene, expect=2).stderr, name)
        (self.directory / "columns.csv").write_text("id[um],x,y,z,radius\n" + "\n".join(rows) + "\n")
        self.assertIn("is no length and has no unit", self.skein_says("check", self.scene, expect=2).stderr)
        for bad, told in (([1.0, 1.0], "'voxel'"), ([1.0, 0.0, 1.0], "above 0"), ([1.0, numpy.nan, 1.0], "above 0")):
            self.write("voxels.h5", voxel=numpy.array(bad))
            self.scene_of("voxels.h5")
            self.assertIn(told, self.skein_says("check", self.scene, expect=2).stderr)

    def test_yarns(self):
        """Open and closed curves of a BCC file, beside the same points in arrays."""
        single = [numpy.asarray(curve, "<f4") for curve in self.curves]
        angles = [numpy.arange(9 + k) * 2 * numpy.pi / (9 + k) for k in range(4)]
        rings = [numpy.stack([0.1 * numpy.cos(a), 0.1 * numpy.sin(a), 0.02 * numpy.cos(2 * a) + k], axis=1).astype("<f4") for k, a in enumerate(angles)]
        every = [(len(curve), curve) for curve in single] + [(-len(ring), ring) for ring in rings]
        every = every[:3] + every[-2:] + every[3:-2]  # both kinds in turn
        header = struct.pack("<3sB2sBBQQ40s", b"BCC", 0x44, b"C0", 3, 2, len(every), sum(abs(n) for n, _ in every), b"yarns")
        (self.directory / "yarns.bcc").write_bytes(header + b"".join(struct.pack("<i", n) + points.tobytes() for n, points in every))
        closed = [numpy.concatenate([ring, ring[:1]]) for n, ring in every if n < 0]
        for name, curves_of, left, shape in (("open", single, "closed", ""), ("rings", closed, "open", ", closed = true")):
            def scene_of(file, more=""):
                self.scene_of(file, more, shape=shape)
                if shape:
                    self.scene.write_text(self.scene.read_text().replace('start = "clamped"\n', ""))

            scene_of("yarns.bcc")
            self.assertIn(f'placement.ignore = ["{left}"] leaves them out', self.skein_says("check", self.scene, expect=2).stderr)
            numpy.savez(self.directory / "arrays.npz", points=numpy.concatenate(curves_of), offsets=numpy.concatenate([[0], numpy.cumsum([len(c) for c in curves_of])]))
            digests = set()
            for file, more in (("yarns.bcc", f', ignore = ["{left}"], unit = 0.5'), ("arrays.npz", ", unit = 0.5")):
                scene_of(file, more)
                for ranks in (1, 2):
                    self.run_skein(f"{name}_{file}_{ranks}", ranks=ranks)
                    digests.add(self.digest(f"{name}_{file}_{ranks}"))
            self.assertEqual(len(digests), 1, digests)

    def test_equal_numbers_of_points(self):
        """One array of all rods, with the same rods as by offsets."""
        self.curves, self.radii = [curve[:4] for curve in self.curves], [radii[:4] for radii in self.radii]
        self.write("rods.h5")
        self.scene_of("rods.h5")
        self.run_skein("ragged")
        numpy.savez(self.directory / "rods.npz", points=numpy.stack(self.curves), radii=numpy.stack(self.radii))
        self.scene_of("rods.npz")
        self.run_skein("equal", ranks=2)
        self.assertEqual(self.digest("equal"), self.digest("ragged"))

    def test_the_plan_bounds_the_deviation(self):
        for name in ("rods.csv", "rods.h5"):
            self.write(name)
            for elements in (5, 9, 30):
                self.scene_of(name, elements=elements)
                points, printed, rod = self.deviation()
                self.assertEqual(points, "4 to 26")
                self.run_skein(f"{name}_{elements}", "--steps", "1", ranks=2)
                nodes = self.frames(f"{name}_{elements}", "trajectory")["groups/traced/position"][0]
                true = [max(distance(a, b), distance(b, a)) for a, b in zip(nodes, self.curves)]
                self.assertGreaterEqual(float(printed), max(true))
                self.assertLess(float(printed), 2 * max(true))
                self.assertIn(f"{int(numpy.argmax(true))}", rod)
        resampled = json.loads(self.skein_says("plan", self.scene, "--json").stdout)["groups"][0]["resampled"]
        self.assertLessEqual(resampled["deviation"], float(printed))
        self.assertEqual((resampled["fewest_points"], resampled["most_points"]), (4, 26))

    def test_first_and_last_points_are_nodes(self):
        self.write("rods.csv")
        self.scene_of("rods.csv")
        self.run_skein("out", "--steps", "1")
        nodes = self.frames("out", "trajectory")["groups/traced/position"][0]
        for rod, curve in enumerate(self.curves):
            self.assertLess(numpy.abs(nodes[rod][[0, -1]] - curve[[0, -1]]).max(), 1e-12)
            edges = numpy.linalg.norm(numpy.diff(nodes[rod], axis=0), axis=1)
            self.assertLess(edges.max() / edges.min(), 1.03 if len(curve) < 8 else 1.01)  # fourth order in the distance of points

    def test_a_rod_as_by_keys(self):
        """An arc, and a straight rod that tapers."""
        for case, shape, more, start in (("arc", ", rest_curvature = [1.5, 0.0, 0.0]", "", 1e-12), ("straight", "", "", 1e-14)):
            self.scene.write_text(SCENE.format(elements=40, shape=shape, placement=more))
            self.run_skein(f"{case}_keys")
            keys = self.frames(f"{case}_keys", "trajectory")["groups/traced/position"]
            self.curves = [keys[0][0]]
            self.radii = [numpy.full(41, 0.01)]
            self.write("one.csv")
            self.scene_of("one.csv", elements=40)
            self.run_skein(f"{case}_points")
            points = self.frames(f"{case}_points", "trajectory")["groups/traced/position"]
            moved = numpy.abs(keys[-1] - keys[0]).max()
            self.assertGreater(moved, 1e-4)
            self.assertLess(numpy.abs(points[0] - keys[0]).max(), 2e-6 if case == "arc" else start)
            self.assertLess(numpy.abs(points[-1] - keys[-1]).max(), 2e-3 * moved if case == "arc" else 1e-10 * moved)

    def test_normals(self):
        """d1 at each point, and at the start alone."""
        self.curves = [curve for curve in self.curves if len(curve) > 8]
        self.radii = [radii for radii in self.radii if len(radii) > 8]
        normals = [numpy.broadcast_to([0.1, 0.2, 1.0], curve.shape) for curve in self.curves]
        self.write("all.h5", normals=numpy.concatenate(normals))
        self.write("start.h5", normal=numpy.stack([n[0] for n in normals]))
        for name in ("all.h5", "start.h5"):
            self.scene_of(name)
            self.scene.write_text(self.scene.read_text().replace("[output]", "[output]\ndirectors = true"))
            self.run_skein(f"out_{name}", "--steps", "1")
            d1 = self.frames(f"out_{name}", "trajectory")["groups/traced/directors"][0][:, :, 0]
            nodes = self.frames(f"out_{name}", "trajectory")["groups/traced/position"][0]
            edges = numpy.diff(nodes, axis=1)
            edges /= numpy.linalg.norm(edges, axis=2, keepdims=True)
            expected = numpy.array([0.1, 0.2, 1.0]) - (edges @ [0.1, 0.2, 1.0])[..., None] * edges
            expected /= numpy.linalg.norm(expected, axis=2, keepdims=True)
            across = (d1 * expected).sum(axis=2)
            self.assertGreater((across if name == "all.h5" else across[:, 0]).min(), 1 - 1e-12, name)

    def test_a_run_goes_on_and_may_start_from_the_shape_alone(self):
        self.write("rods.csv")
        self.scene_of("rods.csv", ', trace = "start"')
        self.run_skein("whole")
        self.run_skein("halves", "--until", "0.01", ranks=2)
        self.run_skein("halves", ranks=3)
        self.assertEqual(self.digest("halves"), self.digest("whole"))
        self.assertIn("the same bits", self.skein_says("verify", self.directory / "whole").stdout)
        self.curves[3][2, 0] += 1e-9
        self.write("rods.csv")
        self.run_skein("changed", "--until", "0.01")
        self.curves[3][2, 0] += 1e-9
        self.write("rods.csv")
        self.assertIn("placement/digest", self.run_skein("changed", expect=2).stderr)

    def test_columns_by_key(self):
        rows = [("cell", "id", "x", "y", "Intensity"), *((f"c{rod}", k, *numpy.round(point[:2], 6), 3) for rod, curve in enumerate(self.curves) for k, point in enumerate(curve))]
        (self.directory / "flat.csv").write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
        self.scene_of("flat.csv", ', id = "cell", ignore = ["id", "Intensity"]')
        self.run_skein("flat", "--steps", "1")
        nodes = self.frames("flat", "trajectory")["groups/traced/position"][0]
        self.assertEqual(nodes.shape, (RODS, 10, 3))
        self.assertLess(numpy.abs(nodes[..., 2]).max(), 1e-12)
        for keys, told in ((', id = "cells"', "has no column 'cells', which placement.id names"), (', id = "cell"', "flat.csv:1: unknown column 'id'"),
                           (', id = "cell", ignore = ["ids"]', "has no column 'ids', which placement.ignore names")):
            self.scene_of("flat.csv", keys)
            self.assertIn(told, self.skein_says("check", self.scene, expect=2).stderr)
        self.write("rods.h5", notes=numpy.zeros(3))
        self.scene_of("rods.h5", ', ignore = ["notes"]')
        self.skein_says("check", self.scene)
        self.scene_of("rods.h5", ', id = "x", ignore = ["notes"]')
        self.assertIn("has no columns", self.skein_says("check", self.scene, expect=2).stderr)


def distance(line, other):
    """Largest distance of sampled points of a line from another line."""
    samples = (line[:-1, None] + numpy.linspace(0, 1, 21)[:, None] * (line[1:] - line[:-1])[:, None]).reshape(-1, 3)
    start, edge = other[:-1], numpy.diff(other, axis=0)
    share = numpy.clip(((samples[:, None] - start) * edge).sum(axis=2) / (edge**2).sum(axis=1), 0, 1)
    return numpy.linalg.norm(samples[:, None] - start - share[..., None] * edge, axis=2).min(axis=1).max()


if __name__ == "__main__":
    unittest.main()
