"""Implicit steps of second order between rods and bodies that touch: order, limits, energy, stability at any stiffness, fast starts, and the same bits however they are run."""

import itertools
import math
import unittest

import numpy

from driver import SEARCH, DriverTest
from implicit_walls_test import BALL, CONSTANTS, DAMPED, DENSITY, GRAVITY, LENGTH, METHODS, RADIUS, floor, law, rod
from scene_text import scene_text

SUNK, BALL_SUNK = 8e-6, 6e-5  # m, overlaps at the start, near those that last
SPRING = {"damping": 0.0}
PUSH = {"kind": "formula", "rods": ["top"], "force": ["0", "0.1*sin(w*t)", "-1-0.5*cos(w*t)"]}
LOW = rod("low", origin=(0.0, 0.0, 0.0), start="clamped", youngs_modulus=1e7)
ACROSS = rod("top", origin=(0.06, -0.04, 2 * RADIUS - SUNK), tangent=(0.0, 1.0, 0.0))
ALONG = rod("top", origin=(0.013, 0.0, 2 * RADIUS - SUNK))
ON_IT = BALL | {"placement": {"origin": [0.06, 0.0, 5e-3 + RADIUS - BALL_SUNK]}}
PUSHED = {"load": [PUSH], "constants": CONSTANTS, "damping": [{"kind": "uniform", "rate": 400.0}]}
# Contacts that last, by springs alone, with dashpots, and with friction: tables.
SPRINGS = {
    "across": PUSHED | {"rods": [LOW, ACROSS], "contact": law(2e3, "none", **SPRING)},
    "hertz": PUSHED | {"rods": [LOW, ACROSS], "contact": law(2e5, "none", "hertz", **SPRING)},
    "along": PUSHED | {"rods": [LOW, ALONG], "contact": law(2e3, "none", **SPRING)},
}
LOSSES = {"dashpot": PUSHED | {"rods": [LOW, ACROSS], "contact": law(2e3, "none")},
          "friction": PUSHED | {"rods": [LOW, ACROSS], "contact": law(2e3)}}
DURATION, FEWEST = 0.02, 400  # steps that contacts allow for


