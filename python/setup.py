"""The package with the program in it: `pip install ./python`, from a checkout. What is built in build/ is taken, else it is built there."""

import shutil
import subprocess
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from wheel.bdist_wheel import bdist_wheel

ROOT = Path(__file__).resolve().parent.parent
BUILT = ("bin/skein", "lib/libskein.so")


class WithProgram(build_py):
    def run(self):
        super().run()
        build = ROOT / "build"
        if not all((build / file).exists() for file in BUILT):
            options = [] if (build / "CMakeCache.txt").exists() else ["-DSKEIN_TESTS=OFF", "-DSKEIN_BENCH=OFF"]
            subprocess.run(["cmake", "-S", str(ROOT), "-B", str(build), *options], check=True)
            subprocess.run(["cmake", "--build", str(build), "--parallel", "--target", "skein", "skein_shared"], check=True)
        for file in BUILT:
            to = Path(self.build_lib, "skein/prefix", file)
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(build / file, to)


class OfThisMachine(Distribution):
    def has_ext_modules(self):
        return True


class ForThisMachine(bdist_wheel):
    """For any Python, but for this kind of machine alone."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


setup(distclass=OfThisMachine, cmdclass={"build_py": WithProgram, "bdist_wheel": ForThisMachine})
