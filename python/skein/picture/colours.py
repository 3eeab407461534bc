"""Colours of rods by what they are or do."""

from dataclasses import dataclass

import numpy as np

from ..needs import NotResults

# Of groups and of single rods: apart from each other in hue and lightness, soft in light and shade.
GROUPS = np.array([[0.80, 0.62, 0.36], [0.36, 0.55, 0.72], [0.72, 0.40, 0.34], [0.45, 0.62, 0.42], [0.60, 0.48, 0.70], [0.35, 0.65, 0.65], [0.78, 0.55, 0.62], [0.55, 0.55, 0.50]])
BODY = np.array([0.62, 0.64, 0.68])


@dataclass
class Scale:
    """What a colour bar shows."""
    words: str
    low: float
    high: float
    colours: object     # of matplotlib
    factor: float = 1   # from SI to the unit in the words
    ticks: list = None  # [(value, words)], where the values' own words do not do

    def paint(self, values):
        return self.colours(self.share(values))[..., :3]

    def share(self, values):
        """0 at the low end, 1 at the high one."""
        return (np.asarray(values, float) - self.low) / max(self.high - self.low, 1e-300)


def bright(name):
    """A map of matplotlib without its darkest end, and paler: what lies in the shade stays readable."""
    import matplotlib
    from matplotlib.colors import ListedColormap
    found = matplotlib.colormaps[name]
    dark_first = sum(found(0.0)[:3]) < sum(found(1.0)[:3])  # maps of two hues are as dark at both ends, and keep their middle
    part = np.linspace(0.12 if dark_first else 0, 1, 256)
    return ListedColormap(0.1 + 0.88 * found(part)[:, :3], name=f"bright_{name}")


def _speed(group, frame):
    return np.linalg.norm(group.field(frame, "velocity"), axis=-1)


def _curvature(group, frame):
    if "curvature" in group._results.fields:
        return group.field(frame, "curvature")
    return curvature_of(group.position[frame].astype(float), group.closed)


def curvature_of(nodes, closed=False):
    """[rods, nodes] 1/m: turn of the edges at a node over the mean length of both; 0 at ends."""
    edge = np.diff(nodes, axis=1)
    length = np.linalg.norm(edge, axis=-1)
    t = edge / length[..., None]
    turn = 2 * np.arcsin(np.clip(0.5 * np.linalg.norm(np.diff(t, axis=1), axis=-1), 0, 1))
    inner = turn / (0.5 * (length[:, 1:] + length[:, :-1]))
    if not closed:
        return np.pad(inner, ((0, 0), (1, 1)))
    joint = 2 * np.arcsin(0.5 * np.linalg.norm(t[:, 0] - t[:, -1], axis=-1)) / (0.5 * (length[:, 0] + length[:, -1]))
    return np.concatenate([joint[:, None], inner, joint[:, None]], axis=1)


def _strain(group, frame):
    """From the poly data, or the lengths of the elements: a relaxation that asks for no frames has no poly data of its last one."""
    if group._results.has_field(frame, "strain") or group.rest_lengths is None:
        return group.field(frame, "strain")
    return strain_of(group.position[frame].astype(float), group.rest_lengths)


def strain_of(nodes, lengths):
    """[rods, nodes]: of elements of these lengths at rest, means of those that meet at a node."""
    strain = np.linalg.norm(np.diff(nodes, axis=1), axis=-1) / lengths - 1
    return np.concatenate([strain[:, :1], 0.5 * (strain[:, 1:] + strain[:, :-1]), strain[:, -1:]], axis=1)


def _bending(group, frame):
    return np.broadcast_to(group.radius, (group.count, group.elements + 1)) * _curvature(group, frame)


# name: (values [rods, nodes] of a group in a frame, words, unit, colours, whether they have a sign)
QUANTITIES = {
    "strain": (_strain, "axial strain", "", "RdBu_r", True),
    "curvature": (_curvature, "curvature", "1/m", "viridis", False),
    "bending": (_bending, "strain by bending", "", "YlOrBr", False),
    "speed": (_speed, "speed", "m/s", "cividis", False),
    "energy": (lambda group, frame: group.field(frame, "energy"), "elastic energy", "J/m", "magma", False),
    "contact_force": (lambda group, frame: np.linalg.norm(group.field(frame, "contact_force"), axis=-1), "contact force", "N", "YlOrRd", False),
    "height": (lambda group, frame: group.position[frame][..., 2], "height", "m", "viridis", True),
    "radius": (lambda group, frame: np.broadcast_to(group.radius, (group.count, group.elements + 1)), "radius", "m", "viridis", True),
}
CHOICES = ("auto", *QUANTITIES, "phase", "rod", "group", "magnetisation")

PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M"}


def _power(power):
    return "10" + str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def named(words, unit, most):
    """Words of an axis, and the factor to the unit that suits numbers up to `most`."""
    if not unit:
        if most > 1e-4:
            return (f"{words} [-]", 1) if most >= 0.5 else (f"{words} [%]", 100)
        power = int(3 * np.floor(np.log10(max(most, 1e-30)) / 3))
        return f"{words} [{_power(power)}]", 10.0**-power
    power = int(3 * np.floor(np.log10(max(most, 1e-30)) / 3))
    if unit in ("m", "N", "J", "m/s", "J/m", "Pa") and power in PREFIXES:
        return f"{words} [{PREFIXES[power]}{unit}]", 10.0**-power
    if 0.01 <= most < 1e4:
        return f"{words} [{unit}]", 1
    return f"{words} [{_power(power)} {unit}]", 10.0**-power


