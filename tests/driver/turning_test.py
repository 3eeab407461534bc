"""Joints at rest beyond half a turn: motors, springs, stops and dry friction in skein equilibrium and path, beside closed forms."""

import csv
import math
import pathlib
import re
import unittest

import numpy

from driver import DriverTest

FOUR_BAR = pathlib.Path(__file__).resolve().parents[2] / "apps/mechanisms/four_bar.toml"

STIFFNESS = 1e9  # N/m
# An arm of 0.2 m in the plane of y and z on a hinge to the world. Its angle grows as the arm turns from z to -y.
ARM = """
time = {duration = 1.0}
[[bodies]]
name = "arm"
mass = 1.0
inertia = [0.01, 0.01, 0.01]
spheres.radii = [0.05]
placement = {origin = [0, 0, 0.2], tangent = [0, 0, 1]}
[[joint]]
name = "shaft"
kind = "hinge"
between = ["arm", "world"]
place = [0, 0, 0]
axis = [1, 0, 0]
stiffness = STIFF
torsional_stiffness = 1e4
KEYS
[output]
trajectory = 1.0
series = 1.0
precision = "double"
""".replace("STIFF", str(STIFFNESS))
WEIGHT = '[[load]]\nkind = "gravity"\nacceleration = [0, G, 0]\n'
DRIVEN = ARM.replace("KEYS", 'motor = {kind = "position", value = "full*t", stiffness = 50.0, damping = 3.0}') + '[constants]\nfull = 14.2\n' + WEIGHT.replace("[0, G, 0]", "[0, 0, -9.0]")


def circles_meet(a, b, of_a, of_b):
    """Where circles about a and b meet, on the left of the way from a to b."""
    way = b - a
    far = numpy.linalg.norm(way)
    along = (far**2 + of_a**2 - of_b**2) / (2 * far)
    across = math.sqrt(of_a**2 - along**2)
    return a + (along * way + across * numpy.array([-way[1], way[0]])) / far


