"""Scenes of apps/statics that snap: limit and branch points of their paths beside solutions by shooting and closed forms, at second order."""

import math
import pathlib
import unittest

import numpy

from branch_points_test import helix_moment, least_root
from solved_scenes import SolvedScenes, march, of_circle, of_rectangle, rod_rate, root

STATICS = pathlib.Path(__file__).resolve().parents[2] / "apps/statics"


def highest(curve, low, high):
    """Place and value of the maximum of a smooth function: the vertex of a parabola, three times."""
    for _ in range(4):
        x = numpy.linspace(low, high, 5)
        a, b, c = numpy.polyfit(x - x[2], [curve(one) for one in x], 2)
        at = x[2] - b / (2 * a)
        reach = 0.2 * (high - low)
        low, high = at - reach, at + reach
    return at, c - b * b / (4 * a)


def turned_strip(length, chord, bending, stretching, stride=0.15):
    """Least angle of the first clamp of an arch: a plane rod that bends, stretches and shears, along the curve of its solutions by arc length.
    Unknown are the force along and across the line of the clamps, the moment at the first clamp and its angle."""
    unit = bending / length

    def off(x):
        across, up = (10 * x[i] * unit / length for i in (0, 1))

        def rate(_, y):
            c, s = numpy.cos(y[2]), numpy.sin(y[2])
            along, aside = 1 + (across * c + up * s) / stretching[2], (up * c - across * s) / stretching[1]
            dx, dy = along * c - aside * s, along * s + aside * c
            return numpy.stack([dx, dy, y[3] / bending, dy * across - dx * up])
        end = march(rate, numpy.stack([0 * x[0], 0 * x[0], x[3], x[2] * unit]), length, 200)
        return numpy.stack([end[0] / length - chord / length, end[1] / length, end[2]])

    def tangent(x):
        h = 1e-5
        columns = off(x[:, None] + h * numpy.concatenate([numpy.eye(4), -numpy.eye(4)], axis=1))
        return numpy.linalg.svd((columns[:, :4] - columns[:, 4:]) / (2 * h))[2][3]

    def ahead(x, way, step):
        return root(lambda y: numpy.concatenate([off(y), (way @ (y - x[:, None]) - step)[None]]), x + step * way, 1e-9)

    # An arch between clamps in line has the slope A sin(2 pi s/L), with A^2/4 of the shortening.
    x, way = numpy.array([-0.4 * math.pi**2, 0, 4 * math.pi * math.sqrt(1 - chord / length), 0]), numpy.array([0, 0, 0, -1.0])
    x = ahead(x, way, 0)
    while True:
        own = tangent(x)
        own = own if own @ way > 0 else -own
        if own[3] > 0:  # the angle turned in the last step
            return -highest(lambda step: -ahead(before, way, step)[3], 0, stride)[1]
        before, way = x, own
        x = ahead(x, way, stride)


def angle_at_the_clamp(bond, tip):
    """Of a rod in a field against it, from the field's line: psi'' + bond sin(psi) = 0 back from the tip, where psi' = 0."""
    return march(lambda s, y: numpy.stack([y[1], -bond * numpy.sin(y[0])]), numpy.array([[tip], [0.0]]), 1.0, 400)[0, 0]


def without_end(turns, stiff, length):
    """Largest slack of a hockle in a rod without ends, and its angle b: Coyne's solution, D = 4 sqrt(B/T) sin b and turns M L/C + 4 b with
    M = 2 sqrt(B T) cos b. Both give D = 4 (B/C) L sin 2b/(turns - 4b), whose slope is 0 where turns = 4b - 2 tan 2b."""
    b = least_root(lambda b: 4 * b - 2 * math.tan(2 * b) - turns, math.pi / 4 + 1e-6, math.pi / 2)
    return -2 * stiff * length * math.cos(2 * b), b


def hockle(turns, length, bending, stretching):
    """Largest slack of a hockle between clamps, from its middle to one end. The half turn about x, on which the middle lies, leaves it as
    it is. Unknown are x, the force across and along, and the moment there, for each angle between the middle and the line of the clamps."""
    B, C = bending[0], bending[2]
    guess = {}

    def shoot(angle, x):
        zero, c, s = 0 * x[0], math.cos(angle), math.sin(angle)
        start = numpy.stack([x[0] * length, zero, zero, zero + 1, zero, zero, zero, zero + c, zero + s, zero, zero - s, zero + c,
                             zero, x[3] * B / length, x[4] * B / length])
        force = numpy.stack([zero, x[1], x[2]]) * B / length**2
        return march(rod_rate(bending, stretching, lambda s, y: force), start, length / 2, 600)

    def off(angle):
        def ends(x):
            y = shoot(angle, x)
            return numpy.stack([y[0] / length, y[1] / length, y[9], y[10], y[4] * math.cos(turns / 2) - y[3] * math.sin(turns / 2)])
        return ends

    def slack(angle):
        b = angle / 2
        if not guess:
            root_T = (turns - 4 * b) * C / (2 * B * math.cos(b))  # over L/sqrt(B)
            tension, moment = root_T**2, 2 * root_T * math.cos(b)
            rate = moment / (1 + math.cos(angle))
            own = numpy.array([0, -math.sin(angle), math.cos(angle)])
            m = moment * own + rate * (numpy.array([0, 0, 1]) - math.cos(angle) * own)
            guess["x"] = numpy.array([m[1] / tension, 0, tension, m[1], m[2]])
        guess["x"] = root(off(angle), guess["x"], 1e-10)
        return length - 2 * shoot(angle, guess["x"][:, None])[2, 0]

    angle = 2 * without_end(turns, B / C, length)[1]
    return highest(slack, angle - 0.04, angle + 0.04)[1]


