#!/usr/bin/env python3
"""What a step of the swarm of millipedes costs, in turn: with 64 steps a visit and with one, without contact; with contact between robots;
on ranks and threads.

    swarm.py --skein build/bin/skein [--layouts 1x1 1x2 2x1] [--steps 1024] [--repeats 5] [--csv swarm.csv]

Prints the least of all repeats and ratios of these, of one run of this script; stops where digests of one scene differ.
"""

import argparse
import csv
import json
import re
import subprocess
import tempfile
from pathlib import Path

PHASES = ("rods", "exchange", "search", "contacts")
ROOT = Path(__file__).resolve().parents[3]
KINDS = {"64 steps a visit": ("asynchronous", False), "a step a visit": ("synchronous", False), "with contact": ("asynchronous", True)}


def scene(text, with_contact):
    """The swarm, at home in another folder, with or without contact between robots."""
    text = re.sub(r'"([\w.]+\.(?:part|pbm))"', lambda m: f'"{ROOT / "apps/millipede" / m[1]}"', text)
    text = re.sub(r"(?ms)^\[output\].*", "", text) + "\n[output]\nseries = 0\n"
    return text if with_contact else re.sub(r"(?ms)^\[contact\].*?(?=^\[)", "", text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skein", type=Path, default=ROOT / "build/bin/skein")
    parser.add_argument("--layouts", nargs="+", default=["1x1", "1x2", "2x1"], help="ranks x threads")
    parser.add_argument("--steps", type=int, default=1024)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--csv", type=Path)
    arguments = parser.parse_args()

    least, digests = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        text = (ROOT / "apps/millipede/swarm_224.toml").read_text()
        for with_contact in (False, True):
            (folder / f"{with_contact}.toml").write_text(scene(text, with_contact))
        for _ in range(arguments.repeats):
            for kind, (protocol, with_contact) in KINDS.items():
                for layout in arguments.layouts:
                    ranks, threads = layout.split("x")
                    subprocess.run(["mpirun", "-n", ranks, "--oversubscribe", "--bind-to", "none", str(arguments.skein), "run", str(folder / f"{with_contact}.toml"), "--out", str(folder / "out"),
                                    "--overwrite", "--steps", str(arguments.steps), "--threads", threads, "--protocol", protocol, "--no-checkpoint", "--rewind", "never", "--quiet"],
                                   check=True, stdout=subprocess.DEVNULL)
                    summary = json.loads((folder / "out/summary.json").read_text())
                    cost = 1e9 * sum(summary["phases"][phase]["max_s"] for phase in PHASES) / summary["element_steps"]
                    least[kind, layout] = min(cost, least.get((kind, layout), cost))
                    digests.setdefault(with_contact, set()).add(summary["digest"])
    if any(len(of_scene) != 1 for of_scene in digests.values()):
        raise SystemExit(f"digests differ: {digests}")
    rows = [{"kind": kind, "layout": layout, "ns": cost, "speedup": least[kind, arguments.layouts[0]] / cost} for (kind, layout), cost in least.items()]
    for row in rows:
        print(f"{row['kind']:18s} {row['layout']}  {row['ns']:6.2f} ns an element-step  {row['speedup']:.2f} times as fast as {arguments.layouts[0]}")
    for layout in arguments.layouts:
        print(f"{layout}: 64 steps a visit are {least['a step a visit', layout] / least['64 steps a visit', layout]:.2f} times as fast as one")
    if arguments.csv:
        with arguments.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
