"""Frames of a fluid: results.fluid, {name: Output}, of output.fields ("fields") and of each [[fluid_output]]. Arrays are [z, y, x], as in the files."""

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .needs import Damaged, NotResults
from .own_file import OwnFile

QUANTITIES = {"speed": ("speed of the fluid", "m/s"), "vorticity": ("vorticity", "1/s"), "q": ("Q", "1/s²"), "pressure": ("pressure", "Pa"),
              **{f"velocity_{axis}": (f"velocity along {axis}", "m/s") for axis in "xyz"}, **{f"vorticity_{axis}": (f"vorticity along {axis}", "1/s") for axis in "xyz"}}


@dataclass
class Field:
    """Numbers [z, y, x] at the middles of cubes with this edge, m, the first of which has this lower corner, m."""
    values: np.ndarray
    lower: np.ndarray
    spacing: float

    @property
    def upper(self):
        return self.lower + self.spacing * np.array(self.values.shape[2::-1])


def outputs(directory):
    found = {}
    for path in sorted(directory.glob("f*_*.h5")):
        name = re.fullmatch(r"(?:fluid_(.+)|fields)_\d{12}\.h5", path.name)
        if name:
            found.setdefault(name[1] or "fields", []).append(path)
    return {name: Output(paths) for name, paths in found.items()}


class Output:
    """Frames of one output.

    time, step      of the frames
    kind            "box", "slice" or "blocks"
    across          axis of a slice, else ""
    """

    def __init__(self, paths):
        self.paths = paths
        self.step = np.array([int(path.stem.rsplit("_", 1)[1]) for path in paths])
        with OwnFile(paths[-1]) as file:
            self.kind, self.across = _text(file, "kind"), _text(file, "across") if "across" in file.attrs else ""
            self.fields = [name for name in ("velocity", "vorticity", "q", "pressure") if name in file]
            self.spacing = float(file.attrs["spacing"])

    @cached_property
    def time(self):
        return np.array([_time(path) for path in self.paths])

    def nearest(self, time):
        return int(np.argmin(np.abs(self.time - time)))

    def has(self, quantity):
        """Whether it holds a quantity, or the velocities from which that is computed."""
        base = _base(quantity)
        if base in self.fields:
            return True
        derived = base in ("vorticity", "q") and "velocity" in self.fields
        return derived and (self.kind == "box" or self.kind == "slice" and quantity == f"vorticity_{self.across}")

    def corners(self, frame):
        """Lower and upper corner of a box, of a slice or of all blocks, m."""
        with OwnFile(self.paths[frame]) as file:
            lower = np.array([file.attrs[f"lower_{axis}"] for axis in "xyz"])
            shape = file[self.fields[0]].shape
            if self.kind != "blocks":
                return lower, lower + self.spacing * np.array(shape[2::-1])
            blocks = file.read("lower").reshape(-1, 3)
            return (blocks.min(axis=0), blocks.max(axis=0) + self.spacing * np.array(shape[3:0:-1])) if len(blocks) else (lower, lower.copy())

    @cached_property
    def _corners(self):
        return [self.corners(frame) for frame in range(len(self.paths))]

    def reach(self, first=0, last=None):
        """Lower and upper corner, m, over the frames from a first to a last one: a box that follows rods moves."""
        low, high = zip(*self._corners[first:None if last is None else last + 1])
        return np.min(low, axis=0), np.max(high, axis=0)

    def read(self, frame, quantity):
        """A Field of one of QUANTITIES. Blocks: the smallest box of cells that has all of them, 0 between them, and a layer of zeros around."""
        base = _base(quantity)
        derived = base not in self.fields
        with OwnFile(self.paths[frame]) as file:
            lower = np.array([file.attrs[f"lower_{axis}"] for axis in "xyz"])
            name = "velocity" if derived else base
            field = _blocks(file, name, lower, self.spacing) if self.kind == "blocks" else Field(file.read(name), lower, self.spacing)
        if derived:
            field.values = vorticity_of(field.values, self.spacing) if base == "vorticity" else q_of(field.values, self.spacing)
        if quantity[-2:] in ("_x", "_y", "_z"):
            field.values = field.values[..., "xyz".index(quantity[-1])]
        elif field.values.ndim == 4:
            field.values = np.linalg.norm(field.values, axis=-1)
        return field


def _base(quantity):
    return "velocity" if quantity == "speed" else quantity.rsplit("_", 1)[0]


def _text(file, name):
    value = file.attrs[name]
    return value.decode() if isinstance(value, bytes) else str(value)


def _time(path):
    with OwnFile(path) as file:
        if _text(file, "format") != "skein fields":
            raise Damaged(f"{path}: is no frame of a fluid")
        return float(file.attrs["time"])


def _blocks(file, name, corner, spacing):
    first = np.rint((file.read("lower") - corner) / spacing).astype(int).reshape(-1, 3)
    cells = np.array(file[name].shape[3:0:-1])
    low, high = (first.min(axis=0), first.max(axis=0) + cells) if len(first) else (np.zeros(3, int), np.zeros(3, int))
    values = np.zeros((*(high - low + 2)[::-1], *file[name].shape[4:]), np.float32)
    for number, block in enumerate(first - low + 1):
        values[tuple(slice(start, start + count) for start, count in zip(block[::-1], cells[::-1]))] = np.nan_to_num(file.read(name, number))
    return Field(values, corner + (low - 1) * spacing, spacing)


def gradient_of(velocity, spacing):
    """{(i, j): derivative of component i along axis j}, to second order up to the faces; 0 along an axis with one cell."""
    size = velocity.shape[2::-1]
    slope = {}
    for i in range(3):
        for j in range(3):
            steep = np.gradient(velocity[..., i].astype(float), spacing, axis=2 - j, edge_order=min(2, size[j] - 1)) if size[j] > 1 else np.zeros(velocity.shape[:3])
            slope[i, j] = steep
    return slope


def vorticity_of(velocity, spacing):
    """Curl [z, y, x, 3] of a velocity [z, y, x, 3]."""
    d = gradient_of(velocity, spacing)
    return np.stack([d[2, 1] - d[1, 2], d[0, 2] - d[2, 0], d[1, 0] - d[0, 1]], axis=-1)


def q_of(velocity, spacing):
    """Half of what the squared rate of rotation exceeds that of strain by, of a velocity without divergence: positive in vortices."""
    d = gradient_of(velocity, spacing)
    return -0.5 * sum(d[i, j] * d[j, i] for i in range(3) for j in range(3))


def cut(field, axis, at):
    """A Field of one layer, linear between the two layers of cells around a plane."""
    a = "xyz".index(axis)
    cells = field.values.shape[2 - a]
    if not field.lower[a] <= at <= field.upper[a]:
        raise NotResults(f"the fluid lies between {axis} = {field.lower[a]:.6g} and {field.upper[a]:.6g} m, and the slice at {at:g} m")
    place = np.clip((at - field.lower[a]) / field.spacing - 0.5, 0, cells - 1)
    below = min(int(place), max(cells - 2, 0))
    share = place - below
    values = (1 - share) * np.take(field.values, [below], 2 - a) + share * np.take(field.values, [min(below + 1, cells - 1)], 2 - a)
    lower = field.lower.copy()
    lower[a] = at - 0.5 * field.spacing
    return Field(values, lower, field.spacing)
