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
            done = self.run_skein(f"pull_{stretch}", "-v", expect=code)
            self.assertIn("directors flip beyond dilatation e_c = 1.01", done.stdout)
            if code:
                for part in ("'rope'", "element", "step", "tension instability", "e_c = 1.01", "likely cause"):
                    self.assertIn(part, done.stderr)

    def test_squeeze_past_what_the_step_bears(self):
        """Compression stiffens an incompressible rod (theory.md (51)): at 0.855 of the limit at rest one of r = 0.1 L has room down to
        e = 0.88, and is told from 0.935 on. Thick and short, so that it does not buckle."""
        for e, code in ((0.985, 0), (0.905, 0), (0.85, 4)):
            self.scene_of(f"[rods.end_motion]\ntimes = [0.0, 1.0]\ntranslation = [[0.0, 0.0, 0.0], [0.0, 0.0, {e - 1!r}]]\n", radius=0.1, elements=10)
            for ranks in (1, 2):
                done = self.run_skein(f"squeeze_{e}_{ranks}", "--set", "rods.0.end=clamped", ranks=ranks, expect=code)
                self.assertEqual(done.stderr.count("warning: step"), 1 if e < 0.935 else 0, done.stderr)
                if e < 0.935:
                    for part in ("rod 0 of 'rope'", "element", "of the limit", "dilatation e = 0.9"):
                        self.assertIn(part, done.stderr)
                if code:
                    for part in ("rod 0 of 'rope'", "dilatation e = 0.8", "step", "likely cause"):
                        self.assertIn(part, done.stderr.split("warning: step")[1].split("\n", 1)[1])

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
