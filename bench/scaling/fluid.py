#!/usr/bin/env python3
"""Strong and weak scaling of the fluid over ranks and threads, with what a rank sends beside its time.

    bench/scaling/fluid.py --csv out/fluid_scaling.csv
    bench/scaling/fluid.py --cells 960 640 640 --layouts 1x16 2x16 4x16 8x16 --csv ...         on a cluster

Runs fluid_box.toml on every layout, repeats in turn, and takes medians. Strong scaling keeps the cells; weak scaling takes planes along z in
proportion to cores, so its largest layout is that of strong scaling. A step is one of the fluid. `columns` and `ghosts` are what a
rank sends in a step, as `skein plan` tells; `GB/s` is both over the time of the step, which is what the network has to carry at least.
Ends with code 1 where layouts disagree in a digest.
"""

import re
import subprocess

import study

UNITS = {"B": 1, "kB": 1e3, "MB": 1e6, "GB": 1e9}


class Box(study.Configuration):
    """Cells along x, y and z."""

    @staticmethod
    def step_seconds(summary):
        return summary["phases"]["fluid"]["mean_s"] / summary["observables"]["fluid_steps[-]"]

    def settings(self, exchange):
        return ["--set", "fluid.cells=[{},{},{}]".format(*self.counts), "--set", f"fluid.pressure_exchange={exchange}"]

    def told(self):
        return f"{self.study} {self.ranks}x{self.threads}: {1e3 * self.step_seconds(self.samples[-1]):.1f} ms a step"


def sent_bytes(args, box):
    """What a rank sends in a step for columns of coefficients and as ghosts, by the plan; nothing where there is one rank."""
    command = [args.skein, "plan", "-v", args.scene, "--ranks", str(box.ranks), "--threads", str(box.threads), *box.settings(args.exchange)]
    plan = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found = re.search(r"by a rank in a step: ([\d.]+) (\w+) (?:in transposes|at interfaces) \([^)]*\), ([\d.]+) (\w+) as ghosts", plan)
    if box.ranks > 1 and not found:
        raise RuntimeError(f"skein plan does not print what {box.ranks} ranks send:\n{plan}")
    return (float(found[1]) * UNITS[found[2]], float(found[3]) * UNITS[found[4]]) if found else (0.0, 0.0)


def table(args, boxes):
    most = max(box.cores for box in boxes)
    for name in args.studies:
        own = sorted((box for box in boxes if box.study == name or (name == "weak" and box.cores == most)), key=lambda box: box.cores)
        base = own[0]
        serial = study.serial_fraction(base, own) if name == "strong" else float("nan")
        for box in own:
            cells = box.counts[0] * box.counts[1] * box.counts[2]
            work, base_work = box.step_s() / cells, base.step_s() / (base.counts[0] * base.counts[1] * base.counts[2])
            columns, ghosts = sent_bytes(args, box)
            yield {"study": name, "ranks": box.ranks, "threads": box.threads, "cells": "x".join(map(str, box.counts)), "repeats": len(box.samples),
                   **box.times(), "ns_per_cell_step_and_core": f"{1e9 * work * box.cores:.4g}",
                   "speedup": f"{base_work / work:.4g}", "efficiency": f"{base_work / work * base.cores / box.cores:.4g}",
                   "serial_fraction": f"{serial:.3g}" if name == "strong" else "", "columns_bytes": f"{columns:.4g}", "ghosts_bytes": f"{ghosts:.4g}",
                   "other_programs_cores": box.others_cores(), "digest": box.samples[0]["digest"]}


def show(rows):
    print(f"\n{'study':<7}{'layout':>7}{'cells':>15}{'ms a step':>11}{'ns':>7}{'speedup':>9}{'efficiency':>11}{'columns':>12}{'ghosts':>9}{'GB/s':>7}{'others':>8}"
          "\n(ns: per cell, step and core; columns, ghosts: MB that a rank sends in a step; others: cores that other programs took)")
    for row in rows:
        sent = float(row["columns_bytes"]), float(row["ghosts_bytes"])
        print(f"{row['study']:<7}{row['ranks']:>4}x{row['threads']:<2}{row['cells']:>15}{1e3 * float(row['step_s']):>11.1f}{row['ns_per_cell_step_and_core']:>7}"
              f"{row['speedup']:>9}{row['efficiency']:>11}{1e-6 * sent[0]:>12.2f}{1e-6 * sent[1]:>9.2f}{1e-9 * sum(sent) / float(row['step_s']):>7.2f}{row['other_programs_cores']:>8}")


def main():
    parser = study.parser_of(__doc__, "fluid_box.toml")
    parser.add_argument("--cells", type=int, nargs=3, metavar=("NX", "NY", "NZ"), default=(128, 128, 128))
    parser.add_argument("--exchange", default="transposes", choices=["transposes", "interfaces"], help="fluid.pressure_exchange; of the second digests depend on ranks")
    args = parser.parse_args()

    boxes = study.planned(args, args.cells, Box)
    show(study.measure(args, boxes, lambda box: [args.scene, *box.settings(args.exchange)], lambda: table(args, boxes), Box.told))
    study.check_digests(boxes, lambda box: (box.counts, box.ranks if args.exchange == "interfaces" else 0))


if __name__ == "__main__":
    main()
