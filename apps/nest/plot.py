#!/usr/bin/env python3
"""Figures of a nest under its lid: plot.py RUN [--area M2] [--beside RUN] [--before RUN] [--contact-bench JSON] [--scaling CSV]

Prints what loops.py measures and draws
  RUN/nest.png   the bed at rest and at its highest load, stress over strain, coordination over stress and time; of the run beside it
                 the last cycle, in grey
  RUN/work.png   what the lid's work becomes, cycle by cycle; where the run has written contacts (output.contacts), forces in a slice
                 of the bed and how they are distributed, at the highest load that a table has
  RUN/cost.png   where the time of a step goes (from summary.json), and went in another program's run (--before); cost of finding
                 candidates over the number of rods, from the JSON of bench_contact (--benchmark_format=json); speed over cores, from a
                 table of bench/scenes/nest/nest.py
as in the figure of nests of the Elastica++ paper (docs/references.md). Needs numpy, h5py and matplotlib.
"""

import argparse
import csv
import json
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)
from matplotlib.collections import LineCollection  # noqa: E402

import loops  # noqa: E402
import skein  # noqa: E402
from skein.style import INK, QUIET, bare, heading  # noqa: E402

CYCLES = plt.get_cmap("viridis")
WORK = {"friction_J": ("friction", "#b8563b"), "dashpots_J": ("dashpots of contacts", "#dfa65a"), "rods_damping_J": ("drag on rods", "#8fb0d4")}
FORCE = "#8e2f3f"
PUBLISHED_Z = 7  # contacts per rod under compression, in the paper
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


def last_cycle(run):
    """Rows of its way forth and back."""
    whole = [(up, down) for _, up, down in parts(run) if down.stop]
    return whole[-1] if whole else (slice(0, 0), slice(0, 0))


def draw_loops(axes, run, figures, beside):
    if beside:
        h0 = beside.height[loops.first_touch(beside)]
        for rows, label in zip(last_cycle(beside), (f"{beside.summary.get('rods', 'other')} rods, last cycle", None)):
            axes.plot((h0 - beside.height[rows]) / h0, 1e-3 * beside.lid_stress[rows], color=QUIET, lw=0.9, label=label)
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
    axes.locator_params(axis="x", nbins=6)
    axis_words(axes, "strain (H₀ - H)/H₀", "stress on the lid [kPa]")
    axes.legend(frameon=False, labelcolor=INK, loc="upper left", handlelength=1.4)
    heading(axes, "loading (full) and unloading (dashed)")


def draw_coordination_over_stress(axes, run, beside):
    if beside:
        for rows in last_cycle(beside):
            axes.plot(1e-3 * beside.lid_stress[rows], smooth(beside["coordination[-]"])[rows], color=QUIET, lw=0.9)
    axes.axhline(PUBLISHED_Z, color=QUIET, lw=0.7, ls=":")
    axes.annotate("paper", (0, PUBLISHED_Z), (3, 2), textcoords="offset points", color=QUIET)
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
    times = skein.open(run.directory).time
    rows = [int(np.argmin(np.abs(run.time - t))) for t in times]
    before = [i for i, row in enumerate(rows) if row < loops.first_touch(run)]
    rest, peak = before[-1] if before else 0, int(np.argmax(np.minimum(run.base_stress, run.lid_stress)[rows]))
    return [(rows[i], times[i]) for i in (rest, peak)]


def draw_nest(path, run, figures, beside):
    figure = plt.figure(figsize=(9, 8.6), facecolor="white")
    chosen = pictured(run)
    pictures = skein.Pictures(run.directory, [time for _, time in chosen], (1020, 620), colour="bending")
    for number, ((row, _), left, word) in enumerate(zip(chosen, (0.015, 0.51), ("at rest", "pressed"))):
        axes = figure.add_axes([left, 0.615, 0.475, 0.28])
        pictures.show(axes, number)
        heading(axes, f"{word}: {run.lid_stress[row]:.0f} Pa, ⟨z⟩ = {smooth(run['coordination[-]'])[row]:.1f}", pad=2)
    pictures.bar(figure, [0.36, 0.603, 0.28, 0.012])

    draw_loops(figure.add_axes([0.08, 0.075, 0.4, 0.42]), run, figures, beside)
    draw_coordination_over_stress(figure.add_axes([0.58, 0.33, 0.4, 0.165]), run, beside)
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


