"""python3 -m skein draw OUT: what the program `skein` starts for its command of this name."""

import sys

from . import command

if len(sys.argv) < 2 or sys.argv[1] != "draw":
    sys.exit("usage: python3 -m skein draw OUT; all else is done by the program skein")
command.main(sys.argv[2:])
