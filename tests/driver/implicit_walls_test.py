"""Implicit steps of second order at walls: order while contacts last, rest, energy, impacts, friction with memory, driven walls, and the same bits however they are run."""

import itertools
import math
import unittest

import numpy

from driver import DriverTest
from scene_text import scene_text

METHODS = ("implicit", "implicit_damped")
RADIUS, LENGTH, DENSITY = 2e-3, 0.1, 1000.0
GRAVITY = [{"kind": "gravity"}]
DAMPED = [{"kind": "uniform", "rate": 20.0}]
MASS = DENSITY * math.pi * RADIUS**2 * LENGTH


def law(stiffness=1e4, friction="memory", normal="linear", damping=0.5, **keys):
    keys = {"law": normal, "stiffness": stiffness, "damping": damping} | keys
    if friction != "none":
        keys = {"friction": friction, "static_friction": 0.4} | keys
        keys |= {"tangential_damping": 0.1} if friction == "memory" else {"slip_speed": 1e-2}
    return keys


def rod(name="rod", origin=(0.0, 0.0, RADIUS), tangent=(1.0, 0.0, 0.0), elements=8, youngs_modulus=1e6, shape=None, **keys):
    return {"name": name, "material": {"density": DENSITY, "youngs_modulus": youngs_modulus}, "section": {"radius": RADIUS},
            "shape": {"length": LENGTH, "elements": elements} | (shape or {}), "placement": {"origin": list(origin), "tangent": list(tangent)}} | keys


def floor(**keys):
    return {"name": "floor", "kind": "plane"} | ({} if "law" in keys else law()) | keys


BALL = {"name": "ball", "density": 900.0, "spheres": {"radii": [5e-3]}}
# Scenes whose contacts last: duration, the fewest steps, tables.
SUNK = 1e-4  # m, overlap at the start
SUNK_ROD = rod(origin=(0, 0, RADIUS - SUNK))
PUSH = {"kind": "formula", "force": ["0", "2*sin(w*t)", "-20-10*cos(w*t)"]}
CONSTANTS = {"w": {"value": 200.0, "unit": "1/s"}}
LASTING = {
    "smooth": (0.02, 100, {"rods": [SUNK_ROD], "load": [PUSH], "constants": CONSTANTS, "wall": [floor(**law(2e3, "none"))]}),
    "hertz": (0.02, 100, {"rods": [SUNK_ROD], "load": [PUSH], "constants": CONSTANTS, "wall": [floor(**law(2e5, "none", "hertz", 60.0))]}),
    "sticking": (0.02, 100, {"rods": [SUNK_ROD], "load": [PUSH], "constants": CONSTANTS, "wall": [floor(**law(2e3))]}),
    "sliding": (0.02, 200, {"rods": [SUNK_ROD | {"shape": SUNK_ROD["shape"] | {"velocity": [2.0, 1.0, 0.0]}}], "load": [PUSH], "constants": CONSTANTS,
                            "wall": [floor(**law(2e3, "regularised", static_friction=0.02))]}),
    "in a tube": (0.02, 100, {"rods": [rod(origin=(0, 0, -8e-3 - SUNK))], "load": [PUSH], "constants": CONSTANTS,
                              "wall": [{"name": "tube", "kind": "tube", "axis": [1.0, 0.0, 0.0], "radius": 1e-2} | law(2e3, "none")]}),
    "moving": (0.02, 100, {"rods": [SUNK_ROD], "load": [PUSH], "constants": CONSTANTS, "wall": [floor(velocity=[0.0, 0.05, 0.02], **law(2e3))]}),
    "a body": (0.02, 100, {"bodies": [BALL | {"placement": {"origin": [0.0, 0.0, 4.9e-3]}}], "load": [{"kind": "gravity", "acceleration": [2.0, 1.0, -300.0]}], "wall": [floor(**law(2e3))]}),
}


