#!/usr/bin/env python3
"""Strong scaling with Amdahl's fit, and where a step's time goes: scaling.py TABLE [PICTURE]

Reads the table of bench/scaling/scaling.py. Left, speed over one core of every layout of ranks x threads, by both protocols; right, time
per element-step and core in strong and weak scaling, the part spent waiting for other ranks on top. PICTURE is TABLE with the ending
.png where it is absent. Needs numpy and matplotlib.
"""

import csv
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)
from matplotlib.ticker import FixedLocator, NullLocator  # noqa: E402

COLOURS = {"asynchronous": "tab:blue", "synchronous": "tab:red"}


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row["layout"] = f"{row['ranks']}x{row['threads']}"
        row["cores"] = int(row["ranks"]) * int(row["threads"])
        for key in ("step_s", "least_step_s", "most_step_s", "speedup", "ns_per_element_step_and_core", "agree_s", "steps", "serial_fraction"):
            row[key] = float(row[key] or "nan")
    return rows


def draw_strong(axes, rows):
    most = max(row["cores"] for row in rows)
    cores = np.geomspace(1, max(2, most), 100)
    axes.plot(cores, cores, color="0.6", lw=1, ls="--", label="ideal")
    for protocol, colour in COLOURS.items():
        own = [row for row in rows if row["protocol"] == protocol]
        if not own:
            continue
        base, serial = own[0], own[0]["serial_fraction"]
        axes.plot(cores, 1 / (serial + (1 - serial) / cores), color=colour, lw=1.3, label=f"{protocol}, serial {max(0.0, 100 * serial):.1f} %")
        for marker, kind in (("o", [row for row in own if row["ranks"] == "1"]), ("s", [row for row in own if row["ranks"] != "1"])):
            speed = np.array([row["speedup"] for row in kind])
            spread = np.array([[base["step_s"] / row["most_step_s"], base["step_s"] / row["least_step_s"]] for row in kind]).reshape(-1, 2).T
            axes.errorbar([row["cores"] for row in kind], speed, yerr=np.maximum(0, [speed - spread[0], spread[1] - speed]), fmt=marker, color=colour, ms=6,
                          mec="k", mew=0.5, elinewidth=1, capsize=3, zorder=4)
    axes.plot([], [], "o", color="w", mec="k", label="threads of one rank")
    axes.plot([], [], "s", color="w", mec="k", label="several ranks")
    if most > 4:
        axes.set_xscale("log", base=2)
        axes.set_yscale("log", base=2)
    ticks = sorted({row["cores"] for row in rows})
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("cores", fontsize=9)
    axes.set_ylabel("speed over one core", fontsize=9)
    axes.legend(fontsize=8, loc="upper left")
    axes.set_title(f"{rows[0]['rods']} rods of {int(rows[0]['elements']) // int(rows[0]['rods'])} elements", fontsize=10)


def draw_time(axes, rows):
    """Per element-step and core: flat where scaling is perfect."""
    labels, place = [], 0
    for study in ("strong", "weak"):
        for layout in dict.fromkeys(row["layout"] for row in rows if row["study"] == study):
            for row in (row for row in rows if row["study"] == study and row["layout"] == layout):
                x = place + (-0.19 if row["protocol"] == "asynchronous" else 0.19)
                total = row["ns_per_element_step_and_core"]
                waiting = total * row["agree_s"] / row["steps"] / row["step_s"]
                axes.bar(x, total - waiting, 0.36, color=COLOURS[row["protocol"]], zorder=2)
                axes.bar(x, waiting, 0.36, bottom=total - waiting, color="0.75", zorder=2)
                axes.text(x, total, f"{total:.1f}", ha="center", va="bottom", fontsize=7)
            labels.append((place, f"{layout}\n{study}"))
            place += 1
        place += 0.4
    axes.bar(0, 0, color="0.75", label="waiting for other ranks")
    axes.set_xticks([x for x, _ in labels], [label for _, label in labels], fontsize=8)
    axes.set_ylim(0, 1.2 * max(row["ns_per_element_step_and_core"] for row in rows))
    axes.set_ylabel("ns per element-step and core", fontsize=9)
    axes.set_xlabel("ranks x threads", fontsize=9)
    axes.legend(fontsize=8, loc="upper left")


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    table = Path(sys.argv[1])
    picture = Path(sys.argv[2]) if len(sys.argv) == 3 else table.with_suffix(".png")
    rows = read(table)
    layouts = len({(row["study"], row["layout"]) for row in rows})
    fig, (left, right) = plt.subplots(1, 2, figsize=(10.4 + 0.5 * max(0, layouts - 6), 4.2), layout="constrained")
    draw_strong(left, [row for row in rows if row["study"] == "strong"])
    draw_time(right, rows)
    for axes in (left, right):
        axes.tick_params(labelsize=8)
        axes.grid(True, axis="y", alpha=0.25)
    fig.savefig(picture, dpi=80)
    print(picture)


if __name__ == "__main__":
    main()
