"""docs/python.md, docs/equilibria.md and the README's own scene, done as they are written; messages and scenes of other pages."""

import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

from package import MPIRUN, ROOT, SKEIN

sys.path.insert(0, str(ROOT / "tests/package"))
from pages import blocks  # noqa: E402

GUIDE, PAGE, README = ROOT / "docs/python.md", ROOT / "docs/equilibria.md", ROOT / "README.md"
THREE = pathlib.Path("/usr/share/javascript/three/build/three.min.js").exists()


class Pages(unittest.TestCase):
    def test_messages_of_troubleshooting_are_printed(self):
        sources = [*ROOT.glob("src/**/*.cpp"), *ROOT.glob("src/**/*.hpp"), *ROOT.glob("apps/skein/*.cpp"), *ROOT.glob("python/skein/**/*.py")]
        texts = "".join(re.sub(r'"\s*\n\s*f?"', "", path.read_text()) for path in sources).replace('\\"', '"')
        page = (ROOT / "docs/troubleshooting.md").read_text()
        found = [line.split("|")[1] for line in page.splitlines() if line.count("|") > 3 and "`" in line.split("|")[1]]
        self.assertGreater(len(found), 30)
        for message in (part for cell in found for part in re.findall("`([^`]+)`", cell)):
            # A dash stands for a name or a number.
            for words in re.split(r"[\['\"]?(?<![\w-])-(?![\w-])[\]'\"]?", message):
                with self.subTest(message=message):
                    self.assertIn(words.strip(" ,;:'[]?"), texts)

    def test_scenes_of_pages_are_good(self):
        with tempfile.TemporaryDirectory() as folder:
            for number, scene in enumerate(re.findall(r"```toml\n(.*?)```", (ROOT / "docs/coming_from.md").read_text(), re.S)):
                path = pathlib.Path(folder, f"{number}.toml")
                path.write_text(scene)
                done = subprocess.run([SKEIN, "check", str(path)], capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)


class Guide(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)
        (self.folder / "filament.toml").write_text(blocks(README, "## A scene of your own", "toml")[0])
        self.environment = dict(os.environ, PYTHONPATH=str(ROOT / "python"), PYTHON=sys.executable)

    def tearDown(self):
        self._folder.cleanup()

    def done(self, *words):
        done = subprocess.run(words, cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=250)
        self.assertEqual(done.returncode, 0, f"{shlex.join(words)}\n{done.stdout}{done.stderr}")
        return done.stdout

    def commands(self, text):
        """Those that need no cluster, at a small size where they draw."""
        for line in text.splitlines():
            words = shlex.split(line, comments=True)
            if not words or words[0] == "sbatch" or ("--html" in words and not THREE):
                continue
            words = [SKEIN if word == "build/bin/skein" else MPIRUN if word == "mpirun" else word for word in words]
            if "draw" in words:
                words += ["--renderer", "plain", "--detail", "0.2"] + (["--every", "10"] if "--movie" in words else [])
            yield words

    def test_readme(self):
        chapter = re.findall(r"(?ms)^```(\w*)\n(.*?)^```$", README.read_text().split("\n## A scene of your own\n")[1].split("\n## ")[0])
        for words in self.commands(next(block for language, block in chapter if not language and "skein draw" in block)):
            self.done(*words)
        for name in ("out/filament/picture.png", "filament.gif", *(["filament.html"] if THREE else [])):
            self.assertGreater((self.folder / name).stat().st_size, 5000, name)
        self.done(sys.executable, "-c", blocks(README, "## A scene of your own", "python")[0] + "assert tip.shape == (41, 3)")

    def test_guide(self):
        self.done(SKEIN, "run", "filament.toml", "-q", "--until", "0.2", "--set", "output.series=0.05", "--set", "output.checkpoint=0.2")
        programs = [blocks(GUIDE, heading, "python")[0] for heading in ("## Results", "## Scenes and runs", "## A run in this process")]
        self.done(sys.executable, "-c", programs[0])
        said = self.done(sys.executable, "-c", "import skein\n" + programs[1] + programs[2])
        tips = eval(said.splitlines()[-2])  # noqa: S307  (a list of numbers)
        self.assertEqual(len(tips), 3)
        for words in self.commands(blocks(GUIDE, "## Pictures", "")[0]):
            self.done(*words)

    def test_equilibria(self):
        """Rows of the page are found by their first two words: what follows is round-off or depends on it."""
        (self.folder / "apps").symlink_to(ROOT / "apps")
        said = ""
        for language, text in re.findall(r"(?ms)^```(\w*)\n(.*?)^```$", PAGE.read_text()):
            if language == "python":
                self.assertRegex(self.done(sys.executable, "-c", text), r"it buckles at 1\.6276\d+ N|^straight to \de-07 m")
            elif language == "csv":
                (self.folder / "shape.csv").write_text(text)
            elif language == "text":
                for row in (line.split()[:2] for line in text.splitlines() if line.startswith("  ")):
                    self.assertIn(row, [line.split()[:2] for line in said.splitlines()])
            else:
                said = "".join(self.done(*words) for words in self.commands(text)) or said
        for name in ("column.png", "out/lee_frame_path/path.png", "out/column_modes/modes.png", "mode_2.gif"):
            self.assertGreater((self.folder / name).stat().st_size, 3000, name)

    def test_equilibria_in_python(self):
        shape = self.done(sys.executable, "-c", "import skein\n" + blocks(GUIDE, "## Equilibria", "python")[0])
        self.assertTrue(shape.startswith("(1, 21, 3) "), shape)


if __name__ == "__main__":
    unittest.main()
