"""skein.arms.ReachArms: the methods and shapes of a Gymnasium vector environment, each arm with the bits that it has alone, and arms that return to their start while others go on."""

import unittest

import numpy as np

from package import skein  # noqa: F401

from skein.arms import EPISODE, MUSCLES, ReachArms

OBSERVED = 18
UPRIGHT = np.outer([0.25, 0.5, 0.75, 1.0], [0, 0, 1]).ravel()  # ends of the links at the start, over the length


def pulls(arms, step):
    """Of each arm its own, by its number."""
    return 0.5 * np.sin(np.outer(1 + np.asarray(arms), np.arange(1, 1 + MUSCLES)) + 0.7 * step)


class Arms(unittest.TestCase):
    def tips(self, arms, steps, **options):
        """Positions of the tips after each step."""
        environment = ReachArms(len(arms), threads=1)
        environment.reset(seed=1)
        places = []
        for step in range(steps):
            observed, *_ = environment.step(pulls(arms, step))
            places.append(environment._links[-1].position[:, -1].copy())
        environment.close()
        return np.array(places)

    def test_methods_and_shapes(self):
        environment = ReachArms(3, threads=1)
        observed, infos = environment.reset(seed=5)
        self.assertEqual((observed.shape, observed.dtype, infos), ((3, OBSERVED), np.float32, {}))
        self.assertTrue(environment.observation_space.contains(observed))
        self.assertEqual((environment.action_space.shape, environment.single_action_space.shape, environment.single_observation_space.shape), ((3, MUSCLES), (MUSCLES,), (OBSERVED,)))
        environment.action_space.seed(2)
        for _ in range(3):
            action = environment.action_space.sample()
            self.assertTrue(environment.action_space.contains(action))
            observed, rewards, terminated, truncated, infos = environment.step(action)
        self.assertEqual((observed.shape, rewards.shape, terminated.dtype, truncated.tolist()), ((3, OBSERVED), (3,), np.dtype(bool), [False] * 3))
        np.testing.assert_allclose(rewards, -infos["distance_m"] / 0.4 + (infos["distance_m"] < 0.02))
        again, _ = environment.reset(seed=5)
        np.testing.assert_array_equal(again[:, :12], np.tile(UPRIGHT, (3, 1)).astype(np.float32))
        other, _ = ReachArms(3, threads=1).reset(seed=5)
        np.testing.assert_array_equal(again, other, err_msg="a seed gives the same targets")
        environment.close()

    def test_each_arm_has_the_bits_that_it_has_alone(self):
        together = self.tips(range(11), 4)
        self.assertGreater(np.abs(together[-1] - together[-1, :1]).max(), 1e-3, "arms move apart")
        for arm in (0, 7, 10):
            np.testing.assert_array_equal(self.tips([arm], 4)[:, 0], together[:, arm], err_msg=f"arm {arm}")

    def test_single_arms_return_to_their_start(self):
        environment = ReachArms(6, threads=1)
        environment.reset(seed=1)
        for step in range(3): environment.step(pulls(range(6), step))
        mask = np.arange(6) == 4
        environment.reset(options={"reset_mask": mask})
        for step in range(3):
            environment.step(np.where(mask[:, None], pulls(range(6), step), pulls(range(6), 3 + step)))
        places = environment._links[-1].position[:, -1]
        whole = self.tips(range(6), 6)
        np.testing.assert_array_equal(places[~mask], whole[5, ~mask])
        np.testing.assert_allclose(places[4], whole[2, 4], rtol=0, atol=1e-13, err_msg="frames are made orthonormal at other steps of its motion")
        environment.close()

    def return_of(self, keys, back, rods):
        """Largest distance of the rods `back` from a first run after they have returned, largest of the others from a run without; and how far they had gone."""
        def run(*restarts):
            with skein.Simulation(skein.Scene("touching", **keys), threads=1) as one:
                found = []
                for restart in restarts:
                    if restart: one["rod"].restart(back)
                    one.step(steps)
                    found.append(one["rod"].position.copy())
                return found
        steps = 400 if "integrator" not in keys["time"] else 40
        others = np.setdiff1d(range(rods), back)
        first, second = run(False, False)
        returned = run(False, True)[1]
        np.testing.assert_array_equal(returned[others], second[others], err_msg="others keep their bits")
        return np.abs(returned[back] - first[back]).max(), np.abs(second[back] - first[back]).max()

    def test_rods_that_touch_return_to_their_start(self):
        """Pairs of crossed rods that press on each other, with friction that remembers. One pair returns: to rounding it does what it did at first."""
        origins = [[x, y, z] for x in (0.0, 1.0, 2.0) for y, z in ((0.0, 0.0), (-0.05, 0.0019))]
        tangents = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] * 3
        rods = {"name": "rod", "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 1e-3}, "shape": {"length": 0.1, "elements": 5},
                "placement": {"kind": "list", "origins": [[x + (0.05 if k % 2 else 0.0), y, z] for k, (x, y, z) in enumerate(origins)], "tangents": tangents}}
        push = {"kind": "formula", "per": "length", "force": ["0.001/L*mod(rod, 2)", "0", "-0.01/L*(2*mod(rod, 2) - 1)"]}
        keys = {"rods": [rods], "time": {"duration": 1.0, "dt": 2e-6}, "load": [push], "constants": {},
                "contact": {"law": "linear", "stiffness": 20.0, "friction": "memory", "static_friction": 0.5}}
        away, gone = self.return_of(keys, [2, 3], 6)
        self.assertLess(away, 1e-13)
        self.assertGreater(gone, 1e-6)

    def test_rods_of_implicit_steps_return_to_their_start(self):
        rods = {"name": "rod", "start": "clamped", "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 1e-3}, "shape": {"length": 0.1, "elements": 6},
                "placement": {"kind": "list", "origins": [[0.0, 0.1 * k, 0.0] for k in range(3)], "tangents": [[1.0, 0.0, 0.0]] * 3}}
        for integrator in ("implicit", "implicit_damped"):
            away, gone = self.return_of({"rods": [rods], "time": {"duration": 1.0, "dt": 1e-3, "integrator": integrator}, "load": [{"kind": "gravity"}]}, [1], 3)
            self.assertLess(away, 1e-11, integrator)
            self.assertGreater(gone, 1e-4)

    def test_episodes_end_by_themselves(self):
        environment = ReachArms(2, threads=1)
        environment.reset(seed=1)
        environment._age[1] = EPISODE - 1
        observed, _, _, truncated, infos = environment.step(pulls(range(2), 0))
        self.assertEqual((truncated.tolist(), infos["_final_obs"].tolist()), ([False, True], [False, True]))
        np.testing.assert_allclose(observed[1, :12], UPRIGHT, atol=1e-7)
        self.assertGreater(np.abs(infos["final_obs"][1, :12] - observed[1, :12]).max(), 1e-6)
        environment.close()

    def test_a_reward_of_ones_own(self):
        environment = ReachArms(2, threads=1, reward=lambda tip, target, length: tip[:, 2] / length)
        environment.reset(seed=1)
        _, rewards, *_ = environment.step(np.zeros((2, MUSCLES)))
        np.testing.assert_allclose(rewards, 1, atol=0.02, err_msg="without pulls arms stand")
        environment.close()

    def test_what_cannot_return_to_its_start(self):
        staged = {"rods": [{"name": "rod", "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 1e-3}, "shape": {"length": 0.1, "elements": 4}}],
                  "time": {"duration": 0.01}, "stage": [{"name": "first", "until": "max_speed > 1.0"}, {"name": "second"}]}
        with skein.Simulation(skein.Scene("staged", **staged), threads=1) as run:
            with self.assertRaisesRegex(skein.RunFailed, "the scene has stages"): run["rod"].restart([0])
        with ReachArms(1, threads=1)._simulation as run:
            with self.assertRaisesRegex(skein.RunFailed, "no table 'pull'"): run.set_table("pull", [0.0, 1.0])
            with self.assertRaisesRegex(skein.RunFailed, "finite and rise"): run.set_table("way", [0.0, 1.0], at=[1.0, 1.0])


if __name__ == "__main__":
    unittest.main()
