#!/usr/bin/env python3
"""Prints what a mechanism did beside its closed form, and draws it: plot.py OUT_DIR. Writes OUT_DIR/mechanism.png. Needs numpy, h5py and matplotlib."""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

import skein  # noqa: E402
from skein.style import bare  # noqa: E402


def door(run):
    """A damped oscillator until it is back at its stop: I q'' + c q' + k q = 0 from a rate of 2 rad/s."""
    inertia, drag, spring, rate = 20 * (0.9**2 + 0.04**2) / 12 + 20 * 0.45**2, 8.0, 30.0, 2.0
    decay, own = drag / (2 * inertia), np.sqrt(spring / inertia)
    swing = np.sqrt(own**2 - decay**2)
    time, place = run.frames.time[:], run["door"].position[:, 0, 0]
    angle = np.arctan2(place[:, 1], place[:, 0])
    back = np.pi / swing
    shut = time[np.argmax((time > 0.5) & (angle < 0))]
    free = time < back
    closed = rate / swing * np.exp(-decay * time[free]) * np.sin(swing * time[free])
    print(f"opens to {np.max(angle):.4f} rad, {np.max(closed):.4f} expected; shuts after {shut:.2f} s, {back:.3f} s expected; off by {np.max(np.abs(angle[free] - closed)):.1e} rad until then")
    return time, {"angle of the door, rad": angle, "closed form, rad": np.interp(time, time[free], closed, right=0.0)}


def four_bar(run):
    """The rocker's angle follows from the crank's: two circles meet at the coupler's end."""
    coupler, rocker, apart = 0.3, 0.25, 0.3
    time, place = run.frames.time[:], run["rocker"].position[:, 0, 0]
    pin = 2 * run["crank"].position[:, 0, 0]
    angle = np.arctan2(place[:, 2], place[:, 0] - apart)
    way = np.array([apart, 0.0]) - pin[:, [0, 2]]
    far = np.linalg.norm(way, axis=1)
    along = (coupler**2 - rocker**2 + far**2) / (2 * far)
    aside = np.sqrt(coupler**2 - along**2)
    end = pin[:, [0, 2]] + along[:, None] * way / far[:, None] + aside[:, None] * np.stack([-way[:, 1], way[:, 0]], axis=1) / far[:, None]
    closed = np.arctan2(end[:, 1], end[:, 0] - apart)
    print(f"the rocker swings by {np.ptp(angle):.4f} rad, {np.ptp(closed):.4f} rad expected; off by {np.max(np.abs(angle - closed)):.1e} rad at most; "
          f"the widest gap of a hinge is {1e6 * np.max(run.series['joint_gap']):.1f} um")
    return time, {"angle of the rocker, rad": angle, "closed form, rad": closed}


def frame(run):
    """The load is that of the press: its stiffness times what the beam is behind."""
    time = run.tips.time[:]
    down = np.interp(time, [0.0, 1.0, 4.0], [0.0, 0.45, 0.525])
    height = run["inner"].tips[:, 0, 1]
    behind = 1.2 - down - height
    load = -1e6 * behind
    print(f"the frame bears {np.max(load):.0f} N, at {1.2 - height[np.argmax(load)]:.3f} m; 18545 N by shooting, 18559 N of the elastica")
    return time, {"load, kN": load / 1e3}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    run = skein.open(out)
    cases = {"door": door, "rocker": four_bar, "inner": frame}
    known = [case for group, case in cases.items() if group in run.groups]
    if not known: sys.exit(f"{out}: no mechanism of this folder; give the output directory of a run of door.toml, four_bar.toml or frame.toml")
    time, curves = known[0](run)
    figure, axis = plt.subplots(figsize=(7, 3.5))
    for (label, values), style in zip(curves.items(), ("-", "--")):
        axis.plot(time, values, style, label=label)
    axis.set_xlabel("time, s")
    axis.legend(frameon=False)
    bare(axis, "left", "bottom")
    figure.savefig(run.directory / "mechanism.png", dpi=150, bbox_inches="tight")
    print(run.directory / "mechanism.png")


if __name__ == "__main__":
    needs.in_words(main)
