"""Tip of a cantilever let go under its weight, small deflections (Euler and Bernoulli), by modes: z at t = 2 s, the lowest z, in m.

Mode n: cosh(b) cos(b) = -1, omega = b^2 sqrt(E I / (rho A L^4)). A weight g per mass gives the tip the sum of
-g P / omega^2 (1 - cos(omega t)), P = phi(L) integral(phi) / integral(phi^2).
"""

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

LENGTH, RADIUS, YOUNG, DENSITY, GRAVITY, END = 1.0, 5e-3, 1e9, 1000.0, 0.01, 2.0


def mode(n):
    """b and the share P of mode n = 0, 1, ..."""
    b = brentq(lambda b: np.cos(b) + 1 / np.cosh(b), n * np.pi + (1 if n == 0 else 0), (n + 1) * np.pi, xtol=1e-14)
    ratio = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    shape = lambda s: np.cosh(b * s) - np.cos(b * s) - ratio * (np.sinh(b * s) - np.sin(b * s))
    return b, shape(1) * quad(shape, 0, 1, limit=200)[0] / quad(lambda s: shape(s) ** 2, 0, 1, limit=200)[0]


if __name__ == "__main__":
    unit = np.sqrt(YOUNG * RADIUS**2 / (4 * DENSITY * LENGTH**4))
    times = np.append(np.linspace(0, END, 20001), END)
    tip = np.zeros_like(times)
    for n in range(6):
        b, share = mode(n)
        omega = b**2 * unit
        tip -= GRAVITY * share / omega**2 * (1 - np.cos(omega * times))
        print(f"mode {n + 1}: omega / unit {b**2:.6g}, period {2 * np.pi / omega:.6g} s, share {share:.6g}")
    print(f"z at the end {tip[-1]:.9g}  lowest {tip.min():.9g}")
