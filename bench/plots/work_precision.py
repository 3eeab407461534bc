#!/usr/bin/env python3
"""Figures of error against work: work_precision.py TABLE [OUT]

Reads the table of `bench_work_precision --csv TABLE` and draws, in OUT (the table's folder where it is absent),
work_precision_CASE.png, one per case, error against core-seconds with one curve per configuration over its ladder, and
work_precision.png, Skein's default against the published configuration in all of them, and PEFRL where the question is the step.
Needs numpy and matplotlib.
"""

import csv
import sys
import textwrap
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)
from matplotlib.ticker import LogLocator, NullFormatter  # noqa: E402

# What is looked at, and what its error is in.
CASES = {
    "timoshenko": ("Thick cantilever at rest: tip", "error / deflection"),
    "magnetised": ("Magnetised cantilever at rest: tip", "error / deflection"),
    "large_rotation": ("Large tip load in 3-D: tip", "error / length"),
    "bend": ("45-degree bend under a tip load: tip", "error / length"),
    "axial_stretching": ("Stretched by half: end", "error / extension"),
    "catenary": ("Catenary: line", "error / length"),
    "euler_buckling": ("Euler buckling: critical load", "relative error"),
    "helical_buckling": ("Helical buckling: envelope", "error"),
    "bending_mode_0": ("Cantilever, mode 0: phase", "error (rad)"),
    "bending_mode_1": ("Cantilever, mode 1: phase", "error (rad)"),
    "axial_wave": ("Axial wave: phase", "error (rad)"),
    "torsional_wave": ("Torsional wave: phase", "error (rad)"),
    "free_rod": ("Free rod, n = 20, dt falls: energy", "largest change / start"),
    "butterfly": ("Butterfly, n = 10, dt falls: energy", "largest change / start"),
    "top": ("Elliptic top, dt falls: directors", "error"),
    "cilium": ("Driven damped cilia: tips", "error / length"),
    "one_percent": ("Thick cantilever: work to 1 %", "element-steps"),
}
DEFAULT, PUBLISHED = dict(color="tab:blue", lw=2.6, zorder=5), dict(color="tab:red", lw=2.6, zorder=4)
OTHERS = ("tab:orange", "tab:green", "tab:purple", "tab:brown", "tab:pink", "tab:gray", "tab:olive", "tab:cyan")
NUMBERS = ("dt", "error", "richardson_error", "richardson_error_estimate", "element_steps", "core_seconds")
EXACT = 1e-14  # round-off


class Curve:
    """Rows of one configuration, work rising."""

    def __init__(self, rows):
        self.rows = rows
        self.name = rows[0]["configuration"].replace("_", " ")

    def column(self, key):
        return np.array([row[key] for row in self.rows])

    def like(self, other):
        """Whether the two lie on each other in a figure, but for the few per cent between the times of two laws."""
        return all(np.allclose(self.column(key), other.column(key), rtol=0.05, atol=0) for key in ("error", "element_steps"))

    def fate(self):
        """What a logarithmic axis does not show."""
        if np.isinf(self.column("error")).any():
            return " (lost where missing)"
        return " (exact, not shown)" if (self.column("error") < EXACT).all() else ""


def read(path):
    """Curves of each case in file order."""
    cases = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            row["n"] = int(row["n"])
            row.update({key: float(row[key] or "nan") for key in NUMBERS})
            cases.setdefault(row["case"], {}).setdefault(row["configuration"], []).append(row)
    return {name: [Curve(rows) for rows in curves.values()] for name, curves in cases.items()}


def finish(axes, name, x):
    title, y = CASES[name]
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=8)
    low, high = axes.get_xlim()
    if high < 100 * low:  # powers of ten alone would leave one label or none
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", alpha=0.25)


def draw_curve(axes, curve, label, **style):
    error = np.where(np.isfinite(curve.column("error")) & (curve.column("error") > EXACT), curve.column("error"), np.nan)
    axes.loglog(curve.column("core_seconds"), error, "o-", ms=3.5, label=label, **style)


