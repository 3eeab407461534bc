"""Many rods in contact: an overlapping start, a rod that holds and slides, a pile whose bits depend on nothing but the scene."""

import math
import random
import subprocess
import unittest

import numpy

from driver import STICKS
from single_runs import APPS, SKEIN, SingleRuns

PILE = """
[time]
duration = 0.25
""" + STICKS + """
[rods.placement]
kind = "packing"
count = 200
seed = 3
region = "cylinder"
radius = 0.12
height = 0.3
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 2.0
[contact]
law = "hertz"
stiffness = 1e5
damping = 10.0
friction = "memory"
static_friction = 0.4
kinetic_friction = 0.3
[[wall]]
name = "floor"
kind = "plane"
law = "hertz"
stiffness = 1e5
damping = 10.0
friction = "memory"
static_friction = 0.4
kinetic_friction = 0.2
[[wall]]
name = "side"
kind = "tube"
radius = 0.12
law = "hertz"
stiffness = 1e5
damping = 10.0
friction = "memory"
static_friction = 0.4
[output]
series = 0.025
checkpoint = 0.05
trajectory = 0.05
"""


class OverlappingStart(SingleRuns):
    def test_soft_start(self):
        """256 rods at random in a box too small for them: many share a place. Softly pushed apart they reach 0.09 m/s
        and have parted before the contact hardens."""
        chance = random.Random(5)
        origins = [[chance.uniform(0, 0.2), chance.uniform(0, 0.2), chance.uniform(0, 0.1)] for _ in range(256)]
        self.scene.write_text("[time]\nduration = 1.0\n" + STICKS + f"""
[rods.placement]
kind = "list"
tangent = [1.0, 0.0, 0.0]
origins = {origins}
[[damping]]
kind = "uniform"
rate = 5.0
[contact]
law = "linear"
stiffness = 1e4
damping = 1.0
soft_until = 0.8
soft_stiffness = 0.5
soft_damping = 0.05
[output]
series = 0.02
""")
        self.run_alone("apart")
        series = self.series("apart")
        for name, column in series.items():
            self.assertTrue(numpy.isfinite(column).all(), name)
        self.assertGreater(series["max_overlap"][1], 0.8)
        self.assertLess(series["max_speed"].max(), 0.3)
        self.assertLess(series["max_overlap"][-1], 0.01)


class PressedNest(SingleRuns):
    """The nest of 110 rods, its lid in haste: its work on the rods is stored, or dissipated by friction or damping."""

    WALLS = ("side", "floor", "lid")
    KEPT = ("kinetic_translation", "kinetic_rotation", "elastic_stretch", "elastic_shear", "elastic_bend", "elastic_twist", "potential", "contact_energy",
            "wall_energy")
    LOST = ("contact_friction_work", "contact_viscous_work", "wall_friction_work", "wall_viscous_work", "dissipated")

    def test_energy_budget_balances(self):
        for out, *settings in (["rough"], ["smooth"] + [f"{place}.friction_from=1" for place in ("contact", *(f"wall.{w}" for w in self.WALLS))]):
            haste = [f"wall.{w}.friction_from=0.02" for w in self.WALLS] + ["contact.friction_from=0.02", "wall.lid.from=0.05", "wall.lid.servo.speed=0.3", "time.duration=0.25",
                     "output.series=0.01", "output.trajectory=0", "output.checkpoint=0.25", "output.audit=true"]
            self.run_alone(out, *haste, *settings, scene=APPS / "nest/nest_110.toml")
            series = self.series(out)
            balance = series["lid_work"] - sum(series[name] - series[name][0] for name in self.KEPT + self.LOST)
            moved = series["dissipated"][-1] + series["contact_viscous_work"][-1] + series["wall_viscous_work"][-1] + abs(series["contact_friction_work"][-1])
            self.assertGreater(series["contacts"].max(), 130, out)
            self.assertGreater(series["lid_work"][-1], 1e-3, out)
            self.assertLess(numpy.abs(balance).max(), 2e-3 * moved, out)
            if out == "smooth":
                self.assertLess(abs(series["contact_friction_work"][-1]), 1e-3 * moved)
            else:
                self.assertGreater(series["contact_friction_work"][-1], 0.2 * moved)


