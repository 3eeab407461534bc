"""skein.persistence_length: chains of a known length lie within the intervals for most seeds, in a plane and in space, with and without errors of points."""

import re
import unittest

import numpy as np

from package import ROOT, skein

FINE = 30  # tangents per chord


def plane_chains(random, count, chords, spacing, length=1.0):
    """Points of worm-like chains in a plane: the direction is a Brownian motion."""
    turns = random.normal(0, np.sqrt(spacing / FINE / length), (count, chords * FINE))
    angle = np.cumsum(turns, axis=1) + random.uniform(0, 2 * np.pi, (count, 1))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * spacing / FINE
    points = np.cumsum(steps, axis=1)[:, FINE - 1::FINE]
    return np.concatenate([np.zeros((count, 1, 2)), points], axis=1)


def space_chains(random, count, chords, spacing, length=1.0):
    """Points of worm-like chains in space. Each tangent is drawn about the last one by von Mises and Fisher's law, whose mean cosine is that of the chain."""
    step = spacing / FINE
    strength = 1 / (1 - np.exp(-step / length))  # coth is 1 to rounding
    tangent = np.tile([0.0, 0.0, 1.0], (count, 1))
    place, points = np.zeros((count, 3)), [np.zeros((count, 3))]
    for k in range(chords * FINE):
        cosine = 1 + np.log(1 - random.random(count)) / strength
        azimuth = random.uniform(0, 2 * np.pi, count)
        one = np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent), axis=1)])
        one /= np.linalg.norm(one, axis=1)[:, None]
        across = np.cos(azimuth)[:, None] * one + np.sin(azimuth)[:, None] * np.cross(tangent, one)
        tangent = cosine[:, None] * tangent + np.sqrt(1 - cosine**2)[:, None] * across
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        place = place + step * tangent
        if (k + 1) % FINE == 0:
            points.append(place)
    return np.stack(points, axis=1)


class PersistenceLength(unittest.TestCase):
    def held(self, chains, dimensions, noise, known=None, seeds=100, **how):
        """How many intervals have the true length, and the mean of inverse lengths with its standard error."""
        within, inverse = 0, []
        for seed in range(seeds):
            random = np.random.default_rng(seed)
            points = chains(random, **how)
            found = skein.persistence_length(points + random.normal(0, noise, points.shape), dimensions, noise=known)
            low, high = found.interval
            within += low <= 1 <= high
            inverse.append(1 / found.value)
        return within, np.mean(inverse), np.std(inverse) / np.sqrt(seeds)

    def test_chains_in_a_plane(self):
        for noise, known in ((0.0, 0.0), (0.003, None)):
            within, mean, error = self.held(plane_chains, 2, noise, known, count=20, chords=20, spacing=0.05)
            self.assertTrue(90 <= within <= 99, (noise, within))
            self.assertLess(abs(mean - 1), 3 * error + 0.003)

    def test_chains_in_space(self):
        for noise, known in ((0.0, 0.0), (0.003, None)):
            within, mean, error = self.held(space_chains, 3, noise, known, count=15, chords=16, spacing=0.05)
            self.assertTrue(90 <= within <= 99, (noise, within))
            self.assertLess(abs(mean - 1), 3 * error + 0.003)

    def test_noise_alone_does_not_pass_for_bends(self):
        """A mean of cosines of neighbours would be wrong by a factor; the noise that is found is the true one."""
        random = np.random.default_rng(5)
        points = plane_chains(random, 100, 40, 0.02)
        found = skein.persistence_length(points + random.normal(0, 0.002, points.shape), 2)
        self.assertAlmostEqual(found.noise / 0.002, 1, delta=0.03)
        self.assertAlmostEqual(found.value, 1, delta=0.12)
        near = found.correlation["cosine"][1]
        self.assertGreater(0.5 * 0.02 / -np.log(near) / found.value, 0.0)
        self.assertLess(0.5 * 0.02 / -np.log(near) / found.value, 0.3)
        np.testing.assert_allclose(found.correlation["cosine"], found.correlation["model"], atol=0.03)

    def test_shapes_of_unlike_lengths_and_spacings(self):
        random = np.random.default_rng(8)
        curves = [chain for chords, spacing in ((10, 0.03), (25, 0.05), (60, 0.02)) for chain in plane_chains(random, 40, chords, spacing)]
        curves += [chain[[0, 1, 3, 4, 7, 8, 9, 12]] for chain in plane_chains(random, 200, 12, 0.02)]
        found = skein.persistence_length([np.column_stack([5 * c, np.full(len(c), 2.0)]) for c in curves], 2)
        low, high = found.interval
        self.assertTrue(low < 5 < high, found)
        self.assertLess(high / low, 1.25)
        self.assertEqual(found.shapes, 320)

    def test_bent_at_rest(self):
        """Frames of one filament that is an arc at rest: about its mean the length is right, about a line it is not."""
        random, within = np.random.default_rng(3), 0
        for _ in range(20):
            angle = np.cumsum(random.normal(0, np.sqrt(0.05 / FINE), (30, 20 * FINE)), axis=1) + 5 * np.linspace(0, 1, 20 * FINE)
            points = np.cumsum(np.stack([np.cos(angle), np.sin(angle)], axis=-1) * 0.05 / FINE, axis=1)[:, ::FINE]
            low, high = skein.persistence_length(points, 2, rest="mean").interval
            within += low <= 1 <= high
        self.assertGreaterEqual(within, 17)
        self.assertLess(skein.persistence_length(points, 2).value, 0.5)

    def test_modulus(self):
        random = np.random.default_rng(3)
        found = skein.persistence_length(plane_chains(random, 100, 20, 0.05) * 1e-5, 2, noise=0)
        self.assertAlmostEqual(found.modulus(4e-9, 300) / (1.380649e-23 * 300 * found.value * 4 / np.pi / 4e-9**4), 1, delta=1e-12)

    def test_the_example_of_the_page(self):
        names = {}
        exec(re.findall(r"```python\n(.*?)```", (ROOT / "docs/traced_files.md").read_text(), re.S)[-1], names)
        low, high = names["found"].interval
        self.assertTrue(low < 15 < high)

    def test_faults(self):
        line = np.column_stack([np.arange(5.0), np.zeros(5)])
        for curves, dimensions, keys, words in (([], 2, {}, "no shapes"), ([line], 4, {}, "dimensions is 4"), ([line], 3, {}, "shape 0"),
                                                ([line[:2]], 2, {}, "three points"), ([line * np.nan], 2, {}, "not finite"), ([line], 2, {}, "exactly straight"),
                                                ([line[[0, 1, 1, 2]]], 2, {}, "two consecutive points"), ([line], 3, {"rest": "mean"}, "rest is"),
                                                ([np.random.default_rng(1).normal(size=(9, 2))], 2, {}, "quarter of the persistence length"),
                                                ([np.random.default_rng(1).normal(size=(9, 3))], 2, {}, "constant z")):
            with self.assertRaisesRegex(ValueError, words):
                skein.persistence_length(curves, dimensions, **keys)


if __name__ == "__main__":
    unittest.main()
