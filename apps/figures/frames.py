"""Frames of whole rods that a run has written (trajectory_*.h5). Needs numpy and h5py."""

from pathlib import Path

import h5py


def frames(directory):
    """[(time s, file, number)] of all of them, in order of time."""
    found = []
    for path in sorted(Path(directory).glob("trajectory_*.h5")):
        with h5py.File(path) as file:
            found += [(float(t), path, k) for k, t in enumerate(file["time"][:])]
    return found


def read_rods(path, number):
    """Nodes [rods, nodes, 3] and radius of the first group, m: [nodes], or [rods, nodes] of rods with sizes of their own."""
    with h5py.File(path) as file:
        group = next(iter(file["groups"].values()))
        return group["position"][number].astype(float), group["radius"][:]


def rods_at(directory, time):
    """The same of the frame nearest to a time, s, and its time."""
    t, path, number = min(frames(directory), key=lambda frame: abs(frame[0] - time))
    return *read_rods(path, number), t
