"""Rods that step implicitly in a fluid: one step a stage, as right as explicit rods in the same steps of the fluid, with the same momentum, books and bits however they are run."""

import unittest

import numpy

from driver import FLUID_OF_RODS, DriverTest, rods_in_a_fluid

METHODS = ("implicit", "implicit_damped")
RIGID = 2e6  # Pa, of the threads: explicit steps are 20 times shorter than stages
DURATION = 0.12


def scene(youngs_modulus=1e4, tables="", density=2.0):
    """A thick rod and two threads, all free, in a box of fluid without walls."""
    return ('title = "rods that step implicitly in a fluid"\n[time]\nduration = 0.12\n' + FLUID_OF_RODS + "largest_slip = 0\n"
            + rods_in_a_fluid((density, 2e3), (20.0, youngs_modulus), [0.0, 1.0, 1.0])
            + "[output]\nseries = 0.02\ntrajectory = 0.02\ncheckpoint = 0.06\nprecision = \"double\"\n" + tables)


SINKING = """
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -30.0]
ramp = 0.06
ramp_shape = "cosine"
"""


def smooth(text):
    """Without velocities at the start, which a fluid at rest stops at once: rods sink, more and more."""
    for velocity in ("velocity = [1.0, 0.2, 0.0]\n", "velocity = [0.0, 0.0, -1.0]\n", "angular_velocity = [0.0, 1.0, 1.0]\n"):
        text = text.replace("\n" + velocity, "\n")
    return text + SINKING


