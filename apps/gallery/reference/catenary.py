#!/usr/bin/python3
"""Middle of the rope of catenary.toml, under its pins: the catenary with stretch (Irvine 1981)."""

import numpy as np
from scipy.optimize import brentq

LENGTH, ELEMENTS, ANGLE = 1.0, 100, 0.02  # the pins are at the ends of a polygon that turns by ANGLE from element to element
AREA = np.pi * 2e-3**2
EA, q = 2e5 * AREA, 1100 * 9.81 * AREA
span = LENGTH / ELEMENTS * np.sin(ELEMENTS * ANGLE / 2) / np.sin(ANGLE / 2)
half = q * LENGTH / 2
H = brentq(lambda H: H * LENGTH / EA + 2 * H / q * np.arcsinh(half / H) - span, 1e-6, 1)
print("span, pull H, strain in the middle", span, H, H / EA)
print("z of the middle", f"{-(half * LENGTH / 4 / EA + (np.hypot(H, half) - H) / q):.9f}")
