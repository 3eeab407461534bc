#!/usr/bin/env python3
"""Strong and weak scaling of 1024 x 1024 rods, as in the Elastica++ paper, over ranks x threads, by both protocols.

  scaling.py --csv FILE [--layouts 1x1 1x2 2x1] [--steps 64] [--repeats 5] [--launch "mpirun -n {ranks} ..."]

Strong: the scene on every layout (ranks x threads). Weak: rods in proportion to the cores, so that the largest layout has the whole
scene. Every repeat runs each configuration once, in turn, so that a busy machine slows all alike; the table holds medians. A step's
time is that of its passes and of meeting other ranks (phases `rods` and `agree` of summary.json); reading, placing and writing are not
in it. Speedups are over the first layout's core count, and Amdahl's serial fraction s is fitted to T(p) = T(1) (s + (1-s)/p).
Ends with code 1 where layouts or protocols disagree in a digest.
"""

import argparse
import csv
import json
import re
import resource
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
PHASES = ("setup", "rods", "agree", "observe", "output")


@dataclass
class Configuration:
    study: str
    protocol: str
    ranks: int
    threads: int
    counts: tuple
    samples: list = field(default_factory=list)  # summary.json of each repeat, with "others"

    @property
    def cores(self):
        return self.ranks * self.threads

    def median(self, of):
        return statistics.median(of(sample) for sample in self.samples)

    def step_s(self):
        return self.median(step_seconds)

    def phase_s(self, phase):
        return self.median(lambda sample: sample["phases"][phase]["max_s" if phase == "rods" else "mean_s"])


def step_seconds(summary):
    return (summary["phases"]["rods"]["mean_s"] + summary["phases"]["agree"]["mean_s"]) / summary["steps"]


def lattice(scene):
    """Rods along x and y, as the scene has them."""
    return tuple(int(n) for n in re.search(r"^counts = \[(\d+), (\d+)\]", Path(scene).read_text(), re.MULTILINE).groups())


