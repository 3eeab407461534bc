"""Flow along plates that swing, or between plates under an acceleration that swings, against its closed form: plot.py draws these where
a scene has a `frequency`, walls across one direction and periods across the others.

u is the real part of exp(i w t) (U0 sinh(k (H - s)) + U1 sinh(k s)) / sinh(k H) + a / (i w) (1 - (sinh(k (H - s)) + sinh(k s)) / sinh(k H)))
with k^2 = i w / nu, a distance s from the lower wall. What a start adds to it decays.
"""

import json

import matplotlib.pyplot as plt
import numpy as np

from skein.own_file import OwnFile
from skein.style import INK, bare

BOUNDS = ("along_x", "along_y", "along_z")


def read_plates(directory):
    """Drive, height and direction of a scene with plates; None where it has none."""
    fluid = json.loads((directory / "physics.json").read_text())["fluid"]
    bounds = [fluid[bound] for bound in BOUNDS]
    if fluid["frequency"] == 0 or bounds.count("no_slip") != 1 or bounds.count("periodic") != 2:
        return None
    across = bounds.index("no_slip")
    drive = np.array([fluid[name] for name in ("lower_wall_velocity", "upper_wall_velocity", "acceleration")])
    stream = int(np.argmax(np.abs(np.delete(drive, across, axis=1)).max(axis=0)))  # the first of the two where both are driven
    stream += stream >= across
    return {"across": across, "stream": stream, "drive": drive[:, stream], "height": fluid["spacing"] * fluid["cells"][across],
            "omega": 2 * np.pi * fluid["frequency"], "nu": fluid["viscosity"] / fluid["density"]}


def exact(plates, place, time):
    lower, upper, acceleration = plates["drive"]
    omega, height = plates["omega"], plates["height"]
    k = np.sqrt(1j * omega / plates["nu"])

    def share(distance):  # sinh(k distance) / sinh(k height), where both may be beyond all numbers
        return np.exp(k * (distance - height)) * -np.expm1(-2 * k * distance) / -np.expm1(-2 * k * height)

    below, above = share(height - place), share(place)
    return (np.exp(1j * omega * time) * (lower * below + upper * above + acceleration / (1j * omega) * (1 - below - above))).real


def profile(path, plates):
    """Time, places across the plates and mean velocity along them there, least and largest of which are the same but for rounding."""
    with OwnFile(path) as file:
        velocity, spacing, time = file["velocity"][..., plates["stream"]].astype(float), file.attrs["spacing"], file.attrs["time"]
    rest = tuple(axis for axis in range(3) if axis != 2 - plates["across"])
    mean = velocity.mean(axis=rest)
    return time, spacing * (np.arange(len(mean)) + 0.5), mean


def draw_plates(files, plates, to):
    """Profiles of the last period."""
    profiles = [profile(path, plates) for path in files]
    end, period = profiles[-1][0], 2 * np.pi / plates["omega"]
    last = [one for one in profiles if one[0] > end - 0.999 * period]
    figure, axes = plt.subplots(figsize=(5, 4), constrained_layout=True)
    fine = np.linspace(0, plates["height"], 400)
    for number, (time, place, velocity) in enumerate(last):
        axes.plot(exact(plates, fine, time), fine, lw=1, color=INK, label="closed form" if number == 0 else None)
        axes.plot(velocity, place, "o", ms=3, label=f"t = {time:.4g} s")
    axes.set_xlabel(f"velocity along {'xyz'[plates['stream']]} [m/s]"), axes.set_ylabel(f"{'xyz'[plates['across']]} over the lower wall [m]")
    axes.legend(frameon=False, fontsize="small")
    bare(axes, "left", "bottom")
    figure.savefig(to, dpi=150)
    most = max(np.abs(exact(plates, fine, time)).max() for time, _, _ in last)
    error = max(np.abs(velocity - exact(plates, place, time)).max() for time, place, velocity in last)
    print(f"largest error of the velocity in the last period {error / most:.3%} of the largest velocity")
