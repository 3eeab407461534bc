"""Scenes that are solved for rest, for their modes and along a path, with their tables as arrays; independent solutions of rods at rest."""

import csv
import math
import subprocess

import numpy

from driver import SKEIN
from single_runs import SingleRuns

SHEAR = 27 / 28  # Timoshenko's factor of a round section of incompressible material


class SolvedScenes(SingleRuns):
    def solve(self, command, out, text, *arguments, expect=0):
        """Results are in the folder `out` of the test's directory; what the program printed."""
        scene = self.directory / f"{out}.toml"
        scene.write_text(text)
        words = [SKEIN, command, str(scene), "--out", str(self.directory / out), "--threads", "1", "--quiet", "--overwrite", *map(str, arguments)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done

    def at_rest(self, text, *arguments):
        """Last values of the time series of an equilibrium, by the names of its columns."""
        self.solve("equilibrium", "rest", text, *arguments)
        return {name: values[-1] for name, values in self.series("rest").items()}

    def modes(self, text, *arguments):
        """Frequencies in Hz without those of neutral motions, which come as a number beside them; negative where a motion grows."""
        self.solve("modes", "modes", text, *arguments)
        rows = self.table("modes/modes.csv")
        return (numpy.array([float(row["frequency"]) for row in rows if row["neutral"] == "0"]),
                sum(row["neutral"] == "1" for row in rows))

    def path(self, text, *arguments):
        """Rows of a path, with the number as 'value'."""
        self.solve("path", "path", text, *arguments)
        rows = self.table("path/path.csv")
        key = list(rows[0])[2]
        return [row | {"value": float(row[key]), "negative": int(row["negative"])} for row in rows]

    def places(self, text, place, *arguments):
        """Values of the number at the limit or branch points of a path."""
        return [row["value"] for row in self.path(text, *arguments) if row["place"] == place]

    def table(self, name):
        with open(self.directory / name, newline="") as file:
            return [{key.split("[")[0]: value for key, value in row.items()} for row in csv.DictReader(file)]

    def assert_second_order(self, name, values, exact, scale=None, richardson=1e-4, orders=(1.9, 2.1)):
        """Of values for n, 2n and 4n."""
        error = (numpy.array(values) - exact) / (abs(exact) if scale is None else scale)
        order = [math.log2(abs(error[i] / error[i + 1])) for i in (0, 1)]
        left = (4 * error[2] - error[1]) / 3
        print(f"  {name}: errors {error[0]:+.2e} {error[1]:+.2e} {error[2]:+.2e}, orders {order[0]:.3f} {order[1]:.3f}, Richardson {left:+.1e}")
        for one in order:
            self.assertTrue(orders[0] <= one <= orders[1], f"{name}: orders {order}")
        self.assertLess(abs(left), richardson, name)
        return error


def rod(name, length, elements, youngs_modulus, section, tangent=(1, 0, 0), normal=(0, 0, 1), more="", **material):
    """[[rods]] of a scene, law "linear". `section`: a radius, or keys; `more`: lines of the group itself."""
    if not isinstance(section, str):
        section = f"radius = {section}"
    keys = "".join(f", {key} = {value}" for key, value in ({"density": 1000.0} | material).items())
    return (f'[[rods]]\nname = "{name}"\n{more}\nmaterial = {{law = "linear", youngs_modulus = {youngs_modulus}{keys}}}\n'
            f"section = {{{section}}}\nshape = {{length = {length}, elements = {elements}}}\n"
            f"placement = {{tangent = {list(tangent)}, normal = {list(normal)}}}\n")


def of_circle(E, r, G=None):
    """Stiffnesses of bending and twist, of shear and stretch."""
    A, second, G = math.pi * r**2, math.pi * r**4 / 4, G or E / 3
    return numpy.array([E * second, E * second, 2 * G * second]), numpy.array([SHEAR * G * A, SHEAR * G * A, E * A])


def of_rectangle(E, G, b, t, shear):
    """The same for sides b along d1 and t < b along d2."""
    odd = numpy.arange(1, 200, 2)
    torsion = b * t**3 / 3 * (1 - 192 * t / (numpy.pi**5 * b) * numpy.sum(numpy.tanh(odd * numpy.pi * b / (2 * t)) / odd**5))  # St Venant
    return (numpy.array([E * b * t**3 / 12, E * t * b**3 / 12, G * torsion]), numpy.array([shear * G * b * t, shear * G * b * t, E * b * t]))


def march(rate, y, length, steps=120):
    """Runge and Kutta's method of fourth order; columns of y go side by side."""
    h = length / steps
    for i in range(steps):
        s = i * h
        k1 = rate(s, y)
        k2 = rate(s + h / 2, y + h / 2 * k1)
        k3 = rate(s + h / 2, y + h / 2 * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(s + h, y + h * k3))
    return y


def root(off, x, tolerance=1e-11, step=1e-6):
    """Newton's method; `off` maps columns of unknowns to columns of what is to vanish."""
    x = numpy.array(x, float)
    for _ in range(60):
        columns = numpy.concatenate([x[:, None], x[:, None] + step * numpy.eye(len(x)), x[:, None] - step * numpy.eye(len(x))], axis=1)
        found = off(columns)
        slopes = (found[:, 1:1 + len(x)] - found[:, 1 + len(x):]) / (2 * step)
        change = numpy.linalg.solve(slopes, -found[:, 0])
        x = x + change * min(1, 1 / max(1e-300, numpy.abs(change).max()))
        if numpy.abs(change).max() < tolerance * max(1, numpy.abs(x).max()):
            return x
    raise RuntimeError("no root")


def rod_rate(bending, stretching, force, rest=(0, 0, 0)):
    """Slopes of place, frame (rows d1, d2, d3) and moment [15, columns] of a rod at rest; force(s, y) on its sections, lab; `rest`: curvature
    without a moment."""
    def rate(s, y):
        Q, m = y[3:12].reshape(3, 3, -1), y[12:]
        n = force(s, y)
        strain = numpy.einsum("ijc,jc->ic", Q, n) / stretching[:, None]
        strain[2] += 1
        r = numpy.einsum("jic,jc->ic", Q, strain)
        kappa = numpy.einsum("jic,jc->ic", Q, numpy.einsum("ijc,jc->ic", Q, m) / bending[:, None] + numpy.array(rest)[:, None])
        turned = numpy.cross(kappa[None], Q, axisa=1, axisb=1, axisc=1)
        return numpy.concatenate([r, turned.reshape(9, -1), numpy.cross(n, r, axisa=0, axisb=0, axisc=0)])
    return rate


def clamped_tip(length, bending, stretching, frame, force, parts=6, rest=(0, 0, 0)):
    """Place of the tip of a clamped rod under a force on it; the force is raised in parts."""
    frame, force, scale = numpy.array(frame, float).reshape(9), numpy.array(force, float), bending[0] / length
    moment = numpy.zeros(3)

    def end(moments, part):
        columns = moments.shape[1]
        start = numpy.concatenate([numpy.zeros((3, columns)), numpy.repeat(frame[:, None], columns, 1), scale * moments])
        return march(rod_rate(bending, stretching, lambda s, y: part * numpy.repeat(force[:, None], columns, 1), rest), start, length)

    for part in numpy.linspace(1 / parts, 1, parts):
        moment = root(lambda moments: end(moments, part)[12:] / scale, moment)
    return end(moment[:, None], 1)[:3, 0]
