"""Steps of "implicit_bed": order, rest, stability at any stiffness, fast starts, columns, and the same bits however they are run."""

import math
import unittest

import numpy

from driver import SEARCH, DriverTest
from scene_text import scene_text

RADIUS, LENGTH, DENSITY = 2e-3, 0.1, 1000.0
GRAVITY = [{"kind": "gravity"}]


def law(stiffness=1e4, friction="memory", normal="linear", damping=0.5):
    keys = {"law": normal, "stiffness": stiffness, "damping": damping}
    if friction != "none":
        keys |= {"friction": friction, "static_friction": 0.4}
        keys |= {"tangential_damping": 0.1} if friction == "memory" else {"slip_speed": 1e-2}
    return keys


def rod(name, origin, tangent, elements=8, youngs_modulus=1e8, **keys):
    return {"name": name, "material": {"density": DENSITY, "youngs_modulus": youngs_modulus}, "section": {"radius": RADIUS},
            "shape": {"length": LENGTH, "elements": elements}, "placement": {"origin": list(origin), "tangent": list(tangent)}} | keys


def floor(**keys):
    return {"name": "floor", "kind": "plane"} | law() | keys


def heap(overlap=0.0, **keys):
    """Two rods on the floor and one across both."""
    return [rod("left", (0.0, -0.02, RADIUS - overlap), (1.0, 0.0, 0.0), **keys), rod("right", (0.01, 0.03, RADIUS - overlap), (1.0, 0.0, 0.0), 7, **keys),
            rod("across", (0.047, -0.05, 3 * RADIUS - 2 * overlap), (0.0, 1.0, 0.0), 9, **keys)]


HEAP = heap()
DAMPED = [{"kind": "uniform", "rate": 20.0}]


