"""How far rods overlap: stiffness = "auto" gives the overlap that is accepted, and too soft a number is told of."""

import math
import re
import unittest

from driver import STICKS, DriverTest

LAW = """law = "{law}"
stiffness = {stiffness}
damping = {damping}
friction = "memory"
static_friction = 0.4
"""

PILE = """
title = "Pile"
[time]
duration = {duration}
{sticks}
[rods.placement]
kind = "packing"
count = 24
seed = 5
region = "cylinder"
radius = 0.08
height = 0.12
elevation = [-0.3, 0.3]
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 10.0
[contact]
{law}
[[wall]]
name = "side"
kind = "tube"
radius = 0.08
{law}
[[wall]]
name = "floor"
kind = "plane"
{law}
{lid}
[output]
series = 0.05
"""

LID = """
[[wall]]
name = "lid"
kind = "plane"
point = [0.0, 0.0, 0.13]
normal = [0.0, 0.0, -1.0]
{law}
[wall.servo]
speed = 0.1
watch = "floor"
area = 0.0201
turn_back_above = 3000.0
turn_forth_below = 100.0
average = 2e-3
cycles = 1
ends_run = true
"""

CROSSED = """
[[rods]]
name = "{name}"
[rods.material]
density = 1000.0
youngs_modulus = 1e7
law = "linear"
[rods.section]
radius = 0.005
[rods.shape]
length = 0.1
elements = 5
[rods.placement]
origin = [{x}, {y}, {z}]
tangent = [{tx}, {ty}, 0.0]
"""


def crossed(layers, gap):
    """Rods that lie across each other, one a layer, the lowest on the floor."""
    text = ""
    for layer in range(layers):
        along_x = layer % 2 == 0
        text += CROSSED.format(name=f"layer{layer}", x=-0.05 * along_x, y=-0.05 * (not along_x), z=0.005 + layer * (0.01 + gap),
                               tx=float(along_x), ty=float(not along_x))
    return text


class Overlap(DriverTest):
    def overlaps(self, out):
        return self.summary(out)["largest_overlap"]

    def run_scene(self, out, text):
        self.scene.write_text(text)
        return self.run_skein(out)

    def pile(self, out, lid="", stiffness='"auto"', law="hertz", damping=5.0, duration=0.7):
        law = LAW.format(law=law, stiffness=stiffness, damping=damping)
        return self.run_scene(out, PILE.format(sticks=STICKS, duration=duration, law=law, lid=lid.format(law=law)))

    def test_automatic_stiffness_holds_piles_at_the_accepted_overlap(self):
        for name, law, damping in ("hertz", "hertz", 20.0), ("linear", "linear", 2.0):
            done = self.pile(name, law=law, damping=damping)
            self.assertIn("(auto)", done.stdout)
            at_rest = self.summary(name)["observables"]["max_overlap[-]"]
            self.assertGreater(at_rest, 0.025, name)
            self.assertLess(at_rest, 0.1, name)

    def test_automatic_stiffness_holds_what_a_lid_presses(self):
        self.pile("pressed", lid=LID, damping=20.0)
        self.assertGreater(self.overlaps("pressed")["rods"], 0.02)
        self.assertLess(self.overlaps("pressed")["rods"], 0.1)

    def test_automatic_stiffness_of_a_stack_of_crossed_rods(self):
        law = LAW.format(law="hertz", stiffness='"auto"', damping=50.0)
        for layers in 2, 5:
            text = f"""[time]
duration = 0.5
{crossed(layers, -0.0003)}
[[load]]
kind = "gravity"
[[damping]]
kind = "uniform"
rate = 50.0
[contact]
{law}[[wall]]
name = "floor"
kind = "plane"
{law}[output]
series = 0.1
"""
            self.run_scene(f"stack{layers}", text)
            at_rest = self.summary(f"stack{layers}")["observables"]["max_overlap[-]"]
            self.assertGreater(at_rest, 0.025, f"{layers} layers")
            self.assertLess(at_rest, 0.1, f"{layers} layers")

    def test_rods_too_soft_are_told_of_once_with_what_would_hold(self):
        """Within 0.1 s: at 0.12 s the first of them have passed through each other, which ends the run."""
        done = self.pile("soft", stiffness="300", damping=0.3, duration=0.1)
        warnings = [line for line in done.stderr.splitlines() if "overlap by" in line]
        self.assertEqual(len([line for line in warnings if re.search("(: |  )rods overlap", line)]), 1, done.stderr)
        told = re.search(r"rods overlap by ([0-9.]+) of the diameter, since step (\d+) by more than the 0.1 that the time step allows for; "
                         r"stiffness = ([0-9.e+]+) in place of 300", done.stderr)
        self.assertTrue(told, done.stderr)
        overlap, step, stiffness = (float(told[i]) for i in (1, 2, 3))
        self.assertGreater(overlap, 0.1)
        self.assertGreater(step, 0)
        self.assertGreater(stiffness / (300 * (overlap / 0.1) ** 2.5), 0.94)  # the energy of the springs, and that of motion
        largest = self.overlaps("soft")
        self.assertGreaterEqual(largest["rods"], overlap * 0.999)
        self.assertIn(f"largest overlap of rods {largest['rods']:.3g} of the diameter", done.stdout)
        hard = self.pile("hard", stiffness="3e5", damping=20.0, duration=0.25)
        self.assertNotIn("overlap", hard.stderr)
        self.assertLess(self.overlaps("hard")["rods"], 0.1)
        self.assertGreater(self.overlaps("hard")["rods"], 0.001)
        self.assertTrue(math.isfinite(self.overlaps("hard")["wall floor"]) and self.overlaps("hard")["wall floor"] > 0)

    def test_the_same_on_any_ranks(self):
        one = self.pile("one", stiffness="300", damping=0.3, duration=0.1)
        two = self.run_skein("two", ranks=2)
        told = [re.search("rods overlap by .*", done.stderr) for done in (one, two)]
        self.assertTrue(told[0] and told[1], one.stderr + two.stderr)
        since = [re.search(r"since step (\d+)", match[0])[1] for match in told]  # when it is told depends on the time of day
        self.assertEqual(since[0], since[1])
        self.assertEqual(self.overlaps("one")["rods"], self.overlaps("two")["rods"])
        self.assertEqual(self.digest("one"), self.digest("two"))


if __name__ == "__main__":
    unittest.main()
