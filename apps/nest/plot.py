#!/usr/bin/env python3
"""Figures of a nest under its lid: plot.py RUN [--area M2] [--contact-bench JSON] [--scaling CSV]

Prints what loops.py measures and draws
  RUN/nest.png   the bed at rest and at its highest load, stress over strain, coordination over stress and time
  RUN/cost.png   where the time of a step goes (from summary.json); cost of finding candidates over the number of rods, from the JSON of
                 bench_contact (--benchmark_format=json); speed over cores, from a table of bench/scenes/nest/nest.py
as in the figure of nests of the Elastica++ paper (docs/references.md). Needs numpy, h5py and matplotlib.
"""

import argparse
import csv
import json
import re
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
import loops  # noqa: E402
import packing  # noqa: E402
from style import INK, QUIET, bare, heading  # noqa: E402  (from apps/figures)

CYCLES = plt.get_cmap("viridis")
WALL_TIME = {"rods": ("rods", "#c8a15a"), "contacts": ("contacts and search", "#3f6fa8"), "exchange": ("loads handed over", "#8fb0d4"),
             "output": ("series, frames, checkpoints", "#c9ced6")}
PAPER = {"Elastica++ (paper)": 26, "control study (paper)": 44}  # % of the time that rods take


def shade_of(cycle, count):
    return CYCLES(0.85 * (cycle / max(1, count - 1)))


def parts(run):
    """[(cycle, loading, unloading)] as ranges of rows; the last cycle may have no end yet."""
    found = [(k, slice(start.row, peak.row), slice(peak.row, end.row + 1)) for k, (start, peak, end) in enumerate(loops.cycles(run))]
    begin = found[-1][2].stop - 1 if found else loops.first_touch(run)
    if run.turns[-1] % 2:
        peak = int(np.argmax(run.turns >= run.turns[-1]))
        found.append((len(found), slice(begin, peak), slice(peak, len(run.time))))
    elif begin < len(run.time) - 1:
        found.append((len(found), slice(begin, len(run.time)), slice(0, 0)))
    return found


def smooth(values):
    """Mean of rows: contacts come and go by single pairs."""
    width = 2 * loops.AROUND + 1
    return np.convolve(np.pad(values, loops.AROUND, mode="edge"), np.ones(width) / width, mode="valid")


def axis_words(axes, x, y):
    axes.set_xlabel(x, color=INK, labelpad=3)
    axes.set_ylabel(y, color=INK, labelpad=3)
    bare(axes, "left", "bottom")


def draw_loops(axes, run, figures):
    found = parts(run)
    strain = (figures["H0_m"] - run.height) / figures["H0_m"]
    stress = 1e-3 * run.lid_stress
    for k, up, down in found:
        colour = shade_of(k, len(found))
        axes.plot(strain[up], stress[up], color=colour, lw=1.4, label=f"cycle {k + 1}")
        axes.plot(strain[down], stress[down], color=colour, lw=1.4, ls=(0, (2.2, 1.2)))
    if found:
        axes.set_xlim(strain[found[0][1].start] - 0.25 * np.ptp(strain[found[0][1]]), None)
    axes.set_ylim(0, None)
    axis_words(axes, "strain (H₀ - H)/H₀", "stress on the lid [kPa]")
    axes.legend(frameon=False, labelcolor=INK, loc="upper left", handlelength=1.4)
    heading(axes, "loading (full) and unloading (dashed)")


def draw_coordination_over_stress(axes, run):
    found, z = parts(run), smooth(run["coordination[-]"])
    stress = 1e-3 * run.lid_stress
    for k, up, down in found:
        colour = shade_of(k, len(found))
        axes.plot(stress[up], z[up], color=colour, lw=1.4)
        axes.plot(stress[down], z[down], color=colour, lw=1.4, ls=(0, (2.2, 1.2)))
    axes.set_ylim(0, None)
    axes.set_xlim(0, None)
    axis_words(axes, "stress on the lid [kPa]", "contacts per rod ⟨z⟩")
    heading(axes, "coordination over stress")


def draw_coordination_over_time(axes, run):
    axes.plot(run.time, run["coordination[-]"], color=QUIET, lw=0.4, alpha=0.5)
    axes.plot(run.time, smooth(run["coordination[-]"]), color="#3f6fa8", lw=1.5)
    axes.set_ylim(0, None)
    axes.set_xlim(0, run.time[-1])
    for k, _, down in parts(run):
        if down.stop:
            axes.axvline(run.time[down.start], color=QUIET, lw=0.7, ls=":")
            axes.annotate(f"{k + 1}", (run.time[down.start], axes.get_ylim()[1]), (0, -2), textcoords="offset points", color=QUIET, ha="center", va="bottom")
    axis_words(axes, "time [s]", "contacts per rod ⟨z⟩")
    heading(axes, "coordination over time, peaks dotted", pad=14)


