#!/usr/bin/env python3
"""What an element-step of a snake pit costs as pits grow, in turn: the first steps of pits of 1024, 4096 and 16384 rods.

    pits.py --skein build/bin/skein [--steps 2000] [--repeats 3] [--threads 1] [--csv pits.csv]

Prints the least of all repeats by phase, ratios of these within one run of this script, and bytes.
"""

import argparse
import csv
import json
import subprocess
import tempfile
from pathlib import Path

PHASES = ("rods", "exchange", "search", "contacts")
ROOT = Path(__file__).resolve().parents[3]
RODS = (1024, 4096, 16384)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skein", type=Path, default=ROOT / "build/bin/skein")
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--threads", default="1")
    parser.add_argument("--csv", type=Path)
    arguments = parser.parse_args()
    best = {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.repeats):
            for rods in RODS:
                subprocess.run([str(arguments.skein), "run", str(ROOT / f"apps/active_matter/pit_{rods}.toml"), "--out", folder, "--overwrite", "--steps", str(arguments.steps),
                                "--threads", arguments.threads, "--no-checkpoint", "--rewind", "never", "--quiet"], check=True)
                summary = json.loads((Path(folder) / "summary.json").read_text())
                per = 1e9 / summary["element_steps"]
                row = {"rods": rods} | {f"{phase}_ns": per * summary["phases"][phase]["max_s"] for phase in PHASES}
                row |= {"step_ns": sum(row[f"{phase}_ns"] for phase in PHASES), "contacts_per_element": summary["observables"]["contacts[-]"] / summary["elements"],
                        "resident_bytes_per_element": summary["memory"]["resident_bytes"] / summary["elements"]}
                if rods not in best or row["step_ns"] < best[rods]["step_ns"]:
                    best[rods] = row
    for row in best.values():
        print("  ".join(f"{key} {value:.4g}" for key, value in row.items()))
    for small, large in ((1024, 4096), (1024, 16384), (4096, 16384)):
        print(f"{large} over {small} rods: {best[large]['step_ns'] / best[small]['step_ns']:.2f}")
    if arguments.csv:
        with arguments.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(best[1024]))
            writer.writeheader()
            writer.writerows(best.values())


if __name__ == "__main__":
    main()
