"""Classical mechanisms of bodies, rods and joints against closed forms, ordinary differential equations and the rod in one piece."""

import os
import unittest

import numpy as np

from package import skein

GRAVITY = 9.81
WORLD = "world"


def bar(name, start, end, mass, **keys):
    """A slender bar in the plane of x and y, its normal along it."""
    start, end = np.array([*start, 0.0]), np.array([*end, 0.0])
    about = inertia(start, end, mass)
    return {"name": name, "mass": mass, "inertia": [0.1 * about, about, about], "spheres": {"radii": [0.01]},
            "placement": {"origin": list(0.5 * (start + end)), "normal": list(end - start), "tangent": [0.0, 0.0, 1.0]}, **keys}


def inertia(start, end, mass):
    return mass * np.sum(np.subtract(end, start)**2) / 12


def hinge(first, second, place, k, **keys):
    """A hinge about z; its torsional stiffness is of the size k times the square of a bar's length."""
    return {"kind": "hinge", "between": [first, second], "place": [*place, 0.0], "axis": [0.0, 0.0, 1.0], "stiffness": k, "torsional_stiffness": 0.1 * k, **keys}


def scene(bodies, joints, duration, dt, **tables):
    return {"time": {"duration": duration, "dt": dt}, "bodies": bodies, "joint": joints, **tables}


def opened(tables):
    return skein.Simulation(skein.Scene("linkage", **tables), threads=1)


def samples(tables, count, *figures):
    """Values of the figures, functions of the run and of its directors at the start, at `count` times and as many steps apart."""
    with opened(tables) as run:
        start = {name: run[name].directors[0, 0].copy() for name in run.groups}
        found = []
        for _ in range(count):
            run.step(run.steps // count)
            found.append([figure(run, start) for figure in figures])
    return np.array(found).T


def turn(name, axis=(0, 0, 1)):
    """The angle by which a body has turned about an axis, between -pi and pi."""
    def found(run, start):
        r = run[name].directors[0, 0].T @ start[name]
        return np.arctan2(np.dot(axis, [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]), np.trace(r) - 1)
    return found


def gap(run, start):
    return run.observables["joint_gap[m]"]


def solved(rates, y, end, steps, samples=1):
    """States at `samples` times by Runge and Kutta's fourth order."""
    h, found = end / steps, []
    for i in range(steps):
        a = rates(y)
        b = rates(y + 0.5 * h * a)
        c = rates(y + 0.5 * h * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rates(y + h * c))
        if (i + 1) % (steps // samples) == 0: found.append(y)
    return np.array(found)