class Turning(DriverTest):
    def solve(self, command, out, text, *arguments, **layout):
        return self.solve_scene(command, out, *arguments, text=text, **layout)

    def places(self, out, body):
        """Centre of a body in the last frame."""
        return self.frames(out, "trajectory")[f"groups/{body}/position"][-1].reshape(-1, 3)[0]

    def assert_turned(self, out, angle, weight, most=1e-10):
        """The arm is where the angle has it, on a hinge whose spring gives way to the weight, a vector in the plane."""
        expected = 0.2 * numpy.array([-math.sin(angle), math.cos(angle)]) + numpy.array(weight) / STIFFNESS
        self.assertLess(numpy.abs(self.places(out, "arm")[1:] - expected).max(), most)

    def residual(self, said):
        return float(re.search(r"Balance: residual (\S+)", said.stdout)[1])

    def test_a_four_bar_is_where_geometry_has_it(self):
        crank, rocker = numpy.zeros(2), numpy.array([0.3, 0.0])
        text = FOUR_BAR.read_text().replace("[output]", '[output]\nprecision = "double"')
        for time in (0.5, 1.5, 1.7, 2.0):
            out = f"at{time}"
            said = self.solve("equilibrium", out, text, "--time", time)
            self.assertLess(self.residual(said), 1e-6)
            angle = 2 * math.pi * time * min(time, 1)
            a = crank + 0.1 * numpy.array([math.sin(angle), math.cos(angle)])
            b = circles_meet(a, rocker, 0.3, 0.25)
            for body, place in (("crank", 0.5 * (crank + a)), ("coupler", 0.5 * (a + b)), ("rocker", 0.5 * (b + rocker))):
                self.assertLess(numpy.abs(self.places(out, body)[[0, 2]] - place).max(), 1e-11, f"{body} at {time}")

    def test_a_motor_turns_an_arm_more_than_twice(self):
        """Its spring gives way to the weight; the same along a path of the motor's value, on any number of ranks, and when it is stepped on."""
        angle = 14.2
        for _ in range(100):
            angle = 14.2 + 0.2 * 9 * math.sin(angle) / 50
        said = self.solve("equilibrium", "whole", DRIVEN)
        self.assertLess(self.residual(said), 1e-8)
        self.assert_turned("whole", angle, (0, -9))
        path = DRIVEN.replace("full = 14.2", "full = 0.5"), "--along", "constants.full", "--to", 14.2, "--step", 0.2
        self.solve("path", "path", *path, "--points", 200)
        self.assert_turned("path", angle, (0, -9))
        for points in (100, 200):
            self.solve("path", "parts", *path, "--points", points, *["--restart"] * (points > 100))
        self.assertEqual((self.directory / "parts/path.csv").read_bytes(), (self.directory / "path/path.csv").read_bytes())
        # A motor that holds its angle keeps the arm there, by whole turns too.
        self.skein_says("branch", self.directory / "whole", self.directory / "on", "--set", "time.duration=1e-2", "--set", "output.series=1e-2",
                        "--set", "output.trajectory=1e-2", "--set", "start.time=zero", "--set", 'joint.0.motor.value="full"')
        self.skein_says("run", self.directory / "on", "--threads", 1)
        self.assert_turned("on", angle, (0, -9), 1e-9)

    def test_bits_are_those_of_any_ranks(self):
        """Of arms by themselves, and of arms that could touch, which all ranks share."""
        copies = '[[assembly]]\nname = "stand"\nplacement = {kind = "list", origins = [[0, 0, 0], [3, 0, 0], [6, 0, 0]], tangents = [[0, 0, 1], [0, 0.6, 0.8], [0, 0, 1]]}\n'
        arms = DRIVEN.replace("[[bodies]]\n", copies + '[[bodies]]\nassembly = "stand"\n')
        arms = arms.replace("motor = {", "friction = 0.5\nfriction_stiffness = 400.0\nmotor = {")
        for shared in ("", "[contact]\nstiffness = 100.0\n"):
            digests = set()
            for ranks in (1, 2, 3):
                out = f"ranks{ranks}{bool(shared)}"
                self.solve("equilibrium", out, arms + shared, ranks=ranks)
                digests.add(self.digest(out))
            self.assertEqual(len(digests), 1, shared)

    def test_a_spring_counts_whole_turns(self):
        """Its rest is 9 rad away; the same along paths of the weight and of that angle, with its energy."""
        text = ARM.replace("KEYS", "spring = 50.0\nspring_rest = 9.0") + WEIGHT.replace("[0, G, 0]", "[0, 0, -9.0]")
        angle = 9.0
        for _ in range(100):
            angle = 9 + 0.2 * 9 * math.sin(angle) / 50
        self.solve("equilibrium", "spring", text)
        self.solve("path", "path", text, "--along", "load.0.acceleration.2", "--from", -1.0, "--to", -9.0, "--step", 0.2, "--points", 50)
        self.solve("path", "rest", text.replace("= 9.0\n", "= 0.5\n"), "--along", "joint.shaft.spring_rest", "--to", 9.0, "--step", 0.2, "--points", 200)
        for out in ("spring", "path", "rest"):
            self.assert_turned(out, angle, (0, -9))
            energy = self.series(out)["joint_energyJ"][-1]
            self.assertLess(abs(energy - 25 * (angle - 9) ** 2 - 0.5 * 81 / STIFFNESS), 1e-10, out)

    def test_a_stop_lies_beyond_a_turn(self):
        """A motor of force turns the arm up to it."""
        self.solve("equilibrium", "stop", ARM.replace("KEYS", 'motor = {kind = "force", value = "0.5*t"}\nspring = 0.01\nlimits = [-1.0, 8.0]\nstop_stiffness = 100.0'))
        self.assert_turned("stop", (0.5 + 800) / 100.01, (0, 0))

    def test_dry_friction_holds_up_to_its_limit(self):
        """A small weight turns the arm by both springs; beyond the limit the arm turns on, and the spring of the axis bears the rest. So along a path."""

        def angle_at(g, limit, stiffness):
            angle = 0.0
            for _ in range(100):
                angle = -(0.2 * g * math.cos(angle) - limit) / stiffness
            return angle

        text = ARM.replace("KEYS", "spring = 20.0\nfriction = 0.5\nfriction_stiffness = 400.0") + WEIGHT
        for g, limit, stiffness in ((1.0, 0.0, 420), (9.0, 0.5, 20)):
            out = f"friction{g:g}"
            self.solve("equilibrium", out, text.replace("G", str(g)))
            angle = angle_at(g, limit, stiffness)
            self.assert_turned(out, angle, (g, 0), 1e-9)
        # From the checkpoint on, a smaller weight does not turn the arm back over the limit: the spring of friction gives way.
        anchor = angle + 0.5 / 400
        for _ in range(100):
            angle = -(0.2 * 8.5 * math.cos(angle) - 400 * anchor) / 420
        self.skein_says("branch", self.directory / "friction9", self.directory / "less", "--set", "load.0.acceleration=[0, 8.5, 0]", "--set", "start.time=zero")
        self.skein_says("equilibrium", self.directory / "less", "--out", self.directory / "held", "--threads", 1)
        self.assert_turned("held", angle, (8.5, 0), 1e-9)
        # A path hands friction on from point to point: past its limit it ends where load steps do.
        for out, end, expected in (("slid", 9.0, angle_at(9, 0.5, 20)), ("stuck", 1.0, angle_at(1, 0, 420))):
            self.solve("path", out, text.replace("G", "0.5"), "--along", "load.0.acceleration.1", "--to", end, "--points", 100)
            self.assert_turned(out, expected, (end, 0), 1e-8)

    def test_dry_friction_is_a_spring_in_modes(self):
        """With its dashpot, beside the spring that joins the points: both motions of the arm in its plane."""
        self.solve("modes", "modes", ARM.replace("KEYS", "spring = 20.0\nfriction = 0.5\nfriction_stiffness = 400.0\nfriction_damping = 0.3"), "--count", 1)
        mass, about, point = numpy.diag([1.0, 0.01]), numpy.diag([0.0, 1.0]), numpy.array([[1.0, 0.2], [0.2, 0.04]])
        rates = numpy.block([[numpy.zeros((2, 2)), numpy.eye(2)], [-numpy.linalg.solve(mass, STIFFNESS * point + 420 * about), -numpy.linalg.solve(mass, 0.3 * about)]])
        slowest = min(numpy.linalg.eigvals(rates), key=abs)
        with open(self.directory / "modes/modes.csv") as file:
            mode = next(csv.DictReader(file))
        self.assertAlmostEqual(float(mode["decay[1/s]"]), -slowest.real, 6)
        self.assertAlmostEqual(2 * math.pi * float(mode["frequency[Hz]"]), abs(slowest.imag), 6)


if __name__ == "__main__":
    unittest.main()
