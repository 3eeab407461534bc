#!/usr/bin/env python3
"""What outputs cost: samples of the series over steps, checkpoints and frames over a plain write of as many bytes.

    bench/scenes/output/output.py [--skein build/bin/skein] [--count 300 300] [--elements 25] [--ranks 1] [--threads 2] [--csv FILE]

A carpet of cilia runs once per turn and kind of output, and once without any; times are phases of summary.json. Beside each run a file
of as many bytes is written and flushed (fsync) into the same directory: disks are shared, so ratios are made within a turn.
"""

import argparse
import csv
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import time

CARPET = pathlib.Path(__file__).parents[3] / "apps/cilia_carpet/carpet_8x8.toml"


def changed(count, elements, **others):
    """Options of a run of the carpet with these numbers of cilia and elements; nothing is written but what `others` ask for."""
    keys = {"rods.cilia.placement.counts": list(count), "rods.cilia.shape.elements": elements, "time.duration": 1e3, "time.divide": 0}
    keys |= {f"output.{key}": others.get(key, 0) for key in ("trajectory", "tips", "series", "checkpoint", "checkpoint_wall")}
    if others.get("trajectory"):
        keys["output.paraview"] = "xdmf"
    return [word for key, value in keys.items() for word in ("--set", f"{key}={value!r}")]


def run(arguments, directory, steps, *options, **outputs):
    """Phases of a run, s, and bytes of its files by beginning of their names; intervals of outputs, s."""
    out = directory / "out"
    launch = ["mpirun", "--oversubscribe", "-n", str(arguments.ranks)] if arguments.ranks > 1 else []
    subprocess.run([*launch, arguments.skein, "run", str(CARPET), "--out", str(out), "--threads", str(arguments.threads),
                    "--steps", str(steps), "--quiet", *options, *changed(arguments.count, arguments.elements, **outputs)],
                   check=True, stdout=subprocess.DEVNULL)
    summary = json.loads((out / "summary.json").read_text())
    phases = {name: times["max_s"] for name, times in summary["phases"].items()}
    size = {kind: sum(f.stat().st_size for f in out.glob(kind + "_*.h5")) for kind in ("checkpoint", "trajectory")}
    shutil.rmtree(out)
    return phases, size, summary


def plain_write(directory, size):
    """Seconds to write and flush a file of `size` bytes."""
    block = os.urandom(8 << 20)
    path = directory / "plain"
    begin = time.monotonic()
    with open(path, "wb", buffering=0) as file:
        for done in range(0, size, len(block)):
            file.write(block[:min(len(block), size - done)])
        os.fsync(file.fileno())
    taken = time.monotonic() - begin
    path.unlink()
    return taken


def turn(arguments, directory):
    row = {}

    steps, every = 128, 64  # a visit takes as many steps as without samples
    _, _, summary = run(arguments, directory, 1, "--no-checkpoint")
    taken, _, sampled = run(arguments, directory, steps, "--no-checkpoint", series=summary["dt_s"] * every)
    row["step_ns"] = 1e9 * taken["rods"] / sampled["element_steps"]
    row["sample_ns"] = 1e9 * taken["observe"] / (steps // every + 1) / summary["elements"]
    row["sample_over_step"] = row["sample_ns"] / row["step_ns"]

    written, size, _ = run(arguments, directory, 1)
    plain = plain_write(directory, size["checkpoint"])
    row["checkpoint_mb_s"] = 1e-6 * size["checkpoint"] / written["checkpoint"]
    row["checkpoint_over_plain"] = plain / written["checkpoint"]

    written, size, _ = run(arguments, directory, 4, "--no-checkpoint", trajectory=summary["dt_s"])
    plain = plain_write(directory, size["trajectory"])
    row["frames_mb_s"] = 1e-6 * size["trajectory"] / written["output"]
    row["frames_over_plain"] = plain / written["output"]
    row["plain_mb_s"] = 1e-6 * size["trajectory"] / plain
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skein", default="build/bin/skein")
    parser.add_argument("--count", type=int, nargs=2, default=[300, 300])
    parser.add_argument("--elements", type=int, default=25)
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--turns", type=int, default=5, help="of which the table shows the medians")
    parser.add_argument("--directory", type=pathlib.Path, help="on the disk to be measured (default: the present one)")
    parser.add_argument("--csv", type=pathlib.Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.directory or pathlib.Path.cwd()) as directory:
        rows = [turn(arguments, pathlib.Path(directory)) for _ in range(arguments.turns)]
    for key in rows[0]:
        values = [row[key] for row in rows]
        print(f"{key:<24}{statistics.median(values):>10.3g}   {' '.join(f'{v:.3g}' for v in values)}")
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            table = csv.DictWriter(file, rows[0])
            table.writeheader()
            table.writerows(rows)


if __name__ == "__main__":
    main()
