"""Implicit steps: order, agreement with explicit runs, energy over many steps, parts by error, and the same bits however they are run."""

import json
import math
import unittest

import numpy

from driver import DriverTest

HEAD = """
time = {duration = DURATION, integrator = "METHOD", STEP}
[output]
trajectory = DURATION
series = DURATION
precision = "double"
"""
CANTILEVER = """
[[load]]
kind = "gravity"
[[rods]]
name = "rod"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 1e-2
shape = {length = 0.5, elements = 10}
placement.tangent = [1.0, 0.0, 0.0]
"""
SCENES = {
    "cantilever": (0.4, CANTILEVER),
    "pendulum": (0.8, CANTILEVER.replace('"clamped"', '"pinned"').replace("youngs_modulus = 1e6", "youngs_modulus = 1e7")),
    "whip": (0.3, CANTILEVER.replace('"clamped"', '"clamped"\nstart_motion = [{kind = "sine", displacement = [0, 0, 0.05], period = 0.4}]')),
    "cilium": (0.4, CANTILEVER.replace('kind = "gravity"', 'kind = "magnetic_field"\nconstant = [0.0, 2e-3, 0.0]\nrotating = 2e-3\nperiod = 0.5\nramp = 0.1')
               + 'magnetisation = {pattern = "uniform", strength = 2e4, direction = [1, 0, 0]}\n'),
    "ring": (0.3, CANTILEVER.replace('start = "clamped"\n', "").replace("elements = 10}", "elements = 12, closed = true}")
             .replace('kind = "gravity"', 'kind = "magnetic_field"\nconstant = [0.0, 2e-3, 1e-3]\nramp = 0.1')
             + 'magnetisation = {pattern = "uniform", strength = 2e4, direction = [1, 0, 0]}\n'),
}


class Implicit(DriverTest):
    def run_scene(self, out, name, method, step="", *arguments, text=None, duration=None, **layout):
        """Places of all nodes at the end."""
        own_duration, own_text = SCENES[name]
        head = HEAD.replace("DURATION", str(duration or own_duration)).replace("METHOD", method).replace(", STEP", f", {step}" if step else "")
        self.scene.write_text(head + (text or own_text))
        self.run_skein(out, "--overwrite", *arguments, **layout)
        return self.places(out)

    def places(self, out):
        frames = self.frames(out, "trajectory")
        return numpy.concatenate([frames[name][-1].reshape(-1, 3) for name in sorted(frames) if name.endswith("/position")])

    def test_steps_are_of_second_order(self):
        for name in SCENES:
            duration = SCENES[name][0]
            for method in ("implicit", "implicit_damped"):
                with self.subTest(scene=name, method=method):
                    ends = [self.run_scene("out", name, method, f"dt = {duration / steps}") for steps in (200, 400, 800)]
                    change = [numpy.abs(a - b).max() for a, b in zip(ends, ends[1:])]
                    print(name, method, change, math.log2(change[0] / change[1]))

    def test_explicit_steps_come_to_the_same_places(self):
        for name, (duration, _) in SCENES.items():
            with self.subTest(scene=name):
                explicit = self.run_scene("explicit", name, "verlet", "safety = 0.25")
                fine = self.run_scene("fine", name, "implicit", f"dt = {duration / 3200}")
                coarse = self.run_scene("coarse", name, "implicit", f"dt = {duration / 1600}")
                print(name, numpy.abs(fine - explicit).max(), numpy.abs(fine + (fine - coarse) / 3 - explicit).max())


if __name__ == "__main__":
    unittest.main()
