#!/usr/bin/python3
"""Tip of the bar of princeton.toml."""

import numpy as np
from rod import shoot

LENGTH, FORCE, E, G, SHEAR = 0.508, 13.345, 7.17e10, 2.7e10, 5 / 6
b, t = 2 * 6.3848e-3, 2 * 1.6012e-3  # sides along d1 and d2
A = b * t
odd = np.arange(1, 200, 2)
torsion = b * t**3 / 3 * (1 - 192 * t / (np.pi**5 * b) * np.sum(np.tanh(odd * np.pi * b / (2 * t)) / odd**5))  # St Venant
bending = np.array([E * b * t**3 / 12, E * t * b**3 / 12, G * torsion])
stretching = np.array([SHEAR * G * A, SHEAR * G * A, E * A])
place, frame = shoot(LENGTH, bending, stretching, (1, 0, 0), (0, 1, 1), (0, 0, -FORCE))
print("y, z of the tip", *(f"{place[i, -1]:.9f}" for i in (1, 2)))
