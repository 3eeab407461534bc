"""Surfaces of rods, bodies and walls, as meshes of quadrilaterals."""

from dataclasses import dataclass

import numpy as np

CAP_RINGS = 6


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)


@dataclass
class Mesh:
    points: np.ndarray    # [points, 3] m
    normals: np.ndarray   # [points, 3], outwards
    faces: np.ndarray     # [faces, 4] points
    colours: np.ndarray   # [points, 3], 0 to 1

    @staticmethod
    def joined(meshes):
        if not meshes:
            return Mesh(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4), int), np.zeros((0, 3)))
        first = np.cumsum([0] + [len(mesh.points) for mesh in meshes])
        return Mesh(*(np.concatenate([getattr(mesh, name) for mesh in meshes]) for name in ("points", "normals")),
                    np.concatenate([mesh.faces + start for mesh, start in zip(meshes, first)]),
                    np.concatenate([mesh.colours for mesh in meshes]))


def refined(values, times, closed=False):
    """Values [rods, nodes, ...] with `times` points per element: Catmull-Rom through the nodes, round the joint of rings."""
    if times == 1:
        return values
    before, after = (values[:, -2:-1], values[:, 1:2]) if closed else (2 * values[:, :1] - values[:, 1:2], 2 * values[:, -1:] - values[:, -2:-1])
    p = np.concatenate([before, values, after], axis=1)
    s = np.linspace(0, 1, times, endpoint=False).reshape(1, 1, -1, *[1] * (values.ndim - 2))
    a, b, c, d = (part[:, :, None] for part in (p[:, :-3], p[:, 1:-2], p[:, 2:-1], p[:, 3:]))
    curve = b + 0.5 * s * (c - a) + s**2 * (a - 2.5 * b + 2 * c - 0.5 * d) + s**3 * (-0.5 * a + 1.5 * b - 1.5 * c + 0.5 * d)
    return np.concatenate([curve.reshape(len(values), -1, *values.shape[2:]), values[:, -1:]], axis=1)


def linear(values, times):
    """The same, linear between nodes: what must not overshoot."""
    if times == 1:
        return values
    s = (np.arange(times) / times).reshape(1, 1, -1, *[1] * (values.ndim - 2))
    between = values[:, :-1, None] * (1 - s) + values[:, 1:, None] * s
    return np.concatenate([between.reshape(len(values), -1, *values.shape[2:]), values[:, -1:]], axis=1)


def carried_normals(tangent):
    """Normals [rods, nodes, 3] carried along the rods without twist."""
    first = np.empty_like(tangent)
    least = np.eye(3)[np.argmin(np.abs(tangent[:, 0]), axis=-1)]
    first[:, 0] = unit(np.cross(least, tangent[:, 0]))
    for k in range(1, tangent.shape[1]):
        t = tangent[:, k]
        first[:, k] = unit(first[:, k - 1] - np.sum(first[:, k - 1] * t, axis=-1, keepdims=True) * t)
    return first


def tubes(nodes, radius, colours, sides, normals=None, flat=None, caps=CAP_RINGS):
    """Rods of nodes [rods, nodes, 3], radius and colours [rods, nodes(, 3)]. `normals`: d1 at nodes, from which angles count; `flat`: the semi-axis along
    d2 over that along d1, a number or [rods or 1, nodes]; caps: rings of the half spheres on both ends, 0 for none."""
    tangent = unit(np.gradient(nodes, axis=1))
    first = carried_normals(tangent) if normals is None else unit(normals - np.sum(normals * tangent, axis=-1, keepdims=True) * tangent)
    second = np.cross(tangent, first)
    angle = 2 * np.pi * np.arange(sides) / sides
    flat = np.broadcast_to(1.0 if flat is None else flat, nodes.shape[:2])[..., None, None]
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    ring = first[:, :, None] * cos + flat * second[:, :, None] * sin
    out = unit(flat * first[:, :, None] * cos + second[:, :, None] * sin)
    r = radius[..., None, None]
    points, normal, paint = [nodes[:, :, None] + r * ring], [out], [colours]
    if caps:
        slope = 0.5 * np.pi * (np.arange(caps) + 1) / caps
        c, s = np.cos(slope)[None, :, None, None], np.sin(slope)[None, :, None, None]
        for end, sign in ((-1, 1), (0, -1)):
            along = sign * tangent[:, end, None, None]
            cap = nodes[:, end, None, None] + r[:, end, None] * (c * ring[:, end, None] + np.minimum(flat[:, end, None], 1) * s * along), unit(c * out[:, end, None] + s * along)
            shown = np.repeat(colours[:, end, None], caps, axis=1)
            for parts, part in zip((points, normal, paint), (*cap, shown)):
                parts.append(part) if end else parts.insert(0, part[:, ::-1])
    points, normal, paint = (np.concatenate(parts, axis=1) for parts in (points, normal, paint))
    return Mesh(points.reshape(-1, 3), normal.reshape(-1, 3), ring_faces(*points.shape[:3]), np.repeat(paint, sides, axis=1).reshape(-1, 3))


