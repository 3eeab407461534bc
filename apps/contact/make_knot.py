#!/usr/bin/env python3
"""Writes knot.toml: a rod, straight at rest, that starts as an open overhand knot with straight tails along x.

The core is the trefoil x = t^3 - 3 t, y = t^4 - 4 t^2, z = t^5/5 - 2 t up to |t| = 2, past its last crossing; an arc then turns the curve into
each tail. The program builds a rod from its curvatures, so the curve is cut into elements whose frames do not twist, and the rotation from each
to the next, over the element's length, is what the scene holds.
"""

import argparse
import pathlib

import numpy

TREFOIL_END = 2.0
ARC_RADIUS = 2.0  # of the turns into the tails, in the trefoil's own unit
SCENE = pathlib.Path(__file__).with_name("knot.toml")


def trefoil(t):
    return numpy.column_stack([t**3 - 3 * t, t**4 - 4 * t**2, t**5 / 5 - 2 * t])


def turn_to_x(point, direction, tail):
    """From a point along a direction into a tail along x, by an arc."""
    along = numpy.array([1.0, 0.0, 0.0])
    angle = numpy.arccos(direction @ along)
    inward = along - (along @ direction) * direction
    inward /= numpy.linalg.norm(inward)
    a = numpy.linspace(0, angle, 2001)[1:, None]
    arc = point + ARC_RADIUS * (numpy.sin(a) * direction + (1 - numpy.cos(a)) * inward)
    return numpy.vstack([arc, arc[-1] + numpy.linspace(0, tail, 2001)[1:, None] * along])


def curve(unit, tail):
    """Points close together, in metres; `tail` is the length of each straight part."""
    core = trefoil(numpy.linspace(-TREFOIL_END, TREFOIL_END, 20001))
    direction = core[-1] - core[-2]
    after = turn_to_x(core[-1], direction / numpy.linalg.norm(direction), tail / unit)
    half_turn = numpy.array([-1.0, 1.0, -1.0])  # about y: what the trefoil is symmetric under, run backwards
    return unit * numpy.vstack([(after * half_turn)[::-1], core, after])


def chords(points, elements):
    """Directions of the elements, and their length."""
    way = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(points, axis=0), axis=1))])
    nodes = numpy.column_stack([numpy.interp(numpy.linspace(0, way[-1], elements + 1), way, column) for column in points.T])
    steps = numpy.diff(nodes, axis=0)
    lengths = numpy.linalg.norm(steps, axis=1)
    return steps / lengths[:, None], lengths.mean()


def curvatures(directions, length, normal):
    """About d1, d2, d3 at every inner vertex, of frames carried along without twist."""
    d1, result = numpy.array(normal), []
    for before, after in zip(directions, directions[1:]):
        d1 = d1 - (d1 @ before) * before
        d1 /= numpy.linalg.norm(d1)
        axis = numpy.cross(before, after)
        sine = numpy.linalg.norm(axis)
        turn = axis / sine * numpy.arctan2(sine, before @ after) if sine > 1e-12 else numpy.zeros(3)
        result.append(numpy.array([turn @ d1, turn @ numpy.cross(before, d1), 0.0]) / length)
        if sine > 1e-12:  # Rodrigues
            unit, angle = axis / sine, numpy.linalg.norm(turn)
            d1 = numpy.cos(angle) * d1 + numpy.sin(angle) * numpy.cross(unit, d1) + (1 - numpy.cos(angle)) * (unit @ d1) * unit
    return numpy.array(result)


def number(value):
    return "0.0" if abs(value) < 5e-7 else repr(round(float(value), 6))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=int, default=200)
    parser.add_argument("--unit", type=float, default=0.05, help="metres per unit of the trefoil")
    parser.add_argument("--tail", type=float, default=0.2, help="length of each straight tail, m")
    parser.add_argument("--scene", type=pathlib.Path, default=SCENE, help="scene whose length, elements and profile are replaced")
    options = parser.parse_args()
    directions, length = chords(curve(options.unit, options.tail), options.elements)
    profile = curvatures(directions, length, [0.0, 0.0, 1.0])
    rows = [", ".join(f"[{number(x)}, {number(y)}, 0.0]" for x, y, _ in profile[i:i + 5]) for i in range(0, len(profile), 5)]
    new = [f"length = {options.elements * length:.6f}         # m\n", f"elements = {options.elements}\n",
           "start_curvature_profile = [  # 1/m; written by make_knot.py\n"] + [f"    {row},\n" for row in rows] + ["]\n"]
    before, rest = options.scene.read_text().split("[rods.shape]\n")
    options.scene.write_text(before + "[rods.shape]\n" + "".join(new) + "\n[rods.placement]" + rest.split("[rods.placement]")[1])


if __name__ == "__main__":
    main()
