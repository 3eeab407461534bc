#!/usr/bin/env python3
"""Speed of a snake that crawls: crawl.py OUT_DIR

Prints how far its centre gets in a period, in rod lengths: ahead along the mean direction from start to end in each period and to the
left of it, mean over whole periods after the first; and along the direction in which it lay at the start and to the left of that, from
the third period on, as PyElastica's example tells it. Needs numpy and h5py.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py")
import numpy as np  # noqa: E402

import skein  # noqa: E402


def crawl(directory):
    """Ahead and sideways of each period after the first, [periods - 1], and the mean way in a period as it lay at the start, [2]; lengths."""
    run = skein.open(directory)
    muscles = [load for load in run.physics.get("load", []) if load["kind"].startswith("muscle")]
    if not muscles or not len(run.frames):
        raise SystemExit(f"{directory}: no rod with muscles, or no frames of it")
    period, length = muscles[0]["period"], run.physics["rods"][0]["shape"]["length"]
    time, nodes = np.asarray(run.time) / period, np.asarray(run.rods[0].position)[:, 0] / length
    weight = np.ones(nodes.shape[1])
    weight[[0, -1]] = 0.5
    centre, way = nodes.transpose(0, 2, 1) @ weight / weight.sum(), nodes[:, -1] - nodes[:, 0]
    ahead, sideways = [], []
    for k in range(1, int(time[-1] + 1e-9)):
        first, last = np.abs(time - k).argmin(), np.abs(time - k - 1).argmin()
        along = way[first + 1:last + 1, :2].sum(axis=0)
        along /= np.linalg.norm(along)
        moved = (centre[last] - centre[first])[:2]
        ahead.append(moved @ along)
        sideways.append(moved @ [-along[1], along[0]])
    third, start = np.abs(time - 2).argmin(), way[0, :2] / np.linalg.norm(way[0, :2])
    mean = (centre[-1] - centre[third])[:2] / (time[-1] - time[third])
    return np.array(ahead), np.array(sideways), np.array([mean @ start, mean @ [-start[1], start[0]]])


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__.strip())
    ahead, sideways, mean = crawl(sys.argv[1])
    print(f"ahead     {ahead.mean():.4f} L/T, from {ahead.min():.4f} to {ahead.max():.4f}\nsideways  {sideways.mean():.4f} L/T")
    print(f"as it lay {mean[0]:.4f} L/T along, {mean[1]:.4f} L/T to the left")


if __name__ == "__main__":
    needs.in_words(main)
