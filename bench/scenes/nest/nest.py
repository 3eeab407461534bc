#!/usr/bin/env python3
"""What a step of a settled nest costs, by phase, over ranks and threads; beside it the same rods free.

    nest.py --skein build/bin/skein [--scene apps/nest/nest_1536.toml] [--settled 0.9] [--layouts 1x1 1x2 2x1] [--steps 2000] [--repeats 3]
            [--csv nest.csv]

The nest is run to its rest once, with a checkpoint; every layout goes on from there for so many steps and must end with the same digest. Free rods: the same
groups without [contact] and walls, with the load and damping that they have, one step per visit as rods that touch are stepped. Prints
medians; ratios are of one run of this script.
"""

import argparse
import csv
import json
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scaling"))
from scaling import serial_fraction  # noqa: E402  (from bench/scaling)

PHASES = ("rods", "exchange", "search", "contacts")


@dataclass
class Layout:
    """A row of the table, as serial_fraction wants it."""
    row: dict

    @property
    def cores(self):
        return self.row["ranks"] * self.row["threads"]

    def step_s(self):
        return 1e-9 * self.row["step_ns"]


def free_scene(text):
    """The scene without what rods touch; the packing stays."""
    text = re.sub(r"(?ms)^\[contact\].*?(?=^\[(?!contact))", "", text)
    text = re.sub(r"(?ms)^\[\[wall\]\].*?(?=^\[(?!\[wall\]\]|wall\.))", "", text)
    return text


def run(skein, scene, out, steps, ranks, threads, extra=()):
    command = ["mpirun", "-n", str(ranks), "--oversubscribe", str(skein), "run", str(scene), "--out", str(out), "--steps", str(steps), "--threads", str(threads),
               "--quiet", *extra]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return json.loads((out / "summary.json").read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = Path(__file__).resolve().parents[3]
    parser.add_argument("--skein", type=Path, default=root / "build/bin/skein")
    parser.add_argument("--scene", type=Path, default=root / "apps/nest/nest_1536.toml")
    parser.add_argument("--settled", type=float, default=0.9, help="time at which the nest is taken, s")
    parser.add_argument("--from-run", type=Path, help="folder of a run of the scene whose checkpoint is taken instead")
    parser.add_argument("--layouts", nargs="+", default=["1x1", "1x2", "2x1"])
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--csv", type=Path)
    arguments = parser.parse_args()

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        settled = arguments.from_run
        if not settled:
            settled = folder / "settled"
            subprocess.run([str(arguments.skein), "run", str(arguments.scene), "--out", str(settled), "--until", str(arguments.settled), "--quiet"], check=True)
        start = max(int(p.stem.split("_")[1]) for p in settled.glob("checkpoint_*.h5"))
        free = folder / "free.toml"
        free.write_text(free_scene(arguments.scene.read_text()))
        for layout in arguments.layouts:
            ranks, threads = map(int, layout.split("x"))
            for kind in ("nest", "free"):
                figures = []
                for _ in range(arguments.repeats):
                    out = folder / "now"
                    shutil.rmtree(out, ignore_errors=True)
                    if kind == "nest":
                        out.mkdir()
                        for name in (f"checkpoint_{start:012d}.h5", "physics.json"):
                            shutil.copy(settled / name, out / name)
                        summary = run(arguments.skein, arguments.scene, out, start + arguments.steps, ranks, threads)
                    else:
                        summary = run(arguments.skein, free, out, arguments.steps, ranks, threads, ("--protocol", "synchronous", "--no-checkpoint"))
                    figures.append(summary)
                per = 1e9 / figures[0]["element_steps"]
                row = {"scene": kind, "ranks": ranks, "threads": threads, "digest": figures[0]["digest"]}
                for phase in PHASES:
                    row[f"{phase}_ns"] = statistics.median(per * s["phases"][phase]["max_s"] for s in figures)
                row["step_ns"] = statistics.median(per * sum(s["phases"][p]["max_s"] for p in PHASES) for s in figures)
                if kind == "nest":
                    o = figures[0]["observables"]
                    row |= {"contacts_per_element": o["contacts[-]"] / figures[0]["elements"], "candidates_per_element": o["candidates[-]"] / figures[0]["elements"]}
                rows.append(row)
                print("  ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()), flush=True)
    nest = [row for row in rows if row["scene"] == "nest"]
    if len({row["digest"] for row in nest}) != 1:
        raise SystemExit("digests differ between layouts")
    for row in rows:
        if row["scene"] == "nest":
            free_row = next(r for r in rows if r["scene"] == "free" and (r["ranks"], r["threads"]) == (row["ranks"], row["threads"]))
            print(f"{row['ranks']}x{row['threads']}: a step is {row['step_ns'] / free_row['step_ns']:.2f} of that of free rods, rods are {row['rods_ns'] / row['step_ns']:.0%} of it, "
                  f"{nest[0]['step_ns'] / row['step_ns']:.2f} times as fast as {nest[0]['ranks']}x{nest[0]['threads']}")
    one = Layout(nest[0])
    for row in nest:
        row["speedup"] = one.cores * one.step_s() / Layout(row).step_s()
    for of, own in (("threads", [row for row in nest if row["ranks"] == 1]), ("ranks", [row for row in nest if row["ranks"] > 1])):
        if any(Layout(row).cores > one.cores for row in own):
            serial = max(0.0, serial_fraction(one, [Layout(row) for row in own]))
            print(f"{of}: serial fraction {serial:.1%} by Amdahl's law")
            for row in own:
                row["serial_fraction"] = serial
    if arguments.csv:
        with arguments.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)))
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
