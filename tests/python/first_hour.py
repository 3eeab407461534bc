#!/usr/bin/env python3
"""The first hour with Skein: types a tutorial in an empty home, with a program that is built, and prints the minutes that it takes.

  first_hour.py SKEIN [ROOT]      the bar: ten minutes of running from the first command to a movie of a scene of one's own
"""

import pathlib
import sys
import time

HERE = pathlib.Path(__file__).resolve()
sys.path.insert(0, str(HERE.parents[1] / "package"))
from typed import Typed, parts, untrue  # noqa: E402

BAR = 10  # minutes

skein = pathlib.Path(sys.argv[1]).resolve()
root = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else HERE.parents[2]).resolve()
text = (root / "docs/tutorial_statics.md").read_text()
shell = Typed(root, skein, "/usr/bin/python3")
began = time.monotonic()
try:
    movie = next(i for i, part in enumerate(parts(text)) if part[0] == "shell" and "--movie" in part[1]) + 1
    for number, part in enumerate(parts(text)):
        shell.part(part)
        if number + 1 == movie:
            computing = (time.monotonic() - began) / 60
            size = (shell.place / "swing.gif").stat().st_size
    whole = (time.monotonic() - began) / 60
    wrong = untrue(text, shell.output, shell.typed)
finally:
    shell.close()
print(f"to a movie of {size} bytes: {computing:.1f} min of running, all blocks {whole:.1f} min; {len(shell.typed.split())} words are typed")
print("\n".join(f"not in the output: {line}" for line in wrong) or "all numbers of the page are in the output")
sys.exit(1 if wrong or computing > BAR or size < 5000 else 0)
