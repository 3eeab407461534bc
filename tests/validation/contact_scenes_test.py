"""Scenes of apps/contact against closed forms: collisions, a rod on an incline, twist and writhe of a rod that touches itself."""

import math
import unittest

import numpy

from single_runs import APPS, SingleRuns, restitution_of_share, share_of_restitution

SPEED, ELEMENTS = 0.1, 3
END_ON = ("rods.striker.placement.origin=[0.06501, 0.0, 0.0]", "rods.striker.placement.tangent=[1.0, 0.0, 0.0]",
          f"rods.striker.shape.velocity=[{-SPEED}, 0.0, 0.0]")
MU, G = 0.4, 9.81


def restitution_of_rods(of_elements, elements=ELEMENTS):
    """Of two rigid rods that meet at one element each, where the contact's law is that of the elements alone."""
    return restitution_of_share(share_of_restitution(of_elements) / math.sqrt(elements))


class Impact(SingleRuns):
    def bounce(self, axis, *settings):
        """Speed of parting over that of approach, and what share of the rods' energy in their common frame is in vibration."""
        self.run_alone("impact", *settings, scene=APPS / "contact/impact.toml")
        state, last = self.state("impact"), {name: column[-1] for name, column in self.series("impact").items()}
        self.assertEqual(last["contacts"], 0, "still touching")
        weight = numpy.array([0.5] + [1.0] * (ELEMENTS - 1) + [0.5]) / ELEMENTS
        velocity = {name: weight @ rod["state"][0][:, 3:6] for name, rod in state.items()}
        mass = 1000 * math.pi * 0.01**2 * 0.09
        energy = sum(last[part] for part in ("kinetic_translation", "kinetic_rotation", "elastic_stretch", "elastic_shear", "elastic_bend", "elastic_twist"))
        rigid = 0.5 * mass * sum(v @ v for v in velocity.values())
        return (velocity["striker"] - velocity["target"])[axis] / SPEED, (energy - rigid) / (0.25 * mass * SPEED**2)

    def test_restitution(self):
        """Side on and end on, against exp(-2 z acos(z)/sqrt(1 - z^2)); the worst, 4e-4, is side on at 0.5."""
        for name, axis, settings in (("side on", 2, ()), ("end on", 0, END_ON)):
            for wanted in (1.0, 0.8, 0.5):
                e, vibration = self.bounce(axis, f"contact.restitution={wanted}", *settings)
                self.assertAlmostEqual(e / restitution_of_rods(wanted), 1, delta=1e-2, msg=f"{name}, {wanted}")
                self.assertLessEqual(e, 1 + 1e-6)
                self.assertLess(vibration, 1e-4)

    def test_a_contact_speaks_of_its_elements(self):
        """Rods of three elements are thrice as heavy as what the law was given, and bounce back faster than it says."""
        e, _ = self.bounce(2, "contact.restitution=0.5")
        self.assertGreater(e, 0.5 * 1.2)


class Incline(SingleRuns):
    MASS = 1000 * math.pi * 0.01**2 * 0.2

    def down(self, out, slope, *settings):
        gravity = f"load.gravity.acceleration=[{G * math.sin(slope)!r}, 0.0, {-G * math.cos(slope)!r}]"
        self.run_alone(out, gravity, *settings, scene=APPS / "contact/incline.toml")
        series = self.series(out)
        late = series["time"] > 0.499 * series["time"][-1]
        way = series["centre_x"][late]
        return way[-1] - way[0], numpy.polyfit(series["time"][late], series["momentum_x"][late] / self.MASS, 1)[0]

    def test_sticks(self):
        way, _ = self.down("sticks", math.atan(0.95 * MU))
        self.assertLess(abs(way), 1e-6 * 0.2)  # 1e-6 lengths a second, over one second

    def test_slides(self):
        slope = math.atan(1.05 * MU)
        ways = []
        for dt in (6e-5, 3e-5):
            way, acceleration = self.down("slides", slope, f"time.dt={dt}")
            self.assertAlmostEqual(acceleration / (G * (math.sin(slope) - MU * math.cos(slope))), 1, delta=1e-2)
            ways.append(way)
        self.assertAlmostEqual(ways[0] / ways[1], 1, delta=2e-2)

    def test_rolls(self):
        """Within what it sinks in, 0.5 % of the radius."""
        _, acceleration = self.down("rolls", 0.3, "rods.rod.placement.tangent=[0.0, 1.0, 0.0]")
        self.assertAlmostEqual(acceleration / (2 / 3 * G * math.sin(0.3)), 1, delta=1e-2)


class Plectoneme(SingleRuns):
    """Wall to wall, twist + writhe is the rotation of the end. The series counts twist between the outermost elements' middles: of n cells
    one, two halves, is missing, in a rod at rest as twisted as the others."""

    TURNS, CELLS = 4.0, 80

    def link(self, out, *settings):
        self.run_alone(out, *settings, scene=APPS / "contact/plectoneme.toml")
        series = self.series(out)
        held = series["time"] >= 10.0
        return (series["twist"] * self.CELLS / (self.CELLS - 1) + series["writhe"])[held], series

    def test_link_is_kept(self):
        link, series = self.link("touching", "time.duration=24", "output.trajectory=0")
        self.assertLess(numpy.abs(link - self.TURNS).max(), 1e-2)
        self.assertGreater(series["writhe"][-1], 1.5)
        self.assertGreater(series["contacts"][-1], 4)

    def test_link_is_lost_without_contact(self):
        """Each passage through itself takes two turns."""
        link, series = self.link("passing", "time.duration=24", "contact.self=false", "output.trajectory=0")
        self.assertAlmostEqual(link[-1], self.TURNS - 2, delta=5e-2)


if __name__ == "__main__":
    unittest.main()
