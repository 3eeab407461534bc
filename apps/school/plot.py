#!/usr/bin/env python3
"""Figures of swimmers: plot.py OUT_DIR [--to DIR]

Prints what school.py measures and whether it is what the case asks for, writes it to school.json, and draws, in OUT_DIR or DIR,
  path.png     ways of the swimmers' centres of mass from above and from the side; speeds forward and aside, of the school and of each of many
  school.png   of five swimmers and more their speeds, and networks of those whose bending is most alike and of those that are nearest, as in
               the figure of swimmers of the Elastica++ paper (docs/references.md)
  power.png    power of their muscles, and what becomes of their work
  flow.png     vorticity in a plane of the waves and the swimmers there: of the last frame of output.fields, or of a slice of the scene
Speeds and powers are means over the period before. wakes.py draws the vortices in space. Needs numpy, h5py and matplotlib.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)
from matplotlib.collections import LineCollection  # noqa: E402

import school as schooling  # noqa: E402
import skein  # noqa: E402
from skein.own_file import OwnFile  # noqa: E402
from skein.picture.camera import framed  # noqa: E402
from skein.style import INK, QUIET, bare, heading  # noqa: E402

FORWARD, LATERAL = "#2b6cb0", "#d9822b"  # and of the networks: bending and nearness
COMMON = "#8e2f3f"                       # edges of both
FROM_WHERE = (-0.55, -1.6, 0.75)         # networks are seen from


def axis_words(axes, x, y):
    axes.set_xlabel(x, color=INK, labelpad=3)
    axes.set_ylabel(y, color=INK, labelpad=3)
    bare(axes, "left", "bottom")


def draw_spread(axes, when, values, colour, label=None, each=False):
    """Mean and range of swimmers [times, swimmers]."""
    if each:
        axes.plot(when, values, color=colour, lw=0.5, alpha=0.45)
    axes.fill_between(when, values.min(axis=1), values.max(axis=1), color=colour, alpha=0.22, lw=0)
    axes.plot(when, values.mean(axis=1), color=colour, lw=1.8, label=label)
    axes.set_xlim(0, when[-1])
    axes.margins(y=0.08)


def draw_ways(school, to):
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.9), width_ratios=(1, 1, 1.1), constrained_layout=True)
    for view, across, words in ((axes[0], 1, "centres of mass, from above"), (axes[1], 2, "from the side")):
        view.add_collection(LineCollection(school.places[:, :, [0, across]].swapaxes(0, 1), colors=FORWARD, linewidths=0.8))
        view.plot(*school.places[-1][:, [0, across]].T, "o", ms=3, color=INK)
        view.set_aspect("equal", "datalim")
        view.autoscale()
        axis_words(view, "x [L]", "xyz"[across] + " [L]")
        heading(view, words)
    when, forward, lateral = schooling.speeds(school)
    draw_spread(axes[2], when, forward, FORWARD, "forward")
    draw_spread(axes[2], when, lateral, LATERAL, "lateral")
    axes[2].set_ylim(bottom=0)
    axis_words(axes[2], "time [T]", "speed [L/T]")
    axes[2].legend(frameon=False, labelcolor=INK, loc="upper left")
    heading(axes[2], "mean over a period" + ("; shaded: all swimmers" if school.swimmers > 1 else ""))
    figure.savefig(to, dpi=150)
    plt.close(figure)


def draw_network(axes, school, networks, network, colour, words):
    """Edges between the swimmers' centres in the last frame, the strongest widest."""
    camera = framed(school.bodies.reshape(-1, 3), FROM_WHERE, (0, 0, 1), 1.3)
    bodies, depth = camera.project(school.bodies)
    centres, _ = camera.project(school.places[-1])
    far = (depth.mean(axis=1) - depth.min()) / np.ptp(depth)
    near_last = np.argsort(-far)
    axes.add_collection(LineCollection(bodies[near_last], linewidths=2.4, capstyle="round", colors=[(0.62, 0.65, 0.70, 1 - 0.55 * f) for f in far[near_last]]))
    width = np.linspace(2.0, 0.7, len(network))
    both = np.isin(network, networks.common)
    for chosen, ink in ((~both, colour), (both, COMMON)):
        axes.add_collection(LineCollection(centres[networks.pairs[network[chosen]]], linewidths=width[chosen], colors=ink, alpha=0.85, capstyle="round"))
    axes.scatter(*centres[near_last].T, s=16 - 8 * far[near_last], color=INK, zorder=3, lw=0)
    axes.set_aspect("equal", "datalim")
    axes.autoscale()
    axes.set_axis_off()
    heading(axes, words)


def draw_school(school, networks, to):
    figure, axes = plt.subplots(2, 2, figsize=(12, 9.2), height_ratios=(1, 1.6), layout="constrained")
    when, forward, lateral = schooling.speeds(school)
    for place, values, colour, words in ((axes[0, 0], forward, FORWARD, "forward speed"), (axes[0, 1], lateral, LATERAL, "lateral speed")):
        draw_spread(place, when, values, colour, each=True)
        place.set_ylim(0, 1.08 * values.max())
        axis_words(place, "time [T]", words + " [L/T]")
        heading(place, f"{words} of each swimmer; mean, and range shaded")
    if networks:
        both = f"{len(networks.common)} of {len(networks.near)} edges in both (red), {networks.by_chance:.1f} by chance"
        draw_network(axes[1, 0], school, networks, networks.similar, FORWARD, f"bending most alike after {schooling.SETTLED:g} T; {both}")
        draw_network(axes[1, 1], school, networks, networks.near, LATERAL, f"nearest to each other; Spearman's ρ of both over all pairs {networks.rho:+.2f}")
    else:
        for place in axes[1]:
            place.set_axis_off()
        heading(axes[1, 0], f"networks: from {schooling.SETTLED + 1:g} T on")
    figure.savefig(to, dpi=140)
    plt.close(figure)


