#!/usr/bin/env python3
"""Error of a nest's figures against what they cost: steps.py RUN [RUN ...] [--to PNG]

Runs of one scene with several steps, each with several seeds: rods are chaotic, so means over seeds are compared, with what single seeds
scatter about them. The error of a step is the distance of its mean from that of the finest step among runs with the same rotary
inertia as published (rotary_inertia_scale 1), or from the finest of all where there is none. Prints a table of height at the first peak and psi of cycle 1, and of core-seconds;
--to draws it. Needs numpy, and matplotlib for --to.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy")
import numpy as np  # noqa: E402

import loops  # noqa: E402

FIGURES = {"peak_height_m": ("height at the first peak", 1e3, "mm"), "psi": ("psi of cycle 1", 1, "-")}


def schemes(directories):
    """{(rotary inertia scale, dt s): [(core-seconds, figures of cycle 1)] by seed}."""
    found = {}
    for directory in directories:
        run = loops.read(directory)
        cycles = loops.measure(run)["cycles"]
        if not cycles or not run.summary:
            raise SystemExit(f"{directory}: the run has no whole cycle, or has not ended")
        cores = run.summary["ranks"] * run.summary["threads"]
        scale = run.physics["rods"][0]["material"]["rotary_inertia_scale"]
        found.setdefault((scale, run.summary["dt_s"]), []).append((run.summary["wall_s"] * cores, cycles[0]))
    return found


def reference(found):
    published = [key for key in found if key[0] == 1]
    return min(published or found, key=lambda key: key[1])


def rows(found):
    best = {key: np.mean([figures[key] for _, figures in found[reference(found)]]) for key in FIGURES}
    for scheme in sorted(found, key=lambda key: (-key[0], -key[1])):
        runs = found[scheme]
        row = {"scale": scheme[0], "dt": scheme[1], "seeds": len(runs), "core_s": float(np.mean([seconds for seconds, _ in runs])), "reference": scheme == reference(found)}
        for key in FIGURES:
            values = np.array([figures[key] for _, figures in runs])
            spread = float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else float("nan")
            row[key] = float(values.mean()), spread, float(values.mean() - best[key])
        yield row


def table(all_rows):
    lines = [f"{'dt [us]':>8}{'inertia':>9}{'seeds':>7}{'core-s':>9}" + "".join(f"{word + ' [' + unit + ']':>34}{'off by':>10}" for word, _, unit in FIGURES.values())]
    for row in all_rows:
        line = f"{1e6 * row['dt']:>8.3g}{row['scale']:>9.3g}{row['seeds']:>7}{row['core_s']:>9.0f}"
        for key, (_, factor, _) in FIGURES.items():
            mean, spread, off = (factor * value for value in row[key])
            line += f"{f'{mean:.4g} +- {spread:.2g}' if row['seeds'] > 1 else f'{mean:.4g}':>34}{off:>10.2g}"
        lines.append(line)
    return "\n".join(lines)


def draw(path, all_rows):
    needs.need("matplotlib")
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter
    from skein.style import INK, bare, heading
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure, axes = plt.subplots(1, len(FIGURES), figsize=(9, 3.4), layout="constrained")
    for panel, (key, (word, factor, unit)) in zip(axes, FIGURES.items()):
        for row in all_rows:
            mean, spread, _ = (factor * value for value in row[key])
            colour = "#b8563b" if row["scale"] == 1 else "#3f6fa8"
            panel.errorbar(row["core_s"], mean, yerr=spread if row["seeds"] > 1 else None, color=colour, marker="o", capsize=3, ms=5)
            panel.annotate(f"{1e6 * row['dt']:.2g} µs" + (", true inertia" if row["scale"] == 1 else ""), (row["core_s"], mean), (5, 5), textcoords="offset points", color=colour)
        panel.set_xscale("log")
        panel.xaxis.set_major_locator(FixedLocator(sorted({round(row["core_s"]) for row in all_rows})))
        panel.xaxis.set_major_formatter(ScalarFormatter())
        panel.xaxis.set_minor_locator(NullLocator())
        panel.margins(x=0.25, y=0.3)
        panel.set_xlabel("core-seconds", color=INK)
        panel.set_ylabel(f"{word} [{unit}]", color=INK)
        bare(panel, "left", "bottom")
        heading(panel, f"{word}, mean of seeds and its error")
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN")
    parser.add_argument("--to", type=Path, help="picture to draw")
    arguments = parser.parse_args()
    all_rows = list(rows(schemes(arguments.runs)))
    print(table(all_rows))
    if arguments.to:
        draw(arguments.to, all_rows)


if __name__ == "__main__":
    needs.in_words(main)
