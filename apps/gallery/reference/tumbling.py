"""Euler's equations of a free block, and the directions of its axes: its first axis and its spin in the lab after 3 s."""

import numpy
from scipy.integrate import solve_ivp

SIDES, SPIN, TIME = numpy.array([0.1, 0.06, 0.02]), (0.1, 10.0, 0.0), 3.0  # m, rad/s, s
J = (sum(SIDES**2) - SIDES**2) / 12  # of a unit mass


def rates(_, state):
    spin, axes = state[:3], state[3:].reshape(3, 3)  # both in the block's axes: rows of axes are the lab's directions
    return numpy.concatenate((numpy.cross(J * spin, spin) / J, numpy.cross(axes, spin).ravel()))


end = solve_ivp(rates, (0, TIME), numpy.concatenate((SPIN, numpy.eye(3).ravel())), method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
axes = end[3:].reshape(3, 3)
print("axis", *(f"{number:.10g}" for number in axes[:, 0]), "spin", *(f"{number:.10g}" for number in axes @ end[:3]))
