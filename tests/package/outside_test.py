#!/usr/bin/env python3
"""Programs of docs/embedding.md against an installed Skein, built and run outside of the tree; with the load of docs/tour.md.

    outside_test.py CMAKE BUILD COMPILER MPIEXEC
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from pages import blocks

CMAKE, BUILD, COMPILER, MPIEXEC = sys.argv[1:5]
HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
EMBEDDING = ROOT / "docs/embedding.md"
SCENE = ROOT / "apps/cilia_carpet/row_8.toml"
STEPS = 640


def run(*command, code=0, **options):
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)
    assert result.returncode == code, f"{command}: {result.returncode}\n{result.stdout}{result.stderr}"
    return result


class Outside(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.prefix = pathlib.Path(cls.folder.name, "prefix")
        run(CMAKE, "--install", BUILD, "--prefix", cls.prefix)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def built(self, name, files):
        source = pathlib.Path(self.folder.name, name)
        source.mkdir()
        for file, text in files.items():
            (source / file).write_text(text)
        run(CMAKE, "-S", source, "-B", source / "build", f"-DCMAKE_PREFIX_PATH={self.prefix}", f"-DCMAKE_CXX_COMPILER={COMPILER}",
            "-DCMAKE_CXX_FLAGS=-O1 -Wall -Wextra -Wno-missing-field-initializers -Werror")
        run(CMAKE, "--build", source / "build")
        return source / "build" / name

    def test_no_header_is_left_behind(self):
        headers = {path.relative_to(ROOT / "include") for path in (ROOT / "include").rglob("*.h*")}
        self.assertEqual(headers, {path.relative_to(self.prefix / "include") for path in (self.prefix / "include").rglob("*.h*")})

    def test_c_program(self):
        source = pathlib.Path(self.folder.name, "c/follow.c")
        source.parent.mkdir()
        source.write_text(blocks(EMBEDDING, "## Other languages", "c")[0])
        program = source.with_suffix("")
        run("cc", "-Wall", "-Wextra", "-Werror", source, f"-I{self.prefix}/include", f"-L{self.prefix}/lib", f"-Wl,-rpath,{self.prefix}/lib", "-lskein", "-o", program)
        digest = run(program, SCENE).stdout.split()[-1]
        whole = source.with_name("run")
        run(self.prefix / "bin/skein", "run", SCENE, "--steps", STEPS, "--out", whole, "-q")
        self.assertEqual(digest, json.loads((whole / "summary.json").read_text())["digest"])
        self.assertIn("no such file", run(program, "absent.toml", code=1).stderr.lower())

    def test_the_package_lies_beside_the_program(self):
        self.assertIn("usage: skein draw", run(self.prefix / "bin/skein", "draw", "--help", env=dict(os.environ, PYTHON=sys.executable)).stdout)

    def test_load_of_the_tour(self):
        program = self.built("wind", {
            "CMakeLists.txt": (HERE / "outside/CMakeLists.txt").read_text(),
            "wind.hpp": blocks(ROOT / "docs/tour.md", "## 8 A new load", "cpp")[0],
            "main.cpp": blocks(EMBEDDING, "## A load", "cpp")[0]})
        forces = [float(line) for line in run(program).stdout.split()]
        lengths = [1 / 16] + 7 * [1 / 8] + [1 / 16]
        self.assertEqual(len(forces), 9)
        for force, length in zip(forces, lengths):
            self.assertAlmostEqual(force, 0.5 * length * 3, places=6)  # c l_i (u - 0)

    def test_run_in_another_program(self):
        program = self.built("follow", {"CMakeLists.txt": blocks(EMBEDDING, "## A run", "cmake")[0],
                                        "follow.cpp": blocks(EMBEDDING, "## A run", "cpp")[0]})
        out = pathlib.Path(self.folder.name, "out")
        run(self.prefix / "bin/skein", "run", SCENE, "-q", "--no-checkpoint", "--steps", STEPS, "--out", out)
        digest = json.loads((out / "summary.json").read_text())["digest"]
        alone = run(program, SCENE, cwd=self.folder.name).stdout
        self.assertIn(f"digest {digest}", alone)
        self.assertIn("magnetic_field", alone, "the plan")
        self.assertEqual(sum(line.startswith("cilia ") for line in alone.splitlines()), 8)
        two = run(MPIEXEC, "-n", "2", program, SCENE, cwd=self.folder.name).stdout
        self.assertIn(f"digest {digest}", two)
        self.assertEqual(sum(line.startswith("cilia ") for line in two.splitlines()), 8)
        self.assertFalse([name for name in os.listdir(self.folder.name) if name not in ("prefix", "follow", "wind", "out", "c")],
                         "a run without a directory wrote something")
        wrong = run(program, self.folder.name + "/none.toml", code=2)
        self.assertIn("there is no such file", wrong.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
