#!/usr/bin/env python3
"""Writes traces.h5: a tuft of 32 filaments as a program that traces them in an image would give them, points along each and its radius there.

Filament i grows from the i-th point of a sunflower, R sqrt((i + 1/2)/32) from the middle in the direction of i golden angles, which is also
the way it leans, by an angle that rises towards the rim. With u = s/L from 0 at its foot to 1 at its tip its tangent has

  angle to the vertical   theta = lean + curl u^2
  azimuth                 phi   = azimuth of the foot +- winding u^2    (every other one to the left)

so tips curl. Nodes are sums of the tangents at the middles of the elements, which are L/24 long. Lengths, radii, curl and winding follow
from i by multiples of irrational numbers; the radius falls to 0.4 of that at the foot. All in metres, rounded to 1 nm.
"""

import argparse
import pathlib

import h5py
import numpy

FILAMENTS, ELEMENTS = 32, 24
FOOT = 8e-3                           # m: radius of the tuft on the ground
LENGTH, RADIUS = (10e-3, 22e-3), (60e-6, 120e-6)  # m: least and largest
LEAN, CURL, WINDING = 0.7, (0.5, 2.2), (0.5, 2.5)  # rad
TAPER = 0.4                           # radius at the tip over that at the foot
TRACES = pathlib.Path(__file__).with_name("traces.h5")


def between(limits, irrational):
    """A number per filament, spread evenly over the interval."""
    low, high = limits
    return low + (high - low) * numpy.modf((numpy.arange(FILAMENTS) + 0.5) * irrational)[0]


def traces():
    """Nodes [filaments, elements + 1, 3] and radii [filaments, elements + 1], m."""
    i = numpy.arange(FILAMENTS)
    out, azimuth = numpy.sqrt((i + 0.5) / FILAMENTS), i * numpy.pi * (3 - numpy.sqrt(5))
    length, radius = between(LENGTH, numpy.sqrt(2)), between(RADIUS, numpy.sqrt(3))
    u = (numpy.arange(ELEMENTS) + 0.5) / ELEMENTS
    theta = LEAN * out[:, None] + between(CURL, numpy.sqrt(5))[:, None] * u**2
    phi = azimuth[:, None] + ((-1.0) ** i * between(WINDING, numpy.sqrt(7)))[:, None] * u**2
    tangent = numpy.stack([numpy.sin(theta) * numpy.cos(phi), numpy.sin(theta) * numpy.sin(phi), numpy.cos(theta)], axis=-1)
    foot = FOOT * out[:, None] * numpy.stack([numpy.cos(azimuth), numpy.sin(azimuth), 0 * azimuth], axis=-1)
    steps = length[:, None, None] / ELEMENTS * tangent
    nodes = foot[:, None] + numpy.concatenate([numpy.zeros((FILAMENTS, 1, 3)), numpy.cumsum(steps, axis=1)], axis=1)
    radii = radius[:, None] * (1 - (1 - TAPER) * numpy.linspace(0, 1, ELEMENTS + 1))
    return numpy.round(nodes, 9), numpy.round(radii, 9)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--file", type=pathlib.Path, default=TRACES, help="written over")
    options = parser.parse_args()
    nodes, radii = traces()
    with h5py.File(options.file, "w") as file:
        file["nodes"], file["radii"] = nodes, radii


if __name__ == "__main__":
    main()
