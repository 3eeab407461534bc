#!/usr/bin/env python3
"""Writes the files of points of the worked cases, as imaging programs would: dish.csv, sag.csv, knit.csv, vessels.swc. All from formulas and fixed seeds.

  dish.csv     48 filaments of 5 to 15 mm in layers above a dish, in mm: in-plane curves of two harmonics, with 9 to 25 points each
  sag.csv      60 points of the image of a hair that sags, in mm, with errors of 0.1 mm in x and z; E = 4 GPa is what skein fit has to find.
               The exact shape is that of a clamped elastica under its weight, E I theta'' = w (L - s) cos(theta), by Newton's method
  knit.csv     six courses of plain knitting, in mm: x = W (u + 0.25 sin(4 pi u)), y = H cos(2 pi u) + P j, z = D cos(4 pi u), with u in loops
  vessels.swc  a tree that forks four times in space, in micrometres: radii by Murray's law, r^3 = r1^3 + r2^3
"""

import argparse
import pathlib

import numpy

HERE = pathlib.Path(__file__).parent
LOOP, HEIGHT, PITCH, DEPTH = 4.0, 2.8, 3.2, 0.64  # mm


def dish(count=48):
    """(rod, x, y, z, radius) of filaments that keep their distance within a layer."""
    random, layers, gap, rows = numpy.random.default_rng(49), [], 0.8, []
    for rod in range(count):
        length, points = random.uniform(5, 15), int(random.integers(9, 26))
        radius, bend = random.uniform(0.08, 0.14), random.normal(0, [1.2, 1.0])
        s = numpy.linspace(0, 1, 200)
        angle = random.uniform(0, 2 * numpy.pi) + bend[0] * numpy.cos(numpy.pi * s) + bend[1] * numpy.cos(2 * numpy.pi * s)
        curve = numpy.cumsum(numpy.stack([numpy.cos(angle), numpy.sin(angle)], axis=1), axis=0) * length / 200
        curve += random.uniform(-6, 6, 2) - curve.mean(axis=0)
        layer = next((k for k, others in enumerate(layers) if min(numpy.linalg.norm(curve[:, None] - other[None], axis=2).min() for other in others) > gap), len(layers))
        if layer == len(layers):
            layers.append([])
        layers[layer].append(curve)
        for x, y in curve[numpy.linspace(0, 199, points).round().astype(int)]:
            rows.append((rod, x, y, 0.3 + 0.4 * layer, radius))
    return rows


def sag(length=60.0, count=60, error=0.1, seed=7, nodes=2001):
    """(x, z) in mm of points of a hair of 40 um radius, 1300 kg/m^3 and 4 GPa."""
    weight, stiffness = 1300 * 9.81 * numpy.pi * 4e-5**2, 4e9 * numpy.pi / 4 * 4e-5**4
    s, h = numpy.linspace(0, length * 1e-3, nodes), length * 1e-3 / (nodes - 1)
    angle = numpy.zeros(nodes)
    for _ in range(30):  # second differences, theta(0) = 0 and theta'(L) = 0
        residual = numpy.zeros(nodes)
        residual[1:-1] = (angle[2:] - 2 * angle[1:-1] + angle[:-2]) / h**2 - weight / stiffness * (s[-1] - s[1:-1]) * numpy.cos(angle[1:-1])
        residual[0], residual[-1] = angle[0], (angle[-1] - angle[-2]) * 2 / h**2
        slope = numpy.diag(numpy.full(nodes, -2 / h**2)) + numpy.diag(numpy.full(nodes - 1, 1 / h**2), 1) + numpy.diag(numpy.full(nodes - 1, 1 / h**2), -1)
        slope[range(1, nodes - 1), range(1, nodes - 1)] += weight / stiffness * (s[-1] - s[1:-1]) * numpy.sin(angle[1:-1])
        slope[0], slope[-1] = 0, 0
        slope[0, 0], slope[-1, -1], slope[-1, -2] = 1, 2 / h**2, -2 / h**2
        change = numpy.linalg.solve(slope, -residual)
        angle += change
        if abs(change).max() < 1e-12:
            break
    middle = 0.5 * (angle[1:] + angle[:-1])
    x, z = (numpy.concatenate([[0], numpy.cumsum(part * h)]) for part in (numpy.cos(middle), numpy.sin(middle)))
    random = numpy.random.default_rng(seed)
    at = numpy.sort(random.uniform(0, s[-1], count))
    return 1e3 * numpy.stack([numpy.interp(at, s, x), numpy.interp(at, s, z)], axis=1) + random.normal(0, error, (count, 2))


def knit(courses=6, loops=5, points=16):
    """(course, x, y, z) along each yarn."""
    u = numpy.linspace(0, loops, loops * points + 1)
    for course in range(courses):
        x, y, z = LOOP * (u + 0.25 * numpy.sin(4 * numpy.pi * u)), HEIGHT * numpy.cos(2 * numpy.pi * u) + PITCH * course, DEPTH * numpy.cos(4 * numpy.pi * u)
        yield from ((course, *point) for point in zip(x, y, z))


def vessels(forks=4):
    """Rows of an SWC file: id, type, x, y, z, radius, parent."""
    rows = []

    def grow(place, way, across, radius, length, parent, left):
        for k in range(1, 6):
            here = place + way * length * k / 5 + 0.06 * length * numpy.sin(numpy.pi * k / 5) * across
            rows.append((len(rows) + 1, 3, *here, radius, parent))
            parent = len(rows)
        if not left:
            return
        large = radius * (1 / (1 + 0.75**3)) ** (1 / 3)  # Murray's law, with radii as 1 to 0.75
        third = numpy.cross(way, across)
        for side, thin, turn in ((1, large, 0.45), (-1, 0.75 * large, 0.75)):
            out = numpy.cos(turn) * way + side * numpy.sin(turn) * across
            grow(here, out, 0.8 * third + 0.6 * numpy.cross(third, out), thin, 0.8 * length if side > 0 else 0.65 * length, parent, left - 1)

    rows.append((1, 3, 0.0, 0.0, 0.0, 250.0, -1))
    grow(numpy.zeros(3), numpy.array([1.0, 0, 0]), numpy.array([0.0, 1, 0]), 250.0, 4000.0, 1, forks)
    return rows


def table(path, names, rows, places):
    text = "".join(",".join(f"{value:.{places}f}" if isinstance(value, float) else str(value) for value in row) + "\n" for row in rows)
    path.write_text(",".join(names) + "\n" + text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=pathlib.Path, default=HERE, help="files there are written over")
    folder = parser.parse_args().folder
    table(folder / "dish.csv", ("filament", "x", "y", "z", "radius"), dish(), 4)
    table(folder / "sag.csv", ("hair", "x", "z"), ((1, float(x), float(z)) for x, z in sag()), 4)
    table(folder / "knit.csv", ("yarn", "x", "y", "z"), knit(), 4)
    rows = "".join(f"{i} {kind} {x:.2f} {y:.2f} {z:.2f} {r:.2f} {parent}\n" for i, kind, x, y, z, r, parent in vessels())
    (folder / "vessels.swc").write_text("# id type x y z radius parent, micrometres\n" + rows)


if __name__ == "__main__":
    main()
