#!/usr/bin/env python3
"""Figures of error against work: work_precision.py TABLE [OUT]

Reads the table of `bench_work_precision --csv TABLE` and draws, in OUT (the table's folder where it is absent),
work_precision_CASE.png, one per case, error against core-seconds with one curve per configuration over n, and
work_precision.png, Skein's default against the published configuration in all of them. Needs numpy and matplotlib.
"""

import csv
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

TITLES = {
    "timoshenko": "Thick cantilever at rest: tip",
    "beam": "Slender cantilever let go: phase after a quarter period",
    "magnetised": "Magnetised cantilever at rest: tip",
    "cilium": "Driven damped cilia: tips over half a turn",
    "one_percent": "Thick cantilever: work to 1 %",
}
DEFAULT, PUBLISHED = dict(color="tab:blue", lw=2.6, zorder=5), dict(color="tab:red", lw=2.6, zorder=4)
OTHERS = ("tab:orange", "tab:green", "tab:purple", "tab:brown", "tab:pink", "tab:gray", "tab:olive", "tab:cyan")
CHOICES = ("law", "clamp", "damping", "integrator")
NUMBERS = ("dt", "error", "richardson_error", "richardson_error_estimate", "element_steps", "core_seconds")


class Curve:
    """Rows of one configuration, n rising."""

    def __init__(self, rows):
        self.rows = rows
        self.law, self.clamp, self.damping, self.integrator = (rows[0][key] for key in CHOICES)

    def column(self, key):
        return np.array([row[key] for row in self.rows])

    def default(self):
        return self.law == "incompressible" and self.clamp == "clamped" and self.damping in ("midpoint", "none") and self.integrator == "verlet"

    def published(self):
        return self.law == "elastica" and self.clamp == "clamped_frozen"

    def label(self, base):
        """What differs from the base curve."""
        names = [getattr(self, key) for key in CHOICES if getattr(self, key) != getattr(base, key)]
        if self.integrator == base.integrator:
            by_n = {row["n"]: row["dt"] for row in base.rows}
            ratio = [by_n[row["n"]] / row["dt"] for row in self.rows if row["n"] in by_n]
            if ratio and round(np.median(ratio)) > 1:
                names.append(f"dt/{round(np.median(ratio))}")
        return ", ".join(names).replace("_", " ") or "default"


def read(path):
    """Curves of each case in file order; a curve ends where a choice changes or n does not rise."""
    cases, before = {}, None
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            row["n"] = int(row["n"])
            row.update({key: float(row[key] or "nan") for key in NUMBERS})
            curves = cases.setdefault(row["case"], [])
            if before is None or any(before[key] != row[key] for key in ("case", *CHOICES)) or row["n"] <= before["n"]:
                curves.append([])
            curves[-1].append(row)
            before = row
    return {name: [Curve(rows) for rows in curves] for name, curves in cases.items()}


def finish(axes, name, x, y):
    axes.set_title(TITLES[name], fontsize=10)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(True, which="both", alpha=0.2)


def draw_curve(axes, curve, label, **style):
    axes.loglog(curve.column("core_seconds"), curve.column("error"), "o-", ms=3.5, label=label, **style)


def draw_richardson(axes, curve, label, color):
    """Error of the value extrapolated from n/2 and n, at the cost of both runs."""
    cost = curve.column("core_seconds")
    axes.loglog(cost[1:] + cost[:-1], curve.column("richardson_error")[1:], "s--", ms=3.5, lw=1.4, color=color, label=label)


def draw_work_to_one_percent(axes, curves):
    """Element-steps over n: default, default with the frozen clamp, published at the automatic and at its own step."""
    styles = (DEFAULT, dict(color="tab:green", lw=1.2, zorder=6), PUBLISHED, PUBLISHED | {"ls": "--"})
    for curve, style in zip(curves, styles):
        name = f"published, dt = {curve.rows[0]['dt'] * curve.rows[0]['n']:.2g} s/n" if curve.published() else curve.label(curves[0])
        axes.loglog(curve.column("n"), curve.column("element_steps"), marker="o", ms=3.5, label=name, **style)
    finish(axes, "one_percent", "elements n", "element-steps")


def draw_case(axes, name, curves, everything):
    if name == "one_percent":
        return draw_work_to_one_percent(axes, curves)
    base = curves[0]
    published = next(curve for curve in curves if curve.published())
    draw_curve(axes, base, "default", **DEFAULT)
    draw_richardson(axes, base, "default, Richardson", DEFAULT["color"])
    if everything:
        others = [curve for curve in curves[1:] if curve is not published]
        for curve, color in zip(others, OTHERS):
            draw_curve(axes, curve, curve.label(base), lw=1, color=color)
    draw_curve(axes, published, f"published: {published.label(base)}", **PUBLISHED)
    draw_richardson(axes, published, "published, Richardson", PUBLISHED["color"])
    finish(axes, name, "core-seconds", "error")


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__.strip())
    table = Path(sys.argv[1])
    out = Path(sys.argv[2]) if len(sys.argv) == 3 else table.parent
    out.mkdir(parents=True, exist_ok=True)
    cases = read(table)
    for name, curves in cases.items():
        fig, axes = plt.subplots(figsize=(8.4, 4.8))
        draw_case(axes, name, curves, everything=True)
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5))
        fig.tight_layout()
        fig.savefig(out / f"work_precision_{name}.png", dpi=90)
        plt.close(fig)
    fig, axes = plt.subplots(2, 3, figsize=(13, 7.4))
    for ax, (name, curves) in zip(axes.flat, cases.items()):
        draw_case(ax, name, curves, everything=False)
        if name == "one_percent":
            ax.legend(fontsize=8)
    for ax in axes.flat[len(cases):]:
        ax.axis("off")
    axes.flat[-1].legend(*axes.flat[0].get_legend_handles_labels(), loc="center")
    fig.tight_layout()
    fig.savefig(out / "work_precision.png", dpi=80)
    print(f"{len(cases) + 1} figures in {out}")


if __name__ == "__main__":
    main()
