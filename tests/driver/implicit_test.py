"""Implicit steps: order, agreement with explicit runs, energy and momenta over many steps, rest, parts by error, and the same bits however they are run."""

import itertools
import math
import unittest

import numpy

from driver import DriverTest
from scene_text import scene_text

METHODS = ("implicit", "implicit_damped")
LENGTH, DENSITY = 0.5, 1000.0
MAGNET = {"magnetisation": {"pattern": "uniform", "strength": 2e4, "direction": [1.0, 0.0, 0.0]}}
RISES = {"ramp": 0.1, "ramp_shape": "cosine"}


def rod(youngs_modulus=1e6, elements=8, radius=1e-2, tangent=(1.0, 0.0, 0.0), shape=None, **keys):
    return {"name": "rod", "material": {"density": DENSITY, "youngs_modulus": youngs_modulus}, "section": {"radius": radius},
            "shape": {"length": LENGTH, "elements": elements} | (shape or {}), "placement": {"tangent": list(tangent)}} | keys


GRAVITY = [{"kind": "gravity"}]
# Duration, s, the fewest steps, and the scene: twice and four times as many have errors of second order. Fewer leave axial motion unresolved.
SCENES = {
    "cantilever": (0.1, 400, {"rods": [rod(1e5, start="clamped")], "load": GRAVITY}),
    "pendulum": (0.1, 400, {"rods": [rod(3e5, start="pinned", tangent=(0.8, 0.0, -0.6))], "load": GRAVITY}),
    "whip": (0.1, 800, {"rods": [rod(2e5, start="clamped", start_motion={"amplitude": [0.0, 0.0, 0.02], "period": 0.1})]}),
    "turning": (0.1, 800, {"rods": [rod(2e5, start="clamped", start_motion={"rotation_amplitude": [0.0, 0.5, 0.3], "period": 0.1})]}),
    "filtered": (0.1, 400, {"rods": [rod(1e5, start="clamped")], "load": GRAVITY, "damping": [{"kind": "laplacian", "rate": 200.0, "order": 1}, {"kind": "laplacian", "rate": 500.0, "order": 3}]}),
    "filtered whip": (0.1, 800, {"rods": [rod(2e5, start="clamped", start_motion={"amplitude": [0.0, 0.0, 0.02], "period": 0.1})], "damping": [{"kind": "laplacian", "rate": 500.0, "order": 2}]}),
    "cilium": (0.1, 100, {"rods": [rod(elements=10, start="clamped", **MAGNET)],
                          "load": [{"kind": "magnetic_field", "constant": [0.0, 2e-2, 0.0], "rotating": 2e-2, "period": 0.1} | RISES]}),
    "ring": (0.1, 100, {"rods": [rod(elements=12, shape={"closed": True}, **MAGNET)],
                        "load": [{"kind": "magnetic_field", "constant": [0.0, 2e-2, 1e-2]} | RISES]}),
}


def joined(first=None, second=None, joints=(), **tables):
    """A rod that hangs on a slope, and one at its end."""
    upper = rod(1e5, name="upper", shape={"length": 0.25, "elements": 6}, tangent=(0.8, 0.0, -0.6)) | (first or {"start": "pinned"})
    lower = rod(1e5, name="lower", shape={"length": 0.25, "elements": 6}, placement={"origin": [0.2, 0.0, -0.15], "tangent": [0.0, 0.6, -0.8]}) | (second or {})
    return {"rods": [upper, lower], "load": GRAVITY, "joint": [{"between": ["upper", "lower"], "at": [1.0, 0.0]} | joint for joint in joints]} | tables


