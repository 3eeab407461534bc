"""Rods as shaded tubes, on a plate if wanted, in perspective: quads sorted from far to near, which matplotlib fills.

All arrays in m, lab frame, z up; colours are RGB from 0 to 1.
"""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Polygon

SIDES = 32      # of a tube, unless told
CAP_RINGS = 5   # of the half sphere on a tip
LIGHT = np.array([-0.45, -0.40, 0.80]) / np.linalg.norm([-0.45, -0.40, 0.80])  # towards the light
PLATE, PLATE_EDGE = "#eef0f3", "#cfd4db"
SHADOWS = "#e3e6ea", "#d6dae0", "#c8cdd5"  # from rim to core


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


class Camera:
    """Central projection; `place` is where the eye is, seen from the target, in units of the scene's size."""

    def __init__(self, target, size, place=(-0.50, -1.75, 1.05)):
        self.eye = target + size * np.asarray(place)
        self.back = unit(self.eye - target)
        self.right = unit(np.cross([0, 0, 1.0], self.back))
        self.up = np.cross(self.back, self.right)

    def project(self, points):
        ray = points - self.eye
        depth = -(ray @ self.back)
        return np.stack([ray @ self.right / depth, ray @ self.up / depth], axis=-1)

    def distance(self, points):
        return np.linalg.norm(points - self.eye, axis=-1)


def rings(nodes, radius, sides=SIDES, both_ends=False):
    """Surface of the tubes: points and outward normals [rods, rings, sides, 3], a half sphere at the last node included, or at both.
    Radius [nodes] of rods that are alike, or [rods, nodes]."""
    angle = np.linspace(0, np.pi / 2, CAP_RINGS + 1)[1:]
    tangent = unit(np.gradient(nodes, axis=1))
    first = np.zeros_like(tangent)  # normal of the tube, carried along without twist
    least = np.where(np.abs(tangent[:, :1, 1]) < 0.9, [0, 1.0, 0], [1.0, 0, 0])  # an axis that is not the tube's
    first[:, 0] = unit(np.cross(least, tangent[:, 0]))
    for k in range(1, nodes.shape[1]):
        before = first[:, k - 1]
        first[:, k] = unit(before - np.sum(before * tangent[:, k], axis=-1, keepdims=True) * tangent[:, k])
    second = np.cross(tangent, first)

    around = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    side = first[:, :, None] * np.cos(around)[:, None] + second[:, :, None] * np.sin(around)[:, None]
    radius = np.broadcast_to(radius, nodes.shape[:2])[..., None, None]
    points = nodes[:, :, None] + radius * side
    slope = angle[None, :, None, None]

    def cap(end, sign):
        return np.cos(slope) * side[:, end, None] + sign * np.sin(slope) * tangent[:, end, None, None]

    last = cap(-1, 1)
    surface, normal = [points, nodes[:, -1:, None] + radius[:, -1:] * last], [side, last]
    if both_ends:
        start = cap(0, -1)[:, ::-1]
        surface.insert(0, nodes[:, :1, None] + radius[:, :1] * start)
        normal.insert(0, start)
    return np.concatenate(surface, axis=1), np.concatenate(normal, axis=1)


def shade(normal, height, towards_eye, colour):
    """Daylight from above, one lamp, a highlight, and less of the sky near the ground."""
    lamp = np.clip(normal @ LIGHT, 0, 1)
    sky = 0.5 * (1 + normal[..., 2])
    half = unit(LIGHT + towards_eye)
    highlight = np.clip(np.sum(normal * half, axis=-1), 0, 1) ** 40
    open_sky = 0.62 + 0.38 * np.clip(height, 0, 1)
    bright = (0.36 + 0.24 * sky + 0.52 * lamp) * open_sky
    return np.clip(bright[..., None] * colour + 0.28 * highlight[..., None], 0, 1)


def corners(surface):
    """Quads [rods, rings - 1, sides, 4, 3] of a surface of rings."""
    beside = np.roll(surface, -1, axis=2)
    return np.stack([surface[:, :-1], beside[:, :-1], beside[:, 1:], surface[:, 1:]], axis=3)


