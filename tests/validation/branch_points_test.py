"""Critical loads as branch and limit points of paths, against closed forms and independent solutions, at second order."""

import cmath
import math
import unittest

import numpy

from solved_scenes import SHEAR, SolvedScenes, march, of_circle, of_rectangle, rod, rod_rate, root

HEAD = "[time]\nduration = 1.0\n"


def number(name, unit, value=1.0):
    return f'[constants]\n{name} = {{value = {value}, unit = "{unit}"}}\n'


def least_root(off, low, high, halvings=100):
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (off(middle) > 0) == (off(low) > 0) else (low, middle)
    return 0.5 * (low + high)


def tipping_weight(length, bending, stretching, rough):
    """Weight on the tip of a clamped strip on edge at which its plane solution has others beside it: moments at the clamp which leave the
    moments at the tip at 0."""
    scale, frame = bending[1] / length, numpy.array([0, 0, 1, 0, -1, 0, 1, 0, 0], float)

    def tip(moments, weight):
        columns = moments.shape[1]
        start = numpy.concatenate([numpy.zeros((3, columns)), numpy.repeat(frame[:, None], columns, 1), scale * moments])
        force = numpy.repeat(numpy.array([0, 0, -weight])[:, None], columns, 1)
        return march(rod_rate(bending, stretching, lambda s, y: force), start, length)[12:] / scale

    def slopes(weight):
        plane = numpy.array([0, weight * length / scale, 0])
        own = root(lambda m: tip(numpy.concatenate([0 * m, m, 0 * m]), weight)[1:2], plane[1:2])
        at, h = numpy.array([0, own[0], 0]), 1e-5
        columns = tip(numpy.stack([at + [h, 0, 0], at - [h, 0, 0], at + [0, 0, h], at - [0, 0, h]], axis=1), weight)[[0, 2]]
        return numpy.linalg.det(numpy.stack([columns[:, 0] - columns[:, 1], columns[:, 2] - columns[:, 3]], axis=1) / (2 * h))

    weights = [0.97 * rough, 1.03 * rough]
    values = [slopes(weight) for weight in weights]
    for _ in range(6):
        weights.append(weights[-1] - values[-1] * (weights[-1] - weights[-2]) / (values[-1] - values[-2]))
        values.append(slopes(weights[-1]))
        if abs(weights[-1] / weights[-2] - 1) < 1e-10:
            break
    return weights[-1]


