"""Centrelines of rods as lists of arrays: files of points, SWC trees, CSV, NumPy, HDF5 and BCC (docs/traced_files.md)."""

import csv
import re
import struct
from pathlib import Path

import numpy as np

from .needs import Damaged, NotResults, reading

FORMATS = (".csv", ".tsv", ".swc", ".npz", ".h5", ".bcc")
NAMES_OF_RODS = ("filament", "fibre", "fiber", "track", "trace", "rod", "curve", "contour", "hair", "yarn", "id")
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "\u00b5m": 1e-6, "\u03bcm": 1e-6, "nm": 1e-9}
SWC = ("id", "type", "x", "y", "z", "radius", "parent")


def ragged(curves, values=None, name="radii", components=()):
    """Points of all rods one after another, and the offsets at which they begin; or `values` of these points as one array."""
    if isinstance(curves, np.ndarray) and curves.ndim != 3:
        raise ValueError(f"an array of centrelines is [rods, points, 3], and has the shape {list(curves.shape)}")
    arrays = [np.asarray(curve, float) for curve in curves]
    if not arrays:
        raise ValueError("there are no centrelines")
    for rod, points in enumerate(arrays):
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"centreline {rod} has the shape {list(points.shape)}; it must be [points, 3]")
        if len(points) < 2:
            raise ValueError(f"centreline {rod} has fewer than two points")
    counts = np.array([len(points) for points in arrays])
    if values is None:
        return np.concatenate(arrays), np.concatenate([[0], np.cumsum(counts)])
    if np.isscalar(values) and not components:
        return np.full(counts.sum(), float(values))
    if len(values) != len(arrays):
        raise ValueError(f"{name} of {len(values)} rods beside {len(arrays)} centrelines")
    parts = []
    for rod, (count, own) in enumerate(zip(counts, values)):
        own = np.asarray(own, float)
        if own.shape == components:
            own = np.broadcast_to(own, (count, *components))
        if own.shape != (count, *components):
            raise ValueError(f"{name} of centreline {rod} have the shape {list(own.shape)}; it has {count} points")
        parts.append(own)
    return np.concatenate(parts)


class SwcTree:
    """A tree of points from an SWC file.

    points [points, 3], radii, types, ids [points]   in the order of the file, in its units
    parents [points]                                 rows of the parents; -1: a root
    sections                                         rows of the points of each section, from a root or branch point on: rods as Skein numbers them
    """

    def __init__(self, path):
        self.path = Path(path)
        rows = list(self._rows())
        if not rows:
            raise Damaged(f"{self.path}: it contains no points")
        table = np.array([row for _, row in rows])
        self._lines = [line for line, _ in rows]
        self.ids, self.types, self.points, self.radii = table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2:5], table[:, 5]
        self.parents = self._parents(table[:, 6].astype(np.int64))
        self.children = np.bincount(self.parents[self.parents >= 0], minlength=len(self.ids))
        self.sections = list(self._sections())

    def _rows(self):
        with reading(self.path), self.path.open(errors="replace") as text:
            for number, line in enumerate(text, 1):
                words = line.lstrip("\ufeff").replace(",", " ").split()
                if not words or words[0].startswith("#"):
                    continue
                if len(words) != len(SWC):
                    raise Damaged(f"{self.path}:{number}: expected 7 numbers, {' '.join(SWC)}, found {len(words)}")
                try:
                    row = [float(word) for word in words]
                except ValueError as error:
                    raise Damaged(f"{self.path}:{number}: {error}") from None
                if not all(np.isfinite(row)) or row[0] != int(row[0]) or row[6] != int(row[6]):
                    raise Damaged(f"{self.path}:{number}: numbers must be finite, and id and parent whole")
                yield number, row

    def _parents(self, named):
        row_of = {}
        for row, name in enumerate(self.ids):
            if row_of.setdefault(name, row) != row:
                raise Damaged(f"{self.path}:{self._lines[row]}: point {name}: has the id of line {self._lines[row_of[name]]}")
        parents = np.full(len(named), -1)
        for row, name in enumerate(named):
            if name < 0:
                continue
            if name not in row_of:
                raise Damaged(f"{self.path}:{self._lines[row]}: point {self.ids[row]}: its parent {name} is missing")
            parents[row] = row_of[name]
        seen = np.full(len(named), -1)
        for start in range(len(named)):
            row = start
            while row >= 0 and seen[row] < 0:
                seen[row] = start
                row = parents[row]
            if row >= 0 and seen[row] == start:
                raise Damaged(f"{self.path}:{self._lines[row]}: point {self.ids[row]}: its parents lead back to itself")
        return parents

    def _sections(self):
        only_child = np.full(len(self.ids), -1)
        only_child[self.parents[self.parents >= 0]] = np.flatnonzero(self.parents >= 0)
        for row, parent in enumerate(self.parents):
            if parent < 0 or (self.parents[parent] >= 0 and self.children[parent] == 1):
                continue
            rows = [parent, row]
            while self.children[rows[-1]] == 1:
                rows.append(only_child[rows[-1]])
            yield np.array(rows)

    def joints(self):
        """[(first, second, at)]: sections that meet at branch points, as lists of `[[joint]]`; `at` is [1, 0] where the first ends there, [0, 0] at a root."""
        ends, starts = {int(rows[-1]): number for number, rows in enumerate(self.sections)}, {}
        for number, rows in enumerate(self.sections):
            starts.setdefault(int(rows[0]), []).append(number)
        of_end, of_root = ([], []), ([], [])
        for point, children in starts.items():
            hub, others, into = (ends[point], children, of_end) if point in ends else (children[0], children[1:], of_root)
            into[0].extend([hub] * len(others))
            into[1].extend(others)
        return [(*pairs, at) for pairs, at in ((of_end, [1.0, 0.0]), (of_root, [0.0, 0.0])) if pairs[0]]

    def roots(self):
        """Sections that begin at a root."""
        return [number for number, rows in enumerate(self.sections) if self.parents[rows[0]] < 0]


