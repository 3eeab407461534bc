#!/usr/bin/env python3
"""Figure of the farm's error against work: farm_precision.py FOLDER [OUT]

Reads farm_precision.csv, farm_phases.csv and farm_kinds.csv in FOLDER (written by bench/scenes/farm_precision/measure.py) and draws
OUT/farm_precision.png, OUT being FOLDER where it is absent. Needs numpy and matplotlib.
"""

import csv
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)
from matplotlib.ticker import LogLocator, NullFormatter  # noqa: E402

CLAMPS = {"clamped": dict(color="tab:blue", lw=2.6, label="clamped (half cell)"),
          "clamped_frozen": dict(color="tab:red", lw=2.6, label="clamped_frozen, as published")}
BAR = 5  # degrees


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def draw_precision(axes, rows):
    """Over element-steps, which do not depend on what else the machine did; the table has the core-seconds."""
    for clamp, style in CLAMPS.items():
        points = [row for row in rows if row["clamp"] == clamp and float(row["error"]) > 0]  # the reference has none
        work, error = (np.array([float(row[key]) for row in points]) for key in ("farm_element_steps", "error"))
        axes.loglog(work, error, "o-", ms=4, **style)
        for row, x, y in zip(points, work, error):
            axes.annotate(row["n"], (x, y), (4, 2), textcoords="offset points", fontsize=7, color=style["color"])
    axes.set_xlim(right=2e12)
    axes.set_ylim(1e-5, 0.5)
    axes.set_title("Tips of the farm, second turn, over n", fontsize=10)
    axes.set_xlabel("element-steps of 111 797 cilia, two turns", fontsize=9)
    axes.set_ylabel("rms distance / length", fontsize=9)
    axes.legend(fontsize=8, loc="lower left")


def draw_start(axes, rows):
    start, cilia = (np.array([float(row[key]) for row in rows]) for key in ("repeats_from_s", "cilia"))
    at = np.arange(0, start.max() + 8, 2)
    axes.step(at, [100 * cilia[start <= t].sum() / cilia.sum() for t in at], where="post", color="tab:blue", lw=2)
    axes.set_title("Tips that repeat a turn later within 2 % L", fontsize=10)
    axes.set_xlabel("from time (s); a turn takes 72 s", fontsize=9)
    axes.set_ylabel("% of cilia", fontsize=9)


def draw_bonds(axes, rows):
    for pattern, color, name in (("wave_xy", "tab:blue", "waves along x and y"), ("wave_x", "tab:green", "wave along x")):
        points = [row for row in rows if row["case"].startswith(f"{pattern}_bond_")]
        bond = np.array([float(row["case"].rpartition("_")[2]) for row in points])
        rms = np.array([float(row["deviation_rms_deg"]) for row in points])
        axes.loglog(bond, rms, "o-", ms=4, color=color, label=name)
        if pattern == "wave_xy":
            axes.loglog(bond, rms[0] * (bond / bond[0]) ** 2, "--", lw=0.9, color="tab:gray", label="bond squared")
    axes.axhline(BAR, color="tab:red", lw=0.8, ls=":")
    axes.axvline(3.286, color="tab:gray", lw=0.8, ls=":")
    axes.set_ylim(1e-3, 300)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_title("Phase about the drive", fontsize=10)
    axes.set_xlabel("bond (the farm: 3.286)", fontsize=9)
    axes.set_ylabel("rms deviation (degrees)", fontsize=9)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.legend(fontsize=8, loc="upper left")


def draw_map(figure, axes, rows):
    x, y = (np.array([int(row[key]) for row in rows]) for key in ("x", "y"))
    image = np.full((y.max() + 1, x.max() + 1), np.nan)
    image[y, x] = [float(row["deviation_deg"]) for row in rows]
    shown = axes.imshow(image, origin="lower", cmap="RdBu_r", vmin=-15, vmax=15, aspect="auto")
    bar = figure.colorbar(shown, ax=axes)
    bar.set_label("deviation (degrees)", fontsize=9)
    bar.ax.tick_params(labelsize=8)
    axes.set_title("... of the 600 kinds of cilia", fontsize=10)
    axes.set_xlabel("x / spacing, one wave", fontsize=9)
    axes.set_ylabel("y / spacing, one wave", fontsize=9)


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    folder = Path(sys.argv[1])
    out = Path(sys.argv[2]) if len(sys.argv) == 3 else folder
    out.mkdir(parents=True, exist_ok=True)
    precision, phases, every_kind = (read(folder / f"farm_{name}.csv") for name in ("precision", "phases", "kinds"))
    figure, axes = plt.subplots(2, 2, figsize=(8.4, 6.4), layout="constrained")
    draw_precision(axes[0, 0], precision)
    draw_start(axes[0, 1], every_kind)
    draw_bonds(axes[1, 0], phases)
    draw_map(figure, axes[1, 1], every_kind)
    for ax in axes.flat:
        ax.tick_params(labelsize=8)
    for ax in axes.flat[:3]:
        ax.grid(True, which="major", alpha=0.25)
    figure.savefig(out / "farm_precision.png", dpi=80)


if __name__ == "__main__":
    main()
