#!/usr/bin/env python3
"""Picture of rods with sizes of their own before and after: plot.py OUT_DIR

Draws OUT_DIR/traced.png: the filaments as traced and at the end, coloured by the radius at their feet, and below how far each tip has gone
over time. Needs numpy, h5py and matplotlib.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "figures"))
import results  # noqa: E402  (from apps/figures)

results.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402

import frames  # noqa: E402  (from apps/figures)
import tubes  # noqa: E402
from style import INK, bare, heading  # noqa: E402

THICKNESS = plt.get_cmap("viridis")
SIDES = 12
VIEW = (1.75, -0.35, 0.6)  # from where y, along which gravity acts, lies across the picture


def draw_tuft(axes, camera, nodes, radius, colours, ground, seen):
    """`seen`: points [:, 2] of the picture that set its limits."""
    tubes.draw_plate(axes, camera, -ground * np.ones(3), ground * np.ones(3))
    tubes.draw_tubes(axes, camera, nodes, radius, colours, sky_from=0.3 * nodes[..., 2].max(), sides=SIDES)
    axes.set_aspect("equal")
    axes.set_xlim(seen[:, 0].min(), seen[:, 0].max())
    axes.set_ylim(seen[:, 1].min(), seen[:, 1].max())
    axes.set_axis_off()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of a run's results")
    arguments = parser.parse_args()

    results.need_files(arguments.out, "trajectory_*.h5")
    shown = [(t, *frames.read_rods(path, k)) for t, path, k in frames.frames(arguments.out)]
    first, last = shown[0], shown[-1]
    radius = first[2]
    if radius.ndim == 1:
        sys.exit(f"{arguments.out}: its rods are all alike; give the output directory of a run of traced.toml")
    scale = Normalize(1e6 * radius[:, 0].min(), 1e6 * radius[:, 0].max())
    colours = THICKNESS(scale(1e6 * radius[:, 0]))[:, :3]

    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure = plt.figure(figsize=(9, 5.4), facecolor="white")
    everything = np.concatenate([first[1], last[1]]).reshape(-1, 3)
    ground = 1.3 * np.abs(first[1][:, 0, :2]).max()
    camera = tubes.Camera(np.array([0, 0, 0.4 * everything[:, 2].max()]), 5 * ground, VIEW)
    corners = ground * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    seen = camera.project(np.concatenate([everything, corners]))
    views = [figure.add_axes([0.01, 0.37, 0.48, 0.58]), figure.add_axes([0.51, 0.37, 0.48, 0.58])]
    for axes, (t, nodes, _), words in zip(views, (first, last), ("as traced", "gravity to the left")):
        draw_tuft(axes, camera, nodes, radius, colours, ground, seen)
        heading(axes, f"{words}, {t:g} s")

    below = figure.add_axes([0.08, 0.1, 0.76, 0.24])
    time = [t for t, _, _ in shown]
    gone = np.array([1e3 * np.linalg.norm(nodes[:, -1] - first[1][:, -1], axis=1) for _, nodes, _ in shown])
    for rod, colour in zip(gone.T, colours):
        below.plot(time, rod, color=colour, linewidth=0.9)
    below.set_xlabel("time [s]", color=INK)
    below.set_ylabel("tips have gone [mm]", color=INK)
    bare(below, "left", "bottom")
    bar = figure.colorbar(ScalarMappable(scale, THICKNESS), cax=figure.add_axes([0.88, 0.1, 0.012, 0.24]))
    bar.set_label("radius at the foot [µm]", color=INK)
    bar.outline.set_visible(False)
    figure.savefig(arguments.out / "traced.png", dpi=84, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    main()
