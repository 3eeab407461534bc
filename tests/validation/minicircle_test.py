"""Rings with turns to spare that touch themselves (apps/contact/minicircle.toml): link is kept through all contacts, a circle buckles where Zajac
says, and what it becomes is in equilibrium as published supercoils are."""

import math
import subprocess
import sys
import unittest

import numpy

from single_runs import APPS, SingleRuns

LENGTH, RADIUS, E, G = 1.0, 0.008, 1e6, 7.5e5
B, C = E * math.pi * RADIUS**4 / 4, G * math.pi * RADIUS**4 / 2
CRITICAL = math.sqrt(3) * B / C


def about(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    return numpy.array({"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis])


def rotation_vector(m):
    angle = math.acos(0.5 * (numpy.trace(m) - 1))
    return angle / (2 * math.sin(angle)) * numpy.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])


def start(n, turns=0, oval=0.5, length=LENGTH):
    """Curvature of every vertex of an oval of n elements whose frame turns about the tangent so often, 1/m."""
    bends, twist = (2 * math.pi / n * (1 + oval * math.cos(4 * math.pi * (k + 1) / n)) for k in range(n)), 2 * math.pi * turns / n
    frames = (about("z", -k * twist) @ about("x", bend) @ about("z", (k + 1) * twist) for k, bend in enumerate(bends))
    return "rods.ring.shape.start_curvature_profile=" + str([[float(c) for c in n / length * rotation_vector(m)] for m in frames])


def leaning_in_ply(moment):
    """Angle of the strands to the axis in a uniform two-strand ply of rods that stretch and shear, on which no force and no moment act from outside.
    d3 leans by beta and turns by p per length about the axis: with m the axial moment of a strand, -m/r is its force about the axis and 0 that
    along it, and the balance p r m_theta = m z' of couples decides beta. Without shear: M r/B = sin^2(beta) tan(2 beta)
    (Thompson, van der Heijden, Neukirch 2002)."""
    shear, stretch = 27 / 28 * G * math.pi * RADIUS**2, E * math.pi * RADIUS**2

    def ply(beta):
        c, s = math.cos(beta), math.sin(beta)
        # p r = nu s - gamma c, with strains nu = 1 - m s/(r EA), gamma = m c/(r aGA) that are linear in m = B p s^2 - M c
        per_m = -(s * s / stretch + c * c / shear) / RADIUS
        p = (s - per_m * moment * c) / (RADIUS - per_m * B * s * s)
        m = B * p * s * s - moment * c
        along = (1 - m * s / (RADIUS * stretch)) * c + m * c / (RADIUS * shear) * s
        return p * RADIUS * -(B * p * s * c + moment * s) - m * along, math.atan2(p * RADIUS, along)

    low, high = 0.02, 0.7
    for _ in range(60):
        beta = 0.5 * (low + high)
        low, high = (beta, high) if (ply(beta)[0] > 0) == (ply(low)[0] > 0) else (low, beta)
    return ply(low)[1]


class Minicircle(SingleRuns):
    def relaxed(self, out, excess, *settings, elements=60, duration=12, length=LENGTH, **shape):
        """Time series of a run that ends at rest."""
        self.run_alone(out, f"rods.ring.shape.rest_curvature=[0.0, 0.0, {-2 * math.pi * excess / length}]", f"rods.ring.shape.elements={elements}",
                       f"rods.ring.shape.length={length}", start(elements, length=length, **shape), f"time.duration={duration}", f"output.trajectory={duration}", *settings, scene=APPS / "contact/minicircle.toml")
        return self.series(out)

    def nodes(self, out):
        return self.state(out)["ring"]["state"][0][:, :3]

    def test_link_is_kept(self):
        """Through the buckling, the first crossing and the winding up; without contact the same ring passes through itself, for two turns each time."""
        series = self.relaxed("touching", 4.0, elements=100)
        self.assertLess(numpy.abs(series["link"]).max(), 1e-9)
        self.assertGreater(series["contacts"][-1], 20)
        self.assertGreater(series["writhe"][-1], 3)
        self.assertLess(series["kinetic_translation"][-1], 1e-9)
        passing = self.relaxed("passing", 4.0, "contact.self=false", duration=4)["link"]
        self.assertGreater(numpy.abs(passing).max(), 2 - 1e-9)
        self.assertLess(numpy.abs(passing - 2 * numpy.round(passing / 2)).max(), 1e-9)

    def test_turns_that_are_put_in_are_kept(self):
        """Two turns of twist at the start instead of turns of the rod at rest: the same ring, whose link is 2."""
        series = self.relaxed("put_in", 0.0, turns=2)
        link = series["link"]
        self.assertAlmostEqual(abs(link[0]), 2, delta=1e-9)
        self.assertLess(numpy.abs(link - link[0]).max(), 1e-9)
        other = self.relaxed("at_rest", 2.0)
        self.assertAlmostEqual(abs(series["writhe"][-1]), abs(other["writhe"][-1]), delta=1e-2)

    def test_a_circle_buckles_where_zajac_says(self):
        """At sqrt(3) B/C turns; then it goes on until it crosses itself. Strands that cross 2 r apart in a flat figure of eight have a writhe
        of 1 - O(r/L), L/r = 125 here."""
        below, above = self.relaxed("below", 0.98 * CRITICAL, oval=0.01), self.relaxed("above", 1.04 * CRITICAL, oval=0.01, duration=16)
        self.assertLess(abs(below["writhe"][-1]), 1e-3)
        self.assertEqual(below["contacts"].max(), 0)
        self.assertGreater(above["writhe"][-1], 1 - 10 * RADIUS / LENGTH)
        self.assertGreater(above["contacts"][-1], 0)
        self.assertLess(numpy.abs(above["link"]).max(), 1e-9)

    def moment(self, series, length=LENGTH):
        """Of twist, N m: twist is even along the rod."""
        return math.sqrt(2 * series["elastic_twist"][-1] * C / length)

    def energy(self, series):
        return sum(series[name][-1] for name in series if name.startswith("elastic_")) + series["contact_energy"][-1]

    def test_energy_grows_with_the_moment(self):
        """dE/d(excess link) = 2 pi M along a branch of states at rest, here those with one point of contact."""
        step = 0.05
        low, middle, high = (self.relaxed(f"{excess}", excess) for excess in (1.5 - step, 1.5, 1.5 + step))
        slope = (self.energy(high) - self.energy(low)) / (2 * step)
        self.assertAlmostEqual(slope / (2 * math.pi * self.moment(middle)), 1, delta=3e-3)

    def test_the_supercoil_is_a_balanced_ply(self):
        """Its strands lean as much as those of a two-strand ply without load do; in the middle, for towards the loops it opens."""
        series = self.relaxed("ply", 4.0, elements=100)
        x = self.nodes("ply")
        middle, edge = 0.5 * (x[1:] + x[:-1]), numpy.diff(x, axis=0)
        tangent, n = edge / numpy.linalg.norm(edge, axis=1)[:, None], len(edge)
        i, j = numpy.indices((n, n))
        apart = numpy.linalg.norm(middle[:, None] - middle[None], axis=2)
        apart[numpy.minimum(abs(i - j), n - abs(i - j)) < 10] = math.inf
        partner = apart.argmin(axis=1)
        wound = apart.min(axis=1) < 2.2 * RADIUS
        self.assertGreater(wound.sum(), 30)
        leaning = 0.5 * numpy.arccos(-(tangent * tangent[partner]).sum(axis=1))[wound]
        expected = leaning_in_ply(self.moment(series))
        self.assertAlmostEqual(numpy.percentile(leaning, 25) / expected, 1, delta=1e-2)
        self.assertAlmostEqual(B / RADIUS * math.sin(expected)**2 * math.tan(2 * expected) / self.moment(series), 1, delta=0.1)  # without shear

    def test_writhe_per_length_is_that_of_the_ply(self):
        """Loops of rings under one moment are the same; what a longer one has more is ply, whose strands lean by beta and have a writhe of
        sin(2 beta)/(4 pi r) per length (Fuller 1971). With the twist M/(2 pi C) per length the excess link follows, at which the moments have to agree."""
        reference = self.relaxed("reference", 4.0, elements=100)
        moment = self.moment(reference)
        writhe = math.sin(2 * leaning_in_ply(moment)) / (4 * math.pi * RADIUS)
        for shorter in (0.1, 0.2):
            length, excess = LENGTH - shorter, 4 - shorter * (writhe + moment / (2 * math.pi * C))
            series = self.relaxed(f"shorter_by_{shorter}", excess, elements=round(100 * length), length=length)
            self.assertAlmostEqual(self.moment(series, length) / moment, 1, delta=5e-3)
            self.assertAlmostEqual((reference["writhe"][-1] - series["writhe"][-1]) / (shorter * writhe), 1, delta=1e-2)

    def test_picture(self):
        self.relaxed("drawn", 2.0, duration=1)
        for runs in (["drawn"], ["drawn", "drawn"]):
            done = subprocess.run([sys.executable, str(APPS / "contact/plot_minicircle.py"), *(str(self.directory / run) for run in runs)],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertGreater((self.directory / "drawn/minicircles.png").stat().st_size, 10000)


if __name__ == "__main__":
    unittest.main()
