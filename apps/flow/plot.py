#!/usr/bin/env python3
"""Figures of a fluid by itself: plot.py OUT_DIR [--axis z] [--at SHARE] [--since SECONDS] | [--slice NAME]

Draws OUT_DIR/flow.png, vorticity across a plane of cells in the first and the last frame of output.fields, or of a slice of the scene, with obstacles in the last alone; with these
OUT_DIR/forces.png, the forces on them, without OUT_DIR/energy.png, kinetic energy and what takes it. Prints mean forces, or how well the loss of energy and the
dissipation agree. Of a scene with a vortex (vortices.py) OUT_DIR/vortex.png and how far it is from theory, of one with walls or an acceleration that swings (plates.py)
OUT_DIR/profiles.png, of a cubic array of spheres (arrays.py) OUT_DIR/drag.png and how far its drag is from what is published,
of an ellipsoid in a cube of periods (ellipsoids.py) OUT_DIR/drift.png and how far the mean velocity is from its closed form. Needs numpy, h5py and matplotlib.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

import arrays  # noqa: E402
import ellipsoids  # noqa: E402
import plates  # noqa: E402
import vortices  # noqa: E402
from skein.own_file import OwnFile  # noqa: E402
from skein.style import INK, QUIET, bare  # noqa: E402


def plane(path, axis, share):
    """Vorticity across a plane of cells at a share of the box along an axis, [row][column]; its edges as imshow takes them; time."""
    with OwnFile(path) as file:
        if "vorticity" not in file:
            sys.exit(f"{path}: has no vorticity; name it in 'fields' of the output")
        vorticity = file["vorticity"]
        direction = "zyx".index(axis)
        at = min(int(share * vorticity.shape[direction]), vorticity.shape[direction] - 1)
        cut = [slice(None)] * 3
        cut[direction] = at
        values, spacing = vorticity[tuple(cut)][..., "xyz".index(axis)], file.attrs["spacing"]
        across = [name for name in "xyz" if name != axis]
        extent = [edge for name, cells in zip(across, values.shape[::-1]) for edge in file.attrs[f"lower_{name}"] + np.array([0, cells * spacing])]
        return values, extent, file.attrs["time"]


def axis_of_slice(path):
    with OwnFile(path) as file:
        if "across" not in file.attrs:
            sys.exit(f"{path}: is no slice")
        across = file.attrs["across"]
        return across.decode() if isinstance(across, bytes) else str(across)


def draw_planes(files, axis, share, to):
    planes = [plane(path, axis, share) for path in dict.fromkeys((files[0], files[-1]))]
    most = max(np.quantile(np.abs(values), 0.995) for values, _, _ in planes) or 1.0  # the thin layer at a body hides all else
    height, width = planes[0][0].shape
    wide = width > 1.2 * height  # then one above the other
    size = (7.6, 0.6 + 7.0 * len(planes) * height / width) if wide else (4.2 * len(planes) + 0.6, 4.2 * max(1.0, height / width))
    figure, axes = plt.subplots(*((len(planes), 1) if wide else (1, len(planes))), figsize=size, squeeze=False, constrained_layout=True)
    for one, (values, extent, time) in zip(axes.flat, planes):
        image = one.imshow(values, origin="lower", extent=extent, cmap="RdBu_r", vmin=-most, vmax=most, interpolation="bilinear")
        one.set_title(f"t = {time:.4g} s", color=INK)
        across = [name for name in "xyz" if name != axis]
        one.set_xlabel(f"{across[0]} [m]"), one.set_ylabel(f"{across[1]} [m]")
    figure.colorbar(image, ax=axes, shrink=0.85).set_label(f"vorticity along {axis} [1/s]")
    figure.savefig(to, dpi=150)


def draw_energy(series, to):
    time, energy, dissipation = (series[name] for name in ("time", "fluid_energy", "fluid_dissipation"))
    figure, axes = plt.subplots(figsize=(6, 4), constrained_layout=True)
    axes.plot(time, dissipation, color="#c8502d", label="dissipation by viscosity")
    loss = -(energy[2:] - energy[:-2]) / (time[2:] - time[:-2])
    axes.plot(time[1:-1], loss, "o", ms=3, color=INK, label="loss of kinetic energy")
    axes.set_xlabel("time [s]"), axes.set_ylabel("power [W]")
    axes.set_ylim(bottom=0)
    bare(axes)
    other = axes.twinx()
    other.plot(time, energy, color=QUIET, ls="--", label="kinetic energy")
    other.set_ylabel("kinetic energy [J]"), other.set_ylim(bottom=0)
    lines = axes.get_lines() + other.get_lines()
    axes.legend(lines, [line.get_label() for line in lines], frameon=False, loc="center left")
    figure.savefig(to, dpi=150)
    between = dissipation[1:-1]
    print(f"largest difference of loss and dissipation: {np.max(np.abs(loss - between) / np.max(between)):.2e} of the largest dissipation")


def draw_forces(series, since, to):
    """On each obstacle, over time; means are of what is later than `since`."""
    columns = [name for name in series if "_force_" in name and np.any(np.abs(series[name]) > 1e-9 * max(np.abs(series[other]).max() for other in series if "_force_" in other))]
    figure, axes = plt.subplots(figsize=(6, 4), constrained_layout=True)
    for name in columns:
        axes.plot(series["time"][1:], series[name][1:], lw=1, label=name.replace("_force_", ", along "))
    late = series["time"] > since * (1 + 1e-9)
    forces = np.concatenate([series[name][late] for name in columns])
    room = 0.2 * max(np.ptp(forces), 1e-3 * np.abs(forces).max())
    axes.set_ylim(forces.min() - room, forces.max() + room)  # a start at once is far off
    axes.set_xlabel("time [s]"), axes.set_ylabel("force [N]")
    axes.legend(frameon=False)
    bare(axes)
    figure.savefig(to, dpi=150)
    for name in columns:
        print(f"{name}: mean {series[name][late].mean():.6g} N, standard deviation {series[name][late].std():.3g} N after {since:g} s")


def read_series(path):
    with open(path) as file:
        names = [name.split("[")[0] for name in file.readline().strip().split(",")]
    rows = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return dict(zip(names, rows.T))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out_dir", type=Path)
    parser.add_argument("--axis", choices="xyz", default="z")
    parser.add_argument("--at", type=float, default=0.5, metavar="SHARE", help="place of the plane, as a share of the box along the axis")
    parser.add_argument("--since", type=float, metavar="SECONDS", help="forces are meaned from there on; default: half the run")
    parser.add_argument("--slice", metavar="NAME", help="draw this [[fluid_output]] of kind \"slice\"")
    given = parser.parse_args()
    pattern = f"fluid_{given.slice}_{'[0-9]' * 12}.h5" if given.slice else "fields_*.h5"
    files = sorted(given.out_dir.glob(pattern))
    if not files:
        sys.exit(f"{given.out_dir}: no {pattern}; {'give a [[fluid_output]] of this name' if given.slice else 'set output.fields'} in the scene")
    if given.slice:
        given.axis = axis_of_slice(files[-1])
    series = given.out_dir / "observables.csv"
    rows = read_series(series) if series.exists() else {}
    forced = any("_force_" in name for name in rows)
    draw_planes(files[-1:] if forced else files, given.axis, given.at, given.out_dir / "flow.png")
    print(given.out_dir / "flow.png")
    if rows:
        picture = given.out_dir / ("forces.png" if forced else "energy.png")
        if forced:
            draw_forces(rows, 0.5 * rows["time"][-1] if given.since is None else given.since, picture)
        else:
            draw_energy(rows, picture)
        print(picture)
    array = arrays.read_array(given.out_dir) if forced else None
    if array:
        arrays.draw_drag(rows, array, given.out_dir / "drag.png")
        print(given.out_dir / "drag.png")
    ellipsoid = ellipsoids.read_ellipsoid(given.out_dir) if forced and not given.slice else None
    if ellipsoid:
        ellipsoids.draw_drift(rows, files, ellipsoid, given.out_dir / "drift.png")
        print(given.out_dir / "drift.png")
    vortex = vortices.read_vortex(given.out_dir)
    if vortex:
        picture = given.out_dir / "vortex.png"
        (vortices.draw_ring if "R" in vortex else vortices.draw_swirl)(files, vortex, picture)
        print(picture)
    between = plates.read_plates(given.out_dir)
    if between and not given.slice:
        picture = given.out_dir / "profiles.png"
        plates.draw_plates(files, between, picture)
        print(picture)


if __name__ == "__main__":
    needs.in_words(main)
