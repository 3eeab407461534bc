#!/usr/bin/env python3
"""Picture of rods with sizes of their own before and after: plot.py OUT_DIR

Draws OUT_DIR/traced.png: the filaments as traced and at the end, coloured by the radius at their feet, and below how far each tip has gone
over time. Needs numpy, h5py and matplotlib.
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
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402

import skein  # noqa: E402
from skein.style import INK, bare, heading  # noqa: E402

THICKNESS = plt.get_cmap("viridis")
VIEW = (1.75, -0.35, 0.6)  # from where y, along which gravity acts, lies across the picture


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of a run's results")
    arguments = parser.parse_args()

    needs.need_files(arguments.out, "trajectory_*.h5")
    run = skein.open(arguments.out)
    filaments = run.rods[0]
    if filaments.radius.ndim == 1:
        sys.exit(f"{arguments.out}: its rods are all alike; give the output directory of a run of traced.toml")
    foot = 1e6 * filaments.radius[:, 0]
    scale = Normalize(foot.min(), foot.max())
    colours = THICKNESS(scale(foot))[:, :3]

    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure = plt.figure(figsize=(9, 5.4), facecolor="white")
    pictures = skein.Pictures(run, [run.time[0], run.time[-1]], (880, 620), colour=colours, camera=VIEW, up=(0, 0, 1), ground=0.0)
    for number, (left, words) in enumerate(zip((0.01, 0.51), ("as traced", "gravity to the left"))):
        axes = figure.add_axes([left, 0.37, 0.48, 0.58])
        pictures.show(axes, number)
        heading(axes, f"{words}, {pictures.times[number]:g} s")

    below = figure.add_axes([0.08, 0.1, 0.76, 0.24])
    tips = filaments.position[:, :, -1]
    time, gone = run.time, 1e3 * np.linalg.norm(tips - tips[0], axis=2)
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
    needs.in_words(main)
