"""Comparison of explicit and implicit steps in the plan: what it says of thin and of soft rods, from either side, and that the run does not feel it."""

import pathlib
import unittest

import numpy

from driver import DriverTest
from scene_text import scene_text

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
GRAVITY = [{"kind": "gravity"}]
DAMPING = [{"kind": "uniform", "rate": 10.0}]


def rod(radius, length, youngs_modulus, elements, **keys):
    return {"name": "rod", "start": "clamped", "material": {"density": 1300.0, "youngs_modulus": youngs_modulus}, "section": {"radius": radius},
            "shape": {"length": length, "elements": elements}, "placement": {"tangent": [1.0, 0.0, 0.0]}} | keys


HAIR = {"rods": [rod(4e-5, 0.1, 4e9, 50)], "load": GRAVITY, "damping": DAMPING}
# Shaken in 50 explicit steps a turn, which implicit steps must resolve too.
BAR = {"rods": [rod(0.05, 0.2, 1e6, 10, start_motion={"amplitude": [0.0, 0.0, 0.002], "period": 0.0213})]}


class Methods(DriverTest):
    def write(self, scene, **time):
        self.scene.write_text(scene_text({"time": time, "output": {"series": min(1.0, time["duration"])}} | scene))

    def pays(self, scene, **time):
        self.write(scene, **time)
        return self.plan().get("methods", {}).get("pays")

    def test_long_steps_pay_for_a_thin_rod(self):
        for integrator in ("verlet", "implicit_damped", "implicit"):
            with self.subTest(integrator=integrator):
                self.assertEqual(self.pays(HAIR, duration=2.0, integrator=integrator), "implicit")
        self.assertEqual(self.pays(HAIR, duration=2.0, integrator="implicit_damped", dt=0.01), "implicit")
        self.assertIn("implicit steps pay: \"verlet\" takes about", self.plan_text())

    def test_short_steps_pay_where_they_resolve_the_motion(self):
        for integrator in ("verlet", "implicit_damped"):
            with self.subTest(integrator=integrator):
                self.assertEqual(self.pays(BAR, duration=4000.0, integrator=integrator, **({} if integrator == "verlet" else {"tolerance": 1e-6})), "explicit")

    def test_errors_are_those_that_are_asked_for_or_found(self):
        self.pays(HAIR, duration=2.0, integrator="implicit_damped", tolerance=1e-2)
        methods = self.plan()["methods"]
        self.assertEqual(methods["implicit"]["error"], 1e-2)
        self.assertLess(methods["explicit"]["error"], 1e-6)
        ends = {}
        for steps in (30, 480):
            self.write(HAIR | {"output": {"trajectory": 0.01, "precision": "double"}}, duration=0.3, integrator="implicit_damped", dt=0.3 / steps)
            if steps == 30: told = self.plan()["methods"]["implicit"]["error"]
            self.run_skein(f"steps_{steps}")
            ends[steps] = self.frames(f"steps_{steps}", "trajectory")["groups/rod/position"]
        error = numpy.linalg.norm(ends[30] - ends[480], axis=-1).max() / 0.1
        self.assertTrue(0.5 < told / error < 2, (told, error))

    def test_short_runs_are_not_compared(self):
        self.assertIsNone(self.pays(HAIR, duration=1e-3))

    def test_joined_rods_and_rods_at_walls_are_compared(self):
        first, second = (rod(4e-5, 0.1, 4e9, 50, name=name) for name in ("first", "second"))
        threads = {"rods": [first, second | {"start": "free", "placement": {"origin": [0.1, 0.0, 0.0], "tangent": [0.0, 1.0, 0.0]}}],
                   "joint": [{"kind": "fixed", "between": ["first", "second"], "at": [1.0, 0.0]}]}
        floor = {"wall": [{"name": "floor", "kind": "plane", "point": [0.0, 0.0, -0.09], "stiffness": 10.0}]}
        for name, tables in (("joined", HAIR | threads), ("wall", HAIR | floor)):
            for integrator in ("verlet", "implicit_damped"):
                with self.subTest(name=name, integrator=integrator): self.assertEqual(self.pays(tables, duration=2.0, integrator=integrator), "implicit")

    def test_copies_of_assemblies_are_compared_on_any_lanes(self):
        """Explicit steps lay the rods of a lone copy side by side, implicit ones in a lane of their own."""
        self.scene = APPS / "millipede/one_bot.toml"
        for lanes in ("1", "8"):
            for integrator in ("verlet", "implicit_damped"):
                with self.subTest(lanes=lanes, integrator=integrator):
                    methods = self.plan("--set=time.duration=400", f"--set=time.integrator={integrator}", *(() if integrator == "verlet" else ("--set=time.dt=0.01",)), "--lanes", lanes)["methods"]
                    self.assertEqual(methods["pays"], "explicit")

    def test_a_trial_ends_within_a_step(self):
        """Snakes in steps of 0.1 s: each has thousands of parts, more than plan() would wait for."""
        self.scene = APPS.parent / "bench/scenes/snakes/bed_256.toml"
        plan = self.plan("--set=time.duration=300", "--set=time.integrator=implicit_bed", "--set=time.dt=0.1")
        self.assertEqual(plan["methods"]["pays"], "explicit")
        self.assertLessEqual(plan["methods"]["covered"] * plan["steps"], 2)
        self.assertGreater(plan["methods"]["implicit"]["predicted_s"], 100 * plan["methods"]["explicit"]["predicted_s"])

    def test_rods_that_touch_are_compared_as_a_whole(self):
        """By their own steps and by those of a bed: nests gain by these, snakes that move all the time do not."""
        for scene, settings, integrator in (("nest/nest_110.toml", (), "implicit_bed"), ("nest/nest_110.toml", ("--set=time.integrator=implicit_bed", "--set=time.dt=2e-4"), "implicit_bed")):
            with self.subTest(scene=scene, settings=settings):
                self.scene = APPS / scene
                methods = self.plan(*settings)["methods"]
                self.assertEqual((methods["pays"], methods["implicit"]["integrator"], methods["explicit"]["integrator"]), ("implicit", integrator, "verlet"))
        self.scene = APPS / "active_matter/pit_1024.toml"
        methods = self.plan()["methods"]
        self.assertNotEqual(methods["pays"], "implicit", methods)

    def test_audited_runs_are_compared(self):
        self.assertEqual(self.pays(HAIR | {"output": {"audit": True, "series": 1.0}}, duration=2.0), "implicit")

    def test_the_run_does_not_feel_it(self):
        self.write(HAIR, duration=2.0, integrator="implicit_damped")
        self.assertIn("implicit steps pay", self.run_skein("compared").stdout)
        self.assertNotIn("steps pay", self.run_skein("quiet", "--quiet").stdout)
        self.assertEqual(self.digest("compared"), self.digest("quiet"))

    def test_few_rods_take_few_lanes(self):
        most = None
        for count, narrow in ((1, 1), (3, 4), (8, None)):
            scene = HAIR | {"rods": [rod(4e-5, 0.1, 4e9, 50) | {"placement": {"kind": "lattice", "counts": [count, 1], "spacing": [0.01, 0.01]}}]}
            self.write(scene, duration=0.1, integrator="implicit_damped", dt=0.05)
            if self.plan("--lanes", "1")["machine"]["lanes"] > 1: self.skipTest("kernels of 1 lane are not built")
            most = most or self.plan("--lanes", "8", "--threads", "1")["machine"]["lanes"]
            self.assertEqual(self.plan("--threads", "1")["machine"]["lanes"], most if narrow is None else min(narrow, most))
            self.run_skein(f"chosen_{count}", threads=1)
            self.run_skein(f"given_{count}", "--lanes", "8", threads=1)
            self.assertEqual(self.digest(f"chosen_{count}"), self.digest(f"given_{count}"))


if __name__ == "__main__":
    unittest.main()
