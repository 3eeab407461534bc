#!/usr/bin/python3
"""Tip of the bar of pendulum.toml: sin(angle/2) = k sn(K - w t, k), w^2 = m g (L/2)/J, J = m (L^2/3 + r^2/4), k = sin(pi/4)."""

import numpy as np
from scipy.special import ellipj, ellipk

LENGTH, RADIUS, TIME = 1.0, 0.04, 1.2
w = np.sqrt(9.81 * LENGTH / 2 / (LENGTH**2 / 3 + RADIUS**2 / 4))
print("period", 4 * ellipk(0.5) / w)
angle = 2 * np.arcsin(np.sqrt(0.5) * ellipj(ellipk(0.5) - w * TIME, 0.5)[0])
print("x, z of the tip", f"{LENGTH * np.sin(angle):.9f}", f"{-LENGTH * np.cos(angle):.9f}")
