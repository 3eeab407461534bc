#!/usr/bin/python3
"""Two strands of strands.toml, helices round a core: the force with which each presses on the core, and its strain. A strand is a polygon whose elements
of the length h turn by ANGLE about the axis; its nodes stand on the core. Nodes at the clamps do not press."""

import numpy as np

LENGTH, ELEMENTS, TURNS = 1.0, 200, 3  # m, -, -
CORE, RADIUS, YOUNG, PULL, STIFFNESS = 0.001, 0.004, 1e8, 10.0, 1e5  # m, m, Pa, N, N/m
h, angle = LENGTH / ELEMENTS, 2 * np.pi * TURNS / ELEMENTS
rate, area, bending = angle / h, np.pi * RADIUS**2, YOUNG * np.pi * RADIUS**4 / 4
twisting = bending * 2 / 3  # incompressible


def shape(node, stretch):
    """Angle to the axis, curvature and twist of elements whose nodes are at this distance from it."""
    slope = np.arcsin(2 * node * np.sin(angle / 2) / (h * (1 + stretch)))
    return slope, rate * np.sin(slope), rate * np.cos(slope)


start, curvature, rest_twist = shape(CORE + RADIUS, 0)
print(f"at the start: curvature {curvature:.12g}, twist {rest_twist:.12g} 1/m")
print(f"tangent 0 {np.sin(start):.12g} {np.cos(start):.12g}")
press = stretch = 0.0
for _ in range(100):
    slope, curvature, twist = shape(CORE + RADIUS - press / STIFFNESS, stretch)
    couple = twisting * (twist - rest_twist)
    # Couples and forces turn about the axis with the rod. The force has the part PULL along the axis and this one around it.
    around = PULL * np.tan(slope) + rate * (bending * curvature - couple * np.tan(slope)) / (1 + stretch)
    press, stretch = 2 * np.sin(angle / 2) * around, (around * np.sin(slope) + PULL * np.cos(slope)) / (YOUNG * area)
print(f"thin strands {np.sin(start)**2 / (CORE + RADIUS) * (PULL + bending * rest_twist**2):.6g} N/m, here {press / h:.9g} N/m")
print(f"both strands {2 * (ELEMENTS - 1) * press:.9g} N, overlap {press / STIFFNESS:.6g} m, strain {stretch:.9g}")