class ImplicitWalls(DriverTest):
    def write(self, scene, time, **output):
        self.scene.write_text(scene_text({"time": time, "output": {"precision": "double"} | output} | scene))

    def places(self, out):
        frames = self.frames(out, "trajectory")
        return numpy.concatenate([frames[name][-1].reshape(-1, 3) for name in sorted(frames) if name.endswith("/position")])

    def end(self, out, scene, time, *arguments, rows=50, **layout):
        self.write(scene, time, trajectory=time["duration"], series=time["duration"] / rows)
        self.run_skein(out, "--overwrite", *arguments, **layout)
        return self.places(out)

    def test_contacts_that_last_are_of_second_order(self):
        """Explicit steps come to the same places: of first order in the dashpots of friction, and nearer with twice as many."""
        for name, (duration, fewest, scene) in LASTING.items():
            def ends(integrator, *times):
                return [self.end("out", scene, {"duration": duration, "dt": duration / (n * fewest), "integrator": integrator}, rows=fewest) for n in times]

            coarse, fine = ends("implicit", 32, 64)
            limit = fine + (fine - coarse) / 3
            explicit = [numpy.abs(end - limit).max() for end in ends("verlet", 64, 128)]
            self.assertLess(explicit[1], 0.6 * explicit[0])
            for method in METHODS:
                with self.subTest(scene=name, method=method):
                    errors = [numpy.abs(end - limit).max() for end in ends(method, 1, 2, 4)]
                    self.assertEqual(numpy.ptp(self.series("out")["wall_contacts"][1:]), 0)
                    self.assertLess(abs(math.log2(errors[1] / errors[2]) - 2), 0.15, errors)
                    self.assertLess(explicit[1], errors[1], "explicit steps, 64 times as many, come to the same places")

    def test_books_of_walls_close(self):
        """Works of walls are those of explicit steps, and the books of steps that keep energy close to rounding."""
        for name in ("hertz", "sliding", "moving", "a body"):
            duration, fewest, scene = LASTING[name]
            works = {}
            for method, steps in (("verlet", 128 * fewest), *((method, 4 * fewest) for method in METHODS)):
                self.write(scene, {"duration": duration, "dt": duration / steps, "integrator": method}, series=duration / 20, audit=True)
                self.run_skein("out", "--overwrite", "--no-checkpoint")
                series = self.series("out")
                size = sum(numpy.ptp(series[of]) for of in series.dtype.names if of.startswith(("kinetic", "elastic", "work")))
                works[method] = numpy.array([series[f"wall_{of}J"][-1] for of in ("friction_work", "viscous_work", "energy")])
                defect = abs(series["energy_defectJ"]).max() / size
                self.assertLess(defect, {"implicit": 1e-12}.get(method, 1e-7), (name, method))
            for method in METHODS:
                self.assertLess(numpy.abs(works[method] - works["verlet"]).max(), 5e-3 * works["verlet"].max(), (name, method, works))

    def test_rods_at_walls_come_to_the_rest_of_an_equilibrium(self):
        leaning = {"rods": [rod(start="clamped", origin=(0.0, 0.0, RADIUS + 5e-4), youngs_modulus=1e8)], "load": GRAVITY, "damping": DAMPED, "wall": [floor(**law(friction="none"))]}
        self.write(leaning, {"duration": 1.0}, trajectory=1.0)
        self.skein_says("equilibrium", self.scene, "--out", self.directory / "rest", "--overwrite", "-q")
        rest = self.places("rest")
        for method, dt in zip(METHODS, (2e-4, 2e-3)):
            with self.subTest(method=method):
                end = self.end("out", leaning, {"duration": 4.0, "dt": dt, "integrator": method})
                self.assertGreaterEqual(self.series("out")["wall_contacts"][-1], 1)
                self.assertLess(numpy.abs(end - rest).max(), 1e-8 * LENGTH)

    def test_walls_of_any_stiffness_bring_rods_to_rest(self):
        for normal in ("linear", "hertz"):
            for stiffness in (1e4, 1e6, 1e8, 1e10):
                of = law(stiffness, normal=normal, damping=0.5 * math.sqrt(stiffness / 1e4))
                for dt in (1e-5, 1e-4, 1e-3):
                    with self.subTest(normal=normal, stiffness=stiffness, dt=dt):
                        scene = {"rods": [rod(youngs_modulus=1e8)], "bodies": [BALL | {"placement": {"origin": [0.0, 0.1, 5e-3]}}], "load": GRAVITY,
                                 "damping": [{"kind": "uniform", "rate": 1 / (200 * dt)}], "wall": [floor(**of)]}
                        self.write(scene, {"duration": 3000 * dt, "dt": dt, "integrator": "implicit_damped"}, series=10 * dt)
                        self.run_skein("out", "--overwrite", "--no-checkpoint")
                        energy = self.series("out")["kinetic_translationJ"]
                        self.assertLess(energy[225:].max(), 1e-5 * MASS * 9.81 * RADIUS)

    THROWN = {"shape": {"velocity": [0.3, 0.2, -0.5], "angular_velocity": [3.0, 5.0, 1.0]}}
    PLAIN = law(friction="none", damping=0.0)
    ENCLOSED = {"planes": [{"name": "box", "kind": "box", "lower": [-0.02, -0.06, 0.0], "upper": [0.12, 0.06, 0.06]} | PLAIN],
                "tube": [{"name": "tube", "kind": "tube", "point": [0.0, 0.0, 0.02], "axis": [1.0, 0.0, 0.0], "radius": 0.03} | PLAIN,
                         {"name": "left", "kind": "plane", "point": [-0.05, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]} | PLAIN,
                         {"name": "right", "kind": "plane", "point": [0.15, 0.0, 0.0], "normal": [-1.0, 0.0, 0.0]} | PLAIN]}

    def test_impacts_keep_the_energy_or_take_of_it(self):
        """Of an undamped rod that is thrown to and fro between elastic walls, resolved and not."""
        for name, walls in self.ENCLOSED.items():
            for stiffness, method in itertools.product((1e3, 1e6, 1e9), METHODS):
                with self.subTest(walls=name, stiffness=stiffness, method=method):
                    scene = {"rods": [rod(origin=(0.0, 0.0, 0.02), **self.THROWN)], "wall": [wall | {"stiffness": stiffness} for wall in walls]}
                    self.write(scene, {"duration": 2.0, "dt": 1e-3, "integrator": method}, series=1e-2)
                    self.run_skein("out", "--overwrite", "--no-checkpoint")
                    series = self.series("out")
                    energy = sum(series[of] for of in series.dtype.names if of.startswith(("kinetic", "elastic")))
                    free = energy[series["wall_contacts"] == 0]  # of contacts that press the series has the middle of a step
                    self.assertLess(len(free), len(energy))
                    self.assertLess(free.max(), energy[0] * (1 + 1e-7))
                    if method == "implicit": self.assertGreater(free.min(), energy[0] * (1 - 1e-7))

    def test_a_rod_that_swings_into_a_wall_comes_to_the_explicit_places(self):
        wall = [{"name": "wall", "kind": "plane", "point": [0.05, 0.0, 0.0], "normal": [-1.0, 0.0, 0.0]} | law(1e3, "none")]
        scene = {"rods": [rod(start="pinned", tangent=(0.0, 0.0, -1.0), youngs_modulus=1e7, shape={"angular_velocity": [0.0, -20.0, 0.0]})], "load": GRAVITY, "wall": wall}
        explicit = self.end("explicit", scene, {"duration": 0.05, "dt": 0.05 / 80000})
        for method in METHODS:
            ends = [self.end("out", scene, {"duration": 0.05, "dt": 0.05 / n, "integrator": method}) for n in (1000, 4000, 16000)]
            self.assertGreaterEqual(self.series("out")["wall_contacts"].max(), 1)
            errors = [numpy.abs(end - explicit).max() for end in ends]
            for a, b in zip(errors, errors[1:]): self.assertLess(b, a / 4, errors)

    def test_friction_holds_and_lets_go(self):
        """A rod along a slope, as gravity is inclined: below the angle of friction it stays where it is, above it it slides at the difference."""
        for slope in (0.3, 0.5):
            scene = {"rods": [rod(origin=(0, 0, RADIUS))], "load": [{"kind": "gravity", "acceleration": [9.81 * slope, 0.0, -9.81]}], "wall": [floor(**law())]}
            for method in METHODS:
                with self.subTest(slope=slope, method=method):
                    end = self.end("out", scene, {"duration": 0.4, "dt": 1e-3, "integrator": method})
                    way = end[:, 0].min()
                    slides = 0.5 * 9.81 * max(0.0, slope - 0.4) * 0.4**2
                    self.assertLess(abs(way - slides), 0.03 * slides + 2e-5)
                    series = self.series("out")
                    lost = series["wall_friction_workJ"][-1]
                    self.assertLess(abs(lost - MASS * 9.81 * 0.4 * slides), 0.03 * MASS * 9.81 * 0.4 * slides + 1e-7)

    def test_driven_walls_turn_where_explicit_ones_do(self):
        lid = {"name": "lid", "kind": "plane", "point": [0.0, 0.0, 2 * RADIUS + 1e-3], "normal": [0.0, 0.0, -1.0],
               "servo": {"speed": 0.02, "watch": "floor", "area": LENGTH * 2 * RADIUS, "turn_back_above": 5e3, "turn_forth_below": 700.0, "not_before": 2 * RADIUS, "cycles": 2}} | law(1e3)
        scene = {"rods": [rod()], "load": GRAVITY, "damping": DAMPED, "wall": [floor(**law(1e3)), lid]}
        self.end("explicit", scene, {"duration": 0.3}, rows=300)
        explicit = self.series("explicit")
        for method, keys in itertools.product(METHODS, ({"dt": 1e-4}, {"tolerance": 1e-4, "divide": 1e-4})):
            with self.subTest(method=method, keys=keys):
                self.end("out", scene, {"duration": 0.3, "integrator": method} | keys, rows=300)
                series = self.series("out")
                self.assertEqual(series["lid_turns"][-1], explicit["lid_turns"][-1])
                self.assertLess(numpy.abs(series["lid_heightm"] - explicit["lid_heightm"]).max(), 0.02 * numpy.ptp(explicit["lid_heightm"]))

    MANY = {"rods": [rod("sticks", elements=6, placement={"kind": "lattice", "counts": [4, 3], "spacing": [0.12, 0.03], "origin": [0.0, 0.0, RADIUS], "tangent": [1.0, 0.0, 0.0]}),
                     rod("ring", elements=12, placement={"origin": [0.0, 0.3, 0.04]}, shape={"closed": True})],
            "bodies": [BALL | {"velocity": [0.1, 0.0, 0.0], "angular_velocity": [1.0, 20.0, 3.0], "placement": {"origin": [0.0, 0.5, 6e-3]}},
                       {"name": "block", "density": 900.0, "boxes": {"sizes": [[0.02, 0.015, 0.01]], "radii": [1e-3]}, "placement": {"origin": [0.05, 0.6, 0.01]}}],
            "load": [{"kind": "gravity", "acceleration": [3.0, 0.0, -9.81]}], "damping": [{"kind": "uniform", "rate": 2.0}], "wall": [floor(), {"name": "side", "kind": "plane", "point": [0.465, 0.0, 0.0], "normal": [-1.0, 0.0, 0.0]} | law()]}
    TIMES = {"fixed": {"dt": 1e-3}, "parts": {"tolerance": 1e-3, "divide": 0.01}}

    def test_bits_do_not_depend_on_the_layout_and_restarts(self):
        for method, (kind, keys) in itertools.product(METHODS, self.TIMES.items()):
            with self.subTest(method=method, time=kind):
                falls = ("ring", "ball", "block")  # impacts take thousands of parts for a tolerance
                scene = self.MANY if kind == "fixed" else {of: rows for of, rows in self.MANY.items() if of != "bodies"} | {"rods": [part for part in self.MANY["rods"] if part["name"] not in falls]}
                self.write(scene, {"duration": 0.1, "integrator": method} | keys, trajectory=0.05, tips=0.02, series=0.01)
                whole = f"whole_{method}_{kind}"
                self.run_skein(whole)
                self.assertGreater(self.series(whole)["wall_contacts"].max(), 10)

                def same(out):
                    self.assertEqual(self.digest(out), self.digest(whole))
                    self.assert_same_frames(out, whole, "sticks")
                    self.assert_same_series(out, whole)

                self.assert_layouts_give(whole, same)
                parts = f"{whole}_parts"
                self.run_skein(parts, "--until", "0.03")
                self.run_skein(parts, "--until", "0.07", "--lanes", "2")
                self.assertIn("Resuming", self.run_skein(parts).stdout)
                same(parts)


if __name__ == "__main__":
    unittest.main()
