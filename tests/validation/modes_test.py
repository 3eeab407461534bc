"""Frequencies about equilibria against Timoshenko's beam, closed forms and each other, at second order; neutral motions are counted."""

import math
import unittest

import numpy

from solved_scenes import SolvedScenes, of_circle, rod

HEAD = "[time]\nduration = 1.0\n"
LENGTH, RADIUS, E = 1.0, 0.02, 1e7
AREA, SECOND = math.pi * RADIUS**2, math.pi * RADIUS**4 / 4


def beam(most, start, end, shear=of_circle(E, RADIUS)[1][0], density=1000.0):
    """Lowest frequencies of Timoshenko's beam, Hz: deflection, turn, moment and shear force, of which two are 0 at each end."""
    def off(omega):
        rate = numpy.array([[0, 1, 0, 1 / shear], [0, 0, 1 / (E * SECOND), 0], [0, -density * SECOND * omega**2, 0, -1],
                            [-density * AREA * omega**2, 0, 0, 0]])
        values, vectors = numpy.linalg.eig(rate * LENGTH)
        transfer = (vectors * numpy.exp(values) @ numpy.linalg.inv(vectors)).real
        free = [i for i in range(4) if i not in start]
        return numpy.linalg.det(transfer[numpy.ix_(list(end), free)])

    scale, found = math.sqrt(E * SECOND / (density * AREA)) / LENGTH**2, []
    omega = 0.5 * scale
    while len(found) < most:
        if off(omega) * off(omega + 0.4 * scale) < 0:
            low, high = omega, omega + 0.4 * scale
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if off(middle) * off(low) > 0 else (low, middle)
            found.append(low / (2 * math.pi))
        omega += 0.4 * scale
    return found


CLAMPED, FREE, PINNED = (0, 1), (2, 3), (0, 2)


class Modes(SolvedScenes):
    def assert_pairs(self, name, text_of, exact, neutral, ns=(10, 20, 40), alike=1e-9):
        """Bending both ways of a round rod: each frequency twice."""
        lists = []
        for n in ns:
            found, still = self.modes(text_of(n), "--count", 2 * len(exact))
            self.assertEqual(still, neutral, name)
            self.assertLess(numpy.abs(found[0::2] / found[1::2] - 1).max(), alike, name)
            lists.append(found[0::2])
        return [self.assert_second_order(f"{name}, mode {i + 1}", [found[i] for found in lists], one) for i, one in enumerate(exact)]

    def test_beams(self):
        ends = {"clamped": 'start = "clamped"', "clamped at both ends": 'start = "clamped"\nend = "clamped"', "free": "",
                "pinned": 'start = "pinned"\nend = "pinned"'}
        for name, start, end, neutral, ns in (("clamped", CLAMPED, FREE, 0, (10, 20, 40)), ("clamped at both ends", CLAMPED, CLAMPED, 0, (20, 40, 80)),
                                              ("free", FREE, FREE, 6, (20, 40, 80)), ("pinned", PINNED, PINNED, 1, (20, 40, 80))):
            exact = beam(2, start, end)
            error = self.assert_pairs(name, lambda n: HEAD + rod("rod", LENGTH, n, E, RADIUS, more=ends[name]), exact, neutral, ns)
            if name == "clamped":
                for n, one in zip(ns, error[0]):
                    self.assertLess(abs(one) * n**2, 0.93)

    def test_string_under_tension(self):
        """A thread between pins that is stretched by 1e-3: k/(2 L) sqrt(T/mu) of the string, and what bending adds."""
        r, stretch = 2e-4, 1e-3
        tension, area, bending = E * stretch * math.pi * r**2, math.pi * r**2, of_circle(E, r)[0][0]
        exact = [k / 2 * math.sqrt(tension / (1000.0 * area * (1 + stretch)) * (1 + bending * (k * math.pi)**2 / tension)) for k in (1, 2)]
        ends = 'start = "pinned"\nend = "pinned"\nend_motion = {translation_formula = ["pulled*t", "0", "0"]}'
        head = HEAD + f'[constants]\npulled = {{value = {stretch}, unit = "m/s"}}\n'
        self.assert_pairs("string", lambda n: head + rod("rod", LENGTH, n, E, r, more=ends), exact, 1, (20, 40, 80), 1e-6)

    def test_joined_rods_move_as_one(self):
        """A clamped rod of two that share a node, over one rod of as many elements."""
        whole, _ = self.modes(HEAD + rod("rod", LENGTH, 20, E, RADIUS, more='start = "clamped"'), "--count", 6)
        text = HEAD + rod("first", 0.6 * LENGTH, 12, E, RADIUS, more='start = "clamped"') + rod("second", 0.4 * LENGTH, 8, E, RADIUS)
        text = text.rstrip().removesuffix("}") + f', origin = [{0.6 * LENGTH}, 0, 0]}}\n[[joint]]\nkind = "fixed"\nbetween = ["first", "second"]\n'
        joined, still = self.modes(text, "--count", 6)
        print(f"  joined rods: {numpy.abs(joined / whole - 1).max():.1e} off one rod")
        self.assertEqual(still, 0)
        self.assertLess(numpy.abs(joined / whole - 1).max(), 1e-6)

    def test_neutral_motions(self):
        """A round rod that hangs between pins turns about its own axis, bent as it is. A ring of one does so beside six motions as a rigid body;
        one of another section does not."""
        pinned = rod("rod", LENGTH, 20, E, RADIUS, more='start = "pinned"\nend = "pinned"') + '[[load]]\nkind = "gravity"\nacceleration = [0, 0, -5]\n'
        ring = rod("rod", LENGTH, 20, E, RADIUS).replace("elements = 20", f"elements = 20, closed = true, rest_curvature = [0.0, 0.0, 0.5], start_curvature = [{2 * math.pi}, 0.0, 0.0]")
        for name, text, neutral in (("hangs", pinned, 1), ("ring", ring, 7)):
            found, still = self.modes(HEAD + text)
            self.assertEqual(still, neutral, name)
            self.assertGreater(found[0], 0.1, name)
        flat = pinned.replace(f"radius = {RADIUS}", f'kind = "elliptic", radius = {RADIUS}, radius_2 = {0.5 * RADIUS}')
        self.assertEqual(self.modes(HEAD + flat)[1], 0)


if __name__ == "__main__":
    unittest.main()
