"""Rods driven past what a run can follow: the program says so, names the place, and ends with its exit code."""

import math
import subprocess
import unittest

from driver import SKEIN, DriverTest

ROD = """
[time]
duration = {duration}
[[rods]]
name = "rope"
start = "clamped"
[rods.material]
density = 1000.0
youngs_modulus = 1e6
shear_modulus = {shear}
[rods.section]
radius = {radius}
[rods.shape]
length = 1.0
elements = {elements}
[[damping]]
kind = "uniform"
rate = {rate}
"""


class Stopped(DriverTest):
    def scene_of(self, loads, duration=2.0, shear=1e6 / 3, radius=0.005, elements=20, rate=60.0):
        self.scene.write_text(ROD.format(duration=duration, shear=shear, radius=radius, elements=elements, rate=rate) + loads)

    def test_twist_beyond_three_radians_per_cell(self):
        """A couple spread along the rod twists its clamped end by C l/(G I3) per cell (theory.md (32), (14))."""
        radius, elements, shear = 0.005, 20, 1e6 / 3
        couple_of_a_radian = shear * 0.5 * math.pi * radius**4 * elements
        for turn, code in ((2.5, 0), (3.5, 4)):
            self.scene_of(f'[[load]]\nkind = "uniform_couple"\ncouple = [0.0, 0.0, {turn * couple_of_a_radian!r}]\nramp = 1.0\n')
            done = self.run_skein(f"twist_{turn}", expect=code)
            if code:
                for part in ("'rope'", "elements 0 and 1", "more than 3 rad", "step", "likely cause"):
                    self.assertIn(part, done.stderr)

    def test_pull_past_the_tension_limit(self):
        """G = E/100: directors flip beyond e = 1.01 (theory.md (15)); the plan says so, and a run that gets there is stopped."""
        axial = 1e6 * math.pi * 0.02**2
        for stretch, code in ((1.005, 0), (1.05, 4)):
            self.scene_of(f'[[load]]\nkind = "end_force"\nend = [0.0, 0.0, {axial * (1 - 1 / stretch)!r}]\nramp = 1.0\n'
                          '[[load]]\nkind = "gravity"\nacceleration = [1e-3, 0.0, 0.0]\n', duration=4.0, shear=1e4, radius=0.02, rate=2.0)
            done = self.run_skein(f"pull_{stretch}", expect=code)
            self.assertIn("directors flip beyond dilatation e_c = 1.01", done.stdout)
            if code:
                for part in ("'rope'", "element", "step", "tension instability", "e_c = 1.01", "likely cause"):
                    self.assertIn(part, done.stderr)

    def test_step_of_twice_the_limit_is_refused(self):
        self.scene_of("")
        plan = subprocess.run([SKEIN, "plan", str(self.scene), "--json"], capture_output=True, text=True, timeout=60)
        self.assertEqual(plan.returncode, 0, plan.stderr)
        limit = float(plan.stdout.split('"limit"')[1].split(":")[1].split(",")[0])
        done = self.run_skein("far", "--set", f"time.dt={2 * limit!r}", expect=2)
        for part in ("'rope'", "element ", "shear-rotation about d1", f"{limit:.4g}"[:5]):
            self.assertIn(part, done.stderr)
        self.run_skein("near", "--set", f"time.dt={0.98 * limit!r}", "--steps", "200")


if __name__ == "__main__":
    unittest.main()
