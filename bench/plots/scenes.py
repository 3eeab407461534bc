#!/usr/bin/env python3
"""Strong scaling of scenes over cores: scenes.py TABLE... [--to PICTURE]

Reads tables of bench/scaling/scenes.py, and strong rows of bench/scaling/scaling.py. Left, speed over one core of every layout of ranks x threads; right,
where the time of a step goes on the most threads of a single rank. PICTURE is the first table with the ending .png where it is absent.
Needs numpy and matplotlib.
"""

import argparse
import csv
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

PHASES = ("rods", "contacts", "search", "exchange", "fluid", "markers", "agree", "balance")


def read(path):
    """Rows by scene."""
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row.get("study", "strong") == "strong" and row.get("protocol", "asynchronous") == "asynchronous"]
    scenes = {}
    for row in rows:
        row["cores"] = int(row["ranks"]) * int(row["threads"])
        scenes.setdefault(row.get("scene") or f"{int(row['rods']):,} free rods".replace(",", " "), []).append(row)
    return scenes


def shares(row):
    """Of the phases of a step, as far as the table has them."""
    seconds = {phase: float(row.get(f"{phase}_s") or 0) for phase in PHASES}
    whole = sum(seconds.values())
    return {phase: time / whole for phase, time in seconds.items() if time > 0}


def draw_speeds(axes, scenes):
    most = max(row["cores"] for rows in scenes.values() for row in rows)
    cores = 2 ** np.arange(np.log2(most) + 0.5)
    axes.plot(cores, cores, color="0.6", lw=1, ls="--", label="ideal")
    for number, (scene, rows) in enumerate(scenes.items()):
        colour = f"C{number}"
        threads = [row for row in rows if row["ranks"] == "1"]
        ranks = [row for row in rows if row["ranks"] != "1"]
        axes.plot([row["cores"] for row in threads], [float(row["speedup"]) for row in threads], "o-", color=colour, ms=5, lw=1.3, label=scene)
        axes.plot([row["cores"] for row in ranks], [float(row["speedup"]) for row in ranks], "s", mfc="none", color=colour, ms=5)
    axes.plot([], [], "s", mfc="none", color="k", label="several ranks")
    axes.set_xscale("log", base=2)
    axes.set_yscale("log", base=2)
    axes.set_xticks(cores, [f"{c:g}" for c in cores])
    axes.set_yticks(cores, [f"{c:g}" for c in cores])
    axes.set_xlabel("cores")
    axes.set_ylabel("speed over one core")
    axes.legend(fontsize=8, frameon=False)


def draw_shares(axes, scenes):
    rows = [max(rows, key=lambda row: (row["ranks"] == "1", row["cores"])) for rows in scenes.values()]
    names = [f"{scene}, {row['ranks']}x{row['threads']}" for scene, row in zip(scenes, rows)]
    before = np.zeros(len(names))
    for number, phase in enumerate(PHASES):
        widths = np.array([shares(row).get(phase, 0.0) for row in rows])
        if widths.max() < 0.005:
            continue
        axes.barh(names, widths, left=before, color=f"C{number}", label=phase, height=0.6)
        before += widths
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of a step, ranks x threads")
    axes.legend(fontsize=8, frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.4, 1.0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="+", type=Path, metavar="TABLE")
    parser.add_argument("--to", type=Path, metavar="PICTURE")
    args = parser.parse_args()
    scenes = {}
    for path in args.tables:
        scenes |= read(path)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained", width_ratios=(1, 1.1))
    draw_speeds(left, scenes)
    draw_shares(right, scenes)
    figure.savefig(args.to or args.tables[0].with_suffix(".png"), dpi=110)


if __name__ == "__main__":
    main()
