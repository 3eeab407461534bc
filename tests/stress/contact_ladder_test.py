"""Collisions of two rods under contacts from soft to far stiffer than themselves, with and without dashpot, at the automatic step."""

import math
import unittest

import h5py
import numpy

from single_runs import SingleRuns, restitution_of_share

ELEMENTS, RADIUS, LENGTH, DENSITY, SPEED = 3, 0.01, 0.09, 1000.0, 0.1
MASS = DENSITY * math.pi * RADIUS**2 * LENGTH
MODES = ("kinetic_translation", "kinetic_rotation", "elastic_stretch", "elastic_shear", "elastic_bend", "elastic_twist", "contact_energy")

ROD = """
[[rods]]
name = "{name}"
[rods.material]
density = {density}
youngs_modulus = {modulus!r}
law = "linear"
[rods.section]
radius = {radius}
[rods.shape]
length = {length}
elements = {elements}
velocity = [0.0, 0.0, {velocity!r}]
[rods.placement]
origin = {origin}
tangent = {tangent}
"""


class Ladder(SingleRuns):
    def collide(self, stiffness, share, modulus, steps=0, gap=1e-5, safety=0.9):
        """Series and end of a central collision of crossed rods whose dashpot has a share of critical damping for both together."""
        time = math.pi / math.sqrt(2 * stiffness / MASS)
        rod = dict(density=DENSITY, modulus=modulus, radius=RADIUS, length=LENGTH, elements=ELEMENTS)
        duration = gap / SPEED + 4 * time * max(1.0, share) + 2e-3 * math.sqrt(1e9 / modulus)
        self.scene.write_text(
            f"[time]\nduration = {duration!r}\nsafety = {safety}\n"
            + ROD.format(name="target", velocity=0.0, origin=[-0.5 * LENGTH, 0.0, 0.0], tangent=[1.0, 0.0, 0.0], **rod)
            + ROD.format(name="striker", velocity=-SPEED, origin=[0.0, -0.5 * LENGTH, 2 * RADIUS + gap], tangent=[0.0, 1.0, 0.0], **rod)
            + f'[contact]\nlaw = "linear"\nstiffness = {stiffness!r}\ndamping = {2 * share * math.sqrt(0.5 * MASS * stiffness)!r}\n'
            + f"[output]\nseries = {duration / 200!r}\n"
            + (f'trajectory = {duration / steps!r}\nprecision = "double"\ndirectors = false\n' if steps else ""))
        self.run_alone("ladder")
        weight = numpy.array([0.5] + [1.0] * (ELEMENTS - 1) + [0.5]) / ELEMENTS
        speed = {name: float(weight @ rod["state"][0][:, 5]) for name, rod in self.state("ladder").items()}
        series = self.series("ladder")
        energy = sum(series[mode] for mode in MODES)
        self.assertEqual(series["contacts"][-1], 0)
        frames = None
        if steps:
            with h5py.File(sorted((self.directory / "ladder").glob("trajectory_*.h5"))[0]) as file:
                frames = {name: file[f"groups/{name}/position"][:, 0, :, 2] @ weight for name in speed}
        return (speed["striker"] - speed["target"]) / SPEED, energy / (0.5 * MASS * SPEED**2), frames

    def test_rods_as_stiff_as_their_contact(self):
        """E = 1e6/m k: each rung is the same collision in other units of time. Against the closed form of rigid rods: 1e-3 off at share 0.5."""
        for exponent in range(4, 11):
            for share in (0.0, 0.1, 0.5):
                stiffness = 10.0**exponent
                e, energy, _ = self.collide(stiffness, share, 1e6 * stiffness)
                self.assertAlmostEqual(e / restitution_of_share(share), 1, delta=1e-2, msg=f"k = 1e{exponent}, share {share}")
                self.assertLessEqual(e, 1 + 1e-6, f"k = 1e{exponent}")
                self.assertLessEqual(energy[-1], (1 + 1e-6) ** 2, f"k = 1e{exponent}, share {share}")

    def test_contacts_stiffer_than_rods(self):
        """The bounce loses to vibration and never gains. With a dashpot nor does the whole."""
        for exponent in range(4, 11):
            for share in (0.0, 0.1, 0.5):
                e, energy, _ = self.collide(10.0**exponent, share, 1e9)
                self.assertLessEqual(e, 1 + 1e-6, f"k = 1e{exponent}, share {share}")
                self.assertGreater(e, 0, f"k = 1e{exponent}, share {share}")
                if share > 0:
                    self.assertLessEqual(energy[-1], 1 + 1e-6, f"k = 1e{exponent}, share {share}")

    def test_energy_of_undamped_contacts_follows_the_step(self):
        """Where contact sets the step, a collision without dashpot ends with some energy more or less, after where in a step it begins.
        In Verlet's map of x'' = -w^2 x through the contact (v h)^2 - (w h)^2 a (v h - a) is kept, a: how far before the contact a step
        began, so v^2 changes by (w h)^2/4 of itself at most. Of second order: a third of the step, a ninth of the bound."""
        stiffness = 1e8
        for safety in (0.9, 0.2):
            worst = 0.0
            for gap in (1.00e-5, 1.04e-5, 1.08e-5, 1.12e-5, 1.16e-5, 1.20e-5):
                e, energy, _ = self.collide(stiffness, 0.0, 1e9, gap=gap, safety=safety)
                self.assertLessEqual(e, 1 + 1e-6)
                worst = max(worst, abs(energy[-1] - 1))
            self.assertLess(worst, 0.25 * (2 * min(safety, 0.6)) ** 2, f"safety {safety}")

    def test_a_contact_never_pulls(self):
        """Twice critical damping: what moves the striker's centre never points towards the other."""
        for exponent in (4, 6):
            _, _, frames = self.collide(10.0**exponent, 2.0, 1e9, steps=400)
            push = numpy.diff(frames["striker"], 2)
            self.assertGreater(push.max(), 1e-9)
            self.assertGreater(push.min(), -1e-14)
            self.assertLess(numpy.diff(frames["target"], 2).max(), 1e-14)


if __name__ == "__main__":
    unittest.main()
