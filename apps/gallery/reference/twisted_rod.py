#!/usr/bin/python3
"""Clamped rods of twisted_rod.toml under a pull T and a couple of twist M: the couple at which they buckle, and their deflections under a sideways
acceleration. With w = y + i z: rho A w_tt = -E I w'''' + i M w''' + T w'' + rho A a, in polynomials that meet the clamps."""

import numpy as np
from numpy.polynomial import Legendre
from scipy.linalg import eigh
from scipy.optimize import brentq

LENGTH, RADIUS, YOUNG, SHEAR, DENSITY = 1.0, 0.003, 1e6, 7.5e5, 1000.0  # m, m, Pa, Pa, kg/m^3
PULL, PUSH, END = 20.0, 3e-6, 3.0  # T L^2/(E I), m/s^2, s
mass, bending = DENSITY * np.pi * RADIUS**2, YOUNG * np.pi * RADIUS**4 / 4
shapes = [Legendre.fromroots([-1, -1, 1, 1]) * Legendre.basis(n) for n in range(18)]  # of x = 2 s/L - 1
x, weights = np.polynomial.legendre.leggauss(32)


def products(a, b): return 0.5 * LENGTH * (2 / LENGTH) ** (a + b) * np.array([[weights @ (u.deriv(a)(x) * v.deriv(b)(x)) for v in shapes] for u in shapes])


bent, turned, pulled, masses = products(2, 2), products(1, 2), products(1, 1), products(0, 0)
forces = 0.5 * LENGTH * np.array([weights @ u(x) for u in shapes])


def modes(couple):
    """Squares of the frequencies and the modes."""
    return eigh(bending * bent + PULL * bending / LENGTH**2 * pulled + 1j * couple * turned, mass * masses)


critical = brentq(lambda couple: modes(couple)[0][0], bending / LENGTH, 20 * bending / LENGTH, xtol=1e-18)
print(f"critical M L/(E I) {critical * LENGTH / bending:.6f}; rest twist at it {critical / (SHEAR * np.pi * RADIUS**4 / 2):.9f} rad/m")
print(f"rest strain {-PULL * bending / LENGTH**2 / (YOUNG * np.pi * RADIUS**2):.9g}, pull {PULL * bending / LENGTH**2:.9g} N")
for share in (0.9, 1.1):
    squares, vectors = modes(share * critical)
    rates = np.sqrt(squares.astype(complex))
    parts = mass * PUSH * (vectors.conj().T @ forces) * np.real((1 - np.cos(rates * END)) / squares)
    for place in (0.25, 0.5):
        w = np.array([u(2 * place - 1) for u in shapes]) @ (vectors @ parts)
        print(f"at {share} of it: squares of rates {squares[0]:.6g} {squares[1]:.6g} 1/s^2, y {w.real:.9g} z {w.imag:.9g} m at {place}")
