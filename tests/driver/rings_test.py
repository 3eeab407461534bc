"""Rings that are linked, pull at each other and touch themselves: links are kept, with the same bits and restarts as of rods alone."""

import math
import unittest

import h5py
import numpy

from driver import SEARCH, DriverTest

RING = """
[rods.material]
density = 1000.0
youngs_modulus = 1e6
shear_modulus = 7.5e5
law = "linear"
[rods.section]
radius = 0.012
[rods.shape]
length = 1.0
elements = {elements}
closed = true
rest_curvature = [0.0, 0.0, -18.8]
start_curvature = [6.283185307179586, 0.0, 0.0]
velocity = [{speed}, 0.0, 0.0]
angular_velocity = [0.3, 0.2, 0.0]
[rods.placement]
kind = "list"
origins = {origins}
tangent = [1.0, 0.0, 0.0]
normal = {normal}
"""
# A chain of four rings, each with three turns more than at rest. Wherever it is shared out among ranks, linked rings are parted.
SCENE = f"""
title = "Linked rings with turns to spare"
[time]
duration = 1.0
[[rods]]
name = "lying"
{RING.format(elements=40, speed=-0.3, origins=[[0.0, -0.159, 0.0], [0.587, -0.159, 0.0]], normal=[0.0, 0.0, 1.0])}
[[rods]]
name = "standing"
{RING.format(elements=36, speed=0.3, origins=[[0.2935, 0.0, -0.159], [0.8805, 0.0, -0.159]], normal=[0.0, -1.0, 0.0])}
[[damping]]
kind = "uniform"
rate = 1.0
[contact]
law = "hertz"
stiffness = 5e5
damping = 10.0
friction = "memory"
static_friction = 0.3
kinetic_friction = 0.2
self = true
[output]
trajectory = 0.25
series = 0.05
contacts = 0.25
checkpoint = 0.25
observables = ["knots", "angular_momentum"]
"""


def solid_angle(a, b, c):
    la, lb, lc = (numpy.linalg.norm(v, axis=-1) for v in (a, b, c))
    dot = lambda v, w: (v * w).sum(axis=-1)
    return 2 * numpy.arctan2(dot(a, numpy.cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)


def linking(one, other):
    """Linking number of two closed polygons [n, 3]: Gauss's integral, edge by edge, as two solid angles each."""
    p, q = one[:, None], numpy.roll(one, -1, axis=0)[:, None]
    r, s = other[None], numpy.roll(other, -1, axis=0)[None]
    return (solid_angle(r - p, s - p, s - q) + solid_angle(r - p, s - q, r - q)).sum() / (4 * math.pi)


class Rings(DriverTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(SCENE)

    def contacts(self, out):
        """Rows of all tables of contacts: columns by name."""
        tables = [numpy.genfromtxt(path, delimiter=",", names=True) for path in sorted((self.directory / out).glob("contacts_*.csv"))]
        return numpy.concatenate([numpy.atleast_1d(table) for table in tables])

    def test_links_are_kept(self):
        """Of every ring with itself and with its neighbours in the chain; there are contacts of all kinds, also by way of the closing vertex."""
        self.run_skein("one")
        series = self.series("one")
        self.assertGreater(series["writheturns"].max(), 4)
        self.assertLess(numpy.abs(series["linkturns"]).max(), 1e-9, "a ring has passed through itself")
        newest = sorted((self.directory / "one").glob("checkpoint_*.h5"))[-1]
        with h5py.File(newest) as file:
            lying, standing = (file[f"groups/{name}/state"][:, :-1, :3] for name in ("lying", "standing"))
        for a in range(2):
            for b in range(2):
                self.assertAlmostEqual(abs(linking(lying[a], standing[b])), 0 if (a, b) == (0, 1) else 1, delta=1e-9)
        rows = self.contacts("one")
        same = rows["rod_1"] == rows["rod_2"]
        elements = numpy.where(rows["rod_1"] < 2, 40, 36)
        apart = numpy.abs(rows["element_1"] - rows["element_2"])
        self.assertGreater(numpy.count_nonzero(~same), 3)
        self.assertGreater(numpy.count_nonzero(same & (apart <= elements / 2)), 10)
        self.assertGreater(numpy.count_nonzero(same & (apart > elements / 2)), 10, "nearest round by way of the vertex")
        nearest = numpy.minimum(apart, elements - apart)[same].min()
        self.assertGreater(nearest, math.ceil(math.pi * 0.012 * 36) + 1, "neighbours have no contact")

    def test_ranks_threads_and_lanes(self):
        self.run_skein("one")
        self.assert_layouts_give("one", lambda out: self.assert_same_series(out, "one"))
        self.run_skein("shuffled", "--shuffle", "7", ranks=2, threads=2)
        self.assertEqual(self.digest("shuffled"), self.digest("one"))

    def test_owners_that_change(self):
        self.run_skein("one")
        for ranks in (2, 3):
            out = f"{ranks} ranks"
            self.run_skein(out, "--balance", "always", ranks=ranks)
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assert_same_series(out, "one")

    def test_restart(self):
        self.run_skein("whole")
        self.run_skein("parts", "--steps", "1611", ranks=2)
        self.run_skein("parts", "--until", "0.75", threads=2)
        self.run_skein("parts", ranks=3)
        self.assertEqual(self.digest("parts"), self.digest("whole"))
        self.assert_same_series("parts", "whole", besides=SEARCH)


if __name__ == "__main__":
    unittest.main()
