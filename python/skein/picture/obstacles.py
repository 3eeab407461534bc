"""Obstacles of a fluid in pictures."""

import json
from pathlib import Path

import numpy as np

from . import shapes
from .colours import BODY
from ..needs import NotResults, reading
from ..own_file import OwnFile


def turned(vector, angular_velocity, time):
    """A vector [3] turned at a steady rate [3], rad/s."""
    rate = np.linalg.norm(angular_velocity)
    if rate == 0:
        return vector
    about, angle = angular_velocity / rate, rate * time
    return np.cos(angle) * vector + np.sin(angle) * np.cross(about, vector) + (1 - np.cos(angle)) * (about @ vector) * about


def axes(obstacle, time):
    """Axes of its shape, rows [3, 3]."""
    d3 = shapes.unit(np.asarray(obstacle.get("axis", (0, 0, 1)), float))
    normal = obstacle.get("normal")
    if normal is None or np.isnan(np.asarray(normal, float)).any():
        normal = (0, 1, 0) if abs(d3[0]) > 1 - 1e-9 else (1, 0, 0)
    d1 = np.asarray(normal, float)
    d1 = shapes.unit(d1 - (d1 @ d3) * d3)
    spin = np.asarray(obstacle.get("angular_velocity", (0, 0, 0)), float)
    return np.array([turned(d, spin, time) for d in (d1, np.cross(d3, d1), d3)])


def place(obstacle, time):
    swing = np.sin(2 * np.pi * obstacle["frequency"] * time) * np.asarray(obstacle["amplitude"], float)
    return np.asarray(obstacle["centre"], float) + time * np.asarray(obstacle["velocity"], float) + swing


def ellipsoid(half_axes, sides=48):
    """Points of its surface and their normals, [rings, sides, 3], along its axes."""
    latitude, longitude = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1), 2 * np.pi * np.arange(sides) / sides, indexing="ij")
    ball = np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], axis=-1)
    return ball * half_axes, shapes.unit(ball / half_axes)


def read_triangles(path):
    """Corners of the triangles of an STL or OBJ file, [triangles, 3, 3]."""
    data = Path(path).read_bytes()
    if Path(path).suffix.lower() == ".obj":
        lines = [line.split() for line in data.decode(errors="replace").splitlines()]
        points = np.array([[float(x) for x in words[1:4]] for words in lines if words[:1] == ["v"]])
        corners = []
        for words in lines:
            if words[:1] != ["f"]:
                continue
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            numbers = [n - 1 if n > 0 else n for n in numbers]  # from the end, where all points stand before the faces
            corners += [(numbers[0], a, b) for a, b in zip(numbers[1:], numbers[2:])]
        return points[np.array(corners)]
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        records = np.frombuffer(data, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]), count, 84)
        return records["corners"].astype(float)
    return np.array([[float(x) for x in line.split()[1:4]] for line in data.decode(errors="replace").splitlines() if line.split()[:1] == ["vertex"]]).reshape(-1, 3, 3)


def scene_folder(results):
    """The folder of the scene, which checkpoints name; else the present one."""
    for step in results.checkpoints[-1:]:
        with OwnFile(results.directory / f"checkpoint_{step:012d}.h5") as file, reading(file.path):
            return Path(json.loads(file.attrs["settings"]).get("file", "")).parent
    return Path()


def mesh(obstacle, results):
    """Triangles of its file, m, with their normals, [triangles, 3, 3] each."""
    path = scene_folder(results) / obstacle["file"]
    try:
        corners = obstacle["unit"] * read_triangles(path)
    except (OSError, ValueError, IndexError):
        raise NotResults(f"the obstacle '{obstacle['name']}' has the shape of '{obstacle['file']}', and {path} cannot be read: put the file there") from None
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return corners, np.repeat(normal[:, None] / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None, None], 3, axis=1)


def surface(obstacle, time, results):
    """A capsule, box, ellipsoid or mesh as shapes.Mesh."""
    at, rows = place(obstacle, time), axes(obstacle, time)
    if obstacle["kind"] == "capsule":
        half = 0.5 * obstacle["length"] * rows[2]
        return shapes.capsules((at - half)[None], (at + half)[None], np.array([obstacle["radius"]]), BODY)
    if obstacle["kind"] == "box":
        return shapes.boxes(at[None], rows[None], 0.5 * np.asarray(obstacle["sides"], float)[None], BODY)
    if obstacle["kind"] == "ellipsoid":
        points, normals = ellipsoid(np.asarray(obstacle["half_axes"], float))
        faces = shapes.ring_faces(1, *points.shape[:2])
    else:
        points, normals = mesh(obstacle, results)
        faces = np.arange(3 * len(points)).reshape(-1, 3)[:, [0, 1, 2, 2]]
    points, normals = (values.reshape(-1, 3) @ rows for values in (points, normals))
    return shapes.Mesh(at + points, normals, faces, np.tile(BODY, (len(points), 1)))
