"""skein.arms.ReachArms: the methods and shapes of a Gymnasium vector environment, each arm with the bits that it has alone, and arms that return to their start while others go on."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from package import MPIRUN, ROOT, skein

from skein.arms import EPISODE, JOINTED, MUSCLES, ReachArms

OBSERVED = 18
MOTORS = 3
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

    def jointed_tips(self, arms, steps, back=()):
        """Tips of jointed arms after each step, and the angles of their second hinges at the end. Arms `back` return to their start halfway, and begin again."""
        environment = ReachArms(len(arms), threads=1, scene=JOINTED)
        environment.reset(seed=1)
        mask = np.isin(arms, back)
        places = []
        for step in range(steps):
            if step == steps // 2 and mask.any(): environment.reset(options={"reset_mask": mask})
            when = np.where(mask & (step >= steps // 2), step - steps // 2, step)
            actions = 0.5 * np.sin(np.outer(1 + np.asarray(arms), np.arange(1, 1 + MOTORS + MUSCLES)) + 0.7 * when[:, None])
            environment.step(actions)
            places.append(environment._links[-1].position[:, -1].copy())
        directions = [link.directors[:, at, 2] for link, at in ((environment._links[1], -1), (environment._links[2], 0))]
        environment.close()
        return np.array(places), np.arccos(np.clip((directions[0] * directions[1]).sum(axis=1), -1, 1)), 0.6 * actions[:, MUSCLES + 1]

    def test_arms_with_motors_at_their_joints(self):
        """Motors turn hinges towards the angles of the actions; each arm has the bits that it has alone; single arms return."""
        environment = ReachArms(2, threads=1, scene=JOINTED)
        self.assertEqual(environment.single_action_space.shape, (MUSCLES + MOTORS,))
        environment.close()
        together, angles, wanted = self.jointed_tips(range(11), 6)
        self.assertGreater(np.abs(together[-1] - together[-1, :1]).max(), 1e-3, "arms move apart")
        self.assertGreater(np.corrcoef(angles, np.abs(wanted))[0, 1], 0.8, "hinges follow their motors")
        for arm in (0, 7, 10):
            np.testing.assert_array_equal(self.jointed_tips([arm], 6)[0][:, 0], together[:, arm], err_msg=f"arm {arm}")
        returned, _, _ = self.jointed_tips(range(11), 6, back=[4])
        others = np.arange(11) != 4
        np.testing.assert_array_equal(returned[:, others], together[:, others])
        np.testing.assert_allclose(returned[3:, 4], together[:3, 4], rtol=0, atol=1e-12)

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

    def on_ranks(self, keys, back, ranks):
        """Digest of all rods after some steps, the return of some, and more steps: on ranks, and in this process. In contact one rank names rods that others own."""
        steps = 60
        program = f"""
import sys; sys.path.insert(0, {str(ROOT / "python")!r})
import os, pathlib, skein
rank = int(os.environ.get("OMPI_COMM_WORLD_RANK", 0))
simulation = skein.Simulation(skein.Scene("ranks", **{keys!r}), threads=1).step({steps})
simulation["rod"].restart({back!r} if rank == 0 or not {"contact" in keys} else [])
pathlib.Path(sys.argv[1] + str(rank)).write_text(simulation.step({steps}).digest)
"""
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([MPIRUN, "-n", str(ranks), sys.executable, "-c", program, folder + "/digest"], check=True, timeout=200)
            found = {file.read_text() for file in pathlib.Path(folder).iterdir()}
        with skein.Simulation(skein.Scene("alone", **keys), threads=1) as one:
            one.step(steps)
            one["rod"].restart(back)
            self.assertEqual(found, {one.step(steps).digest})

    def test_rods_return_on_several_ranks(self):
        """Rods of a pile, whose owners are others than the rank that names them, and rods of implicit steps: the bits of one rank."""
        rods = {"name": "rod", "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 1e-3}, "shape": {"length": 0.05, "elements": 5},
                "placement": {"kind": "list", "origins": [[0.01 * k, 0.0, 0.0] if k < 4 else [-0.005, 0.01 * (k - 4) + 0.005, 0.0019] for k in range(8)],
                              "tangents": [[0.0, 1.0, 0.0]] * 4 + [[1.0, 0.0, 0.0]] * 4}}
        touching = {"rods": [rods], "time": {"duration": 1.0, "dt": 2e-6}, "load": [{"kind": "gravity"}],
                    "contact": {"law": "linear", "stiffness": 20.0, "friction": "memory", "static_friction": 0.5},
                    "wall": [{"name": "floor", "kind": "plane", "point": [0.0, 0.0, -0.00095], "law": "linear", "stiffness": 20.0, "friction": "memory", "static_friction": 0.5}]}
        implicit = {"rods": [rods | {"start": "clamped"}], "time": {"duration": 1.0, "dt": 1e-3, "integrator": "implicit"}, "load": [{"kind": "gravity"}]}
        for keys in (touching, implicit):
            for ranks in (2, 3):
                with self.subTest(integrator=keys["time"].get("integrator"), ranks=ranks): self.on_ranks(keys, [2, 5], ranks)

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
