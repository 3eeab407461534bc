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


ABOVE, BELOW = 0.86, 0.80  # of half the picture's height, what points keep to: words stand beyond


def upright(from_where, up):
    """`up`, or where it is along the line of sight the y axis, then the x axis: a picture needs a direction across that line."""
    from_where = unit(np.asarray(from_where, float))
    for axis in (np.asarray(up, float), np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])):
        if np.linalg.norm(np.cross(axis, from_where)) > 1e-6 * np.linalg.norm(axis):
            return axis
    raise ValueError("a camera needs a direction")


def framed(points, from_where, up, aspect, margin=0.06, angle=VIEW_ANGLE, below=BELOW):
    """The camera in direction `from_where` that shows all of these points."""
    from_where, up = unit(np.asarray(from_where, float)), upright(from_where, up)
    right = unit(np.cross(up, from_where))
    above = np.cross(from_where, right)
    across, upward, near = points @ right, points @ above, points @ from_where
    tangent = np.tan(np.radians(0.5 * angle))

    def fit(along, far, back):
        """Least distance, and the eye's place along, from which -(distance - near) back <= along - place <= (distance - near) far for all points."""
        high, low = np.max(along + near * far), np.min(along - near * back)
        return (high - low) / (far + back), (low * far + high * back) / (far + back)

    wide, tall = fit(across, *[(1 - margin) * aspect * tangent] * 2), fit(upward, ABOVE * tangent, below * tangent)
    distance = max(wide[0], tall[0], near.max() + 1e-9)
    target = wide[1] * right + tall[1] * above
    middle = 0.5 * (near.min() + near.max())
    return Camera(target + distance * from_where, target + middle * from_where, up, angle)
