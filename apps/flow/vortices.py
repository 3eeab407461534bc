"""Vortices against what theory says of them: plot.py draws these where a scene has the constants `circulation` and `core`.

A ring has a constant `R` too. Its place is the centroid of impulse, its speed is compared with Saffman's formula for a Gaussian core,
U = Gamma / (4 pi R) (ln(8 R / a) - 0.558) with a^2 = core^2 + 4 nu t. Without `R` the vortex is that of Lamb and Oseen.
"""

import json

import matplotlib.pyplot as plt
import numpy as np

from skein.own_file import OwnFile
from skein.style import INK, bare

SEEN = "#c8502d"


def read_vortex(directory):
    """Circulation, core, the fluid's constants and, of a ring, R of the scene; None where it has no vortex."""
    scene = json.loads((directory / "physics.json").read_text())
    constants = {name: entry["value"] for name, entry in scene.get("constants", {}).items()}
    if not {"circulation", "core"} <= set(constants):
        return None
    fluid = scene["fluid"]
    return constants | {"nu": fluid["viscosity"] / fluid["density"], "density": fluid["density"], "lower": fluid["lower"]}


def middles(file, lower):
    """Places of the middles of cells along x, y and z, each of a shape that goes with fields[z][y][x]."""
    shape = file["velocity"].shape[:3]
    spacing = file.attrs["spacing"]
    for direction, axis in enumerate((2, 1, 0)):
        yield (lower[direction] + spacing * (np.arange(shape[axis]) + 0.5)).reshape([-1 if a == axis else 1 for a in range(3)])


def ring_state(path, vortex):
    """Time, impulse along x and its centroid along x."""
    with OwnFile(path) as file:
        x, y, z = middles(file, vortex["lower"])
        vorticity = file["vorticity"]
        density = 0.5 * (y * vorticity[..., 2] - z * vorticity[..., 1]).astype(float)
        impulse = density.sum()
        return file.attrs["time"], vortex["density"] * impulse * file.attrs["spacing"] ** 3, (x * density).sum() / impulse


def saffman(vortex, time):
    core = np.sqrt(vortex["core"] ** 2 + 4 * vortex["nu"] * time)
    return vortex["circulation"] / (4 * np.pi * vortex["R"]) * (np.log(8 * vortex["R"] / core) - 0.558)


def travel(vortex, time):
    """Way of the ring by the formula, from the first time on."""
    fine = np.linspace(time[0], time[-1], 2001)
    speed = saffman(vortex, fine)
    way = np.concatenate([[0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])
    return np.interp(time, fine, way)


def draw_ring(files, vortex, to):
    time, impulse, place = np.array([ring_state(path, vortex) for path in files]).T
    way = (place - place[0]) / vortex["R"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.6), constrained_layout=True)
    left.plot(time, way, "o", ms=4, color=SEEN, label="centroid of impulse")
    left.plot(time, travel(vortex, time) / vortex["R"], color=INK, label="Saffman's formula")
    left.set_xlabel("time [s]"), left.set_ylabel("way over radius")
    left.legend(frameon=False)
    right.plot(time, impulse / impulse[0] - 1, "o-", ms=4, color=SEEN)
    right.set_xlabel("time [s]"), right.set_ylabel("relative change of impulse")
    for axes in (left, right):
        bare(axes, "left", "bottom")
    figure.savefig(to, dpi=150)
    for first, last in ((0, 1), (1, 2), (0, way[-1])):
        begin, end = np.interp([first, last], way, time)
        if last <= way[-1]:
            speed = (last - first) * vortex["R"] / (end - begin)
            formula = np.diff(np.interp([begin, end], time, travel(vortex, time)))[0] / (end - begin)
            print(f"way {first:.3g} to {last:.3g} radii: speed {speed:.5g} m/s, formula {formula:.5g} m/s, difference {speed / formula - 1:+.2%}")
    expected = vortex["density"] * np.pi * vortex["circulation"] * (vortex["R"] ** 2 + 0.5 * vortex["core"] ** 2)
    print(f"impulse at the start {impulse[0]:.6g} N s, of the vorticity in the scene {expected:.6g} N s; largest change {np.max(np.abs(impulse / impulse[0] - 1)):.2%}")


def exact_swirl(vortex, x, y, time):
    """Velocity of a vortex of Lamb and Oseen without bounds."""
    square = np.maximum(x**2 + y**2, 1e-20)
    share = vortex["circulation"] / (2 * np.pi) * -np.expm1(-square / (vortex["core"] ** 2 + 4 * vortex["nu"] * time)) / square
    return -y * share, x * share


def swirl_error(path, vortex):
    """Time, distance from the axis, largest difference from the exact velocity in a cell, and velocity round the axis, of a plane of cells.

    What files have are means of two faces, and so is what they are compared with.
    """
    with OwnFile(path) as file:
        x, y = (place[0] for place in list(middles(file, vortex["lower"]))[:2])
        velocity, half, time = file["velocity"][0].astype(float), 0.5 * file.attrs["spacing"], file.attrs["time"]
    u = 0.5 * sum(exact_swirl(vortex, x + side, y, time)[0] for side in (-half, half))
    v = 0.5 * sum(exact_swirl(vortex, x, y + side, time)[1] for side in (-half, half))
    r = np.hypot(x, y)
    return time, r, np.maximum(np.abs(velocity[..., 0] - u), np.abs(velocity[..., 1] - v)), (x * velocity[..., 1] - y * velocity[..., 0]) / r


def draw_swirl(files, vortex, to):
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.6), constrained_layout=True)
    for path, colour in zip((files[0], files[-1]), ("#7a7f87", SEEN)):
        time, r, error, swirl = swirl_error(path, vortex)
        most = 0.6382 * vortex["circulation"] / (2 * np.pi * np.sqrt(vortex["core"] ** 2 + 4 * vortex["nu"] * time))
        left.plot(r.ravel(), swirl.ravel(), ".", ms=2, color=colour, label=f"t = {time:.4g} s")
        line = np.linspace(1e-6, r.max(), 400)
        left.plot(line, exact_swirl(vortex, line, 0 * line, time)[1], lw=1, color=INK)
        right.semilogy(r.ravel(), error.ravel() / most, ".", ms=2, color=colour)
        for within in (2, 4):
            print(f"t = {time:.4g} s: largest error of u or v within {within} cores of the axis {np.max(error[r < within * vortex['core']]) / most:.3%} of the largest velocity")
    left.set_xlabel("distance from the axis [m]"), left.set_ylabel("velocity round the axis [m/s]")
    right.set_xlabel("distance from the axis [m]"), right.set_ylabel("error over largest velocity")
    left.legend(frameon=False)
    for axes in (left, right):
        bare(axes, "left", "bottom")
    figure.savefig(to, dpi=150)
