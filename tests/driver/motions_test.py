"""Ends that move by formulas of time: the same bits for all layouts, and of a run that was stopped in mid-motion."""

import math
import unittest

import numpy

from driver import DriverTest

SCENE = """
title = "Shaken by formulas"
[time]
duration = 0.4
[constants]
d = { value = 0.02, unit = "m" }
T = { value = 0.13, unit = "s" }
[[table]]
name = "lift"
at = [0.0, 0.1, 0.4]
value = [0.0, 0.01, 0.03]
unit = "m"
[[rods]]
name = "shaken"
start = "clamped"
end = "pinned"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
shear_modulus = 4e5
[rods.section]
radius = 0.02
[rods.shape]
length = 1.0
elements = 10
[rods.placement]
kind = "line"
counts = [9]
spacing = [0.3]
[rods.start_motion]
translation_formula = ["d*sin(2*pi*t/T)*ramp(t, T)", "0", "lift(t)"]
rotation_formula = ["0.1*sin(2*pi*t/T)", "0", "exp(-t/T) - 1"]
[rods.end_motion]
translation_formula = ["0", "d*(t/T)^2*exp(-t/T)", "-lift(t)"]
[output]
trajectory = 0.1
tips = 0.02
series = 0.05
checkpoint = 0.1
"""


class Motions(DriverTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(SCENE)

    def test_layouts(self):
        self.run_skein("one")
        self.assert_layouts_give("one", lambda out: self.assertEqual(self.results(out), self.results("one"), out))

    def test_restart_in_mid_motion(self):
        self.run_skein("whole", threads=2)
        self.run_skein("parts", "--until", "0.17", ranks=2)
        self.assertIn("Resuming from", self.run_skein("parts").stdout)
        self.assertEqual(self.digest("parts"), self.digest("whole"))
        self.assert_same_series("parts", "whole")
        self.assert_same_frames("parts", "whole", "shaken")

    def test_ends_are_where_the_formulas_say(self):
        """Frames show positions half a step further on at the velocity of then: h^2/8 times the acceleration is left."""
        self.run_skein("out", "--set", "output.precision=\"double\"")
        frames = self.frames("out", "trajectory")
        t, first = frames["time"], frames["groups/shaken/position"][:, :, 0]
        says = numpy.stack([0.02 * numpy.sin(2 * math.pi * t / 0.13) * numpy.clip(t / 0.13, 0, 1), 0 * t,
                            numpy.interp(t, [0, 0.1, 0.4], [0, 0.01, 0.03])], axis=-1)
        step = t[-1] / self.summary("out")["steps"]
        left = step**2 / 8 * 0.02 * (2 * math.pi / 0.13) * (2 * math.pi + 2) / 0.13
        moved = first - first[0]
        self.assertLess(abs(moved - says[:, None]).max(), left)
        self.assertGreater(abs(says).max(), 1e3 * left)


    def test_walls_of_the_published_law(self):
        """A clamp that turns takes its rod to the rest of one that was placed so, from the start or as one of several."""
        def rods(placement, motion=""):
            return (f'time = {{duration = 4.0}}\noutput = {{series = 4.0}}\ndamping = [{{kind = "uniform", rate = 12.0}}]\nload = [{{kind = "gravity"}}]\n[[rods]]\nname = "rod"\nstart = "clamped"\n'
                    'material = {law = "elastica", density = 1000.0, youngs_modulus = 1e7}\nsection.radius = 0.02\nshape = {length = 0.5, elements = 10}\n' + f"placement = {placement}\n" + motion)

        def centre(name, scene):
            self.scene.write_text(scene)
            self.run_skein(name)
            end = numpy.atleast_1d(self.series(name))[-1]
            return numpy.array([end[f"centre_{axis}m"] for axis in "xyz"]), end["max_speedms"]

        turn, axis = 0.6, numpy.array([0.6, 0.8, 0.0])
        directions = [[math.sin(turn) * axis[1], -math.sin(turn) * axis[0], math.cos(turn)], [1.0, 0.0, 0.0]]
        turned, speed = centre("turned", rods("{tangent = [0, 0, 1]}", f"start_motion = {{times = [0.0, 0.5], rotation = [[0, 0, 0], {list(turn * axis)}], smooth = true}}\n"))
        self.assertLess(speed, 1e-7, "at rest")
        placed = [centre(f"placed{i}", rods(f"{{tangent = {direction}}}"))[0] for i, direction in enumerate(directions)]
        self.assertGreater(numpy.linalg.norm(placed[0] - 0.25 * numpy.array(directions[0])), 0.01, "bent by its weight")
        numpy.testing.assert_allclose(turned, placed[0], rtol=0, atol=1e-8)
        both = centre("both", rods(f"{{kind = 'list', origins = [[0, 0, 0], [0, 0, 0]], tangents = {directions}}}"))[0]
        numpy.testing.assert_allclose(both, 0.5 * (placed[0] + placed[1]), rtol=0, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
