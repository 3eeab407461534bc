#!/usr/bin/env python3
"""Strong and weak scaling of the fluid over ranks and threads, with what a rank sends beside its time.

    bench/scaling/fluid.py --csv out/fluid_scaling.csv
    bench/scaling/fluid.py --cells 960 640 640 --layouts 1x16 2x16 4x16 8x16 --csv ...         on a cluster

Runs fluid_box.toml on every layout, repeats in turn, and takes medians. Strong scaling keeps the cells; weak scaling takes planes along z in
proportion to cores, so its largest layout is that of strong scaling. A step is one of the fluid. `columns` and `ghosts` are what a
rank sends in a step, as `skein plan` tells; `GB/s` is both over the time of the step, which is what the network has to carry at least.
Ends with code 1 where layouts disagree in a digest.
"""

import argparse
import csv
import json
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from scaling import HERE, Configuration, busy_seconds, own_seconds, serial_fraction, wait_for_quiet

UNITS = {"B": 1, "kB": 1e3, "MB": 1e6, "GB": 1e9}


class Box(Configuration):
    """A configuration whose counts are cells along x, y and z."""

    def step_s(self):
        return self.median(step_seconds)

    def settings(self):
        return ["--set", "fluid.cells=[{},{},{}]".format(*self.counts)]


def step_seconds(summary):
    return summary["phases"]["fluid"]["mean_s"] / summary["observables"]["fluid_steps[-]"]


