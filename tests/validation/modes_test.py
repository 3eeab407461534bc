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


def ring_frequencies(most, density=1000.0):
    """Lowest frequencies, Hz, of a ring with shear, stretch and rotary inertia: of n waves round it the energy of a displacement outwards, one along
    and a turn in the plane, or of a displacement across, a turn of the section and a twist."""
    radius, (bending, shear) = LENGTH / (2 * math.pi), of_circle(E, RADIUS)
    masses = density * numpy.array([AREA, AREA, SECOND]), density * numpy.array([AREA, SECOND, 2 * SECOND])
    found = []
    for n in range(2, 6):
        strains = (((numpy.array([1, n, 0]) / radius, shear[2]), (numpy.array([n / radius, 1 / radius, 1]), shear[0]), (numpy.array([0, 0, n]) / radius, bending[0])),
                   ((numpy.array([n / radius, 1, 0]), shear[0]), (numpy.array([0, n, 1]) / radius, bending[0]), (numpy.array([0, 1, n]) / radius, bending[2])))
        for parts, mass in zip(strains, masses):
            stiffness = sum(size * numpy.outer(strain, strain) for strain, size in parts)
            found.append(math.sqrt(numpy.linalg.eigvals(stiffness / mass[:, None]).real.min()) / (2 * math.pi))
    return sorted(found)[:most]


def member_stiffness(omega, length, density=1000.0):
    """Dynamic stiffness [12, 12] of a round rod along x with shear and rotary inertia, exact: places and turns of its start, then of its end."""
    (bending, _, twist), (shear, _, stretch) = of_circle(E, RADIUS)
    mass, spin, stiffness = density * AREA * omega**2, density * SECOND * omega**2, numpy.zeros((12, 12))

    def fill(slots, rate, signs=(1, 1)):
        """Of displacements and the forces on them, u' = rate u."""
        half = len(rate) // 2
        values, vectors = numpy.linalg.eig(rate * length)
        transfer = (vectors * numpy.exp(values) @ numpy.linalg.inv(vectors)).real
        by_end = numpy.linalg.inv(transfer[:half, half:])
        start = numpy.hstack([-by_end @ transfer[:half, :half], by_end])  # forces at the start
        end = numpy.hstack([transfer[half:, :half], numpy.zeros((half, half))]) + transfer[half:, half:] @ start
        sign = numpy.tile(signs[:half], 2)
        stiffness[numpy.ix_(slots, slots)] += sign[:, None] * numpy.vstack([-start, end]) * sign

    fill([0, 6], numpy.array([[0, 1 / stretch], [-mass, 0]]))
    fill([3, 9], numpy.array([[0, 1 / twist], [-2 * spin, 0]]))
    plane = numpy.array([[0, 1, 1 / shear, 0], [0, 0, 0, 1 / bending], [-mass, 0, 0, 0], [0, -spin, -1, 0]])
    fill([1, 5, 7, 11], plane)
    fill([2, 4, 8, 10], plane, (1, -1))
    return stiffness


def frame_frequencies(sides, most):
    """Lowest frequencies, Hz, of a free box of twelve rods with stiff corners, by counting negative eigenvalues of its dynamic stiffness
    (Wittrick, Williams): right below the lowest frequency of a rod that is clamped at both ends."""
    corners = numpy.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    edges = [(a, b) for a in range(8) for b in range(a + 1, 8) if numpy.abs(corners[a] - corners[b]).sum() == 1]

    def below(omega):
        all_of = numpy.zeros((48, 48))
        for a, b in edges:
            axis = int(numpy.argmax(numpy.abs(corners[b] - corners[a])))
            turn = numpy.kron(numpy.eye(4), numpy.roll(numpy.eye(3), axis, axis=1))  # local to lab axes
            at = [*range(6 * a, 6 * a + 6), *range(6 * b, 6 * b + 6)]
            all_of[numpy.ix_(at, at)] += turn.T @ member_stiffness(omega, sides[axis]) @ turn
        return int(numpy.sum(numpy.linalg.eigvalsh(0.5 * (all_of + all_of.T)) < 0))

    highest, found = 22.0 * math.sqrt(E * SECOND / (1000.0 * AREA)) / max(sides)**2, []
    for i in range(most):
        low, high = 1e-3 * highest, highest
        assert below(low) == 6 and below(high) >= 7 + i
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if below(middle) < 7 + i else (low, middle)
        found.append(low / (2 * math.pi))
    return found


def frame(sides, n):
    """The same as a scene: rods of n elements, joined at each corner."""
    corners = numpy.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    text, at = HEAD, {corner: [] for corner in range(8)}  # rods, and which of their ends
    for a in range(8):
        for axis in range(3):
            if corners[a][axis]: continue
            b = a + (4, 2, 1)[axis]
            name, tangent, normal = f"edge{a}{b}", numpy.roll([1, 0, 0], axis), numpy.roll([0, 1, 0], axis)
            one = rod(name, sides[axis], n, E, RADIUS, tangent.tolist(), normal.tolist())
            text += one.rstrip().removesuffix("}") + f", origin = {(corners[a] * sides).tolist()}}}\n"
            at[a].append((name, 0.0))
            at[b].append((name, 1.0))
    for first, *others in at.values():
        text += "".join(f'[[joint]]\nkind = "fixed"\nbetween = ["{first[0]}", "{other[0]}"]\nat = [{first[1]}, {other[1]}]\n' for other in others)
    return text


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

    def test_ring(self):
        """A circular ring that is free of stress, in its plane and out of it: each frequency twice."""
        ring = rod("ring", LENGTH, 0, E, RADIUS)
        self.assert_pairs("ring", lambda n: HEAD + ring.replace("elements = 0", f"elements = {n}, closed = true"), ring_frequencies(4), 6, (20, 40, 80))

    def test_frame_of_twelve_rods(self):
        """A free box with stiff corners and three different sides."""
        sides = (1.0, 0.8, 0.65)
        exact = frame_frequencies(sides, 4)
        lists = []
        for n in (6, 12, 24):
            found, still = self.modes(frame(sides, n), "--count", 4)
            self.assertEqual(still, 6)
            lists.append(found)
        for i, one in enumerate(exact):
            self.assert_second_order(f"frame, mode {i + 1}", [found[i] for found in lists], one)

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
