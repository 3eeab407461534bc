"""Frames as poly data: what ParaView opens is what the trajectory holds, at once ready for Tube; the same on any ranks, across restarts."""

import math
import re
import resource
import shutil
import struct
import subprocess
import time
import unittest
from xml.etree import ElementTree

import h5py
import numpy

from driver import LAW, SCENE, SKEIN, STICKS, DriverTest, bed_under_a_lid

try:  # Debian: python3-vtk9 or python3-paraview
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkDataObject
    from vtkmodules.vtkFiltersCore import vtkTriangleFilter, vtkTubeFilter
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
except ImportError:
    vtkXMLPolyDataReader = None

BED = bed_under_a_lid(30, 0.16) + """
[output]
trajectory = 0.02
series = 0.02
checkpoint = 0.05
precision = "double"
"""

CURVES = """
[time]
duration = 1e-3
[[rods]]
name = "straight"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.01
[rods.shape]
length = 1.0
elements = 10
[rods.placement]
kind = "line"
counts = [3]
spacing = [0.5]
[[rods]]
name = "helix"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.005
[rods.shape]
length = 2.0
elements = 200
rest_curvature = [6.0, 0.0, 1.0]
[output]
trajectory = 1e-3
"""

TYPES = {"Int32": "<i4", "Int64": "<i8", "Float32": "<f4", "Float64": "<f8"}


