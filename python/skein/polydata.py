"""Poly data files as Skein writes them (VTK XML, appended raw numbers), mapped into memory without VTK."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from .needs import Damaged, reading

TYPES = {"Float32": "f4", "Float64": "f8", "Int32": "i4", "Int64": "i8"}


def read(path):
    """{part: {name: array}} of a .vtp, parts PointData, CellData, Points, Lines, Polys; arrays are views of the mapped file."""
    with reading(path):
        return _read(path)


def _read(path):
    data = np.memmap(path, np.uint8, mode="r")
    mark = re.search(rb'<AppendedData encoding="raw">\s*_', bytes(data[:65536]))
    if mark is None:
        raise Damaged(f"{path}: is no poly data of Skein, or damaged")
    head = ElementTree.fromstring(bytes(data[:mark.start()]).decode() + "</VTKFile>")
    little = "<" if head.get("byte_order") == "LittleEndian" else ">"
    parts = {}
    for part in head.find("PolyData/Piece"):
        for array in part:
            at = mark.end() + int(array.get("offset"))
            count = int(data[at:at + 8].view(little + "u8")[0])
            numbers = data[at + 8:at + 8 + count].view(np.dtype(little + TYPES[array.get("type")]))
            width = int(array.get("NumberOfComponents"))
            parts.setdefault(part.tag, {})[array.get("Name")] = numbers.reshape(-1, width) if width > 1 else numbers
    return parts


def listed(pvd):
    """[(time s, path)] of a .pvd; none where there is none."""
    pvd = Path(pvd)
    if not pvd.exists():
        return []
    with reading(pvd):
        found = [(float(entry.get("timestep")), Path(entry.get("file"))) for entry in ElementTree.parse(pvd).iter("DataSet")]
        for _, path in found:
            if path.is_absolute() or ".." in path.parts:
                raise Damaged(f"{pvd}: names '{path}', which lies outside its directory")
    return [(time, pvd.parent / path) for time, path in found]


def polygons(parts):
    """Points [points, 3], [corners of each polygon] and the number of each polygon's wall."""
    lines = parts["Polys"]
    ends = lines["offsets"]
    return parts["Points"]["Points"], np.split(lines["connectivity"], ends[:-1])[:len(ends)], next(iter(parts["CellData"].values()))
