"""skein plot and skein doctor: columns of runs, and what a machine lacks."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from package import ROOT, SKEIN
from PIL import Image

SCENE = """
time.duration = 0.2
load = [{kind = "gravity"}]
[[rods]]
name = "beam"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 5e-3
shape = {length = 0.2, elements = 4}
placement.tangent = [1.0, 0.0, 0.0]
[output]
series = 0.02
"""


def command(*words, code=0, **environment):
    done = subprocess.run([SKEIN, *map(str, words)], capture_output=True, text=True, timeout=200, env=dict(os.environ, PYTHON=sys.executable, **environment))
    if done.returncode != code:
        raise AssertionError(f"{words}: code {done.returncode}\n{done.stdout}{done.stderr}")
    return done


class Plot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.directory = pathlib.Path(folder.name)
        (self.directory / "beam.toml").write_text(SCENE)
        for out, density in (("light", 1000.0), ("heavy", 2000.0)):
            command("run", self.directory / "beam.toml", "--set", f"rods.beam.material.density={density}", "--quiet", "--threads", "1", "--out", self.directory / out)

    def test_a_python_without_packages(self):
        """As seen by a Python that looks nowhere else."""
        program = f"import sys; sys.path.insert(0, {str(ROOT / 'python')!r}); import skein; skein.open"
        done = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, text=True)
        self.assertRegex(done.stderr.splitlines()[-1], r"ModuleNotFoundError: \S+ has no numpy; on Debian 'apt install python3-numpy'")

    def test_pictures_of_columns(self):
        light, heavy = self.directory / "light", self.directory / "heavy"
        command("plot", light)
        with Image.open(light / "series.png") as picture: whole = picture.height
        command("plot", light, heavy, "--columns", "centre_?", "max_speed", "--to", self.directory / "two.png")
        with Image.open(self.directory / "two.png") as two:
            self.assertGreater(two.height, 1.5 * whole, "two units, two axes")
            self.assertGreater(len(set(two.convert("RGB").getdata())), 50)
        self.assertFalse(list(light.glob("part_*")))

    def test_lists_are_those_of_the_file(self):
        rows = json.loads(command("plot", self.directory / "light", "--list", "--json").stdout)
        heads, *_, last = [line.split(",") for line in (self.directory / "light/observables.csv").read_text().splitlines()]
        self.assertEqual([row["column"] + (f"[{row['unit']}]" if row["unit"] else "") for row in rows], heads)
        self.assertEqual([row["last"] for row in rows], [float(number) for number in last])

    def test_mistakes_name_the_nearest(self):
        self.assertIn("did you mean max_speed?", command("plot", self.directory / "light", "--columns", "max_sped", code=2).stderr)
        self.assertIn("no columns of observables.csv called q*", command("plot", self.directory / "light", "--columns", "q*", code=2).stderr)
        self.assertIn("did you mean '--columns'?", command("plot", self.directory / "light", "--colums", "a", code=2).stderr)
        self.assertIn("a picture is one of .png", command("plot", self.directory / "light", "--to", "a.jpeg", code=2).stderr)
        self.assertIn("give the output directory of a run", command("plot", self.directory, code=2).stderr)


class Doctor(unittest.TestCase):
    def test_this_machine_runs(self):
        rows = {row["part"]: row for row in json.loads(command("doctor", "--json").stdout)}
        for part in ("program", "run", "launcher", "ranks", "python", "h5py", "fonts"):
            self.assertEqual(rows[part]["state"], "ok", rows[part])

    def test_no_launcher(self):
        text = command("doctor", code=2, PATH="/nowhere").stdout
        self.assertRegex(text, r"launcher +wrong +no mpirun in PATH; on Debian: apt install openmpi-bin")
        self.assertRegex(text, r"ranks +wrong +not tried")


if __name__ == "__main__":
    unittest.main()