def swc(path, group="sections", elements=8, unit=1e-6, joined=True, material=None, joint=None, **tables):
    """A scene of an SWC file: a rod for each section without branches, and joints at branch points.

        tree = skein.swc("vessels.swc", "vessels", elements=6, material={"density": 1100, "youngs_modulus": 1e5})
        tree["time.duration"] = 0.5

    unit: length of 1 in the file, m (most are in micrometres); joint: keys of the joints, by default stiff ones of one node (kind "fixed", stiffness "auto");
    tables: of the scene, as of skein.Scene. The scene names the file, which skein.run finds from anywhere.
    """
    from .scene import Scene
    path = Path(path)
    tree = SwcTree(path)
    scene = Scene(path.stem, **tables)
    radius = float(np.median(tree.radii)) * unit
    length = float(np.median([np.linalg.norm(np.diff(tree.points[rows], axis=0), axis=1).sum() for rows in tree.sections])) * unit
    scene.rods(group, material=material or {"density": 1000.0, "youngs_modulus": 1e6}, section={"radius": radius}, shape={"length": length, "elements": elements},
               placement={"kind": "file", "file": str(path.resolve()), "unit": unit})
    for first, second, at in tree.joints() if joined else []:
        keys = {"kind": "fixed", "pairs": "listed", "first": first, "second": second, "at": at, **(joint or {})}
        scene.joint(keys.pop("kind"), group, group, **keys)
    return scene


def read_centrelines(path, unit=1.0, id=None):
    """Centrelines of a file of points, as `write` and other programs make it: a list of arrays [points, 3], and radii [points] of each or None, m.

    unit: length of 1 in the file, m, where neither a column names its own, as "z[0.3 um]", nor an array "voxel" [3] does; id: the column of a table that names the rod of a row, if it is none of the usual names. Rods of tables have the order in
    which they appear; a coordinate that a table lacks is 0. Closed curves of a BCC file end with their first point. The program's own reader, which scenes use, checks more (docs/traced_files.md).
    """
    path = Path(path)
    if path.suffix == ".swc":
        tree = SwcTree(path)
        return [unit * tree.points[rows] for rows in tree.sections], [unit * tree.radii[rows] for rows in tree.sections]
    if path.suffix == ".bcc":
        return [unit * curve for curve in _curves_of_bcc(path)], None
    points, offsets, radii = _table_of(path, id, unit) if path.suffix in (".csv", ".tsv", ".txt") else _arrays_of(path, unit)
    return np.split(points, offsets[1:-1]), None if radii is None else np.split(radii, offsets[1:-1])


