"""docs/recipes.md, done as it is written: every kind of `skein new` runs, is on the page, and has the figures that the page prints."""

import math
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

from package import ROOT, SKEIN

sys.path.insert(0, str(ROOT / "python"))
import skein  # noqa: E402

PAGE = (ROOT / "docs/recipes.md").read_text()
KINDS = sorted(path.stem for path in (ROOT / "apps/recipes").glob("*.toml"))
FLUID = "fluid" in subprocess.run([SKEIN, "info"], capture_output=True, text=True, check=True).stdout


class Recipes(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def call(self, *words):
        environment = dict(os.environ, PYTHONPATH=str(ROOT / "python"), PYTHON=sys.executable)
        return subprocess.run(words, cwd=self.folder, env=environment, capture_output=True, text=True, timeout=100)

    def done(self, *words):
        done = self.call(*words)
        self.assertEqual(done.returncode, 0, f"{shlex.join(map(str, words))}\n{done.stdout}{done.stderr}")
        return done.stdout

    def test_kinds(self):
        listed = self.done(SKEIN, "new")
        for kind in KINDS:
            self.assertRegex(listed, rf"(?m)^  {kind}\s+[A-Z].*\.$")
            self.assertIn(f"`skein new {kind}`", PAGE)
            self.done(SKEIN, "new", kind)
            self.assertEqual((self.folder / f"{kind}.toml").read_text(), (ROOT / f"apps/recipes/{kind}.toml").read_text())
            if kind != "fluid" or FLUID:
                self.done(SKEIN, "check", f"{kind}.toml")

    def test_nothing_is_overwritten_and_names_are_guessed(self):
        self.done(SKEIN, "new", "cantilever")
        again = self.call(SKEIN, "new", "cantilever")
        self.assertEqual((again.returncode, again.stderr), (2, "error: cantilever.toml exists; give another name\n"))
        wrong = self.call(SKEIN, "new", "pil")
        self.assertEqual((wrong.returncode, wrong.stderr), (2, "error: there is no kind 'pil' of scenes; did you mean 'pile'?\n"))

    def test_commands(self):
        blocks = re.findall(r"(?ms)^```(\w*)\n(.*?)^```$", PAGE)
        for block in (text for language, text in blocks if not language):
            for line in block.splitlines():
                words = [SKEIN if word == "build/bin/skein" else word for word in shlex.split(line, comments=True)]
                words += ["--renderer", "plain", "--detail", "0.2"] if "draw" in words else []
                words += ["--every", "10"] if "--movie" in words else []
                self.done(*words)
        program = next(text for language, text in blocks if language == "python")
        self.assertEqual(self.done(sys.executable, "-c", program), "the tip sinks by 18.30 mm\n")
        self.assertIn("18.30 mm", program)

    def test_figures(self):
        for kind in ("cable", "motor", "release"):
            self.done(SKEIN, "new", kind)
            self.done(SKEIN, "run", f"{kind}.toml", "--quiet")
        sag = -skein.open(self.folder / "out/cable")["rope"].position[-1, 0, :, 2].min()
        self.assertAlmostEqual(sag, 18.5e-3, delta=0.1e-3)
        self.assertIn("18.5 mm", PAGE)
        link = skein.open(self.folder / "out/motor")["link"].position[20:, 0]  # the second period
        turns = [math.atan2(nodes[0, 2] - nodes[-1, 2], nodes[-1, 0] - nodes[0, 0]) for nodes in link]
        self.assertAlmostEqual(0.5 * (max(turns) - min(turns)), 0.8, delta=0.1)
        header, *rows = (self.folder / "out/release/observables.csv").read_text().splitlines()
        columns = [name.split("[")[0] for name in header.split(",")]
        column = lambda name: [float(row.split(",")[columns.index(name)]) for row in rows]
        self.assertLess(max(map(abs, column("energy_defect"))), 1e-3 * max(column("work_loads")))


if __name__ == "__main__":
    unittest.main()