def read_vtp(path):
    """Arrays by part and name, by what the format says: a head of XML, then numbers, each array behind the count of its bytes."""
    content = path.read_bytes()
    content, stamp = content[:-86], content[-86:]
    assert re.fullmatch(rb"<!-- step \d{20} after [-\d]{20} digest [0-9a-f]{16} -->\n", stamp)
    assert content.endswith(b"\n</AppendedData>\n</VTKFile>\n")
    summed = numpy.frombuffer(content[: -len(b"\n</AppendedData>\n</VTKFile>\n")], numpy.uint8)
    digest = int(summed.astype(numpy.uint64) @ (2 * numpy.arange(len(summed), dtype=numpy.uint64) + numpy.uint64(1)))
    step, after = int(stamp[10:30]), int(stamp[37:57])
    assert int(stamp[65:81], 16) == (digest + 1 + 3 * step + 5 * after) % 2**64
    head, marker = content.split(b'<AppendedData encoding="raw">\n_', 1)
    tree = ElementTree.fromstring(head + b"</VTKFile>")
    assert tree.get("type") == "PolyData" and tree.get("header_type") == "UInt64" and tree.get("byte_order") == "LittleEndian"
    found = {"time": float(tree.find("PolyData/FieldData/DataArray").text), "piece": tree.find("PolyData/Piece").attrib}
    end = 0
    for part in tree.find("PolyData/Piece"):
        for array in part:
            offset, components = int(array.get("offset")), int(array.get("NumberOfComponents"))
            (size,) = struct.unpack_from("<Q", marker, offset)
            numbers = numpy.frombuffer(marker, TYPES[array.get("type")], size // int(TYPES[array.get("type")][-1]), offset + 8)
            found[part.tag, array.get("Name")] = numbers.reshape(-1, components) if components > 1 else numbers
            end = max(end, offset + 8 + size)
    assert len(marker) == end + len(b"\n</AppendedData>\n</VTKFile>\n")
    return found


def listed(path):
    """Times and files of a .pvd."""
    return [(float(entry.get("timestep")), entry.get("file")) for entry in ElementTree.parse(path).getroot().iter("DataSet")]


def node_lengths(vtp):
    """Of a rod that is not stretched: half of the elements on both sides."""
    lengths = numpy.zeros(len(vtp["Points", "Points"]))
    begin = 0
    for end in vtp["Lines", "offsets"]:
        sides = numpy.linalg.norm(numpy.diff(vtp["Points", "Points"][begin:end], axis=0), axis=1)
        lengths[begin : end - 1] += 0.5 * sides
        lengths[begin + 1 : end] += 0.5 * sides
        begin = end
    return lengths


class ParaView(DriverTest):
    def files(self, out):
        folder = self.directory / out
        names = [*folder.glob("*.pvd"), *folder.glob("vtp/*")]
        return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(names)}

    def trajectory(self, out):
        """Of each frame: time and groups' datasets."""
        for segment in sorted((self.directory / out).glob("trajectory_*.h5")):
            with h5py.File(segment) as file:
                for k, time in enumerate(file["time"]):
                    yield time, {name: {key: data[k] if key in ("position", "normal") else data[:] for key, data in group.items()
                                        if key != "frames"} for name, group in file["groups"].items()}

    def test_holds_what_the_trajectory_holds(self):
        self.run_skein("out")
        folder = self.directory / "out"
        frames = list(self.trajectory("out"))
        series = listed(folder / "rods.pvd")
        self.assertEqual([time for time, _ in series], [time for time, _ in frames])
        self.assertEqual(len(series), 9)
        for (time, name), (_, groups) in zip(series, frames):
            vtp = read_vtp(folder / name)
            self.assertEqual(vtp["time"], time)
            together = lambda key: numpy.concatenate([numpy.reshape(g[key], (-1, *g[key].shape[2:])) for g in groups.values()])
            self.assertTrue(numpy.array_equal(vtp["Points", "Points"], together("position")))
            self.assertTrue(numpy.allclose(vtp["PointData", "normal"], together("normal"), atol=1e-6))
            self.assertTrue(numpy.allclose(vtp["PointData", "radius"], numpy.ravel(together("point_radius"))))
            nodes = [g["position"].shape[1] for g in groups.values() for _ in range(len(g["position"]))]
            self.assertTrue(numpy.array_equal(vtp["Lines", "offsets"], numpy.cumsum(nodes)))
            self.assertTrue(numpy.array_equal(vtp["Lines", "connectivity"], numpy.arange(sum(nodes))))
            self.assertTrue(numpy.array_equal(vtp["CellData", "group"], [0] * 25 + [1] * 3))
            self.assertTrue(numpy.array_equal(vtp["CellData", "rod"], [*range(25), *range(3)]))
            moments = vtp["CellData", "magnetisation"]
            self.assertTrue(numpy.allclose(moments[:25], groups["cilia"]["magnetisation"]) and not moments[25:].any())
            self.assertEqual(vtp["piece"]["NumberOfLines"], "28")
        self.assertNotIn(("PointData", "contact_force"), vtp)
        self.assertFalse((folder / "walls.pvd").exists())
        self.assertGreater(numpy.abs(vtp["PointData", "curvature"]).max(), 0.05)
        self.assertGreater(numpy.abs(vtp["PointData", "velocity"]).max(), 1e-3)

    def test_velocity_and_strain_are_those_of_the_frame(self):
        rods = CURVES.split("[[rods]]")[1]
        hanging = rods.replace('"straight"', '"hanging"\nstart = "clamped"').replace("counts = [3]", "counts = [3]\ntangent = [0.0, 0.0, -1.0]")
        self.scene.write_text(f"""
[time]
duration = 0.03
[[rods]]{rods}
[[rods]]{hanging}
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]
[output]
trajectory = 0.01
precision = "double"
""")
        self.run_skein("out")
        folder = self.directory / "out"
        frames = listed(folder / "rods.pvd")
        self.assertEqual(len(frames), 4)
        for time, name in frames:
            vtp = read_vtp(folder / name)
            node, velocity, strain = (vtp[key].reshape(6, 11, -1) for key in (("Points", "Points"), ("PointData", "velocity"), ("PointData", "strain")))
            # Rods that fall freely, up to rounding of many steps.
            self.assertTrue(numpy.allclose(velocity[:3], [0, 0, -9.81 * time], rtol=1e-10, atol=1e-12), velocity[0, 0])
            self.assertTrue(numpy.allclose(strain[:3], 0, atol=1e-9))
            # Rods that hang are stretched along a line: their strain is what their nodes say.
            stretch = numpy.linalg.norm(numpy.diff(node[3:], axis=1), axis=2) / 0.1 - 1
            at_nodes = 0.5 * (numpy.concatenate([stretch[:, :1], stretch], axis=1) + numpy.concatenate([stretch, stretch[:, -1:]], axis=1))
            self.assertTrue(numpy.allclose(strain[3:, :, 0], at_nodes, atol=1e-12))
        self.assertGreater(strain[3:].max(), 1e-3)

    def test_contact_forces_balance_walls_stand_where_they_are_and_energy_sums_up(self):
        self.scene.write_text(BED)
        self.run_skein("out")
        folder = self.directory / "out"
        series = numpy.genfromtxt(folder / "observables.csv", delimiter=",", names=True)
        rods, walls = listed(folder / "rods.pvd"), listed(folder / "walls.pvd")
        self.assertEqual([time for time, _ in rods], list(series["times"]))
        self.assertEqual([time for time, _ in walls], list(series["times"]))
        pressed = 0
        for (_, name), (_, wall_name), row in zip(rods, walls, series):
            vtp, wall = read_vtp(folder / name), read_vtp(folder / wall_name)
            force = vtp["PointData", "contact_force"]
            pressed = max(pressed, numpy.abs(force).max())
            self.assertLess(numpy.abs(force.sum(axis=0)).max(), 1e-12 * max(1, numpy.abs(force).sum()))
            self.assertEqual(numpy.abs(force).max() > 0, row["contacts"] > 0 and row["step"] > 0)
            elastic = sum(row[f"elastic_{kind}J"] for kind in ("stretch", "shear", "bend", "twist"))
            length = numpy.tile(numpy.r_[0.5, numpy.ones(5), 0.5] * 0.1 / 6, 30)
            self.assertAlmostEqual((vtp["PointData", "energy"] * length).sum(), elastic, delta=1e-9 * elastic + 1e-18)
            corners = {}
            begin = 0
            for end, number in zip(wall["Polys", "offsets"], wall["CellData", "wall"]):
                corners[number] = wall["Points", "Points"][wall["Polys", "connectivity"][begin:end]]
                begin = end
            self.assertEqual(sorted(corners), [0, 1, 2, 3, 4, 5])
            for number in range(5):  # sides of the box, cut by each other
                self.assertTrue(numpy.all(corners[number][:, :2] > -1e-6) and numpy.all(corners[number][:, :2] < 0.15 + 1e-6))
            floor = {tuple(numpy.round(corner, 6) + 0.0) for corner in corners[4]}
            self.assertEqual(floor, {(0, 0, 0), (0.15, 0, 0), (0.15, 0.15, 0), (0, 0.15, 0)})
            self.assertTrue(numpy.allclose(corners[5][:, 2], row["lid_heightm"], atol=1e-12), f"{corners[5]} {row['lid_heightm']}")
        self.assertGreater(pressed, 0.1)

    def test_the_sides_of_a_moving_box_stay_together(self):
        law = 'law = "hertz"\nstiffness = "auto"\n'
        self.scene.write_text(CURVES.split("[[rods]]\nname = \"helix\"")[0].replace("duration = 1e-3", "duration = 0.02") + f"""
[[load]]
kind = "gravity"
[[wall]]
name = "box"
kind = "box"
lower = [-0.3, -0.3, -0.2]
upper = [1.3, 0.3, 1.2]
velocity = [0.5, 0.0, 0.0]
{law}
[[wall]]
name = "tube"
kind = "tube"
point = [0.5, 0.0, 0.0]
radius = 2.0
{law}
[output]
trajectory = 0.01
""")
        self.run_skein("out")
        walls = listed(self.directory / "out/walls.pvd")
        self.assertEqual(len(walls), 3)
        for time, name in walls:
            wall = read_vtp(self.directory / "out" / name)
            ends = wall["Polys", "offsets"]
            begins = numpy.r_[0, ends[:-1]]
            for side in range(6):
                at = list(wall["CellData", "wall"]).index(side)
                corners = wall["Points", "Points"][wall["Polys", "connectivity"][begins[at] : ends[at]]] - [0.5 * time, 0, 0]
                self.assertEqual(len(corners), 4)
                for axis, (low, high) in enumerate([(-0.3, 1.3), (-0.3, 0.3), (-0.2, 1.2)]):
                    expected = {low, high} if axis != side // 2 else {(low, high)[side % 2]}
                    self.assertEqual({round(x, 6) for x in corners[:, axis]}, expected)
            tube = wall["CellData", "wall"] == 6
            self.assertEqual(tube.sum(), 64)
            points = wall["Points", "Points"][wall["Polys", "connectivity"][begins[tube][0] :]]
            self.assertTrue(numpy.allclose(numpy.hypot(points[:, 0] - 0.5, points[:, 1]), 2.0))

    def test_the_same_bytes_on_any_ranks_and_across_restarts(self):
        for scene in SCENE, BED:
            for folder in self.directory.iterdir():
                if folder.is_dir():
                    shutil.rmtree(folder)
            self.scene.write_text(scene)
            self.run_skein("whole")
            whole = self.files("whole")
            self.assertGreater(len(whole), 8)
            self.run_skein("shared", ranks=3, threads=2)
            self.assertEqual(self.files("shared"), whole)
            # Frames after the checkpoint from which a run goes on are replaced, what was begun is removed.
            checkpoints = sorted((self.directory / "whole").glob("checkpoint_*.h5"))
            checkpoints[-1].unlink()
            resumed = int(re.search(r"(\d+)", checkpoints[-2].name)[1])
            damaged = 0
            for frame in (self.directory / "whole/vtp").glob("rods_*.vtp"):
                if int(frame.stem.split("_")[1]) > resumed:
                    content = bytearray(frame.read_bytes())
                    content[-200:-150] = bytes(50)  # numbers, which stand before the tail
                    frame.write_bytes(content)
                    damaged += 1
            self.assertGreater(damaged, 0)
            (self.directory / "whole/vtp/rods_000000000003.vtp.tmp").write_bytes(whole["vtp/rods_000000000000.vtp"][:5000])
            self.run_skein("whole")
            self.assertEqual(self.files("whole"), whole)
            # While a run stands still its list has the frames so far.
            steps = self.summary("whole")["steps"]
            self.run_skein("part", "--steps", str(steps // 2))
            part = listed(self.directory / "part/rods.pvd")
            self.assertEqual(part, listed(self.directory / "whole/rods.pvd")[: len(part)])
            self.assertEqual({name for _, name in part}, {name for name in self.files("part") if name.startswith("vtp/rods")})
            self.run_skein("part")
            self.assertEqual(self.files("part"), whole)

    def test_a_disk_that_is_full_at_a_frame_costs_no_work(self):
        """The state is kept, and the frame is written when the run goes on: but for the forces, which a checkpoint does not have."""
        self.scene.write_text(f"""
[time]
duration = 0.5
{STICKS}
[rods.placement]
kind = "lattice"
counts = [40, 40]
spacing = [0.02, 0.02]
[[load]]
kind = "gravity"
[contact]
{LAW}
[output]
trajectory = 0.125
precision = "double"
""")
        self.run_skein("whole")
        first = "vtp/rods_000000000000.vtp"
        limit = (self.directory / "whole" / first).stat().st_size - 50_000
        self.assertGreater(limit, max(path.stat().st_size for path in (self.directory / "whole").glob("checkpoint_*.h5")))
        run = subprocess.Popen(self.command("full")[3:], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        while run.poll() is None and not (self.directory / "full" / first).exists():
            time.sleep(0.005)
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (limit, limit))
        told = run.communicate(timeout=100)[0].split("of stepping")[-1]
        self.assertEqual(run.returncode, 5, told)
        self.assertIn("kept in a last checkpoint", told)
        self.assertRegex(told, "rods_[0-9]+.vtp.*ulimit -f")
        self.assertEqual(list((self.directory / "full/vtp").glob("*.tmp")), [])
        (checkpoint,) = (self.directory / "full").glob("checkpoint_*.h5")
        before, whole = self.files("full"), self.files("whole")
        self.assertTrue(all(whole[name] == content for name, content in before.items() if name.endswith(".vtp")))
        self.assertEqual(listed(self.directory / "full/rods.pvd"), listed(self.directory / "whole/rods.pvd")[: len(before) - 1])
        self.assertIn("Resuming from", self.run_skein("full").stdout)
        self.assertEqual(self.digest("full"), self.digest("whole"))
        missed = f"vtp/rods_{int(checkpoint.stem[11:]):012d}.vtp"
        after = self.files("full")
        self.assertEqual({name: content for name, content in after.items() if name != missed}, {name: content for name, content in whole.items() if name != missed})
        late, timely = read_vtp(self.directory / "full" / missed), read_vtp(self.directory / "whole" / missed)
        self.assertEqual(late.keys(), timely.keys())
        for key in late.keys() - {"time", "piece", ("PointData", "contact_force")}:
            self.assertTrue(numpy.array_equal(late[key], timely[key]), key)
        self.assertTrue(numpy.isnan(late["PointData", "contact_force"]).all())

    def test_lists_and_frames_that_are_not_a_run_s_are_put_aside(self):
        self.run_skein("whole")
        steps = self.summary("whole")["steps"]
        self.run_skein("out", "--steps", str(steps // 2))
        folder = self.directory / "out"
        frames = sorted((folder / "vtp").glob("rods_*.vtp"))
        whole = sorted((self.directory / "whole/vtp").glob("rods_*.vtp"))
        self.assertGreater(len(whole), len(frames))
        damaged, foreign = frames[0], folder / "vtp" / whole[-1].name
        damaged.write_bytes(damaged.read_bytes()[:-40])
        foreign.write_bytes(b"of another program")
        (folder / "rods.pvd").write_bytes(b"of another program")
        done = self.run_skein("out", ranks=2)
        self.assertIn(f"{damaged.name}: is incomplete or damaged", done.stderr)
        self.assertTrue(damaged.with_name(damaged.name + ".damaged").exists())
        for name in "rods.pvd.foreign", f"vtp/{foreign.name}.foreign":
            self.assertEqual((folder / name).read_bytes(), b"of another program")
        self.assertEqual(listed(folder / "rods.pvd"), listed(self.directory / "whole/rods.pvd")[1:])
        self.assertEqual(foreign.read_bytes(), whole[-1].read_bytes())

    def test_a_branch_has_frames_and_walls_from_its_first_step_on(self):
        self.scene.write_text(BED.split("[wall.servo]")[0] + "[output]" + BED.split("[output]")[1])
        self.run_skein("out")
        parents = sorted((self.directory / "out").glob("checkpoint_*.h5"))
        dt = 0.7 * self.summary("out")["dt_s"]
        for arguments in (["branch", str(self.directory / "out") + f"@{int(parents[0].stem[11:])}", str(self.directory / "new"), "--set", f"time.dt={dt}"],
                          ["run", str(self.directory / "new")]):
            done = subprocess.run([SKEIN, *arguments], capture_output=True, text=True, timeout=100)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        folder = self.directory / "new"
        rods, walls = listed(folder / "rods.pvd"), listed(folder / "walls.pvd")
        self.assertEqual([time for time, _ in rods], [time for time, _ in self.trajectory("new")])
        self.assertGreater(len(rods), 2)
        self.assertGreater(rods[0][0], 0)
        self.assertEqual([time for time, _ in walls], [rods[0][0]])
        self.assertEqual([time for time, _ in listed(self.directory / "out/walls.pvd")], [0])
        for _, name in rods:
            self.assertTrue(numpy.isfinite(read_vtp(folder / name)["PointData", "contact_force"]).all())

    def test_scenes_choose(self):
        for choice, vtp, xdmf in ("auto", True, True), ("vtp", True, True), ("xdmf", False, True), ("none", False, False):
            done = self.run_skein(choice, f"--set=output.paraview={choice}", "--set=time.duration=3.6")
            self.assertEqual((self.directory / choice / "rods.pvd").exists(), vtp, choice)
            self.assertEqual((self.directory / choice / "vtp").exists(), vtp, choice)
            self.assertEqual((self.directory / choice / "trajectory.xdmf").exists(), xdmf, choice)
            self.assertEqual("rods.pvd" in done.stdout, vtp)
        self.run_skein("auto", "--overwrite", "--set=output.paraview=none", "--set=time.duration=3.6")
        self.assertEqual(self.files("auto"), {})

    @unittest.skipUnless(vtkXMLPolyDataReader, "Python has no VTK")
    def test_tube_takes_them_as_they_are(self):
        self.scene.write_text(CURVES)
        self.run_skein("out")
        for _, name in listed(self.directory / "out/rods.pvd"):
            reader = vtkXMLPolyDataReader()
            reader.SetFileName(str(self.directory / "out" / name))
            reader.Update()
            own = read_vtp(self.directory / "out" / name)
            rods = reader.GetOutput()
            self.assertEqual((rods.GetNumberOfLines(), rods.GetNumberOfPoints()), (4, 3 * 11 + 201))
            self.assertTrue(numpy.array_equal(vtk_to_numpy(rods.GetPoints().GetData()), own["Points", "Points"]))
            for array in "radius", "velocity", "strain", "curvature", "energy", "normal":
                self.assertTrue(numpy.array_equal(vtk_to_numpy(rods.GetPointData().GetArray(array)), own["PointData", array]), array)
            self.assertEqual(rods.GetFieldData().GetArray("TimeValue").GetValue(0), own["time"])
            sides = 100
            tube = vtkTubeFilter()
            tube.SetInputData(rods)
            tube.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "radius")
            tube.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
            tube.SetNumberOfSides(sides)
            triangles = vtkTriangleFilter()
            triangles.SetInputConnection(tube.GetOutputPort())
            triangles.Update()
            surface = triangles.GetOutput()
            points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
            corner = points[vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)]
            area = 0.5 * numpy.linalg.norm(numpy.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum()
            expected = 2 * math.pi * (3 * 0.01 * 1.0 + 0.005 * 2.0)
            self.assertAlmostEqual(area / expected, 1, delta=2e-3)
            self.assertAlmostEqual(own["PointData", "curvature"][-100], 6, delta=0.01)


if __name__ == "__main__":
    unittest.main()