def configurations(args):
    nx, ny, nz = args.cells
    layouts = [tuple(int(n) for n in layout.split("x")) for layout in args.layouts]
    most = max(ranks * threads for ranks, threads in layouts)
    out = [Box("strong", "", *layout, (nx, ny, nz)) for layout in layouts]
    if "weak" in args.studies:
        out += [Box("weak", "", *layout, (nx, ny, nz * layout[0] * layout[1] // most)) for layout in layouts if layout[0] * layout[1] < most]
    return out


def sent_bytes(args, box):
    """What a rank sends in a step for columns of coefficients and as ghosts, by the plan; nothing where there is one rank."""
    command = [args.skein, "plan", args.scene, "--ranks", str(box.ranks), "--threads", str(box.threads), *box.settings(), "--set", f"fluid.pressure_exchange={args.exchange}"]
    plan = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found = re.search(r"sent +by a rank in a step: ([\d.]+) (\w+) (?:in transposes|at interfaces) \([^)]*\), ([\d.]+) (\w+) as ghosts", plan)
    return (float(found[1]) * UNITS[found[2]], float(found[3]) * UNITS[found[4]]) if found else (0.0, 0.0)


def run(args, box, out):
    launch = shlex.split(args.launch.format(ranks=box.ranks, threads=box.threads))
    command = [*launch, args.skein, "run", args.scene, *box.settings(), "--set", f"fluid.pressure_exchange={args.exchange}", "--threads", str(box.threads), "--out", out, "--overwrite", "--no-checkpoint", "--quiet"]
    wait_for_quiet(args.patience)
    start, busy, own = time.monotonic(), busy_seconds(), own_seconds()
    subprocess.run(command, check=True)
    summary = json.loads((Path(out) / "summary.json").read_text())
    summary["others"] = max(0.0, busy_seconds() - busy - (own_seconds() - own)) / (time.monotonic() - start)
    return summary


def table(args, boxes):
    most = max(box.cores for box in boxes)
    for study in args.studies:
        own = sorted((box for box in boxes if box.study == study or (study == "weak" and box.cores == most)), key=lambda box: box.cores)
        base = own[0]
        serial = serial_fraction(base, own) if study == "strong" else float("nan")
        for box in own:
            cells = box.counts[0] * box.counts[1] * box.counts[2]
            work, base_work = box.step_s() / cells, base.step_s() / (base.counts[0] * base.counts[1] * base.counts[2])
            columns, ghosts = sent_bytes(args, box)
            yield {"study": study, "ranks": box.ranks, "threads": box.threads, "cells": "x".join(map(str, box.counts)), "repeats": len(box.samples),
                   "step_s": f"{box.step_s():.5g}", "least_step_s": f"{min(map(step_seconds, box.samples)):.5g}",
                   "most_step_s": f"{max(map(step_seconds, box.samples)):.5g}", "ns_per_cell_step_and_core": f"{1e9 * work * box.cores:.4g}",
                   "speedup": f"{base_work / work:.4g}", "efficiency": f"{base_work / work * base.cores / box.cores:.4g}",
                   "serial_fraction": f"{serial:.3g}" if study == "strong" else "", "columns_bytes": f"{columns:.4g}", "ghosts_bytes": f"{ghosts:.4g}",
                   "other_programs_cores": f"{box.median(lambda sample: sample['others']):.3f}", "digest": box.samples[0]["digest"]}


def show(rows):
    print(f"\n{'study':<7}{'layout':>7}{'cells':>15}{'ms a step':>11}{'ns':>7}{'speedup':>9}{'efficiency':>11}{'columns':>12}{'ghosts':>9}{'GB/s':>7}{'others':>8}"
          "\n(ns: per cell, step and core; columns, ghosts: MB that a rank sends in a step; others: cores that other programs took)")
    for row in rows:
        sent = float(row["columns_bytes"]), float(row["ghosts_bytes"])
        print(f"{row['study']:<7}{row['ranks']:>4}x{row['threads']:<2}{row['cells']:>15}{1e3 * float(row['step_s']):>11.1f}{row['ns_per_cell_step_and_core']:>7}"
              f"{row['speedup']:>9}{row['efficiency']:>11}{1e-6 * sent[0]:>12.2f}{1e-6 * sent[1]:>9.2f}{1e-9 * sum(sent) / float(row['step_s']):>7.2f}{row['other_programs_cores']:>8}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", required=True, help="file for the table")
    parser.add_argument("--skein", default=str(HERE.parents[1] / "build/bin/skein"), help="program")
    parser.add_argument("--scene", default=str(HERE / "fluid_box.toml"))
    parser.add_argument("--cells", type=int, nargs=3, metavar=("NX", "NY", "NZ"), default=(128, 128, 128))
    parser.add_argument("--layouts", nargs="+", default=["1x1", "1x2", "2x1"], help="ranks x threads")
    parser.add_argument("--studies", nargs="+", default=["strong", "weak"], choices=["strong", "weak"])
    parser.add_argument("--exchange", default="transposes", choices=["transposes", "interfaces"], help="fluid.pressure_exchange; of the second digests depend on ranks")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--launch", default="mpirun -n {ranks} --map-by slot:PE={threads} --bind-to core", help="launcher of {ranks} ranks of {threads} threads")
    parser.add_argument("--patience", type=float, default=30, help="longest wait for a quiet machine before a run, s")
    args = parser.parse_args()

    boxes = configurations(args)
    Path("out").mkdir(exist_ok=True)  # here, because every node must see it
    with tempfile.TemporaryDirectory(dir="out") as out:
        for repeat in range(args.repeats):
            for box in boxes:
                box.samples.append(run(args, box, out))
                print(f"{repeat + 1}/{args.repeats} {box.study} {box.ranks}x{box.threads}: {1e3 * step_seconds(box.samples[-1]):.1f} ms a step", flush=True)
            rows = list(table(args, boxes))  # after every repeat: a job may end before the last
            with open(args.csv, "w", newline="") as file:
                writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
    show(rows)
    digests = {}
    for box in boxes:
        digests.setdefault((box.counts, box.ranks if args.exchange == "interfaces" else 0), set()).update(sample["digest"] for sample in box.samples)
    if any(len(found) > 1 for found in digests.values()):
        sys.exit("digests differ")


if __name__ == "__main__":
    main()
