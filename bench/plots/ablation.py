#!/usr/bin/env python3
"""Figure of what the speed is made of: ablation.py TABLE [PICTURE]

Reads the table of `bench_farm --csv TABLE` and draws the speed-up over the textbook as one thing is added after the other, from the
medians of one run; a dashed line where the textbook stands that was compiled to vectorise. PICTURE is ablation.png beside the table where it is absent. Needs matplotlib.
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

# What is added, and where its row is: code, lanes, threads, steps per visit.
STAGES = (
    ("textbook: a loop per term,\nscalar, library functions", ("textbook", 1, 1, 1)),
    ("passes over a tile,\nquaternions, polynomials", ("skein", 1, 1, 1)),
    ("2 rods side by side", ("skein", 2, 1, 1)),
    ("4 rods side by side", ("skein", 4, 1, 1)),
    ("8 rods side by side", ("skein", 8, 1, 1)),
    ("64 steps per visit", ("skein", 8, 1, 64)),
    ("2 threads", ("skein", 8, 2, 64)),
)


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return rows[0], {(row["code"], int(row["lanes"]), int(row["threads"]), int(row["steps_per_visit"])): float(row["wall_ns"]) for row in rows}


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    table = Path(sys.argv[1])
    picture = Path(sys.argv[2]) if len(sys.argv) == 3 else table.parent / "ablation.png"
    run, ns = read(table)
    times = [ns[key] for _, key in STAGES]
    speed = [times[0] / t for t in times]

    fig, axes = plt.subplots(figsize=(8.4, 4.2), layout="constrained")
    colours = ["tab:gray"] + ["tab:blue"] * 4 + ["tab:green", "tab:orange"]
    axes.barh(range(len(STAGES)), speed, color=colours, height=0.68, zorder=2)
    for k, (s, t) in enumerate(zip(speed, times)):
        axes.text(s + 0.01 * max(speed), k, f"{s:.1f}x" + f"   {t:.1f} ns", va="center", fontsize=9)
    vectorised = ns.get(("textbook vectorised", 1, 1, 1))
    if vectorised:
        axes.axvline(times[0] / vectorised, color="tab:gray", linestyle="--", linewidth=1, label="textbook, vectorised by the compiler")
        axes.legend(frameon=False, fontsize=8, loc="lower right")
    axes.set_yticks(range(len(STAGES)), [label for label, _ in STAGES], fontsize=9)
    axes.invert_yaxis()
    axes.set_xlim(0, 1.2 * max(speed))
    axes.set_xlabel("speed over the textbook; wall time per element-step", fontsize=9)
    axes.set_title(f"{run['cilia']} cilia of {run['elements']} elements; each line with all above it", fontsize=10)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(True, axis="x", alpha=0.25)
    fig.savefig(picture, dpi=80)
    print(picture)


if __name__ == "__main__":
    main()