def bars(nodes, half, half_2, colours, normals, times=4, caps=True):
    """Rods of rectangular sections with half sides along d1 and d2 [rods, nodes] and sharp edges; `normals`: d1 at nodes; `times`: faces across a side."""
    tangent = unit(np.gradient(nodes, axis=1))
    first = unit(normals - np.sum(normals * tangent, axis=-1, keepdims=True) * tangent)
    second = np.cross(tangent, first)
    meshes = []
    along = np.linspace(-1, 1, times + 1)[:, None]
    for out, side, far, wide in ((first, second, half, half_2), (second, -first, half_2, half), (-first, -second, half, half_2), (-second, first, half_2, half)):
        far, wide = (np.broadcast_to(value, nodes.shape[:2])[..., None, None] for value in (far, wide))
        points = nodes[:, :, None] + far * out[:, :, None] + along * wide * side[:, :, None]
        number = np.arange(points[..., 0].size).reshape(points.shape[:-1])
        faces = np.stack([number[:, :-1, :-1], number[:, :-1, 1:], number[:, 1:, 1:], number[:, 1:, :-1]], axis=-1).reshape(-1, 4)
        meshes.append(Mesh(points.reshape(-1, 3), np.broadcast_to(out[:, :, None], points.shape).reshape(-1, 3), faces, np.repeat(colours, times + 1, axis=1).reshape(-1, 3)))
    for end, sign in ((0, -1), (-1, 1)) if caps else ():
        reach, reach_2 = ((np.broadcast_to(value, nodes.shape[:2])[:, end, None] * axis[:, end])[:, None] for value, axis in ((half, first), (half_2, second)))
        points = nodes[:, end, None] + np.concatenate([i * reach + j * reach_2 for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))], axis=1)
        faces = np.arange(4 * len(nodes)).reshape(-1, 4)[:, ::sign]
        meshes.append(Mesh(points.reshape(-1, 3), np.repeat(sign * tangent[:, end], 4, axis=0), faces, np.repeat(colours[:, end], 4, axis=0)))
    return Mesh.joined(meshes)


def ring_faces(rods, rings, sides):
    number = np.arange(rods * rings * sides).reshape(rods, rings, sides)
    beside = np.roll(number, -1, axis=2)
    return np.stack([number[:, :-1], beside[:, :-1], beside[:, 1:], number[:, 1:]], axis=-1).reshape(-1, 4)


def capsules(start, end, radius, colour, sides=48):
    """Balls (start = end) and capsules [bodies, 3] of one colour."""
    axis = np.where(np.linalg.norm(end - start, axis=-1, keepdims=True) > 0, end - start, [0, 0, 1.0])
    tangent = unit(axis)
    first = unit(np.cross(np.eye(3)[np.argmin(np.abs(tangent), axis=-1)], tangent))
    second = np.cross(tangent, first)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = first[:, None] * np.cos(angle)[:, None] + second[:, None] * np.sin(angle)[:, None]
    slope = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sides // 2)
    normal = np.cos(slope)[None, :, None, None] * ring[:, None] + np.sin(slope)[None, :, None, None] * tangent[:, None, None]
    centre = np.where((slope < 0)[None, :, None], start[:, None], end[:, None])
    points = centre[:, :, None] + np.asarray(radius)[:, None, None, None] * normal
    return Mesh(points.reshape(-1, 3), normal.reshape(-1, 3), ring_faces(*points.shape[:3]), np.tile(colour, (points[..., 0].size, 1)))


