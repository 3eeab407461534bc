"""Arrays of frames that lie across the segments of a run: opened at once, read as far as they are asked for."""

import json
from collections import OrderedDict
from pathlib import Path

import numpy as np

from .needs import NotResults, reading
from .own_file import OwnFile

MOST_OPEN = 64  # files at a time


class Segments:
    """Files `<kind>_<first step>.h5` of a run: steps [frames], times [frames] s, and where each frame lies."""

    def __init__(self, directory, kind):
        self.paths = sorted(Path(directory).glob(f"{kind}_*.h5"))
        self._open = OrderedDict()
        step, time, first = [], [], [0]
        for number in range(len(self.paths)):
            file = self.file(number)
            step.append(file.read("step", slice(None)))
            time.append(file.read("time", slice(None)))
            first.append(first[-1] + len(step[-1]))
        self.step = np.concatenate(step) if step else np.zeros(0, np.int64)
        self.time = np.concatenate(time) if time else np.zeros(0)
        self.first = np.array(first)  # frame with which each segment begins, and behind the last

    def __len__(self):
        return len(self.step)

    def file(self, number):
        if number not in self._open:
            while len(self._open) >= MOST_OPEN:
                self._open.popitem(last=False)[1].close()
            self._open[number] = OwnFile(self.paths[number])
        self._open.move_to_end(number)
        return self._open[number]

    def close(self):
        for file in self._open.values():
            file.close()
        self._open.clear()

    def groups(self):
        """Names of groups that have frames."""
        return self.file(0).names("groups") if self.paths else []

    def constant(self, group, name):
        """What does not change from frame to frame, read from the first segment."""
        return self.file(0).read(f"groups/{group}/{name}")

    def has(self, group, name):
        return bool(self.paths) and f"groups/{group}/{name}" in self.file(0)

    def array(self, group, name):
        return FrameArray(self, f"groups/{group}/{name}")

    def nearest(self, time):
        """Number of the frame nearest to a time, s."""
        if not len(self):
            raise NotResults("the run has no frames")
        return int(np.argmin(np.abs(self.time - time)))


class FrameArray:
    """[frames, ...] of one dataset across segments. Indexing reads what is asked for and no more: `array[-1]`, `array[::10, 5]`,
    `array[3:5, :, -1, 2]`; np.asarray(array) reads all of it."""

    def __init__(self, segments, path):
        self._segments, self._path = segments, path
        one = segments.file(0)[path]
        self.shape = (len(segments), *one.shape[1:])
        self.dtype = one.dtype

    ndim = property(lambda self: len(self.shape))
    size = property(lambda self: int(np.prod(self.shape)))
    nbytes = property(lambda self: self.size * self.dtype.itemsize)

    def __len__(self):
        return self.shape[0]

    def __repr__(self):
        return f"<FrameArray {self._path} {self.shape} {self.dtype}, not read>"

    def __array__(self, dtype=None, copy=None):
        everything = self[:]
        return everything if dtype is None else everything.astype(dtype, copy=False)

    def __iter__(self):
        return (self[frame] for frame in range(len(self)))

    def __getitem__(self, key):
        key = key if isinstance(key, tuple) else (key,)
        if key and key[0] is Ellipsis:
            key = (slice(None), *key) if len(key) <= self.ndim else key[1:]
        first, rest = (key[0], key[1:]) if key else (slice(None), ())
        if isinstance(first, (int, np.integer)):
            return self._one(int(first), rest)
        frames = np.arange(len(self))[first]
        starts = self._segments.first
        out, k = None, 0
        while k < len(frames):  # runs of frames of one segment, evenly apart, are read in one go
            number = int(np.searchsorted(starts, frames[k], side="right")) - 1
            last = k + 1
            apart = int(frames[last] - frames[k]) if last < len(frames) else 1
            while last < len(frames) and starts[number] <= frames[last] < starts[number + 1] and frames[last] - frames[last - 1] == apart > 0:
                last += 1
            apart = max(apart, 1)
            begin = int(frames[k] - starts[number])
            part = (slice(begin, begin + (last - k - 1) * apart + 1, apart), *rest)
            file = self._segments.file(number)
            data = file[self._path]
            if last - k == len(frames):
                return file.read(self._path, part)
            if out is None:
                out = np.empty((len(frames), *file.read(self._path, (slice(begin, begin + 1), *rest)).shape[1:]), self.dtype)
            if _plain(rest):
                with reading(file.path, (OSError, RuntimeError)):
                    data.read_direct(out, part, np.s_[k:last])
            else:
                out[k:last] = file.read(self._path, part)
            k = last
        if out is None:
            out = np.empty((0, *self._segments.file(0).read(self._path, (slice(0, 0), *rest)).shape[1:]), self.dtype)
        return out

    def _one(self, frame, rest):
        frame += len(self) if frame < 0 else 0
        if not 0 <= frame < len(self):
            raise IndexError(f"frame {frame} of {len(self)}")
        number = int(np.searchsorted(self._segments.first, frame, side="right")) - 1
        return self._segments.file(number).read(self._path, (frame - int(self._segments.first[number]), *rest))


def _plain(rest):
    """Selections that HDF5 reads straight into their place."""
    return all(isinstance(k, slice) for k in rest)


class Times:
    """Frames in which there are no rods."""

    paths = ()

    def __init__(self, step, time):
        self.step, self.time = step, time

    def __len__(self):
        return len(self.step)

    def has(self, group, name):
        return False

    nearest = Segments.nearest


class Snapshot:
    """The newest checkpoint as the only frame of a run that has written none: nodes half a step before its time, no directors; rods alone."""

    def __init__(self, path, physics):
        self.paths = [path]
        with OwnFile(path) as file, reading(path):
            settings = json.loads(file.attrs["settings"])
            self.title = settings.get("title", "")
            self.step, self.time = np.array([file.attrs["step"]]), np.array([file.attrs["step"] * file.attrs["dt"]])
            self._arrays = {}
            for rods in physics.get("rods", []):
                nodes = file[f"groups/{rods['name']}/state"][..., :3]
                section, count = rods["section"], nodes.shape[1]
                profile = np.asarray(section["profile"] or np.linspace(1, section["taper"], count - 1))
                at_nodes = np.concatenate([profile[:1], 0.5 * (profile[1:] + profile[:-1]), profile[-1:]])
                radius = np.sqrt(section["radius"] * section["radius_2"]) if section["kind"] == "elliptic" else section["radius"]
                self._arrays[rods["name"]] = {"position": nodes[None], "origin": nodes[:, 0], "radius": radius * at_nodes}

    def __len__(self):
        return 1

    def groups(self):
        return list(self._arrays)

    def has(self, group, name):
        return name in self._arrays.get(group, ())

    def constant(self, group, name):
        return self._arrays[group][name]

    array = constant

    def nearest(self, time):
        return 0
