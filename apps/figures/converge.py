#!/usr/bin/python3
"""Error against core-seconds: converge.py OUT_DIR, of `skein converge`

Draws OUT_DIR/converge.png from OUT_DIR/converge.json: a line for each observable through the runs of other elements, over its range; a
ring for the run of half the step. Observables that do not converge smoothly are dashed: their error is against the finest run. Needs
matplotlib.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout)

needs.need("matplotlib")
import matplotlib  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

from skein import style  # noqa: E402

COLOURS = ("#3b6fb6", "#c4574b", "#4f9d69", "#b08a2e", "#7d5ba6", "#2f8f9d", "#8a5a44", "#c06c9c")


def figures_of(out):
    needs.need_files(out, "converge.json")
    figures = json.loads((out / "converge.json").read_text())
    if figures.get("format") != "skein-converge":
        sys.exit(f"{out}: converge.json is not from skein converge")
    return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of skein converge")
    arguments = parser.parse_args()
    figures = figures_of(arguments.out)
    observables = [o for o in figures["observables"] if o["counts"]]
    if not observables:
        sys.exit(f"{arguments.out}: no observable changes, so there is nothing to draw")

    runs = figures["runs"]
    seconds = [run["core_seconds"] for run in runs]
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure, axes = plt.subplots(figsize=(6.4, 4.6), layout="constrained")
    for number, o in enumerate(observables):
        colour = COLOURS[number % len(COLOURS)]
        rough = o["convergence"] == "not smooth"
        error = [e / o["range"] for e in o["errors"]]
        shown = [k for k in range(3) if error[k] > 0]
        axes.loglog([seconds[k] for k in shown], [error[k] for k in shown], "--" if rough else "-", marker="o", markersize=4,
                    color=colour, label=o["name"])
        if len(error) > 3 and error[3] > 0:
            axes.loglog(seconds[3], error[3], "o", markersize=7, fillstyle="none", color=colour)
    for k, run in enumerate(runs[:3]):
        axes.axvline(seconds[k], color="#e4e7eb", linewidth=1, zorder=0)
        axes.annotate(f"{run['elements']} elements", (seconds[k], 1.01), xycoords=("data", "axes fraction"), ha="center", color=style.QUIET)
    axes.set(xlabel="core-seconds", ylabel="error over range")
    axes.legend(frameon=False, fontsize=8)
    style.bare(axes, "left", "bottom")
    if figures["title"]:
        style.heading(axes, figures["title"], pad=18)
    figure.savefig(arguments.out / "converge.png", dpi=150)


if __name__ == "__main__":
    needs.in_words(main)
