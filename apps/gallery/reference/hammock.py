#!/usr/bin/python3
"""Log on the two cords of hammock.toml: height of its axis over the pins, strain of the cords. A cord without friction and bending stiffness is straight
to the log, an arc round it, straight to the other pin. It pulls with E A times its strain, and both ends of both cords carry the weight."""

import numpy as np
from scipy.optimize import brentq

LENGTH, ELEMENTS, ANGLE = 0.5, 100, 0.01  # the pins are at the ends of a polygon that turns by ANGLE from element to element
RADIUS, MODULUS = 0.001, 1e7  # m, Pa
LOG, BETWEEN, DENSITY, G = 0.03, 0.15, 190.0, 9.81  # m, m, kg/m^3, m/s^2
half = LENGTH / ELEMENTS * np.sin(ELEMENTS * ANGLE / 2) / np.sin(ANGLE / 2) / 2
weight, reach = DENSITY * np.pi * LOG**2 * (BETWEEN + 4 / 3 * LOG) * G, LOG + RADIUS


def cords(depth):
    """Strain, and the force that carries the log."""
    far = np.hypot(half, depth)
    slope = np.arctan2(depth, half) + np.arcsin(reach / far)  # of the straight parts; also half of the arc
    strain = 2 * (np.sqrt(far**2 - reach**2) + reach * slope) / LENGTH - 1
    return strain, 4 * MODULUS * np.pi * RADIUS**2 * strain * np.sin(slope)


depth = brentq(lambda depth: cords(depth)[1] - weight, 0.0, 0.2, xtol=1e-15)
print(f"span {2 * half:.9f} m, weight {weight:.6f} N, height of the axis {-depth:.9f} m, strain {cords(depth)[0]:.9f}")
