#!/usr/bin/python3
"""Point under the press of apps/mechanisms/frame.toml at rest at the end of its way: a plane Cosserat rod of column and beam by shooting."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

LENGTH, DOWN, PRESS = 1.2, 0.525, 1e6
E, AREA, SECOND_MOMENT = 7.2e10, 6e-4, 2e-8
SHEAR = 27 / 28 * E / 3 * AREA


def member(y, force, length):
    """The end of a member from its start: x, y, angle, moment; `force` acts on every section from the side of the end."""
    def rate(s, y):
        c, s = np.cos(y[2]), np.sin(y[2])
        along, aside = 1 + (force[0] * c + force[1] * s) / (E * AREA), (force[1] * c - force[0] * s) / SHEAR
        dx, dy = along * c - aside * s, along * s + aside * c
        return [dx, dy, y[3] / (E * SECOND_MOMENT), dy * force[0] - dx * force[1]]
    return solve_ivp(rate, (0, length), y, method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]


def frame(unknown):
    """Corner, point under the press and far end, for reactions at the foot, the angle there and the load in units of 10 kN."""
    across, up, load = 1e4 * unknown[[0, 1, 3]]
    corner = member([0, 0, unknown[2], 0], (-across, -up), LENGTH) - [0, 0, np.pi / 2, 0]
    under = member(corner, (-across, -up), LENGTH / 5)
    return corner, under, member(under, (-across, load - up), 0.8 * LENGTH), load


def missing(unknown, down, press):
    _, under, end, load = frame(unknown)
    return [end[0] - LENGTH, end[1] - LENGTH, end[3] / 1e4, LENGTH - down - under[1] + load / press]


unknown = np.array([0.01, 0.01, np.pi / 2, 0.01])
for down in np.linspace(0.03, DOWN, 30):
    found = root(missing, unknown, (down, PRESS), tol=1e-11)
    if not found.success and np.abs(found.fun).max() > 1e-9: raise RuntimeError(found.message)
    unknown = found.x
corner, under, _, load = frame(unknown)
print("load", f"{load:.3f}", "N, the press is shorter by", f"{load / PRESS:.9f}", "m")
print("x, y of the point", f"{under[0]:.9f}", f"{under[1]:.9f}", "of the corner", f"{corner[0]:.9f}", f"{corner[1]:.9f}")