class ImplicitContact(DriverTest):
    def write(self, scene, time, **output):
        self.scene.write_text(scene_text({"time": time, "output": {"precision": "double"} | output} | scene))

    def places(self, out):
        frames = self.frames(out, "trajectory")
        return numpy.concatenate([frames[name][-1].reshape(-1, 3) for name in sorted(frames) if name.endswith("/position")])

    def end(self, out, scene, time, *arguments, rows=50):
        self.write(scene, time, trajectory=time["duration"], series=time["duration"] / rows)
        self.run_skein(out, "--overwrite", *arguments)
        return self.places(out)

    def ends(self, scene, integrator, *times):
        """Places after runs of these multiples of the fewest steps."""
        return [self.end("out", scene, {"duration": DURATION, "dt": DURATION / (n * FEWEST), "integrator": integrator}, rows=FEWEST) for n in times]

    def test_springs_are_of_second_order(self):
        for name, scene in SPRINGS.items():
            coarse, fine = self.ends(scene, "verlet", 32, 64)
            limit = fine + (fine - coarse) / 3
            for method in METHODS:
                with self.subTest(scene=name, method=method):
                    errors = [numpy.abs(end - limit).max() for end in self.ends(scene, method, 2, 4, 8)]
                    self.assertGreaterEqual(self.series("out")["touching_pairs"][1:].min(), 1)
                    order = math.log2(errors[1] / errors[2])
                    self.assertGreater(order, 1.8, errors)
                    if method == "implicit": self.assertLess(order, 2.2, errors)  # the other one delays contacts, at third order

    def test_losses_have_the_limit_of_explicit_steps(self):
        """With rates of the start of a step, as in explicit steps, of first order in the losses."""
        for name, scene in LOSSES.items():
            first, coarse, fine = self.ends(scene, "verlet", 2, 16, 32)
            limit = 2 * fine - coarse
            for method in METHODS:
                with self.subTest(scene=name, method=method):
                    errors = [numpy.abs(end - limit).max() for end in self.ends(scene, method, 2, 16)]
                    self.assertLess(errors[1], errors[0] / 4, errors)
                    self.assertLess(errors[0], 4 * numpy.abs(first - limit).max(), "explicit steps, half as long")

    def heap(self, stiffness, normal="linear", **keys):
        """Two rods on a floor, one across both, and a ball on it."""
        of = law(stiffness, normal=normal, damping=0.5 * math.sqrt(stiffness / 1e4))
        rods = [rod("left", (0.0, -0.02, RADIUS), **keys), rod("right", (0.01, 0.03, RADIUS), elements=7, **keys),
                rod("across", (0.047, -0.05, 3 * RADIUS), (0.0, 1.0, 0.0), 9, **keys)]
        return {"rods": rods, "bodies": [BALL | {"placement": {"origin": [0.047, 0.0, 4 * RADIUS + 5e-3]}}], "load": GRAVITY, "contact": of, "wall": [floor(**of)]}

    def test_heaps_move_and_rest_as_in_explicit_steps(self):
        """Stiff contacts cut steps into parts, and none gains energy."""
        for stiffness in (1e3, 1e6):
            scene, motion = self.heap(stiffness, youngs_modulus=1e8) | {"damping": [{"kind": "uniform", "rate": 300.0}]}, {}
            for method, keys in ("verlet", {}), *((method, {"dt": 1e-4}) for method in METHODS):
                self.write(scene, {"duration": 0.05, "integrator": method} | keys, series=1e-3)
                self.run_skein("out", "--overwrite", "--no-checkpoint")
                series = self.series("out")
                self.assertGreaterEqual(series["contacts"][-1], 2)
                motion[method] = series["kinetic_translationJ"] + series["kinetic_rotationJ"]
            most = motion["verlet"].max()
            self.assertLess(motion["verlet"][-1], 0.1 * most)
            for method in METHODS:
                with self.subTest(method=method, stiffness=stiffness): self.assertLess(abs(motion[method] - motion["verlet"]).max(), 0.05 * most)

    def test_contacts_keep_energy_and_momentum(self):
        """Of an undamped pair in free flight: a ball that is pressed on a rod, and leaves it."""
        pair = {"rods": [rod("low", origin=(0.0, 0.0, 0.0), youngs_modulus=1e7)], "bodies": [ON_IT | {"velocity": [0.0, 0.0, -0.05]}], "contact": law(2e3, "none", **SPRING)}
        nodes = numpy.full(9, DENSITY * math.pi * RADIUS**2 * LENGTH / 8)
        nodes[[0, -1]] /= 2
        ball = BALL["density"] * 4 / 3 * math.pi * 5e-3**3
        for method in METHODS:
            with self.subTest(method=method):
                self.write(pair, {"duration": 0.05, "dt": 1e-5, "integrator": method}, series=1e-4, trajectory=0.01)
                self.run_skein("out", "--overwrite", "--no-checkpoint")
                series = self.series("out")
                self.assertGreater(series["touching_pairs"].max(), 0)
                self.assertEqual(series["touching_pairs"][-1], 0)
                energy = sum(series[of] for of in series.dtype.names if of.startswith(("kinetic", "elastic", "contact_energy")))
                start = energy[0] + 0.5 * 2e3 * BALL_SUNK**2
                self.assertLess(abs(energy[-1] - start), 1e-3 * start)
                frames = self.frames("out", "trajectory")
                place = {name.split("/")[-2]: at.reshape(len(at), -1, 3) for name, at in frames.items() if name.endswith("/position")}
                centre = (numpy.einsum("k,fki->fi", nodes, place["low"]) + ball * place["ball"][:, 0]) / (nodes.sum() + ball)
                self.assertLess(abs(numpy.diff(centre, 2, axis=0)).max(), 1e-9 * LENGTH, "no force on both")

    def test_rods_that_are_thrown_do_not_pass(self):
        """They meet in steps that are cut, with a tolerance and without, and their energy does not rise."""
        thrown = {"rods": [LOW, rod("top", origin=(0.06, -0.04, 0.01), tangent=(0.0, 1.0, 0.0), shape={"velocity": [0.0, 0.0, -1.0]})], "contact": law(1e4, "none", **SPRING)}
        for method, keys in itertools.product(METHODS, ({"dt": 1e-3}, {"tolerance": 1e-2, "divide": 1e-3})):
            with self.subTest(method=method, keys=keys):
                self.write(thrown, {"duration": 0.02, "integrator": method} | keys, series=1e-3, trajectory=0.02)
                self.run_skein("out", "--overwrite", "--no-checkpoint")
                series = self.series("out")
                self.assertGreater(series["touching_pairs"].max(), 0)
                energy = sum(series[of] for of in series.dtype.names if of.startswith(("kinetic", "elastic", "contact_energy")))
                self.assertLess(energy.max(), 1.02 * energy[0])
                self.assertGreater(self.summary("out")["implicit"]["largest_parts"], 3)
                places = self.places("out")
                self.assertGreater(places[9 + 4, 2], places[5, 2], "the middle of the upper one and the lower one below it")

    def test_what_no_number_of_parts_does_is_named(self):
        """A contact that is too stiff for a 2^20th of the step, and a rod that is too fast for it."""
        fast = rod("top", origin=(0.06, -0.04, 0.01), tangent=(0.0, 1.0, 0.0), shape={"velocity": [0.0, 0.0, -1e9]})
        for rods, stiffness, reason, cure in ((
                [LOW, ACROSS], 1e16, r"step 1 in 1048576 parts is too long: rod 0 of '(low|top)' \(element \d\) and rod 0 of '(low|top)' \(element \d\) overlap by 8e-06 m, "
                r"which allows parts of \S+ s, not of 9.54e-10 s", "contacts are too stiff"), (
                [LOW, fast], 1e4, r"step 1 in 1048576 parts is too long: rod 0 of 'top' moves at 1e\+09 m/s", "something throws it")):
            with self.subTest(reason=reason):
                self.write({"rods": rods, "contact": law(stiffness, "none", **SPRING)}, {"duration": 0.01, "dt": 1e-3, "integrator": "implicit"})
                done = self.run_skein("out", "--overwrite", "--no-checkpoint", expect=4)
                self.assertRegex(done.stderr, reason)
                self.assertIn(cure, done.stderr)

    def test_bits_do_not_depend_on_the_layout_and_restarts(self):
        many = self.heap(1e4, youngs_modulus=1e7) | {"damping": DAMPED}
        many["rods"].append(rod("sticks", elements=6, placement={"kind": "lattice", "counts": [3, 2], "spacing": [0.12, 2 * RADIUS - 1e-5], "origin": [0.0, 0.1, RADIUS], "tangent": [1.0, 0.0, 0.0]}))
        for method, keys in (("implicit", {"dt": 1e-3}), ("implicit_damped", {"dt": 1e-3}), ("implicit", {"tolerance": 1e-2, "divide": 5e-3})):
            with self.subTest(method=method, keys=keys):
                scene = many if "dt" in keys else {of: rows for of, rows in many.items() if of != "bodies"}
                self.write(scene, {"duration": 0.02, "integrator": method} | keys, trajectory=0.01, tips=0.01, series=5e-3)
                whole = f"whole_{method}_{len(keys)}"
                self.run_skein(whole)
                self.assertGreaterEqual(self.series(whole)["contacts"].max(), 2)

                def same(out):
                    self.assertEqual(self.digest(out), self.digest(whole))
                    self.assert_same_frames(out, whole, "sticks")
                    self.assert_same_series(out, whole, SEARCH)

                self.assert_layouts_give(whole, same)
                parts = f"{whole}_parts"
                self.run_skein(parts, "--until", "0.007" if "dt" in keys else "0.005")
                self.run_skein(parts, "--until", "0.015", "--lanes", "2")
                self.assertIn("Resuming", self.run_skein(parts).stdout)
                same(parts)


if __name__ == "__main__":
    unittest.main()
