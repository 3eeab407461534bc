#!/usr/bin/python3
"""Picture of reeds in gusts, of a rod near a magnet, of a flagellum that swims: plot.py OUT_DIR... [--to FILE]

Of gusts.toml the reeds at one time, and how far their tips lean, by place and time, with the way of a gust (dashed); of magnet.toml the rod
as the magnet comes near, in lines of its field; of flagellum.toml its shapes in a period, and the way of its head. Writes formulas.png into the first directory, or FILE. Needs numpy, h5py and matplotlib.
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
from skein import style  # noqa: E402

REED, ROD, FIELD, SWIMMER = np.array([0.42, 0.56, 0.30]), "#c2554a", "#cfd4db", "#3f6fa8"


def constants_of(out):
    needs.need_files(out, "physics.json", "trajectory_*.h5")
    return skein.open(out).constants


def draw_reeds(axes, out, time):
    run = skein.open(out)
    skein.Pictures(run, [time], (1600, 900), colour=np.tile(REED, (run.rods[0].count, 1)), camera=(-0.3, -2.0, 0.5)).show(axes)


def draw_leaning(axes, out, travel):
    run = skein.open(out)
    times, place = run.time, run.rods[0].position[0][:, 0, 0]
    lean = 1e3 * (run.rods[0].position[:, :, -1, 0] - run.rods[0].position[:, :, 0, 0])
    most = np.abs(lean).max()
    picture = axes.pcolormesh(times, place, lean.T, cmap="YlGn", vmin=min(0, lean.min()), vmax=most, shading="nearest")
    axes.figure.colorbar(picture, ax=axes)
    axes.plot(0.5 * times[-1] + (place - place[0]) / travel, place, "--", color=style.INK, linewidth=1)
    axes.set(xlabel="time, s", ylabel="place of the reed, m", xlim=(times[0], times[-1]))


def dipole(x, z, constants):
    rx, rz = x - constants["reach"], z - constants["height"]
    r = np.hypot(rx, rz)
    return 3 * rx * rx / r**5 - 1 / r**3, 3 * rx * rz / r**5


def draw_rod(axes, out, constants):
    x, z = np.meshgrid(np.linspace(-0.01, 0.055, 120), np.linspace(0, 0.065, 120))
    axes.streamplot(1e3 * x, 1e3 * z, *dipole(x, z, constants), color=FIELD, linewidth=0.6, arrowsize=0.6, density=1.2)
    run = skein.open(out)
    for share in np.linspace(0, 1, 11):
        nodes = run.rods[0].position[run.frames.nearest(share * constants["rise"])]
        axes.plot(*(1e3 * nodes[0][:, [0, 2]]).T, color=ROD, linewidth=2, alpha=0.25 + 0.7 * share)
    axes.plot(1e3 * constants["reach"], 1e3 * constants["height"], "s", color=style.INK, markersize=7)
    axes.set(xlabel="x, mm", ylabel="z, mm", aspect="equal", xlim=(-10, 55), ylim=(0, 65))


def draw_swimmer(axes, out, period):
    run = skein.open(out)
    nodes, times = 1e3 * run.rods[0].position[:, 0], run.time
    axes.plot(*nodes[:, 0, :2].T, color=FIELD, linewidth=1)
    for share in np.linspace(0, 1, 9)[1:]:
        k = int(np.argmin(np.abs(times - (times[-1] - (1 - share) * period))))
        axes.plot(*nodes[k, :, :2].T, color=SWIMMER, linewidth=2, alpha=0.1 + 0.85 * share**2)
    axes.plot(*nodes[-1, 0, :2], "o", color=SWIMMER, markersize=5)
    axes.set(xlabel="x, mm", ylabel="y, mm", aspect="equal")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, nargs="+", help="results of gusts.toml, magnet.toml and flagellum.toml, or of some of them")
    parser.add_argument("--to", type=Path, help="file to write")
    arguments = parser.parse_args()
    gusts = magnet = swimmer = None
    for out in arguments.out:
        constants = constants_of(out)
        if "travel" in constants:
            gusts = out, constants
        elif "wavelength" in constants:
            swimmer = out, constants
        else:
            needs.need_names(out, "constant", constants, ("reach", "height", "rise"), "give results of gusts.toml, magnet.toml or flagellum.toml")
            magnet = out, constants

    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    rows = [["reeds"], ["leaning", "rod"]] if gusts and magnet else [["reeds", "leaning"]] if gusts else [["rod"]] if magnet else []
    if swimmer:
        rows.append(["swimmer"])
    heights = [1.8 if row == ["swimmer"] else 3.1 for row in rows]
    figure = plt.figure(figsize=(8.0, sum(heights)), layout="constrained")
    axes = {}
    for row, part in zip(rows, figure.subfigures(len(rows), 1, height_ratios=heights, squeeze=False)[:, 0]):
        axes |= part.subplot_mosaic([row])
    if gusts:
        draw_reeds(axes["reeds"], gusts[0], 3.0)
        style.heading(axes["reeds"], "Reeds in gusts of wind")
        draw_leaning(axes["leaning"], gusts[0], gusts[1]["travel"])
        style.heading(axes["leaning"], "Lean of the tips, mm")
    if magnet:
        draw_rod(axes["rod"], *magnet)
        style.heading(axes["rod"], "A rod as a magnet comes near")
    if swimmer:
        draw_swimmer(axes["swimmer"], swimmer[0], swimmer[1]["period"])
        style.heading(axes["swimmer"], "A flagellum swims against the wave of its muscles")
    for name in axes.keys() - {"reeds"}:
        style.bare(axes[name], "left", "bottom")
    figure.savefig(arguments.to or arguments.out[0] / "formulas.png", dpi=150)


if __name__ == "__main__":
    needs.in_words(main)
