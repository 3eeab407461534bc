"""skein export: the rods of a frame as a file of rods, for Skein or other programs."""

import json
from pathlib import Path

import numpy as np

from .needs import NotResults, in_words, need
from .parser import Parser


def parser():
    p = Parser(prog="skein export", takes="a directory of results", description="Writes the rods of a frame as points: .csv or .tsv with a row per point, .swc, .npz, .h5 or .bcc (without radii). "
               "Skein reads each with placement.kind = \"file\".",
               epilog="examples: skein export out/net --to net.csv | skein export out/net --group hair --time 0.5 --unit 1e-6 --to hair.swc")
    p.add_argument("out", type=Path, metavar="OUT", help="directory of a run's results")
    p.add_argument("--to", type=Path, metavar="FILE", required=True, help="file to write; its ending is the format")
    p.add_argument("--group", metavar="NAME", help="group of rods; needed if there are several")
    p.add_argument("--time", type=float, metavar="T", help="time of the frame, s, the nearest is taken; default: the last")
    p.add_argument("--unit", type=float, default=1.0, metavar="METRES", help="length of 1 in the file, m; default: 1")
    p.add_argument("--json", action="store_true", help="print what was written as JSON")
    return p


def main(words=None):
    in_words(lambda: _export(parser().parse_args(words)), code=2, code_of_damage=5)


def _export(given):
    need("numpy", "h5py")
    from .centrelines import write
    from .results import open as open_results
    if not given.unit > 0:
        raise NotResults(f"--unit {given.unit:g}: a length in metres, above 0")
    run = open_results(given.out)
    group = _group(run, given.group)
    frame = len(run.time) - 1 if given.time is None else int(np.argmin(np.abs(np.asarray(run.time[:]) - given.time)))
    if frame < 0:
        raise NotResults(f"{given.out}: no frames; set output.trajectory in the scene")
    curves, radii = group.centrelines(frame)
    write(given.to, curves, radii, given.unit)
    time = float(run.time[frame])
    print(json.dumps({"file": str(given.to), "rods": len(curves), "time_s": time}, indent=2) if given.json else f"{given.to}: {len(curves)} rods at {time:.6g} s" + (", without radii, which BCC does not have" if given.to.suffix == ".bcc" else ""))


def _group(run, name):
    names = [group.name for group in run.rods]
    if name is None and len(names) != 1:
        raise NotResults(f"{run.directory}: --group says which of {', '.join(names) or 'no groups of rods'}")
    if name is not None and name not in names:
        raise NotResults(f"{run.directory}: no group of rods '{name}'; there are {', '.join(names)}")
    return run[name or names[0]]