HINGE = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "stiffness": 1e3, "torsional_stiffness": 0.1}
BLOCK = {"name": "block", "mass": 0.2, "inertia": [1e-4, 1e-4, 2e-4], "spheres": {"radii": [0.03]}, "angular_velocity": [3.0, 5.0, 1.0]}
SCENES |= {
    "spherical": (0.1, 800, joined(joints=[{"kind": "spherical", "stiffness": 1e3}])),
    "hinge": (0.1, 800, joined(joints=[HINGE | {"spring": 0.02, "friction": 1e-3, "friction_stiffness": 0.05, "friction_damping": 1e-4}])),
    "motor": (0.1, 800, joined(joints=[HINGE | {"motor": {"kind": "position", "value": "0.5*sin(w*t)^2", "stiffness": 0.5, "damping": 1e-3}}],
                               constants={"w": {"value": 30.0, "unit": "1/s"}})),
    "half cells": (0.1, 800, joined({"start": "clamped"}, joints=[{"kind": "fixed"}])),
    "on a body": (0.1, 800, {"rods": [rod(1e5, name="upper", shape={"length": 0.25, "elements": 6}, placement={"origin": [0.0, 0.03, 0.0], "tangent": [0.0, 1.0, 0.0]})],
                             "bodies": [BLOCK | {"angular_velocity": [0.0, 0.0, 0.0]}],  # one that turns strikes the rod
                             "load": [*GRAVITY, {"kind": "end_force", "end": [0.05, 0.0, -0.05], "rods": ["upper"]}],
                             "joint": [{"kind": "fixed", "between": ["upper", "block"], "at": [0.0, 0.0]}]}),
}
EXPLICIT_STEPS = 8000
EXPLICIT_ENDS = {}  # by name
CURVED = {"rest_curvature": [3.0, 1.0, 2.0], "start_curvature": [2.0, 0.5, 0.0], "angular_velocity": [3.0, 5.0, 1.0], "velocity": [0.3, 0.2, 0.1]}


