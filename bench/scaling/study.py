"""What the studies of scaling here share: layouts of ranks x threads, runs that are repeated in turn beside other programs, and their table."""

import argparse
import csv
import json
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


@dataclass
class Configuration:
    """One of a study. Subclasses say what a step takes by a summary.json: step_seconds(summary)."""

    study: str
    ranks: int
    threads: int
    counts: tuple  # of rods or cells, along axes
    samples: list = field(default_factory=list)  # summary.json of each repeat, with "others"

    @property
    def cores(self):
        return self.ranks * self.threads

    def median(self, of):
        return statistics.median(of(sample) for sample in self.samples)

    def step_s(self):
        return self.median(self.step_seconds)

    def times(self):
        """Columns of the table."""
        return {"step_s": f"{self.step_s():.5g}", "least_step_s": f"{min(map(self.step_seconds, self.samples)):.5g}",
                "most_step_s": f"{max(map(self.step_seconds, self.samples)):.5g}"}

    def others_cores(self):
        return f"{self.median(lambda sample: sample['others']):.3f}"


def parser_of(doc, scene=None, scene_help=None):
    """Of the arguments that all studies have, and a scene where there is one by default."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", required=True, help="file for the table")
    parser.add_argument("--skein", default=str(HERE.parents[1] / "build/bin/skein"), help="program")
    if scene:
        parser.add_argument("--scene", default=str(HERE / scene), help=scene_help)
        parser.add_argument("--studies", nargs="+", default=["strong", "weak"], choices=["strong", "weak"])
    parser.add_argument("--layouts", nargs="+", default=["1x1", "1x2", "2x1"], help="ranks x threads")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--launch", default="mpirun -n {ranks} --map-by slot:PE={threads} --bind-to core", help="launcher of {ranks} ranks of {threads} threads")
    parser.add_argument("--patience", type=float, default=30, help="longest wait for a quiet machine before a run, s")
    return parser


def planned(args, counts, make):
    """make(study, ranks, threads, counts) of every layout. Weak scaling has the last of the counts in proportion to cores, so that its largest
    layout is that of strong scaling."""
    layouts = [tuple(int(n) for n in layout.split("x")) for layout in args.layouts]
    most = max(ranks * threads for ranks, threads in layouts)
    out = [make("strong", *layout, tuple(counts)) for layout in layouts]
    if "weak" in args.studies:
        smaller = [(ranks, threads) for ranks, threads in layouts if ranks * threads < most]
        out += [make("weak", ranks, threads, (*counts[:-1], max(1, counts[-1] * ranks * threads // most))) for ranks, threads in smaller]
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


def run(args, configuration, arguments, out):
    """summary.json of a run with these arguments, a scene and what is set in it, and under "others" the cores that other programs took meanwhile."""
    launch = shlex.split(args.launch.format(ranks=configuration.ranks, threads=configuration.threads))
    command = [*launch, args.skein, "run", *arguments, "--threads", str(configuration.threads), "--out", out,
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


def measure(args, configurations, arguments, table, told):
    """Runs each configuration once a repeat, in turn, so that a busy machine slows all alike; writes and returns the rows of `table()`.
    `arguments(c)`: of its runs. `told(c)`: what is printed of its last one."""
    Path("out").mkdir(exist_ok=True)  # here, because every node must see it
    with tempfile.TemporaryDirectory(dir="out") as out:
        for repeat in range(args.repeats):
            for c in configurations:
                c.samples.append(run(args, c, arguments(c), out))
                print(f"{repeat + 1}/{args.repeats} {told(c)}", flush=True)
            rows = list(table())  # after every repeat: a job may end before the last
            with open(args.csv, "w", newline="") as file:
                writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
    return rows


def check_digests(configurations, alike):
    """Exits where configurations of the same `alike(c)` disagree."""
    digests = {}
    for c in configurations:
        digests.setdefault(alike(c), set()).update(sample["digest"] for sample in c.samples)
    if any(len(found) > 1 for found in digests.values()):
        sys.exit("digests differ")
