#!/usr/bin/env python3
"""Learns to reach a point with a soft arm of four links, by an evolution strategy: every arm of skein.arms.ReachArms tries a policy of its own.

    python3 apps/arms/learn.py --out out/learn            # 256 arms, 60 generations
"""

import argparse
import csv
from pathlib import Path

import numpy as np

from skein.arms import JOINTED, SCENE, ReachArms

ACTIONS = 40        # of an episode
TARGET = (0.15, 0.1, 0.25)  # m, from the foot
SPREAD, RATE = 0.1, 0.3     # of the tried weights, and of a step


def evaluated(arms, weights):
    """Mean reward over an episode of the policies pull = tanh(W [observed, 1]), [arms]."""
    observed, _ = arms.reset(options={"targets": arms.targets * 0 + np.array(TARGET)})
    total = np.zeros(len(weights))
    for _ in range(ACTIONS):
        seen = np.concatenate([observed, np.ones((len(observed), 1))], axis=1)
        observed, rewards, *_ = arms.step(np.tanh(np.einsum("amo,ao->am", weights, seen)))
        total += rewards
    return total / ACTIONS


def learned(arms, generations, seed=1, told=print):
    """Weights of the mean policy, and (generation, mean, best) of the rewards."""
    random, mean = np.random.default_rng(seed), np.zeros((arms.single_action_space.shape[0], arms.single_observation_space.shape[0] + 1))
    curve = []
    for generation in range(generations):
        half = random.normal(size=(arms.num_envs // 2, *mean.shape))
        tried = np.concatenate([half, -half])
        rewards = evaluated(arms, mean + SPREAD * tried)
        rank = np.argsort(np.argsort(rewards)) / (len(rewards) - 1) - 0.5
        mean = mean + RATE * np.tensordot(rank, tried, 1) / len(tried) / SPREAD
        curve.append((generation, rewards.mean(), rewards.max()))
        told(f"generation {generation:3d}: mean reward {rewards.mean():+.3f}, best {rewards.max():+.3f}")
    return mean, curve


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arms", type=int, default=256)
    parser.add_argument("--generations", type=int, default=60)
    parser.add_argument("--jointed", action="store_true", help="arms whose links are joined by hinges with motors, besides their muscles")
    parser.add_argument("--out", type=Path, default=Path("out/learn"))
    arguments = parser.parse_args()
    _, curve = learned(ReachArms(arguments.arms, scene=JOINTED if arguments.jointed else SCENE), arguments.generations)
    arguments.out.mkdir(parents=True, exist_ok=True)
    with open(arguments.out / "curve.csv", "w", newline="") as file:
        csv.writer(file).writerows([("generation", "mean", "best"), *curve])
    try:
        import matplotlib
    except ImportError:
        return
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    generation, mean, best = zip(*curve)
    plt.figure(figsize=(6, 4))
    plt.plot(generation, mean, label="mean of all arms")
    plt.plot(generation, best, label="best arm")
    plt.xlabel("generation"), plt.ylabel("mean reward of an episode"), plt.legend()
    plt.savefig(arguments.out / "curve.png", dpi=150)


if __name__ == "__main__":
    main()
