"""Drag of a cubic array of spheres against what is published of it: plot.py draws it where one sphere rests in a cube of periods.

K = F / (6 pi mu r U) of the force F on the sphere and the mean velocity U of the whole cube, the sphere in it.
"""

import json

import matplotlib.pyplot as plt
import numpy as np

from skein.style import INK, bare

SEEN = "#c8502d"
# Zick and Homsy 1982, table 2: share of the spheres, K.
PUBLISHED = {0.027: 2.008, 0.064: 2.810, 0.125: 4.292, 0.216: 7.442, 0.343: 15.4, 0.45: 28.1, 0.5236: 42.1}


def read_array(directory):
    """Fluid and obstacle of the scene, and the share of spheres; None where it is no array."""
    scene = json.loads((directory / "physics.json").read_text())
    fluid, obstacles = scene["fluid"], scene.get("obstacle", [])
    if len(obstacles) != 1 or obstacles[0]["kind"] != "sphere" or np.any(obstacles[0]["velocity"]) or obstacles[0]["frequency"] > 0:
        return None
    if {fluid[f"along_{d}"] for d in "xyz"} != {"periodic"} or len(set(fluid["cells"])) != 1 or not np.any(fluid["acceleration"]):
        return None
    edge = fluid["cells"][0] * fluid["spacing"]
    return {"edge": edge, "share": 4 / 3 * np.pi * (obstacles[0]["radius"] / edge) ** 3} | fluid | {"obstacle": obstacles[0]}


def draw_drag(series, array, to):
    volume, sphere = array["edge"] ** 3, array["obstacle"]
    drive = np.array(array["acceleration"])
    along = drive / np.linalg.norm(drive)
    force = sum(a * series[f"{sphere['name']}_force_{d}"] for a, d in zip(along, "xyz"))
    speed = sum(a * series[f"fluid_momentum_{d}"] for a, d in zip(along, "xyz")) / (array["density"] * volume)
    factor = force[1:] / (6 * np.pi * array["viscosity"] * sphere["radius"] * speed[1:])
    published = next((k for share, k in PUBLISHED.items() if abs(share - array["share"]) < 1e-4 + 1e-3 * share), None)
    figure, axes = plt.subplots(figsize=(6, 4), constrained_layout=True)
    axes.plot(series["time"][1:], factor, color=SEEN, label="drag factor")
    if published:
        axes.axhline(published, lw=1, ls="--", color=INK, label="Zick and Homsy 1982")
        axes.legend(frameon=False)
    axes.set_xlabel("time [s]"), axes.set_ylabel("$F / (6 \\pi \\mu r U)$")
    bare(axes, "left", "bottom")
    figure.savefig(to, dpi=150)
    text = f"drag factor at the end {factor[-1]:.5g} at a share of spheres of {array['share']:.4g}, Re = {speed[-1] * 2 * sphere['radius'] * array['density'] / array['viscosity']:.2g}"
    print(text + (f"; published {published:g}, difference {factor[-1] / published - 1:+.2%}" if published else ""))
    print(f"force on the sphere over what drives the cube: {force[-1] / (array['density'] * np.linalg.norm(drive) * volume) - 1:+.1e} more than 1")