def draw_power(school, to):
    figure, (each, whole) = plt.subplots(1, 2, figsize=(9.6, 3.8), constrained_layout=True)
    when, power = schooling.mean_rate(school.time, school.work)
    draw_spread(each, when, power, FORWARD)
    each.set_ylim(*room(power[when > min(2, 0.5 * when[-1])]))
    axis_words(each, "time [T]", "power of muscles [ρ L⁵/T³]")
    heading(each, "a swimmer's, mean over a period" + ("; shaded: all" if school.swimmers > 1 else ""))
    whole.plot(school.time, school.work.sum(axis=1), color=FORWARD, lw=1.2, label="work of all muscles")
    if school.spent:
        time, energy, lost = school.spent
        whole.plot(time, energy, color=LATERAL, lw=1.2, ls="--", label="taken by viscosity and stored in fluid and bodies")
        if lost is not None: whole.plot(time, energy + lost, color=LATERAL, lw=1.2, ls=":", label="and lost at surfaces")
    whole.set_xlim(0, school.time[-1]), whole.set_ylim(bottom=0)
    whole.legend(frameon=False, labelcolor=INK, loc="lower right")
    axis_words(whole, "time [T]", "energy [ρ L⁵/T²]")
    heading(whole, "since the start")
    figure.savefig(to, dpi=150)
    plt.close(figure)


def room(values):
    """Limits that show 0 and what is here: muscles that begin load the bodies, at many times the later power."""
    return min(0, 1.1 * values.min()), max(1e-300, 1.3 * values.max())


def last_plane(directory, until):
    """The newest file, of frames of rods that are there, with vorticity in a plane across z: of output.fields, else of a slice."""
    frames = [path for path in sorted(directory.glob("fields_*.h5")) if has_plane(path, until)]
    slices = [path for path in directory.glob("fluid_*_[0-9]*.h5") if has_plane(path, until, "slice")]
    return (frames or sorted(slices, key=lambda path: path.stem[-12:]) or [None])[-1]


def has_plane(path, until, kind=None):
    with OwnFile(path) as file:
        sliced = kind is None or (file.attrs["kind"] in (kind, kind.encode()) and file.attrs["across"] in ("z", b"z"))
        return "vorticity" in file and file.attrs["time"] < until + 1e-9 and sliced


def draw_flow(path, run, to):
    group = run.rods[0]
    with OwnFile(path) as file:
        time, spacing, lower = float(file.attrs["time"]), file.attrs["spacing"], [file.attrs[f"lower_{axis}"] for axis in "xyz"]
        nodes = group.position[run.frames.nearest(time)]
        level = min(int((nodes[0, 0, 2] - lower[2]) / spacing), len(file["vorticity"]) - 1) if len(file["vorticity"]) > 1 else 0
        values = file["vorticity"][level, ..., 2]
    z = lower[2] + (level + 0.5) * spacing
    reach = group.physics["section"]["radius_2"]
    period, length = run.constants["period"], group.physics["shape"]["length"]
    values, size = values * period, spacing / length
    most = np.quantile(np.abs(values), 0.998) or 1.0  # the thin layer at a body hides all else
    figure, axes = plt.subplots(figsize=(8.6, 1.1 + 7 * values.shape[0] / values.shape[1]), constrained_layout=True)
    corner = np.asarray(lower) / length
    extent = [corner[0], corner[0] + size * values.shape[1], corner[1], corner[1] + size * values.shape[0]]
    image = axes.imshow(values, origin="lower", extent=extent, cmap="RdBu_r", vmin=-most, vmax=most, interpolation="bilinear")
    for rod in nodes:
        if np.abs(rod[:, 2] - z).min() < reach:
            axes.plot(*rod[:, :2].T / length, color=INK, lw=1.5, solid_capstyle="round")
    axis_words(axes, "x [L]", "y [L]")
    heading(axes, f"vorticity across z = {z / length:.3g} L after {time / period:.3g} T")
    bar = figure.colorbar(image, ax=axes, shrink=0.85)
    bar.set_label("[1/T]", color=INK)
    bar.outline.set_visible(False)
    figure.savefig(to, dpi=150)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", metavar="OUT_DIR", type=Path)
    parser.add_argument("--to", metavar="DIR", type=Path, help="folder of the figures; default: OUT_DIR")
    given = parser.parse_args()
    to = given.to or given.directory
    school, run = schooling.read_school(given.directory), skein.open(given.directory)
    figures = schooling.measure(school)
    print(schooling.table(figures))
    to.mkdir(parents=True, exist_ok=True)
    (to / "school.json").write_text(json.dumps(figures, indent=2) + "\n")
    plt.rcParams.update({"font.size": 9})
    draw_ways(school, to / "path.png")
    draw_power(school, to / "power.png")
    if school.swimmers >= 5:
        draw_school(school, schooling.networks(school), to / "school.png")
    plane = last_plane(given.directory, run.time[-1])
    if plane:
        draw_flow(plane, run, to / "flow.png")


if __name__ == "__main__":
    needs.in_words(main)
