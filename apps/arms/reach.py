#!/usr/bin/env python3
"""Drives the motors of arm.toml so that its hand reaches a place, although links and joints sag.

    reach.py [--target 0.55 0.55] [--out out/arm_driven.toml]

Every 20 ms the angles go on by the transposed Jacobian of the hand's place times its distance from the target. Prints the distance at the end of every second, and
writes the scene with the tables that the controller has left: `skein run` repeats the motion, bit for bit.
"""

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy")
import numpy as np  # noqa: E402

import skein  # noqa: E402

NAMES = ("angle_1", "angle_2", "angle_3", "angle_4")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", type=float, nargs=2, default=(0.55, 0.55), metavar=("X", "Z"), help="m")
    parser.add_argument("--gain", type=float, default=0.3, help="share of the distance that a turn takes off")
    parser.add_argument("--lead", type=float, default=0.5, help="time by which the hand's motion is looked ahead, s")
    parser.add_argument("--out", type=Path, help="scene to write")
    arguments = parser.parse_args()
    target, arm = np.array(arguments.target), skein.Simulation(HERE / "arm.toml")
    every = round(0.02 / arm.dt)
    angles = np.array([arm.table(name)[1][-1] for name in NAMES])
    arm.step(round(0.5 / arm.dt) + 1)  # up to the end of the scene's own tables
    while not arm.finished:
        hand, roots = arm["hand"].position[0, 0, ::2], arm["links"].position[:, 0, ::2]
        away = target - hand - arguments.lead * arm["hand"].velocity[0, 0, ::2]
        lever = hand - roots
        angles += arguments.gain * (lever[:, 1] * away[0] - lever[:, 0] * away[1]) / np.sum(lever**2)
        angles = np.clip(angles, -1.6, 1.6)
        for name, angle in zip(NAMES, angles):
            arm.drive(name, angle, until=arm.after(every))
        before = arm.time
        arm.step(every)
        if int(arm.time) > int(before): print(f"{arm.time:.2f} s: the hand is {1e3 * np.linalg.norm(away):.3f} mm from the target", flush=True)
    print(f"end: {1e3 * np.linalg.norm(target - arm['hand'].position[0, 0, ::2]):.3f} mm; {arm.observables['joint_motor_work[J]']:.3f} J of motors; angles {np.round(angles, 4)} rad")
    if arguments.out:
        scene = skein.Scene(str(HERE / "arm.toml"))
        for i, name in enumerate(NAMES):
            at, value = arm.table(name)
            scene[f"table.{i}.at"], scene[f"table.{i}.value"] = at.tolist(), value.tolist()
        scene.save(arguments.out)
        print(f"{arguments.out}: digest {arm.digest}")


if __name__ == "__main__":
    needs.in_words(main)
