"""The command skein where the package is installed by pip, and python3 -m skein: `draw`, `plot`, `export` and `doctor` are done here, all else by the program."""

import os
import sys
from importlib import import_module

from . import needs

DEBIAN = "/usr/bin/python3"  # has the packages that jobscripts/install.sh installs, whatever python3 is first in PATH
COMMANDS = ("draw", "plot", "export", "doctor")


def main():
    words = sys.argv[1:]
    name = words[0] if words else ""
    if name not in COMMANDS:
        from .program import program
        os.execv(program(), ["skein", *words])
    lacking = any(needs.missing(("numpy", "h5py", "matplotlib")))
    if lacking and os.path.exists(DEBIAN) and not os.environ.get("PYTHON") and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN):
        os.environ["PYTHON"] = DEBIAN
        os.execv(DEBIAN, [DEBIAN, "-m", "skein", *words])
    import_module(f".{name}_command", __package__).main(words[1:])


if __name__ == "__main__":
    main()
