#!/usr/bin/env python3
"""Picture of a modulus from a picture: plot_sag.py [--to FILE]

Fits E to the points of sag.csv and draws them beside the hair with this modulus, and with half and twice of it. Needs numpy, h5py and matplotlib.
"""

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "python"))
from skein import needs  # noqa: E402  (of the checkout, as all of skein here)

needs.need("numpy", "h5py", "matplotlib")
import matplotlib  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of Agg)

import skein  # noqa: E402
from skein.style import INK, bare  # noqa: E402

KEY = "rods.hair.material.youngs_modulus"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--to", type=Path, default=Path("sag.png"), help="picture to write; default: sag.png")
    to = parser.parse_args().to
    points = skein.read_centrelines(HERE / "sag.csv", unit=1e-3)[0][0]
    found = skein.fit(HERE / "sag.toml", {"x": points[:, 0], "z": points[:, 2]}, KEY)
    modulus, half = found.values[KEY], found.half_widths[KEY]

    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans"})
    figure, axes = plt.subplots(figsize=(7.2, 3.2), facecolor="white")
    for times, colour in ((0.5, "#bbbbbb"), (2, "#bbbbbb"), (1, "#b5452c")):
        hair = 1e3 * skein.equilibrium(HERE / "sag.toml", **{KEY: times * modulus}).positions["hair"][0]
        label = f"E = {1e-9 * modulus:.2f} ± {1e-9 * half:.2f} GPa" if times == 1 else "half and twice of E" if times == 2 else None
        axes.plot(hair[:, 0], hair[:, 2], color=colour, linewidth=1.4, label=label)
    axes.plot(1e3 * points[:, 0], 1e3 * points[:, 2], ".", color="#2b6777", markersize=3.5, label="points of the picture")
    axes.set(xlabel="x [mm]", ylabel="z [mm]", aspect="equal")
    axes.legend(frameon=False, labelcolor=INK, loc="lower left")
    bare(axes, "left", "bottom")
    figure.savefig(to, dpi=130, bbox_inches="tight")
    print(to)


if __name__ == "__main__":
    main()