def draw_tubes(axes, camera, nodes, radius, colours, sky_from=None, sides=SIDES, both_ends=False):
    """Colours [rods, 3] or [rods, nodes - 1, 3]; from height sky_from on the sky is open, by default 0.6 of the highest tip."""
    points, normals = rings(nodes, radius, sides, both_ends)
    quads, normal = corners(points), unit(corners(normals).mean(axis=3))
    centre = quads.mean(axis=3)
    towards_eye = unit(camera.eye - centre)
    if colours.ndim == 2:
        colours = colours[:, None]
    else:
        colours = np.pad(colours, ((0, 0), (CAP_RINGS if both_ends else 0, CAP_RINGS), (0, 0)), mode="edge")
    colour = shade(normal, centre[..., 2] / (sky_from or 0.6 * nodes[:, -1, 2].max()), towards_eye, colours[:, :, None, :])
    seen = np.sum(normal * towards_eye, axis=-1) > -0.1
    far_first = np.argsort(-camera.distance(centre[seen]))
    faces = colour[seen][far_first]
    axes.add_collection(PolyCollection(camera.project(quads[seen][far_first]), facecolors=faces, edgecolors=faces, linewidths=0.35))


def draw_shadows(axes, camera, nodes, radius, plate):
    """Strips and discs on the plate, where the lamp does not reach: opaque, so that they do not darken each other."""
    ground = nodes - nodes[..., 2:] / LIGHT[2] * LIGHT
    along = unit(np.gradient(ground, axis=1) + 1e-9 * np.array([1.0, 0, 0]))
    across = np.stack([-along[..., 1], along[..., 0], np.zeros(along.shape[:2])], axis=-1)
    around = np.linspace(0, 2 * np.pi, 24)
    disc = np.stack([np.cos(around), np.sin(around), 0 * around], axis=-1)
    for colour, scale in zip(SHADOWS, (1.35, 1.1, 0.85)):
        width = scale * np.broadcast_to(radius, nodes.shape[:2])[..., None]
        left, right = ground + width * across, ground - width * across
        strips = np.stack([left[:, :-1], left[:, 1:], right[:, 1:], right[:, :-1]], axis=2).reshape(-1, 4, 3)
        discs = (ground[:, :, None] + width[..., None] * disc).reshape(-1, len(around), 3)
        for shapes in (strips, discs):
            collection = PolyCollection(camera.project(shapes), facecolors=colour, edgecolors=colour, linewidths=0.3)
            axes.add_collection(collection)
            collection.set_clip_path(plate)


def draw_plate(axes, camera, low, high):
    """A plate from low to high with its top at z = 0; returns the patch of its top."""
    corner = np.array([[low[0], low[1], 0], [high[0], low[1], 0], [high[0], high[1], 0], [low[0], high[1], 0]])
    thick = np.array([0, 0, 0.012 * np.linalg.norm(high - low)])
    for a, b in zip(corner, np.roll(corner, -1, axis=0)):
        axes.add_patch(Polygon(camera.project(np.array([a, b, b - thick, a - thick])), facecolor=PLATE_EDGE, edgecolor="none"))
    return axes.add_patch(Polygon(camera.project(corner), facecolor=PLATE, edgecolor="none"))


def draw(axes, nodes, radius, colours):
    """Rods of nodes [rods, nodes, 3], radius [nodes] or [rods, nodes], colours [rods, 3], on a plate through z = 0; returns the camera."""
    low, high = nodes[:, 0].min(axis=0), nodes[:, 0].max(axis=0)
    length = np.linalg.norm(np.diff(nodes[0], axis=0), axis=1).sum()
    camera = Camera(0.5 * (low + high), np.linalg.norm(high - low) + 2 * length)
    plate = draw_plate(axes, camera, low - length, high + length)
    draw_shadows(axes, camera, nodes, radius, plate)
    draw_tubes(axes, camera, nodes, radius, colours)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0)
    axes.set_axis_off()
    return camera
