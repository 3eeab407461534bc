#!/usr/bin/env python3
"""Rods in a fluid, and theory: rods.py OUT_DIR | rods.py --cylinder RATIO

OUT_DIR of rod_in_stokes_flow.toml, free_filament_in_shear.toml or rod_in_cross_flow.toml: draws OUT_DIR/drag.png, orbit.png or bend.png and prints how far the
rod is from theory. Of low_re_cilium.toml or cilia_row.toml: draws OUT_DIR/pumping.png, cilia over a beat in the plane of the last frame of fields, and prints what
they pump along their wall. --cylinder prints what theory there is of a cylinder whose length is RATIO diameters: its drag in Stokes flow without bounds beside that of a
slender body, and the ratio of axes of the spheroid that turns in shear as it does. Needs numpy, h5py and matplotlib.
"""

import argparse
import math
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
from skein.own_file import OwnFile  # noqa: E402
from skein.style import INK, QUIET, bare  # noqa: E402

SEEN, OTHER = "#c8502d", "#2d6fc8"
erfc = np.vectorize(math.erfc)

# Stokes flow. Velocities are those of forces 8 pi mu.


def of_forces(offset):
    """[..., 3, 3]: velocity at offsets from a force without bounds, 1/r + r r / r^3."""
    r = np.linalg.norm(offset, axis=-1)[..., None, None]
    return np.eye(3) / r + offset[..., :, None] * offset[..., None, :] / r**3


def of_images(place, edge, reach=3):
    """[places, 3]: velocity on the z axis along x, y and z, each for a force that way at 0, by what a cube of periods adds to it: its images, less the mean of all.
    Ewald sums of Hasimoto 1959; at 0 that is -2.837297 * 4/3 / edge."""
    xi = math.sqrt(math.pi) / edge
    points = np.stack([0 * place, 0 * place, place], axis=-1)
    velocity = np.zeros_like(points)
    for cell in np.ndindex(*[2 * reach + 1] * 3):
        cell = np.array(cell) - reach
        offset = points + cell * edge
        square = np.maximum((offset**2).sum(axis=-1), (1e-6 * edge) ** 2)
        r = np.sqrt(square)
        near = xi * np.exp(-square * xi**2) / math.sqrt(math.pi)
        far = erfc(xi * r) if cell.any() else erfc(xi * r) - 1
        velocity += ((2 * near / square + far / r**3) * (square + offset.T**2) - 4 * near).T
        if cell.any():
            k = 2 * math.pi / edge * cell
            k2 = k @ k
            share = 8 * math.pi / edge**3 * (1 + k2 / (4 * xi**2)) * math.exp(-k2 / (4 * xi**2)) * (1 - k**2 / k2) / k2
            velocity += np.cos(points @ k)[:, None] * share
    return velocity


def profile(length, radius, step, depth):
    """[points, 4]: rho, z, what a point stands for along the line, and its depth, on a line within a cylinder with flat ends, closer to its edges where it is denser."""
    points = []
    for half, on_side in ((0.5 * length, True), (radius, False)):
        from_edge = [0.01 * radius]
        while from_edge[-1] < half:
            from_edge.append(from_edge[-1] + step * min(radius, max(0.1 * radius, from_edge[-1])))
        from_edge = np.array(from_edge[:-1])
        for end in (-1, 1):
            for at, share in zip(from_edge, np.gradient(from_edge)):
                below = depth * min(at, radius)
                rho, z = (radius - below, 0.5 * length - at) if on_side else (radius - at, 0.5 * length - below)
                points.append((rho, end * z, share, below))
    return np.array(points)