def contacts_at_highest_load(run):
    """Table of contacts, by heading, and lid's stress there; none where the run has written no table with contacts."""
    found = skein.open(run.directory)
    rows = {step: int(np.argmin(np.abs(run["step"] - step))) for step in found.contact_steps}
    if not rows:
        return None
    step = max(rows, key=lambda step: run.lid_stress[rows[step]])
    contacts = found.contacts(step)
    return (contacts, run.lid_stress[rows[step]]) if len(contacts["rod_1"]) else None


def draw_work(axes, figures):
    bottom = np.zeros(len(figures["cycles"]))
    k = np.arange(1, len(bottom) + 1)
    for key, (label, colour) in WORK.items():
        share = 100 * np.array([c[key] / c["work_in_J"] for c in figures["cycles"]])
        axes.bar(k, share, bottom=bottom, color=colour, width=0.6, label=label)
        bottom += share
    axes.plot(k, [100 * c["psi"] for c in figures["cycles"]], color=INK, marker="_", ms=26, lw=0, label="all that is not returned")
    axes.set_xticks(k)
    axes.set_ylim(0, 160 * max(c["psi"] for c in figures["cycles"]))
    axis_words(axes, "cycle", "share of the lid's work [%]")
    axes.legend(frameon=False, labelcolor=INK, loc="upper right", handlelength=1)
    heading(axes, "what the lid's work becomes")


def draw_chains(axes, contacts, radius):
    """Contacts in the middle of the bed as bars along their forces, from axis to axis, as wide as the forces are large."""
    place = np.stack([contacts[f"{i}[m]"] for i in "xyz"], axis=1)
    force = np.stack([contacts[f"force_{i}[N]"] for i in "xyz"], axis=1)
    size = np.linalg.norm(force, axis=1)
    middle = 0.5 * (place[:, 1].min() + place[:, 1].max())
    chosen = (np.abs(place[:, 1] - middle) < 0.1 * np.ptp(place[:, 1])) & (size > 0)
    along = radius * force[chosen] / size[chosen, None]
    ends = np.stack([place[chosen] - along, place[chosen] + along], axis=1)[..., [0, 2]]
    axes.add_collection(LineCollection(1e3 * ends, linewidths=0.5 * size[chosen] / np.mean(size), colors=FORCE, alpha=0.75, capstyle="butt"))
    axes.autoscale()
    axes.set_aspect("equal")
    axis_words(axes, "x [mm]", "z [mm]")
    heading(axes, "forces in a slice, a fifth of the bed thick; width: force")


def draw_distribution(axes, contacts):
    force = np.hypot(contacts["normal[N]"], contacts["friction[N]"])
    over_mean = force / np.average(force)
    density, edges = np.histogram(over_mean, bins=40, density=True)
    centre = 0.5 * (edges[1:] + edges[:-1])
    axes.semilogy(centre[density > 0], density[density > 0], color=FORCE, marker="o", ms=3, lw=0)
    axes.semilogy(centre, np.exp(-centre), color=QUIET, lw=1, ls="--", label="exponential")
    axes.set_ylim(0.5 / len(force), None)
    axis_words(axes, "force over its mean", "probability density")
    axes.legend(frameon=False, labelcolor=INK)
    heading(axes, f"{len(force)} pairs of elements, mean {np.average(force):.2f} N")


