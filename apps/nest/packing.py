"""Pictures of a bed of rods between floor and lid: what plot.py draws of the frames of a run.

Rods are coloured by how much they bend: the strain kappa r at their surface, between elements.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Polygon

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "figures"))
import tubes  # noqa: E402  (from apps/figures)

BENDING = LinearSegmentedColormap.from_list("bending", ["#d9cdb8", "#dfa65a", "#c8442b", "#6d0f2e"])  # from wood to what would break first
FLOOR, FLOOR_EDGE, LID = "#eef0f3", "#cfd4db", "#9fb4cc"
PIECES = 4  # per element: long quads would be sorted wrongly where rods cross


def bending_strain(nodes, radius):
    """kappa r of elements, mean of those at their ends, [rods, elements]."""
    edge = np.diff(nodes, axis=1)
    length = np.linalg.norm(edge, axis=-1)
    tangent = edge / length[..., None]
    sine = np.linalg.norm(np.cross(tangent[:, :-1], tangent[:, 1:]), axis=-1)
    at_node = np.pad(2 * sine / (length[:, :-1] + length[:, 1:]) * np.mean(radius), ((0, 0), (1, 1)))
    return 0.5 * (at_node[:, :-1] + at_node[:, 1:])


def finer(nodes, radius, strain):
    """Straight pieces of the elements."""
    at = np.linspace(0, nodes.shape[1] - 1, PIECES * (nodes.shape[1] - 1) + 1)
    left = np.minimum(at.astype(int), nodes.shape[1] - 2)
    share = at - left
    between = nodes[:, left] * (1 - share)[:, None] + nodes[:, left + 1] * share[:, None]
    return between, np.interp(at, np.arange(len(radius)), radius), np.repeat(strain, PIECES, axis=1)


class Stage:
    """Outline of floor and lid: a circle where a tube stands around the rods, otherwise the rectangle of what the walls leave."""

    def __init__(self, physics, nodes):
        tube = [wall for wall in physics["wall"] if wall["kind"] == "tube"]
        if tube:
            angle = np.linspace(0, 2 * np.pi, 181)
            self.outline = np.array(tube[0]["point"])[:2] + tube[0]["radius"] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        else:
            low, high = nodes.min(axis=(0, 1))[:2], nodes.max(axis=(0, 1))[:2]
            self.outline = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]], [low[0], low[1]]])
        self.size = np.ptp(self.outline, axis=0).max()
        self.middle = 0.5 * (self.outline.min(axis=0) + self.outline.max(axis=0))

    def at(self, height):
        return np.column_stack([self.outline, np.full(len(self.outline), height)])


def draw(axes, physics, nodes, radius, most_strain, lid_height, top):
    """`most_strain`: end of the colours; `top`: height that the view leaves room for, so that several pictures have one scale."""
    stage = Stage(physics, nodes)
    camera = tubes.Camera(np.array([*stage.middle, 0.5 * top]), stage.size, place=(-0.35, -2.1, 0.72))
    thick = np.array([0, 0, 0.02 * stage.size])
    axes.add_patch(Polygon(camera.project(stage.at(0) - thick), facecolor=FLOOR_EDGE, edgecolor="none"))
    axes.add_patch(Polygon(camera.project(stage.at(0)), facecolor=FLOOR, edgecolor="none"))
    strain = bending_strain(nodes, radius)
    fine, thickness, strain = finer(nodes, radius, strain)
    sides = 16 if len(nodes) < 500 else 10
    colours = BENDING(np.clip(strain / most_strain, 0, 1))[..., :3]
    tubes.draw_tubes(axes, camera, fine, thickness, colours, sky_from=0.9 * nodes[..., 2].max(), sides=sides, both_ends=True)
    if lid_height <= top:
        lid = camera.project(stage.at(lid_height))
        axes.add_patch(Polygon(lid, facecolor=LID, edgecolor="none", alpha=0.16))
        axes.add_patch(Polygon(lid, facecolor="none", edgecolor=LID, lw=1.2))
    everything = np.vstack([camera.project(stage.at(0) - thick), camera.project(stage.at(top))])
    margin = 0.01 * np.ptp(everything[:, 0])
    axes.set_xlim(everything[:, 0].min() - margin, everything[:, 0].max() + margin)
    axes.set_ylim(everything[:, 1].min() - margin, everything[:, 1].max() + margin)
    axes.set_aspect("equal")
    axes.set_axis_off()
