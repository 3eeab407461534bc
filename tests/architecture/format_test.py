#!/usr/bin/env python3
"""Holds the layout of every C++ file against .clang-format.

    format_test.py CLANG_FORMAT ROOT

A badly laid out text is tried first, so that a test which finds nothing has looked.
"""
import subprocess
import sys
from pathlib import Path

clang_format, root = sys.argv[1], Path(sys.argv[2])
forged = subprocess.run([clang_format, "--dry-run", "-Werror", "--assume-filename=forged.cpp"], input="int  f( ){return 1 ;}\n",
                        capture_output=True, text=True, cwd=root)
assert forged.returncode != 0, "clang-format accepts anything"

files = [str(f) for folder in ("src", "include", "apps", "tests", "bench") for f in sorted((root / folder).rglob("*.[ch]pp"))]
assert len(files) > 100, files
found = subprocess.run([clang_format, "--dry-run", "-Werror", *files], capture_output=True, text=True, cwd=root)
wrong = sorted({line.split(":")[0] for line in found.stderr.splitlines() if "clang-format-violations" in line})
if found.returncode:
    sys.exit("not laid out as .clang-format says: " + " ".join(wrong) + "\n  clang-format -i these files\n" + ("" if wrong else found.stderr))
print(f"{len(files)} files")
