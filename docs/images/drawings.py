#!/usr/bin/python3
"""Draws the figures of docs/theory.md and docs/numerics.md: rod, cell, clamps, capsules, joint and grid, as PNG files beside this script.

  drawings.py [FOLDER]    default: the folder of this script
"""

import io
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

BLUE, RED, GREEN, GREY, ROD = "#1f5fa8", "#c0392b", "#2e8b57", "#7f8c8d", "#cfdcec"


def blank(width, height, x, y):
    figure, axes = plt.subplots(figsize=(width, height), dpi=110)
    axes.set_xlim(*x)
    axes.set_ylim(*y)
    axes.set_aspect("equal")
    axes.axis("off")
    figure.subplots_adjust(0, 0, 1, 1)
    return figure, axes


def arrow(axes, start, end, colour, width=1.8):
    axes.annotate("", xy=end, xytext=start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0})


def words(axes, place, text, colour="black", size=12, **options):
    axes.text(*place, text, color=colour, fontsize=size, ha=options.pop("ha", "center"), va=options.pop("va", "center"), **options)


def tube(axes, points, radius, colour=ROD):
    """A capsule per edge, so that the tube is round at nodes and ends."""
    for a, b in zip(points[:-1], points[1:]):
        along = (b - a) / np.linalg.norm(b - a)
        side = radius * np.array([-along[1], along[0]])
        axes.fill(*np.array([a + side, b + side, b - side, a - side]).T, color=colour, lw=0)
    for point in points:
        axes.add_patch(plt.Circle(point, radius, color=colour, lw=0))


def measure(axes, a, b, text, colour=GREY, off=0.14, **options):
    axes.annotate("", xy=b, xytext=a, arrowprops={"arrowstyle": "<->", "color": colour, "lw": 1, "shrinkA": 0, "shrinkB": 0})
    a, b = np.array(a), np.array(b)
    side = np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
    words(axes, (a + b) / 2 + off * side, text, colour, **options)


def rod():
    """Nodes, elements, the frame of an element, and its section seen along d3."""
    figure, axes = blank(7.2, 2.6, (-0.4, 8.3), (-0.55, 2.6))
    s = np.linspace(0, 1, 6)
    points = np.stack([5.4 * s, 0.35 + 1.2 * np.sin(2.2 * s)], 1)
    tube(axes, points, 0.17)
    axes.plot(*points.T, color=BLUE, lw=1.5)
    axes.plot(*points.T, "o", color=BLUE, ms=6)
    for k in (0, 1, 2, 3):
        words(axes, points[k] + (0.07, -0.37), f"$x_{k}$", BLUE)
    words(axes, points[5] + (-0.1, -0.4), "$x_n$", BLUE)
    middle, along = (points[2] + points[3]) / 2, points[3] - points[2]
    along /= np.linalg.norm(along)
    side = np.array([-along[1], along[0]])
    arrow(axes, middle, middle + 0.95 * along, RED)
    arrow(axes, middle, middle + 0.85 * side, RED)
    axes.add_patch(plt.Circle(middle, 0.11, fc="white", ec=RED, lw=1.5, zorder=3))
    axes.plot(*middle, "x", color=RED, ms=6, zorder=4)   # into the page: d1 x d2 = d3
    words(axes, middle + 0.95 * along + (0.1, 0.24), "$d_3$", RED)
    words(axes, middle + 0.85 * side + (0, 0.2), "$d_2$", RED)
    words(axes, middle + (-0.28, 0.28), "$d_1$", RED)
    middle = (points[0] + points[1]) / 2
    words(axes, middle + (-0.2, 0.5), "element 0", GREY, 10)
    words(axes, (3.3, 0.35), "element 2: $Q_2$, $\\omega_2$, $l_2$", GREY, 10)
    arrow(axes, (3.1, 0.52), (points[2] + points[3]) / 2 + (0.2, -0.2), GREY, 1)
    centre = np.array([7.0, 0.95])
    axes.add_patch(matplotlib.patches.Ellipse(centre, 1.7, 1.1, fc=ROD, ec=BLUE))
    arrow(axes, centre, centre + (1.15, 0), RED)
    arrow(axes, centre, centre + (0, 0.95), RED)
    axes.add_patch(plt.Circle(centre, 0.08, fc="white", ec=RED, lw=1.5))
    axes.plot(*centre, ".", color=RED, ms=4)
    words(axes, centre + (1.15, -0.2), "$d_1$", RED)
    words(axes, centre + (0.25, 0.9), "$d_2$", RED)
    words(axes, centre + (-0.22, -0.2), "$d_3$", RED)
    measure(axes, centre + (0, -0.75), centre + (0.85, -0.75), "$a$", off=-0.17)
    measure(axes, centre + (-1.05, 0), centre + (-1.05, 0.55), "$b$", off=0.17)
    words(axes, centre + (0, 1.3), "section", GREY, 10)
    return figure


