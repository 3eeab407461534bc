#!/usr/bin/env python3
"""Runs the scenes of the farm's error against work: run.py SKEIN OUT [NAME...]

SKEIN is the program, OUT takes a folder for each scene; runs that are finished there are kept. NAMEs choose some of the scenes.
Everything takes ten minutes on one core, and no more than 100 MB.
"""

import argparse
import json
import os
import subprocess
from pathlib import Path

import cell


def finished(out):
    path = out / "summary.json"
    return path.exists() and json.loads(path.read_text())["finished"]


def run(command):
    """Core time of a program, s: on a shared machine it says more than the wall time."""
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"failed: {' '.join(map(str, command))}")
    return usage.ru_utime + usage.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("skein", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("names", nargs="*", help="of scenes; all where absent")
    arguments = parser.parse_args()
    scenes = cell.ladder() | cell.variations()
    if unknown := set(arguments.names) - set(scenes):
        raise SystemExit(f"no scene {', '.join(sorted(unknown))}; there are {', '.join(scenes)}")
    for name in arguments.names or scenes:
        out = arguments.out / name
        if finished(out):
            continue
        out.parent.mkdir(parents=True, exist_ok=True)
        path = arguments.out / f"{name}.toml"
        path.write_text(scenes[name])
        seconds = run([arguments.skein, "run", path, "--threads", "1", "--quiet", "--overwrite", "--out", out])
        (out / "core_seconds").write_text(f"{seconds:.4g}\n")
        print(f"{name}: {seconds:.1f} s", flush=True)


if __name__ == "__main__":
    main()