def draw_what_becomes(path, run, figures):
    found = contacts_at_highest_load(run)
    figure = plt.figure(figsize=(9, 6.6 if found else 3.3), facecolor="white")
    draw_work(figure.add_axes([0.08, 0.085, 0.38, 0.33] if found else [0.08, 0.16, 0.6, 0.7]), figures)
    if found:
        contacts, stress = found
        draw_distribution(figure.add_axes([0.59, 0.085, 0.38, 0.33]), contacts)
        draw_chains(figure.add_axes([0.08, 0.55, 0.89, 0.36]), contacts, max(run.physics["rods"][0]["section"]["radius"], 1e-9))
        figure.text(0.02, 0.965, f"{figures['title']}: {1e-3 * stress:.1f} kPa", color=INK, fontsize=13, va="center")
    figure.savefig(path, dpi=120, pil_kwargs={"optimize": True})
    plt.close(figure)


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


def draw_before(axes, run, before):
    """What an element-step costs on one core, part by part, in both."""
    parts_of = ("rods", "contacts", "search", "exchange")
    for y, (of, word) in enumerate(((run, "now"), (before, "before"))):
        left = 0.0
        steps = of.summary["element_steps"] / (of.summary["ranks"] * of.summary["threads"])
        for k, name in enumerate(parts_of):
            ns = 1e9 * of.summary["phases"].get(name, {"mean_s": 0})["mean_s"] / steps
            axes.barh(y, ns, left=left, height=0.6, color=("#c8a15a", "#3f6fa8", "#8e2f3f", "#8fb0d4")[k], label=name if y == 0 else None)
            if ns > 2:
                axes.text(left + 0.5 * ns, y, f"{ns:.0f}", color="white", ha="center", va="center", fontweight="bold")
            left += ns
    axes.set_yticks([0, 1], labels=["now", "before"])
    axes.set_xlabel("ns an element-step and core", color=INK, labelpad=3)
    bare(axes, "bottom")
    axes.tick_params(axis="y", length=0)
    axes.legend(frameon=False, labelcolor=INK, ncols=4, loc="lower left", bbox_to_anchor=(0, 1.0), columnspacing=1.2, handlelength=1)


def draw_cost(path, run, bench, scaling, before):
    more = [(draw, source) for draw, source in ((draw_search, bench), (draw_scaling, scaling)) if source]
    height = 3.1 + (1.9 if before else 0) + (3.4 if more else 0)
    figure = plt.figure(figsize=(9, height), facecolor="white")
    draw_split(figure.add_axes([0.19, 1 - 2.55 / height, 0.78, 1.45 / height]), run)
    if before:
        draw_before(figure.add_axes([0.19, 1 - 4.5 / height, 0.78, 0.9 / height]), run, loops.read(before))
    figure.text(0.02, 1 - 0.3 / height, "Where the time goes", color=INK, fontsize=13, va="center")
    for k, (draw, source) in enumerate(more):
        draw(figure.add_axes([0.09 + 0.5 * k, 0.6 / height, 0.39 if len(more) == 2 else 0.89, 2.4 / height]), source)
    figure.savefig(path, dpi=120, pil_kwargs={"optimize": True})
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="directory of a run's results")
    parser.add_argument("--area", type=float, help="of the base, m^2; default: the servo's")
    parser.add_argument("--beside", type=Path, help="another run, whose last cycle is drawn in grey")
    parser.add_argument("--before", type=Path, help="a run of another program, to compare costs with")
    parser.add_argument("--contact-bench", type=Path, help="JSON of bench_contact")
    parser.add_argument("--scaling", type=Path, help="table of bench/scenes/nest/nest.py")
    arguments = parser.parse_args()

    run = loops.read(arguments.run, arguments.area)
    figures = loops.measure(run)
    print(loops.table(figures))
    (arguments.run / "loops.json").write_text(json.dumps(figures, indent=2) + "\n")
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    if any(arguments.run.glob("trajectory_*.h5")):
        draw_nest(arguments.run / "nest.png", run, figures, loops.read(arguments.beside) if arguments.beside else None)
    if figures["cycles"]:
        draw_what_becomes(arguments.run / "work.png", run, figures)
    if run.summary:
        draw_cost(arguments.run / "cost.png", run, arguments.contact_bench, arguments.scaling, arguments.before)


if __name__ == "__main__":
    needs.in_words(main)
