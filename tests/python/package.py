"""For tests of the Python package: the package of the checkout with the program under test, and runs to look at."""

import os
import pathlib
import subprocess
import sys
import tempfile

SKEIN, MPIRUN = sys.argv[1:3]
del sys.argv[1:3]

ROOT = pathlib.Path(__file__).resolve().parents[2]
APPS = ROOT / "apps"
os.environ["SKEIN"] = SKEIN
sys.path.insert(0, str(ROOT / "python"))

import skein  # noqa: E402

SCENE = """
title = "Two groups and a ball"
time.duration = 0.2
load = [{kind = "gravity"}, {kind = "formula", per = "length", rods = ["reeds"], force = ["push(t)*s/L", "0", "0"]}]
damping = [{kind = "uniform", rate = 5.0}]

[output]
trajectory = 0.01
tips = 0.005
series = 0.01
checkpoint = 0.05
contacts = 0.05

[[table]]
name = "push"
at = [0.0, 0.01]
value = [0.0, 0.05]
unit = "N/m"

[[rods]]
name = "reeds"
start = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 12}
placement = {kind = "line", counts = [3], spacing = [0.05]}

[[rods]]
name = "flat"
material = {density = 1200.0, youngs_modulus = 2e6}
section = {kind = "elliptic", radius = 4e-3, radius_2 = 2e-3}
shape = {length = 0.1, elements = 6}
placement = {tangent = [1.0, 0.0, 0.0], origin = [0.0, 0.1, 0.004]}

[[bodies]]
name = "ball"
density = 1000.0
spheres.radii = [0.01]
placement.origin = [0.05, 0.1, 0.03]

[[wall]]
name = "floor"
kind = "plane"
rods = ["flat", "ball"]
stiffness = 1e5
damping = 10.0

[contact]
stiffness = 1e5
damping = 10.0
"""


class Directory:
    """A folder with the results of SCENE, in four segments, made once for a test's class."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self._folder.name)
        self.scene = self.path / "two.toml"
        self.scene.write_text(SCENE)
        self.out = self.path / "out"
        subprocess.run([SKEIN, "run", str(self.scene), "--out", str(self.out), "-q"], check=True, timeout=200)

    def close(self):
        self._folder.cleanup()
