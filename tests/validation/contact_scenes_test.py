"""Scenes of apps/contact against closed forms: collisions, a rod on an incline, twist and writhe of a rod that touches itself, a knot."""

import math
import unittest

import h5py
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


class Knot(SingleRuns):
    """An open overhand knot under tension T. Contact without friction only pushes across the rod, so that B k^2/2 + N = T all along it, with the
    curvature k and the tension N. In the loop N is small where the rod is thin, hence T R^2/B -> 1/2 (Audoly, Clauvelin, Neukirch 2007)."""

    TENSION, RADIUS, MODULUS = 8e-3, 0.003, 1e6
    BENDING = MODULUS * math.pi * RADIUS**4 / 4

    def pulled(self, out, duration, *settings):
        """Its end state: curvature at the inner vertices, and B k^2/2 + N over T there."""
        self.run_alone(out, f"time.duration={duration}", f"output.trajectory={duration}", *settings, scene=APPS / "contact/knot.toml")
        frames = []
        for segment in sorted((self.directory / out).glob("trajectory_*.h5")):
            with h5py.File(segment) as file:
                frames += list(next(iter(file["groups"].values()))["position"][:, 0])
        rest, edges = numpy.linalg.norm(frames[0][1] - frames[0][0]), numpy.diff(frames[-1], axis=0)
        lengths = numpy.linalg.norm(edges, axis=1)
        directions = edges / lengths[:, None]
        curvature = numpy.arccos(numpy.clip((directions[1:] * directions[:-1]).sum(axis=1), -1, 1)) / rest
        stretch = lengths / rest - 1
        tension = self.MODULUS * math.pi * self.RADIUS**2 * 0.5 * (stretch[1:] + stretch[:-1])
        return curvature, (0.5 * self.BENDING * curvature**2 + tension) / self.TENSION

    def test_loop_stays_and_carries_the_tension(self):
        curvature, share = self.pulled("tied", 25)
        self.assertAlmostEqual(share[0], 1, delta=1e-3)  # through the knot without loss
        self.assertAlmostEqual(share[-1], 1, delta=1e-3)
        self.assertLess(numpy.abs(share - 1).max(), 5e-2)  # loop and contacts: elements are straight, and corners rub
        loop = numpy.flatnonzero(curvature > 0.5 * curvature.max())
        mean = curvature[loop[0]:loop[-1] + 1].mean()
        r_over_R = self.RADIUS * math.sqrt(2 * self.TENSION / self.BENDING)
        self.assertAlmostEqual(self.TENSION / (self.BENDING * mean**2), 0.5, delta=3 * r_over_R)
        writhe = self.series("tied")["writhe"]
        self.assertLess(numpy.abs(writhe - 3).max(), 0.5)  # a passage would take 2

    def test_slips_open_without_contact(self):
        self.pulled("slips", 15, "contact.self=false")
        self.assertLess(abs(self.series("slips")["writhe"][-1]), 0.1)


if __name__ == "__main__":
    unittest.main()
