"""Violent runs at and beyond the limit of the step, whatever it comes from: at 0.9 of it the energy stays; beyond it a scene is refused, and
where that is overruled the run is stopped and says what broke, where and why, or warns; no state that is no number is kept."""

import re
import subprocess
import unittest

import h5py
import numpy

from driver import DriverTest

ROD = """
[[rods]]
name = "sticks"
[rods.material]
density = 1000.0
youngs_modulus = {young}
[rods.section]
radius = 0.02
[rods.shape]
length = 0.5
elements = 8
start_curvature = {curvature}
velocity = [0.5, 0.3, -2.0]
[rods.placement]
kind = "lattice"
counts = [1, {count}]
spacing = [0.1, 0.06]
origin = [-0.25, -0.1, 0.25]
tangent = [1.0, 0.02, 0.01]
"""
WALLS = """
[[wall]]
name = "room"
kind = "box"
lower = [-0.5, -0.5, 0.0]
upper = [0.5, 0.5, 0.5]
law = "{law}"
stiffness = {stiffness}
"""
TIME = 'title = "violent"\n[time]\nduration = 0.2\n[output]\nseries = 0.01\ntrajectory = 0.1\ncheckpoint = 0.1\n'
BALL = """
[[bodies]]
name = "sticks"
density = 1000.0
velocity = [0.7, 1.1, -3.0]
[bodies.spheres]
radii = [0.05]
[bodies.placement]
origin = [0.0, 0.0, 0.1]
"""

# Scenes by what limits their step.
SCENES = {
    "shear-rotation": TIME + ROD.format(young=1e6, curvature="[4.0, 1.0, 2.0]", count=1),
    "contact": TIME + ROD.format(young=1e8, curvature="[0.0, 0.0, 0.0]", count=3) + WALLS.format(law="linear", stiffness=1e9)
    + '\n[contact]\nlaw = "linear"\nstiffness = 1e9\n',
    "contact, walls alone": TIME + ROD.format(young=1e6, curvature="[2.0, 0.0, 1.0]", count=1) + WALLS.format(law="linear", stiffness=1e8),
    "contact, a body": TIME + BALL + WALLS.format(law="linear", stiffness=1e7),
}


class BeyondTheLimit(DriverTest):
    def limit(self):
        plan = self.plan("--set", "time.dt=1e-9")
        return min((limit["dt"], mode) for group in plan["groups"] for mode, limit in group["limits"].items())

    def energy(self, out):
        series = self.series(out)
        return sum(series[name] for name in series.dtype.names if name.startswith(("kinetic_", "elastic_")) or name in ("contact_energyJ", "wall_energyJ"))

    def assert_numbers(self, out):
        """Every number of every state that was kept is one, that of the failure too; a checkpoint is among them."""
        files = list((self.directory / out).glob("*.h5"))
        self.assertTrue([file for file in files if file.name.startswith("checkpoint_")], f"{out}: no checkpoint")
        for file in files:
            with h5py.File(file) as h5:
                def look(name, item):
                    if isinstance(item, h5py.Dataset) and item.dtype.kind == "f":
                        self.assertTrue(numpy.isfinite(item[()]).all(), f"{file.name}: {name}")
                h5.visititems(look)
        self.assertNotIn("nan", (self.directory / out / "observables.csv").read_text().split("\n", 1)[1])

    def test_each_limit(self):
        for what, scene in SCENES.items():
            with self.subTest(what):
                self.scene.write_text(scene)
                limit, mode = self.limit()
                self.assertIn(what.split(",")[0], mode)
                name = what.replace(" ", "_").replace(",", "")

                self.run_skein(f"{name}_within", "--set", f"time.dt={0.9 * limit}")
                energy = self.energy(f"{name}_within")
                self.assertLess(energy.max(), 1.2 * energy[0])
                self.assert_numbers(f"{name}_within")

                refused = self.run_skein(f"{name}_refused", "--set", f"time.dt={1.5 * limit}", expect=2)
                self.assertIn("beyond the stable limit", refused.stderr)
                self.assertFalse((self.directory / f"{name}_refused").exists())

                for times in (1.5, 4.0):
                    out, dt = f"{name}_forced_{times}", times * limit
                    checkpoint = max(2 * dt, 2e-3)  # before the first failure, which is at the third step
                    done = subprocess.run(self.command(out, "--set", f"time.dt={dt}", "--set", "time.force_dt=true",
                                                       "--set", f"output.checkpoint={checkpoint}", "--set", "output.series=0.002"),
                                          capture_output=True, text=True, timeout=200)
                    self.assertIn(done.returncode, (0, 4), done.stderr)
                    if done.returncode == 4:
                        for part in ("'sticks'", "step", "likely cause", "limit"):
                            self.assertIn(part, done.stderr)
                        self.assertRegex(done.stderr, r"the last good checkpoint is of step \d+")
                        step = int(re.search(r"the last good checkpoint is of step (\d+)", done.stderr)[1])
                        self.assertTrue((self.directory / out / f"checkpoint_{step:012}.h5").exists(), out)
                        self.assertTrue((self.directory / out / "failure.h5").exists(), out)
                    else:
                        self.assertIn(f"time.force_dt lets a step pass that is {times:.3g} of its limit", done.stdout.replace("\n", " "))
                        self.assertLess(self.energy(out)[-1], 100 * energy[0])
                    self.assert_numbers(out)


if __name__ == "__main__":
    unittest.main()
