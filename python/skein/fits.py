"""skein.fit finds numbers of a scene from measurements at rest, skein.gradient the slopes of observables by numbers (docs/equilibria.md)."""

import csv
import json
import math
import subprocess
import tempfile
from pathlib import Path

from .program import RunFailed, as_file, command, environment


class Fit:
    """Numbers of a scene that fit measurements best.

    values        {path of the number: value}, and their `units`
    half_widths   {path: half the width of the interval of 95 %}; infinite of a number that is not determined and was kept
    misfits       {"places" or observable: root mean square of what is left}, in the units of the data
    figures       all that `skein fit --json` prints
    """

    def __init__(self, figures):
        self.figures = figures
        self.values, self.half_widths, self.units = ({one["key"]: one[name] for one in figures["numbers"]} for name in ("value", "half_width_95", "unit"))
        self.half_widths = {key: math.inf if width is None else width for key, width in self.half_widths.items()}
        self.misfits = figures["misfits"]

    def __getitem__(self, key):
        """The value of the number under this path."""
        return self.values[key]

    def interval(self, key):
        """(lowest, highest) of the interval of 95 %."""
        return self.values[key] - self.half_widths[key], self.values[key] + self.half_widths[key]

    def __repr__(self):
        numbers = (f"{key} = {value:.6g} +- {self.half_widths[key]:.2g} {self.units[key]}".rstrip(" -") for key, value in self.values.items())
        return f"<Fit: {', '.join(numbers)}>"


def fit(scene, data, numbers, rods=None, keep_undetermined=False, time=None, threads=None, **keys):
    """Finds numbers of a scene, a file, TOML text or a skein.Scene, from measurements at rest. data: a CSV file, or {column: values}, with s, x, y, z of places on a
    rod, keys of the scene that a row was measured with, and observables; numbers: paths of the numbers to find; rods: group whose first rod the shape is of;
    keep_undetermined: what the data do not determine stays as it is in the scene; time [s]: of loads and ends, else the scene's end. Keys of the scene by their path, as in skein.run. Raises RunFailed if the data do not determine the numbers."""
    words = [word for number in ([numbers] if isinstance(numbers, str) else numbers) for word in ("--number", number)]
    words += ["--keep-undetermined"] * bool(keep_undetermined)
    for name, value in (("--rods", rods), ("--time", time), ("--threads", threads)):
        words += [] if value is None else [name, value]
    with as_file(scene) as file, tempfile.TemporaryDirectory(prefix="skein_") as folder:
        table = _written(data, Path(folder) / "data.csv") if isinstance(data, dict) else Path(data)
        return Fit(_answer("fit", file, keys, [*words, table]))


class Gradient:
    """Slopes of observables at an equilibrium by numbers of the scene.

    values        {observable: value}, and their `units`
    slopes        {path of the number: {observable: slope}}, per unit of the number
    figures       all that `skein gradient --json` prints
    """

    def __init__(self, figures):
        self.figures = figures
        heading = {name: name.partition("[")[0] for name in figures["values"]}
        self.values = {heading[name]: value for name, value in figures["values"].items()}
        self.units = {heading[name]: name.partition("[")[2].rstrip("]") for name in figures["values"]}
        self.slopes = {one["key"]: {heading[name]: slope for name, slope in one["slopes"].items()} for one in figures["numbers"]}

    def __getitem__(self, key):
        """{observable: slope} by the number under this path."""
        return self.slopes[key]

    def __repr__(self):
        return f"<Gradient of {len(self.values)} observables by {', '.join(self.slopes)}>"


def gradient(scene, by, of=(), time=None, threads=None, **keys):
    """Finds the slopes of observables at the equilibrium of a scene by numbers of it. by: paths of the numbers; of: observables, else all: each takes one adjoint
    solution for any number of numbers; time [s]: of loads and ends, else the scene's end. Keys of the scene by their path, as in skein.run."""
    words = [word for option, names in (("--by", by), ("--of", of)) for name in ([names] if isinstance(names, str) else names) for word in (option, name)]
    for name, value in (("--time", time), ("--threads", threads)):
        words += [] if value is None else [name, value]
    with as_file(scene) as file:
        return Gradient(_answer("gradient", file, keys, words))


def _answer(what, file, keys, words):
    """What a command prints as JSON."""
    done = subprocess.run(command(what, file, keys, *words, "--json"), capture_output=True, text=True, env=environment())
    if done.returncode:
        said = done.stderr.strip()
        raise RunFailed(said[max(said.find("error: "), 0):] or f"skein {what} ended with code {done.returncode}", done.returncode)
    return json.loads(done.stdout)


def _written(columns, file):
    """The table of columns as a file; shorter columns are refused."""
    with file.open("w", newline="") as text:
        rows = csv.writer(text)
        rows.writerow(columns)
        rows.writerows([repr(float(value)) for value in row] for row in zip(*columns.values(), strict=True))
    return file
