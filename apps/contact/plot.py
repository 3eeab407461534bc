#!/usr/bin/python3
"""Picture of a rod that winds round itself: plot.py OUT_DIR [--time SECONDS] [--without OUT_DIR]

Draws OUT_DIR/rod.png: the rod at a time (the last frame where none is given), and below it twist, writhe and link over time; dashed, the
link of a run that passes through itself (contact.self=false). Needs numpy, h5py and matplotlib.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

import skein  # noqa: E402

LINES = (("twist", "#3b6fb6"), ("writhe", "#c4574b"), ("link", "#22252b"))


def series(run):
    needs.need_names(run.directory, "columns of observables.csv called", run.series, [name for name, _ in LINES],
                     "the scene needs 'knots' among its observables in [output]")
    return run.series


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of a run's results")
    parser.add_argument("--time", type=float, default=1e9, help="of the frame, s")
    parser.add_argument("--without", type=Path, help="the same without contact")
    arguments = parser.parse_args()

    needs.need_files(arguments.out, "trajectory_*.h5")
    run = skein.open(arguments.out)
    columns = series(run)
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 6.4), height_ratios=(1.6, 1), layout="constrained")
    pictures = skein.Pictures(run, [arguments.time], (1280, 760), colour="group", ground=False)
    pictures.show(above)
    for name, colour in LINES:
        below.plot(columns["time"], columns[name], color=colour, label=name)
    if arguments.without:
        columns = series(skein.open(arguments.without))
        below.plot(columns["time"], columns["link"], color=LINES[-1][1], linestyle="--", linewidth=1, label="link, no contact")
    below.axvline(pictures.times[0], color="#cfd4db", linewidth=1, zorder=0)
    below.set(xlabel="time, s", ylabel="turns")
    below.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    below.spines[["top", "right"]].set_visible(False)
    figure.savefig(arguments.out / "rod.png", dpi=150)


if __name__ == "__main__":
    needs.in_words(main)
