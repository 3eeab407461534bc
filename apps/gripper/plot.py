#!/usr/bin/env python3
"""Prints how a gripper has held its ball: plot.py OUT_DIR. Draws OUT_DIR/gripper.png: heights and ways over time. Needs numpy, h5py and matplotlib."""

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

CLOSED, OPENS, FRICTION, WEIGHT = 1.2, 4.2, 0.8, 200 * 4 / 3 * np.pi * 0.04**3 * 9.81


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    run = skein.open(out)
    if not {"ball", "palm", "fingers"} <= set(run.groups) or not run.contact_steps:
        sys.exit(f"{out}: no gripper; give the output directory of a run of gripper.toml")
    if run.frames.time[-1] < OPENS: sys.exit(f"{out}: the run ends before the ball has been carried, at {OPENS} s")
    dt = run.frames.time[-1] / run.frames.step[-1]
    time, ball, palm = run.frames.time[:], run["ball"].position[:, 0, 0], run["palm"].position[:, 0, 0]
    series = run.series
    held = (series["time"] > CLOSED) & (series["time"] < OPENS)
    lost = np.ptp(series["contact_friction_work"][held])
    normal, upwards = [], []
    for step in run.contact_steps:
        if not CLOSED < step * dt < OPENS: continue
        contacts = run.contacts(int(step))
        normal.append(np.sum(contacts["normal[N]"]))
        upwards.append(abs(np.sum(contacts["force_z[N]"])))
    print(f"the ball went {ball[-1, 0] - ball[0, 0]:.4f} m along and {np.max(ball[:, 2]) - ball[0, 2]:.4f} m up")
    print(f"friction took {1e6 * lost:.2f} uJ while it was held: a slip of {1e6 * lost / (FRICTION * np.mean(normal)):.2f} um at the mean grip of {np.mean(normal):.2f} N")
    print(f"fingers bear {np.median(upwards) / WEIGHT:.4f} of its weight (median)")
    figure, axis = plt.subplots(figsize=(7, 3.5))
    axis.plot(time, ball[:, 2], label="height of the ball, m")
    axis.plot(time, ball[:, 0], label="way of the ball, m")
    axis.plot(time, palm[:, 0], "--", label="way of the palm, m")
    axis.set_xlabel("time, s")
    axis.legend(frameon=False)
    bare(axis, "left", "bottom")
    figure.savefig(run.directory / "gripper.png", dpi=150, bbox_inches="tight")
    print(run.directory / "gripper.png")


if __name__ == "__main__":
    needs.in_words(main)
