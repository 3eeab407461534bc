#!/usr/bin/env python3
"""Vortices around swimmers in space: wakes.py OUT_DIR [--to PNG] [--time T] [--level Q] [--smooth] [--most W] [--camera X,Y,Z] [--zoom TIMES] [--size W,H]

Draws OUT_DIR/wakes.png: surfaces on which Q has a level, coloured by vorticity along z, and the swimmers' bodies with the widths that their
scene gives them. From the blocks of a [[fluid_output]] named "wakes" whose threshold is at most the level, or else from the frames of
output.fields. Needs numpy, h5py, matplotlib, PIL and VTK (Debian: python3-vtk9, and xvfb where there is no display).
"""

import argparse
import sys
from pathlib import Path
from types import SimpleNamespace

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import numpy as np  # noqa: E402

import school as schooling  # noqa: E402
import skein  # noqa: E402
from skein.own_file import OwnFile  # noqa: E402
from skein.picture import shapes, sheet, vtk_stage  # noqa: E402
from skein.picture.camera import framed  # noqa: E402
from skein.picture.colours import Scale, bright  # noqa: E402
from skein.picture.view import Shown  # noqa: E402

BODY = np.array([0.46, 0.47, 0.50])
TIMES, SIDES = 4, 32   # rings an element, points a ring


def vortices(path):
    """Q and vorticity along z [z, y, x] over the smallest box of cells that has all blocks, with a layer of zeros around it: where there is no
    block, Q is below its threshold. Place of the first number and spacing, m."""
    with OwnFile(path) as file:
        if "q" not in file or "vorticity" not in file:
            sys.exit(f"{path}: no q or no vorticity; name them in 'fields' of the output")
        spacing, corner = float(file.attrs["spacing"]), np.array([file.attrs[f"lower_{axis}"] for axis in "xyz"])
        whole = "lower" not in file
        blocks = np.zeros((1, 3), int) if whole else np.rint((file["lower"][:] - corner) / spacing).astype(int)
        if not len(blocks):
            sys.exit(f"{path}: no block, so no vortices above the threshold yet")
        cells = np.array(file["q"].shape[-3:])[::-1]
        low, high = blocks.min(axis=0), blocks.max(axis=0) + cells
        q, vorticity = (np.zeros((high - low + 2)[::-1], np.float32) for _ in range(2))
        for number, block in enumerate(blocks - low + 1):
            room = tuple(slice(first, first + count) for first, count in zip(block[::-1], cells[::-1]))
            q[room] = np.nan_to_num(file["q"][()] if whole else file["q"][number])
            vorticity[room] = np.nan_to_num(file["vorticity"][..., 2] if whole else file["vorticity"][number, ..., 2])
    return q, vorticity, corner + (low - 0.5) * spacing, spacing


def smoothed(values):
    """Means by 1, 2, 1 along each direction: what changes from cell to cell is noise, and hides the rest."""
    for axis in range(3):
        values = np.moveaxis(values, axis, 0)
        inner = 0.25 * (values[:-2] + values[2:]) + 0.5 * values[1:-1]
        values = np.moveaxis(np.concatenate([values[:1], inner, values[-1:]]), 0, axis)
    return np.ascontiguousarray(values)


def surface(q, vorticity, first, spacing, level):
    """Where Q has the level: points, normals towards smaller Q, triangles, vorticity at the points."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
    image = vtkImageData()
    image.SetDimensions(*q.shape[::-1])
    image.SetSpacing(spacing, spacing, spacing)
    image.SetOrigin(*first)
    for name, values in (("q", q), ("vorticity", vorticity)):
        array = numpy_to_vtk(values.ravel())
        array.SetName(name)
        image.GetPointData().AddArray(array)
    image.GetPointData().SetActiveScalars("q")
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, level)
    contour.ComputeNormalsOn()
    contour.InterpolateAttributesOn()
    contour.Update()
    found = contour.GetOutput()
    if not found.GetNumberOfPoints():
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros(0)
    at = found.GetPointData()
    return (vtk_to_numpy(found.GetPoints().GetData()).astype(float), vtk_to_numpy(at.GetNormals()).astype(float),
            vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3), vtk_to_numpy(at.GetArray("vorticity")))


def bodies(run, group, frame):
    """The swimmers' surfaces: their sections all along, between nodes too."""
    count = group.elements * TIMES + 1
    a, b = (np.nan_to_num(values)[:, None, None] for values in schooling.semi_axes(group, run.constants, np.linspace(0, group.physics["shape"]["length"], count)))
    axis = shapes.refined(group.position[frame].astype(float), TIMES)
    first = shapes.refined(group.normal[frame].astype(float), TIMES)
    tangent = shapes.unit(np.gradient(axis, axis=1))
    first = shapes.unit(first - np.sum(first * tangent, axis=-1, keepdims=True) * tangent)[:, :, None]
    second = np.cross(tangent, first[:, :, 0])[:, :, None]
    angle = 2 * np.pi * np.arange(SIDES)[:, None] / SIDES
    points = axis[:, :, None] + a * np.cos(angle) * first + b * np.sin(angle) * second
    normals = shapes.unit(b * np.cos(angle) * first + a * np.sin(angle) * second)
    faces = shapes.ring_faces(*points.shape[:3])
    points = points.reshape(-1, 3)
    return shapes.Mesh(points, normals.reshape(-1, 3), faces, np.tile(BODY, (len(points), 1)))


