#!/usr/bin/env python3
"""Looks that formulas call no function of the C library whose bits depend on the processor: graphs are worked out by what programs run.

    formula_functions_test.py OBJDUMP LIBRARY

LIBRARY is that of src/formula, compiled for any x86-64: there a fused multiply-add, which is exact, is a call.
"""
import re
import subprocess
import sys

MATHEMATICS = re.compile(r"^(a?(sin|cos|tan)h?|atan2|sincos|exp(2|m1|10)?|log(2|10|1p|b)?|pow|hypot|cbrt|tgamma|lgamma|erfc?|fmod|remainder)[fl]?$")

assert all(MATHEMATICS.match(name) for name in ("sin", "acosh", "tanh", "expm1", "powl")) and not MATHEMATICS.match("fma")

objdump, library = sys.argv[1:]
symbols = subprocess.run([objdump, "-t", library], capture_output=True, text=True, check=True).stdout
wanted = {line.split()[-1] for line in symbols.splitlines() if "*UND*" in line}
assert "fma" in wanted, "no operation of a formula is in this library"
if wrong := sorted(filter(MATHEMATICS.match, wanted)):
    sys.exit("formulas call the C library's " + ", ".join(wrong))
