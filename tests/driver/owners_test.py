"""Rods that go to other ranks at every list of candidates: nothing in the results tells."""

import pathlib
import unittest

from contact_test import SCENE
from driver import SEARCH, DriverTest

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
LARGE = ("nest_460", "nest_1536", "nest_1536_published", "pit_1024", "pit_1024_friction", "pit_1024_published", "pit_4096", "pit_16384", "swarm_224")
CASES = [scene for scene in sorted(APPS.glob("*/*.toml")) if "\n[contact]" in scene.read_text() and scene.stem not in LARGE]


# A heap of rods that touch, and as many beside it that do not.
HEAP = """
[time]
duration = 100.0
dt = 2e-5
[[rods]]
name = "heap"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.004
[rods.shape]
length = 0.08
elements = 8
[rods.placement]
kind = "packing"
count = 400
seed = 2
region = "box"
lower = [0.0, 0.0, 0.0]
upper = [0.2, 0.2, 0.5]
[[rods]]
name = "field"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
[rods.section]
radius = 0.004
[rods.shape]
length = 0.08
elements = 8
[rods.placement]
kind = "lattice"
counts = [40, 10]
spacing = [0.02, 0.2]
origin = [1.0, 0.0041, 0.0041]
tangent = [0.0, 1.0, 0.0]
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 5.0
[contact]
law = "hertz"
stiffness = 1e5
damping = 10.0
friction = "memory"
static_friction = 0.4
kinetic_friction = 0.3
[[wall]]
name = "box"
kind = "box"
lower = [0.0, 0.0, 0.0]
upper = [3.0, 3.0, 1.0]
law = "hertz"
stiffness = 1e5
damping = 10.0
[output]
series = 0.002
"""


MUSCLES = """
[[load]]
kind = "muscle_wave"
rods = ["curls"]
amplitude = 2e-3
period = 0.1
wavelength = 0.1
[[damping]]
"""


class Owners(DriverTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(SCENE.replace("\n[[damping]]\n", MUSCLES, 1))

    def test_move(self):
        """At every list of candidates rods go to other ranks: nothing in the results tells, nor in those of runs that go on."""
        waves = ["--set=output.paraview=vtp", "--set=output.contacts=0.1"]
        self.run_skein("one", *waves)
        for ranks, threads in ((2, 1), (2, 2), (3, 1), (4, 1), (8, 1)):
            out = f"{ranks}x{threads}"
            self.run_skein(out, "--balance", "always", *waves, ranks=ranks, threads=threads)
            moved = self.summary(out)["balance"]
            self.assertGreaterEqual(moved["migrations"], self.series(out)["rebuilds"][-1])
            self.assertGreater(moved["rods"], 2 * moved["migrations"])
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assert_same_series(out, "one")
            self.assert_same_frames(out, "one", "curls")
            for pattern in ("vtp/*.vtp", "contacts_*.csv"):
                mine, theirs = (sorted((self.directory / o).glob(pattern)) for o in (out, "one"))
                self.assertEqual([f.name for f in mine], [f.name for f in theirs])
                self.assertGreater(len(mine), 2)
                for a, b in zip(mine, theirs):
                    self.assertEqual(a.read_bytes(), b.read_bytes(), f"{out} {a.name}")
        self.run_skein("parts", "--steps", "1111", "--balance", "always", ranks=3)
        self.run_skein("parts", "--until", "0.2", "--balance", "always", ranks=2)
        self.run_skein("parts", ranks=1)
        self.assertEqual(self.digest("parts"), self.digest("one"))
        self.assert_same_series("parts", "one", besides=SEARCH)

    def test_of_every_case_with_contact(self):
        """Rings, ends that move, bodies and single rods too, whose energies are audited where they can be."""
        self.assertGreaterEqual(len(CASES), 6)
        for case in CASES:
            self.scene = case
            settings = ["--steps", "400", "--set=output.trajectory=0", "--set=output.tips=0", "--no-checkpoint"]
            if case.stem in ("plectoneme", "solenoid"):
                settings.append("--set=output.audit=true")
            self.run_skein(f"{case.stem}_one", *settings)
            self.run_skein(f"{case.stem}_moved", *settings, "--balance", "always", ranks=3)
            self.assertEqual(self.digest(f"{case.stem}_moved"), self.digest(f"{case.stem}_one"), case)
            self.assertGreater(self.summary(f"{case.stem}_moved")["balance"]["migrations"], 0)
            self.assert_same_series(f"{case.stem}_moved", f"{case.stem}_one")

    def test_where_it_pays(self):
        """The rank that has the heap gives some of it away, and what both have to do is even then."""
        self.scene.write_text(HEAP)
        for even in ("even", "again"):  # it goes by measured times, which other work on this machine may disturb once
            self.run_skein(even, "--walltime", "10", ranks=2, expect=3)
            summary = self.summary(even)
            if summary["balance"]["imbalance"] < 1.15: break
        self.assertGreaterEqual(summary["balance"]["migrations"], 1)
        self.assertGreater(summary["balance"]["rods"], 50)
        self.assertLess(summary["balance"]["imbalance"], 1.15)
        self.run_skein("one", "--steps", str(summary["steps"]), threads=2)
        self.assertEqual(self.digest(even), self.digest("one"))
        self.assert_same_series(even, "one")


if __name__ == "__main__":
    unittest.main()
