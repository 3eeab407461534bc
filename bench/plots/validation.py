#!/usr/bin/env python3
"""Figures of the validation cases: validation.py FOLDER [OUT]

Reads every CASE.csv in FOLDER (written by the tests of `ctest -L validation` where SKEIN_VALIDATION_OUT names it) and draws
OUT/CASE.png, OUT being FOLDER where it is absent: error against the number of elements, and against the step where only the
step changes, with lines of the nearest whole order. Needs numpy and matplotlib.
"""

import csv
import math
import sys
from collections import defaultdict
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)


def read(path):
    """Rows of each quantity, in file order; numbers as floats."""
    series = defaultdict(list)
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            series[row["quantity"]].append({key: float(row[key]) for key in ("n", "dt", "error", "order")})
    return series


def refines_in_space(rows):
    return len({row["n"] for row in rows}) > 1


def draw(axes, series, key):
    """Errors of several quantities against n or dt, each with the line of the whole order nearest to its last one."""
    for name, rows in series.items():
        at, error = (np.array([row[k] for row in rows]) for k in (key, "error"))
        order = rows[-1]["order"]
        label = name if math.isnan(order) else f"{name}: order {order:.2f}"
        (line,) = axes.loglog(at, error, "o-", ms=5, lw=1.2, label=label)
        if not math.isnan(order):
            slope = round(order) * (-1 if key == "n" else 1)
            axes.loglog(at, 0.7 * error[-1] * (at / at[-1]) ** slope, "--", lw=0.8, color=line.get_color())
    axes.set_xlabel("elements n" if key == "n" else "step dt (s)")
    axes.set_ylabel("error")
    axes.grid(True, which="both", alpha=0.2)
    axes.legend(fontsize=8)
    if key == "n":
        ticks = sorted({row["n"] for rows in series.values() for row in rows})
        axes.set_xticks(ticks, [f"{t:.0f}" for t in ticks])
        axes.minorticks_off()


def figure(path, out):
    """Draws one table; says so and returns False where it has no rows, as a case leaves it that was stopped."""
    series = read(path)
    if not series:
        print(f"warning: {path} has no rows: no figure", file=sys.stderr)
        return False
    panels = []
    for key, space in (("n", True), ("dt", False)):
        chosen = {name: rows for name, rows in series.items() if refines_in_space(rows) == space}
        if chosen:
            panels.append((key, chosen))
    fig, axes = plt.subplots(1, len(panels), figsize=(5.4 * len(panels), 4.2), squeeze=False)
    for ax, (key, chosen) in zip(axes[0], panels):
        draw(ax, chosen, key)
    fig.suptitle(path.stem.replace("_", " "))
    fig.tight_layout()
    fig.savefig(out / f"{path.stem}.png", dpi=140)
    plt.close(fig)
    return True


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    folder = Path(sys.argv[1])
    out = Path(sys.argv[-1])
    tables = sorted(folder.glob("*.csv"))
    if not tables:
        sys.exit(f"error: no tables (*.csv) in {folder}")
    out.mkdir(parents=True, exist_ok=True)
    drawn = sum(figure(path, out) for path in tables)
    print(f"{drawn} figures in {out}")


if __name__ == "__main__":
    main()
