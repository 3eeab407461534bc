"""Many soft arms at once that are to reach points, with the methods and shapes of Gymnasium's vector environments. Needs numpy alone; see arms.toml and jointed_arms.toml,
beside this file."""

import re
from pathlib import Path

import numpy as np

from .simulation import Simulation

SCENE = Path(__file__).with_name("arms.toml")
JOINTED = Path(__file__).with_name("jointed_arms.toml")  # with motors at the joints
LINKS, AXES = 4, 2
MUSCLES = LINKS * AXES
STEP = 0.02     # s, between two actions
EPISODE = 100   # actions
NEAR = 0.02     # m: the target is reached


class Box:
    """Space of arrays, as gymnasium.spaces.Box has it."""

    def __init__(self, low, high, shape, dtype=np.float32, seed=None):
        self.shape, self.dtype = tuple(shape), np.dtype(dtype)
        self.low, self.high = np.full(shape, low, dtype), np.full(shape, high, dtype)
        self.seed(seed)

    def seed(self, seed=None):
        self._random = np.random.default_rng(seed)

    def sample(self):
        return self._random.uniform(np.maximum(self.low, -1e3), np.minimum(self.high, 1e3), self.shape).astype(self.dtype)

    def contains(self, x):
        x = np.asarray(x)
        return x.shape == self.shape and bool(np.all(x >= self.low) and np.all(x <= self.high))

    def __repr__(self):
        return f"Box({self.low.min()}, {self.high.max()}, {self.shape}, {self.dtype})"


class ReachArms:
    """`num_envs` arms of four links, side by side in SIMD lanes, on threads and, under mpirun, on ranks, each of which has arms of its own.

    Action of an arm: pulls of its eight muscles, -1 to 1, to which they come linearly until the next action; with scene = JOINTED of its three motors, too. Observed: the ends of its links, the velocity of
    its tip and its target, over its length. Reward: minus the tip's distance from the target, over the length, and 1 where it is near. An episode has
    EPISODE actions. An arm whose episode ends begins the next one in the same step (autoreset mode "SameStep"): `infos["final_obs"]` has what was observed last. `reward(tip, target, length)`: a function
    in place of this one, of arrays by arm. `scene`: of one arm, with rods link_1 to link_4, a table "way" and, for each number of an action, tables "from_NAME" and "to_NAME" by `rod`."""

    metadata = {"render_modes": [], "autoreset_mode": "SameStep"}
    render_mode = None

    def __init__(self, num_envs=1, threads=0, scene=SCENE, reward=None, **keys):
        copies = f"origins = [{', '.join(['[0.0, 0.0, 0.0]'] * num_envs)}]"
        text, found = re.subn(r"origins = \[\[.*?\]\]", copies, Path(scene).read_text(), count=1)
        self.actions = re.findall(r'^name = "to_(\w+)"', text, re.MULTILINE)
        if not found:
            raise ValueError(f"{scene}: the assembly has no 'origins' to copy")
        if not self.actions:
            raise ValueError(f"{scene}: no table is named to_NAME, which takes a number of each action")
        self._simulation = Simulation(text, threads, **keys)
        self._links = [self._simulation[f"link_{k}"] for k in range(1, LINKS + 1)]
        self.numbers = self._links[0].numbers  # of this rank's arms
        self.num_envs, self._all = len(self.numbers), num_envs
        self.single_action_space, self.single_observation_space = Box(-1, 1, (len(self.actions),)), Box(-np.inf, np.inf, (3 * LINKS + 6,))
        self.action_space, self.observation_space = Box(-1, 1, (self.num_envs, len(self.actions))), Box(-np.inf, np.inf, (self.num_envs, 3 * LINKS + 6))
        self._batch = round(STEP / self._simulation.dt)
        self._foot = self._links[0].position[:, 0].copy()
        self._length = LINKS * float(np.linalg.norm(np.diff(self._links[0].position[0], axis=0), axis=1).sum())
        self._reward = reward or self._distance_reward
        self._random = [np.random.default_rng() for _ in self.numbers]
        self._pull = np.zeros((self.num_envs, len(self.actions)))
        self._age = np.zeros(self.num_envs, int)
        self.targets = np.zeros((self.num_envs, 3))

    @staticmethod
    def _distance_reward(tip, target, length):
        distance = np.linalg.norm(tip - target, axis=1)
        return -distance / length + (distance < NEAR)

    def reset(self, *, seed=None, options=None):
        """`seed`: one for all, from which each arm has its own, or one for each arm. options: "reset_mask" [num_envs], the arms that return to their start; "targets" [num_envs, 3]."""
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, bool)))
        if seed is not None:
            seeds = [seed + int(number) for number in self.numbers] if np.isscalar(seed) else list(seed)
            self._random = [np.random.default_rng(one) if chosen else old for one, old, chosen in zip(seeds, self._random, mask)]
        self._begin(mask)
        if options and "targets" in options:
            self.targets[mask] = np.asarray(options["targets"], float)[mask]
        return self._observed(), {}

    def _begin(self, mask):
        """Arms of the mask at their start, with new targets and no pull."""
        if self._simulation.steps_done:
            for link in self._links:
                link.restart(self.numbers[mask])  # on all ranks, as arms may touch those of others
        for arm in np.flatnonzero(mask):
            away = self._random[arm].normal(size=3)
            away[2] = abs(away[2])
            self.targets[arm] = self._foot[arm] + self._length * self._random[arm].uniform(0.4, 0.8) * away / np.linalg.norm(away)
        self._pull[mask] = 0
        self._age[mask] = 0

    def _set_pulls(self, when, pulls):
        by_number = np.zeros((self._all + 1, len(self.actions)))  # a table has two points or more
        by_number[self.numbers] = pulls
        for name, column in zip(self.actions, by_number.T):
            self._simulation.set_table(f"{when}_{name}", column)

    def step(self, actions):
        actions = np.clip(np.asarray(actions, float).reshape(self.num_envs, len(self.actions)), -1, 1)
        self._set_pulls("from", self._pull)
        self._set_pulls("to", actions)
        self._simulation.set_table("way", [0.0, 1.0], at=[self._simulation.time, self._simulation.after(self._batch)])
        self._simulation.step(self._batch)
        self._pull[:] = actions
        self._age += 1
        tip = self._links[-1].position[:, -1]
        rewards = np.asarray(self._reward(tip - self._foot, self.targets - self._foot, self._length), float)
        infos = {"distance_m": np.linalg.norm(tip - self.targets, axis=1)}
        truncated = self._age >= EPISODE
        observed = self._observed()
        if truncated.any():
            infos |= {"final_obs": observed, "_final_obs": truncated}
        self._begin(truncated)
        if truncated.any():
            observed = self._observed()
        return observed, rewards, np.zeros(self.num_envs, bool), truncated, infos

    def _observed(self):
        ends = [(link.position[:, -1] - self._foot) / self._length for link in self._links]
        return np.concatenate([*ends, self._links[-1].velocity[:, -1] / self._length, (self.targets - self._foot) / self._length], axis=1).astype(np.float32)

    @property
    def digest(self):
        """Of all arms' state."""
        return self._simulation.digest

    def close(self):
        self._simulation.close()
