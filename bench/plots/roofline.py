#!/usr/bin/env python3
"""Roofline of the rotation of frames and of the whole step: roofline.py TABLE [PICTURE]

Reads the table of `bench_passes --csv TABLE`: roofs (multiply-add peak at 8 lanes and at one, bandwidth of an update in place in each
level of the memory) and points are of one run on one core. Flop are those of the machine code, bytes those of the state that a row
streams. PICTURE is roofline.png beside the table where it is absent. Needs numpy and matplotlib.
"""

import csv
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

LEVELS = {"L1": "tab:green", "L2": "tab:blue", "L3": "tab:purple", "DRAM": "tab:red"}
# Row of the table, marker, name: at 8 lanes, the step of rods of 20 elements.
KERNELS = (
    ("rotation", "8", "", "o", "rotation of frames"),
    ("rotation", "1", "", "v", "rotation, one lane"),
    ("step/uniform/visit1", "8", "20", "s", "step, one per visit"),
    ("step/uniform/visit64", "8", "20", "D", "step, 64 per visit"),
)
LEAST, MOST = 0.1, 200  # flop/byte


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    table = Path(sys.argv[1])
    picture = Path(sys.argv[2]) if len(sys.argv) == 3 else table.parent / "roofline.png"
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    peak = {row["width"]: float(row["gflops"]) for row in rows if row["what"] == "peak"}
    update = {row["level"]: float(row["gbs"]) for row in rows if row["what"] == "stream-update"}

    fig, axes = plt.subplots(figsize=(8.4, 5.0), layout="constrained")
    intensity = np.geomspace(LEAST, MOST, 200)
    for level, colour in LEVELS.items():
        axes.loglog(intensity, np.minimum(update[level] * intensity, peak["8"]), color=colour, lw=1.3, zorder=2)
    axes.axhline(peak["1"], color="0.6", lw=1, ls="--", zorder=1)
    axes.text(MOST, 1.04 * peak["8"], f"peak, 8 lanes: {peak['8']:.0f} GF/s", ha="right", va="bottom", fontsize=8)
    axes.text(MOST, 1.04 * peak["1"], f"one lane: {peak['1']:.0f} GF/s", ha="right", va="bottom", fontsize=8, color="0.4")
    for what, width, n, marker, name in KERNELS:
        for row in rows:
            if (row["what"], row["width"], row["elements"]) != (what, width, n):
                continue
            axes.plot(float(row["flop"]) / float(row["bytes"]), float(row["gflops"]), marker, color=LEVELS[row["level"]], ms=7, mec="k", mew=0.6, zorder=4)
    for *_, marker, name in KERNELS:
        axes.plot([], [], marker, color="w", mec="k", ms=7, label=name)
    for level, colour in LEVELS.items():
        axes.plot([], [], color=colour, lw=2, label=f"{level}: {update[level]:.0f} GB/s")
    axes.legend(fontsize=8, loc="lower right", ncols=2)
    axes.set_xlim(LEAST, 1.15 * MOST)
    axes.set_ylim(1, 1.6 * peak["8"])
    axes.set_xlabel("flop per byte of state streamed", fontsize=9)
    axes.set_ylabel("GF/s of one core", fontsize=9)
    axes.set_title("Rotation of frames and whole step (uniform rods of 20 elements), state in each level of the memory", fontsize=10)
    axes.tick_params(labelsize=8)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(True, which="major", alpha=0.25)
    fig.savefig(picture, dpi=80)
    print(picture)


if __name__ == "__main__":
    main()