def draw_richardson(axes, curve, label, color):
    """Error of the value extrapolated from one rung and the next, at the cost of both runs."""
    cost, error = curve.column("core_seconds"), curve.column("richardson_error")
    if np.nanmax(error[1:], initial=0) > EXACT:
        axes.loglog(cost[1:] + cost[:-1], error[1:], "s--", ms=3.5, lw=1.4, color=color, label=label)


def draw_work_to_one_percent(axes, curves):
    """Element-steps over n: default, default with the frozen clamp, published at the automatic and at its own step."""
    styles = (DEFAULT, dict(color="tab:green", lw=1.2, zorder=6), PUBLISHED, PUBLISHED | {"ls": "--"})
    for curve, style in zip(curves, styles):
        row = curve.rows[0]
        name = f"{curve.name.split(' dt')[0]}, dt = {row['dt'] * row['n']:.2g} s/n" if "published" in curve.name else curve.name
        axes.loglog(curve.column("n"), curve.column("element_steps"), marker="o", ms=3.5, label=name, **style)
    finish(axes, "one_percent", "elements n")


def draw_case(axes, name, curves, everything):
    """All curves, those that lie on the default's or the published one under its name; or these two alone."""
    if name == "one_percent":
        return draw_work_to_one_percent(axes, curves)
    base, *others, published = curves
    in_step = len({row["n"] for row in base.rows}) == 1
    near = {base: [other for other in others if everything and other.like(base)]}
    near[published] = [other for other in others if everything and other.like(published) and other not in near[base]]

    def label(curve):
        also = [other.name for other in near[curve]]
        return textwrap.fill(curve.name + (f" (also {', '.join(also)})" if also else "") + (curve.fate() if everything else ""), 34)

    draw_curve(axes, base, label(base), **DEFAULT)
    draw_richardson(axes, base, "default, Richardson", DEFAULT["color"])
    if everything:
        alone = [curve for curve in others if curve not in near[base] + near[published]]
        for curve, color in zip(alone, OTHERS):
            draw_curve(axes, curve, curve.name + curve.fate(), lw=1.3, color=color)
    elif in_step:
        draw_curve(axes, next(curve for curve in others if curve.name == "pefrl"), "pefrl", lw=1.3, color="tab:green")
    draw_curve(axes, published, label(published), **PUBLISHED)
    draw_richardson(axes, published, "published, Richardson", PUBLISHED["color"])
    finish(axes, name, "core-seconds")


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    table = Path(sys.argv[1])
    out = Path(sys.argv[2]) if len(sys.argv) == 3 else table.parent
    out.mkdir(parents=True, exist_ok=True)
    cases = read(table)
    for name, curves in cases.items():
        fig, axes = plt.subplots(figsize=(8.4, 4.4), layout="constrained")
        draw_case(axes, name, curves, everything=True)
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5))
        fig.savefig(out / f"work_precision_{name}.png", dpi=80)
        plt.close(fig)
    rows = -(-(len(cases) + 1) // 3)
    fig, axes = plt.subplots(rows, 3, figsize=(11.7, 2.9 * rows), layout="constrained", squeeze=False)
    legend = {}
    for ax, (name, curves) in zip(axes.flat, cases.items()):
        draw_case(ax, name, curves, everything=False)
        if name == "one_percent":
            ax.legend(fontsize=8)
        else:
            legend |= {label: handle for handle, label in zip(*ax.get_legend_handles_labels())}
    for ax in axes.flat[len(cases):]:
        ax.axis("off")
    axes.flat[len(cases)].legend(legend.values(), legend.keys(), loc="center")
    fig.savefig(out / "work_precision.png", dpi=80)
    print(f"{len(cases) + 1} figures in {out}")


if __name__ == "__main__":
    main()
