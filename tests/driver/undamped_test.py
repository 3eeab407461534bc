"""Rods without damping that strain has stiffened: energy kept to a hundredth of what loads did, or a warning with the step that keeps it."""

import re
import subprocess
import unittest

from driver import SKEIN, DriverTest

# Clamped thick rods under a load by formula, for some 96 periods (theory.md 17).
THICK = """
time = {duration = 21.598239999999997}
rods = [{name = "r0", material = {density = 166.13240020365242, youngs_modulus = 36547.6525680046, law = "incompressible"}, section = {radius = 0.009270874645530471, taper = 0.9114846679292183}, shape = {length = 0.0929101882316254, elements = 12, velocity = [0.4726567754550753, -0.4687664008822728, -0.38830231003162624]}, placement = {tangent = [1.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0]}, start = "clamped"}]
load = [{kind = "formula", force = ["0.2643882710532941*sin(55.752538647617186*t)", "0", "0.2643882710532941*cos(27.876269323808593*t)*s/L"]}]
wall = [{name = "floor", kind = "plane", point = [0.0, 0.0, -0.11125049574636565], law = "hertz", stiffness = 3075.7161884897487}]
contact = {law = "hertz", stiffness = 3075.7161884897487, self = true}
output = {series = 0.4319647999999999, audit = true}
"""
SMALL = """
time = {duration = 3.71092}
rods = [{name = "r0", material = {density = 7321.844285356955, youngs_modulus = 5114.587580626263, law = "incompressible"}, section = {radius = 6.99013893879178e-05}, shape = {length = 0.0009599700740044124, elements = 12, start_curvature = [-1324.7498728451094, 0.0, 0.0], velocity = [-0.019718967344276205, 0.01655541403286507, 0.009292021827662313]}, placement = {tangent = [1.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0]}, start = "clamped"}]
load = [{kind = "formula", force = ["0.00010841032576677552*sin(221.88785346248764*t)", "0", "0.00010841032576677552*cos(110.94392673124382*t)*s/L"]}]
wall = [{name = "floor", kind = "plane", point = [0.0, 0.0, -0.0008388166726550137], law = "linear", stiffness = 0.007789249177956939, friction = "regularised", kinetic_friction = 0.36770145808471, slip_speed = 0.005325142477726612}]
output = {series = 0.0742184, audit = true}
"""
STIFF = SMALL.replace("youngs_modulus = 5114.587580626263", "youngs_modulus = 5e5")  # that the same load hardly strains


class Undamped(DriverTest):
    def energy(self, scene, *settings):
        """Largest defect of the balance over the largest work of the loads, and what the run warned of."""
        self.scene.write_text(scene)
        sets = [word for setting in settings for word in ("--set", setting)]
        done = subprocess.run([SKEIN, "run", str(self.scene), "--out", str(self.directory / "out"), "--threads", "1", "--overwrite", *sets], capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        series = self.series("out")
        return abs(series["energy_defectJ"]).max() / abs(series["work_loadsJ"]).max(), done.stderr

    def test_energy_is_kept_or_the_step_is_named(self):
        for name, scene in (("thick", THICK), ("small", SMALL)):
            with self.subTest(scene=name):
                defect, warned = self.energy(scene)
                step = re.search(r"rods without damping may have gained energy.*time\.dt = ([0-9.e+-]+) holds", warned)
                self.assertTrue(step or defect < 0.01, f"{defect:.3g} and no word of it: {warned}")
                if step:
                    defect, warned = self.energy(scene, f"time.dt={step.group(1)}")
                    self.assertLess(defect, 0.01, "at the step that the warning named")
                    self.assertNotIn("without damping", warned)

    def test_small_strains_are_no_cause_to_warn(self):
        self.assertNotIn("without damping", self.energy(STIFF, "time.duration=0.4")[1])


if __name__ == "__main__":
    unittest.main()
