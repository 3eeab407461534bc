#!/usr/bin/env python3
"""Error of the fluid against core-seconds: fluid_work_precision.py TABLE [PICTURE]

Reads the table of bench/scenes/fluid_work_precision/run.py. A curve is a scheme at a Courant number over the grids, n of which stands beside the points. PICTURE
is TABLE with the ending .png where it is absent. Needs numpy and matplotlib.
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

TITLES = {"plane": "Vortices in a plane, n x n x 4", "space": "Vortices in space, n x n x n"}
COLOURS = {"rk3": "tab:blue", "rk3_projected": "tab:red", "adams_bashforth": "tab:green"}
LINES = ("-", "--", ":")


def read(path):
    with open(path, newline="") as file:
        return [row | {"error": float(row["error"])} for row in csv.DictReader(file)]


def draw(axes, rows):
    for scheme, colour in COLOURS.items():
        own = [row for row in rows if row["scheme"] == scheme]
        for courant, line in zip(dict.fromkeys(row["courant"] for row in own), LINES):
            points = [row for row in own if row["courant"] == courant and row["error"] < float("inf")]
            seconds = [float(row["core_seconds"]) for row in points]
            axes.loglog(seconds, [row["error"] for row in points], "o" + line, ms=3.5, lw=1.3, color=colour, label=f"{scheme.replace('_', ' ')}, Courant {courant}")
    for n in dict.fromkeys(row["n"] for row in rows):  # beside the grid's dearest run
        last = max((row for row in rows if row["n"] == n and row["error"] < float("inf")), key=lambda row: float(row["core_seconds"]))
        axes.annotate(f"n = {n}", (float(last["core_seconds"]), last["error"]), (5, 3), textcoords="offset points", fontsize=7)
    axes.margins(x=0.12)
    axes.set_title(TITLES[rows[0]["flow"]], fontsize=10)
    axes.set_xlabel("core-seconds", fontsize=9)
    axes.set_ylabel("largest error / largest velocity", fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(True, which="major", alpha=0.25)


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    table = Path(sys.argv[1])
    picture = Path(sys.argv[2]) if len(sys.argv) == 3 else table.with_suffix(".png")
    rows = read(table)
    flows = list(dict.fromkeys(row["flow"] for row in rows))
    figure, axes = plt.subplots(1, len(flows), figsize=(5.2 * len(flows), 4.2), layout="constrained", squeeze=False)
    for one, flow in zip(axes.flat, flows):
        draw(one, [row for row in rows if row["flow"] == flow])
    axes.flat[0].legend(fontsize=7, loc="lower left")
    figure.savefig(picture, dpi=80)
    print(picture)


if __name__ == "__main__":
    main()