def pictured(run):
    """Rows of the series nearest to two frames: the last one before the lid touches, and that of the highest stress."""
    found = frames.frames(run.directory)
    rows = [int(np.argmin(np.abs(run.time - t))) for t, _, _ in found]
    before = [i for i, row in enumerate(rows) if row < loops.first_touch(run)]
    rest, peak = before[-1] if before else 0, int(np.argmax(np.minimum(run.base_stress, run.lid_stress)[rows]))
    return [(rows[i], found[i][1], found[i][2]) for i in (rest, peak)]


def draw_nest(path, run, figures):
    figure = plt.figure(figsize=(9, 8.6), facecolor="white")
    chosen = pictured(run)
    rods = [frames.read_rods(file, number) for _, file, number in chosen]
    most = max(packing.bending_strain(nodes, radius).max() for nodes, radius in rods)
    top = 1.05 * max(nodes[..., 2].max() for nodes, _ in rods)
    for (row, _, _), (nodes, radius), left, word in zip(chosen, rods, (0.015, 0.51), ("at rest", "pressed")):
        axes = figure.add_axes([left, 0.615, 0.475, 0.28])
        packing.draw(axes, run.physics, nodes, radius, most, run.height[row], top)
        heading(axes, f"{word}: {run.lid_stress[row]:.0f} Pa, ⟨z⟩ = {smooth(run['coordination[-]'])[row]:.1f}", pad=2)
    bar = figure.colorbar(ScalarMappable(Normalize(0, 100 * most), packing.BENDING), cax=figure.add_axes([0.36, 0.603, 0.28, 0.012]), orientation="horizontal")
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=0, labelcolor=INK)
    bar.ax.set_xlabel("strain by bending [%]", color=INK, labelpad=2)

    draw_loops(figure.add_axes([0.08, 0.075, 0.4, 0.42]), run, figures)
    draw_coordination_over_stress(figure.add_axes([0.58, 0.33, 0.4, 0.165]), run)
    draw_coordination_over_time(figure.add_axes([0.58, 0.075, 0.4, 0.14]), run)
    figure.text(0.02, 0.965, figures["title"], color=INK, fontsize=13, va="center")
    figure.text(0.02, 0.937, "; ".join(words(figures)), color=QUIET, va="center")
    figure.savefig(path, dpi=120, pil_kwargs={"optimize": True})
    plt.close(figure)


def words(figures):
    if figures["cycles"]:
        yield "of the lid's work " + ", ".join(f"{100 * c['psi']:.0f} %" for c in figures["cycles"]) + " are lost, cycle by cycle"
        if len(figures["cycles"]) < 4:
            yield "the bed sinks by " + ", ".join(f"{1e3 * c['residual_m']:.2f} mm" for c in figures["cycles"])


def draw_split(axes, run):
    """Shares of the step, and below them those that the Elastica++ paper gives for rods and the rest."""
    seconds = {name: phase["mean_s"] for name, phase in run.summary["phases"].items()}
    seconds["contacts"] = seconds.get("contacts", 0) + seconds.get("search", 0)
    seconds["output"] = sum(seconds.get(name, 0) for name in ("observe", "output", "checkpoint"))
    shares = {name: seconds.get(name, 0) for name in WALL_TIME}
    whole, left = sum(shares.values()), 0.0
    for name, (label, colour) in WALL_TIME.items():
        share = 100 * shares[name] / whole
        axes.barh(2, share, left=left, color=colour, height=0.6, label=label)
        if share > 6:
            axes.text(left + 0.5 * share, 2, f"{share:.0f} %", color="white", ha="center", va="center", fontweight="bold")
        left += share
    for y, (_, share) in zip((1, 0), PAPER.items()):
        axes.barh(y, share, color=WALL_TIME["rods"][1], height=0.6)
        axes.barh(y, 100 - share, left=share, color=WALL_TIME["contacts"][1], height=0.6)
        axes.text(0.5 * share, y, f"{share} %", color="white", ha="center", va="center", fontweight="bold")
    axes.set_yticks([2, 1, 0], labels=["Skein, this run", *PAPER])
    axes.set_xlim(0, 100)
    axes.set_xlabel("share of the run time [%]", color=INK, labelpad=3)
    bare(axes, "bottom")
    axes.tick_params(axis="y", length=0)
    axes.legend(frameon=False, labelcolor=INK, ncols=2, loc="lower left", bbox_to_anchor=(0, 1.0), columnspacing=1.2, handlelength=1)