def move_cylinder(length, radius, around, velocities, edge=None):
    """[(force [3], couple about y)] over mu, by which a cylinder along z with flat ends moves the fluid at each of `velocities`: functions of rho and z of (u, v, w), on its
    surface u cos(m t), -v sin(m t), w cos(m t) along r, t and z, m = `around`. Rings of forces within it, the weakest that bring the surface to that, by least squares. In
    a cube of periods of `edge` velocities are relative to the mean of the fluid."""
    rings, surface = profile(length, radius, 0.4, 0.5), profile(length, radius, 0.2, 0)
    angles = (0, 0.5 * math.pi) if around else (0,)
    places = [np.stack([surface[:, 0] * math.cos(t), surface[:, 0] * math.sin(t), surface[:, 1]], axis=-1) for t in angles]
    along = np.linspace(-length, length, 201)
    images = of_images(along, edge) if edge else np.zeros((len(along), 3))
    slopes = np.gradient(images[:, 2], along)
    columns, forces, couples = [], [], []
    for rho, z, _, below in rings:
        t = 2 * math.pi * (np.arange(max(24, int(8 * rho / below))) + 0.5) / max(24, int(8 * rho / below))
        c, s, none = np.cos(t), np.sin(t), 0 * t
        points = np.stack([rho * c, rho * s, none + z], axis=-1)
        cm, sm = np.cos(around * t), np.sin(around * t)
        kinds = np.stack([np.stack(kind, axis=-1) for kind in ((cm * c, cm * s, none), (sm * s, -sm * c, none), (none, none, cm))], axis=1) / len(t)
        force = kinds.sum(axis=0)
        seen = []
        for place in places:
            velocity = np.einsum("iqab,qkb->iak", of_forces(place[:, None] - points), kinds)
            for axis in range(3):  # images are far, so that rings are points on the axis to them
                velocity[:, axis] += np.interp(place[:, 2] - z, along, images[:, axis])[:, None] * force[:, axis]
            if around == 0:  # what keeps this without divergence off the axis: forces that are a pressure within must not move the fluid
                slope = np.interp(place[:, 2] - z, along, slopes)
                velocity[:, 2, 0] += 0.5 * rho * slope
                velocity[:, 0, 2] -= 0.5 * surface[:, 0] * slope
            seen.append(velocity)
        columns.append(np.concatenate([seen[0][:, 0], seen[0][:, 2]] + [one[:, 0] for one in seen[1:]]))
        forces.append(force), couples.append((points[:, 2, None] * kinds[..., 0] - points[:, 0, None] * kinds[..., 2]).sum(axis=0))
    matrix, forces, couples = np.concatenate(columns, axis=1), np.concatenate(forces), np.concatenate(couples)
    weight = np.tile(np.sqrt(surface[:, 0] * surface[:, 2]), len(angles) + 1)
    found = []
    for velocity in velocities:
        wanted = np.array([velocity(*point[:2]) for point in surface], dtype=float)
        strength = np.linalg.lstsq(matrix * weight[:, None], weight * np.concatenate([wanted[:, 0], wanted[:, 2], wanted[:, 1]][:len(angles) + 1]), rcond=1e-12)[0]
        found.append((8 * math.pi * strength @ forces, 8 * math.pi * strength @ couples))
    return found


def drag_of_cylinder(length, radius, edge=None):
    """F / (mu U) of motion sideways and lengthwise, m."""
    (sideways, _), = move_cylinder(length, radius, 1, [lambda rho, z: (1, 1, 0)], edge)
    (lengthwise, _), = move_cylinder(length, radius, 0, [lambda rho, z: (0, 0, 1)], edge)
    return np.array([sideways[0], lengthwise[2]])


def spheroid_of_cylinder(length, radius):
    """Ratio of axes of the spheroid that turns in shear as the cylinder does: squared, the couple on it across the shear over that along it (Cox 1971)."""
    (_, across), (_, along) = move_cylinder(length, radius, 1, [lambda rho, z: (z, z, 0), lambda rho, z: (0, 0, rho)])
    return math.sqrt(-across / along)


def tell_cylinder(ratio):
    sideways, lengthwise = drag_of_cylinder(ratio, 0.5) / (math.pi * ratio)
    slender = math.log(2 * ratio)
    print(f"drag sideways    4 pi mu U L / (ln(L/a) + C): C = {4 / sideways - slender:+.4f}; -1/2 + ln 2 = {math.log(2) - 0.5:+.4f} where L/a has no end")
    print(f"drag lengthwise  2 pi mu U L / (ln(L/a) + C): C = {2 / lengthwise - slender:+.4f}; -3/2 + ln 2 = {math.log(2) - 1.5:+.4f}")
    print(f"turns in shear as a spheroid of {spheroid_of_cylinder(ratio, 0.5):.3f}")


