"""What may meet in a step: the automatic step follows from every speed that a scene states, and the plan doubts steps and laws that let bodies pass."""

import re
import unittest

from driver import DriverTest

RADIUS, OVERLAP = 1e-3, 0.1  # contact.overlap, of the diameter
BALL = """
[[bodies]]
name = "{name}"
density = 1000.0
velocity = [{v}, 0.0, 0.0]
spheres = {{radii = [1e-3]}}
placement = {{origin = [{x}, 0.0, 0.0]}}
"""
ROD = """
[[rods]]
name = "rod"
material = {{density = 1000.0, youngs_modulus = 1e4}}
section = {{radius = 1e-3}}
shape = {{length = 0.04, elements = 4 {shape}}}
placement = {{origin = [0.1, 0.1, 0.0]}}
{more}
"""
CONTACT = """
[contact]
law = "hertz"
stiffness = {stiffness}
"""
WALL = """
[[wall]]
name = "floor"
kind = "plane"
point = [0.0, 0.0, -1.0]
law = "hertz"
stiffness = 1e-3
{more}
"""
SERVO = """
[wall.servo]
speed = {fast}
watch = "other z-"
area = 1.0
turn_back_above = 1e9
turn_forth_below = 1.0
[[wall]]
name = "other"
kind = "box"
lower = [-1.0, -1.0, -2.0]
upper = [1.0, 1.0, 2.0]
law = "hertz"
stiffness = 1e-3
"""


def balls(left, right):
    return "[time]\nduration = 0.05\n" + BALL.format(name="left", v=left, x=-0.05) + BALL.format(name="right", v=right, x=0.05)


class Meetings(DriverTest):
    def planned(self, scene, *settings):
        self.scene.write_text(scene)
        words = [word for setting in settings for word in ("--set", setting)]
        return self.plan(*words)["dt"], " ".join(self.plan_text(*words).split())

    def stated(self, fast):
        """Scenes that state this speed, m/s, each in its own way."""
        start, soft, ball = "[time]\nduration = 0.05\n", CONTACT.format(stiffness=1e-3), BALL.format(name="ball", v=0, x=0)
        yield "start", balls(fast, 0) + soft
        yield "against each other", balls(fast / 2, -fast / 2) + soft
        yield "turning", start + ROD.format(shape=f", angular_velocity = [0.0, 0.0, {fast / 0.02}]", more="") + ball + soft
        yield "moved end", start + ROD.format(shape="", more=f'start = "clamped"\nstart_motion = {{translation_formula = ["{fast}*t", "0", "0"]}}') + ball + soft
        yield "moved wall", start + ball + WALL.format(more=f"velocity = [0.0, 0.0, {fast}]")
        yield "servo", start + ball + WALL.format(more="velocity = [0.0, 0.0, 0.1]" + SERVO.format(fast=fast))

    def test_the_automatic_step_sees_every_speed_that_is_stated(self):
        longest = OVERLAP * 2 * RADIUS / 200
        for (name, scene), (_, slow) in zip(self.stated(200.0), self.stated(0.2)):
            with self.subTest(name):
                self.assertLessEqual(self.planned(scene)[0], 1.001 * longest)
                self.assertGreater(self.planned(slow)[0], 10 * longest)

    def test_a_step_that_is_too_long_is_doubted_and_the_one_it_names_is_not(self):
        scene = balls(100, -100) + CONTACT.format(stiffness=1e6)
        _, text = self.planned(scene, "time.dt=5e-6")
        doubt = re.search(r"'left' and 'right' may meet at 200 m/s, 0.5 diameters in a step, and an overlap of 0.1 is allowed for; dt = ([0-9.e-]+) would see them meet", text)
        self.assertTrue(doubt, text)
        self.assertNotIn("would see them meet", self.planned(scene, f"time.dt={doubt[1]}")[1])

    def test_a_law_that_lets_them_pass_is_doubted_and_the_one_it_names_is_not(self):
        for law, key in ((CONTACT.format(stiffness=10.0), "stiffness"), ('\n[contact]\nlaw = "linear"\nrestitution = 0.8\ncollision_time = 0.01\n', "collision_time")):
            scene = balls(2.5, -2.5) + law
            _, text = self.planned(scene)
            doubt = re.search(rf"'left' and 'right' may meet at 5 m/s, and would sink [0-9.e+]+ diameters into each other: they pass through; contact\.{key} = ([0-9.e+-]+) in place of", text)
            self.assertTrue(doubt, text)
            self.assertNotIn("pass through", self.planned(scene, f"contact.{key}={doubt[1]}")[1])

    def test_what_goes_the_same_way_does_not_meet(self):
        dt, text = self.planned(balls(100, 100) + CONTACT.format(stiffness=10.0))
        self.assertGreater(200 * dt, OVERLAP * 2 * RADIUS)
        self.assertNotIn("may meet", text)


if __name__ == "__main__":
    unittest.main()
