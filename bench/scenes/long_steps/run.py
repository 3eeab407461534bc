#!/usr/bin/env python3
"""Error against core time of thin and of soft rods by explicit and implicit steps.

    run.py --skein build/bin/skein --csv long_steps.csv [--kinds hair suture cable pendulum cilium] [--repeats 3]

Errors are the largest distance of a node, in any of ten frames, from where a converged run has it, over the length; the converged run takes
explicit steps of half the automatic length. Core time is that of the process less that of a run of one step; the median of the repeats, in turn.
One rod, of cilia 64; one thread. Needs numpy and h5py.
"""

import argparse
import csv
import resource
import statistics
import subprocess
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
GRAVITY = '[[load]]\nkind = "gravity"\n'
SCENE = """
[time]
duration = {duration}
{time}
[output]
trajectory = {frame!r}
precision = "double"
[[rods]]
name = "rod"
{ends}
material = {{density = {density}, youngs_modulus = {modulus}{inertia}}}
section.radius = {radius}
shape = {{length = {length}, elements = {elements}}}
placement = {{kind = "lattice", counts = [{count}, 1], spacing = [{length}, {length}], tangent = [{tangent}]}}
{tables}
"""
X, Z = "1.0, 0.0, 0.0", "0.0, 0.0, 1.0"


def damping(rate):
    return f'[[damping]]\nkind = "uniform"\nrate = {rate}\n'


SAGS = 'start = "pinned"\nend = "pinned"\nend_motion = {times = [0.0, 1.0], translation = [[0, 0, 0], [-0.1, 0, 0]], smooth = true}'
FIELD = """magnetisation = {pattern = "uniform", strength = 18999.0, direction = [0.0, 0.0, 1.0]}
[[load]]
kind = "magnetic_field"
rotating = 0.02
period = 72.0
ramp = 7.2
"""
KINDS = {
    "hair": {"duration": 0.25, "ends": 'start = "clamped"', "density": 1300.0, "modulus": 4e9, "radius": 4e-5, "length": 0.1, "elements": 50, "tangent": X,
             "tables": GRAVITY + damping(10.0)},
    "suture": {"duration": 1.0, "ends": 'start = "clamped"', "density": 1200.0, "modulus": 1e9, "radius": 1e-4, "length": 0.2, "elements": 100, "tangent": X,
               "tables": GRAVITY + damping(5.0)},
    "cable": {"duration": 1.0, "ends": SAGS, "density": 7800.0, "modulus": 2e11, "radius": 5e-3, "length": 10.0, "elements": 100, "tangent": X,
              "tables": GRAVITY + damping(0.5)},
    "soft pendulum": {"duration": 1.2, "ends": 'start = "pinned"', "density": 2000.0, "modulus": 1e6, "radius": 0.04, "length": 1.0, "elements": 40, "tangent": X,
                      "tables": GRAVITY},
    "cilium": {"duration": 72.0, "ends": 'start = "clamped"', "density": 2390.0, "modulus": 1.85e5, "radius": 0.15, "length": 1.5, "elements": 25, "tangent": Z, "count": 64,
               "tables": FIELD + damping(0.5)},
}
# Fixed steps, as parts of the duration, and tolerances of those that choose their parts.
PARTS = (100, 200, 400, 800, 1600)
TOLERANCES = (3e-2, 1e-2, 1e-3, 1e-4, 1e-5)


def methods():
    yield "explicit", "", ""
    yield 'explicit, rotary_inertia_for_dt = "auto"', "", ', rotary_inertia_for_dt = "auto"'
    for name in ("implicit", "implicit_damped"):
        for parts in PARTS:
            yield f"{name}, {parts} steps", f'integrator = "{name}"\ndt = {{duration}}/{parts}', ""
        for tolerance in TOLERANCES:
            yield f"{name}, tolerance = {tolerance:g}", f'integrator = "{name}"\ntolerance = {tolerance}', ""


def scene_of(kind, time, inertia):
    if "/" in time:
        head, parts = time.rsplit("{duration}/", 1)
        time = f"{head}{kind['duration'] / int(parts)!r}"
    return SCENE.format(**{"count": 1} | kind, time=time, inertia=inertia, frame=kind["duration"] / 10)


def core_seconds(skein, scene, out, *arguments):
    """Of the process; none where the scene is refused or the run fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([skein, "run", scene, "--out", out, "--overwrite", "--threads", "1", "--no-checkpoint", "--quiet", *arguments], capture_output=True, check=False)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before if done.returncode in (0, 3) else None


def places(out):
    with h5py.File(min(Path(out).glob("trajectory_*.h5"))) as file:
        return file["groups/rod/position"][:]


def measure(skein, kind, folder, repeats):
    scene, out = folder / "scene.toml", folder / "out"

    def run(time, inertia, *arguments):
        scene.write_text(scene_of(kind, time, inertia))
        return core_seconds(skein, scene, out, *arguments)

    run("safety = 0.3", "")
    converged = places(out)
    start = statistics.median(run("", "", "--steps", "1") for _ in range(5))
    spent, errors = {}, {}
    for _ in range(repeats):
        for name, time, inertia in methods():
            seconds = run(time, inertia)
            if seconds is None:
                continue
            spent.setdefault(name, []).append(seconds - start)
            errors[name] = np.linalg.norm(places(out) - converged, axis=-1).max() / kind["length"]
    return [(name, statistics.median(spent[name]), errors[name]) for name, _, _ in methods() if name in spent]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skein", type=Path, default=ROOT / "build/bin/skein")
    parser.add_argument("--csv", type=Path, required=True)
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.kinds:
            for method, seconds, error in measure(str(arguments.skein), KINDS[name], Path(folder), arguments.repeats):
                rows.append({"kind": name, "method": method, "core_seconds": f"{seconds:.3g}", "error": f"{error:.2g}"})
                print("  ".join(rows[-1].values()), flush=True)
    with arguments.csv.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
