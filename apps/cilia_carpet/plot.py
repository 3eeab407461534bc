#!/usr/bin/env python3
"""Figures of a carpet of cilia: plot.py OUT_DIR [--period SECONDS] [--turn 0.5]

Prints how the carpet beats, writes it to OUT_DIR/beat.json, and draws OUT_DIR/carpet.png where there are whole rods
(trajectory_*.h5), OUT_DIR/phase.png where there are tips only. Needs numpy, h5py and matplotlib.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402
import numpy as np  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402

import beat  # noqa: E402
import skein  # noqa: E402
from skein.picture.colours import circle  # noqa: E402
from skein.style import INK, QUIET, bare, heading  # noqa: E402


CIRCLE = circle()


def phase_at(a, time, period):
    """Phase of every cilium at an instant, 0 to 1 of a turn; 0: tip furthest towards +x."""
    return (np.angle(a) / (2 * np.pi) + time / abs(period)) % 1


def colour_bar(figure, place):
    axes = figure.add_axes(place)
    bar = figure.colorbar(ScalarMappable(Normalize(0, 360), CIRCLE), cax=axes, orientation="horizontal")
    bar.set_ticks([0, 90, 180, 270, 360], labels=["0°", "90°", "180°", "270°", "360°"])
    bar.outline.set_visible(False)
    axes.tick_params(length=0, labelcolor=INK)
    axes.set_xlabel("phase of the beat (0°: tip furthest to the right)", color=INK, labelpad=3)


def draw_orbits(axes, turn, row, nodes, colours, upwards):
    """A row from the side (upwards = 2) or from above (1): its rods at the instant, and the orbits of its tips."""
    dots = max(1, (len(turn.time) - 1) // 50)
    for i, colour in zip(row, colours):
        base = (turn.origin[i, 0] - turn.origin[row[0], 0]) / turn.length
        rod = (nodes[i] - turn.origin[i]) / turn.length
        x, y = base + turn.displacement[:, i, 0], turn.displacement[:, i, upwards]
        axes.plot(x, y, color=colour, lw=0.7, alpha=0.6, zorder=2)
        axes.scatter(x[:-1:dots], y[:-1:dots], s=5, color=colour, lw=0, zorder=2)
        axes.plot(base + rod[:, 0], rod[:, upwards], color=colour, lw=4.5, alpha=0.35, solid_capstyle="round", zorder=1)
    axes.axhline(0, color=QUIET, lw=0.8, zorder=0)
    axes.set_aspect("equal")
    axes.set_xlim(-1, (turn.origin[row[-1], 0] - turn.origin[row[0], 0]) / turn.length + 1)
    axes.set_xticks([])
    bare(axes)


def draw_phase_map(axes, turn, phase):
    x, y = ((turn.origin - turn.origin.min(axis=0)) / turn.length).T[:2]
    axes.scatter(x, y, s=150, c=CIRCLE(phase), lw=0)
    axes.set_aspect("equal")
    axes.set_xlim(-0.6, x.max() + 0.6)
    axes.set_ylim(-0.6, y.max() + 0.6)
    axes.set_yticks(np.arange(0, y.max() + 0.5, max(1, y.max() // 7)))
    axes.set_xlabel("x/L", color=INK, labelpad=2)
    axes.set_ylabel("y/L", color=INK, labelpad=2)
    bare(axes)
    axes.tick_params(length=0)
    heading(axes, "phase from above")


def draw_strokes(axes, turn, row, colours):
    """u_x of a row over the turn, one line per cilium, shifted."""
    share = (turn.time - turn.time[0]) / abs(turn.period)
    for k, (i, colour) in enumerate(zip(row, colours)):
        axes.axhline(k, color=QUIET, lw=0.4, alpha=0.5)
        axes.plot(share, k + 0.6 * turn.displacement[:, i, 0], color=colour, lw=1.8)
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.5, 1], labels=["0", "½", "1"])
    axes.set_xlabel("turn of the field", color=INK, labelpad=2)
    axes.set_yticks([])
    bare(axes, "bottom")
    heading(axes, "u of the front row's tips")


def draw_arrows(axes, pictures, turn, figures):
    """Which way wave and slow stroke go, on the plate before the front row."""
    middle = 0.5 * (turn.origin[:, 0].min() + turn.origin[:, 0].max())
    for name, key, place in (("wave", "wave", -2.6), ("slow stroke", "slow_stroke", 2.6)):
        if figures[key] == "none":
            continue
        direction = {"+x": 1, "-x": -1}[figures[key]]
        x = middle + turn.length * (place + 1.1 * direction * np.array([-1, 1]))
        y, z = np.full(2, turn.origin[:, 1].min() - 0.62 * turn.length), np.zeros(2)
        tail, head = pictures.pixels(np.stack([x, y, z], axis=1))
        axes.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.4, "shrinkA": 0, "shrinkB": 0})
        slope = (head - tail) * direction
        axes.text(*(0.5 * (tail + head)), name + "\n\n", color=INK, ha="center", va="center", rotation_mode="anchor",
                  rotation=np.degrees(np.arctan2(-slope[1], slope[0])), linespacing=0.85)


def summary(figures):
    if not figures["lag_to_next_deg"]:
        return ""
    lag, amplitude = figures["lag_to_next_deg"]["mean"], figures["amplitude_fundamental_L"]["mean"]
    words = f"neighbours {abs(lag):.1f}° apart, tips {amplitude:.2f} L to and fro"
    return words if figures["plectic"] == 0 else f"{words}, {figures['plectic_word']} wave"


def draw_carpet(path, turn, figures, a, directory, at):
    run = skein.open(directory)
    time = run.time[run.frames.nearest(turn.time[0] + at * abs(turn.period))]
    nodes = run.rods[0].position[run.frames.nearest(time)]
    phase = phase_at(a, time, turn.period)
    row = np.flatnonzero(np.isclose(turn.origin[:, 1], turn.origin[:, 1].min()))
    row = row[np.argsort(turn.origin[row, 0])]
    colours = CIRCLE(phase[row])

    figure = plt.figure(figsize=(14, 7), facecolor="white")
    view = figure.add_axes([0.0, 0.12, 0.6, 0.79])
    pictures = skein.Pictures(run, [time], (1680, 1106), colour=CIRCLE(phase)[:, :3], camera=(-0.50, -1.75, 1.05))
    pictures.show(view)
    draw_arrows(view, pictures, turn, figures)
    colour_bar(figure, [0.17, 0.085, 0.26, 0.016])

    side, above = figure.add_axes([0.61, 0.72, 0.38, 0.17]), figure.add_axes([0.61, 0.50, 0.38, 0.17])
    draw_orbits(side, turn, row, nodes, colours, upwards=2)
    draw_orbits(above, turn, row, nodes, colours, upwards=1)
    side.set_ylim(-0.1, 1.1)
    side.set_yticks([0, 1], labels=["z = 0", "L"])
    above.set_ylim(-0.85, 0.85)
    above.set_yticks([0], labels=["y = 0"])
    heading(side, "tip orbits of the front row, side and top view; dots at equal times")
    draw_phase_map(figure.add_axes([0.625, 0.085, 0.17, 0.34]), turn, phase)
    draw_strokes(figure.add_axes([0.825, 0.085, 0.165, 0.34]), turn, row, colours)

    figure.text(0.02, 0.955, figures["title"].replace(" x ", " × "), color=INK, fontsize=16, va="center")
    figure.text(0.02, 0.912, summary(figures), color=QUIET, fontsize=10.5, va="center")
    figure.savefig(path, dpi=105, pil_kwargs={"optimize": True})
    plt.close(figure)


def draw_phases(path, turn, figures, a, at):
    """Map of the phases over a lattice with holes."""
    phase = phase_at(a, turn.time[0] + at * abs(turn.period), turn.period)
    cell = np.rint((turn.origin[:, :2] - turn.origin[:, :2].min(axis=0)) / beat.spacing_of(turn.origin)).astype(int)
    image = np.ones((cell[:, 1].max() + 1, cell[:, 0].max() + 1, 4))
    image[cell[:, 1], cell[:, 0]] = np.where(np.abs(a)[:, None] > beat.STILL, CIRCLE(phase), 0.85)
    width, height = 14.0, 14.0 * image.shape[0] / image.shape[1] * 0.96 + 1.5
    figure = plt.figure(figsize=(width, height), facecolor="white")
    axes = figure.add_axes([0.02, 0.85 / height, 0.96, 1 - 1.5 / height])
    axes.imshow(image, origin="lower", interpolation="nearest")
    axes.set_axis_off()
    figure.text(0.02, 1 - 0.32 / height, figures["title"], color=INK, fontsize=15, va="center")
    colour_bar(figure, [0.36, 0.52 / height, 0.28, 0.12 / height])
    figure.savefig(path, dpi=105, pil_kwargs={"optimize": True})
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="directory of a run's results")
    parser.add_argument("--period", type=float, help="of the field, s, negative where it turns the other way; as in the scene")
    parser.add_argument("--turn", type=float, default=0.5, help="instant of the figures, as share of the last turn")
    arguments = parser.parse_args()

    turn = beat.read_turn(arguments.out, arguments.period or beat.period_of(arguments.out))
    figures = beat.measure(turn)
    print(beat.table(figures))
    (arguments.out / "beat.json").write_text(json.dumps(figures, indent=2) + "\n")

    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    a = beat.fundamental(turn)
    if any(arguments.out.glob("trajectory_*.h5")):
        draw_carpet(arguments.out / "carpet.png", turn, figures, a, arguments.out, arguments.turn)
    else:
        draw_phases(arguments.out / "phase.png", turn, figures, a, arguments.turn)


if __name__ == "__main__":
    needs.in_words(main)