def columns(ends, first, second, colour, sides=96):
    """An elliptic cylinder along z, with semi-axes along x and y, between two points [2, 3], closed above."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([first * np.cos(angle), second * np.sin(angle), np.zeros(sides)], axis=1)
    out = unit(np.stack([second * np.cos(angle), first * np.sin(angle), np.zeros(sides)], axis=1))
    up = np.tile([0.0, 0.0, 1.0], (sides, 1))
    points = np.concatenate([ends[0] + ring, ends[1] + ring, ends[1] + ring, ends[1] + 0 * ring])
    faces = np.concatenate([ring_faces(1, 2, sides), 2 * sides + ring_faces(1, 2, sides)])
    return Mesh(points, np.concatenate([out, out, up, up]), faces, np.tile(colour, (len(points), 1)))


def axes_of(quaternion):
    """Rows: axes of a frame turned by w, x, y, z."""
    w, x, y, z = quaternion
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                     [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                     [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]])


def boxes(centre, axes, half, colour, times=8):
    """Boxes: centre [bodies, 3], axes [bodies, 3, 3] (rows), half sides [bodies, 3]. Each side of times x times faces, to be shaded."""
    meshes = []
    for normal in range(3):
        for sign in (-1, 1):
            u, v = (normal + 1) % 3, (normal + 2) % 3
            local = np.zeros((times + 1, times + 1, 3))
            local[..., normal], local[..., u], local[..., v] = sign, *np.meshgrid(*[np.linspace(-1, 1, times + 1)] * 2, indexing="ij")
            points = centre[:, None, None] + np.einsum("bij,uvi,bi->buvj", axes, local, half)
            normals = np.broadcast_to(sign * axes[:, None, None, normal], points.shape)
            number = np.arange(points[..., 0].size).reshape(points.shape[:-1])
            faces = np.stack([number[:, :-1, :-1], number[:, 1:, :-1], number[:, 1:, 1:], number[:, :-1, 1:]], axis=-1).reshape(-1, 4)
            meshes.append(Mesh(points.reshape(-1, 3), normals.reshape(-1, 3), faces if sign > 0 else faces[:, ::-1], np.tile(colour, (points[..., 0].size, 1))))
    return Mesh.joined(meshes)


def plate(low, high, up, height, colour, times=320):
    """The ground between two corners, across `up` (an axis of the lab), of times x times faces that catch shadows."""
    u, v = (up + 1) % 3, (up + 2) % 3
    points = np.empty((times + 1, times + 1, 3))
    points[..., u], points[..., v] = np.meshgrid(np.linspace(low[u], high[u], times + 1), np.linspace(low[v], high[v], times + 1), indexing="ij")
    points[..., up] = height
    normals = np.zeros_like(points)
    normals[..., up] = 1
    number = np.arange(points[..., 0].size).reshape(points.shape[:2])
    faces = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    return Mesh(points.reshape(-1, 3), normals.reshape(-1, 3), faces, np.tile(colour, (number.size, 1)))


def edges(points, polygons):
    """[edges, 2, 3]: of a surface of polygons those at its rim or where it turns by more than 30 degrees."""
    sides = {}
    for polygon in polygons:
        corner = points[polygon].astype(float)
        normal = unit(np.sum(np.cross(corner, np.roll(corner, -1, axis=0)), axis=0))
        for a, b in zip(polygon, np.roll(polygon, -1)):
            key = tuple(sorted((tuple(np.round(points[a], 9)), tuple(np.round(points[b], 9)))))
            sides.setdefault(key, []).append(normal)
    return np.array([key for key, found in sides.items() if len(found) == 1 or abs(found[0] @ found[1]) < np.cos(np.pi / 6)]).reshape(-1, 2, 3)


def wires(ends, radius, colour, sides=6):
    """Thin bars along edges [edges, 2, 3]."""
    count = len(ends)
    return tubes(ends.astype(float), np.full((count, 2), radius), np.tile(colour, (count, 2, 1)), sides, caps=0)
