"""Slices, boxes of means and blocks of a fluid: what they hold is what the whole frame holds there, on any ranks, across restarts; ParaView's
readers find it."""

import itertools
import pathlib
import random
import re
import subprocess
import sys
import unittest

import h5py
import numpy

from driver import BALL_IN_IT, FLUID_IN_A_BOX, DriverTest

try:  # Debian: python3-vtk9 or python3-paraview
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkDataObjectTreeIterator, vtkImageData, vtkRectilinearGrid
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
    from vtkmodules.vtkIOXdmf3 import vtkXdmf3Reader
except ImportError:
    vtkXdmfReader = None

CELLS, SPACING, LOWER = (24, 20, 16), 0.1, (0.5, -1.0, 0.0)
FIELDS = {"velocity": 3, "vorticity": 3, "q": 1, "pressure": 1}
SCENE = """
[time]
duration = 0.4
""" + FLUID_IN_A_BOX + """
velocity_formula = ["U * sin(k*y) * (1 + 0.2 * cos(2*k*z))", "0.3 * U * sin(2 * k * x / 2.4)", "0 * U"]
""" + BALL_IN_IT + """
[output]
checkpoint = 0.2
[[fluid_output]]
name = "all"
kind = "box"
every = 0.1
precision = "double"
"""
FRAMES = 5


def table(**keys):
    def value(x):
        return f'"{x}"' if isinstance(x, str) else "[" + ", ".join(map(value, x)) + "]" if isinstance(x, (list, tuple)) else repr(x)

    return "[[fluid_output]]\n" + "".join(f"{key} = {value(x)}\n" for key, x in keys.items())


def corner(cell):
    return [LOWER[d] + SPACING * cell[d] for d in range(3)]