def time_of(path):
    with OwnFile(path) as file:
        return float(file.attrs["time"])


def vector(words):
    return np.array([float(word) for word in words.split(",")])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", metavar="OUT_DIR", type=Path)
    parser.add_argument("--to", metavar="PNG", type=Path, help="default: OUT_DIR/wakes.png")
    parser.add_argument("--time", type=float, metavar="T", help="the frame nearest to it, periods; default: the last")
    parser.add_argument("--level", type=float, default=4.0, metavar="Q", help="of the surfaces, 1/T^2")
    parser.add_argument("--smooth", action="store_true", help="Q is meaned over neighbouring cells: of coarse grids")
    parser.add_argument("--most", type=float, default=8.0, metavar="W", help="vorticity of the full colours, 1/T")
    parser.add_argument("--camera", type=vector, default="-0.7,-1.6,0.9", metavar="X,Y,Z", help="direction from which to look")
    parser.add_argument("--zoom", type=float, default=1.0)
    parser.add_argument("--size", type=vector, default="1800,1200", metavar="W,H", help="pixels")
    given = parser.parse_args()
    reason = vtk_stage.why_not()
    if reason:
        sys.exit(f"wakes.py: {reason}")
    from PIL import Image
    run = skein.open(given.directory)
    files = {time_of(path): path for path in sorted(given.directory.glob("fluid_wakes_*.h5")) or sorted(given.directory.glob("fields_*.h5"))}
    files = {time: path for time, path in files.items() if len(run.time) and time < run.time[-1] + 1e-9}
    if not files or not run.rods or "period" not in run.constants:
        sys.exit(f"{given.directory}: no frames of swimmers, or neither blocks of an output 'wakes' nor frames of output.fields by then")
    period, group = run.constants["period"], run.rods[0]
    time = min(files, key=lambda t: abs(t - (max(files) if given.time is None else given.time * period)))
    q, vorticity, first, spacing = vortices(files[time])
    points, normals, triangles, vorticity = surface(smoothed(q) if given.smooth else q, vorticity, first, spacing, given.level / period**2)
    scale = Scale("vorticity along z [1/T]", -given.most, given.most, bright("RdBu_r"))
    swimmers = bodies(run, group, run.frames.nearest(time))
    wakes = shapes.Mesh(points, normals, triangles[:, [0, 1, 2, 2]], scale.paint(vorticity * period))
    mesh = shapes.Mesh.joined([swimmers, wakes])
    width, height = (int(pixels) for pixels in given.size)
    up = np.array([0.0, 0.0, 1.0])
    view = SimpleNamespace(camera=framed(mesh.points, given.camera, up, width / height), up=up, centre=mesh.points.mean(axis=0))
    view.camera.angle /= given.zoom
    image = vtk_stage.Stage(width, height).draw(view, Shown(mesh, mesh, None, time, 0))
    page = sheet.Sheet(width, height, f"{run.title}: Q = {given.level:g}/T²", [scale])
    to = given.to or given.directory / "wakes.png"
    to.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(page.filled(image, f"{time / period:.3g} T")).save(to, optimize=True)
    print(f"{to}: {len(triangles)} triangles after {time / period:.3g} T")


if __name__ == "__main__":
    needs.in_words(main)
