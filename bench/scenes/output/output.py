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

SCENE = """
title = "Cilia that are written"
[time]
duration = 1e3
[[rods]]
name = "cilia"
start = "clamped"
[rods.material]
density = 2390.0
youngs_modulus = 1.85e5
shear_modulus = 6.16e4
[rods.section]
radius = 0.15
[rods.shape]
length = 1.5
elements = {elements}
[rods.placement]
kind = "lattice"
counts = [{nx}, {ny}]
spacing = [1.5, 1.5]
[rods.magnetisation]
pattern = "wave_x"
strength = 18999.0
wavelength_x = 6.0
[[load]]
kind = "magnetic_field"
rotating = 0.08
period = 72.0
constant = [0.0, 8e-4, 0.0]
[[damping]]
kind = "legacy"
rate = 0.5
"""


def run(arguments, scene, steps, *options):
    """Phases of a run, s, and bytes of its files by beginning of their names."""
    out = scene.parent / "out"
    launch = ["mpirun", "--oversubscribe", "-n", str(arguments.ranks)] if arguments.ranks > 1 else []
    subprocess.run([*launch, arguments.skein, "run", str(scene), "--out", str(out), "--threads", str(arguments.threads),
                    "--steps", str(steps), "--quiet", *options], check=True, stdout=subprocess.DEVNULL)
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
    scene = directory / "scene.toml"
    scene.write_text(SCENE.format(elements=arguments.elements, nx=arguments.count[0], ny=arguments.count[1]))
    row = {}

    steps, every = 128, 64  # a visit takes as many steps as without samples
    _, _, summary = run(arguments, scene, 1, "--no-checkpoint")
    taken, _, sampled = run(arguments, scene, steps, "--no-checkpoint", "--set", f"output.series={summary['dt_s'] * every!r}")
    row["step_ns"] = 1e9 * taken["rods"] / sampled["element_steps"]
    row["sample_ns"] = 1e9 * taken["observe"] / (steps // every + 1) / summary["elements"]
    row["sample_over_step"] = row["sample_ns"] / row["step_ns"]

    written, size, _ = run(arguments, scene, 1)
    plain = plain_write(directory, size["checkpoint"])
    row["checkpoint_mb_s"] = 1e-6 * size["checkpoint"] / written["checkpoint"]
    row["checkpoint_over_plain"] = plain / written["checkpoint"]

    written, size, _ = run(arguments, scene, 4, "--no-checkpoint", "--set", f"output.trajectory={summary['dt_s']!r}")
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
