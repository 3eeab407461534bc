#!/usr/bin/env python3
"""Strong scaling of whole scenes over ranks and threads: what a step takes, by phase.

    bench/scaling/scenes.py --csv out/scenes.csv apps/active_matter/pit_16384.toml=2000 apps/school/school_4.toml=750
    bench/scaling/scenes.py --layouts 1x16 16x16 64x16 --csv out/scenes.csv apps/school/school_32.toml=720         on a cluster

Each scene is followed by its number of steps of rods from its start on, of which whole steps of a fluid (`skein plan`: meets rods) take some hundreds each. Every layout runs each scene once a repeat, in turn; the table has medians. A step's time
is that of all phases but those of setup, observables and files. Ends with code 1 where layouts disagree in a digest.
"""

from dataclasses import dataclass
from pathlib import Path

import study

NOT_STEPS = ("setup", "observe", "output", "checkpoint")


@dataclass
class Case(study.Configuration):
    scene: Path = None
    steps: int = 0

    @staticmethod
    def phases(summary):
        """Seconds of each phase of a step, over all steps."""
        return {name: phase["mean_s"] / summary["steps"] for name, phase in summary["phases"].items() if name not in NOT_STEPS and phase["mean_s"] > 0}

    @classmethod
    def step_seconds(cls, summary):
        return sum(cls.phases(summary).values())

    def told(self):
        return f"{self.scene.stem} {self.ranks}x{self.threads}: {1e3 * self.step_seconds(self.samples[-1]):.3f} ms a step, digest {self.samples[-1]['digest']}"


def case(text):
    scene, _, steps = text.rpartition("=")
    if not scene or not steps.isdecimal():
        raise ValueError(text)
    return Path(scene), int(steps)


def table(cases):
    """Rows of the CSV: by scenes, of each by cores."""
    names = dict.fromkeys(name for one in cases for name in Case.phases(one.samples[-1]))
    for scene in dict.fromkeys(one.scene for one in cases):
        own = sorted((one for one in cases if one.scene == scene), key=lambda one: one.cores)
        base = own[0]
        for one in own:
            sample, speedup = one.samples[-1], base.step_s() / one.step_s()
            yield {"scene": scene.stem, "ranks": one.ranks, "threads": one.threads, "rods": sample["rods"], "elements": sample["elements"], "steps": one.steps,
                   "repeats": len(one.samples), **one.times(), "speedup": f"{speedup:.4g}", "efficiency": f"{speedup * base.cores / one.cores:.4g}",
                   **{f"{name}_s": f"{one.median(lambda s: Case.phases(s).get(name, 0.0)):.4g}" for name in names},
                   "other_programs_cores": one.others_cores(), "digest": sample["digest"]}


def show(rows):
    print(f"\n{'scene':<22}{'layout':>7}{'ms a step':>11}{'speedup':>9}{'efficiency':>11}{'others':>8}  shares of a step")
    for row in rows:
        shares = ((name.removesuffix("_s"), float(value) / float(row["step_s"])) for name, value in row.items() if name.endswith("_s") and "step" not in name)
        print(f"{row['scene']:<22}{row['ranks']:>4}x{row['threads']:<2}{1e3 * float(row['step_s']):>11.3f}{row['speedup']:>9}{row['efficiency']:>11}{row['other_programs_cores']:>8}  "
              + ", ".join(f"{name} {share:.0%}" for name, share in shares if share >= 0.005))


def main():
    parser = study.parser_of(__doc__)
    parser.add_argument("cases", nargs="+", metavar="SCENE=STEPS", type=case)
    args = parser.parse_args()
    cases = [Case("strong", *(int(n) for n in layout.split("x")), (), scene=scene, steps=steps) for scene, steps in args.cases for layout in args.layouts]
    show(study.measure(args, cases, lambda one: [str(one.scene), "--steps", str(one.steps), "--rewind", "never"], lambda: table(cases), Case.told))
    study.check_digests(cases, lambda one: (one.scene, one.steps))


if __name__ == "__main__":
    main()