def configurations(args):
    nx, ny = args.counts or lattice(args.scene)
    layouts = [tuple(int(n) for n in layout.split("x")) for layout in args.layouts]
    most = max(ranks * threads for ranks, threads in layouts)
    out = [Configuration("strong", protocol, *layout, (nx, ny)) for layout in layouts for protocol in args.protocols]
    if "weak" in args.studies:
        smaller = [layout for layout in layouts if layout[0] * layout[1] < most]
        out += [Configuration("weak", protocol, *layout, (nx, max(1, ny * layout[0] * layout[1] // most))) for layout in smaller for protocol in args.protocols]
    return out


def busy_seconds():
    """Processor time that all programs of this machine have taken, as far as it tells."""
    try:
        user, nice, system, _, _, irq, softirq, steal = (int(n) for n in Path("/proc/stat").read_text().split(None, 9)[1:9])
        return 0.01 * (user + nice + system + irq + softirq + steal)
    except (OSError, ValueError):
        return 0.0


def own_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def wait_for_quiet(seconds):
    """Until others take less than a twentieth of a core, but not longer than told."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        before = busy_seconds()
        time.sleep(2)
        if busy_seconds() - before < 0.1:
            return


def run(args, configuration, out):
    launch = shlex.split(args.launch.format(ranks=configuration.ranks, threads=configuration.threads))
    command = [*launch, args.skein, "run", args.scene, "--set", f"rods.0.placement.counts=[{configuration.counts[0]},{configuration.counts[1]}]",
               "--threads", str(configuration.threads), "--protocol", configuration.protocol, "--steps", str(args.steps), "--out", out,
               "--overwrite", "--no-checkpoint", "--quiet"]
    wait_for_quiet(args.patience)
    start, busy, own = time.monotonic(), busy_seconds(), own_seconds()
    subprocess.run(command, check=True)
    summary = json.loads((Path(out) / "summary.json").read_text())
    summary["others"] = max(0.0, busy_seconds() - busy - (own_seconds() - own)) / (time.monotonic() - start)
    return summary


def serial_fraction(base, rows):
    """Least squares of T(p)/T(1) - 1/p = s (1 - 1/p), p the cores over those of `base`."""
    pairs = [(1 - base.cores / row.cores, row.step_s() / base.step_s() - base.cores / row.cores) for row in rows if row.cores > base.cores]
    norm = sum(x * x for x, _ in pairs)
    return sum(x * y for x, y in pairs) / norm if norm else float("nan")


def table(all_rows):
    """Rows of the CSV, in the order of the configurations; weak scaling shares its largest layouts with strong."""
    most = max(row.cores for row in all_rows)
    for study in ("strong", "weak"):
        for protocol in dict.fromkeys(row.protocol for row in all_rows):
            rows = [row for row in all_rows if row.protocol == protocol and (row.study == study or (study == "weak" and row.cores == most))]
            rows.sort(key=lambda row: row.cores)
            if all(row.study != study for row in rows):
                continue
            base = rows[0]
            serial = serial_fraction(base, rows) if study == "strong" else float("nan")
            for row in rows:
                sample = row.samples[0]
                work = row.step_s() / sample["elements"]  # s per element-step
                speedup = base.step_s() / base.samples[0]["elements"] / work
                yield {"study": study, "protocol": protocol, "ranks": row.ranks, "threads": row.threads, "rods": sample["rods"],
                       "elements": sample["elements"], "steps": sample["steps"], "repeats": len(row.samples),
                       "step_s": f"{row.step_s():.5g}", "least_step_s": f"{min(map(step_seconds, row.samples)):.5g}",
                       "most_step_s": f"{max(map(step_seconds, row.samples)):.5g}",
                       "ns_per_element_step_and_core": f"{1e9 * work * row.cores:.4g}", "speedup": f"{speedup:.4g}",
                       "efficiency": f"{speedup * base.cores / row.cores:.4g}", "serial_fraction": f"{serial:.3g}" if study == "strong" else "",
                       **{f"{phase}_s": f"{row.phase_s(phase):.4g}" for phase in PHASES},
                       "other_programs_cores": f"{row.median(lambda sample: sample['others']):.3f}", "digest": sample["digest"]}


def show(rows):
    print(f"\n{'study':<7}{'protocol':<14}{'layout':>7}{'rods':>10}{'ms a step':>11}{'ns':>8}{'speedup':>9}{'efficiency':>11}{'agree':>8}{'others':>8}  digest"
          "\n(ns: per element-step and core; agree: share of a step spent waiting for other ranks; others: cores that other programs took)")
    for row in rows:
        agree = float(row["agree_s"]) / row["steps"] / float(row["step_s"])
        print(f"{row['study']:<7}{row['protocol']:<14}{row['ranks']:>4}x{row['threads']:<2}{row['rods']:>10}{1e3 * float(row['step_s']):>11.1f}"
              f"{row['ns_per_element_step_and_core']:>8}{row['speedup']:>9}{row['efficiency']:>11}{agree:>8.1%}{row['other_programs_cores']:>8}  {row['digest']}")
    for protocol in dict.fromkeys(row["protocol"] for row in rows):
        serial = next(row["serial_fraction"] for row in rows if row["protocol"] == protocol)
        print(f"Amdahl, {protocol}: serial fraction {100 * float(serial):.2f} %")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", required=True, help="file for the table")
    parser.add_argument("--skein", default=str(HERE.parents[1] / "build/bin/skein"), help="program")
    parser.add_argument("--scene", default=str(HERE / "million.toml"), help="scene whose first group is a lattice")
    parser.add_argument("--counts", type=int, nargs=2, metavar=("NX", "NY"), help="rods along x and y; default: the scene's")
    parser.add_argument("--layouts", nargs="+", default=["1x1", "1x2", "2x1"], help="ranks x threads")
    parser.add_argument("--protocols", nargs="+", default=["asynchronous", "synchronous"])
    parser.add_argument("--studies", nargs="+", default=["strong", "weak"], choices=["strong", "weak"])
    parser.add_argument("--steps", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--launch", default="mpirun -n {ranks} --map-by slot:PE={threads} --bind-to core", help="launcher of {ranks} ranks of {threads} threads")
    parser.add_argument("--patience", type=float, default=30, help="longest wait for a quiet machine before a run, s")
    args = parser.parse_args()

    todo = configurations(args)
    Path("out").mkdir(exist_ok=True)  # here, because every node must see it
    with tempfile.TemporaryDirectory(dir="out") as out:
        for repeat in range(args.repeats):
            for c in todo:
                sample = run(args, c, out)
                c.samples.append(sample)
                print(f"{repeat + 1}/{args.repeats} {c.study} {c.protocol} {c.ranks}x{c.threads}: {1e3 * step_seconds(sample):.1f} ms a step, "
                      f"others {sample['others']:.2f} cores, digest {sample['digest']}", flush=True)
            rows = list(table(todo))  # after every repeat: a job may end before the last
            with open(args.csv, "w", newline="") as file:
                writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
    show(rows)
    digests = {}
    for c in todo:
        digests.setdefault(c.counts, set()).update(sample["digest"] for sample in c.samples)
    if any(len(found) > 1 for found in digests.values()):
        sys.exit("digests differ")


if __name__ == "__main__":
    main()
