"""Rods of one file with very unlike masses: a restitution holds for the masses of each pair, and friction without memory for the mobilities of each pair."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from package import skein

BOUNCE = 0.5


def opened(folder, rows, material, elements, **tables):
    """Rods of a file: origin, tangent, length and radius."""
    file = Path(folder) / "rods.csv"
    np.savetxt(file, np.array(rows, float), delimiter=",", header="x,y,z,tx,ty,tz,length,radius", comments="", fmt="%.17g")
    rods = {"name": "rods", "material": material, "section": {"radius": 1e-3}, "shape": {"length": 0.1, "elements": elements}, "placement": {"kind": "file", "file": str(file)}}
    return skein.Simulation(skein.Scene("own", rods=[rods], **tables), threads=1)


def mean_velocity(run, rod):
    """Of the centre of mass: end nodes have half the mass."""
    v = run["rods"].velocity[rod]
    return (v.sum(axis=0) - 0.5 * (v[0] + v[-1])) / (len(v) - 1)


class OwnMasses(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)

    def crossed(self, at, length, radius, gap):
        """Two rods that cross in their middles, the first one above."""
        return [[at - length / 2, 0, 2 * radius + gap, 1, 0, 0, length, radius], [at, -length / 2, 0, 0, 1, 0, length, radius]]

    def bounces(self, normal):
        """Speeds at which a light pair and one 256 times as heavy part, over those at which they met."""
        law = {"law": normal, "restitution": BOUNCE, "collision_time": 2e-3} | ({"collision_speed": 0.05} if normal == "hertz" else {})
        push = {"kind": "formula", "per": "mass", "force": ["0", "0", "if(t < 0.001, -50*(1 - mod(rod, 2)), 0)"]}
        rows = self.crossed(0.0, 0.01, 5e-4, 6e-5) + self.crossed(1.0, 0.04, 4e-3, 6e-5)
        with opened(self._folder.name, rows, {"density": 1000.0, "youngs_modulus": 1e9}, 5, time={"duration": 0.008}, contact=law, load=[push]) as run:
            while run.time < 0.00101: run.step(1)
            before = [mean_velocity(run, k)[2] - mean_velocity(run, k + 1)[2] for k in (0, 2)]
            run.step(run.steps)
            after = [mean_velocity(run, k)[2] - mean_velocity(run, k + 1)[2] for k in (0, 2)]
            momenta = [mean_velocity(run, k)[2] + mean_velocity(run, k + 1)[2] for k in (0, 2)]
        np.testing.assert_allclose(before, -0.05, rtol=0.01)
        np.testing.assert_allclose(momenta, before, rtol=1e-6)
        return -np.array(after) / before

    def test_restitution_of_unlike_pairs(self):
        for normal in ("linear", "hertz"):
            with self.subTest(normal):
                np.testing.assert_allclose(self.bounces(normal), BOUNCE, atol=0.01)

    def test_friction_of_a_heavy_rod_beside_a_light_one(self):
        """Rails begin to run below a rod, which slips at first: v = mu g t and omega = 2 mu g t/r of a cylinder, whatever else lies in its file."""
        speed, mu, gravity, radius, until = 0.3, 0.5, 9.81, 5e-3, 0.006  # slip ends at speed/(3 mu gravity) = 0.02 s
        rails = {"name": "rails", "mass": 1e3, "inertia": [1e3, 1e3, 1e3], "velocity": [speed, 0.0, 0.0],
                 "capsules": {"from": [[-0.1, -0.03, 0.0], [-0.1, 0.03, 0.0]], "to": [[0.1, -0.03, 0.0], [0.1, 0.03, 0.0]], "radii": [radius, radius]}}
        stiffness, mass = 400.0, 1000.0 * np.pi * radius**2 * 0.1
        sunk = 0.5 * mass * gravity / stiffness
        rows = [[0.0, -0.05, 2 * radius - sunk, 0, 1, 0, 0.1, radius], [5.0, 0.0, 0.0, 1, 0, 0, 1e-3, 5e-5]]
        weight = {"kind": "formula", "per": "mass", "rods": ["rods"], "force": ["0", "0", f"if(rod < 0.5, {-gravity}, 0)"]}
        law = {"law": "linear", "stiffness": stiffness, "damping": 0.2, "friction": "regularised", "kinetic_friction": mu, "slip_speed": 1e-3}
        with opened(self._folder.name, rows, {"density": 1000.0, "youngs_modulus": 3e7}, 5, time={"duration": until}, contact=law, load=[weight], bodies=[rails]) as run:
            run.step(run.steps)
            speed_now, spin = mean_velocity(run, 0)[0], run["rods"].spin[0, :, 2].mean()
        self.assertAlmostEqual(speed_now / (mu * gravity * until), 1.0, delta=0.01)
        self.assertAlmostEqual(abs(spin) / (2 * mu * gravity * until / radius), 1.0, delta=0.02)


if __name__ == "__main__":
    unittest.main()