def _column(path, name, unit):
    """Name of a column in small letters, and the length of 1 in it, m."""
    found = re.fullmatch(r"(.*?)[ _]*\[ *([0-9.eE+-]*) *(\w+) *\]", name.strip())
    if not found or found[3] not in LENGTHS: return name.strip().lower(), unit
    try:
        size = float(found[2] or 1)
    except ValueError:
        size = 0
    if not 0 < size < float("inf"): raise Damaged(f"{path}: column '{name.strip()}': its unit is no length above 0, such as [um] or [0.3 um]")
    return found[1].lower(), size * LENGTHS[found[3]]


def _table_of(path, id, unit):
    """Points, m, offsets and radii of a table with a row per point."""
    with reading(path), path.open(newline="", encoding="utf-8-sig", errors="replace") as text:
        lines = [line for line in text if line.strip() and not line.startswith("#")]
        comma = next((mark for mark in "\t;," if lines and mark in lines[0]), ",")
        rows = list(csv.reader(lines, delimiter=comma, skipinitialspace=True))
    names, units = zip(*(_column(path, name, unit) for name in rows[0])) if rows else ((), ())
    wanted = [id.lower()] if id else [stem + end for stem in NAMES_OF_RODS for end in ("", "_id")]
    column = next((names.index(name) for name in wanted if name in names), None)
    places = [next((names.index(name) for name in (axis, f"position_{axis}") if name in names), None) for axis in "xyz"]
    if column is None or places.count(None) > 1:
        raise Damaged(f"{path}: a table of points names a column of rods ({', '.join(wanted[:3])}, ...) and two of x, y, z in its first line")
    size = next((names.index(name) for name in ("radius", "diameter") if name in names), None)
    by_rod = {}
    for number, row in enumerate(rows[1:], 2):
        try:
            point = [0.0 if place is None else units[place] * float(row[place]) for place in places]
            by_rod.setdefault(row[column].strip(), []).append([*point, 0.0 if size is None else units[size] * float(row[size]) / (2 if names[size] == "diameter" else 1)])
        except (ValueError, IndexError) as error:
            raise Damaged(f"{path}: row {number}: {error}") from None
    if not by_rod:
        raise Damaged(f"{path}: it contains no points")
    table = np.array([row for rod in by_rod.values() for row in rod])
    return table[:, :3], np.cumsum([0] + [len(rod) for rod in by_rod.values()]), None if size is None else table[:, 3]


def _arrays_of(path, unit):
    """The same of NumPy and HDF5."""
    with reading(path):
        if path.suffix in (".npy", ".npz"):
            found = np.load(path)
            arrays = {"points": found} if path.suffix == ".npy" else {name: found[name] for name in ("points", "offsets", "radii", "voxel") if name in found}
        elif path.suffix in (".h5", ".hdf5"):
            import h5py
            with h5py.File(path) as file:
                arrays = {name: file[name][:] for name in ("points", "offsets", "radii", "voxel") if name in file}
        else:
            raise NotResults(f"{path}: a file of centrelines is .csv, .tsv, .txt, .swc, .npy, .npz, .h5, .hdf5 or .bcc")
    points, radii = arrays.get("points"), arrays.get("radii")
    if points is None or points.ndim not in (2, 3) or points.shape[-1] != 3 or (points.ndim == 2 and "offsets" not in arrays):
        raise Damaged(f"{path}: it needs points [points, 3] with offsets, or points [rods, points, 3]")
    offsets = arrays.get("offsets", np.arange(0, len(points.reshape(-1, 3)) + 1, points.shape[1]) if points.ndim == 3 else None)
    if offsets[0] != 0 or offsets[-1] != len(points.reshape(-1, 3)) or (np.diff(offsets) < 2).any():
        raise Damaged(f"{path}: offsets begin with 0, end with the number of points, and leave two points or more to each rod")
    voxel = np.asarray(arrays.get("voxel", [unit] * 3), float)
    if voxel.shape != (3,) or not (voxel > 0).all():
        raise Damaged(f"{path}: voxel has three lengths above 0, m")
    return voxel * points.reshape(-1, 3).astype(float), offsets, None if radii is None else unit * radii.reshape(-1).astype(float)


