"""Elements that `skein converge` recommends for a thousandth, on scenes that are solved: their solution is within a thousandth of an independent
one. Prints the elements, the error, and what converge says of its method."""

import json
import math
import pathlib
import unittest

import h5py
import numpy

from branch_points_test import lees_limits
from driver import launch
from solved_scenes import SolvedScenes, clamped_tip, of_circle, of_rectangle

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
BAR = 1e-3


class RecommendedElements(SolvedScenes):
    def skein(self, command, scene, *words):
        done = launch(command, APPS / scene, "--threads", 1, "--json", *words, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads(done.stdout)

    def recommended(self, scene, *words, method="equilibrium"):
        """Elements of the group with the most, by solutions alone."""
        figures = self.skein("converge", scene, "--tolerance", BAR, "--out", self.directory / "converge", *words)
        self.assertEqual(figures["method"], method)
        advice = figures["advice"]
        self.assertEqual(advice["untold"], [])
        print(f"  {scene}: {advice['elements']} elements, by {', '.join(advice['by'])}")
        return advice["elements"]

    def at(self, elements, scene, group, *words):
        """Columns of the equilibrium with so many elements, at the start and at the end."""
        self.skein("equilibrium", scene, "--set", f"rods.{group}.shape.elements={elements}", "--out", self.directory / "rest", *words)
        return self.series("rest")

    def assert_meets(self, name, found, exact, size=None):
        """`size`: what the error is over; the value itself where it is none."""
        error = numpy.linalg.norm(numpy.subtract(found, exact)) / (numpy.linalg.norm(exact) if size is None else size)
        print(f"    {name}: error {error:.2e}")
        self.assertLessEqual(error, BAR, name)

    def assert_tip_meets(self, columns, exact):
        tip = numpy.stack([columns[f"tip_{axis}"] for axis in "xyz"], axis=1)
        self.assert_meets("tip over its way", tip[-1], exact, numpy.linalg.norm(exact - tip[0]))

    def test_princeton_beam(self):
        half = math.sqrt(0.5)
        bending, stretching = of_rectangle(7.17e10, 2.7e10, 2 * 6.3848e-3, 2 * 1.6012e-3, 0.8333)
        exact = clamped_tip(0.508, bending, stretching, ((0, half, half), (0, -half, half), (1, 0, 0)), (0, 0, -13.345))
        n = self.recommended("gallery/princeton.toml", "--equilibrium")
        columns = self.at(n, "gallery/princeton.toml", "bar")
        self.assert_tip_meets(columns, exact)
        for axis, value in (("y", exact[1]), ("z", exact[2])):
            self.assert_meets(axis, columns[f"tip_{axis}"][-1], value)

    def test_bend_of_45_degrees(self):
        bending, stretching = of_rectangle(1e7, 5e6, 1.0, 1.0, 0.8333)
        exact = clamped_tip(25 * math.pi, bending, stretching, ((0, 0, -1), (-1, 0, 0), (0, 1, 0)), (0, 0, 600.0), rest=(0.01, 0, 0))
        n = self.recommended("statics/bend_45.toml", "--equilibrium")
        columns = self.at(n, "statics/bend_45.toml", "bend")
        self.assert_tip_meets(columns, exact)
        for axis, value in zip("xyz", exact):
            self.assert_meets(axis, columns[f"tip_{axis}"][-1], value)

    def test_lees_frame(self):
        """Both limit loads; members of other lengths have elements in proportion."""
        along = ("--along", "constants.weight.value", "--to", 20000)
        n = 5 * math.ceil(self.recommended("statics/lee_frame.toml", *along, method="path") / 5)
        members = {"column": n, "inner": n // 5, "outer": n - n // 5}
        sets = [word for name, count in members.items() for word in ("--set", f"rods.{name}.shape.elements={count}", "--set",
                                                                     f"rods.{name}.hold.nodes={list(range(1, count))}")]
        limits = self.skein("path", "statics/lee_frame.toml", *along, *sets, "--out", self.directory / "path")["limits"]
        for name, found, exact in zip(("first limit", "second limit"), limits, lees_limits(), strict=True):
            self.assert_meets(name, found, exact)

    def test_bend_by_a_couple(self):
        """A half circle: the tip, the middle, and the direction of the last element, whose middle is half an element before the end."""
        n = self.recommended("statics/arc.toml", "--equilibrium", "--observable", "tip of rod 0")
        columns = self.at(n, "statics/arc.toml", "rod")
        self.assert_tip_meets(columns, numpy.array([0, -2 / math.pi, 0]))
        angle = math.pi * (1 - 0.5 / n)
        direction = [columns[f"axis_{axis}"][-1] for axis in "xyz"]
        self.assert_meets("direction of the last element", direction, (0, -math.sin(angle), math.cos(angle)))

    def test_twist(self):
        bending, _ = of_circle(1e8, 0.01)
        n = self.recommended("statics/twist.toml", "--equilibrium")
        columns = self.at(n, "statics/twist.toml", "rod", "--set", "output.precision=double")
        self.assert_meets("energy of twist", columns["elastic_twist"][-1], bending[2] * math.pi**2 / 2)
        with h5py.File(next((self.directory / "rest").glob("trajectory_*.h5"))) as file:
            directors = file["groups/rod/directors"][-1, 0]
        start = directors[0]
        for k, now in enumerate(directors):
            middle = (k + 0.5) / n
            self.assert_meets(f"angle of element {k}", self.angle_about_z(now), math.pi * middle)

    def angle_about_z(self, directors):
        return math.atan2(directors[0][1], directors[0][0])

    def test_twisted_ring(self):
        """Michell's and Zajac's turns of an inextensible ring."""
        along = ("--along", "rods.ring.shape.rest_curvature.2", "--to", 8.7)
        n = self.recommended("statics/twisted_ring.toml", *along, method="path")
        found = self.skein("path", "statics/twisted_ring.toml", *along, "--set", f"rods.ring.shape.elements={n}", "--out", self.directory / "path")
        bending, _ = of_circle(1e9, 1.6e-4, 7.5e8)
        self.assert_meets("critical twist", found["branches"][0], 2 * math.pi * math.sqrt(3) * bending[0] / bending[2])


if __name__ == "__main__":
    unittest.main()
