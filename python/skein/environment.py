"""An environment of gymnasium: a soft arm that is to reach a point. Needs gymnasium; the arm's muscles are tables of arm.toml, beside this file."""

from pathlib import Path

import gymnasium
import numpy as np

from .simulation import Simulation

SCENE = Path(__file__).with_name("arm.toml")
MUSCLES = 6
STEP = 0.02   # s, between two actions
NEAR = 0.02   # m: the target is reached


class Reach(gymnasium.Env):
    """One action: the pulls of six muscles, -1 to 1, which they come to linearly until the next. Observed: positions of seven nodes along the arm and the
    velocity of its tip over its length, and the target, over its length. Reward: minus the tip's distance from the target, over the length, and 1 a step
    where it is near; an episode ends with the scene."""

    metadata = {"render_modes": []}

    def __init__(self, scene=SCENE, threads=1, **keys):
        self._scene, self._threads, self._keys = scene, threads, keys
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (MUSCLES,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (27,), np.float32)
        self.simulation = None

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.simulation = Simulation(self._scene, self._threads, **self._keys)
        self._arm = self.simulation["arm"]
        rest = self._arm.position[0]
        self._length = float(np.linalg.norm(np.diff(rest, axis=0), axis=1).sum())
        self._seen = np.linspace(0, len(rest) - 1, 8).astype(int)[1:]
        away = self.np_random.normal(size=3)
        away[2] = abs(away[2])
        target = (options or {}).get("target", rest[0] + self._length * self.np_random.uniform(0.4, 0.8) * away / np.linalg.norm(away))
        self.target = np.asarray(target, float)
        self._batch = round(STEP / self.simulation.dt)
        return self._observed(), {"target": self.target}

    def step(self, action):
        simulation = self.simulation
        until = simulation.after(self._batch)
        for muscle, pull in enumerate(np.clip(action, -1, 1), 1):
            simulation.drive(f"pull_{muscle}", float(pull), until)
        simulation.step(self._batch)
        distance = float(np.linalg.norm(self._arm.position[0, -1] - self.target))
        reward = -distance / self._length + (distance < NEAR)
        return self._observed(), reward, False, simulation.finished, {"distance_m": distance}

    def _observed(self):
        places = (self._arm.position[0, self._seen] - self._arm.position[0, 0]) / self._length
        return np.concatenate([places.ravel(), self._arm.velocity[0, -1] / self._length, (self.target - self._arm.position[0, 0]) / self._length]).astype(np.float32)

    def close(self):
        if self.simulation:
            self.simulation.close()
            self.simulation = None
