#!/usr/bin/python3
"""Extension of coil_spring.toml for small forces, by the twist, bending, stretch and shear of its wire (Love 1927, article 271)."""

import numpy as np

RADIUS, PITCH, TURNS, WIRE, FORCE, E, G = 0.02, np.radians(15), 5, 1e-3, 0.01, 2.1e11, 8e10
length = TURNS * 2 * np.pi * RADIUS / np.cos(PITCH)
s, c, area, second = np.sin(PITCH), np.cos(PITCH), np.pi * WIRE**2, np.pi * WIRE**4 / 4
extension = FORCE * RADIUS**2 * length * (c**2 / (2 * G * second) + s**2 / (E * second)) + FORCE * length * (s**2 / (E * area) + c**2 / (27 / 28 * G * area))
print("length, curvature, twist", length, c**2 / RADIUS, s * c / RADIUS)
print("extension, z of the end", extension, length * s + extension)
