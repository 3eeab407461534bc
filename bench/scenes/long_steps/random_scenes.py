#!/usr/bin/env python3
"""Random scenes by implicit steps with a tolerance: how each run ends.

    random_scenes.py --skein build/bin/skein --csv random.csv [--count 200] [--first 0] [--tolerance 1e-2] [--seconds 8]

Scene i depends on its number alone: one to three rods with random lengths, slenderness, moduli, densities, ends, damping, loads and velocities at the
start, by turns with `implicit_damped` and `implicit`. A row has the number, the method, how the run ended (end, warning, stop, cut), its core time, the
error that the run reports, and the first line of a stop. "cut": the run took longer than `seconds`. The script ends with 1 if a run ends with a number
that is not finite, or stops without a cause. Needs numpy and h5py.
"""

import argparse
import csv
import json
import math
import random
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
METHODS = "implicit_damped", "implicit"
CAUSES = ("parts has corrections", "parts still has an error", "parts is too long", "parts fails", "of its limit", "beyond", "likely cause", "cause:", "do not converge")


def vector(rng, size):
    return [round(rng.uniform(-size, size), 6) for _ in range(3)]


def rod(rng, number):
    length, slenderness = 10 ** rng.uniform(-2, 0.5), 10 ** rng.uniform(0.8, 3)
    radius, elements = length / (2 * slenderness), rng.randint(3, 60)
    ends = {"start": rng.choice(("free", "pinned", "clamped", "clamped")), "end": rng.choice(("free", "free", "free", "pinned", "clamped"))}
    lines = [f'[[rods]]\nname = "rod_{number}"'] + [f'{key} = "{kind}"' for key, kind in ends.items()]
    lines.append(f"material = {{density = {10 ** rng.uniform(2.5, 4):.5g}, youngs_modulus = {10 ** rng.uniform(5, 11):.5g}}}")
    lines.append(f"section.radius = {radius:.5g}")
    shape = {"length": f"{length:.5g}", "elements": elements}
    if rng.random() < 0.3: shape["velocity"] = vector(rng, length)
    if rng.random() < 0.4 and set(ends.values()) == {"free"}: shape["angular_velocity"] = vector(rng, 10)
    if rng.random() < 0.3: shape["rest_curvature"] = [round(rng.uniform(-2, 2) / length, 5) for _ in range(2)] + [0.0]
    lines.append("shape = {" + ", ".join(f"{key} = {value}" for key, value in shape.items()) + "}")
    tangent = vector(rng, 1) if rng.random() < 0.5 else [1.0, 0.0, 0.0]
    lines.append(f"placement = {{origin = [0.0, {10 * number}.0, 0.0], tangent = {tangent}}}")
    return "\n".join(lines), length


def loads(rng, length, duration):
    all = []
    if rng.random() < 0.7: all.append('[[load]]\nkind = "gravity"')
    if rng.random() < 0.3:
        period = duration * 10 ** rng.uniform(-2.5, 0)
        size = 10 ** rng.uniform(-2, 1)
        all.append(f'[[load]]\nkind = "formula"\nper = "mass"\nforce = ["{size:.4g}*sin({2 * math.pi / period:.6g}*t)", "0", "{size / 2:.4g}*cos({1 / period:.6g}*t)"]')
    if rng.random() < 0.8: all.append(f'[[damping]]\nkind = "uniform"\nrate = {10 ** rng.uniform(-1, 2):.4g}')
    return all


def scene_of(number, tolerance):
    rng = random.Random(number)
    duration = 10 ** rng.uniform(-1, 0.7)
    rods = [rod(rng, i) for i in range(rng.choice((1, 1, 1, 2, 3)))]
    method = METHODS[number % 2]
    head = f'[time]\nduration = {duration:.5g}\nintegrator = "{method}"\ntolerance = {tolerance}\n[output]\ntrajectory = {duration / 4:.6g}\nseries = {duration / 20:.6g}\nprecision = "double"\n'
    return method, head + "\n".join([text for text, _ in rods] + loads(rng, max(length for _, length in rods), duration)) + "\n"


def finite(out):
    for name in Path(out).glob("trajectory_*.h5"):
        with h5py.File(name) as file:
            for group in file["groups"].values():
                if not np.isfinite(group["position"][:]).all(): return False
    series = Path(out) / "observables.csv"
    return not series.exists() or "nan" not in series.read_text()


def outcome(skein, scene, out, seconds):
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(seconds), math.ceil(seconds) + 5))

    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([skein, "run", scene, "--out", out, "--overwrite", "--threads", "1", "--no-checkpoint", "--quiet"], capture_output=True, text=True, check=False, preexec_fn=limit)
    spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if done.returncode < 0: return "cut", spent, ""
    if not finite(out): return "not finite", spent, ""
    if done.returncode == 0: return "warning" if "warning:" in done.stderr else "end", spent, ""
    reason = done.stderr.partition("error: ")[2].strip()
    named = any(cause in reason for cause in CAUSES)
    return "stop" if named else "no cause", spent, " ".join(reason.split("\n")[:2])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skein", type=Path, default=ROOT / "build/bin/skein")
    parser.add_argument("--csv", type=Path, required=True)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--tolerance", type=float, default=1e-2)
    parser.add_argument("--seconds", type=float, default=8)
    arguments = parser.parse_args()
    counts = {}
    with tempfile.TemporaryDirectory() as folder, arguments.csv.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["scene", "method", "end", "core_seconds", "error", "reason"])
        for number in range(arguments.first, arguments.first + arguments.count):
            scene, out = Path(folder) / "scene.toml", Path(folder) / f"out_{number}"
            method, text = scene_of(number, arguments.tolerance)
            scene.write_text(text)
            end, spent, reason = outcome(str(arguments.skein), str(scene), str(out), arguments.seconds)
            summary = out / "summary.json"
            error = json.loads(summary.read_text()).get("implicit", {}).get("largest_error", "") if summary.exists() else ""
            writer.writerow([number, method, end, f"{spent:.2f}", error, reason])
            file.flush()
            counts[end] = counts.get(end, 0) + 1
    print("  ".join(f"{end}: {count}" for end, count in sorted(counts.items())))
    return 1 if {"not finite", "no cause"} & set(counts) else 0


if __name__ == "__main__":
    sys.exit(main())