def draw_search(axes, path):
    found = {}
    for row in json.loads(Path(path).read_text())["benchmarks"]:
        name = re.fullmatch(r"candidates/(grids|all_pairs)/N(\d+)(?:/threads1)?(?:/real_time)?(?:_median)?", row["name"])
        if name and (row.get("run_type") != "aggregate" or row.get("aggregate_name") == "median"):
            seconds = row["real_time"] * {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1}[row["time_unit"]]
            found.setdefault(name[1], {}).setdefault(int(name[2]), []).append(seconds)
    for kind, label, colour, marker in (("all_pairs", "all pairs", "#b8563b", "s"), ("grids", "grids", "#3f6fa8", "o")):
        n = np.array(sorted(found.get(kind, {})))
        if not len(n):
            continue
        time = np.array([np.median(found[kind][k]) for k in n])
        slope = np.polyfit(np.log(n), np.log(time), 1)[0] if len(n) > 1 else np.nan
        axes.loglog(n, 1e6 * time / n, color=colour, marker=marker, ms=5, lw=1.4, label=f"{label}, time ~ $N^{{{slope:.2f}}}$")
    axis_words(axes, "rods N", "time of a search / N [µs]")
    axes.legend(frameon=False, labelcolor=INK)
    heading(axes, "finding candidates, one thread")


def draw_scaling(axes, path):
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row.get("study", "strong") == "strong" and row.get("scene", "nest") != "free"]
    most = max(int(row["ranks"]) * int(row["threads"]) for row in rows)
    axes.plot([1, most], [1, most], color=QUIET, lw=1, ls="--", label="ideal")
    for protocol, colour in (("asynchronous", "#8fb0d4"), ("synchronous", "#3f6fa8")):
        own = [row for row in rows if row.get("protocol", "synchronous") == protocol]
        if not own:
            continue
        serial = f", serial {100 * float(own[0]['serial_fraction']):.0f} %" if own[0].get("serial_fraction") else ""
        for marker, kind in (("o", [row for row in own if row["ranks"] == "1"]), ("s", [row for row in own if row["ranks"] != "1"])):
            points = sorted((int(row["ranks"]) * int(row["threads"]), float(row["speedup"])) for row in kind)
            style = {"lw": 1.4, "label": protocol + serial} if marker == "o" else {"lw": 0}
            axes.plot(*np.array(points).reshape(-1, 2).T, color=colour, marker=marker, ms=5, **style)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log", base=2)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
    axis_words(axes, "cores", "speed over one core")
    axes.legend(frameon=False, labelcolor=INK)
    heading(axes, "strong scaling; squares: several ranks")


def draw_cost(path, run, bench, scaling):
    more = [(draw, source) for draw, source in ((draw_search, bench), (draw_scaling, scaling)) if source]
    height, width = (6.5 if more else 3.1), (0.39 if len(more) == 2 else 0.89)
    figure = plt.figure(figsize=(9, height), facecolor="white")
    draw_split(figure.add_axes([0.19, 1 - 2.55 / height, 0.78, 1.45 / height]), run)
    figure.text(0.02, 1 - 0.3 / height, "Where the time goes", color=INK, fontsize=13, va="center")
    for k, (draw, source) in enumerate(more):
        draw(figure.add_axes([0.09 + 0.5 * k, 0.09, width, 2.4 / height]), source)
    figure.savefig(path, dpi=120, pil_kwargs={"optimize": True})
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="directory of a run's results")
    parser.add_argument("--area", type=float, help="of the base, m^2; default: the servo's")
    parser.add_argument("--contact-bench", type=Path, help="JSON of bench_contact")
    parser.add_argument("--scaling", type=Path, help="table of bench/scenes/nest/nest.py")
    arguments = parser.parse_args()

    run = loops.read(arguments.run, arguments.area)
    figures = loops.measure(run)
    print(loops.table(figures))
    (arguments.run / "loops.json").write_text(json.dumps(figures, indent=2) + "\n")
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    if frames.frames(arguments.run):
        draw_nest(arguments.run / "nest.png", run, figures)
    if run.summary:
        draw_cost(arguments.run / "cost.png", run, arguments.contact_bench, arguments.scaling)


if __name__ == "__main__":
    main()