def cell():
    """The Voronoi cell between the middles of two elements, and the angle that its curvature measures."""
    figure, axes = blank(6.2, 2.6, (-0.5, 6.0), (-0.5, 2.2))
    points = np.array([[0, 0.3], [1.9, 1.25], [4.0, 1.1], [5.6, 0.2]])
    middles = (points[1:] + points[:-1]) / 2
    tube(axes, points, 0.2)
    tube(axes, np.array([middles[0], points[1], middles[1]]), 0.2, "#f6d9b8")
    axes.plot(*points.T, color=BLUE, lw=1.5)
    axes.plot(*points.T, "o", color=BLUE, ms=6)
    for name, point, off in (("$x_k$", points[0], (-0.25, 0.3)), ("$x_{k+1}$", points[1], (0.1, -0.42)), ("$x_{k+2}$", points[2], (0.1, -0.42))):
        words(axes, point + off, name, BLUE)
    for k, name in ((0, "$Q_k$"), (1, "$Q_{k+1}$")):
        along = points[k + 1] - points[k]
        along /= np.linalg.norm(along)
        side = np.array([-along[1], along[0]])
        arrow(axes, middles[k], middles[k] + 0.6 * along, RED)
        arrow(axes, middles[k], middles[k] + 0.6 * side, RED)
        words(axes, middles[k] - 0.45 * side + (0.1, 0), name, RED)
    words(axes, (1.95, 1.85), "cell $k$: $D_k$, $B^{cell}_k$, $\\kappa_k$", "#a35d00", 11)
    measure(axes, points[2] + (-2.1, -0.95), points[2] + (0, -1.1), "$l_{k+1}$", off=-0.2)
    return figure


def clamps():
    """`clamped` and `clamped_frozen`: where a held rod begins to bend."""
    figure, axes = blank(7.0, 1.9, (-0.4, 8.6), (-1.0, 1.35))
    for left, name, first in ((0, "clamped", 0), (4.6, "clamped_frozen", 0.5)):
        axes.fill([left - 0.3, left, left, left - 0.3], [-0.7, -0.7, 0.9, 0.9], fc="#dddddd", ec=GREY, hatch="///", lw=0)
        axes.plot([left, left], [-0.7, 0.9], color=GREY)
        nodes = np.array([[left, 0.1], [left + 1, 0.1], [left + 2, 0.02], [left + 3, -0.22]])
        if not first:
            nodes = np.array([[left, 0.1], [left + 1, 0.05], [left + 2, -0.14], [left + 3, -0.45]])
        tube(axes, nodes, 0.13)
        axes.plot(*nodes.T, "-o", color=BLUE, ms=5)
        if first:
            axes.plot(nodes[:2, 0], nodes[:2, 1], color=RED, lw=3)
            words(axes, (left + 0.1, -0.28), "held element", RED, 10, ha="left")
        start = left + first
        axes.fill_between([start, left + 1.5 if first else left + 0.5], [0.3, 0.3], [0.42, 0.42], color="#f0a040")
        words(axes, (left + 1.0 if first else left + 0.1, 0.62), "first cell" if first else "half cell at the wall", "#a35d00", 10, ha="center" if first else "left")
        words(axes, (left + 1.5, 1.12), name, "black", 12, family="monospace")
    return figure


def capsules():
    """Two elements as capsules that overlap by g."""
    figure, axes = blank(6.0, 2.9, (-0.7, 5.6), (-0.75, 2.3))
    below, above, radius = np.array([[0, 0.0], [4.6, 0.0]]), np.array([[2.3, 0.85], [5.0, 1.75]]), 0.55
    tube(axes, below, radius)
    tube(axes, above, radius, "#f6d9b8")
    axes.add_patch(plt.Circle(above[0], radius, fill=False, ec="#a35d00", lw=1))
    axes.plot([0, 4.6], [radius, radius], color=BLUE, lw=1)
    for edge, colour in ((below, BLUE), (above, "#a35d00")):
        axes.plot(*edge.T, "-o", color=colour, ms=5)
    near = np.array([2.3, 0.0])
    arrow(axes, near, above[0], "black")
    axes.plot(*near, "s", color=BLUE, ms=5)
    words(axes, (2.3, -0.25), "$x_1 = p_1 + s\\,d_1$", BLUE)
    words(axes, (2.05, 1.15), "$x_2$", "#a35d00")
    words(axes, (2.5, 0.6), "$n$")
    words(axes, (0, -0.25), "$p_1$", BLUE)
    measure(axes, (1.55, above[0][1] - radius), (1.55, radius), "$g$", RED, off=0.2)
    measure(axes, (0.5, 0), (0.5, radius), "$r_1$", off=0.22)
    measure(axes, above[1], above[1] + radius * np.array([0.316, -0.949]), "$r_2$", off=0.22)
    arrow(axes, (2.3, 0.42), (3.2, 0.42), GREEN)
    words(axes, (3.5, 0.3), "$u_t$", GREEN)
    return figure