def words(**keys):
    return [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


class ImplicitFluid(DriverTest):
    def places(self, out, text, **keys):
        """Of all nodes at the end."""
        self.scene.write_text(text)
        self.run_skein(out, "--overwrite", *words(**keys))
        frames = self.frames(out, "trajectory")
        return numpy.concatenate([frames[name][-1].reshape(-1, 3) for name in sorted(frames) if name.endswith("/position")])

    def test_order_beside_explicit_rods(self):
        """In steps of the fluid that stay as they are: the second by itself, and towards explicit rods, whose places lag half a step behind what the fluid feels: the first."""
        steady = scene().replace("courant = 0.4", "courant = 0.802").replace("expected_speed = 2.0", "expected_speed = 4.0")
        ways = {"two_way": "", "one_way": '[immersion]\ncoupling = "one_way"\n',
                "penalty": '[immersion]\nforcing = "penalty"\npenalty_stiffness = 1e5\npenalty_damping = 1e3\n'}
        for way, tables in ways.items():
            at = lambda n, method: self.places("out", steady + tables, time__dt=0.02 / 30 / n, time__integrator=method)
            coarse, fine = at(16, "verlet"), at(32, "verlet")
            explicit = 2 * fine - coarse if way != "one_way" else fine + (fine - coarse) / 3
            for method in METHODS:
                ends = [at(n, method) for n in (2, 4, 8)]
                changes = [abs(b - a).max() for a, b in zip(ends, ends[1:])]
                apart = abs(ends[2] - explicit).max()
                print(f"{way}, {method}: changes {changes}, apart {apart} of {abs(fine - coarse).max()}")
                self.assertGreater(changes[0] / changes[1], 3.5, (way, method))
                self.assertLess(changes[0] / changes[1], 4.7, (way, method))
                self.assertLess(apart, 1e-2 * abs(fine - coarse).max() if way != "one_way" else changes[1], (way, method))

    def test_one_step_a_stage(self):
        """Stiff threads in automatic steps, some of which fall and some of which are thrown: places are as wrong as those of explicit rods in the same steps of the fluid."""
        for name, text in {"sinking": smooth(scene(RIGID)), "thrown": scene(RIGID)}.items():
            exact = self.places("fine", text, fluid__courant=0.025, time__integrator="implicit_damped")
            errors = []
            for courant in (0.4, 0.2, 0.1):
                explicit = self.places("explicit", text, fluid__courant=courant, time__safety=0.1)
                errors.append(abs(explicit - exact).max())
                for method in METHODS:
                    ours = self.places("one", text, fluid__courant=courant, time__integrator=method)
                    apart = abs(ours - explicit).max()
                    print(f"{name}, courant {courant}, {method}: {apart} from explicit rods, which are {errors[-1]} wrong")
                    self.assertLess(apart, 0.1 * errors[-1], (name, courant, method))
            self.assertLess(errors[-1], errors[0], name)
        self.scene.write_text(smooth(scene(RIGID)))
        plan = self.plan(*words(time__integrator="implicit"))
        self.assertGreater(self.plan()["steps"], 2 * plan["steps"])
        self.assertIn("one step of rods in a stage", self.plan_text(*words(time__integrator="implicit")))

    def test_momentum(self):
        self.scene.write_text(scene(RIGID))
        for method in METHODS:
            self.run_skein(method, *words(time__integrator=method))
            series = self.series(method)
            for axis in "xyz":
                total = series[f"coupled_momentum_{axis}kg_ms"]
                self.assertLess(numpy.ptp(total), 1e-13 * abs(series["fluid_momentum_xkg_ms"]).max() + 1e-14, (method, axis))

    def test_books(self):
        """Audits close in a fluid: in steps that keep energy to the tolerance of corrections, in beds at first order."""
        audited = smooth(scene(1e5)).replace("[output]", "[output]\naudit = true")
        for method, most in {"implicit": 1e-9, "implicit_damped": 1e-6, "implicit_bed": 1e-4}.items():
            defects = []
            for courant in (0.4, 0.2):
                self.scene.write_text(audited)
                self.run_skein("books", "--overwrite", *words(time__integrator=method, fluid__courant=courant))
                series = self.series("books")
                defects.append(abs(series["energy_defectJ"]).max() / abs(series["work_fluidJ"]).max())
            print(method, defects, "loss", abs(series["numerical_lossJ"]).max() / abs(series["work_fluidJ"]).max())
            self.assertLess(defects[0], most, method)
            self.assertLess(defects[1], max(0.7 * defects[0], 1e-11), method)

    def test_same_bits_however_they_are_run(self):
        for method in METHODS:
            self.scene.write_text(scene(RIGID).replace("largest_slip = 0\n", ""))
            of = words(time__integrator=method)
            self.run_skein(f"{method}-one", *of)
            for name, layout in {"two": {"ranks": 2}, "three": {"ranks": 3}, "threads": {"threads": 2}}.items():
                self.run_skein(f"{method}-{name}", *of, **layout)
            for lanes in (1, 4):
                self.run_skein(f"{method}-lanes{lanes}", "--lanes", str(lanes), *of)
            self.run_skein(f"{method}-parts", *of, "--until", "0.07", ranks=2)
            self.assertIn("Resuming from", self.run_skein(f"{method}-parts", *of).stdout)
            for name in ("two", "three", "threads", "lanes1", "lanes4", "parts"):
                self.assertEqual(self.digest(f"{method}-{name}"), self.digest(f"{method}-one"), (method, name))

    def test_steps_that_do_not_converge_are_made_in_more_parts(self):
        """Short rods that turn by several radians in a stage: the fluid begins a stage once, and rods have received what they have in the end."""
        self.scene.write_text("""
title = "rods that are thrown round"
[time]
duration = 0.3
integrator = "implicit_damped"
[fluid]
cells = [8, 6, 6]
spacing = 0.8
density = 2.0
viscosity = 0.02
courant = 1.5
largest_slip = 0
expected_speed = 6.0
[[rods]]
name = "short"
material = {density = 20.0, youngs_modulus = 1e6}
section.radius = 0.02
shape = {length = 0.2, elements = 4, angular_velocity = [0.0, 40.0, 10.0], velocity = [0.2, 0.0, 0.1]}
placement = {kind = "list", origins = [[2.5, 1.4, 1.0], [2.5, 2.8, 1.0]], tangent = [1.0, 0.0, 0.0]}
[output]
series = 0.1
""")
        self.run_skein("thrown")
        self.assertGreater(self.summary("thrown")["implicit"]["largest_parts"], 1)
        series = self.series("thrown")
        for axis in "xyz":
            self.assertLess(numpy.ptp(series[f"coupled_momentum_{axis}kg_ms"]), 1e-14, axis)
        self.assertGreater(abs(series["fluid_momentum_xkg_ms"]).max(), 1e-5)

    def test_tolerance_has_no_use(self):
        self.scene.write_text(scene())
        said = self.run_skein("refused", *words(time__integrator="implicit", time__tolerance=1e-3), expect=2)
        self.assertIn("in a fluid, whose steps set the clock", said.stderr)


if __name__ == "__main__":
    unittest.main()
