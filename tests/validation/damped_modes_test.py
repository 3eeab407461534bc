"""Small motions with damping, loads without a potential and spinning rods against closed forms: decay and frequency of every damper, flutter, whirl."""

import math
import subprocess
import unittest

import numpy

from driver import SKEIN
from modes_test import AREA, CLAMPED, E, FREE, HEAD, LENGTH, RADIUS, SECOND, beam
from solved_scenes import SolvedScenes, of_circle, rod

DENSITY = 1000.0
UNIFORM = '[[damping]]\nkind = "uniform"\nrate = {}\n'


def exponents(mass, damping, stiffness):
    """Of m l^2 + c l + k = 0, 1/s, with a positive imaginary part or both real ones."""
    return [one for one in numpy.roots([mass, damping, stiffness]) if one.imag >= 0]


class DampedModes(SolvedScenes):
    def exponents(self, text, *arguments):
        """Exponents of the motions in 1/s, and the number of neutral ones."""
        self.solve("modes", "modes", text, *arguments)
        rows = self.table("modes/modes.csv")
        for row in rows:
            self.assertLess(float(row["residual"]), 1e-10, row)
        return (numpy.array([complex(-float(row["decay"]), 2 * math.pi * float(row["frequency"])) for row in rows if row["neutral"] == "0"]),
                sum(row["neutral"] == "1" for row in rows))

    def assert_among(self, exact, found, name, tolerance=1e-9):
        """Each exact exponent is among those found, as often."""
        left = list(found)
        for one in exact:
            nearest = min(left, key=lambda other: abs(other - one))
            self.assertLess(abs(nearest - one), tolerance * abs(one), f"{name}: {one} among {found}")
            left.remove(nearest)

    def test_uniform_damping(self):
        """lambda = -c/2 +- sqrt(c^2/4 - w^2) with the frequencies w of the same rod without damping, to round-off, and those of the beam at second order."""
        exact = [2 * math.pi * one for one in beam(2, CLAMPED, FREE)]
        c = 0.5 * exact[1]  # the first is overdamped
        lists = []
        for n in (10, 20, 40):
            text = HEAD + rod("rod", LENGTH, n, E, RADIUS, more='start = "clamped"') + UNIFORM.format(c)
            found, _ = self.exponents(text, "--count", 6)
            swinging, _ = self.modes(text, "--count", 4, "--undamped")
            omega = 2 * math.pi * swinging
            self.assert_among([one for w in omega for one in exponents(1, c, w**2)], found, "uniform")
            lists.append(numpy.sort_complex(found))
        fast, slow = exponents(1, c, exact[0]**2)
        for name, at, one in (("fast decay", 0, fast.real), ("slow decay", -1, slow.real), ("frequency", 2, math.sqrt(exact[1]**2 - c**2 / 4))):
            values = [found[at].imag if name == "frequency" else found[at].real for found in lists]
            self.assert_second_order(name, values, one)

    def test_slender_body_drag(self):
        """A clamped filament in a viscous fluid: rho A l^2 + zeta l + EI k^4 = 0 with zeta = 4 pi mu/ln(L/r), k L = 1.8751 and 4.6941."""
        r, viscosity = 1e-3, 0.5
        bending, zeta, mass = of_circle(E, r)[0][0], 4 * math.pi * viscosity / math.log(LENGTH / r), DENSITY * math.pi * r**2
        exact = [max(exponents(mass, zeta, bending * k**4), key=lambda one: one.real).real for k in (1.8751040687, 4.6940911330)]
        drag = f'[[load]]\nkind = "slender_body_drag"\nviscosity = {viscosity}\n'
        lists = []
        for n in (20, 40, 80):
            found, _ = self.exponents(HEAD + rod("rod", LENGTH, n, E, r, more='start = "clamped"') + drag, "--count", 4)
            self.assertTrue((found.imag == 0).all())
            self.assertLess(numpy.abs(found[0::2] / found[1::2] - 1).max(), 1e-6)
            lists.append(found[0::2].real)
        for i, one in enumerate(exact):
            self.assert_second_order(f"drag, mode {i + 1}", [found[i] for found in lists], one)

    def test_laplacian_filter(self):
        """Waves along a free rod, of the phase t = k pi/n from node to node, decay at the rate c sin(t/2)^(2 p)."""
        n, rate = 12, 4e3
        held = f'hold = {{nodes = {list(range(n + 1))}, directions = "yz", elements = {list(range(n))}, axes = "xyz"}}'
        for order in (1, 3):
            damping = f'[[damping]]\nkind = "laplacian"\norder = {order}\nrate = {rate}\n'
            found, still = self.exponents(HEAD + rod("rod", LENGTH, n, E, RADIUS, more=held) + damping, "--count", 2 * n)
            self.assertEqual(still, 1)
            sine = numpy.sin(0.5 * math.pi * numpy.arange(1, n + 1) / n)
            omega = 2 * n / LENGTH * math.sqrt(E / DENSITY) * sine
            exact = [one for s, w in zip(sine, omega) for one in exponents(1, rate * s**(2 * order), w**2)]
            self.assert_among(exact, found, f"order {order}")

    def test_drag_by_formula(self):
        """Drag in proportion to mass and velocity, and of its square, which has no slope at rest: waves along a held rod."""
        n, rate = 6, 300.0
        held = f'hold = {{nodes = {list(range(1, n + 1))}, directions = "yz", elements = {list(range(n))}, axes = "xyz"}}\nstart = "pinned"'
        load = f'[[load]]\nkind = "formula"\nper = "mass"\nforce = ["-{rate}*vx - 50*vx*abs(vx)", "0", "0"]\n'
        found, still = self.exponents(HEAD + rod("rod", LENGTH, n, E, RADIUS, more=held) + load, "--count", n)
        self.assertEqual(still, 0)
        omega = 2 * n / LENGTH * math.sqrt(E / DENSITY) * numpy.sin(0.5 * math.pi * (numpy.arange(n) + 0.5) / n)
        self.assert_among([one for w in omega for one in exponents(1, rate, w**2)], found, "formula")

    def test_dashpots_of_joints(self):
        """A body on springs and dashpots, alike along all axes and about them."""
        mass, inertia = 2.0, 0.03
        text = HEAD + (f'[[bodies]]\nname = "ball"\nmass = {mass}\ninertia = [{inertia}, {inertia}, {inertia}]\nspheres.radii = [0.1]\n'
                       '[[joint]]\nkind = "bushing"\nbetween = ["ball", "world"]\nstiffness = 300.0\ndamping = 12.0\n'
                       'torsional_stiffness = 5.0\ntorsional_damping = 1.5\n')
        found, still = self.exponents(text, "--count", 12)
        self.assertEqual(still, 0)
        self.assertEqual(len(found), 9, "those that swing once, the others twice")
        self.assert_among(3 * exponents(mass, 12.0, 300.0) + 3 * exponents(inertia, 1.5, 5.0), found, "bushing")

    def test_dashpots_of_walls(self):
        """A ball on a floor: it bounces on the spring and dashpot, and rolls against those of friction, m J/(J + m a^2) moving at the arm a."""
        mass, r, k, c, share, ct = 0.4, 0.1, 2e4, 15.0, 0.6, 6.0
        inertia, depth = 0.4 * mass * r**2, mass * 9.81 / k
        arm = r - 0.5 * depth  # contact is midway in the overlap
        wall = (f'[[wall]]\nname = "floor"\nkind = "plane"\nlaw = "linear"\nstiffness = {k}\ndamping = {c}\n' '{}'
                '[[load]]\nkind = "gravity"\n')
        ball = HEAD + f'[[bodies]]\nname = "ball"\nmass = {mass}\ninertia = {[inertia] * 3}\nspheres.radii = [{r}]\nplacement.origin = [0, 0, {r - depth}]\n'
        found, still = self.exponents(ball + wall.format(""), "--count", 1)
        self.assertEqual(still, 5)
        self.assert_among(exponents(mass, c, k), found, "bounce")
        rubs = f'friction = "memory"\nstatic_friction = 0.5\ntangential_share = {share}\ntangential_damping = {ct}\n'
        found, still = self.exponents(ball + wall.format(rubs), "--count", 3)
        self.assertEqual(still, 3, "it rolls both ways and turns on its place")
        moving = 1 / (1 / mass + arm**2 / inertia)
        self.assert_among(exponents(mass, c, k) + 2 * exponents(moving, ct, share * k), found, "sticks", 1e-6)
        slips = 'friction = "regularised"\nkinetic_friction = 0.3\nslip_speed = 0.2\n'
        found, still = self.exponents(ball + wall.format(slips), "--count", 3)
        self.assertEqual(still, 5)
        drag = 0.3 * mass * 9.81 / 0.2
        self.assert_among(exponents(mass, c, k) + 2 * [-drag / moving], found, "slips below the slip speed", 1e-6)

    def test_dashpots_of_contacts(self):
        """Two balls on each other on a floor: [m1 m2 0] l^2 and the springs and dashpots between. Their lean grows."""
        masses, r, k, c = (0.4, 0.3), 0.1, 2e4, 15.0
        weight = 9.81 * numpy.array(masses)
        low = r - weight.sum() / k
        high = low + 2 * r - weight[1] / k
        balls = "".join(f'[[bodies]]\nname = "{name}"\nmass = {m}\nspheres.radii = [{r}]\nplacement.origin = [0, 0, {z}]\n'
                        for name, m, z in (("low", masses[0], low), ("high", masses[1], high)))
        law = f'law = "linear"\nstiffness = {k}\ndamping = {c}\n'
        text = HEAD + balls + f'[contact]\n{law}[[wall]]\nname = "floor"\nkind = "plane"\n{law}[[load]]\nkind = "gravity"\n'
        found, _ = self.exponents(text, "--count", 24)
        springs = numpy.array([[2.0, -1.0], [-1.0, 1.0]])
        mass = numpy.diag(masses)
        pair = numpy.block([[numpy.zeros((2, 2)), numpy.eye(2)], [-k * numpy.linalg.solve(mass, springs), -c * numpy.linalg.solve(mass, springs)]])
        self.assert_among([one for one in numpy.linalg.eigvals(pair) if one.imag > 0], found, "bounce")
        self.assertTrue((found.real > 1).any(), "the upper one leans")

    def test_flutter_under_a_follower_couple(self):
        """A cantilever whose tip bears a couple along its tangent flutters (Nicolai): EI w'''' - i T w''' + rho A l^2 w = 0 with w = w' = 0, w'' = w''' = 0."""
        r, torque = 1e-3, 1.5
        bending, mass = of_circle(E, r)[0][0], DENSITY * math.pi * r**2
        couple = torque * bending / LENGTH

        def off(exponent):
            k = numpy.roots([bending, -1j * couple, 0, 0, mass * exponent**2])
            return numpy.linalg.det(numpy.array([k**0, k, k**2 * numpy.exp(k * LENGTH), k**3 * numpy.exp(k * LENGTH)])) / numpy.prod([k[i] - k[j] for i in range(4) for j in range(i)])

        scale = math.sqrt(bending / mass) / LENGTH**2
        exact = []
        for start in (3.5j, -3.5j):
            x, h = (start + 0.1) * scale, 1e-6 * scale
            for _ in range(50):
                x = x - off(x) * 2 * h / (off(x + h) - off(x - h))
            exact.append(x if x.imag > 0 else x.conjugate())
        growth = max(one.real for one in exact)
        frequency = max(exact, key=lambda one: one.real).imag
        self.assertGreater(growth, 0.01 * scale)
        text = f'[[load]]\nkind = "end_couple"\nframe = "body"\nend = [0, 0, {couple}]\n'
        lists = []
        for n in (20, 40, 80):
            found, _ = self.exponents(HEAD + rod("rod", LENGTH, n, E, r, more='start = "clamped"') + text, "--count", 2)
            lists.append(max(found, key=lambda one: one.real))
        self.assert_second_order("growth", [one.real for one in lists], growth, scale)
        self.assert_second_order("frequency of it", [one.imag for one in lists], frequency)

    def test_flutter_of_becks_column(self):
        """A cantilever under a force that follows its tip flutters at 20.0509536 EI/L^2, where its stiffness has no sign of it."""
        r = 5e-4
        bending = of_circle(E, r)[0][0]
        critical = []
        for n in (32, 64, 128):
            column = HEAD + rod("rod", LENGTH, n, E, r, more='start = "clamped"')

            def grows(load):
                follower = f'[[load]]\nkind = "end_force"\nframe = "body"\nend = [0, 0, {-load * bending / LENGTH**2}]\n'
                found, _ = self.exponents(column + follower, "--count", 2)
                return (found.real > 2e-3 * numpy.abs(found)).any()

            low, high = 19.0, 20.5
            self.assertTrue(grows(high) and not grows(low))
            for _ in range(20):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if grows(middle) else (middle, high)
            critical.append(low)
        self.assert_second_order("Beck's load", critical, 20.0509536)

    def test_whirl_of_a_shaft(self):
        """A round rod between pins that spins about its axis: forward and backward whirl of Timoshenko's shaft, of k half waves
        (S k^2 - m w^2) (EI k^2 + S - i w^2 + 2 i spin w) = (S k)^2 with w of both signs."""
        r, spin = 0.05, 400.0
        (bending, *_), (shear, *_) = of_circle(E, r)
        second = DENSITY * math.pi * r**4 / 4
        exact = []
        for k in (math.pi / LENGTH, 2 * math.pi / LENGTH):
            translation, turn = numpy.poly1d([-DENSITY * math.pi * r**2, 0, shear * k**2]), numpy.poly1d([-second, 2 * second * spin, bending * k**2 + shear])
            exact += sorted(numpy.abs((translation * turn - (shear * k)**2).roots))[:2]
        exact = sorted(exact)
        self.assertGreater(exact[1] / exact[0], 1.02, "apart by the spin")
        lists = []
        for n in (10, 20, 40):
            shaft = rod("shaft", LENGTH, n, E, r, more='start = "pinned"\nend = "pinned"').replace(f"elements = {n}", f"elements = {n}, element_spin = [0, 0, {spin}]")
            found, still = self.exponents(HEAD + shaft, "--count", 4)
            self.assertEqual(still, 1)
            self.assertLess(numpy.abs(found.real).max(), 1e-8 * numpy.abs(found).min())
            lists.append(found.imag)
        for i, one in enumerate(exact):
            self.assert_second_order(f"whirl {i + 1}", [found[i] for found in lists], one)

    def test_spin_that_something_resists(self):
        """It is left out, with a word."""
        spun = rod("shaft", LENGTH, 10, E, RADIUS, more='start = "clamped"').replace("elements = 10", "elements = 10, element_spin = [0, 0, 50]")
        pinned = spun.replace("clamped", "pinned") + UNIFORM.format(1.0)
        for text in (spun, pinned):
            self.solve("modes", "spun", HEAD + text)
            still = self.table("spun/modes.csv")
            self.solve("modes", "still", HEAD + text.replace(", element_spin = [0, 0, 50]", ""))
            self.assertEqual(still, self.table("still/modes.csv"))
            words = [SKEIN, "modes", str(self.directory / "spun.toml"), "--out", str(self.directory / "told")]
            self.assertIn("that spin is left out", subprocess.run([*words, "--overwrite"], capture_output=True, text=True).stdout)

    def test_nutation_of_a_free_rod(self):
        """A free rod that spins about its axis nutates as a symmetric top, at its momentum over its inertia across."""
        n, r, spin = 20, 0.1, 5.0
        mass = DENSITY * math.pi * r**2 * LENGTH
        top = rod("top", LENGTH, n, 1e9, r).replace(f"elements = {n}", f"elements = {n}, element_spin = [0, 0, {spin}]")
        found, still = self.exponents(HEAD + top, "--count", 1)
        self.assertEqual(still, 6)
        along = 0.5 * mass * r**2
        places = numpy.linspace(-0.5, 0.5, n + 1) * LENGTH
        share = numpy.full(n + 1, mass / n)
        share[[0, -1]] /= 2
        across = 0.5 * along + float(share @ places**2)
        self.assert_among([1j * spin * along / across], found, "nutation", 1e-6)


if __name__ == "__main__":
    unittest.main()
