#!/usr/bin/env python3
"""Makes a movie of every scene of the gallery that `skein draw` can show: movies.py FOLDER [NAME ...] [--skein SKEIN] [--frames N] [--size WxH] [--kind gif|mp4]

Runs each scene of README.md into FOLDER/runs/NAME and draws FOLDER/NAME.gif with the options that README.md has for it: of the command with --movie, or else
of the picture. Frames are evenly apart over the scene's duration. Of relaxations, which have no time, FOLDER/NAME.png shows the end. Without names all scenes.
"""

import argparse
import re
import shlex
import subprocess
import sys
import time
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OURS = {"--to": 1, "--size": 1, "--time": 1, "--movie": 1}  # options of README.md that are set here, and how many words follow


def scenes(text):
    """{name: (scene, options of run, options of draw)} of README.md."""
    found, scene = {}, None
    for line in text.splitlines():
        words = shlex.split(line, comments=True) if line.startswith("build/bin/skein ") else []
        if words[1:2] == ["expect"]:
            scene = Path(words[2])
            found[scene.stem] = (scene, [], None)
        elif words[1:2] == ["run"] and scene and Path(words[2]) == scene:
            found[scene.stem] = (scene, [word for k, word in enumerate(words[3:]) if "--set" in (word, words[2 + k])], found[scene.stem][2])
        elif words[1:2] == ["draw"] and scene:
            options, k = [], 3
            while k < len(words):
                if words[k] in OURS:
                    k += OURS[words[k]]
                else:
                    options.append(words[k])
                k += 1
            if found[scene.stem][2] is None or "--movie" in words:
                found[scene.stem] = (*found[scene.stem][:2], options)
    return {name: entry for name, entry in found.items() if entry[2] is not None}


def times_of(scene, options):
    """Duration, s, whether the scene is relaxed, and whether it has rods or bodies."""
    tree = tomllib.loads((ROOT / scene).read_text())
    given = tree.get("time", {})
    changed = [re.fullmatch(r"time\.duration=(.+)", word) for word in options]
    return float(next((found[1] for found in changed if found), given["duration"])), bool(given.get("relax")), bool({"rods", "bodies", "assembly"} & set(tree))


def make(name, scene, run_options, draw_options, given):
    duration, relaxed, solid = times_of(scene, run_options)
    out, still = given.folder / "runs" / name, relaxed or given.frames < 2
    every = [f"--set=output.trajectory={duration / given.frames}"] if solid and not still else []
    if not still and {"--slice", "--q"} & set(draw_options):
        every.append(f"--set=output.fields={duration / given.frames}")
    subprocess.run([given.skein, "run", str(scene), "--out", str(out), "--quiet", "--overwrite", *run_options, *every], check=True, cwd=ROOT)
    to = given.folder / f"{name}.{'png' if still else given.kind}"
    subprocess.run([given.skein, "draw", str(out), "--to" if still else "--movie", str(to), "--size", given.size, "--rate", str(given.rate), *draw_options],
                   check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    return to


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*", metavar="NAME", help="of scenes; default: all")
    parser.add_argument("--skein", default=str(ROOT / "build/bin/skein"))
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--rate", type=float, default=20, help="frames per second")
    parser.add_argument("--size", default="480x360")
    parser.add_argument("--kind", choices=("gif", "mp4", "webm"), default="gif")
    given = parser.parse_args()
    given.folder = given.folder.resolve()
    known = scenes((HERE / "README.md").read_text())
    unknown = set(given.names) - set(known)
    if unknown:
        sys.exit(f"movies.py: no scene {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    began, total, failed = time.monotonic(), 0, []
    for name in given.names or known:
        start = time.monotonic()
        try:
            to = make(name, *known[name], given)
        except subprocess.CalledProcessError as error:
            failed.append(name)
            print(f"{name}: exit code {error.returncode}", flush=True)
            continue
        total += to.stat().st_size
        print(f"{to}  ({to.stat().st_size / 1e6:.2f} MB, {time.monotonic() - start:.1f} s)", flush=True)
    print(f"{total / 1e6:.1f} MB in {time.monotonic() - began:.0f} s" + (f"; failed: {', '.join(failed)}" if failed else ""))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
