#!/usr/bin/env python3
"""Figures of swimmers: plot.py OUT_DIR

Draws OUT_DIR/path.png, the way of every swimmer's centre of mass and its speed forward, a mean over a period, and with frames of the fluid OUT_DIR/flow.png, vorticity in the plane of
the waves and the swimmers' axes in the last one. Prints speeds forward and aside after the last period. Needs numpy, h5py and matplotlib.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import h5py  # noqa: E402
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

from skein.results import open as open_results  # noqa: E402
from skein.style import INK, bare  # noqa: E402

PERIOD = 1.0  # s, of the wave


def ways(results):
    """Times and places of the swimmers' centres, [frame][swimmer][xyz]: their nodes weighed by the areas of their sections."""
    places = []
    for group in results.rods:
        nodes, weight = np.asarray(group.position[:]), np.asarray(group.radius) ** 2
        places.append(np.einsum("frnx,n->frx", nodes, weight / weight.sum()))
    return np.asarray(results.time), np.concatenate(places, axis=1)


def mean_velocity(times, places):
    """Over the period before each frame, from the first whole one on: times, [frame][swimmer][xyz]."""
    steps = int(round(PERIOD / (times[1] - times[0])))
    return times[steps:], (places[steps:] - places[:-steps]) / (times[steps:] - times[:-steps])[:, None, None]


def draw_ways(times, places, to):
    figure, (way, speed) = plt.subplots(1, 2, figsize=(9, 3.6), constrained_layout=True)
    when, velocity = mean_velocity(times, places)
    for swimmer in range(places.shape[1]):
        way.plot(places[:, swimmer, 0], places[:, swimmer, 1])
        speed.plot(when, -velocity[:, swimmer, 0])
    way.set_xlabel("x [L]"), way.set_ylabel("y [L]"), way.set_aspect("equal", "datalim")
    way.set_title("centre of mass", color=INK)
    speed.set_xlabel("time [T]"), speed.set_ylabel("speed forward, mean over T [L/T]")
    for axes in (way, speed):
        bare(axes)
    figure.savefig(to, dpi=150)


def draw_flow(path, results, to):
    with h5py.File(path) as file:
        vorticity, spacing, lower = file["vorticity"], file.attrs["spacing"], [file.attrs[f"lower_{axis}"] for axis in "xyz"]
        frame = results.frames.nearest(float(file.attrs["time"]))
        nodes = np.concatenate([np.asarray(group.position[frame]) for group in results.rods])
        plane = int((nodes[0, 0, 2] - lower[2]) / spacing)
        values = vorticity[plane, ..., 2]
        title = f"vorticity along z, t = {file.attrs['time']:.3g} T"
    most = np.quantile(np.abs(values), 0.995) or 1.0
    figure, axes = plt.subplots(figsize=(8, 0.8 + 7 * values.shape[0] / values.shape[1]), constrained_layout=True)
    extent = [lower[0], lower[0] + spacing * values.shape[1], lower[1], lower[1] + spacing * values.shape[0]]
    image = axes.imshow(values, origin="lower", extent=extent, cmap="RdBu_r", vmin=-most, vmax=most, interpolation="bilinear")
    for rod in nodes:
        if abs(rod[0, 2] - nodes[0, 0, 2]) < spacing:
            axes.plot(rod[:, 0], rod[:, 1], color=INK, linewidth=1.5)
    axes.set_title(title, color=INK), axes.set_xlabel("x [L]"), axes.set_ylabel("y [L]")
    figure.colorbar(image, ax=axes, shrink=0.85).set_label("[1/T]")
    figure.savefig(to, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", metavar="OUT_DIR", type=Path)
    directory = parser.parse_args().directory
    results = open_results(directory)
    times, places = ways(results)
    draw_ways(times, places, directory / "path.png")
    frames = sorted(directory.glob("fields_*.h5"))
    if frames:
        draw_flow(frames[-1], results, directory / "flow.png")
    when, velocity = mean_velocity(times, places)
    for at in np.arange(when[0], when[-1] + 1e-9, PERIOD):
        now = velocity[np.argmin(np.abs(when - at))]
        print(f"to {at:.4g} T: forward {-now[:, 0].mean():.4f} L/T ({-now[:, 0].max():.4f} to {-now[:, 0].min():.4f}), aside {np.hypot(now[:, 1], now[:, 2]).mean():.4f} L/T")


if __name__ == "__main__":
    main()