# "BCC", bytes of integers and floats, type of curves, dimensions, axis that points up, curves, points, text. Little-endian.
BCC_HEADER = struct.Struct("<3sB2sBBQQ40s")


def _curves_of_bcc(path):
    """Curves of a binary curve collection; closed ones end with their first point."""
    with reading(path):
        data = path.read_bytes()
    if len(data) < BCC_HEADER.size:
        raise Damaged(f"{path}: is cut short: the header has {BCC_HEADER.size} bytes")
    sign, sizes, kind, dimensions, _, count, points, _ = BCC_HEADER.unpack_from(data)
    if (sign, sizes, kind[:1], dimensions) != (b"BCC", 0x44, b"C", 3):
        raise Damaged(f"{path}: is no BCC file of curves through points in 3 dimensions, with numbers of 4 bytes")
    at, found, held = BCC_HEADER.size, [], 0
    for number in range(count):
        own = abs(struct.unpack_from("<i", data, at)[0]) if at + 4 <= len(data) else None
        if own is None or at + 4 + 12 * own > len(data):
            raise Damaged(f"{path}: is cut short in curve {number}")
        curve = np.frombuffer(data, "<f4", 3 * own, at + 4).reshape(own, 3).astype(float)
        found.append(np.vstack([curve, curve[:1]]) if data[at + 3] & 0x80 else curve)
        at, held = at + 4 + 12 * own, held + own
    if at != len(data) or held != points:
        raise Damaged(f"{path}: its header counts {points} points in {count} curves, and it holds others")
    return found


def write(path, curves, radii=None, unit=1.0):
    """Writes centrelines, m, for placement.kind = "file": .csv or .tsv with a row per point, .swc, .npz, .h5 or .bcc; `unit`: length of 1 in the file, m.

    BCC has no radii, and single precision; curves that end with their first point are closed there.
    """
    path = Path(path)
    if path.suffix not in FORMATS:
        raise NotResults(f"{path}: a file of rods is one of {', '.join(FORMATS)}")
    points, offsets = ragged(curves)
    values = None if radii is None else ragged(curves, radii) / unit
    digits = 9 if all(np.asarray(curve).dtype == np.float32 for curve in curves) else 17
    points = points / unit
    part = path.with_name(f"part_{path.name}")
    if path.suffix == ".bcc":
        part.write_bytes(_bcc(np.split(points, offsets[1:-1])))
    elif path.suffix in (".npz", ".h5"):
        _write_arrays(part, {"points": points, "offsets": offsets} | ({} if values is None else {"radii": values}))
    else:
        if path.suffix == ".swc" and values is None:
            raise NotResults(f"{path}: SWC needs radii")
        part.write_text(_text(path.suffix, points, offsets, values, f"%.{digits}g"))
    part.replace(path)
    return path


def _bcc(curves):
    closed = [len(curve) > 2 and (curve[0] == curve[-1]).all() for curve in curves]
    own = [curve[:-1] if ends else curve for curve, ends in zip(curves, closed)]
    header = BCC_HEADER.pack(b"BCC", 0x44, b"C0", 3, 2, len(own), sum(map(len, own)), b"skein export")
    return header + b"".join(struct.pack("<i", -len(curve) if ends else len(curve)) + curve.astype("<f4").tobytes() for curve, ends in zip(own, closed))


def _write_arrays(path, arrays):
    if path.suffix == ".npz":
        np.savez(path, **arrays)
        return
    import h5py
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file[name] = values


def _text(suffix, points, offsets, radii, number):
    rod = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    if suffix == ".swc":
        parent = np.arange(len(points))
        parent[offsets[:-1]] = -1
        rows = zip(range(1, len(points) + 1), points, radii, parent)
        return f"# {' '.join(SWC)}\n" + "".join(f"{row} 0 {' '.join(number % x for x in p)} {number % r} {above}\n" for row, p, r, above in rows)
    comma = "," if suffix == ".csv" else "\t"
    names = ["rod", "x", "y", "z"] + ([] if radii is None else ["radius"])
    table = points if radii is None else np.column_stack([points, radii])
    return comma.join(names) + "\n" + "".join(f"{i}{comma}{comma.join(number % x for x in row)}\n" for i, row in zip(rod, table))
