"""skein doctor: what of this machine runs and pictures need, what is missing, and how to get it."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from importlib import import_module
from pathlib import Path

from .needs import in_words
from .parser import Parser
from .program import program

SCENE = """
time.duration = 1e-3
[[rods]]
name = "beam"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 5e-3
shape = {length = 0.1, elements = 4}
placement = {kind = "line", counts = [4], spacing = [0.1]}
"""
GOOD, ABSENT, WRONG = "ok", "absent", "wrong"  # absent: a picture or a page lacks something; wrong: runs do


def parser():
    p = Parser(prog="skein doctor", takes="no words", description="Checks MPI, HDF5, Python, VTK and fonts by using them, and prints what to install. Exit code 2 if runs are affected.")
    p.add_argument("--json", action="store_true", help="as JSON")
    return p


def main(words=None):
    in_words(lambda: _report(parser().parse_args(words)), code=2)


def _report(given):
    rows = [check() for check in CHECKS]
    if given.json:
        print(json.dumps([{"part": part, "state": state, "found": found} for part, state, found in rows], indent=2))
    else:
        for part, state, found in rows:
            print(f"{part:<11} {state:<7} {found}")
    if any(state == WRONG for _, state, _ in rows):
        sys.exit(2)


def _ran(*words, timeout=60):
    """Exit code and both outputs; of what cannot be started 127."""
    try:
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=timeout, stdin=subprocess.DEVNULL)
        return done.returncode, done.stdout + done.stderr
    except (OSError, subprocess.TimeoutExpired) as error:
        return 127, str(error)


def _last(text):
    lines = [line for line in text.splitlines() if line.strip("- ")]
    return next((line for line in lines if "error" in line.lower() or "not" in line), lines[-1] if lines else "no message")


@cache
def _run_of(*launcher):
    """The digest of a run of four small rods, which writes a checkpoint and reads it back; else none, and what went wrong."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder, "scene.toml")
        scene.write_text(SCENE)
        code, text = _ran(*launcher, program(), "run", scene, "--quiet", "--threads", "1", "--out", Path(folder, "out"))
        if code:
            return None, f"{' '.join((*launcher, 'skein'))} run ends with code {code}: {_last(text)}"
        return json.loads(Path(folder, "out/summary.json").read_text())["digest"], ""


def _program():
    code, text = _ran(program(), "--version")
    return "program", GOOD if code == 0 else WRONG, f"{text.strip()} at {program()}"


def _run():
    digest, fault = _run_of()
    return "run", GOOD if digest else WRONG, fault or "a run of four rods writes and reads its HDF5 files"


def _launcher():
    path = shutil.which("mpirun")
    return "launcher", GOOD if path else WRONG, _ran(path, "--version")[1].splitlines()[0] if path else "no mpirun in PATH; on Debian: apt install openmpi-bin, or load the cluster's module"


def _ranks():
    if not shutil.which("mpirun"):
        return "ranks", WRONG, "not tried"
    digest, fault = _run_of("mpirun", "-n", "2")
    if not digest:
        cure = ("; root needs OMPI_ALLOW_RUN_AS_ROOT=1 and OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1" if os.geteuid() == 0 and not os.environ.get("OMPI_ALLOW_RUN_AS_ROOT") else
                "; with fewer cores than ranks: mpirun --oversubscribe" if "slots" in fault else "")
        return "ranks", WRONG, fault + cure
    same = digest == _run_of()[0]
    return "ranks", GOOD if same else WRONG, "two ranks have the bits of one" if same else "two ranks have other bits than one: mpirun is of another MPI than the program"


def _processors():
    allowed = len(os.sched_getaffinity(0))
    return "processors", GOOD if allowed == os.cpu_count() else ABSENT, (f"all {allowed} processors" if allowed == os.cpu_count() else
                                                                     f"{allowed} of {os.cpu_count()} processors; the batch system or a container gives no more")


def _memory():
    threads = os.environ.get("OMP_NUM_THREADS")
    free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1e9
    return "memory", GOOD, f"{free:.1f} GB free" + (f"; OMP_NUM_THREADS={threads} has no effect on Skein, --threads has" if threads else "")


def _version(name):
    try:
        return import_module(name).__version__
    except ImportError:
        return ""


def _python():
    versions = {name: _version(name) for name in ("numpy", "matplotlib")}
    lacking = [name for name, version in versions.items() if not version]
    found = ", ".join(f"{name} {version}" for name, version in versions.items() if version)
    cure = f"; on Debian: apt install {' '.join('python3-' + name for name in lacking)}, and PYTHON=/usr/bin/python3" if lacking else ""
    return "python", ABSENT if lacking else GOOD, f"{sys.executable}: {found}{cure}"


def _hdf5():
    version = _version("h5py")
    return "h5py", GOOD if version else ABSENT, f"reads frames, {version}" if version else "frames cannot be read in Python; on Debian: apt install python3-h5py"


def _renderer():
    if not _version("numpy"):
        return "renderer", ABSENT, "needs numpy"
    from .picture.vtk_stage import why_not
    reason = why_not()
    return "renderer", ABSENT if reason else GOOD, f"plain pictures: {reason}" if reason else "VTK draws shadows"


def _movies():
    path = shutil.which("ffmpeg")
    return "movies", GOOD if path else ABSENT, path or "no .mp4 and .webm, .gif alone; on Debian: apt install ffmpeg"


def _pages():
    if not _version("numpy"):
        return "pages", ABSENT, "needs numpy"
    from .needs import NotResults
    from .picture.page import three
    try:
        return "pages", GOOD, f"three.js of {len(''.join(three())) // 1024} kB"
    except NotResults as error:
        return "pages", ABSENT, str(error)


def _fonts():
    if not _version("matplotlib"):
        return "fonts", ABSENT, "needs matplotlib"
    from matplotlib.font_manager import FontProperties, findfont
    return "fonts", GOOD, Path(findfont(FontProperties(family=["sans-serif"]))).name


CHECKS = (_program, _run, _launcher, _ranks, _processors, _memory, _python, _hdf5, _renderer, _movies, _pages, _fonts)
