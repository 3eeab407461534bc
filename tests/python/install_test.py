"""pip install ./python: the package with its program, away from the checkout."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

from package import ROOT, SKEIN, SCENE

PREFIX = pathlib.Path(SKEIN).parents[1]
try:
    import ensurepip  # noqa: F401
    import pip  # noqa: F401
    import venv  # noqa: F401
    import wheel  # noqa: F401
    WHY_NOT = "" if (PREFIX / "lib/libskein.so").exists() else "libskein.so is not built"
except ImportError as lacking:
    WHY_NOT = f"{lacking} (Debian: python3-pip, python3-venv, python3-wheel)"


@unittest.skipIf(WHY_NOT, WHY_NOT)
class Installed(unittest.TestCase):
    def test_a_wheel(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            # A checkout that has been built where the program under test is.
            shutil.copytree(ROOT / "python", folder / "tree/python", ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
            (folder / "tree/build").symlink_to(PREFIX)
            clean = {key: value for key, value in os.environ.items() if key not in ("SKEIN", "PYTHONPATH", "PYTHON")}

            def run(*words, **options):
                done = subprocess.run(list(map(str, words)), capture_output=True, text=True, env=clean, cwd=folder, timeout=200, **options)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                return done.stdout

            run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", folder, folder / "tree/python")
            built, = folder.glob("*.whl")
            self.assertIn("-py3-none-linux", built.name)
            self.assertTrue({"skein/prefix/bin/skein", "skein/prefix/lib/libskein.so", "skein/picture/page.html"} <= set(zipfile.ZipFile(built).namelist()))
            run(sys.executable, "-m", "venv", "--system-site-packages", folder / "env")
            run(folder / "env/bin/pip", "install", "--quiet", "--no-deps", "--no-index", built)
            shutil.rmtree(folder / "tree")

            (folder / "two.toml").write_text(SCENE)
            self.assertIn("Plan: Two groups", run(folder / "env/bin/skein", "plan", "two.toml"))
            run(folder / "env/bin/skein", "run", "two.toml", "--until", "0.05", "--set", "output.trajectory=0.05", "-q")
            run(folder / "env/bin/skein", "draw", "out/two", "--renderer", "plain", "--size", "200x150")
            self.assertTrue((folder / "out/two/picture.png").exists())
            said = run(folder / "env/bin/python", "-c", "import skein; print(skein.__file__, skein.Simulation('two.toml').step(10).steps_done, skein.program())".replace("skein.program()", "__import__('skein.program', fromlist=['x']).program()"))
            self.assertIn(str(folder / "env"), said)
            self.assertIn(" 10 ", said)


if __name__ == "__main__":
    unittest.main()
