"""Bodies at rest: skein.equilibrium, skein.modes and skein.path solve a scene in place of stepping it (docs/equilibria.md)."""

import json
import subprocess
import tempfile
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from .columns import NUMBER, OF_POINT, modes_columns, path_columns, slope_columns
from .program import RunFailed, as_file, command, environment
from .results import open as open_results

UNSTABLE = 10  # exit code of `skein equilibrium --stable`
FULL_SWING = 6  # frame of a mode's movie with the largest displacement


class Solution:
    """Bodies at rest.

    directory     of the results; None if it was temporary
    positions     {group: [rods, nodes, 3]} m, double precision; bodies [bodies, 1, 3]
    directors     {group: [rods, elements, 3, 3]}, rows d1, d2, d3
    observables   {name: value}, and their `units`
    """

    def __init__(self, directory, kept):
        results = open_results(directory)
        state = results.state()
        self.directory = Path(directory) if kept else None
        self.title = results.title
        self.positions = {name: group["position"] for name, group in state.items()}
        self.directors = {name: _axes(group["quaternion"]) for name, group in state.items()}
        split = {heading: heading.rstrip("]").split("[") for heading in results.summary.get("observables", {})}
        self.observables = {name: results.summary["observables"][heading] for heading, (name, *_) in split.items()}
        self.units = {name: unit[0] if unit else "" for name, *unit in split.values()}

    def __getitem__(self, name):
        """The observable of this name."""
        return _named(self.observables, name)


class Equilibrium(Solution):
    """Where the bodies of a scene are at rest.

    residual      largest force that is out of balance, over the acting forces
    load_steps    most of a piece; `iterations`: of Newton's method, most of a piece
    pieces        rods, or copies of assemblies, that are solved each alone; `unstable`: how many are; `unknown`: of how many it is not known
    neutral       motions that change no load
    stable        None if no piece is unstable, but the loads of some have no potential, so that it is not known
    figures       all that `skein equilibrium --json` prints
    """

    def __init__(self, directory, kept, figures):
        super().__init__(directory, kept)
        self.figures = figures
        self.residual, self.iterations, self.load_steps = figures["residual"], figures["iterations"], figures["load_steps"]
        self.pieces, self.unstable, self.neutral = figures["pieces"], figures["unstable_pieces"], figures["neutral_motions"]
        self.unknown = figures["unknown_stability"]
        self.stable = self.unstable == 0 if self.unstable or not self.unknown else None

    def __repr__(self):
        words = {True: "stable", False: f"unstable, {self.unstable} of {self.pieces} pieces", None: "stability not known"}[self.stable]
        return f"<Equilibrium {self.title!r}: {words}, {self.neutral} neutral motions, residual {self.residual:.2g}>"


class Modes(Solution):
    """Small motions about an equilibrium, exp(lambda t), the slowest first.

    frequencies   [modes] Hz; 0 if the motion is overdamped; without damping negative if it grows in place of swinging
    decays        [modes] 1/s: -Re lambda, negative if the motion grows
    damping_ratios  [modes]: the decay over |lambda|
    eigenvalues   [modes] 1/s^2: squares of the angular frequencies, negative if the motion grows; with damping |lambda|^2
    residuals     [modes], of the eigenvalue problem
    names         [modes], rod or assembly that moves
    neutral       motions that change no load: of frequency 0, and not among the modes
    shapes        of the first `movies` modes: [{group: [rods, nodes, 3]}] m, displacements at the largest swing
    """

    def __init__(self, directory, kept):
        super().__init__(directory, kept)
        table = modes_columns(directory)
        swinging = table["neutral"] == 0
        self.neutral = int(np.sum(~swinging))
        self.frequencies, self.eigenvalues, self.residuals = (table[name][swinging] for name in ("frequency", "eigenvalue", "residual"))
        self.decays, self.damping_ratios = table["decay"][swinging], table["damping_ratio"][swinging]
        self.names = list(table["of"][swinging])
        folders = sorted(Path(directory).glob("mode_*"), key=lambda folder: int(folder.name.partition("_")[2]))
        self.shapes = [{name: group.position[FULL_SWING] - self.positions[name] for name, group in open_results(folder).groups.items()} for folder in folders]

    def __repr__(self):
        return f"<Modes of {self.title!r}: {', '.join(f'{frequency:.6g}' for frequency in self.frequencies)} Hz, {self.neutral} neutral motions>"


