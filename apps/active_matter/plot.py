#!/usr/bin/env python3
"""Figures of a snake pit: plot.py OUT_DIR [--times T0 T1 T2]

Prints how its rods are ordered, writes it to OUT_DIR/order.json, and draws OUT_DIR/pit.png: the bed from above at three times,
coloured by direction, S(t), directions over the last period, order by distance from the walls, and clusters. Needs numpy, h5py and
matplotlib.
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

import order as ordering  # noqa: E402
import skein  # noqa: E402
from skein.picture.colours import circle  # noqa: E402
from skein.style import INK, QUIET, bare, heading  # noqa: E402

CIRCLE = circle()
ISOTROPIC = 2 / np.pi


def draw_bed(axes, pit, run, period, time, colours=None, words=""):
    """Rods from above, the highest last; colours by direction, 0 and 180 degrees apart."""
    frame = run.frames.nearest(time * period)
    length = run.physics["rods"][0]["shape"]["length"]
    nodes = np.asarray(run.rods[0].position[frame]) / length
    order = np.argsort(nodes[..., 2].mean(axis=1))
    if colours is None:
        way = nodes[:, -1] - nodes[:, 0]
        colours = CIRCLE(np.arctan2(way[:, 1], way[:, 0]) / (2 * np.pi) % 1)
    lines = LineCollection(nodes[order][:, :, :2], colors=colours[order], capstyle="round", rasterized=True)
    axes.add_collection(lines)
    axes.set_xlim(pit.lower[0], pit.upper[0])
    axes.set_ylim(pit.lower[1], pit.upper[1])
    axes.set_aspect("equal")
    axes.figure.canvas.draw()
    inch = axes.get_window_extent().width / axes.figure.dpi
    lines.set_linewidth(0.9 * 72 * inch * 2 * pit.radius / (pit.upper[0] - pit.lower[0]))
    axes.set_xticks([])
    axes.set_yticks([])
    for side in axes.spines.values():
        side.set_color(QUIET)
    heading(axes, words or f"t = {run.time[frame] / period:g} T")


def draw_order(axes, pit):
    axes.plot(pit.time, pit.order, color="#9db8d9", lw=0.6)
    axes.plot(pit.time, pit.mean_order, color="#2b6cb0", lw=1.8)
    axes.axhline(ISOTROPIC, color=QUIET, lw=0.8, ls="--")
    axes.set_ylim(min(0.5, pit.order.min()), 1)
    axes.set_xlim(0, pit.time[-1])
    axes.set_xlabel("t/T", color=INK)
    bare(axes, "left", "bottom")
    heading(axes, "S(t) and its mean over a period; dashed: even directions")


def draw_directions(axes, pit):
    angle = pit.angles(pit.last_period()).ravel()
    counts, edges = np.histogram(np.degrees(angle) % 360, bins=72, range=(0, 360))
    middle = np.radians(0.5 * (edges[1:] + edges[:-1]))
    axes.bar(middle, counts / counts.sum() * 72 / 360, width=np.radians(5), color=CIRCLE(middle / (2 * np.pi)), lw=0)
    axes.set_yticks([])
    axes.set_xticks(np.radians([0, 90, 180, 270]), labels=["0°", "90°", "180°", "270°"])
    axes.spines["polar"].set_visible(False)
    heading(axes, "f(θ) over the last period", pad=14)


def draw_walls(axes, figures):
    for low, high, value in figures["order_by_distance_from_wall_L"]:
        axes.bar(0.5 * (low + high), value, width=0.92 * (high - low), color="#2b6cb0", lw=0)
    axes.axhline(ISOTROPIC, color=QUIET, lw=0.8, ls="--")
    axes.set_ylim(0, 1)
    axes.set_xlabel("distance of centres from the nearest wall [L]", color=INK)
    bare(axes, "left", "bottom")
    heading(axes, "mean |cos 2θ| over the last period")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of a run's results")
    parser.add_argument("--times", type=float, nargs=3, help="of the pictures, periods; default: before the muscles begin, half-way, the end")
    arguments = parser.parse_args()
    pit = ordering.read_pit(arguments.out)
    figures = ordering.measure(pit)
    print(ordering.table(figures))
    (arguments.out / "order.json").write_text(json.dumps(figures, indent=2) + "\n")

    run = skein.open(arguments.out)
    muscles = next(load for load in run.physics["load"] if load["kind"].startswith("muscle"))
    period, end = muscles["period"], pit.time[-1]
    times = arguments.times or [min(muscles.get("onset", 0) / period, end), 0.5 * end, end]
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure = plt.figure(figsize=(14, 9), facecolor="white", dpi=105)
    grid = figure.add_gridspec(2, 12, height_ratios=[1.25, 1], hspace=0.22, wspace=0.6, left=0.04, right=0.98, top=0.93, bottom=0.07)
    for k, time in enumerate(times):
        draw_bed(figure.add_subplot(grid[0, 4 * k:4 * k + 4]), pit, run, period, time)
    draw_order(figure.add_subplot(grid[1, 0:4]), pit)
    draw_directions(figure.add_subplot(grid[1, 4:6], projection="polar"), pit)
    draw_walls(figure.add_subplot(grid[1, 6:9]), figures)
    centre = 0.5 * (pit.start[-1] + pit.end[-1])
    number = ordering.clusters(centre, pit.angles(-1))
    palette = np.array(plt.get_cmap("tab10").colors)
    colours = np.where(number[:, None] < 6, palette[np.minimum(number, 5)], [0.8, 0.8, 0.8])
    draw_bed(figure.add_subplot(grid[1, 9:12]), pit, run, period, pit.frames[-1], colours, "largest clusters: " + ", ".join(map(str, figures["clusters"][:4])))
    figure.savefig(arguments.out / "pit.png", pil_kwargs={"optimize": True})
    plt.close(figure)


if __name__ == "__main__":
    needs.in_words(main)
