"""One cilium of every kind in farm_111797.toml, and how often the farm has each.

Cilia do not touch, and their magnetisation repeats every 20 spacings along x and every 30 along y, so the farm holds 600 kinds: those of a
lattice of 20 x 30 with its first corner. What is averaged over them with the number of each is the figure of the whole farm.
"""

import re
import sys
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "apps/cilia_carpet"))
import beat  # noqa: E402  (after the path to it)

FARM = ROOT / "apps/cilia_carpet/farm_111797.toml"
KINDS = (20, 30)      # wavelengths over spacing
PERIOD = 72.0         # s
FRAMES = 36           # per turn
BOND_1 = 5781.25      # A/m, strength at bond 1
REFERENCE = "clamped_100"

LADDER = {"clamped": [5, 8, 10, 15, 20, 25, 40, 50, 100], "clamped_frozen": [5, 10, 15, 20, 25, 40, 50, 100]}
BONDS = [0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.286, 4.0]


def scene(turns=2, period=PERIOD, **values):
    """The farm's scene with one cilium of each kind and some values changed; `KEY = VALUE` has to stand on a line of its own."""
    values = {"duration": turns * period, "divide": period / FRAMES, "tips": period / FRAMES, "series": turns * period,
              "checkpoint": turns * period, "period": period, **values}
    text = FARM.read_text()
    text, found = re.subn(r'^kind = "mask".*\nfile = .*$', f'kind = "lattice"\ncounts = {list(KINDS)}', text, flags=re.M)
    added = [f"velocity = {values.pop('velocity')}"] if "velocity" in values else []
    for key, value in values.items():
        shown = f'"{value}"' if isinstance(value, str) else value
        text, n = re.subn(rf"^{key} = [^#\n]*", f"{key} = {shown} ", text, flags=re.M)
        found *= n
    if found != 1:
        raise SystemExit(f"{FARM.name} does not have each of {', '.join(values)} and the mask exactly once")
    if values.get("pattern") == "wave_x":
        text = re.sub(r"^wavelength_y = .*\n", "", text, flags=re.M)
    text = re.sub(r"^(length = .*)$", "\n".join([r"\1", *added]), text, flags=re.M)
    return text.replace("[output]", '[output]\nprecision = "double"')


def ladder():
    """Scenes by name: elements and clamp, two turns as the farm is run."""
    return {f"{clamp}_{n}": scene(start=clamp, elements=n) for clamp, ns in LADDER.items() for n in ns}


def variations():
    """Scenes by name: what phases and repetition may depend on; three turns of ten elements unless said."""
    def ten(**values):
        return scene(**{"turns": 3, "elements": 10, **values})

    cases = {"farm": ten(), "n_25": ten(elements=25), "n_50": ten(elements=50), "n_25_frozen": ten(elements=25, start="clamped_frozen"),
             "half_step": ten(dt=1 / 164)}
    cases |= {f"damping_{rate:g}": ten(rate=rate) for rate in (0.125, 0.25, 1.0, 2.0)}
    cases |= {f"field_y_{share:g}": ten(constant=[0.0, share * 0.08, 0.0]) for share in (0.0, 0.001, 0.05)}
    cases |= {f"turn_{period:g}_s": ten(period=period) for period in (36.0, 144.0, 576.0)}
    cases |= {f"thrown_to_{name}": ten(velocity=velocity) for name, velocity in
              {"+x": [0.5, 0.0, 0.0], "-x": [-0.5, 0.0, 0.0], "+y": [0.0, 0.5, 0.0], "-y": [0.0, -0.5, 0.0]}.items()}
    cases["field_rises_for_36_s"] = ten(ramp=36.0)
    cases |= {f"{pattern}_bond_{bond:g}": ten(pattern=pattern, strength=bond * BOND_1)
              for pattern in ("wave_xy", "wave_x") for bond in BONDS}
    return cases


def weights(origin):
    """How many cilia of the farm are of each kind, for cilia of the lattice."""
    rows = [line for line in (FARM.parent / "wordmark.pbm").read_text().split("\n") if not line.startswith("#")]
    width, height = map(int, rows[1].split())
    ink = np.array(list("".join(rows[2:]).replace(" ", ""))).reshape(height, width)[::-1] == "1"  # the last row is y = 0
    y, x = np.nonzero(ink)
    count = np.zeros(KINDS, int)
    np.add.at(count, ((x - x.min()) % KINDS[0], (y - y.min()) % KINDS[1]), 1)  # phases are measured from the first corner
    return count[tuple(kinds(origin).T)]


def kinds(origin):
    return np.rint((origin[:, :2] - origin[:, :2].min(axis=0)) / beat.spacing_of(origin)).astype(int)


def read(directory):
    """Time [frames], tips from where they were planted [frames, cilia, 3] in L, and origin [cilia, 3] in m."""
    time, tips = [], []
    for path in beat.segments(directory, "tips"):
        with h5py.File(path) as file:
            group = next(iter(file["groups"].values()))
            origin = group["origin"][:]
            time.append(file["time"][:])
            tips.append(group["position"][:])
    time, tips = np.concatenate(time), np.concatenate(tips) - origin
    return time, tips / np.linalg.norm(tips[0, 0]), origin
