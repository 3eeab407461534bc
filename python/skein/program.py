"""The program skein and its library: where they are, and runs by processes of their own."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent


class RunFailed(RuntimeError):
    """A run ended with an error: its message, and `code`, the program's exit code (docs/faults.md)."""

    def __init__(self, message, code):
        super().__init__(message)
        self.code = code


def found(inside, wanted):
    """A file of the program's own: in the folder that SKEIN's program lies in, beside an installed package, in a checkout's build/, in a wheel."""
    chosen = os.environ.get("SKEIN")
    prefixes = [Path(chosen).resolve().parents[1]] if chosen else [HERE / "prefix", *HERE.parents[2:4], HERE.parents[1] / "build"]
    for prefix in prefixes:
        if (prefix / inside).exists():
            return prefix / inside
    return wanted()


def program():
    """Path of `skein`: what the environment's SKEIN says, else what lies with this package, else in PATH."""
    def in_path():
        path = shutil.which("skein")
        if path and not Path(path).read_bytes()[:2] == b"#!":  # not the script that pip has made of this very package
            return Path(path)
        raise FileNotFoundError("the program skein is not beside this package, nor in PATH; build it (README), or set SKEIN to it")
    return Path(os.environ["SKEIN"]) if os.environ.get("SKEIN") else found("bin/skein", in_path)


def _toml(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    return repr(value)


def overrides(keys):
    """["key=value"] as --set takes them, of {"rods.cilia.shape.elements": 50}."""
    return [f"{key}={_toml(value)}" for key, value in keys.items()]


def command(what, scene, keys, *words):
    return [str(program()), what, str(scene), *(word for change in overrides(keys) for word in ("--set", change)), *map(str, words)]


def description():
    """What the program knows of scenes, as `skein describe --json` has it: {"tables": [{"name", "list"}], "keys": [{"path", "unit", "type", ...}]}."""
    return _description(str(program()))


@cache
def _description(path):
    done = subprocess.run([path, "describe", "--json"], capture_output=True, text=True, env=environment())
    if done.returncode:
        raise RunFailed(f"{path} describe --json: {done.stderr.strip() or 'no answer'}", done.returncode)
    return json.loads(done.stdout)


def lists():
    """Names of the lists of tables that a scene may have: rods, bodies, load, joint, ..."""
    return [table["name"] for table in description()["tables"] if table["list"]]


def _launched(words, ranks, mpirun):
    if not ranks:
        return words
    launch = [mpirun, "-n", str(ranks)]
    if os.geteuid() == 0:
        os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")  # Open MPI asks root to say so
        os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    return launch + words


def environment():
    """Of processes that are started: without what MPI, once it is at work in this process (skein.Simulation), has put there behind Python's back,
    which would make an mpirun believe that it is part of this run."""
    return dict(os.environ)


def run(scene, out=None, ranks=None, threads=None, overwrite=False, until=None, quiet=False, mpirun="mpirun", flags=(), **keys):
    """Runs a scene, a file, TOML text or a skein.Scene, in a process of its own, or goes on with it, and returns its results. Keys of the scene by their path:
    skein.run("carpet.toml", **{"rods.cilia.shape.elements": 50}). ranks: by mpirun; threads: per rank. Raises RunFailed with the program's message;
    Ctrl-C stops the run with a checkpoint."""
    from .results import open as results
    with as_file(scene) as path:
        out = Path(out or Path("out") / path.stem)
        words = command("run", path, keys, "--out", out, "--progress", "lines", *flags)
        words += ["--threads", str(threads)] if threads else []
        words += ["--until", repr(float(until))] if until else []
        words += ["--overwrite"] if overwrite else []
        words += ["--quiet"] if quiet else []
        with tempfile.TemporaryFile("w+") as errors, subprocess.Popen(_launched(words, ranks, mpirun), stdout=subprocess.PIPE, stderr=errors, text=True, env=environment()) as process:
            try:
                for line in process.stdout:
                    _tell(line, quiet)
                code = process.wait()
            except KeyboardInterrupt:
                process.send_signal(2)
                process.wait()
                raise
            errors.seek(0)
            said = errors.read().strip()
        if code not in (0, 3):
            raise RunFailed(said or f"the run ended with code {code}", code)
        if said and not quiet:
            print(said, file=sys.stderr)
    return results(out)


def _tell(line, quiet):
    """Progress rewrites one line, in terminals and notebooks; what else is said goes line by line."""
    if quiet:
        return
    passing = re.match(r"step \d+/", line)
    print("\r" + line.rstrip().ljust(100) if passing else line, end="" if passing else "", flush=True)


def plan(scene, **keys):
    """What a run would do, as text, with all of its lines. Raises RunFailed with what is wrong with the scene."""
    with as_file(scene) as path:
        done = subprocess.run([*command("plan", path, keys), "--verbose"], capture_output=True, text=True, env=environment())
    if done.returncode:
        raise RunFailed(done.stderr.strip(), done.returncode)
    return done.stdout


def is_text(scene):
    """Whether it is TOML text: a text with several lines, or a last one that ends, which no file is called."""
    return isinstance(scene, str) and "\n" in scene


@contextmanager
def as_file(scene):
    """Path of a scene: a file's own, or of TOML text or a Scene's in a folder that goes at the end."""
    if is_text(scene):
        with tempfile.TemporaryDirectory(prefix="skein_") as folder:
            path = Path(folder, "scene.toml")
            path.write_text(scene)
            yield path
        return
    if not hasattr(scene, "text"):
        yield Path(scene)
        return
    with tempfile.TemporaryDirectory(prefix="skein_") as folder:
        yield scene.written(Path(folder))
