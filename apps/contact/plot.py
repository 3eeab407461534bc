#!/usr/bin/python3
"""Picture of a rod that winds round itself: plot.py OUT_DIR [--time SECONDS] [--without OUT_DIR]

Draws OUT_DIR/rod.png: the rod at a time (the last frame where none is given), and below it twist, writhe and link over time; dashed, the
link of a run that passes through itself (contact.self=false). Needs numpy, h5py and matplotlib.
"""

import argparse
import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "figures"))
import results  # noqa: E402  (from apps/figures)

results.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

import frames  # noqa: E402  (from apps/figures)
import tubes  # noqa: E402

LINES = (("twist", "#3b6fb6"), ("writhe", "#c4574b"), ("link", "#22252b"))
ROD = np.array([0.80, 0.62, 0.36])
SMOOTH = 4  # points drawn per element


def series(out):
    results.need_files(out, "observables.csv")
    with open(out / "observables.csv", newline="") as file:
        rows = list(csv.reader(file))
    columns = [name.split("[")[0] for name in rows[0]]
    results.need_names(out, "columns of observables.csv called", columns, [name for name, _ in LINES],
                       "the scene needs 'knots' among its observables in [output]")
    return {name.split("[")[0]: np.array(column, dtype=float) for name, column in zip(rows[0], zip(*rows[1:]))}


def smoothed(nodes):
    """Catmull-Rom through the nodes."""
    p = np.vstack([2 * nodes[0] - nodes[1], nodes, 2 * nodes[-1] - nodes[-2]])
    s = np.linspace(0, 1, SMOOTH, endpoint=False)[:, None, None]
    a, b, c, d = p[:-3], p[1:-2], p[2:-1], p[3:]
    curve = b + 0.5 * s * (c - a) + s**2 * (a - 2.5 * b + 2 * c - 0.5 * d) + s**3 * (-0.5 * a + 1.5 * b - 1.5 * c + 0.5 * d)
    return np.vstack([curve.transpose(1, 0, 2).reshape(-1, 3), nodes[-1]])


def draw_rod(axes, nodes, radius):
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    axes.set_facecolor("white")
    upright = nodes[:, [0, 2, 1]] * [1, -1, 1]  # what leans out along y stands up
    upright[:, 2] += radius - upright[:, 2].min()
    camera = tubes.Camera(0.5 * (upright.min(axis=0) + upright.max(axis=0)), np.linalg.norm(high - low), (-0.35, -1.9, 0.55))
    curve = smoothed(upright)
    tubes.draw_tubes(axes, camera, curve[None], np.full(len(curve), radius), ROD[None])
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of a run's results")
    parser.add_argument("--time", type=float, default=np.inf, help="of the frame, s")
    parser.add_argument("--without", type=Path, help="the same without contact")
    arguments = parser.parse_args()

    results.need_files(arguments.out, "trajectory_*.h5")
    columns = series(arguments.out)
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 6.4), height_ratios=(1.6, 1), layout="constrained")
    nodes, radius, time = frames.rods_at(arguments.out, min(arguments.time, 1e9))
    draw_rod(above, nodes[0], radius[0])
    for name, colour in LINES:
        below.plot(columns["time"], columns[name], color=colour, label=name)
    if arguments.without:
        columns = series(arguments.without)
        below.plot(columns["time"], columns["link"], color=LINES[-1][1], linestyle="--", linewidth=1, label="link, no contact")
    below.axvline(time, color="#cfd4db", linewidth=1, zorder=0)
    below.set(xlabel="time, s", ylabel="turns")
    below.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    below.spines[["top", "right"]].set_visible(False)
    figure.savefig(arguments.out / "rod.png", dpi=150)


if __name__ == "__main__":
    main()