def mean_of_quarter(values, quarter):
    return values[len(values) * quarter // 4 : len(values) * (quarter + 1) // 4].mean()


class Implicit(DriverTest):
    def write(self, scene, time, **output):
        self.scene.write_text(scene_text({"time": time, "output": {"precision": "double"} | output} | scene))

    def run_scene(self, out, scene, time, *arguments, frames=1, rows=1, observables=(), **layout):
        """Places of all nodes at the end."""
        self.write(scene, time, trajectory=time["duration"] / frames, series=time["duration"] / rows, observables=list(observables))
        self.run_skein(out, "--overwrite", *arguments, **layout)
        return self.places(out)

    def places(self, out):
        frames = self.frames(out, "trajectory")
        return numpy.concatenate([frames[name][-1].reshape(-1, 3) for name in sorted(frames) if name.endswith("/position")])

    def explicit_end(self, name):
        """Richardson's value of two explicit runs."""
        if name not in EXPLICIT_ENDS:
            duration, _, scene = SCENES[name]
            coarse, fine = (self.run_scene("explicit", scene, {"duration": duration, "dt": duration / n}) for n in (EXPLICIT_STEPS, 2 * EXPLICIT_STEPS))
            EXPLICIT_ENDS[name] = fine + (fine - coarse) / 3
        return EXPLICIT_ENDS[name]

    def test_steps_are_of_second_order_and_come_to_the_explicit_places(self):
        for name, (duration, fewest, scene) in SCENES.items():
            explicit = self.explicit_end(name)
            for method in METHODS:
                with self.subTest(scene=name, method=method):
                    ends = [self.run_scene("out", scene, {"duration": duration, "dt": duration / n, "integrator": method})
                            for n in (fewest, 2 * fewest, 4 * fewest)]
                    errors = [numpy.abs(end - explicit).max() for end in ends]
                    for a, b in zip(errors, errors[1:]):
                        self.assertLess(abs(math.log2(a / b) - 2), 0.1, errors)
                    beyond = numpy.abs(ends[2] + (ends[2] - ends[1]) / 3 - explicit).max()
                    self.assertLess(beyond, 0.1 * errors[2], errors)

    def energies(self, scene, steps, times, rows=200):
        """Series of an undamped run with steps of so many times the explicit step, and its energy at every row, J."""
        self.write(scene, {"duration": 1.0})
        duration = steps * times * self.plan()["dt"]
        self.run_scene("out", scene, {"duration": duration, "dt": duration / steps, "integrator": "implicit"}, "--no-checkpoint", rows=rows, observables=["angular_momentum"])
        series = self.series("out")
        energy = sum(series[name] for name in series.dtype.names if name.startswith(("kinetic", "elastic")))
        if "load" in scene:
            part = scene["rods"][0]
            energy = energy + DENSITY * math.pi * part["section"]["radius"] ** 2 * LENGTH * 9.81 * series["centre_zm"]
        return series, energy

    def test_energy_stays_over_many_steps(self):
        """Of a heavy cantilever, a pendulum that flails, a thin curved rod and a soft one that spin free. The midpoint rule gains 1 % of the last at 20 times the explicit step, and loses it at 100."""
        scenes = {"cantilever": {"rods": [rod(1e8, start="clamped")], "load": GRAVITY},
                  "pendulum": {"rods": [rod(3e5, start="pinned", tangent=(0.8, 0.0, -0.6))], "load": GRAVITY},
                  "free": {"rods": [rod(1e9, radius=1e-3, shape=CURVED)]}, "soft": {"rods": [rod(shape=CURVED)]}}
        for name, scene in scenes.items():
            for times in (20, 100):
                with self.subTest(scene=name, times=times):
                    series, energy = self.energies(scene, 20000, times)
                    scale = abs(energy[0]) + series["kinetic_translationJ"].max()
                    kept = 1e-6 if name == "pendulum" else 1e-8  # its corrections end more slowly
                    self.assertLess(numpy.abs(energy - energy[0]).max(), kept * scale)

    def test_momenta_of_a_free_rod_stay(self):
        for times in (1, 20, 100):
            with self.subTest(times=times):
                series, _ = self.energies({"rods": [rod(shape=CURVED)]}, 2000, times)
                for name in ("momentum", "angular_momentum"):
                    columns = [column for column in series.dtype.names if column.startswith(f"{name}_")]
                    self.assertEqual(len(columns), 3)
                    values = numpy.stack([series[column] for column in columns])
                    self.assertLess(numpy.abs(values - values[:, :1]).max(), 1e-8 * numpy.linalg.norm(values[:, 0]), name)

    def test_momenta_of_free_joined_rods_stay(self):
        turning = {"shape": {"length": 0.25, "elements": 6, "velocity": [0.3, 0.2, 0.1], "angular_velocity": [3.0, 5.0, 1.0]}}
        scenes = {name: joined(turning, turning, joints) for name, joints in {"spring": [HINGE], "half cells": [{"kind": "fixed"}]}.items()}
        scenes["on a body"] = SCENES["on a body"][2] | {"bodies": [BLOCK]}
        for name, scene in scenes.items():
            scene.pop("load")
            with self.subTest(joint=name):
                series, _ = self.energies(scene, 500, 20)
                mass = DENSITY * math.pi * 1e-2**2 * LENGTH
                scale = math.sqrt(2 * mass * series["kinetic_translationJ"].max())
                self.assertGreater(scale, 0.01 * mass)
                for what, size in {"momentum": scale, "angular_momentum": scale * LENGTH}.items():
                    values = numpy.stack([series[column] for column in series.dtype.names if column.startswith(f"{what}_")])
                    self.assertEqual(len(values), 3)
                    self.assertLess(numpy.abs(values - values[:, :1]).max(), 1e-8 * size, what)

    def test_joints_tear_when_explicit_ones_do(self):
        """To the length of a step, in which the rod that comes off goes a way."""
        pulled = [{"kind": "end_force", "end": [2.0, 0.0, -1.5], "rods": ["lower"]} | RISES]
        scene = joined({"start": "clamped"}, {"placement": {"origin": [0.2, 0.0, -0.15], "tangent": [0.8, 0.0, -0.6]}},
                       [{"kind": "fixed", "break_strain": 0.03}]) | {"load": pulled}
        explicit = self.run_scene("explicit", scene, {"duration": 0.1, "dt": 0.1 / 32000})
        whole = self.run_scene("whole", scene | {"joint": [scene["joint"][0] | {"break_strain": 1.0}]}, {"duration": 0.1, "dt": 0.1 / 32000})
        moved = numpy.abs(explicit - whole).max()
        self.assertGreater(moved, 0.01 * LENGTH)
        for method in METHODS:
            for steps in (400, 1600):
                with self.subTest(method=method, steps=steps):
                    end = self.run_scene("out", scene, {"duration": 0.1, "dt": 0.1 / steps, "integrator": method})
                    self.assertLess(numpy.abs(end - explicit).max(), 4 * moved / steps)

    def test_strong_damping_ends_at_the_equilibrium(self):
        scenes = {"heavy": ({"load": GRAVITY}, {}), "followed": ({"load": [{"kind": "end_force", "frame": "body", "end": [0.0, 0.01, 0.02]}]}, {}),
                  "curved": ({"load": GRAVITY}, {"shape": {"rest_curvature": [2.0, 1.0, 0.5], "start_curvature": [0.0, 0.0, 0.0]}})}
        for name, (tables, keys) in scenes.items():
            scene = {"rods": [rod(start="clamped", **keys)], "damping": [{"kind": "uniform", "rate": 3.5}]} | tables
            for method, dt in zip(METHODS, (1e-3, 0.02)):  # undamped steps that leave axial motion unresolved ring on
                with self.subTest(scene=name, method=method):
                    time = {"duration": 15.0, "dt": dt, "integrator": method}
                    ends = self.run_scene("run", scene, time)
                    self.write(scene, time, trajectory=15.0)
                    self.skein_says("equilibrium", self.scene, "--out", self.directory / "rest", "--overwrite", "-q")
                    rest = self.places("rest")
                    self.assertGreater(numpy.abs(rest[-1] - [LENGTH, 0.0, 0.0]).max(), 0.01 * LENGTH)
                    self.assertLess(numpy.abs(ends - rest).max(), 1e-8 * LENGTH)

    # Tiles of more and fewer rods than lanes, a ring, and a body; loads with slopes and without.
    MANY = {"rods": [rod(elements=6, start="clamped", **MAGNET) | {"name": "carpet", "placement": {"kind": "lattice", "counts": [4, 3], "spacing": [0.5, 0.5]},
                                                                   "magnetisation": {"pattern": "wave_x", "strength": 2e4, "wavelength_x": 1.7}},
                     rod(elements=11, shape={"closed": True}, **MAGNET) | {"name": "ring"}, rod(shape=CURVED) | {"name": "free"}],
            "bodies": [{"name": "ball", "density": 900.0, "spheres": {"radii": [0.02]}, "velocity": [0.1, 0.0, 0.0], "angular_velocity": [1.0, 2.0, 3.0], "placement": {"origin": [0.0, 3.0, 0.0]}}],
            "load": [{"kind": "gravity", "rods": ["free", "ball"]}, {"kind": "magnetic_field", "constant": [0.0, 2e-3, 1e-3], "rotating": 5e-3, "period": 0.2, "rods": ["carpet", "ring"]}]}
    # Copies of an assembly with half cells that tear, a body, friction, and joints that are made and end.
    JOINED = {"rods": [rod(elements=6, name=name, assembly="robot", shape={"length": 0.1, "elements": 4}, placement={"origin": origin, "tangent": [1.0, 0.0, 0.0]})
                       for name, origin in (("carpet", [0.0, 0.0, 0.0]), ("hand", [0.1, 0.0, 0.0]), ("torn", [0.2, 0.0, 0.0]))],
              "bodies": [BLOCK | {"assembly": "robot", "placement": {"origin": [-0.03, 0.0, 0.0]}}],
              "assembly": [{"name": "robot", "scatter": [0.01, 0.0, 0.02], "placement": {"kind": "line", "counts": [11], "spacing": [1.0], "tangent": [0.0, 1.0, 0.0]}}],
              "joint": [{"kind": "fixed", "between": ["carpet", "block"], "at": [0.0, 0.0]}, {"kind": "fixed", "between": ["hand", "torn"], "break_strain": 1e-3},
                        HINGE | {"between": ["carpet", "hand"], "friction": 1e-4, "friction_stiffness": 0.05, "friction_damping": 1e-4},
                        {"kind": "spherical", "between": ["torn", "world"], "at": [1.0], "stiffness": 100.0, "until": 0.04},
                        {"kind": "spherical", "between": ["carpet", "world"], "at": [0.5], "stiffness": 50.0, "from": 0.03}],
              "load": GRAVITY}
    JOINED_TOLERANCE = 1e-4  # a joint that tears in the middle of a step would take thousands of parts for a smaller one
    TIMES = {"fixed": {"dt": 2e-3}, "parts": {"tolerance": 1e-6, "divide": 0.01}}

    def times(self, keys, scene):
        return keys | ({"tolerance": self.JOINED_TOLERANCE} if "tolerance" in keys and "joint" in scene else {})

    def test_bits_do_not_depend_on_the_layout(self):
        for scene, (method, (kind, keys)) in itertools.product((self.MANY, self.JOINED), zip(METHODS, self.TIMES.items())):
            with self.subTest(method=method, time=kind, joined="joint" in scene):
                self.write(scene, {"duration": 0.1, "integrator": method} | self.times(keys, scene), trajectory=0.05, tips=0.02, series=0.01)
                whole = f"whole_{kind}_{len(scene)}"
                self.run_skein(whole)
                if kind == "parts": self.assertGreater(self.summary(whole)["implicit"]["largest_parts"], 2)
                self.assertGreater(numpy.abs(numpy.diff(self.frames(whole, "trajectory")["groups/carpet/position"], axis=0)).max(), 1e-3)

                def same(out):
                    self.assert_same_frames(out, whole, "carpet")
                    self.assert_same_series(out, whole)

                self.assert_layouts_give(whole, same)

    def test_bits_do_not_depend_on_restarts(self):
        for scene, method in itertools.product((self.MANY, self.JOINED), METHODS):
            for kind, keys in self.TIMES.items():
                with self.subTest(method=method, time=kind, joined="joint" in scene):
                    self.write(scene, {"duration": 0.1, "integrator": method} | self.times(keys, scene), trajectory=0.05, tips=0.02, series=0.01)
                    whole, parts = f"{method}_{kind}_{len(scene)}", f"{method}_{kind}_{len(scene)}_parts"
                    self.run_skein(whole)
                    self.run_skein(parts, "--until", "0.03")
                    self.run_skein(parts, "--until", "0.07", "--lanes", "2")
                    self.assertIn("Resuming", self.run_skein(parts).stdout)
                    self.assertEqual(self.digest(parts), self.digest(whole))
                    self.assert_same_frames(parts, whole, "carpet")
                    self.assert_same_series(parts, whole)

    def test_parts_keep_the_error_that_is_asked_for(self):
        for name in ("whip", "cilium", "ring", "hinge"):
            duration, _, scene = SCENES[name]
            explicit = self.explicit_end(name)
            for method in METHODS:
                with self.subTest(scene=name, method=method):
                    for tolerance in (1e-3, 1e-5):
                        end = self.run_scene("out", scene, {"duration": duration, "tolerance": tolerance, "integrator": method})
                        self.assertLess(numpy.abs(end - explicit).max(), tolerance * LENGTH)

    def test_a_drive_whose_period_divides_the_steps_is_seen(self):
        """Steps of 0.05 s, at whose ends and middles the clamp is where it began."""
        scene = {"rods": [rod(2e5, start="clamped", start_motion={"amplitude": [0.0, 0.0, 0.02], "period": 0.025})], "damping": [{"kind": "uniform", "rate": 20.0}]}
        explicit = self.run_scene("explicit", scene, {"duration": 3.2})
        for method in METHODS:
            with self.subTest(method=method):
                end = self.run_scene("out", scene, {"duration": 3.2, "divide": 0.05, "tolerance": 1e-2, "integrator": method})
                self.assertLess(numpy.abs(end - explicit).max(), 1e-2 * LENGTH)
                self.assertLess(self.summary("out")["implicit"]["largest_error"], 1e-2)


if __name__ == "__main__":
    unittest.main()
