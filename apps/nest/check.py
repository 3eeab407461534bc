#!/usr/bin/env python3
"""Figures of a nest against their bars: check.py [--full] [RUN ...] [--soft RUN ...] [--frictionless RUN ...] [--slow RUN ...]

  RUN, --hard      contacts so stiff that rods overlap by less than a tenth of their diameter, the scenes as they are
  --soft           contacts as published
  --frictionless   compared with the run with friction of the same stiffness and seed
  --slow           half the speed of the lid; likewise
  --full           the bars for 460 and 1536 rods; without it those for 110

Every role takes several runs, of several seeds say: a bar is met where all of them meet it. Figures are those of loops.py. Ends with code 1
where one is not met. A row without runs or without enough cycles is not measured.
"""

import argparse
import json
import math
import sys
from dataclasses import dataclass, field

import numpy as np

import loops

MM = 1e3


@dataclass
class Nest:
    """A run and what there is to say of it."""
    directory: str
    figures: dict
    stiffness: float
    seed: int

    def cycle(self, number, key):
        """Of cycle 1, 2, ...; not a number where there is none."""
        found = self.figures["cycles"]
        return found[number - 1][key] if number <= len(found) else math.nan

    def late(self, key):
        return [self.cycle(k, key) for k in (3, 4, 5)]


@dataclass
class Row:
    figure: str
    unit: str
    low: float
    high: float
    values: list = field(default_factory=list)

    def meets(self):
        return [self.low <= value <= self.high for value in self.values if not math.isnan(value)]

    @property
    def verdict(self):
        met = self.meets()
        if not met:
            return "not measured"
        if math.isinf(self.low) and math.isinf(self.high):
            return "reported"
        return "met" if all(met) else f"NOT MET{'' if len(met) == 1 else f' by {met.count(False)} of {len(met)}'}"

    @property
    def bar(self):
        if math.isinf(self.low):
            return "-" if math.isinf(self.high) else f"<= {self.high:g}"
        return f">= {self.low:g}" if math.isinf(self.high) else f"{self.low:g} to {self.high:g}"

    @property
    def measured(self):
        known = [value for value in self.values if not math.isnan(value)]
        if not known:
            return "-"
        if len(known) == 1:
            return f"{known[0]:.4g}"
        return f"{np.mean(known):.4g} ({min(known):.4g} to {max(known):.4g})"


def open_run(directory):
    run = loops.read(directory)
    seeds = [group["placement"]["seed"] for group in run.physics["rods"]]
    return Nest(str(directory), loops.measure(run), run.physics["contact"]["stiffness"], seeds[0])


def pairs(runs, others):
    """Runs with those of the same stiffness and seed among others."""
    return [(run, other) for run in runs for other in others if (run.stiffness, run.seed) == (other.stiffness, other.seed)]


def row(figure, runs, of, low=-math.inf, high=math.inf, unit=""):
    values = []
    for run in runs:
        value = of(*run) if isinstance(run, tuple) else of(run)
        values.append(math.nan if value is None else float(value))
    return Row(figure, unit, low, high, values)


def finite(runs):
    return row("finite (1: yes)", runs, lambda r: r.figures["finite"], 1, 1)


def overlap(runs, high=math.inf):
    return row("largest overlap over diameter", runs, lambda r: max(r.figures["overlap_rods"], r.figures["overlap_walls"]), high=high)


def open_budget(runs):
    return row("energy budget open by, of the lid's work", runs, lambda r: abs(r.figures["budget"]["defect_percent"]), high=2, unit="%")


def first_peak_ratio(smooth, rough):
    return smooth.cycle(1, "peak_height_m") / rough.cycle(1, "peak_height_m")


def mean_change(slow, usual, cycles):
    change = [slow.cycle(k, "psi") / usual.cycle(k, "psi") - 1 for k in cycles]
    return 100 * abs(np.mean(change))


