"""Figures of solutions for skein plot: observables along a path of equilibria, frequencies of modes."""

import json

import numpy as np

from .columns import NUMBER, OF_POINT
from .own_file import OwnFile
from .needs import NotResults, reading
from .results import open as open_results
from .style import INK, QUIET, bare

MARKS = {"limit": ("o", "limit point"), "branch": ("D", "branch point")}
WORDS = {True: "stable", False: "unstable", None: "stability not known"}
LINES = {"stable": "-", "unstable": (0, (4, 2.2)), "stability not known": (0, (1, 1.5))}


def drawable(table):
    """Names of the columns of numbers that may be drawn: of a path the number and its observables, of modes all but their own numbers."""
    if table.path.name == "path.csv":
        return [list(table)[NUMBER], "length", "residual", *list(table)[OF_POINT:]]
    return [name for name in ("frequency", "decay", "damping_ratio", "eigenvalue", "residual") if name in table]


def grown(table):
    """Modes that grow, by more than round-off if they swing as well."""
    return (table["eigenvalue"] < 0) | (table["damping_ratio"] < -1e-7 if "damping_ratio" in table else False)


def most_moved(directory, table):
    """The column of the first probe's unit that changes most, of probes; without probes, of the centre of mass."""
    observables = list(table)[OF_POINT:]
    probes = _probes(directory)
    of_probes = [name for name in observables if any(name == probe or name.startswith(f"{probe}_") for probe in probes)]
    names = of_probes or [name for name in observables if name.startswith("centre_")] or observables
    if not names:
        raise NotResults(f"{directory}: path.csv has no observables; add a [[probe]] to the scene")
    names = [name for name in names if table.units[name] == table.units[names[0]]]
    return max(names, key=lambda name: np.ptp(table[name]))


def _probes(directory):
    """Names of the scene's probes, which its newest checkpoint keeps."""
    results = open_results(directory)
    if not results.checkpoints:
        return []
    with OwnFile(results.directory / f"checkpoint_{results.checkpoints[-1]:012d}.h5") as file, reading(file.path):
        return [probe["name"] for probe in json.loads(file.attrs["settings"]).get("probe", [])]


def _axes(table, names, against, log):
    from matplotlib import pyplot
    units = list(dict.fromkeys(table.units[name] for name in names))
    figure, axes = pyplot.subplots(len(units), 1, figsize=(7, 3.2 * len(units) + 0.6), sharex=True, squeeze=False, layout="constrained")
    for axis, unit in zip(axes[:, 0], units):
        own = [name for name in names if table.units[name] == unit]
        axis.set_ylabel(f"{own[0] if len(own) == 1 else 'values'} [{unit or '-'}]", color=INK)
        if log: axis.set_yscale("log")
        bare(axis, "left", "bottom")
    axes[-1, 0].set_xlabel(f"{against} [{table.units[against] or '-'}]", color=INK)
    return figure, {name: axes[units.index(table.units[name]), 0] for name in names}


def _label(name, out, runs):
    return name if len(runs) == 1 else f"{name}, {out}"


def draw_paths(runs, names, against, log):
    """Columns of paths over a column, {out: table}: stable parts as lines, others dashed, with marks at limit and branch points."""
    from matplotlib.lines import Line2D
    first = next(iter(runs.values()))
    against = against or list(first)[NUMBER]
    figure, axis_of = _axes(first, names, against, log)
    seen = set()
    for k, (name, out) in enumerate((name, out) for name in names for out in runs):
        table, axis, colour = runs[out], axis_of[name], f"C{k}"
        x, y = table[against], table[name]
        unknown = bool((table["negative"] < 0).any())
        for begin, end, stable in [(0, len(x) - 1, None)] if unknown else parts(table["place"], table["negative"] == 0):
            axis.plot(x[begin:end + 1], y[begin:end + 1], color=colour, lw=1.4, ls=LINES[WORDS[stable]], label="_")
            seen.add(WORDS[stable])
        for place, (marker, words) in MARKS.items():
            at = table["place"] == place
            if at.any():
                axis.plot(x[at], y[at], marker, color=colour, mfc="white", ms=6, mew=1.3, zorder=3, label="_")
                seen.add(words)
        axis.plot([], [], color=colour, lw=1.4, label=_label(name, out, runs))
    kinds = {words: {"ls": line} for words, line in LINES.items()} | {words: {"ls": "", "marker": marker, "mfc": "white", "ms": 6, "mew": 1.3} for marker, words in MARKS.values()}
    handles = [Line2D([], [], color=QUIET, lw=1.4, label=words, **look) for words, look in kinds.items() if words in seen]
    for number, axis in enumerate(dict.fromkeys(axis_of.values())):
        own = axis.get_legend_handles_labels()[0]
        axis.legend(handles=[*(own if len(own) > 1 else []), *(handles if number == 0 else [])], frameon=False, fontsize=8)
    return figure


def parts(place, stable):
    """[(first point, last point, whether stable)], each from the last point of the one before. Between two points a path is as stable as the point that is neither
    a limit nor a branch point, where stability changes."""
    found = []
    for k in range(len(place) - 1):
        critical = place[k] in MARKS, place[k + 1] in MARKS
        here = stable[k] if critical == (False, True) else stable[k + 1] if critical[0] else stable[k] and stable[k + 1]
        if found and found[-1][2] == here:
            found[-1] = (found[-1][0], k + 1, here)
        else:
            found.append((k, k + 1, here))
    return [(begin, end, bool(here)) for begin, end, here in found]


def draw_modes(runs, names, against, log):
    """Columns of modes over their numbers, {out: table}, without neutral motions; those that grow have hollow heads."""
    first = next(iter(runs.values()))
    against = against or "mode"
    figure, axis_of = _axes(first, names, against, log)
    for name, axis in axis_of.items():
        for k, (out, table) in enumerate(runs.items()):
            swings = table["neutral"] == 0
            x, y, grows = table[against][swings], table[name][swings], grown(table)[swings]
            x = x + (0.12 * (k - (len(runs) - 1) / 2) if against == "mode" else 0.0)
            axis.vlines(x, 0 if not log else np.min(y[y > 0], initial=np.inf) / 2, y, color=f"C{k}", lw=1.4)
            axis.plot(x[~grows], y[~grows], "o", color=f"C{k}", ms=6, label=_label(name, out, runs))
            if grows.any():
                axis.plot(x[grows], y[grows], "o", color=f"C{k}", mfc="white", ms=6, mew=1.3, label=_label("grows", out, runs))
        if not log: axis.axhline(0, color=QUIET, lw=0.8, zorder=0)
        if len(axis.get_legend_handles_labels()[0]) > 1: axis.legend(frameon=False, fontsize=8)
    if against == "mode": axis.xaxis.get_major_locator().set_params(integer=True)
    return figure
