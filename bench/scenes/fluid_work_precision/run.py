#!/usr/bin/env python3
"""Error of the fluid against its cost: vortices carried by a stream, whose exact velocity is known, by every scheme, Courant number and grid.

    run.py --skein build/bin/skein --csv fluid_work_precision.csv [--flows plane space] [--repeats 2]

`plane`: vortices of Taylor and Green, which decay as exp(-2 nu t), on n x n x 4 cells; `space`: those of Arnold, Beltrami and Childress, which
decay as exp(-nu t), on n x n x n. The error is the largest of a component in a cell after half a second, over the largest velocity of the vortices.
One thread; the least time of the repeats. Needs numpy and h5py.
"""

import argparse
import csv
import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
STREAM = (1.0, 0.7, 0.4)  # m/s
NU, END = 0.01, 0.5
RUNS = {"rk3": (0.25, 0.5, 1.0), "rk3_projected": (0.25, 0.5, 1.0), "adams_bashforth": (0.1, 0.25, 0.5)}
SCENE = """
title = "Vortices in a stream"
[constants]
k = {{ value = 1.0, unit = "1/m" }}
[time]
duration = {end}
[fluid]
cells = [{cells}]
spacing = {spacing!r}
density = 1.0
viscosity = {nu}
scheme = "{scheme}"
courant = {courant}
velocity_formula = [{formulas}]
[output]
fields = {end}
"""


@dataclass
class Flow:
    """Velocity of the vortices without the stream: as formulas, and as functions of x, y, z at time 0."""
    grids: tuple
    planes: int  # of cells along z; 0: as many as along x
    formulas: tuple
    functions: tuple
    decay: float  # 1/s
    most: float  # largest component, m/s


FLOWS = {
    "plane": Flow((32, 64, 128, 256), 4, ("-cos(k*x) * sin(k*y)", "sin(k*x) * cos(k*y)", "0"),
                  (lambda x, y, z: -np.cos(x) * np.sin(y) + 0 * z, lambda x, y, z: np.sin(x) * np.cos(y) + 0 * z, lambda x, y, z: 0 * (x + y + z)), 2 * NU, 1),
    "space": Flow((32, 64, 128), 0, ("sin(k*z) + cos(k*y)", "sin(k*x) + cos(k*z)", "sin(k*y) + cos(k*x)"),
                  (lambda x, y, z: np.sin(z) + np.cos(y) + 0 * x, lambda x, y, z: np.sin(x) + np.cos(z) + 0 * y, lambda x, y, z: np.sin(y) + np.cos(x) + 0 * z), NU, 2),
}


def scene_of(flow, n, scheme, courant):
    formulas = ", ".join(f'"{carried} + {formula}"' for carried, formula in zip(STREAM, flow.formulas))
    return SCENE.format(end=END, cells=f"{n}, {n}, {flow.planes or n}", spacing=2 * np.pi / n, nu=NU, scheme=scheme, courant=courant, formulas=formulas)


def error(flow, path):
    """Largest difference from the exact solution; what files have are means of the two faces of a cell, and so is what they are compared with."""
    with h5py.File(path) as file:
        velocity, h, time = file["velocity"][:].astype(float), file.attrs["spacing"], file.attrs["time"]
    places = [h * (np.arange(count) + 0.5) - carried * time for count, carried in zip(velocity.shape[2::-1], STREAM)]
    worst = 0.0
    for component, function in enumerate(flow.functions):
        exact = 0.0
        for side in (-0.5, 0.5):
            x, y, z = (place + (side * h if direction == component else 0) for direction, place in enumerate(places))
            exact = exact + 0.5 * function(x[None, None, :], y[None, :, None], z[:, None, None])
        worst = max(worst, np.abs(velocity[..., component] - STREAM[component] - np.exp(-flow.decay * time) * exact).max())
    return worst / flow.most


def measure(skein, name, n, scheme, courant, repeats, folder):
    flow, seconds = FLOWS[name], []
    scene, out = folder / "scene.toml", folder / "out"
    scene.write_text(scene_of(flow, n, scheme, courant))
    for _ in range(repeats):
        done = subprocess.run([str(skein), "run", str(scene), "--out", str(out), "--overwrite", "--threads", "1", "--no-checkpoint", "--quiet"], capture_output=True, text=True)
        if done.returncode == 4:  # the flow was lost, as by a scheme that is unstable at this step
            return {"flow": name, "scheme": scheme, "courant": courant, "n": n, "steps": 0, "error": "inf", "core_seconds": "", "ns_per_cell_step": "", "digest": ""}
        done.check_returncode()
        summary = json.loads((out / "summary.json").read_text())
        seconds.append(summary["phases"]["fluid"]["mean_s"])
    return {"flow": name, "scheme": scheme, "courant": courant, "n": n, "steps": int(summary["observables"]["fluid_steps[-]"]),
            "error": f"{error(flow, max(out.glob('fields_*.h5'))):.4g}", "core_seconds": f"{min(seconds):.4g}",
            "ns_per_cell_step": f"{1e9 * min(seconds) / summary['fluid_cell_steps']:.4g}", "digest": summary["digest"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--skein", type=Path, default=ROOT / "build/bin/skein")
    parser.add_argument("--csv", type=Path, required=True)
    parser.add_argument("--flows", nargs="+", default=list(FLOWS), choices=list(FLOWS))
    parser.add_argument("--most", type=int, default=256, help="cells along x of the finest grid")
    parser.add_argument("--repeats", type=int, default=2)
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.flows:
            for n in (n for n in FLOWS[name].grids if n <= arguments.most):
                for scheme, numbers in RUNS.items():
                    for courant in numbers:
                        rows.append(measure(arguments.skein, name, n, scheme, courant, arguments.repeats, Path(folder)))
                        print("  ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
    with arguments.csv.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
