"""Ball on two rails, simply supported beams that bend and shear: place of the middle of one of them, m. Each carries half of the weight and, because the
ball touches it at the angle alpha to the vertical, half of the weight times tan(alpha) outwards; alpha is that of the rails when bent apart."""

import math

from scipy.optimize import brentq

LENGTH, RADIUS, MODULUS, APART = 0.3, 0.002, 1e10, 0.01  # m, m, Pa, m: rail; APART: from the middle plane to its axis
BALL, DENSITY, G = 0.015, 2500.0, 9.81  # m, kg/m^3, m/s^2

weight = DENSITY * 4 / 3 * math.pi * BALL**3 * G
area, inertia = math.pi * RADIUS**2, math.pi / 4 * RADIUS**4
flexibility = LENGTH**3 / (48 * MODULUS * inertia) + LENGTH / (4 * 27 / 28 * MODULUS / 3 * area)  # m/N


def outwards(side):
    return 0.5 * weight * side / math.sqrt((BALL + RADIUS)**2 - side**2)


side = brentq(lambda side: side - APART - flexibility * outwards(side), APART, 0.99 * (BALL + RADIUS), xtol=1e-15)
print(f"z {-0.5 * weight * flexibility:.12g} y {side:.12g}")