def reduced(hard, soft, smooth, slow):
    yield "contacts so stiff that rods hardly overlap", [
        finite(hard), overlap(hard, 0.1), open_budget(hard),
        row("psi of cycle 1", hard, lambda r: r.cycle(1, "psi")),
        row("psi of cycle 2", hard, lambda r: r.cycle(2, "psi")),
        row("z at the first peak", hard, lambda r: r.cycle(1, "z_peak")),
        row("height at the first peak", hard, lambda r: MM * r.cycle(1, "peak_height_m"), unit="mm")]
    yield "contacts as published", [
        finite(soft),
        row("lid height at 822 Pa, first loading", soft, lambda r: MM * (r.figures["height_at_822_Pa_m"] or math.nan), 16.9, 20.9, "mm"),
        row("psi of cycle 1", soft, lambda r: r.cycle(1, "psi"), 0.08, 0.20),
        row("psi of cycle 2", soft, lambda r: r.cycle(2, "psi"), 0.04, 0.11),
        row("psi of cycle 2 over that of cycle 1", soft, lambda r: r.cycle(2, "psi") / r.cycle(1, "psi"), high=1),
        row("lower turning height, cycle 2 from 1", soft, lambda r: MM * abs(r.cycle(2, "peak_height_m") - r.cycle(1, "peak_height_m")), high=0.5, unit="mm"),
        row("upper turning height, cycle 2 from 1", soft, lambda r: MM * abs(r.cycle(2, "end_height_m") - r.cycle(1, "end_height_m")), high=0.5, unit="mm"),
        row("z at low stress, cycle 1", soft, lambda r: r.cycle(1, "z_low")),
        row("z at the first peak", soft, lambda r: r.cycle(1, "z_peak"), 6, 8.5),
        overlap(soft), open_budget(soft)]
    yield "without friction", [
        row(f"first peak's height over that with friction, {name}", pairs(smooth, rough), first_peak_ratio, high=0.8)
        for name, rough in (("stiff", hard), ("as published", soft))]
    yield "lid at half the speed", [
        row(f"psi of cycle {k} changes by", pairs(slow, hard + soft), lambda s, r, k=k: mean_change(s, r, (k,)), unit="%") for k in (1, 2)]


def full(hard, soft, smooth, slow):
    psi = "psi of cycles 3 to 5"
    yield "(a) finite, little overlap", [finite(hard + soft), overlap(hard, 0.1), overlap(soft)]
    yield "(b) coordination", [
        row("z at the last peak, stiff", hard, lambda r: r.cycle(len(r.figures["cycles"]), "z_peak")),
        row("z at the last peak, as published", soft, lambda r: r.cycle(len(r.figures["cycles"]), "z_peak"), 6, 8.5)]
    yield "(c) a loop that friction makes", [
        row(f"{psi}, least", hard, lambda r: np.min(r.late("psi")), 0.02, 0.4),
        row(f"{psi}, most", hard, lambda r: np.max(r.late("psi")), 0.02, 0.4),
        row(f"{psi}, furthest from their mean", hard, lambda r: 100 * np.max(np.abs(np.array(r.late("psi")) / np.mean(r.late("psi")) - 1)), high=15, unit="%"),
        row("first peak's height without friction over that with", pairs(smooth, hard + soft), first_peak_ratio, high=0.8)]
    yield "(d) plasticity that fades", [
        # Above three times, or no loss at all in the last cycle.
        row("a third of cycle 1's residual less cycle 5's", hard, lambda r: MM * (r.cycle(1, "residual_m") / 3 - r.cycle(5, "residual_m")), low=0, unit="mm")]
    yield "(e) no matter how fast", [
        row(f"{psi} change at half the speed by", pairs(slow, hard + soft), lambda s, r: mean_change(s, r, (3, 4, 5)), high=20, unit="%")]
    yield "(f) energy", [open_budget(hard), open_budget(soft)]
    yield "(g) run time", [row("share of the rods", hard + soft, lambda r: 100 * r.figures["rod_share"] if r.figures["rod_share"] else math.nan, unit="%")]


def show(blocks):
    print(f"{'':<54}{'bar':>14}{'measured':>34}  verdict")
    for title, rows in blocks:
        print(title)
        for r in rows:
            name = f"  {r.figure}" + (f" [{r.unit}]" if r.unit else "")
            print(f"{name:<54}{r.bar:>14}{r.measured:>34}  {r.verdict}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="*", default=[], metavar="RUN")
    for role in ("hard", "soft", "frictionless", "slow"):
        parser.add_argument(f"--{role}", nargs="+", default=[], metavar="RUN")
    parser.add_argument("--full", action="store_true", help="the bars for 460 and 1536 rods")
    parser.add_argument("--json", help="where to write the rows")
    arguments = parser.parse_args()
    roles = [[open_run(d) for d in chosen] for chosen in (arguments.runs + arguments.hard, arguments.soft, arguments.frictionless, arguments.slow)]
    if not any(roles):
        parser.error("no runs")
    blocks = list((full if arguments.full else reduced)(*roles))
    show(blocks)
    if arguments.json:
        rows = [dict(vars(r), bar=r.bar, verdict=r.verdict, group=title) for title, found in blocks for r in found]
        for r in rows:
            for key in ("low", "high"):
                r[key] = r[key] if math.isfinite(r[key]) else None  # JSON has no infinity
            r["values"] = [None if math.isnan(value) else value for value in r["values"]]
        with open(arguments.json, "w") as file:
            json.dump(rows, file, indent=2)
    sys.exit(any(r.verdict.startswith("NOT") for _, found in blocks for r in found))


if __name__ == "__main__":
    main()