def lees_frame(n):
    """apps/mechanisms/frame.toml with n elements a member and a weight in place of the press."""
    members = {"column": ((0, 1, 0), (0, 0, 0), 1.2, n), "inner": ((1, 0, 0), (0, 1.2, 0), 0.24, n // 5),
               "outer": ((1, 0, 0), (0.24, 1.2, 0), 0.96, n - n // 5)}
    text = HEAD + number("weight", "N")
    for name, (tangent, origin, length, elements) in members.items():
        inner = f'hold = {{nodes = {list(range(1, elements))}, directions = "z"}}'
        text += rod(name, length, elements, 7.2e10, 'kind = "rectangular", radius = 0.015, radius_2 = 0.01', tangent, more=inner)
        text = text.rstrip().removesuffix("}") + f", origin = {list(origin)}}}\n"
    for name, at in (("column", 0.0), ("outer", 1.0)):
        text += (f'[[joint]]\nkind = "hinge"\nbetween = ["{name}", "world"]\nat = [{at}]\naxis = [0, 0, 1]\nstiffness = 1e9\n'
                 "torsional_stiffness = 1e4\n")
    text += '[[joint]]\nkind = "fixed"\nbetween = ["column", "inner"]\n[[joint]]\nkind = "fixed"\nbetween = ["inner", "outer"]\n'
    return text + '[[load]]\nkind = "formula"\nrods = ["inner"]\nat = "end"\nforce = ["0", "-weight", "0"]\n'


def lees_limits(length=1.2, E=7.2e10, area=6e-4, second=2e-8, stride=1.0):
    """First largest and least weight of a plane rod that bends, stretches and shears, along the curve of its solutions by arc length. Unknown
    are the reactions at the foot, the angle there and the weight; the far end is in its place without a moment."""
    shear, unit = SHEAR * E / 3 * area, E * second / length**2

    def member(y, across, up, part):
        def rate(_, y):
            c, s = numpy.cos(y[2]), numpy.sin(y[2])
            along, aside = 1 + (across * c + up * s) / (E * area), (up * c - across * s) / shear
            dx, dy = along * c - aside * s, along * s + aside * c
            return numpy.stack([dx, dy, y[3] / (E * second), dy * across - dx * up])
        return march(rate, y, part * length, 24)

    def off(x):
        across, up, weight, zero = -unit * x[0], -unit * x[1], unit * x[3], 0 * x[0]
        corner = member(numpy.stack([zero, zero, math.pi / 2 + x[2], zero]), across, up, 1) - numpy.array([[0], [0], [math.pi / 2], [0]])
        end = member(member(corner, across, up, 0.2), across, up + weight, 0.8)
        return numpy.stack([end[0] / length - 1, end[1] / length - 1, end[3] / (unit * length)])

    def tangent(x):
        h = 1e-5
        columns = off(x[:, None] + h * numpy.concatenate([numpy.eye(4), -numpy.eye(4)], axis=1))
        return numpy.linalg.svd((columns[:, :4] - columns[:, 4:]) / (2 * h))[2][3]

    def ahead(x, way, step):
        return root(lambda y: numpy.concatenate([off(y), (way @ (y - x[:, None]) - step)[None]]), x + step * way)

    def along_weight(own, way):
        return own[3] if own @ way > 0 else -own[3]

    x, way, limits = numpy.zeros(4), numpy.array([0, 0, 0, 1.0]), []
    while len(limits) < 2:
        own = tangent(x)
        own = own if own @ way > 0 else -own
        if own[3] * way[3] < 0:  # the weight turned in the last step
            share = least_root(lambda step: along_weight(tangent(ahead(before, way, step)), way), 0, stride, 24)
            limits.append(unit * ahead(before, way, share)[3])
        before, way = x, own
        x = ahead(x, way, stride)
    return limits


def helix_moment(tension):
    """M L/B for T L^2/B: y is 1, s, exp(r1 s) and exp(r2 s) with r = i (a +- d)."""
    def off(moment):
        a, d = moment / 2, cmath.sqrt(moment**2 / 4 - tension)
        r1, r2 = 1j * (a + d), 1j * (a - d)
        e1, e2 = cmath.exp(r1), cmath.exp(r2)
        ends = numpy.linalg.det([[1, 0, 1, 1], [0, 1, r1, r2], [1, 1, e1, e2], [0, 1, r1 * e1, r2 * e2]])
        return (ends / d * cmath.exp(-1j * a)).imag

    values = 2.002 * math.sqrt(tension) + numpy.linspace(0, 20, 400)
    after = next(i for i in range(1, 400) if off(values[i]) * off(values[i - 1]) < 0)
    return least_root(off, values[after - 1], values[after])


class BranchPoints(SolvedScenes):
    def first_branch(self, text, *arguments):
        found = self.places(text, "branch", *arguments)
        self.assertTrue(found, "no branch point")
        return found[0]

    def test_columns(self):
        """Euler's loads with shear and shortening: P (1 - P/(E A) + P/(alpha G A)) = B k^2 of the law "linear"."""
        r = 0.05
        bending, stretching = of_circle(1.0, r)
        for name, ends, k in (("cantilever", 'start = "clamped"', math.pi / 2),
                              ("guided column", 'start = "clamped"\nend = "clamped"\nend_free = "xz"', math.pi),
                              ("sliding clamp", 'start = "clamped"\nend = "clamped"\nend_free = "z"', 2 * math.pi)):
            slender = k * k * bending[0]
            exact = least_root(lambda p: p * (1 - p / stretching[2] + p / stretching[0]) - slender, 0, 2 * slender)
            loads = []
            for n in (10, 20, 40):
                text = HEAD + rod("rod", 1.0, n, 1.0, r, (0, 0, 1), (1, 0, 0), more=ends)
                text += f'[[load]]\nkind = "end_force"\nend = [0, 0, {-0.1 * exact}]\n'
                loads.append(self.first_branch(text, "--along", "load.0.end.2", "--to", -1.2 * exact, "--points", 60))
            error = self.assert_second_order(f"Euler's load, {name}", [-load for load in loads], exact)
            for n, one in zip((10, 20, 40), error):
                self.assertAlmostEqual(-one / ((k / n)**2 / 12), 1, delta=0.2)

    def test_heavy_column(self):
        """Greenhill's: q L^3/B = 9/4 of the square of the first zero of J_{-1/3}, by a path and by the lowest frequency."""
        def bessel(x):
            return sum((-1)**m * (x / 2)**(2 * m) / math.factorial(m) / math.gamma(m + 2 / 3) for m in range(30))

        length, r, E = 1.0, 1e-3, 1e9
        bending, stretching = of_circle(E, r)
        exact = 9 / 4 * least_root(bessel, 1, 3)**2 * bending[0] / length**3 / (1000 * math.pi * r**2)
        loads, zeros = [], []
        for n in (10, 20, 40):
            text = HEAD + rod("rod", length, n, E, r, (0, 0, 1), (1, 0, 0), more='start = "clamped"')
            text += f'[[load]]\nkind = "gravity"\nacceleration = [0, 0, {-0.5 * exact}]\n'
            loads.append(-self.first_branch(text, "--along", "load.0.acceleration.2", "--to", -1.2 * exact, "--points", 40))
            lowest = [self.modes(text, "--set", f"load.0.acceleration.2={-loads[-1] * share}")[0][0] for share in (0.98, 0.99)]
            squares = [f * abs(f) for f in lowest]
            zeros.append(loads[-1] * (0.99 + 0.01 * squares[1] / (squares[0] - squares[1])))
        self.assert_second_order("Greenhill's column", loads, exact)
        self.assert_second_order("Greenhill's column, frequency to 0", zeros, exact)

    def test_strips_on_edge(self):
        """Weights at which cantilevers of sections 1:2 to 1:10 tip over, with the deflection before."""
        E, G, length, b = 2e9, 7.5e8, 0.5, 0.02
        for ratio in (2, 5, 10):
            t = b / ratio
            bending, stretching = of_rectangle(E, G, b, t, 0.8333)
            rough = 4.0126 * math.sqrt(bending[0] * bending[2]) / length**2
            rough /= math.sqrt((1 - bending[0] / bending[1]) * (1 - bending[2] / bending[1]))
            exact = tipping_weight(length, bending, stretching, rough)
            section = (f'kind = "rectangular", radius = {b / 2}, radius_2 = {t / 2}, shear_factors = [0.8333, 0.8333], '
                       f'torsion_constant = {bending[2] / G}')
            loads = []
            for n in (20, 40, 80):
                text = HEAD + rod("rod", length, n, E, section, more='start = "clamped"', shear_modulus=G)
                text += f'[[load]]\nkind = "end_force"\nend = [0, 0, {-0.1 * exact}]\n'
                loads.append(-self.first_branch(text, "--along", "load.0.end.2", "--to", -1.2 * exact, "--points", 60))
            self.assert_second_order(f"strip 1:{ratio}, {exact * length**2 / bending[1]:.3f} EI2/L^2", loads, exact)

    def test_twisted_ring(self):
        """A thin ring buckles at sqrt(3) B/C turns (Zajac 1962)."""
        E, G, r = 1e9, 7.5e8, 1.6e-4
        bending, _ = of_circle(E, r, G)
        exact = math.sqrt(3) * bending[0] / bending[2] * 2 * math.pi
        twists = []
        for n in (20, 40, 80):
            ring = rod("ring", 1.0, n, E, r, shear_modulus=G)
            ring = ring.replace(f"elements = {n}", f"elements = {n}, closed = true, rest_curvature = [0.0, 0.0, {0.5 * exact}], "
                                f"start_curvature = [{2 * math.pi}, 0.0, 0.0]")
            twists.append(self.first_branch(HEAD + ring, "--along", "rods.ring.shape.rest_curvature.2", "--to", 1.2 * exact, "--points", 40))
        self.assert_second_order("twisted ring", twists, exact)

    def test_twisted_rod_under_tension(self):
        """Turns at which a thin rod between clamps becomes a helix: B y'''' - i M y''' - T y'' = 0, clamped at both ends, y across in the
        complex plane; M goes to 8.9868 B/L where T goes to 0."""
        self.assertAlmostEqual(helix_moment(1e-2), 8.98682, delta=2e-3)
        E, G, r = 1e9, 4e8, 3e-4
        bending, stretching = of_circle(E, r, G)
        for tension in (1.0, 100.0):  # in B/L^2
            exact = helix_moment(tension) * bending[0] / bending[2]
            stretch = tension * bending[0] / stretching[2]
            turns = []
            for n in (20, 40, 80):
                motion = f'translation_formula = ["0", "0", "pulled*t"], rotation_formula = ["0", "0", "angle*t"]'
                text = HEAD + number("angle", "1/s") + f'pulled = {{value = {stretch!r}, unit = "m/s"}}\n'
                text += rod("rod", 1.0, n, E, r, (0, 0, 1), (1, 0, 0), 'start = "clamped"\nend = "clamped"\nend_motion = {' + motion + "}", shear_modulus=G)
                turns.append(self.first_branch(text, "--along", "constants.angle.value", "--from", 0.5 * exact, "--to", 1.1 * exact, "--points", 200, "--step", 0.5))
            self.assert_second_order(f"helix, T = {tension:g} B/L^2", turns, exact)

    def test_sides_of_an_arch(self):
        """An arch under a push leaves its mirror symmetry to either side, at the same push for any step. Its stiffness there is singular to
        rounding, so that neither the tangent nor a solution is to be trusted."""
        def arch(side, step):
            ends = ('start = "clamped"\nend = "clamped"\nstart_motion.rotation_formula = ["0", "angle*t", "0"]\n'
                    'end_motion.rotation_formula = ["0", "-angle*t", "0"]')
            tangent = (math.cos(0.6), 0, math.sin(0.6))
            text = HEAD + number("push", "N", 0.0) + 'angle = {value = 0.6, unit = "1/s"}\n'
            text += rod("arch", 0.3, 40, 2.1e11, 'kind = "rectangular", radius = 0.005, radius_2 = 1e-4', tangent, (0, 1, 0), ends)
            text = text.replace("elements = 40", "elements = 40, start_curvature = [4.0, 0.0, 0.0]")
            text += '[[load]]\nkind = "formula"\nper = "rod"\nforce = ["0", "0", "-push"]\n[[probe]]\nname = "middle"\nof = "arch"\nat = 0.5\n'
            return self.path(text, "--along", "constants.push.value", "--to", 2, "--step", step, "--points", 40, "--branch", side)

        pushes = []
        for step in (0.05, 0.02):
            left, right = arch(-1, step), arch(1, step)
            at = next(i for i, row in enumerate(left) if row["place"] == "branch")
            pushes.append(left[at]["value"])
            middle = float(left[at]["middle_x"])
            for one, other in zip(left[at + 1:], right[at + 1:]):
                self.assertAlmostEqual(float(one["middle_x"]) + float(other["middle_x"]), 2 * middle, delta=1e-7)
                self.assertAlmostEqual(one["value"], other["value"], delta=1e-5)
            self.assertGreater(abs(float(left[at + 5]["middle_x"]) - middle), 1e-5, "a side of the arch")
            self.assertLess(left[at + 1]["value"], pushes[-1], "under less push")
        self.assertAlmostEqual(pushes[0] / pushes[1], 1, delta=1e-5)

    def test_lees_frame(self):
        """Both limit loads of a column and a beam that meet in a stiff corner, between hinges."""
        exact = lees_limits()
        limits = {}
        for n in (10, 20, 40):
            limits[n] = self.places(lees_frame(n), "limit", "--along", "constants.weight.value", "--from", 0, "--to", 30000, "--points", 400)[:2]
        for i, name in enumerate(("largest", "least")):
            self.assert_second_order(f"Lee's frame, {name} load", [limits[n][i] for n in (10, 20, 40)], exact[i], orders=(1.85, 2.15))


if __name__ == "__main__":
    unittest.main()