def drawn(seed, count):
    """Outputs of all kinds, with what they should show."""
    draw = random.Random(seed)
    outputs = []
    for number, kind in zip(range(count), itertools.cycle(["slice", "box", "blocks"])):
        fields = draw.sample(sorted(FIELDS), draw.randint(1, 4))
        keys = {"name": f"out-{number}", "kind": kind, "every": draw.choice([0.1, 0.2]), "fields": fields, "precision": draw.choice(["single", "double"])}
        more = {}
        if kind == "slice":
            axis = draw.randrange(3)
            cell = draw.randrange(CELLS[axis])
            keys |= {"across": "xyz"[axis], "at": LOWER[axis] + SPACING * (cell + draw.uniform(0.05, 0.95))}
            more = {"axis": axis, "cell": cell}
        if kind == "box":
            n = draw.choice([1, 2, 3, 4, 5, 7])
            count = [draw.randint(1, CELLS[d] // n) for d in range(3)]
            first = [draw.randint(0, CELLS[d] - n * count[d]) for d in range(3)]
            keys |= {"average": n, "lower": corner(first), "upper": corner([first[d] + n * count[d] for d in range(3)])}
            more = {"first": first, "count": count}
        if kind == "blocks":
            keys |= {"edge": draw.choice([4, 6, 8, 16]), "criterion": draw.choice(["q", "vorticity"])}
            keys["threshold"] = draw.uniform(2.0, 10.0) if keys["criterion"] == "q" else draw.uniform(3.0, 8.0)
        outputs.append((keys, more))
    return outputs


class FluidOutput(DriverTest):
    def write_scene(self, *tables):
        self.scene.write_text(SCENE + "".join(tables))

    def frames(self, out, name):
        for path in sorted((self.directory / out).glob(f"fluid_{name}_*.h5")):
            with h5py.File(path) as file:
                yield path.name[-15:-3], {key: file[key][:] for key in file if key != "blocks"}, dict(file.attrs)

    def files(self, out):
        return {path.name: path.read_bytes() for path in (self.directory / out).glob("fluid_*")}

    def test_all_kinds_hold_what_the_whole_frame_holds(self):
        for seed in (1, 2):
            outputs = drawn(seed, 12)
            self.write_scene(*(table(**keys) for keys, _ in outputs))
            out = f"seed{seed}"
            self.run_skein(out)
            whole = {step: frame for step, frame, _ in self.frames(out, "all")}
            self.assertEqual(len(whole), FRAMES)
            written, left_out = 0, 0
            for keys, more in outputs:
                count = 0
                for step, frame, attributes in self.frames(out, keys["name"]):
                    count += 1
                    self.assertEqual(set(frame) - {"lower"}, set(keys["fields"]), keys)
                    self.assertEqual({frame[field].dtype for field in keys["fields"]}, {numpy.dtype("f4" if keys["precision"] == "single" else "f8")})
                    tolerance = {"rtol": 1e-6 if keys["precision"] == "single" else 1e-12, "atol": 1e-6 if keys["precision"] == "single" else 1e-12, "err_msg": str(keys)}
                    getattr(self, "check_" + keys["kind"])(keys, more, frame, attributes, whole[step], tolerance)
                    if keys["kind"] == "blocks":
                        written += len(frame["lower"])
                        left_out += numpy.prod([-(-n // keys["edge"]) for n in CELLS]) - len(frame["lower"])
                self.assertEqual(count, 5 if keys["every"] == 0.1 else 3, keys)
            self.assertGreater(written, 10)
            self.assertGreater(left_out, 10)

    def check_slice(self, keys, more, frame, attributes, whole, tolerance):
        self.assertEqual(attributes["across"].decode(), keys["across"])
        for field in keys["fields"]:
            numpy.testing.assert_allclose(frame[field], numpy.take(whole[field], [more["cell"]], axis=2 - more["axis"]), **tolerance)
        self.assertAlmostEqual(attributes["lower_" + keys["across"]], corner([more["cell"]] * 3)[more["axis"]])

    def check_box(self, keys, more, frame, attributes, whole, tolerance):
        n, (x, y, z), (nx, ny, nz) = keys["average"], more["first"], more["count"]
        self.assertAlmostEqual(attributes["spacing"], n * SPACING)
        for d in range(3):
            self.assertAlmostEqual(attributes["lower_" + "xyz"[d]], keys["lower"][d])
        for field in keys["fields"]:
            cells = whole[field][z : z + n * nz, y : y + n * ny, x : x + n * nx].reshape(nz, n, ny, n, nx, n, -1)
            numpy.testing.assert_allclose(frame[field].reshape(nz, ny, nx, -1), cells.mean(axis=(1, 3, 5)), **tolerance)

    def check_blocks(self, keys, more, frame, attributes, whole, tolerance):
        n = keys["edge"]
        size = abs(whole["q"]) if keys["criterion"] == "q" else numpy.linalg.norm(whole["vorticity"], axis=-1)
        expected = [(x, y, z) for z in range(0, CELLS[2], n) for y in range(0, CELLS[1], n) for x in range(0, CELLS[0], n)
                    if size[z : z + n, y : y + n, x : x + n].max() > keys["threshold"]]
        found = [tuple(numpy.rint((row - LOWER) / SPACING).astype(int)) for row in frame["lower"]]
        self.assertEqual(found, expected, keys)
        for field in keys["fields"]:
            self.assertEqual(frame[field].shape[:4], (len(found), n, n, n))
            for block, (x, y, z) in zip(frame[field], found):
                cells = whole[field][z : z + n, y : y + n, x : x + n]
                nz, ny, nx = cells.shape[:3]
                numpy.testing.assert_allclose(block[:nz, :ny, :nx], cells, **tolerance)
                self.assertEqual(numpy.isnan(block).sum(), block.size - cells.size, "beyond the grid")

    def test_the_same_files_on_any_ranks_and_after_a_stop(self):
        self.write_scene(*(table(**keys) for keys, _ in drawn(3, 12)))
        self.run_skein("one")
        whole = self.files("one")
        self.assertGreater(len(whole), 50)
        self.run_skein("two", ranks=2)
        self.run_skein("three", ranks=3)
        self.run_skein("threads", threads=2)
        self.run_skein("rows", "--set", "fluid.ranks_across=2", ranks=4)
        self.run_skein("parts", "--steps", "2", ranks=2)
        self.assertLess(len(self.files("parts")), len(whole))
        self.assertIn("Resuming from", self.run_skein("parts", ranks=3).stdout)
        for out in ("two", "three", "threads", "rows", "parts"):
            files = self.files(out)
            self.assertEqual(set(files), set(whole), out)
            for name in whole:
                self.assertEqual(files[name], whole[name], f"{out}/{name}")

    def test_outputs_may_change_at_a_restart(self):
        """Frames of before stay; the document lists those that show what the newest does."""
        keys = {"name": "plane", "kind": "slice", "every": 0.1, "at": 0.75}
        self.write_scene(table(**keys))
        self.run_skein("out", "--steps", "2")
        self.write_scene(table(**keys, fields=["q"]))
        self.assertIn("Resuming from", self.run_skein("out").stdout)
        self.assertEqual(len(list((self.directory / "out").glob("fluid_plane_*.h5"))), FRAMES)
        listed = set(re.findall(r"fluid_plane_\d+", (self.directory / "out/fluid_plane.xdmf").read_text()))
        self.assertEqual(listed, {f"fluid_plane_{step:012d}" for step in (2, 3, 4)})

    def test_a_picture_of_a_slice(self):
        slices = [table(name=name, kind="slice", every=0.2, at=0.75, fields=fields) for name, fields in (("mid", ["vorticity"]), ("mid_q", ["q"]))]
        self.write_scene(*slices)
        self.run_skein("out")
        plot = [sys.executable, str(pathlib.Path(__file__).resolve().parents[2] / "apps/flow/plot.py"), str(self.directory / "out"), "--slice"]
        subprocess.run([*plot, "mid"], check=True, stdout=subprocess.DEVNULL)
        self.assertEqual((self.directory / "out/flow.png").read_bytes()[:4], b"\x89PNG")
        for name, told in (("mid_q", "has no vorticity"), ("all", "is no slice"), ("other", "give a [[fluid_output]] of this name")):
            done = subprocess.run([*plot, name], capture_output=True, text=True)
            self.assertEqual(done.returncode, 1)
            self.assertIn(told, done.stderr)

    @unittest.skipIf(vtkXdmfReader is None, "needs VTK")
    def test_paraview_reads_them(self):
        blocks = {"name": "vortices", "kind": "blocks", "every": 0.1, "threshold": 4.0, "edge": 8}
        self.write_scene(table(name="plane", kind="slice", every=0.1, across="y", at=0.21), table(name="means", kind="box", every=0.1, average=4),
                         table(**blocks), table(**blocks | {"name": "none", "threshold": 1e6}))
        self.run_skein("out")
        for make, name in itertools.product((vtkXdmfReader, vtkXdmf3Reader), ("plane", "means", "vortices", "none")):
            with self.subTest(reader=make.__name__, name=name):
                reader = make()
                reader.SetFileName(str(self.directory / f"out/fluid_{name}.xdmf"))
                reader.UpdateInformation()
                times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
                numpy.testing.assert_allclose(times, [0.1 * k for k in range(FRAMES)])
                for time, (_, frame, attributes) in zip(times, self.frames("out", name)):
                    reader.UpdateTimeStep(time)
                    grids = leaves(reader.GetOutputDataObject(0))
                    lower = [[attributes["lower_" + d] for d in "xyz"]] if name in ("plane", "means") else frame["lower"]
                    self.assertEqual(len(grids), len(lower))
                    for number, (grid, first) in enumerate(zip(grids, lower)):
                        numpy.testing.assert_allclose(grid.GetBounds()[::2], first, atol=1e-9)
                        for field in FIELDS:
                            values = frame[field] if name in ("plane", "means") else frame[field][number]
                            nx, ny, nz = (n - 1 for n in grid.GetDimensions())
                            numpy.testing.assert_array_equal(vtk_to_numpy(grid.GetCellData().GetArray(field)).ravel(), values[:nz, :ny, :nx].ravel())


def leaves(data):
    if isinstance(data, (vtkImageData, vtkRectilinearGrid)):
        return [data]
    walk = vtkDataObjectTreeIterator()
    walk.SetDataSet(data)
    found = []
    walk.InitTraversal()
    while not walk.IsDoneWithTraversal():
        found.append(walk.GetCurrentDataObject())
        walk.GoToNextItem()
    return found


if __name__ == "__main__":
    unittest.main()