class Bed(DriverTest):
    def write(self, scene, time, **output):
        self.scene.write_text(scene_text({"time": {"integrator": "implicit_bed"} | time, "output": {"precision": "double"} | output} | scene))

    def places(self, out):
        frames = self.frames(out, "trajectory")
        return numpy.concatenate([frames[name][-1].reshape(-1, 3) for name in sorted(frames) if name.endswith("/position")])

    def end(self, out, scene, time, *arguments):
        self.write(scene, time, trajectory=time["duration"], series=time["duration"] / 50)
        self.run_skein(out, "--overwrite", *arguments)
        return self.places(out)

    def test_steps_are_of_first_order(self):
        scenes = {"cantilever": {"rods": [rod("rod", (0, 0, 0), (1, 0, 0), youngs_modulus=1e6, start="clamped")], "load": GRAVITY},
                  "pressed": {"rods": HEAP, "load": GRAVITY, "damping": DAMPED, "contact": law(), "wall": [floor()]}}
        for name, scene in scenes.items():
            with self.subTest(scene=name):
                duration = 0.02
                explicit = self.end("explicit", scene, {"duration": duration, "integrator": "verlet", "dt": duration / 64000})
                ends = [self.end("out", scene, {"duration": duration, "dt": duration / n}) for n in (3200, 6400, 12800)]
                errors = [numpy.abs(end - explicit).max() for end in ends]
                for a, b in zip(errors, errors[1:]):
                    self.assertLess(abs(math.log2(a / b) - 1), 0.15, errors)

    def test_heaps_come_to_the_rest_of_explicit_steps(self):
        """Without friction one rod alone: a heap slides on and on. With it places at rest depend on the way there."""
        for friction, rods, bound in (("none", HEAP[:1], 1e-8), ("memory", HEAP, 5e-6)):
            scene = {"rods": rods, "load": GRAVITY, "damping": DAMPED, "contact": law(friction=friction), "wall": [floor(**law(friction=friction))]}
            explicit = self.end("explicit", scene, {"duration": 3.0, "integrator": "verlet"})
            for dt in (1e-4, 5e-4, 2e-3):
                with self.subTest(friction=friction, dt=dt):
                    out = self.end("out", scene, {"duration": 3.0, "dt": dt})
                    self.assertLess(numpy.abs(out - explicit)[:, 2].max(), bound * LENGTH)
                    self.assertGreaterEqual(self.series("out")["wall_contacts"][-1], 9)

    def test_pressed_rods_come_to_rest_at_any_stiffness(self):
        """A heap under its weight, with a damping that takes its motion in the same number of steps."""
        for normal in ("linear", "hertz"):
            for stiffness in (1e4, 1e6, 1e8, 1e10):
                of = law(stiffness, normal=normal, damping=0.5 * math.sqrt(stiffness / 1e4))
                for dt in (1e-5, 1e-4, 1e-3):
                    with self.subTest(normal=normal, stiffness=stiffness, dt=dt):
                        scene = {"rods": HEAP, "load": GRAVITY, "damping": [{"kind": "uniform", "rate": 1 / (200 * dt)}], "contact": of, "wall": [floor(**of)]}
                        self.write(scene, {"duration": 3000 * dt, "dt": dt}, series=10 * dt)
                        self.run_skein("out", "--overwrite", "--no-checkpoint")
                        energy = self.series("out")["kinetic_translationJ"]
                        falling = DENSITY * math.pi * RADIUS**2 * LENGTH * 9.81 * RADIUS  # of one rod by a radius
                        self.assertLess(energy[225:].max(), 1e-5 * falling)

    def test_fast_starts_are_cut_into_parts(self):
        thrown = [part | ({"shape": part["shape"] | {"velocity": [0.0, 0.0, -0.5]}} if part["name"] == "across" else {}) for part in HEAP]
        scene = {"rods": thrown, "load": GRAVITY, "damping": DAMPED, "contact": law(), "wall": [floor()]}
        end = self.end("out", scene, {"duration": 0.4, "dt": 1.6e-3})
        self.assertGreaterEqual(self.summary("out")["implicit_bed"]["most_parts"], 4)
        self.assertGreater(end[:, 2].min(), 0.0)
        self.assertLess(end[:, 2].max(), 6 * RADIUS)

    def test_columns_say_what_the_method_adds_and_takes(self):
        scene = {"rods": HEAP, "load": GRAVITY, "damping": DAMPED, "contact": law(), "wall": [floor()]}
        added = []
        for dt in (1e-4, 2e-4):
            self.end("out", scene, {"duration": 0.1, "dt": dt})
            series = self.series("out")
            self.assertTrue((numpy.diff(series["numerical_lossJ"]) >= 0).all())
            added.append(series["added_mass"][-1])
        self.assertGreater(added[0], 0)
        self.assertLess(abs(added[1] / added[0] - 4), 1.5, added)  # h^2 k + h c

    MANY = {"rods": [{"name": "sticks", "material": {"density": DENSITY, "youngs_modulus": 1e8}, "section": {"radius": RADIUS}, "shape": {"length": 0.04, "elements": 5},
                      "placement": {"kind": "packing", "count": 27, "seed": 2, "region": "box", "lower": [0.0, 0.0, 0.0], "upper": [0.07, 0.07, 0.05]}},
                     rod("ring", (0.02, 0.02, 0.06), (1.0, 0.0, 0.0), 12, 1e6, shape={"length": 0.1, "elements": 12, "closed": True})],
            "bodies": [{"name": "ball", "density": 900.0, "spheres": {"radii": [5e-3]}, "velocity": [0.05, 0.0, -0.3], "placement": {"origin": [0.035, 0.035, 0.075]}},
                       {"name": "block", "density": 900.0, "boxes": {"sizes": [[0.02, 0.015, 0.01]], "radii": [1e-3]}, "placement": {"origin": [0.05, 0.05, 0.08]}}],
            "load": GRAVITY + [{"kind": "slender_body_drag", "viscosity": 1e-2, "rods": ["ring"]}], "damping": [{"kind": "uniform", "rate": 2.0}], "contact": law(),
            "wall": [{"name": "box", "kind": "box", "lower": [0.0, 0.0, 0.0], "upper": [0.07, 0.07, 1.0], "open": ["z+"]} | law()]}

    def test_bits_do_not_depend_on_the_layout(self):
        self.write(self.MANY, {"duration": 0.2, "dt": 4e-4}, trajectory=0.1, tips=0.05, series=0.01)
        self.run_skein("whole")
        self.assertGreater(self.series("whole")["contacts"][-1], 10)
        self.assertGreater(self.summary("whole")["implicit_bed"]["most_parts"], 1)

        def same(out):
            self.assertEqual(self.digest(out), self.digest("whole"))
            self.assert_same_frames(out, "whole", "ring")
            self.assert_same_series(out, "whole", besides=SEARCH)

        self.assert_layouts_give("whole", same)
        self.run_skein("moved", "--balance", "always", ranks=2)
        same("moved")
        self.run_skein("parts", "--until", "0.06")
        self.run_skein("parts", "--until", "0.14", "--lanes", "2", ranks=2)
        self.assertIn("Resuming", self.run_skein("parts").stdout)
        same("parts")


if __name__ == "__main__":
    unittest.main()
