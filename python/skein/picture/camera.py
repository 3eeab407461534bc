"""Where a picture is taken from."""

from dataclasses import dataclass

import numpy as np

from .shapes import unit

VIEW_ANGLE = 24.0  # degrees, across the picture's height


@dataclass
class Camera:
    """Central projection."""
    eye: np.ndarray
    target: np.ndarray
    up: np.ndarray
    angle: float = VIEW_ANGLE

    @property
    def axes(self):
        """Right, up and back."""
        back = unit(self.eye - self.target)
        right = unit(np.cross(self.up, back))
        return right, np.cross(back, right), back

    def project(self, points):
        """[points, 2] in units of half the picture's height, and depth in m."""
        right, up, back = self.axes
        ray = points - self.eye
        depth = -(ray @ back)
        scale = depth * np.tan(np.radians(0.5 * self.angle))
        return np.stack([ray @ right / scale, ray @ up / scale], axis=-1), depth


def framed(points, from_where, up, aspect, margin=0.06, angle=VIEW_ANGLE):
    """The camera in direction `from_where` that shows all of these points."""
    from_where, up = unit(np.asarray(from_where, float)), np.asarray(up, float)
    right = unit(np.cross(up, from_where))
    above = np.cross(from_where, right)
    across, upward, near = points @ right, points @ above, points @ from_where
    tangent = (1 - margin) * np.tan(np.radians(0.5 * angle))

    def fit(along, slope):
        """Least distance, and the eye's place along, from which |along - place| <= (distance - near) slope for all points."""
        high, low = np.max(along + near * slope), np.min(along - near * slope)
        return (high - low) / (2 * slope), 0.5 * (high + low)
    wide, tall = fit(across, aspect * tangent), fit(upward, 0.88 * tangent)  # room for words above and below
    distance = max(wide[0], tall[0])
    target = wide[1] * right + tall[1] * above
    middle = 0.5 * (near.min() + near.max())
    if distance - near.max() < 1e-9:
        distance = near.max() + 1e-9
    return Camera(target + distance * from_where, target + middle * from_where, up, angle)
