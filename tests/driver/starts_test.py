"""Where bodies stand at the start: deep in another, in a wall, in an obstacle or outside the fluid they are refused, by check, plan and run alike."""

import pathlib
import subprocess
import unittest

from driver import SKEIN, DriverTest, group, table

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
RADIUS = 3e-3
TWO = "time.duration = 0.002\n" + "".join(
    group(name, 2e6, RADIUS, 0.2, 20, {"placement": {"tangent": [0.0, 1.0, 0.0], "origin": [x, 0.0, 0.0]}}, **ends)
    for name, x, ends in (("held", 0.0, {"start": "clamped"}), ("free", 0.001, {})))
CONTACT = table("[contact]", {"stiffness": "auto"})
BALL = """
[[bodies]]
name = "ball"
density = 1000.0
spheres = {{radii = [0.01]}}
placement = {{origin = {at}}}
"""
FLUID = """
[fluid]
cells = [16, 16, 16]
spacing = 0.05
lower = [-0.4, -0.4, -0.4]
density = 1000.0
viscosity = 0.1
along_x = "through"
inflow = [0.1, 0.0, 0.0]
along_y = "free_slip"
"""


class Starts(DriverTest):
    def command_of(self, *words):
        return subprocess.run([SKEIN, words[0], str(self.scene), *words[1:]], capture_output=True, text=True, timeout=100)

    def refused(self, text, *said, ranks=(1, 2)):
        """By every command; the message of a run."""
        self.scene.write_text(text)
        for command in "check", "plan":
            done = self.command_of(command)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            for part in said:
                self.assertIn(part, done.stderr)
        messages = set()
        for n in ranks:
            messages.add(self.run_skein(f"refused{n}", ranks=n, expect=2).stderr.split("error:")[1].split("\n--")[0].strip().splitlines()[0])
            self.assertFalse((self.directory / f"refused{n}").exists())
        self.assertEqual(len(messages), 1, messages)

    def accepted(self, text, *arguments):
        self.scene.write_text(text)
        done = self.command_of("check")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return self.run_skein("accepted", "--overwrite", "--steps", "3", *arguments, expect=0 if self.steps_are_few() else 3)

    def steps_are_few(self):
        return True

    def test_rods_deep_in_each_other(self):
        """The pair of the report: 1 mm apart, radii of 3 mm."""
        self.refused(TWO + CONTACT, "rod 0 of 'held' (element ", "rod 0 of 'free' (element ", "0.833 of the diameter",
                     "contact.overlap allows 0.1", "allow_overlap = true in [contact]", ranks=(1, 2, 3))

    def test_its_cures(self):
        self.accepted(TWO + CONTACT + "allow_overlap = true\n")
        self.accepted(TWO.replace("[0.001, 0.0, 0.0]", "[0.0055, 0.0, 0.0]") + CONTACT)  # an overlap of 0.083
        self.accepted(TWO)  # they do not feel each other

    def test_a_soft_beginning_parts_rods(self):
        soft = {"stiffness": 100.0, "law": "linear", "soft_until": 1.0, "soft_stiffness": 1e-3}
        self.accepted(TWO + table("[contact]", soft))

    def test_neighbours_along_a_rod_and_joined_rods_may(self):
        thick = group("thick", 1e6, 0.02, 0.1, 20)
        self.accepted("time.duration = 0.001\n" + thick + CONTACT.replace('"auto"', "10.0") + "self = true\n")
        pair = "".join(group(name, 1e6, 0.01, 0.1, 4, {"placement": {"origin": [0.0, 0.0, z]}}) for name, z in (("low", 0.0), ("high", 0.1)))
        joint = '[[joint]]\nkind = "spherical"\nbetween = ["low", "high"]\nat = ["end", "start"]\nstiffness = 100.0\n'
        text = "time.duration = 0.001\n" + pair + joint + CONTACT.replace('"auto"', "10.0")
        self.scene.write_text(text)
        done = self.command_of("check")
        self.assertNotIn("overlap at the start", done.stderr)

    def test_a_run_that_goes_on_is_not_looked_at(self):
        text = TWO + CONTACT + "allow_overlap = true\n" + table("[output]", {"checkpoint": 5e-4})
        self.scene.write_text(text)
        self.run_skein("whole", "--until", "0.001")
        self.scene.write_text(text)
        self.run_skein("whole")
        step = int(sorted((self.directory / "whole").glob("checkpoint_*.h5"))[0].stem.split("_")[1])
        self.scene.write_text(TWO + CONTACT + table("[start]", {"from": f"{self.directory}/whole@{step}"}))
        self.assertEqual(self.command_of("check").returncode, 0)
        self.run_skein("branch")

    def test_balls_and_rods(self):
        rod = group("rod", 2e6, RADIUS, 0.2, 4, {"placement": {"tangent": [0.0, 1.0, 0.0]}})
        law = table("[contact]", {"stiffness": 100.0})
        self.refused("time.duration = 0.001\n" + rod + BALL.format(at=[0.005, 0.1, 0.0]) + law, "rod 0 of 'rod' (element 1)", "body 0 of 'ball' (part 0)")
        self.accepted("time.duration = 0.001\n" + rod + BALL.format(at=[0.0128, 0.1, 0.0]) + law)

    def test_walls(self):
        rod = group("rod", 2e6, RADIUS, 0.2, 4, {"placement": {"tangent": [0.0, 1.0, 0.0], "origin": [0.0, 0.0, 0.001]}})
        floor = table("[[wall]]", {"name": "floor", "kind": "plane", "stiffness": 100.0})
        self.refused("time.duration = 0.001\n" + rod + floor, "rod 0 of 'rod' (node 0)", "0.333 of its diameter", "the wall 'floor'", "allow_overlap = true")
        self.accepted("time.duration = 0.001\n" + rod + floor + "allow_overlap = true\n")
        self.accepted("time.duration = 0.001\n" + rod.replace("0.001]", "0.0029]") + floor)
        standing = group("standing", 2e6, RADIUS, 0.2, 4, start="clamped")
        self.accepted("time.duration = 0.001\n" + standing + floor)  # what is held there is no mistake
        self.refused("time.duration = 0.001\n" + BALL.format(at=[0.0, 0.0, 0.005]) + floor, "body 0 of 'ball' (point 0)", "0.25 of its diameter")
        pipe = table("[[wall]]", {"name": "pipe", "kind": "tube", "radius": 0.02, "stiffness": 100.0})
        self.refused("time.duration = 0.001\n" + group("rod", 2e6, RADIUS, 0.2, 4, {"placement": {"origin": [0.019, 0.0, 0.0]}}) + pipe, "the wall 'pipe'")

    def test_shipped_scenes_stand_well(self):
        for scene in sorted(APPS.glob("*/*.toml")):
            if any(word in scene.name for word in ("16384", "4096")):
                continue  # as the smaller ones, and longer to pack
            done = subprocess.run([SKEIN, "check", str(scene)], capture_output=True, text=True, timeout=100)
            self.assertNotIn("at the start", done.stderr, scene)


if __name__ == "__main__":
    unittest.main()
