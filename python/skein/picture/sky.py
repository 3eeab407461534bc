"""Daylight: how much of the sky and of the sun each point of a surface sees.

The bodies' depth is drawn once from every direction of light (a parallel projection); a point is lit from a direction unless something
is nearer to the light there. Sums over directions give open shade in crevices and soft shadows, on whatever draws depths.
"""

import numpy as np

from .shapes import unit

SKY, SUN = 26, 6              # directions
SUN_WIDTH = 0.10              # rad, half the angle over which the sun is spread
AMBIENT, BOUNCE, SKY_SHARE, SUN_SHARE = 0.12, 0.16, 0.52, 0.50  # bounce: from the ground, to what faces down
FILL = 0.15


def directions(up, sun):
    """[directions, 3] towards the light, and what each gives to a surface that faces it."""
    golden = np.pi * (3 - np.sqrt(5))
    k = np.arange(SKY)
    height = np.sqrt((k + 0.5) / SKY)  # as many as give a level plane the same light each
    across = np.sqrt(1 - height**2)
    axes = frame(up)
    dome = height[:, None] * axes[2] + across[:, None] * (np.cos(golden * k)[:, None] * axes[0] + np.sin(golden * k)[:, None] * axes[1])
    j = np.arange(SUN)
    axes = frame(sun)
    width = SUN_WIDTH * np.sqrt((j + 0.5) / SUN)
    disc = unit(axes[2] + width[:, None] * (np.cos(golden * j)[:, None] * axes[0] + np.sin(golden * j)[:, None] * axes[1]))
    return np.concatenate([dome, disc]), np.concatenate([SKY_SHARE / (SKY * height), np.full(SUN, SUN_SHARE / (SUN * max(unit(np.asarray(sun)) @ unit(np.asarray(up)), 0.3)))])


def frame(axis):
    axis = unit(np.asarray(axis, float))
    first = unit(np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis))
    return np.stack([first, np.cross(axis, first), axis])


def light(points, normals, depth_from, up, sun, centre, size, pixels):
    """[points]: 1 on open level ground. `depth_from(right, above, towards)`: distances [pixels, pixels] of what is nearest to the light from a plane
    at `size` from the centre towards it, over a square of half side `size`."""
    found = AMBIENT + 0.5 * BOUNCE * (1 - normals @ np.asarray(up, float))
    step = 2 * size / pixels
    clear = (points + 1.5 * step * normals - centre).astype(np.float32)
    normals = normals.astype(np.float32)
    for towards, share in zip(*directions(up, sun)):
        right, above, _ = frame(towards)
        facing = normals @ towards.astype(np.float32)
        column = np.clip((0.5 + 0.5 / size * (clear @ right.astype(np.float32))) * pixels, 0, pixels - 1).astype(np.int32)
        row = np.clip((0.5 + 0.5 / size * (clear @ above.astype(np.float32))) * pixels, 0, pixels - 1).astype(np.int32)
        seen = size - clear @ towards.astype(np.float32) < depth_from(right, above, towards)[row, column] + 1.5 * step
        found += share * np.maximum(facing, 0) * seen
    return found


def from_the_eye(points, normals, eye):
    """A little light from where the picture is taken: what faces the viewer is not left in the dark."""
    return FILL * np.clip(np.sum(normals * unit(eye - points), axis=-1), 0, 1)


def highlight(points, normals, eye, sun):
    half = unit(unit(np.asarray(sun)) + unit(eye - points))
    return 0.16 * np.clip(np.sum(normals * half, axis=-1), 0, 1) ** 40


def smoothed(values, width):
    """Light [rows, columns] of a level plate, mean over a square of 2 width + 1 points, twice: few directions give steps in shadows."""
    for _ in range(2):
        for axis in (0, 1):
            padded = np.pad(values, [(width + 1, width) if a == axis else (0, 0) for a in (0, 1)], mode="edge").cumsum(axis=axis)
            values = (np.take(padded, range(2 * width + 1, padded.shape[axis]), axis) - np.take(padded, range(padded.shape[axis] - 2 * width - 1), axis)) / (2 * width + 1)
    return values
