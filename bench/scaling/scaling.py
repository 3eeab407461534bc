#!/usr/bin/env python3
"""Strong and weak scaling of 1024 x 1024 rods, as in the Elastica++ paper, over ranks x threads, by both protocols.

  scaling.py --csv FILE [--layouts 1x1 1x2 2x1] [--steps 64] [--repeats 5] [--launch "mpirun -n {ranks} ..."]

Strong: the scene on every layout (ranks x threads). Weak: rods in proportion to the cores, so that the largest layout has the whole
scene. Every repeat runs each configuration once, in turn, so that a busy machine slows all alike; the table holds medians. A step's
time is that of its passes and of meeting other ranks (phases `rods` and `agree` of summary.json); reading, placing and writing are not
in it. Speedups are over the first layout's core count, and Amdahl's serial fraction s is fitted to T(p) = T(1) (s + (1-s)/p).
Ends with code 1 where layouts or protocols disagree in a digest.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import study

PHASES = ("setup", "rods", "agree", "observe", "output")


@dataclass
class Lattice(study.Configuration):
    """Rods along x and y."""

    protocol: str = ""

    @staticmethod
    def step_seconds(summary):
        return (summary["phases"]["rods"]["mean_s"] + summary["phases"]["agree"]["mean_s"]) / summary["steps"]

    def phase_s(self, phase):
        return self.median(lambda sample: sample["phases"][phase]["max_s" if phase == "rods" else "mean_s"])

    def arguments(self, steps):
        return ["--set", f"rods.0.placement.counts=[{self.counts[0]},{self.counts[1]}]", "--protocol", self.protocol, "--steps", str(steps)]

    def told(self):
        sample = self.samples[-1]
        return (f"{self.study} {self.protocol} {self.ranks}x{self.threads}: {1e3 * self.step_seconds(sample):.1f} ms a step, "
                f"others {sample['others']:.2f} cores, digest {sample['digest']}")


def lattice(scene):
    """Rods along x and y, as the scene has them."""
    return tuple(int(n) for n in re.search(r"^counts = \[(\d+), (\d+)\]", Path(scene).read_text(), re.MULTILINE).groups())


def configurations(args):
    """By layouts, and of each by protocols."""
    each = [study.planned(args, args.counts or lattice(args.scene), lambda *layout: Lattice(*layout, protocol=protocol)) for protocol in args.protocols]
    return [one for of_a_layout in zip(*each) for one in of_a_layout]


def table(all_rows):
    """Rows of the CSV, in the order of the configurations; weak scaling shares its largest layouts with strong."""
    most = max(row.cores for row in all_rows)
    for name in ("strong", "weak"):
        for protocol in dict.fromkeys(row.protocol for row in all_rows):
            rows = [row for row in all_rows if row.protocol == protocol and (row.study == name or (name == "weak" and row.cores == most))]
            rows.sort(key=lambda row: row.cores)
            if all(row.study != name for row in rows):
                continue
            base = rows[0]
            serial = study.serial_fraction(base, rows) if name == "strong" else float("nan")
            for row in rows:
                sample = row.samples[0]
                work = row.step_s() / sample["elements"]  # s per element-step
                speedup = base.step_s() / base.samples[0]["elements"] / work
                yield {"study": name, "protocol": protocol, "ranks": row.ranks, "threads": row.threads, "rods": sample["rods"],
                       "elements": sample["elements"], "steps": sample["steps"], "repeats": len(row.samples),
                       **row.times(), "ns_per_element_step_and_core": f"{1e9 * work * row.cores:.4g}", "speedup": f"{speedup:.4g}",
                       "efficiency": f"{speedup * base.cores / row.cores:.4g}", "serial_fraction": f"{serial:.3g}" if name == "strong" else "",
                       **{f"{phase}_s": f"{row.phase_s(phase):.4g}" for phase in PHASES},
                       "other_programs_cores": row.others_cores(), "digest": sample["digest"]}


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
    parser = study.parser_of(__doc__, "million.toml", "scene whose first group is a lattice")
    parser.add_argument("--counts", type=int, nargs=2, metavar=("NX", "NY"), help="rods along x and y; default: the scene's")
    parser.add_argument("--protocols", nargs="+", default=["asynchronous", "synchronous"])
    parser.add_argument("--steps", type=int, default=64)
    args = parser.parse_args()

    todo = configurations(args)
    show(study.measure(args, todo, lambda c: [args.scene, *c.arguments(args.steps)], lambda: table(todo), Lattice.told))
    study.check_digests(todo, lambda c: c.counts)


if __name__ == "__main__":
    main()
