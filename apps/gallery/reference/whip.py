#!/usr/bin/python3
"""Plane chain of whip.toml, of stiff links on hinges without play, in the angles of its links: middle of the last link and its velocity at the end."""

import numpy as np
from scipy.integrate import solve_ivp

LINKS, LENGTH, MASS, INERTIA, G, END = 6, 0.1, 0.05, 4.1666666666666667e-5, 9.81, 0.36  # -, m, kg, kg m^2, m/s^2, s
reach = LENGTH * (np.tri(LINKS) - 0.5 * np.eye(LINKS))  # way to the middle of link k along link i
coupled, lever = MASS * reach.T @ reach, MASS * G * reach.sum(axis=0)


def rates(_, state):
    angle, spin = state[:LINKS], state[LINKS:]  # rad below the horizontal
    between = angle[:, None] - angle
    inertia = coupled * np.cos(between) + INERTIA * np.eye(LINKS)
    return np.concatenate((spin, np.linalg.solve(inertia, lever * np.cos(angle) - coupled * np.sin(between) @ spin**2)))


end = solve_ivp(rates, (0, END), np.zeros(2 * LINKS), method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
along, down = np.cos(end[:LINKS]), np.sin(end[:LINKS])
print(f"x, z {reach[-1] @ along:.9f} {-reach[-1] @ down:.9f} m")
print(f"velocity {-reach[-1] @ (down * end[LINKS:]):.9f} {-reach[-1] @ (along * end[LINKS:]):.9f} m/s")