def joint():
    """Two points at arms of two elements, held together by a spring and a dashpot."""
    figure, axes = blank(6.2, 2.6, (-0.5, 6.0), (-0.55, 2.2))
    first, second = np.array([[0, 0.2], [2.2, 0.75]]), np.array([[3.6, 1.55], [5.5, 0.35]])
    for edge, colour in ((first, ROD), (second, "#f6d9b8")):
        tube(axes, edge, 0.28, colour)
    arms = []
    for edge, share, colour, k, side in ((first, 0.7, BLUE, 1, 1), (second, 0.25, "#a35d00", 2, -1)):
        axes.plot(*edge.T, "-o", color=colour, ms=5)
        foot = edge[0] + share * (edge[1] - edge[0])
        along = (edge[1] - edge[0]) / np.linalg.norm(edge[1] - edge[0])
        tip = foot + side * 0.62 * np.array([-along[1], along[0]]) + (0.1 * side, 0)
        arrow(axes, foot, tip, colour)
        axes.plot(*tip, "s", color=colour, ms=5)
        words(axes, (foot + tip) / 2 + (0.27, 0 if k == 2 else -0.02), f"$r_{k}$", colour)
        words(axes, tip + ((-0.3, 0.1) if k == 1 else (0.1, -0.25)), f"$x_{k}$", colour)
        arms.append(tip)
    a, b = arms
    t = np.linspace(0, 1, 200)[:, None]
    side = np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
    axes.plot(*(a + t * (b - a) + 0.08 * np.sin(2 * np.pi * 9 * t) * (np.abs(t - 0.5) < 0.4) * side).T, color=RED, lw=1.3)
    words(axes, (a + b) / 2 + 0.32 * side, "$d$: $k$, $\\nu$", RED)
    words(axes, first[0] + (0.1, -0.5), "element of 1", BLUE, 10)
    words(axes, second[1] + (-0.2, -0.55), "element of 2", "#a35d00", 10)
    return figure


def grid():
    """Places of pressure and velocities in the grid, and markers of a body."""
    figure, axes = blank(5.6, 3.6, (-0.5, 4.9), (-0.45, 3.3))
    for i in range(5):
        axes.plot([i, i], [0, 3], color="#bbbbbb", lw=1)
    for j in range(4):
        axes.plot([0, 4], [j, j], color="#bbbbbb", lw=1)
    centre, radius, within = np.array([2.7, 1.5]), 1.2, 0.4
    axes.add_patch(plt.Circle(centre, radius, fc=ROD, ec=BLUE, lw=1.2, alpha=0.7))
    turn = np.linspace(0, 2 * np.pi, 6, endpoint=False) + 0.3
    axes.plot(centre[0] + (radius - within) * np.cos(turn), centre[1] + (radius - within) * np.sin(turn), "D", color=GREEN, ms=6)
    for i in range(4):
        for j in range(3):
            axes.plot(i + 0.5, j + 0.5, "o", color=BLUE, ms=5)
            arrow(axes, (i + 0.85, j + 0.5), (i + 1.18, j + 0.5), RED, 1.3)
            arrow(axes, (i + 0.5, j + 0.85), (i + 0.5, j + 1.18), "#a35d00", 1.3)
    words(axes, (0.3, 0.32), "$p$", BLUE)
    words(axes, (1.22, 0.74), "$u_x$", RED)
    words(axes, (0.76, 1.24), "$u_y$", "#a35d00")
    measure(axes, (0, -0.2), (1, -0.2), "$h$", off=-0.18)
    words(axes, (4.45, 2.85), "markers", GREEN, 11)
    arrow(axes, (4.3, 2.7), centre + (radius - within) * np.array([np.cos(turn[0]), np.sin(turn[0])]) + (0.06, 0.1), GREEN, 1)
    return figure


def main(folder):
    for draw in (rod, cell, clamps, capsules, joint, grid):
        figure, raw = draw(), io.BytesIO()
        figure.savefig(raw, dpi=110, facecolor="white")
        plt.close(figure)
        target = folder / f"drawing_{draw.__name__}.png"
        Image.open(raw).convert("RGB").quantize(64, dither=Image.Dither.NONE).save(target, optimize=True)
        print(f"{target.name}: {target.stat().st_size / 1e3:.1f} kB")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent)
