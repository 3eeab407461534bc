#!/usr/bin/python3
"""Pictures of rings with turns to spare: plot_minicircle.py OUT_DIR... [--to FILE]

Of runs of minicircle.toml that differ in their excess link: every ring at its end, and below them writhe and twist of all over the excess
link, with the link at which a circle buckles, sqrt(3) B/C, and the writhe of a supercoil without ends (dashed). Writes
minicircles.png into the first directory, or FILE. Needs numpy, h5py and matplotlib.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "figures"))
import results  # noqa: E402  (from apps/figures)

results.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

import frames  # noqa: E402  (from apps/figures)
import tubes  # noqa: E402
from plot import LINES, ROD, series, smoothed  # noqa: E402

COLOUR = dict(LINES)


def ring_of(out):
    """Section, moduli and length of a run's ring, and its excess link in turns."""
    results.need_files(out, "physics.json", "trajectory_*.h5")
    rod = json.loads((out / "physics.json").read_text())["rods"][0]
    if not rod["shape"]["closed"]:
        sys.exit(f"{out}: its first rod is no ring; give results of minicircle.toml")
    link = series(out)["link"][-1]
    length, twist = rod["shape"]["length"], rod["shape"]["rest_curvature"][2]
    return {"radius": rod["section"]["radius"], "length": length, "E": rod["material"]["youngs_modulus"],
            "G": rod["material"]["shear_modulus"] or rod["material"]["youngs_modulus"] / 3, "excess": link - twist * length / (2 * np.pi)}


def upright(nodes):
    """About its centre, the longest extent along z and the shortest along y."""
    centred = nodes - nodes[:-1].mean(axis=0)
    _, _, axis = np.linalg.svd(centred[:-1], full_matrices=False)
    turned = centred @ axis[[1, 2, 0]].T
    return turned - 0.5 * (turned.min(axis=0) + turned.max(axis=0))


def draw_ring(axes, nodes, radius, width, height):
    curve = smoothed(np.vstack([nodes[-3:-1], nodes, nodes[1:3]]))[8:-7]  # smooth over the joint too
    camera = tubes.Camera(np.zeros(3), 1.0, (0.0, -20.0, 0.0))  # far away: all to one scale
    tubes.draw_tubes(axes, camera, curve[None] / 20, np.full(len(curve), radius) / 20, ROD[None], sky_from=height / 20)
    axes.set(xlim=(-width / 800, width / 800), ylim=(-height / 800, height / 800), aspect="equal")
    axes.set_axis_off()


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

    runs = sorted(((ring_of(out), out) for out in arguments.out), key=lambda run: run[0]["excess"])
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    shapes = [upright(frames.rods_at(out, 1e9)[0][0]) for _, out in runs]
    widths = [np.ptp(nodes[:, 0]) + 4 * ring["radius"] for nodes, (ring, _) in zip(shapes, runs)]
    height = max(np.ptp(nodes[:, 2]) + 4 * ring["radius"] for nodes, (ring, _) in zip(shapes, runs))
    figure = plt.figure(figsize=(6.4, 6.0), layout="constrained")
    grid = figure.add_gridspec(2, len(runs), height_ratios=(1, 1.2), width_ratios=widths)
    for i, (nodes, width, (ring, _)) in enumerate(zip(shapes, widths, runs)):
        axes = figure.add_subplot(grid[0, i])
        draw_ring(axes, nodes, ring["radius"], width, height)
        axes.set_title(f"{ring['excess']:.3g}", fontsize=8)
    below = figure.add_subplot(grid[1, :])
    excess = np.array([ring["excess"] for ring, _ in runs])
    writhe = np.array([series(out)["writhe"][-1] for _, out in runs])
    ring = runs[-1][0]
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
    main()
