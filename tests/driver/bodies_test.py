"""Rigid bodies of all kinds of parts among rods: the same bits on any ranks, widths and across restarts; what files show of them."""

import re
import unittest
import xml.etree.ElementTree as xml

import h5py
import numpy

from driver import SEARCH, STICKS, DriverTest

LAW = """law = "hertz"
stiffness = 1e5
damping = 5.0
friction = "memory"
static_friction = 0.4
"""

SCENE = f"""
title = "Bodies and rods in a box"
[time]
duration = 0.25
{STICKS}
[rods.placement]
kind = "packing"
count = 40
seed = 3
upper = [0.16, 0.16, 0.14]

[[bodies]]
name = "balls"
density = 1500.0
[bodies.spheres]
radii = [0.008]
[bodies.placement]
kind = "packing"
count = 15
seed = 4
upper = [0.16, 0.16, 0.14]

[[bodies]]
name = "jacks"
density = 1500.0
angular_velocity = [3.0, 20.0, 5.0]
[bodies.capsules]
from = [[-0.02, 0.0, 0.0], [0.0, -0.015, 0.0], [0.0, 0.0, -0.01]]
to = [[0.02, 0.0, 0.0], [0.0, 0.015, 0.002], [0.0, 0.0, 0.01]]
radii = [0.004, 0.004, 0.005]
[bodies.spheres]
centres = [[0.02, 0.0, 0.0]]
radii = [0.006]
[bodies.placement]
kind = "lattice"
counts = [3, 2]
spacing = [0.05, 0.06]
origin = [0.03, 0.05, 0.17]

[[bodies]]
name = "block"
density = 900.0
[bodies.boxes]
sizes = [[0.07, 0.05, 0.03]]
radii = [0.003]
[bodies.placement]
origin = [0.08, 0.08, 0.24]
normal = [1.0, 0.3, 0.1]
tangent = [0.1, 0.1, 1.0]

[[bodies]]
name = "crates"
density = 900.0
[bodies.boxes]
sizes = [[0.03, 0.025, 0.02]]
radii = [0.002]
[bodies.placement]
kind = "lattice"
counts = [2, 2]
spacing = [0.035, 0.03]
origin = [0.06, 0.06, 0.3]

[[load]]
kind = "gravity"

[[damping]]
kind = "physical"
translational = 1e-3
rotational = 1e-8

[contact]
{LAW}
[[wall]]
name = "box"
kind = "box"
{LAW}
lower = [0.0, 0.0, 0.0]
upper = [0.16, 0.16, 0.4]

[output]
trajectory = 0.05
series = 0.05
contacts = 0.05
checkpoint = 0.1
directors = true
precision = "double"
paraview = "vtp"
observables = ["angular_momentum"]
"""


class Bodies(DriverTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(SCENE)

    def test_have_the_same_bits(self):
        self.run_skein("one")
        self.assertGreater(self.series("one")["contacts"][-1], 20)
        for ranks, threads in ((1, 2), (2, 1), (3, 1), (4, 1)):
            out = f"{ranks}x{threads}"
            self.run_skein(out, "--balance", "always", ranks=ranks, threads=threads)
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assert_same_series(out, "one")
            for pattern in ("vtp/*.vtp", "contacts_*.csv"):
                mine, theirs = (sorted((self.directory / o).glob(pattern)) for o in (out, "one"))
                self.assertEqual([f.name for f in mine], [f.name for f in theirs])
                for a, b in zip(mine, theirs):
                    self.assertEqual(a.read_bytes(), b.read_bytes(), f"{out} {a.name}")
        for lanes in (1, 2, 4):
            self.run_skein(f"w{lanes}", "--lanes", str(lanes))
            self.assertEqual(self.digest(f"w{lanes}"), self.digest("one"), lanes)
        self.run_skein("parts", "--until", "0.1", ranks=3)
        self.run_skein("parts", "--until", "0.2", ranks=2)
        self.run_skein("parts", ranks=1)
        self.assertEqual(self.digest("parts"), self.digest("one"))
        self.assert_same_series("parts", "one", besides=SEARCH)

    def test_bodies_that_blow_up_stop(self):
        """A step beyond the limit of joints drives bodies apart, or round, faster than it can follow; the end of a run is no excuse."""
        joined = """
[time]
duration = 0.1
dt = 2e-3
force_dt = true
[[bodies]]
name = "balls"
density = 1000.0
angular_velocity = [0.0, 1e-3, 0.0]
spheres = {radii = [0.01]}
placement = {kind = "list", origins = [[0, 0, 0.02], [0.05, 0, 0]]}
[[load]]
kind = "gravity"
"""
        point = '[[joint]]\nkind = "spherical"\nbetween = ["balls", "world"]\nstiffness = 1e5\n'
        fixed = '[[joint]]\nkind = "fixed"\nbetween = ["balls", "world"]\nstiffness = 1.0\ntorsional_stiffness = 100.0\n'
        for joint, said in ((point, r"its velocity of \S+ m/s moves it by \S+ of its size within a step"), (fixed, r"its angular velocity of \S+ rad/s turns it by \S+ rad within a step")):
            self.scene.write_text(joined + joint)
            message = self.run_skein("out", "--overwrite", expect=4).stderr
            self.assertRegex(message, r"body [01] of 'balls', " + said + r" at step \d+ \(t = \S+ s, dt = 0.002 s\)")
            self.assertIn("pass 'joints'", message)
            self.assertRegex(message, r"the same steps hold with time\.dt = (\S+): it was tried")
            step = re.search(r"time\.dt = (\S+): it was tried", message)[1]
            self.run_skein("held", "--overwrite", "--set", f"time.dt={step}")
        # What nothing holds may fly and spin as fast as it likes.
        self.scene.write_text(joined.replace("angular_velocity = [0.0, 1e-3, 0.0]", "angular_velocity = [0, 1e5, 0]\nvelocity = [1e3, 0, 0]"))
        self.run_skein("free")

    def test_are_in_the_trajectory(self):
        self.run_skein("out")
        with h5py.File(sorted((self.directory / "out").glob("trajectory_*.h5"))[-1]) as file:
            groups = file["groups"]
            self.assertEqual(groups["balls/position"].shape[1:], (15, 1, 3))
            self.assertEqual(groups["jacks/directors"].shape[1:], (6, 1, 3, 3))
            self.assertEqual(groups["jacks/capsules"].shape, (4, 7))
            self.assertEqual(groups["block/boxes"].shape, (1, 11))
            box = groups["block/boxes"][0]
            numpy.testing.assert_allclose(sorted(box[7:10]), [0.012, 0.022, 0.032], rtol=1e-12)
            frames = groups["jacks/directors"][-1, :, 0]
            for q in frames:
                numpy.testing.assert_allclose(q @ q.T, numpy.eye(3), atol=1e-12)
            # The dumbbells' round ends stand on or above the floor, but for overlaps.
            capsules = groups["jacks/capsules"][:]
            for centre, q in zip(groups["jacks/position"][-1, :, 0], frames):
                for end in (capsules[:, :3], capsules[:, 3:6]):
                    places = centre + end @ q
                    self.assertGreater((places[:, 2] - capsules[:, 6]).min(), -0.002)
        text = (self.directory / "out/trajectory.xdmf").read_text()
        xml.fromstring(text)
        self.assertIn("Polyvertex", text)


if __name__ == "__main__":
    unittest.main()
