"""python3 -m skein draw OUT: what the program `skein` starts for its command of this name."""

import os
import sys

from . import needs

DEBIAN = "/usr/bin/python3"  # has the packages that jobscripts/install.sh installs, whatever python3 is first in PATH

if any(needs.missing(("numpy", "h5py", "matplotlib"))) and os.path.exists(DEBIAN) and not os.environ.get("PYTHON") and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN):
    os.environ["PYTHON"] = DEBIAN
    os.execv(DEBIAN, [DEBIAN, "-m", "skein", *sys.argv[1:]])

from . import command  # noqa: E402  (needs the packages)

if len(sys.argv) < 2 or sys.argv[1] != "draw":
    sys.exit("usage: python3 -m skein draw OUT; all else is done by the program skein")
command.main(sys.argv[2:])