class Incline(SingleRuns):
    MU, G, LENGTH = 0.4, 9.81, 0.1

    def down(self, out, of_mu, law, stiffness, dt=None):
        """Mean of nine rods, aligned with the slope, which is turned by turning gravity: series of the centre and of the speed."""
        slope = math.atan(of_mu * self.MU)
        self.scene.write_text(f"[time]\nduration = 1.0\n" + (f"dt = {dt!r}\n" if dt else "") + STICKS + f"""
[rods.placement]
kind = "lattice"
counts = [3, 3]
spacing = [0.2, 0.05]
origin = [0.0, 0.0, 0.005]
tangent = [1.0, 0.0, 0.0]
[[load]]
kind = "gravity"
acceleration = [{self.G * math.sin(slope)!r}, 0.0, {-self.G * math.cos(slope)!r}]
[[wall]]
name = "floor"
kind = "plane"
law = "{law}"
stiffness = {stiffness!r}
damping = {0.4 if law == "linear" else 10.0}
friction = "memory"
static_friction = {self.MU}
tangential_damping = 0.4
[output]
series = 0.01
""")
        self.run_alone(out)
        series = self.series(out)
        mass = 9 * 1000 * math.pi * 0.005**2 * self.LENGTH
        return slope, series["time"], series["centre_x"], series["momentum_x"] / mass

    def test_stick_and_slip(self):
        for law, stiffness in (("linear", 300.0), ("hertz", 1e4)):
            slope, time, way, speed = self.down("holds", 0.95, law, stiffness)
            late = time >= 0.5
            self.assertLess(numpy.ptp(way[late]) / 0.5, 1e-6 * self.LENGTH, law)
            ways = []
            for dt in (4e-5, 2e-5):
                slope, time, way, speed = self.down("slides", 1.05, law, stiffness, dt)
                late = time >= 0.2
                expected = self.G * (math.sin(slope) - self.MU * math.cos(slope))
                self.assertAlmostEqual(numpy.polyfit(time[late], speed[late], 1)[0] / expected, 1, delta=1e-2, msg=law)
                ways.append(way[-1] - way[0])
            self.assertAlmostEqual(ways[0] / ways[1], 1, delta=2e-2, msg=law)


class Pile(SingleRuns):
    def setUp(self):
        super().setUp()
        self.scene.write_text(PILE)

    def assert_same_series(self, out, ranks):
        """Bit for bit, but for energies of contacts, which every rank sums on its own before all do."""
        mine, theirs = self.series(out), self.series("1x1")
        self.assertEqual(mine.keys(), theirs.keys())
        for name, column in mine.items():
            if ranks > 1 and name in ("contact_energy", "contact_friction_work", "contact_viscous_work"):
                self.assertLess(numpy.abs(column - theirs[name]).max(), 1e-12 * numpy.abs(column).max(), f"{name} of {out}")
            else:
                self.assertTrue(numpy.array_equal(column, theirs[name]), f"{name} of {out}")

    def test_bits_of_a_pile(self):
        self.run_skein("1x1")
        last = {name: column[-1] for name, column in self.series("1x1").items()}
        self.assertGreater(last["contacts"], 200)
        self.assertGreater(last["wall_contacts"], 100)
        for ranks, threads in ((2, 1), (4, 1), (1, 2), (2, 2)):
            out = f"{ranks}x{threads}"
            self.run_skein(out, ranks=ranks, threads=threads)
            self.assertEqual(self.digest(out), self.digest("1x1"), out)
            self.assert_same_series(out, ranks)
        self.run_skein("parts", "--until", "0.15", ranks=2)
        self.run_skein("parts", "--until", "0.2", threads=2)
        self.assertLess(self.summary("parts")["time_s"], 0.21)
        self.run_skein("parts", ranks=4)
        self.assertEqual(self.digest("parts"), self.digest("1x1"), "restarted")

    def test_step_of_twice_the_limit_is_refused(self):
        plan = subprocess.run([SKEIN, "plan", str(self.scene), "--json"], capture_output=True, text=True, timeout=60)
        self.assertEqual(plan.returncode, 0, plan.stderr)
        limit = float(plan.stdout.split('"limit"')[1].split(":")[1].split(",")[0])
        done = self.run_alone("far", f"time.dt={2 * limit!r}", expect=2)
        for part in ("'sticks'", "element ", "beyond the stable limit"):
            self.assertIn(part, done.stderr)
        stiff = self.run_alone("stiff", f"time.dt={limit!r}", "contact.stiffness=1e9", expect=2)
        for part in ("'sticks'", "element ", "contact"):
            self.assertIn(part, stiff.stderr)


if __name__ == "__main__":
    unittest.main()