def circle():
    """Hues of one lightness and chroma (OKLCH, Ottosson 2020), so that no phase stands out and light and shade stay readable."""
    from matplotlib.colors import ListedColormap
    hue = 2 * np.pi * (np.arange(512) / 512 + 0.08)
    lightness, chroma = 0.70, 0.135
    lab = np.stack([np.full_like(hue, lightness), chroma * np.cos(hue), chroma * np.sin(hue)])
    lms = (np.array([[1, 0.3963377774, 0.2158037573], [1, -0.1055613458, -0.0638541728], [1, -0.0894841775, -1.2914855480]]) @ lab) ** 3
    linear = np.array([[4.0767416621, -3.3077115913, 0.2309699292], [-1.2684380046, 2.6097574011, -0.3413193965],
                       [-0.0041960863, -0.7034186147, 1.7076147010]]) @ lms
    linear = np.clip(linear, 0, 1)
    return ListedColormap(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).T, name="circle")


def phases(time, tips):
    """Phase of each rod's beat at time 0, 0 to 1 of a period, and the period, s, from tips [frames, rods, 3] at evenly spaced times: of the
    strongest line in the spectrum of all tips, along the direction in which they move most. 0: furthest along it."""
    moved = tips - tips.mean(axis=0)
    covariance = np.einsum("tri,trj->ij", moved, moved)
    along = np.linalg.eigh(covariance)[1][:, -1]
    along *= np.sign(along[np.argmax(np.abs(along))])
    signal = moved @ along * np.hanning(len(time))[:, None]
    power = np.sum(np.abs(np.fft.rfft(signal, axis=0))**2, axis=1)
    line = 1 + int(np.argmax(power[1:]))
    step = (time[-1] - time[0]) / (len(time) - 1)
    around = power[max(1, line - 1):line + 2]
    period = len(time) * step / (np.sum(np.arange(max(1, line - 1), line + 2)[:len(around)] * around) / around.sum())
    coefficient = np.einsum("tr,t->r", signal, np.exp(-2j * np.pi * time / period))
    return (np.angle(coefficient) / (2 * np.pi)) % 1, period


class Paint:
    """Colours [rods, nodes, 3] of groups frame by frame, by one quantity on one scale over the frames that are shown."""

    def __init__(self, results, by, frames, limits=None):
        self.results, self.by = results, by
        self.scale = None
        if not isinstance(by, str):
            self._given = np.asarray(by, float)  # [rods, 3] of the only group
            return
        if by == "auto":
            self.by = by = self._fitting()
        if by in QUANTITIES:
            if not results.rods: raise NotResults(f"colour '{by}' is of rods, and there are bodies alone; give rod or group")
            self._measure(frames, limits)
        elif by == "phase":
            self._beat()
        elif by not in ("rod", "group", "magnetisation"):
            raise NotResults(f"no colour '{by}'; there are {', '.join(CHOICES)}")

    def _fitting(self):
        rods = self.results.rods
        return "group" if len(rods) != 1 else "curvature" if rods[0].elements > 1 else "rod"

    def _measure(self, frames, limits):
        values, words, unit, colours, signed = QUANTITIES[self.by]
        self._values = values
        if limits is None:
            shown = np.concatenate([np.asarray(values(group, k), float).ravel() for k in frames for group in self.results.rods])
            shown = shown[np.isfinite(shown)]
            low, high = (np.percentile(shown, (0.5, 99.5)) if len(shown) else (0, 1))
            if colours == "RdBu_r":
                high = max(abs(low), abs(high))
                low = -high
            elif not signed:
                low = 0.0
            if high <= low:
                high = low + 1
        else:
            low, high = limits
        words, factor = named(words, unit, max(abs(low), abs(high)))
        self.scale = Scale(words, low, high, bright(colours), factor)

    def _beat(self):
        self._phase = {}
        for group in self.results.rods:
            tips = self.results.tips
            if tips.has(group.name, "position") and len(tips) >= 8:
                time, moved = tips.time, np.asarray(group.tips, float)
            else:
                time, moved = self.results.frames.time, group.position[:, :, -1].astype(float)
            late = time >= time[0] + 0.5 * (time[-1] - time[0])  # what has settled
            if late.sum() < 8:
                raise NotResults(f"{self.results.directory}: too few frames for phases of a beat")
            self._end = time[-1]
            self._phase[group.name] = phases(time[late] - time[-1], moved[late])
        self.scale = Scale("phase of the beat (0°: tip furthest out)", 0, 1, circle(), 360, [(k / 4, f"{90 * k}°") for k in range(5)])

    def _values_of(self, group, frame):
        if self.by == "phase":
            start, period = self._phase[group.name]
            return np.broadcast_to(((start + (self.results.frames.time[frame] - self._end) / period) % 1)[:, None], (group.count, group.elements + 1))
        return np.nan_to_num(self._values(group, frame))

    def share(self, group, frame):
        """[rods, nodes] on the scale, 0 to 1 or beyond."""
        return self.scale.share(self._values_of(group, frame))

    def of_group(self, group):
        return GROUPS[[g.name for g in self.results.rods].index(group.name) % len(GROUPS)]

    def of(self, group, frame):
        """[rods, nodes, 3]."""
        if self.scale is not None:
            return self.scale.paint(self._values_of(group, frame))
        if not isinstance(self.by, str):
            one = self._given
        elif self.by == "magnetisation":
            one = 0.5 + 0.35 * group.magnetisation
        elif self.by == "rod":
            one = GROUPS[np.arange(group.count) % len(GROUPS)]
        else:
            one = np.tile(self.of_group(group), (group.count, 1))
        return np.broadcast_to(one[:, None], (group.count, group.elements + 1, 3))
