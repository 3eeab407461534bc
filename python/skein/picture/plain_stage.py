"""Drawing by matplotlib alone, where there is no VTK: faces far first, shaded by one lamp and the sky, without shadows."""

import numpy as np

from .shapes import unit
from .sheet import blank

DETAIL = 0.2  # of surfaces, against those for VTK: each face is a polygon of its own

def why_not():
    return ""


class Stage:
    def __init__(self, width, height, samples=1):
        self.width, self.height = width, height

    def draw(self, view, shown):
        from matplotlib.collections import PolyCollection
        lit, camera = len(shown.mesh.faces), view.camera
        mesh = shown.mesh if shown.flat is None else type(shown.mesh).joined([shown.mesh, shown.flat])
        right, _, back = camera.axes
        lamp = unit(0.9 * view.up - 0.5 * right + 0.35 * back)
        corner = mesh.points[mesh.faces]
        centre, normal = corner.mean(axis=1), unit(mesh.normals[mesh.faces].mean(axis=1))
        towards_eye = unit(camera.eye - centre)
        seen = np.flatnonzero(np.sum(normal * towards_eye, axis=1) > -0.1)
        place, depth = camera.project(corner[seen].reshape(-1, 3))
        far_first = np.argsort(-depth.reshape(-1, 4).mean(axis=1))
        chosen = seen[far_first]
        bright = 0.34 + 0.24 * (1 + normal[chosen] @ view.up) + 0.5 * np.clip(normal[chosen] @ lamp, 0, 1)
        shine = 0.22 * np.clip(np.sum(normal[chosen] * unit(lamp + towards_eye[chosen]), axis=1), 0, 1)[:, None] ** 40
        flat = chosen >= lit
        bright[flat], shine[flat] = 1, 0
        faces = np.clip(mesh.colours[mesh.faces[chosen]].mean(axis=1) * bright[:, None] + shine, 0, 1)
        figure = blank(self.width, self.height)
        axes = figure.add_axes([0, 0, 1, 1])
        axes.add_collection(PolyCollection(place.reshape(-1, 4, 2)[far_first], facecolors=faces, edgecolors=faces, linewidths=0.35))
        aspect = self.width / self.height
        axes.set(xlim=(-aspect, aspect), ylim=(-1, 1))
        axes.set_axis_off()
        figure.canvas.draw()
        image = np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()
        return image
