"""Slow flow past an ellipsoid in a cube of periods, against its closed form: plot.py draws it if one sharp ellipsoid rests there.

The force that holds the ellipsoid is F, the mean velocity of the cube U = M F. Without images M is of Oberbeck. Each point A n of the surface, with n
uniform on the unit sphere, has the same share of the force, so the images add the difference of a sum and an integral over wave vectors k of
(1 - k k / k^2) / (mu k^2) (sin |A k| / |A k|)^2. Changes of these shares by the images are neglected: of fifth order in size over edge.
"""

import json

import matplotlib.pyplot as plt
import numpy as np

from skein.own_file import OwnFile
from skein.style import INK, QUIET, bare, heading

SEEN = {"x": "#c8502d", "y": "#2d6fc8", "z": "#3f8f4f"}
CUT = 6.0  # of wave vectors, over the edge: what is cut off decays within an edge to 1e-6


def read_ellipsoid(directory):
    """Fluid and obstacle of the scene with its edge [m]; None if the scene has more or other bodies, or a box without periods."""
    scene = json.loads((directory / "physics.json").read_text())
    fluid, obstacles = scene["fluid"], scene.get("obstacle", [])
    if len(obstacles) != 1 or obstacles[0]["kind"] != "ellipsoid" or any(np.any(obstacles[0][key]) for key in ("velocity", "angular_velocity", "frequency")):
        return None
    if {fluid[f"along_{d}"] for d in "xyz"} != {"periodic"} or len(set(fluid["cells"])) != 1 or not np.any(fluid["acceleration"]):
        return None
    return fluid | {"edge": fluid["cells"][0] * fluid["spacing"], "obstacle": obstacles[0]}


def shape_of(obstacle):
    """Half axes as columns, [3][3], in m."""
    along = np.array(obstacle["axis"]) / np.linalg.norm(obstacle["axis"])
    first = np.array(obstacle["normal"]) if np.any(obstacle["normal"]) else np.eye(3)[int(abs(along[0]) > 0.9)]
    first = first - along * (first @ along)
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(along, first), along], axis=1) * obstacle["half_axes"]


def resistances(half_axes):
    """Force over velocity and viscosity along each axis, m: 16 pi / (chi + a^2 alpha), of Oberbeck 1876; midpoint rule, 1e-8."""
    share = (np.arange(20000) + 0.5) / 20000
    place = half_axes[0] ** 2 * share**2 / (1 - share) ** 2
    width = half_axes[0] ** 2 * 2 * share / (1 - share) ** 3 / len(share)
    to = half_axes**2 + place[:, None]
    term = width / np.sqrt(to.prod(axis=1))
    return 16 * np.pi / (term.sum() + half_axes**2 * (term[:, None] / to).sum(axis=0))


def over_waves(k, weight, shape, cut):
    """Sum over wave vectors k [n][3] of the integrand above with its weight, cut off beyond 2 cut as Hasimoto does."""
    square = (k**2).sum(axis=1)
    decay = square / (4 * cut**2)
    share = weight * np.sinc(np.linalg.norm(k @ shape, axis=1) / np.pi) ** 2 * (1 + decay) * np.exp(-decay) / square
    return share.sum() * np.eye(3) - np.einsum("n,ni,nj->ij", share / square, k, k)


def mobility(shape, edge):
    """Mean velocity of the cube over force and viscosity, [3][3], 1/m, to about (a / edge)^5 of it."""
    half_axes, cut = np.linalg.norm(shape, axis=0), CUT / edge
    axes = shape / half_axes
    counts = np.arange(-16, 17)
    waves = 2 * np.pi / edge * np.stack(np.meshgrid(counts, counts, counts, indexing="ij"), axis=-1).reshape(-1, 3)
    waves = waves[np.any(waves != 0, axis=1)]
    radial, radial_weight = np.polynomial.legendre.leggauss(80)
    height, height_weight = np.polynomial.legendre.leggauss(48)
    turn = 2 * np.pi * (np.arange(96) + 0.5) / 96
    flat = np.sqrt(1 - height**2)[:, None]
    sphere = np.stack([flat * np.cos(turn), flat * np.sin(turn), np.repeat(height[:, None], 96, axis=1)], axis=-1).reshape(-1, 3)
    sphere_weight = np.repeat(height_weight, 96) * 2 * np.pi / 96
    whole = np.zeros((3, 3))
    for k, weight in zip(6 * cut * (radial + 1), 6 * cut * radial_weight):
        whole += over_waves(k * sphere, sphere_weight * weight * k**2 / (2 * np.pi) ** 3, shape, cut)
    return axes @ np.diag(1 / resistances(half_axes)) @ axes.T + over_waves(waves, np.full(len(waves), edge**-3), shape, cut) - whole


def draw_flow(axes, path, ellipsoid, shape):
    """Speed and streamlines in the plane z = const through the centre."""
    centre = np.array(ellipsoid["obstacle"]["centre"])
    with OwnFile(path) as file:
        spacing, lower = file.attrs["spacing"], np.array([file.attrs[f"lower_{d}"] for d in "xyz"])
        velocity = file["velocity"][int((centre[2] - lower[2]) / spacing)].astype(float)
    x, y = (lower[d] + spacing * (np.arange(ellipsoid["cells"][d]) + 0.5) for d in (0, 1))
    extent = [edge for d in (0, 1) for edge in (lower[d], lower[d] + ellipsoid["edge"])]
    image = axes.imshow(np.linalg.norm(velocity, axis=-1), origin="lower", extent=extent, cmap="YlGnBu", vmin=0, interpolation="bilinear")
    place = np.stack([*np.meshgrid(x, y), np.full((len(y), len(x)), centre[2])], axis=-1) - centre
    level = np.linalg.norm(place @ np.linalg.inv(shape).T, axis=-1)
    velocity[level < 1] = np.nan
    axes.streamplot(x, y, velocity[..., 0], velocity[..., 1], color=QUIET, linewidth=0.7, density=1.3, arrowsize=0.7)
    axes.contourf(x, y, level, levels=[0, 1], colors=[INK])
    axes.set_xlabel("x [m]"), axes.set_ylabel("y [m]")
    heading(axes, "speed and streamlines")
    return image


def draw_drift(series, files, ellipsoid, to):
    """The flow, and mean velocities over time beside their closed form."""
    shape, volume = shape_of(ellipsoid["obstacle"]), ellipsoid["edge"] ** 3
    force = ellipsoid["density"] * volume * np.array(ellipsoid["acceleration"])
    expected = mobility(shape, ellipsoid["edge"]) @ force / ellipsoid["viscosity"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.2), constrained_layout=True)
    figure.colorbar(draw_flow(left, files[-1], ellipsoid, shape), ax=left, shrink=0.85).set_label("speed [m/s]")
    for d, value in zip("xyz", expected):
        if abs(value) < 1e-6 * np.abs(expected).max():
            continue
        found = series[f"fluid_momentum_{d}"] / (ellipsoid["density"] * volume)
        right.plot(series["time"], found, color=SEEN[d], label=f"along {d}")
        right.axhline(value, color=INK, lw=0.8, ls="--")
        print(f"mean velocity along {d} {found[-1]:.5g} m/s; closed form {value:.5g} m/s, difference {found[-1] / value - 1:+.2%}")
    right.set_xlabel("time [s]"), right.set_ylabel("mean velocity [m/s]")
    heading(right, "mean velocity; dashed: closed form")
    right.legend(frameon=False, loc="center right")
    bare(right, "left", "bottom")
    figure.savefig(to, dpi=150)
