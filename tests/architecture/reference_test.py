#!/usr/bin/env python3
"""docs/scene.md is what the program prints.

    reference_test.py SKEIN PAGE
"""
import difflib
import subprocess
import sys

program, page = sys.argv[1:]
printed = subprocess.run([program, "describe"], check=True, capture_output=True, text=True).stdout
kept = open(page).read()
assert printed.count("\n") > 100, "skein describe prints no reference"
if printed != kept:
    sys.stdout.writelines(difflib.unified_diff(kept.splitlines(True), printed.splitlines(True), page, "skein describe"))
    sys.exit(f"{page} is out of date: write it anew with  build/bin/skein describe > docs/scene.md")
