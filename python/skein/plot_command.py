"""skein plot: columns of observables.csv over time, of path.csv along a path of equilibria, of modes.csv; of one run or several."""

import json
from fnmatch import fnmatchcase
from pathlib import Path

from .needs import NotResults, in_words, need
from .parser import Parser

FORMATS = (".png", ".svg", ".pdf")
FEW_ROWS = 10  # a line through fewer is hard to see: a relaxation has one or two


def parser():
    p = Parser(prog="skein plot", takes="directories of results", description="Plots columns of observables.csv over time, one axis for each unit. Of the results of skein path: "
               "columns of path.csv over the number, unstable parts dashed. Of skein modes: the frequencies.",
               epilog="examples: skein plot out/net | skein plot out/coarse out/fine --columns 'tip_*' | skein plot out/net --list | skein plot out/column_path --columns tip_x")
    p.add_argument("out", nargs="+", type=Path, metavar="OUT", help="directory of a run's results; several are drawn over each other")
    p.add_argument("--columns", nargs="+", metavar="NAME", help="columns, without units; * and ? match parts of names; default: all in joule, else all; of a path, of its probes the one that changes most")
    p.add_argument("--against", metavar="NAME", help="column of the horizontal axis; default: time, or the number along a path, or the number of a mode")
    p.add_argument("--log", action="store_true", help="a logarithmic vertical axis")
    p.add_argument("--to", type=Path, metavar="FILE", help="picture to write, .png, .svg or .pdf; default: OUT/series.png, OUT/path.png, OUT/modes.png")
    p.add_argument("--list", action="store_true", help="print the columns, their units and last numbers, and plot nothing")
    p.add_argument("--json", action="store_true", help="with --list: as JSON")
    return p


def main(words=None):
    in_words(lambda: _plot(parser().parse_args(words)), code=2, code_of_damage=5)


def _plot(given):
    need("numpy", "h5py", "matplotlib")
    kind, runs = _opened(given.out)
    first = runs[given.out[0]]
    if given.list or given.json:
        print(_listed(first, given.json))
        return
    to = given.to or given.out[0] / f"{kind}.png"
    if to.suffix not in FORMATS:
        raise NotResults(f"{to}: a picture is one of {', '.join(FORMATS)}")
    if given.against: _numbers(first, given.against)
    import matplotlib
    matplotlib.use("Agg")
    if kind == "series":
        _save(_draw(runs, _chosen(first, given.columns), given.against or "time", given.log), to)
    else:
        from .solution_plots import draw_modes, draw_paths, drawable, most_moved
        names = _matching(first, drawable(first), given.columns) if given.columns else [most_moved(given.out[0], first) if kind == "path" else "frequency"]
        _save((draw_paths if kind == "path" else draw_modes)(runs, names, given.against, given.log), to)
    print(to)


def _opened(directories):
    """What kind of results they are, and the columns of each: {out: table}."""
    from .columns import modes_columns, path_columns
    from .results import open as open_results
    kinds = {out: next((kind for kind in ("path", "modes") if (out / f"{kind}.csv").exists()), "series") for out in directories}
    kind = kinds[directories[0]]
    for out, other in kinds.items():
        if other != kind and out.is_dir():
            raise NotResults(f"{out}: no {kind if kind != 'series' else 'observables'}.csv alone; results of one kind are drawn over each other")
    read = {"path": path_columns, "modes": modes_columns, "series": lambda out: open_results(out).series}[kind]
    return kind, {out: read(out) for out in directories}


def _listed(series, as_json):
    rows = [{"column": name, "unit": series.units[name], "last": float(values[-1])} for name, values in series.items() if values.dtype.kind != "U"]
    if as_json:
        return json.dumps(rows, indent=2)
    width = max(len(row["column"]) for row in rows)
    return "\n".join(f"{row['column']:<{width}}  {row['unit']:<8} {row['last']:.6g}" for row in rows)


def _chosen(series, patterns):
    others = [name for name in series if name not in ("step", "time")]
    if not patterns:
        return [name for name in others if series.units[name] == "J"] or others
    return _matching(series, others, patterns)


def _numbers(series, name):
    """Raises NotResults unless it is a column of numbers."""
    if series[name].dtype.kind == "U":
        raise NotResults(f"the column {name} has words in place of numbers, which cannot be plotted")


def _matching(series, others, patterns):
    """Of `others`, the columns that match any of the patterns."""
    names = []
    for pattern in patterns:
        found = [name for name in others if fnmatchcase(name, pattern)]
        if not found:
            _numbers(series, pattern)  # a heading with its unit, the time or a step
            found = [pattern.split("[")[0]]
        names += [name for name in found if name not in names]
    return names


def _draw(runs, names, against, log):
    from matplotlib import pyplot

    from .style import INK, bare
    first = next(iter(runs.values()))
    units = list(dict.fromkeys(first.units[name] for name in names))
    figure, axes = pyplot.subplots(len(units), 1, figsize=(7, 2.6 * len(units) + 0.4), sharex=True, squeeze=False, layout="constrained")
    for axis, unit in zip(axes[:, 0], units):
        for name in (name for name in names if first.units[name] == unit):
            for out, series in runs.items():
                axis.plot(series[against], series[name], lw=1.2, marker="o" if len(series[name]) < FEW_ROWS else None, ms=4, label=name if len(runs) == 1 else f"{name}, {out}")
        axis.set_ylabel(unit or "-", color=INK)
        if log: axis.set_yscale("log")
        bare(axis, "left", "bottom")
        axis.legend(frameon=False, fontsize=8)
    axes[-1, 0].set_xlabel(f"{against} [{first.units[against] or '-'}]", color=INK)
    return figure


def _save(figure, to):
    """A file appears whole."""
    from matplotlib import pyplot
    part = to.with_name(f"part_{to.name}")
    figure.savefig(part, dpi=150)
    part.replace(to)
    pyplot.close(figure)