class PathOfEquilibria:
    """Equilibria along a number of the scene, in their order along the path.

    key           path of the number; `unit`: of its values
    value         [points], of the number
    length        [points], of arc along the path
    place         [points]: "regular", "limit", "branch" or "end"
    branch        [points]: 0 until the path leaves for another branch
    negative      [points]: directions in which the energy falls; -1: not known
    stable        [points] of bool, False where it is not known
    observables   {name: [points]}, and their `units`
    limits        values of the number at the limit points; `branches`: at the branch points
    slopes        {key: {name: [points]}} of observables by the numbers in `by`, at a fixed value of the path's number; empty if none were asked for
    limit_slopes  {key: [limit points]} of the path's number there, by these numbers; `branch_slopes`: [branch points]. NaN if there is none
    complete      whether the path has come to its end, and has not been cut off or failed to go farther
    positions     {group: [points, rods, nodes, 3]} m, single precision
    directors     {group: [points, rods, elements, 3, 3]}
    """

    def __init__(self, directory, kept):
        table = path_columns(directory)
        results = open_results(directory)
        self.directory = Path(directory) if kept else None
        self.title = results.title
        self.key = list(table)[NUMBER]
        self.unit = table.units[self.key]
        self.value, self.length, self.residual = table[self.key], table["length"], table["residual"]
        self.place, self.branch, self.negative = table["place"], table["branch"], table["negative"]
        self.stable = self.negative == 0
        self.observables = {name: table[name] for name in list(table)[OF_POINT:]}
        self.units = {name: table.units[name] for name in self.observables}
        self.limits, self.branches = (self.value[self.place == place] for place in ("limit", "branch"))
        self.slopes, self.limit_slopes, self.branch_slopes = _slopes_along(directory)
        self.complete = bool(len(self.place) and self.place[-1] == "end")
        self.positions, self.directors = (_frames(results, name, len(self.value)) for name in ("position", "directors"))

    def __len__(self):
        return len(self.value)

    def __getitem__(self, name):
        """[points] of the observable of this name."""
        return _named(self.observables, name)

    def __repr__(self):
        unit = f" {self.unit}" if self.unit else ""
        ends = f" from {self.value[0]:.6g} to {self.value[-1]:.6g}{unit}" if len(self) else ""
        return f"<PathOfEquilibria {self.title!r} along {self.key}: {len(self)} points{ends}, {len(self.limits)} limit points, {len(self.branches)} branch points>"


def equilibrium(scene, time=None, stable=False, out=None, overwrite=False, threads=None, **keys):
    """Finds where the bodies of a scene are at rest, by Newton's method: a file, TOML text or a skein.Scene. time [s]: of loads and ends, else the scene's
    end; stable: an equilibrium that is unstable, or not known to be stable, raises RunFailed; out: directory of results, else a temporary one. Keys of the scene by their path, as in
    skein.run."""
    words = [*_option("--time", time), *["--stable"] * bool(stable)]
    with _solved("equilibrium", scene, out, overwrite, threads, keys, [*words, "--json"], (0, UNSTABLE)) as (directory, done):
        found = Equilibrium(directory, out is not None, json.loads(done.stdout))
    if done.returncode == UNSTABLE:
        raise RunFailed(_error(done, "equilibrium"), UNSTABLE)
    return found


