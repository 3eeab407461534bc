#!/usr/bin/python3
"""Tips of the two strips of lateral_buckling.toml."""

import numpy as np
from rod import shoot

LENGTH, E, G, SHEAR, SIDE = 0.5, 2.0e9, 7.5e8, 5 / 6, 2e-3  # SIDE: side force over the weight
b, t = 2 * 0.01, 2 * 0.001  # sides along d1 and d2
odd = np.arange(1, 200, 2)
torsion = b * t**3 / 3 * (1 - 192 * t / (np.pi**5 * b) * np.sum(np.tanh(odd * np.pi * b / (2 * t)) / odd**5))  # St Venant
bending = np.array([E * b * t**3 / 12, E * t * b**3 / 12, G * torsion])
stretching = np.array([SHEAR * G * b * t, SHEAR * G * b * t, E * b * t])
critical = 4.0126 * np.sqrt(bending[0] * bending[2]) / LENGTH**2
print(f"4.0126 sqrt(E I G J)/L^2 = {critical:.6f} N, divided by the effect of the deflection before: "
      f"{critical / np.sqrt((1 - bending[0] / bending[1]) * (1 - bending[2] / bending[1])):.6f} N")
for name, share in (("light", 0.8), ("heavy", 1.2)):
    F = share * critical
    place, _ = shoot(LENGTH, bending, stretching, (1, 0, 0), (0, 0, 1), (0, SIDE * F, -F))
    print(f"{name}: weight {F:.9f} N, side force {SIDE * F:.9f} N, y and z of the tip {place[1, -1]:.9f} {place[2, -1]:.9f}")
