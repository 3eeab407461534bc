"""Tip of a magnetised rod in a constant field across it, by shooting: x(L), z(L) in m.

Arc length s, curvature and moment in units of the rest length L. m = M / (E I), bond = M B A L^2 / (E I).
theta' = m e^3, m' = -bond cos(theta), x' = e sin(theta), z' = e cos(theta), m(1) = 0, with the stretch e of bending in an incompressible rod.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

LENGTH, RADIUS, YOUNG = 0.02, 2e-4, 1.85e5
BOND = 4 * 5000.0 * 2.775e-3 * LENGTH**2 / (YOUNG * RADIUS**2)


def stretch(moment):
    """1 - 1/e = 1.5 (r/2)^2 (theta'/e^2)^2 with theta' = moment e^3."""
    e = 1.0
    for _ in range(50): e = 1 / (1 - 1.5 * (RADIUS / LENGTH / 2) ** 2 * (moment * e) ** 2)
    return e


def shoot(start):
    def slopes(_, state):
        theta, moment = state[:2]
        e = stretch(moment)
        return [moment * e**3, -BOND * np.cos(theta), e * np.sin(theta), e * np.cos(theta)]

    return solve_ivp(slopes, (0, 1), [0, start, 0, 0], rtol=1e-11, atol=1e-13).y[:, -1]


if __name__ == "__main__":
    tip = shoot(brentq(lambda start: shoot(start)[1], 0.1, BOND, xtol=1e-13))
    print(f"x {LENGTH * tip[2]:.9g}  z {LENGTH * tip[3]:.9g}")
