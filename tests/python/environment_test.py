"""skein.environment.Reach, by gymnasium where it is there, else by the little of it that an environment needs."""

import sys
import types
import unittest

import numpy as np

from package import skein

try:
    import gymnasium  # noqa: F401
except ImportError:
    class Env:
        def reset(self, *, seed=None, options=None):
            self.np_random = np.random.default_rng(seed)

    def box(low, high, shape, dtype):
        return types.SimpleNamespace(low=low, high=high, shape=shape, dtype=dtype)

    stand_in = types.ModuleType("gymnasium")
    stand_in.Env, stand_in.spaces = Env, types.SimpleNamespace(Box=box)
    sys.modules["gymnasium"] = stand_in

from skein.environment import MUSCLES, SCENE, Reach  # noqa: E402


class Environment(unittest.TestCase):
    def episode(self, action, **options):
        environment = Reach()
        observed, told = environment.reset(seed=3, **options)
        self.assertEqual((observed.shape, observed.dtype), (environment.observation_space.shape, np.float32))
        rewards, ended = [], False
        while not ended:
            observed, reward, _, ended, told = environment.step(action)
            rewards.append(reward)
        self.assertTrue(np.isfinite(observed).all())
        return environment, observed, rewards, told

    def test_an_episode(self):
        environment, observed, rewards, told = self.episode(np.zeros(MUSCLES))
        self.assertEqual(len(rewards), 100)
        np.testing.assert_allclose(observed[18:21], [0, 0, 1], atol=0.01, err_msg="without pulls the arm stands")
        again = self.episode(np.zeros(MUSCLES))
        self.assertEqual(environment.simulation.digest, again[0].simulation.digest)

    def test_muscles_bend_the_arm_and_a_pull_can_be_rewarded(self):
        pull = np.array([0.6, 0.6, 0.6, 0, 0, 0])
        environment, observed, _, _ = self.episode(pull)
        self.assertLess(abs(observed[18]), 1e-6, "about d1 it bends across d1")
        self.assertGreater(abs(observed[19]), 0.3)
        tip = environment._arm.position[0, -1].copy()
        _, _, rewards, told = self.episode(pull, options={"target": tip})
        self.assertLess(told["distance_m"], 1e-12)
        self.assertGreater(rewards[-1], rewards[0] + 1)

    def test_what_was_done_is_a_scene(self):
        environment, *_ = self.episode(np.array([0.5, -0.2, 0.1, 0.3, 0.2, -0.4]))
        tables = {f"table.{k}.{part}": values for k in range(MUSCLES) for part, values in zip(("at", "value"), environment.simulation.table(f"pull_{k + 1}"))}
        repeated = skein.Simulation(SCENE, **tables)
        repeated.step(environment.simulation.steps_done)
        self.assertEqual(repeated.digest, environment.simulation.digest)


if __name__ == "__main__":
    unittest.main()
