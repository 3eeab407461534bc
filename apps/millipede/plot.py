#!/usr/bin/env python3
"""Figures of magnetic millipedes: plot.py OUT_DIR

Prints how they walk, writes it to OUT_DIR/walk.json, and draws OUT_DIR/millipede.png: of one robot its gait over a cycle and its
path, of a swarm its formation before and after and how it drifts apart. Needs numpy, h5py and matplotlib.
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

import skein  # noqa: E402
import walk as walking  # noqa: E402
from skein.style import INK, QUIET, bare, heading  # noqa: E402

COLOURS = {"legs": "#2b6cb0", "along": "#c2703d", "across": "#8a8f98"}
STRIPS = 8  # of a cycle


def draw_gait(axes, run, walk):
    """The robot from the side at equal times over the last cycle, one strip below the other; the line is the floor."""
    last = max(walk.cycles, 1)
    for strip in range(STRIPS + 1):
        frame = walk.frame_of(last - 1 + strip / STRIPS)
        shift = -2.2 * strip
        axes.axhline(shift, color=QUIET, lw=0.6, zorder=0)
        for group in run.rods:
            for rod in np.asarray(group.position[frame]):
                axes.plot(rod[:, 0], rod[:, 2] + shift, color=COLOURS.get(group.name, INK), lw=2.2, solid_capstyle="round", alpha=0.9)
    axes.set_aspect("equal")
    axes.set_yticks([-2.2 * k for k in range(STRIPS + 1)], labels=[f"{k / STRIPS:g}" for k in range(STRIPS + 1)])
    axes.set_xlabel("x [m]", color=INK)
    axes.set_ylabel("share of the cycle", color=INK)
    bare(axes, "bottom")
    heading(axes, f"gait in cycle {last}, from the side")


def draw_path(axes, walk):
    axes.plot(walk.cycle(walk.time), (walk.centre[:, :, 0] - walk.centre[0, :, 0]).mean(axis=1) / walk.length, color=COLOURS["legs"], lw=1.8, label="forward")
    axes.plot(walk.cycle(walk.time), (walk.centre[:, :, 1] - walk.centre[0, :, 1]).mean(axis=1) / walk.length, color=COLOURS["along"], lw=1.8, label="sideways")
    axes.set_xlabel("cycles of the field", color=INK)
    axes.set_ylabel("way [lengths of the body]", color=INK)
    axes.legend(frameon=False)
    bare(axes, "left", "bottom")
    heading(axes, "way of the centre of mass")


def draw_height(axes, walk):
    axes.fill_between(walk.cycle(walk.time), walk.centre[:, :, 2].min(axis=1), walk.centre[:, :, 2].max(axis=1), color=COLOURS["across"], alpha=0.4, lw=0)
    axes.plot(walk.cycle(walk.time), walk.centre[:, :, 2].mean(axis=1), color=INK, lw=1.2)
    axes.set_xlabel("cycles of the field", color=INK)
    axes.set_ylabel("height [m]", color=INK)
    bare(axes, "left", "bottom")
    heading(axes, "height of the centre of mass")


def draw_formation(axes, walk):
    """Robots at the start, and at the end moved back by the mean way; circles grow with how far one is from its place."""
    last = walk.frame_of(walk.cycles)
    start, end = walk.centre[0, :, :2], walk.centre[last, :, :2]
    way = (end - start).mean(axis=0)
    off = np.linalg.norm(end - way - start, axis=1) / walk.length
    for place, colour, words in ((start, QUIET, "start"), (end, COLOURS["legs"], f"after {walk.cycles} cycles")):
        for x, y in place:
            axes.add_patch(plt.Rectangle((x - walk.length / 2, y - walk.width / 2), walk.length, walk.width, color=colour, lw=0, alpha=0.75))
        axes.plot([], [], color=colour, lw=6, alpha=0.75, label=words)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.legend(frameon=False, loc="lower center")
    axes.set_xlabel("x [m]", color=INK)
    axes.set_ylabel("y [m]", color=INK)
    bare(axes, "left", "bottom")
    heading(axes, f"formation: {way[0] / walk.length:.2f} lengths on; farthest from its place {off.max():.3f} lengths")


def draw_drift(axes, walk):
    axes.plot(walk.cycle(walk.time), walking.formation(walk), color=COLOURS["legs"], lw=1.8)
    axes.axhline(0.05, color=QUIET, lw=0.8, ls="--")
    axes.set_xlabel("cycles of the field", color=INK)
    axes.set_ylabel("rms from place [lengths]", color=INK)
    axes.set_ylim(0, None)
    bare(axes, "left", "bottom")
    heading(axes, "drift of the formation")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of a run's results")
    arguments = parser.parse_args()
    walk = walking.read_walk(arguments.out)
    figures = walking.measure(walk)
    print(walking.table(figures))
    (arguments.out / "walk.json").write_text(json.dumps(figures, indent=2) + "\n")

    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    if walk.centre.shape[1] == 1:
        figure = plt.figure(figsize=(13, 7), facecolor="white")
        grid = figure.add_gridspec(2, 2, width_ratios=[1.15, 1], hspace=0.45, wspace=0.2)
        draw_gait(figure.add_subplot(grid[:, 0]), skein.open(arguments.out), walk)
        draw_path(figure.add_subplot(grid[0, 1]), walk)
        draw_height(figure.add_subplot(grid[1, 1]), walk)
    else:
        figure = plt.figure(figsize=(14, 6), facecolor="white")
        grid = figure.add_gridspec(2, 2, width_ratios=[1.8, 1], hspace=0.5, wspace=0.2)
        draw_formation(figure.add_subplot(grid[:, 0]), walk)
        draw_path(figure.add_subplot(grid[0, 1]), walk)
        draw_drift(figure.add_subplot(grid[1, 1]), walk)
    figure.savefig(arguments.out / "millipede.png", dpi=105, bbox_inches="tight", pil_kwargs={"optimize": True})
    plt.close(figure)


if __name__ == "__main__":
    needs.in_words(main)
