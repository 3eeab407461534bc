"""State of rest of a clamped Cosserat rod by shooting, with shear, stretch and twist; for the references beside this file. Needs numpy and scipy."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

SHEAR = 27 / 28  # Timoshenko's factor of a round section of incompressible material


def circle(E, r, G=0.0):
    """Stiffnesses of a round section: E I1, E I2, G I3, and alpha G A, alpha G A, E A."""
    A, second, G = np.pi * r**2, np.pi * r**4 / 4, G or E / 3
    return np.array([E * second, E * second, 2 * G * second]), np.array([SHEAR * G * A, SHEAR * G * A, E * A])


def shoot(length, bending, stretching, tangent, normal, force, weight=(0, 0, 0), loads=20, moment=(0, 0, 0)):
    """Places [3, 201] and frames [201, 3, 3] (rows d1, d2, d3) along a rod that is clamped at s = 0, with a force at its end and a force per rest
    length; strains n = S nu, moments m = B kappa (law "linear"). The moment at the clamp is sought; the load is raised in `loads` parts."""
    force, weight = np.array(force, float), np.array(weight, float)
    d3 = np.array(tangent, float) / np.linalg.norm(tangent)
    d1 = np.array(normal, float) - np.dot(normal, d3) * d3
    d1 /= np.linalg.norm(d1)
    frame = np.array([d1, np.cross(d3, d1), d3])
    at = np.linspace(0, length, 201)

    def integrate(m0, part):
        def rate(s, y):
            Q, m = y[3:12].reshape(3, 3), y[12:]
            n = part * (force + weight * (length - s))
            r = Q.T @ (np.array([0, 0, 1]) + Q @ n / stretching)
            kappa = Q.T @ ((Q @ m) / bending)
            return np.concatenate([r, np.cross(kappa, Q).ravel(), np.cross(n, r)])

        start = np.concatenate([np.zeros(3), frame.ravel(), m0])
        return solve_ivp(rate, (0, length), start, method="DOP853", t_eval=at, rtol=1e-11, atol=1e-13).y

    scale = bending[0] / length
    moment = np.array(moment, float) / scale
    for part in np.linspace(1 / loads, 1, loads):
        found = root(lambda m: integrate(m * scale, part)[12:, -1] / scale, moment, tol=1e-11)
        if not found.success and np.abs(found.fun).max() > 1e-8: raise RuntimeError(found.message)
        moment = found.x
    y = integrate(moment * scale, 1)
    return y[:3], np.moveaxis(y[3:12].reshape(3, 3, -1), 2, 0)
