#!/usr/bin/python3
"""Tip of the cantilever of elastica.toml, and of a rod that only bends."""

from rod import circle, shoot

LENGTH, FORCE = 0.5, 0.0157
B, S = circle(2e6, 5e-3)
print("F L^2/(E I)", FORCE * LENGTH**2 / B[0])
for name, stiff in (("x, z of the tip", S), ("without shear and stretch", 1e9 * S)):
    place, _ = shoot(LENGTH, B, stiff, (1, 0, 0), (0, 1, 0), (0, 0, -FORCE))
    print(name, *(f"{place[i, -1]:.9f}" for i in (0, 2)))