def shape_of(results):
    """Fluid, the only group of rods, its physics, length and radius."""
    rods, = results.rods
    return results.physics["fluid"], rods, rods.physics, rods.physics["shape"]["length"], rods.physics["section"]["radius"]


def draw_drag(results, to):
    fluid, rods, physics, length, radius = shape_of(results)
    series, cells, spacing = results.series, fluid["cells"], fluid["spacing"]
    edge = cells[0] * spacing
    velocity = np.array(physics["shape"]["velocity"])
    axis = int(np.argmax(np.abs(physics["placement"]["tangent"])))
    if len(set(cells)) > 1 or np.count_nonzero(physics["placement"]["tangent"]) > 1 or radius > 0.05 * edge:
        sys.exit(f"{results.directory}: theory is of a thin rod along an axis of a cube")
    side = next((d for d in range(3) if d != axis and velocity[d]), None)
    theory = drag_of_cylinder(length, radius, edge)
    radii = np.array([0.6, 0.8, 1.0, 1.25, 1.6]) * radius
    drags = np.array([drag_of_cylinder(length, r, edge) for r in radii])
    figure, axes = plt.subplots(figsize=(6, 4), constrained_layout=True)
    for direction, kind, colour in ((side, 0, SEEN), (axis, 1, OTHER)):
        if direction is None or not velocity[direction]:
            continue
        name, letter = ("sideways", "lengthwise")[kind], "xyz"[direction]
        relative = velocity[direction] - series[f"fluid_momentum_{letter}"] / (fluid["density"] * edge**3)
        drag = -series[f"{rods.name}_fluid_force_{letter}"][1:] / (fluid["viscosity"] * relative[1:])
        axes.plot(series["time"][1:], drag / length, color=colour, label=name)
        axes.axhline(theory[kind] / length, lw=1, ls="--", color=colour)
        late = drag[len(drag) // 2:]
        print(f"{name}: F / (mu U L) = {late.mean() / length:.4f} +- {late.std() / length:.4f}, of a cylinder {theory[kind] / length:.4f}: {late.mean() / theory[kind] - 1:+.2%}")
        print(f"    a cylinder of a radius of {np.interp(late.mean(), drags[:, kind], radii) / spacing:.3f} cells would have this drag; the rod's is {radius / spacing:.3f}")
    axes.plot([], [], lw=1, ls="--", color=QUIET, label="cylinder in a cube of periods")
    axes.set_xlabel("time [s]"), axes.set_ylabel("$F / (\\mu U L)$"), axes.set_ylim(bottom=0)
    axes.legend(frameon=False)
    bare(axes, "left", "bottom")
    figure.savefig(to, dpi=150)


def jeffery(time, start, shear, ratio):
    """Angle of a spheroid from the flow, in its plane; it turns by -pi in half a period, pi (ratio + 1 / ratio) / shear."""
    turn = math.atan2(math.sin(start) * ratio, math.cos(start)) - shear * time / (ratio + 1 / ratio)
    return np.unwrap(np.arctan2(np.sin(turn), ratio * np.cos(turn)))


def draw_orbit(results, to):
    fluid, rods, physics, length, radius = shape_of(results)
    time, nodes = np.array(results.time), np.array(rods.position[:][:, 0], dtype=float)
    ends = nodes[:, -1] - nodes[:, 0]
    angle = np.unwrap(np.arctan2(ends[:, 1], ends[:, 0]))
    shear = (fluid["upper_wall_velocity"][0] - fluid["lower_wall_velocity"][0]) / (fluid["cells"][1] * fluid["spacing"])
    ratio = spheroid_of_cylinder(length, radius)
    lengths = np.linalg.norm(np.diff(nodes, axis=1), axis=-1).sum(axis=1)
    figure, axes = plt.subplots(figsize=(6, 4), constrained_layout=True)
    axes.plot(time, np.degrees(jeffery(time, angle[0], shear, ratio)), color=INK, lw=1, label=f"Jeffery 1922, ratio of axes {ratio:.2f}")
    axes.plot(time, np.degrees(angle), "o", ms=3, color=SEEN, label="rod")
    axes.set_xlabel("time [s]"), axes.set_ylabel("angle from the flow [degrees]")
    axes.legend(frameon=False)
    bare(axes, "left", "bottom")
    figure.savefig(to, dpi=150)
    print(f"Re = {fluid['density'] * shear * length**2 / fluid['viscosity']:.3g} of its length; length within {np.abs(lengths / length - 1).max():.2%} of that at rest")
    first = int(np.searchsorted(time, 0.5 / shear))  # the start at rest is over
    turned = np.flatnonzero(angle < angle[first] - math.pi)
    if not len(turned):
        return print(f"turned by {np.degrees(angle[0] - angle[-1]):.4g} degrees; Jeffery's spheroid by {np.degrees(angle[0] - jeffery(time, angle[0], shear, ratio)[-1]):.4g}")
    last = turned[0]
    half = np.interp(math.pi - angle[first], -angle[last - 1:last + 1], time[last - 1:last + 1]) - time[first]
    theory = math.pi * (ratio + 1 / ratio) / shear
    print(f"half a period {half:.4g} s, Jeffery's with a ratio of axes of {ratio:.3f} {theory:.4g} s: {half / theory - 1:+.2%}")


def draw_bend(results, to):
    fluid, rods, physics, length, radius = shape_of(results)
    density, speed, diameter, series = fluid["density"], fluid["inflow"][0], 2 * radius, results.series
    gravity = sum(np.linalg.norm(load["acceleration"]) for load in results.physics["load"] if load["kind"] == "gravity")
    reynolds = density * speed * diameter / fluid["viscosity"]
    drag = (1.13 + 11.4 / reynolds**0.808) ** 0.952
    cauchy = 2 / math.pi * drag * density * speed**2 / ((physics["material"]["density"] - density) * gravity * diameter)
    angle = 90 - 90 / (1 + 3.32 * cauchy**1.33) ** 0.407
    time, nodes = np.array(results.time), np.array(rods.position[:][:, 0], dtype=float)
    down = lambda way: np.degrees(np.arctan2(way[..., 0], -way[..., 2]))  # noqa: E731
    chord, tip = down(nodes[:, -1] - nodes[:, 0]), down(nodes[:, -1] - nodes[:, -2])
    height = nodes[-1, 0, 2] - nodes[-1, -1, 2]
    force = series[f"{rods.name}_fluid_force_x"]
    seen = force[-1] / (0.5 * density * speed**2 * diameter * height)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 4), constrained_layout=True)
    left.plot(nodes[-1, :, 0] - nodes[-1, 0, 0], nodes[-1, :, 2] - nodes[-1, 0, 2], color=SEEN, lw=3)
    left.plot([0, length * math.sin(math.radians(angle))], [0, -length * math.cos(math.radians(angle))], color=INK, lw=1, ls="--")
    left.set_aspect("equal"), left.set_xlabel("x [m]"), left.set_ylabel("z [m]")
    right.plot(time, tip, color=SEEN, label="of the last element"), right.plot(time, chord, color=OTHER, label="of the line to the tip")
    right.axhline(angle, color=INK, lw=1, ls="--", label="Silva-Leon and Cioncolini 2018")
    right.set_xlabel("time [s]"), right.set_ylabel("angle from the vertical [degrees]")
    right.legend(frameon=False)
    bare(left, "left", "bottom"), bare(right, "left", "bottom")
    figure.savefig(to, dpi=150)
    print(f"Re = {reynolds:.3g}, drag over weight {cauchy:.3g}")
    print(f"angle from the vertical: of the last element {tip[-1]:.2f}, of the line to the tip {chord[-1]:.2f}, published {angle:.2f} degrees; "
          f"changed by {tip[-1] - tip[-2]:+.3f} since the frame before")
    print(f"drag coefficient {seen:.4f} of what the rod shows to the stream, published {drag:.4f}: {seen / drag - 1:+.2%}")