class SnapThroughs(SolvedScenes):
    def of(self, name):
        return (STATICS / f"{name}.toml").read_text()

    def limits(self, name, n, *arguments, place="limit"):
        group = {"bistable_strip": "strip", "magnetic_cilium": "cilium", "hockling": "cable"}[name]
        held = {"bistable_strip": [], "magnetic_cilium": list(range(2, n + 1)), "hockling": [n // 2]}[name]
        sets = ("--set", f"rods.{group}.shape.elements={n}") + (("--set", f"rods.{group}.hold.nodes={held}") if held else ())
        return self.places(self.of(name), place, *sets, *arguments)

    def test_strip(self):
        """The turn at which an arch snaps, near that of a shallow arch."""
        length, angle = 0.3, 0.6
        chord = length * math.sin(angle) / angle
        bending, stretching = of_rectangle(2.1e11, 7e10, 0.01, 2e-4, 27 / 28)
        exact = turned_strip(length, chord, bending[0], stretching)
        small = 1.7818 * math.sqrt(1 - chord / length)  # of Gomez, Moulton and Vella
        print(f"  snaps at {exact:.6f}; of a shallow arch {small:.6f}")
        self.assertAlmostEqual(exact / -small, 1, delta=0.01)
        along = ("--along", "constants.turn.value", "--to", -0.6, "--points", 40)
        turns = [self.limits("bistable_strip", n, *along)[0] for n in (20, 40, 80)]
        self.assert_second_order("strip", turns, exact, richardson=2e-4)

    def test_cilium_in_a_rising_field(self):
        """M B A L^2/(E I) = pi^2/4: E I theta'' + M A B sin(theta) = 0, theta(0) = 0, theta'(L) = 0, for small theta."""
        exact = math.pi**2 / 4 * 1.85e5 * 2e-4**2 / 4 / (5000.0 * 0.02**2)
        along = ("--set", "constants.angle=0", "--along", "constants.strength.value", "--from", 0, "--to", 4.5e-3)
        fields = [self.limits("magnetic_cilium", n, *along, place="branch")[0] for n in (10, 20, 40)]
        self.assert_second_order("field at which a cilium bends", fields, exact)

    def test_cilium_in_a_field_that_turns(self):
        """It snaps, to either side, where the angle at the clamp is extreme among all pendulum solutions."""
        bond = 5000.0 * 4.5e-3 * 0.02**2 / (1.85e5 * 2e-4**2 / 4)
        tip, exact = highest(lambda tip: -angle_at_the_clamp(bond, tip), 1.0, 2.0)
        along = ("--along", "constants.angle", "--to", -1.5, "--points", 300)
        angles = {n: self.limits("magnetic_cilium", n, *along) for n in (10, 20, 40)}
        for i, side in ((0, -1), (1, 1)):
            self.assert_second_order(f"angle of the field, {side:+d}", [angles[n][i] for n in (10, 20, 40)], side * exact)

    def test_hockle(self):
        """The slack at which a hockle pops: between clamps, and beside that of a rod without ends."""
        length, turns = 1.0, 25.13274123
        bending, stretching = of_circle(1e9, 5e-4, 4e8)
        exact, endless = hockle(turns, length, bending, stretching), without_end(turns, bending[0] / bending[2], length)[0]
        print(f"  pops at {exact:.6f} m; without ends {endless:.6f} m")
        self.assertAlmostEqual(exact / endless, 1, delta=4e-3)
        along = ("--along", "constants.slack.value", "--to", 0.4, "--step", 0.15, "--points", 240, "--branch", 1)
        slacks = [self.limits("hockling", n, *along)[0] for n in (60, 120, 240)]
        self.assert_second_order("slack at which a hockle pops", slacks, exact)

    def test_helix(self):
        """The slack at which the straight cable buckles: its tension is such that its torque is that of a helix between clamps."""
        length, turns = 1.0, 25.13274123
        bending, stretching = of_circle(1e9, 5e-4, 4e8)
        moment = turns * bending[2] / bending[0]  # M L/B
        tension = least_root(lambda t: helix_moment(t) - moment, 10.0, moment**2 / 4)
        endless = moment**2 / 4
        print(f"  T L^2/B = {tension:.4f}; without ends {endless:.4f}, less pi^2 {endless - math.pi**2:.4f}")
        exact = -tension * bending[0] / (length**2 * stretching[2]) * length
        along = ("--along", "constants.slack.value", "--from", -2e-5, "--to", 2e-5)
        slacks = [self.limits("hockling", n, *along, place="branch")[0] for n in (50, 100, 200)]
        self.assert_second_order("slack of the straight cable", slacks, exact)


if __name__ == "__main__":
    unittest.main()
