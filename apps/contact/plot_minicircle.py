#!/usr/bin/python3
"""Pictures of rings with turns to spare: plot_minicircle.py OUT_DIR... [--to FILE]

Of runs of minicircle.toml that differ in their excess link: every ring at its end, and below them writhe and twist of all over the excess
link, with the link at which a circle buckles, sqrt(3) B/C, and the writhe of a supercoil without ends (dashed). Writes
minicircles.png into the first directory, or FILE. Needs numpy, h5py and matplotlib.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

import skein  # noqa: E402
from plot import LINES, series  # noqa: E402

COLOUR = dict(LINES)


def ring_of(out):
    """Section, moduli and length of a run's ring, and its excess link in turns."""
    needs.need_files(out, "physics.json", "trajectory_*.h5")
    run = skein.open(out)
    rod = run.rods[0].physics
    if not rod["shape"]["closed"]:
        sys.exit(f"{out}: its first rod is no ring; give results of minicircle.toml")
    length, twist = rod["shape"]["length"], rod["shape"]["rest_curvature"][2]
    return {"radius": rod["section"]["radius"], "length": length, "E": rod["material"]["youngs_modulus"],
            "G": rod["material"]["shear_modulus"] or rod["material"]["youngs_modulus"] / 3,
            "excess": series(run)["link"][-1] - twist * length / (2 * np.pi), "writhe": series(run)["writhe"][-1], "run": run}


def sides(ring):
    """Extents along the ring's longest and second axis, and the directions of the longest and the shortest."""
    nodes = ring["run"].rods[0].position[-1][0, :-1].astype(float)
    centred = nodes - nodes.mean(axis=0)
    _, _, axis = np.linalg.svd(centred, full_matrices=False)
    extent = np.ptp(centred @ axis.T, axis=0) + 4 * ring["radius"]
    return extent[0], extent[1], axis[0], axis[2]


def endless_supercoil(ring, beta):
    """Excess link and writhe of a rod that is a balanced two-strand ply all along, of strands at an angle beta to its axis."""
    B, C = ring["E"] * np.pi * ring["radius"]**4 / 4, ring["G"] * np.pi * ring["radius"]**4 / 2
    moment = B / ring["radius"] * np.sin(beta)**2 * np.tan(2 * beta)
    writhe = ring["length"] * np.sin(2 * beta) / (4 * np.pi * ring["radius"])
    return writhe + moment * ring["length"] / (2 * np.pi * C), writhe


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, nargs="+", help="directories of runs' results")
    parser.add_argument("--to", type=Path, help="file to write")
    arguments = parser.parse_args()

    rings = sorted((ring_of(out) for out in arguments.out), key=lambda ring: ring["excess"])
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    shapes = [sides(ring) for ring in rings]
    tallest = max(shape[0] for shape in shapes)
    figure = plt.figure(figsize=(6.4, 6.0), layout="constrained")
    grid = figure.add_gridspec(2, len(rings), height_ratios=(1, 1.2), width_ratios=[shape[1] for shape in shapes])
    for i, (ring, (_, width, up, towards)) in enumerate(zip(rings, shapes)):
        axes = figure.add_subplot(grid[0, i])
        pictures = skein.Pictures(ring["run"], [1e9], (max(64, round(720 * width / tallest)), 720), colour="group", ground=False,
                                  camera=tuple(towards), up=tuple(up), span=tallest)  # all to one scale
        pictures.show(axes)
        axes.set_title(f"{ring['excess']:.3g}", fontsize=8)
    below = figure.add_subplot(grid[1, :])
    excess, writhe = (np.array([ring[name] for ring in rings]) for name in ("excess", "writhe"))
    ring = rings[-1]
    below.plot(excess, writhe, "o-", color=COLOUR["writhe"], label="writhe")
    below.plot(excess, excess - writhe, "o-", color=COLOUR["twist"], label="elastic twist")
    ply, of_ply = endless_supercoil(ring, np.linspace(0, 0.6, 200))
    below.plot(ply[ply < excess[-1]], of_ply[ply < excess[-1]], "--", color=COLOUR["writhe"], linewidth=1, label="endless supercoil")
    below.axvline(np.sqrt(3) * ring["E"] / (2 * ring["G"]), color="#cfd4db", linewidth=1, zorder=0)
    below.set(xlabel="excess link, turns", ylabel="turns", xlim=(0, None), ylim=(0, None))
    below.legend(frameon=False)
    below.spines[["top", "right"]].set_visible(False)
    figure.savefig(arguments.to or arguments.out[0] / "minicircles.png", dpi=150)


if __name__ == "__main__":
    needs.in_words(main)