def modes(scene, count=10, time=None, movies=0, amplitude=None, undamped=False, out=None, overwrite=False, threads=None, **keys):
    """Finds the equilibrium of a scene, and the `count` slowest small motions about it. movies: how many of them have shapes, and are written as runs mode_1,
    mode_2, ... in `out`, to draw; amplitude: of these, over the length of a rod; undamped: leaves out what damps, and gyroscopic couples."""
    words = ["--count", count, *_option("--time", time), *_option("--movies", movies or None), *_option("--amplitude", amplitude), *["--undamped"] * bool(undamped)]
    with _solved("modes", scene, out, overwrite, threads, keys, words) as (directory, _):
        return Modes(directory, out is not None)


def path(scene, along, to, from_=None, step=None, points=None, branch=0, by=(), of=(), time=None, out=None, overwrite=False, restart=False, threads=None, **keys):
    """Follows the equilibria of a scene while the number `along`, the path of a key such as "load.0.end.2", goes from `from_`, else its value in the scene,
    to `to`, and round limit points. step: the largest, of arc; points: the most; branch: 1 or -1 leaves the path at its first branch point, to that side.
    by: a number of the scene, or several, by which the path has slopes; of: an observable for them, or several, else all.
    restart: goes on with the path in `out`, which was stopped or has used up its points."""
    words = ["--along", along, "--to", repr(float(to)), *_option("--from", None if from_ is None else float(from_)), *_option("--step", step), *_option("--points", points),
             *_option("--branch", branch or None), *_repeated("--by", by), *_repeated("--of", of), *_option("--time", time), *["--restart"] * bool(restart)]
    keys = {"output.directors": True, **keys}
    with _solved("path", scene, out, overwrite, threads, keys, words, goes_on=restart) as (directory, _):
        return PathOfEquilibria(directory, out is not None)


def _slopes_along(directory):
    """Slopes at points by key and observable, and those of the path's number at limit and at branch points by key."""
    found = slope_columns(directory)
    if found is None:
        return {}, {}, {}
    at_points, critical = found
    slopes = {}
    for heading in list(at_points)[3:]:  # after point, branch and number
        name, number = heading[2:-1].split(")/d(", 1)
        slopes.setdefault(number, {})[name] = at_points[heading]
    of_number = {heading[2:-1].split(")/d(", 1)[1]: critical[heading] for heading in list(critical)[4:]}
    return slopes, *({number: values[critical["place"] == place] for number, values in of_number.items()} for place in ("limit", "branch"))


def _repeated(name, values):
    return [word for value in ([values] if isinstance(values, str) else values) for word in (name, value)]


def _option(name, value):
    return [] if value is None else [name, value]


@contextmanager
def _solved(what, scene, out, overwrite, threads, keys, words, good=(0,), goes_on=False):
    """Directory of results and the ended program; a temporary directory goes at the end."""
    if out is not None and not overwrite and not goes_on and (Path(out) / "physics.json").exists():
        raise FileExistsError(f"{out} holds results; give overwrite=True or another `out`")
    with tempfile.TemporaryDirectory(prefix="skein_") as folder, as_file(scene) as file:
        directory = Path(out) if out is not None else Path(folder) / "out"
        words = [*words, "--out", directory, *_option("--threads", threads), *["--overwrite"] * bool(overwrite)]
        done = subprocess.run(command(what, file, keys, *words), capture_output=True, text=True, env=environment())
        if done.returncode not in good:
            raise RunFailed(_error(done, what), done.returncode)
        yield directory, done


def _error(done, what):
    """The program's message, which ends what it says, without the text on the solution before it."""
    at = done.stderr.find("error: ")
    return done.stderr[max(at, 0):].strip() or f"skein {what} ended with code {done.returncode}"


def _named(values, name):
    if name not in values:
        guess = get_close_matches(name, values, 1)
        raise KeyError(f"no observable '{name}'" + (f"; did you mean '{guess[0]}'?" if guess else f"; there are {', '.join(values)}"))
    return values[name]


def _axes(quaternion):
    """[..., 3, 3] rows d1, d2, d3 of quaternions w, x, y, z."""
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _frames(results, name, points):
    """{group: [points, ...]}: a frame for each point, after the scene's own."""
    return {group.name: getattr(group, name)[1:points + 1] for group in results.groups.values() if results.frames.has(group.name, name)}
