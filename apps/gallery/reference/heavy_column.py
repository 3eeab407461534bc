#!/usr/bin/python3
"""Tip of the column of heavy_column.toml."""

import numpy as np
from rod import circle, shoot

LENGTH = 0.0928
B, S = circle(1e6, 2e-3)
q = 1100 * np.pi * 2e-3**2 * 9.81
print("q L^3/(E I)", q * LENGTH**3 / B[0])
for name, stiff in (("x, z of the tip", S), ("without shear and stretch", 1e6 * S)):
    place, _ = shoot(LENGTH, B, stiff, (0, 0, 1), (1, 0, 0), (0, 0, 0), (0, 0, -q), 1, (0, 2 * B[0] / LENGTH, 0))
    print(name, *(f"{place[i, -1]:.9f}" for i in (0, 2)))
