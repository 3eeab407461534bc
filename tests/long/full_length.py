#!/usr/bin/env python3
"""Runs shipped scenes to their end, twice: on one rank, and on two ranks up to half the steps, which one rank of another number of lanes
goes on from. Compares the digests, and prints a line for each scene.

    full_length.py SKEIN MPIRUN [--minutes M] [SCENE]...

Scenes whose steps are predicted to take longer than M minutes (default 2) are left out, and so are those whose bits depend on the number
of ranks. Without SCENE: all below apps/.
"""
import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def digest(command, scene, out, *options):
    done = subprocess.run([*command, "run", scene, "--quiet", "--out", out, *options], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise RuntimeError(done.stderr)
    return json.loads((out / "summary.json").read_text())["digest"]


def compare(args, scene, plan):
    with tempfile.TemporaryDirectory() as folder:
        whole, parts = Path(folder, "whole"), Path(folder, "parts")
        first = digest([args.skein], scene, whole, "--threads", "2")
        ranks = 1 if "bits depend" in plan["pressure"] else 2
        digest([args.mpirun, "-n", str(ranks), args.skein], scene, parts, "--threads", "1", "--steps", str(max(1, plan["steps"] // 2)))
        lanes = max(1, plan["machine"]["lanes"] // 2)
        return first, digest([args.skein], scene, parts, "--threads", "1", "--lanes", str(lanes))


def plan_of(args, scene):
    text = subprocess.run([args.skein, "plan", scene, "--json"], check=True, capture_output=True, text=True).stdout
    plan = json.loads(text)
    plan["pressure"] = subprocess.run([args.skein, "plan", scene], check=True, capture_output=True, text=True).stdout
    return plan


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("skein")
    parser.add_argument("mpirun")
    parser.add_argument("--minutes", type=float, default=2)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    args = parser.parse_args()
    failed = ran = 0
    for scene in args.scenes or sorted(map(str, ROOT.glob("apps/*/*.toml"))):
        plan = plan_of(args, scene)
        if plan["predicted_s"] > 60 * args.minutes:
            continue
        began = time.time()
        try:
            first, second = compare(args, scene, plan)
            same = first == second
            told = f"{first} {'is that of parts' if same else 'differs from ' + second}"
        except (RuntimeError, OSError) as error:
            same, told = False, str(error).strip()
        ran, failed = ran + 1, failed + (not same)
        print(f"{Path(scene).stem:<28}{time.time() - began:8.1f} s  {told}", flush=True)
    print(f"{ran} scenes, {failed} of them differ")
    return 1 if failed or not ran else 0


if __name__ == "__main__":
    sys.exit(main())