def draw_pumping(results, to):
    fluid, rods, physics, *_ = shape_of(results)
    beat, series = results.constants["beat"], results.series
    frames = sorted(results.directory.glob("fields_*.h5"))
    if not frames:
        sys.exit(f"{results.directory}: has no fields_*.h5; set output.fields in the scene")
    volume = np.prod(np.array(fluid["cells"]) * fluid["spacing"])
    time, along = series["time"] / beat, series["fluid_momentum_x"] / (fluid["density"] * volume)
    with OwnFile(frames[-1]) as file:
        spacing, lower, when = file.attrs["spacing"], [file.attrs[f"lower_{d}"] for d in "xyz"], file.attrs["time"]
        plane = int((physics["placement"]["origin"][1] - lower[1]) / spacing + 1e-9)
        across = file["velocity"][:, plane, :, 0]
    nodes, times = rods.position, np.array(results.time)
    last = [int(np.argmin(np.abs(times - (when - beat * k / 8)))) for k in range(8)]
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.6), width_ratios=(3, 2), constrained_layout=True)
    edges = [lower[d] + spacing * np.arange(fluid["cells"][d] + 1) for d in range(3)]
    most = np.abs(across).max()
    shown = left.pcolormesh(edges[0], edges[2], across, cmap="RdBu_r", vmin=-most, vmax=most, rasterized=True)
    figure.colorbar(shown, ax=left, label="velocity along the wall [m/s]", shrink=0.8)
    for at in reversed(last):
        now = at == last[0]
        for rod in np.asarray(nodes[at], float):
            left.plot(rod[:, 0], rod[:, 2], color=INK, lw=2 if now else 0.6, alpha=1 if now else 0.5)
    left.set_aspect("equal")
    left.set(xlim=(edges[0][0], edges[0][-1]), xlabel="x [m]", ylabel="z [m]")
    right.axhline(0, color=QUIET, lw=0.6)
    right.plot(time, along, color=SEEN)
    right.set(xlabel="time [beats]", ylabel="mean velocity along the wall [m/s]")
    bare(left, "left", "bottom")
    bare(right, "left", "bottom")
    figure.savefig(to, dpi=150)
    over = time > time[-1] - 1 + 1e-9
    print(f"mean velocity of the fluid along the wall over the last beat {along[over].mean():+.4f} m/s; between {along[over].min():+.3f} and {along[over].max():+.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out_dir", type=Path, nargs="?")
    parser.add_argument("--cylinder", type=float, metavar="RATIO", help="tell theory of a cylinder of this length over its diameter")
    given = parser.parse_args()
    if given.cylinder:
        return tell_cylinder(given.cylinder)
    if not given.out_dir:
        parser.error("give OUT_DIR, or --cylinder RATIO")
    results = skein.open(given.out_dir)
    fluid = results.physics.get("fluid")
    if not fluid or len(results.rods) != 1:
        sys.exit(f"{given.out_dir}: is not rods of one group in a fluid")
    bounds, alone = [fluid[f"along_{d}"] for d in "xyz"], results.rods[0].count == 1
    for name, draw, fits in (("drag", draw_drag, alone and bounds == ["periodic"] * 3 and np.any(results.rods[0].physics["shape"]["velocity"])),
                             ("orbit", draw_orbit, alone and bounds == ["periodic", "no_slip", "periodic"]),
                             ("bend", draw_bend, alone and bounds[0] == "through"),
                             ("pumping", draw_pumping, bounds == ["periodic", "periodic", "no_slip"] and "beat" in results.constants)):
        if fits:
            draw(results, given.out_dir / f"{name}.png")
            return print(given.out_dir / f"{name}.png")
    sys.exit(f"{given.out_dir}: is none of the scenes that rods.py knows")


if __name__ == "__main__":
    needs.in_words(main)
