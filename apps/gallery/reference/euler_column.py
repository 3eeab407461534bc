#!/usr/bin/python3
"""Tip of the column of euler_column.toml: K(k) = (pi/2) sqrt(P/P_c), x = 2 k sqrt(E I/P), z = 2 sqrt(E I/P) E(k) - L (Love 1927, art. 263)."""

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

LENGTH, P = 0.5, 1.790592
B = 2.1e11 * np.pi * 1e-3**4 / 4
ratio = P / (np.pi**2 * B / (4 * LENGTH**2))
m = brentq(lambda m: ellipk(m) - np.pi / 2 * np.sqrt(ratio), 1e-9, 0.9)
print("P/P_c", ratio)
print("x, z of the tip", f"{2 * np.sqrt(m * B / P):.9f}", f"{2 * np.sqrt(B / P) * ellipe(m) - LENGTH:.9f}")
