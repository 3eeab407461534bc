"""skein plot: columns of observables.csv over time, of one run or several."""

import json
from fnmatch import fnmatchcase
from pathlib import Path

from .needs import NotResults, in_words, need
from .parser import Parser

FORMATS = (".png", ".svg", ".pdf")
FEW_ROWS = 10  # a line through fewer is hard to see: a relaxation has one or two


def parser():
    p = Parser(prog="skein plot", takes="directories of results", description="Plots columns of observables.csv over time, one axis for each unit.",
               epilog="examples: skein plot out/net | skein plot out/coarse out/fine --columns 'tip_*' | skein plot out/net --list")
    p.add_argument("out", nargs="+", type=Path, metavar="OUT", help="directory of a run's results; several are drawn over each other")
    p.add_argument("--columns", nargs="+", metavar="NAME", help="columns, without units; * and ? match parts of names; default: all in joule, else all")
    p.add_argument("--against", default="time", metavar="NAME", help="column of the horizontal axis; default: time")
    p.add_argument("--log", action="store_true", help="a logarithmic vertical axis")
    p.add_argument("--to", type=Path, metavar="FILE", help="picture to write, .png, .svg or .pdf; default: OUT/series.png")
    p.add_argument("--list", action="store_true", help="print the columns, their units and last numbers, and plot nothing")
    p.add_argument("--json", action="store_true", help="with --list: as JSON")
    return p


def main(words=None):
    in_words(lambda: _plot(parser().parse_args(words)), code=2, code_of_damage=5)


def _plot(given):
    need("numpy", "h5py", "matplotlib")
    from .results import open as open_results
    runs = {out: open_results(out).series for out in given.out}
    if given.list or given.json:
        print(_listed(runs[given.out[0]], given.json))
        return
    first = runs[given.out[0]]
    names = _chosen(first, given.columns)
    to = given.to or given.out[0] / "series.png"
    if to.suffix not in FORMATS:
        raise NotResults(f"{to}: a picture is one of {', '.join(FORMATS)}")
    _draw(runs, names, given.against, given.log, to)
    print(to)


def _listed(series, as_json):
    rows = [{"column": name, "unit": series.units[name], "last": float(values[-1])} for name, values in series.items()]
    if as_json:
        return json.dumps(rows, indent=2)
    width = max(len(row["column"]) for row in rows)
    return "\n".join(f"{row['column']:<{width}}  {row['unit']:<8} {row['last']:.6g}" for row in rows)


def _chosen(series, patterns):
    others = [name for name in series if name not in ("step", "time")]
    if not patterns:
        return [name for name in others if series.units[name] == "J"] or others
    names = []
    for pattern in patterns:
        found = [name for name in others if fnmatchcase(name, pattern)]
        if not found:
            series[pattern]  # a heading with its unit, the time or a step; else it raises
            found = [pattern.split("[")[0]]
        names += [name for name in found if name not in names]
    return names


def _draw(runs, names, against, log, to):
    import matplotlib
    matplotlib.use("Agg")
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
    part = to.with_name(f"part_{to.name}")
    figure.savefig(part, dpi=150)
    part.replace(to)
    pyplot.close(figure)
