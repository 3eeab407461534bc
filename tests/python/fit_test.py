"""skein.fit: true numbers lie within the intervals for most seeds of noise, curves of a load, rest shapes, refusals; skein.gradient."""

import pathlib
import tempfile
import unittest

import numpy as np

from package import APPS, skein

YOUNG, CURVATURE = 2e6, 1.5
E, K = "rods.arm.material.youngs_modulus", "rods.arm.shape.rest_curvature.1"
ARM = """
time.duration = 1.0
[[rods]]
name = "arm"
start = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 12, rest_curvature = [0.0, 1.5, 0.0]}
placement.tangent = [1.0, 0.0, 0.0]
[[probe]]
name = "tip"
of = "arm"
[[load]]
kind = "gravity"
"""
PULLED = ARM + """
[[load]]
kind = "end_force"
end = [0.0, 0.0, -2e-3]
"""
FORCE = "load.end_force.end.2"


def shape(scene=ARM, **keys):
    """Places of the nodes at rest."""
    places = skein.equilibrium(scene, threads=1, **keys).positions["arm"][0]
    return {"s": np.linspace(0, 0.2, len(places)), **dict(zip("xyz", places.T))}


def noisy(data, seed, share=0.01):
    """With errors of places of this share of the largest displacement."""
    random, size = np.random.default_rng(seed), share * np.ptp(data["z"])
    return {name: column if name == "s" else column + random.normal(0, size, len(column)) for name, column in data.items()}


class Fits(unittest.TestCase):
    def test_intervals_hold_the_truth(self):
        exact, within = shape(), {E: 0, K: 0}
        for seed in range(20):
            found = skein.fit(ARM, noisy(exact, seed), [E, K], threads=1, **{E: 1e6, K: 0.5})
            for key, truth in ((E, YOUNG), (K, CURVATURE)):
                low, high = found.interval(key)
                within[key] += low <= truth <= high
                self.assertLess(abs(found[key] / truth - 1), 0.3)
        self.assertGreaterEqual(min(within.values()), 17, within)
        self.assertLess(max(within.values()) + min(within.values()), 41)
        self.assertEqual(found.units, {E: "Pa", K: "1/m"})
        self.assertAlmostEqual(found.misfits["places"] / (0.01 * np.ptp(exact["z"])), 1, delta=0.3)

    def test_points_whose_arc_length_is_not_known(self):
        """Points anywhere along the rod, in space and as an image of its plane has them: errors along the rod count for nothing."""
        straight = ARM.replace("rest_curvature = [0.0, 1.5, 0.0]", "start_curvature = [0.0, 0.0, 0.0]")
        exact = shape(straight)
        size, along = 0.01 * np.ptp(exact["z"]), exact["s"]
        for names, seeds in (("xyz", 20), ("xz", 20)):
            within = 0
            for seed in range(seeds):
                random = np.random.default_rng(seed)
                s = random.uniform(0, 0.2, 30)
                found = skein.fit(straight, {name: np.interp(s, along, exact[name]) + random.normal(0, size, 30) for name in names}, E, threads=1, **{E: 1e6})
                low, high = found.interval(E)
                within += low <= YOUNG <= high
                self.assertLess(high - low, 0.07 * YOUNG)
                self.assertAlmostEqual(found.misfits["places"] / size, 1, delta=0.5)
            self.assertTrue(17 <= within, (names, within))
            self.assertEqual(found.figures["values"], 30 * (len(names) - 1))
        with self.assertRaisesRegex(skein.RunFailed, "without s two or three"):
            skein.fit(straight, {"s": along, "x": exact["x"]}, E)

    def test_exact_data_give_the_numbers(self):
        found = skein.fit(ARM, shape(), [E, K], threads=1, **{E: 1e6, K: 0.5})
        self.assertAlmostEqual(found[E] / YOUNG, 1, delta=1e-6)
        self.assertAlmostEqual(found[K] / CURVATURE, 1, delta=1e-6)
        self.assertIn("youngs_modulus = 2e+06", repr(found))

    def test_a_curve_of_a_force(self):
        forces = np.linspace(-1e-3, -8e-3, 7)
        tips = np.array([skein.equilibrium(PULLED, threads=1, **{FORCE: force})["tip_z"] for force in forces])
        data = {f"{FORCE}[N]": forces, "tip_z[m]": tips + np.random.default_rng(1).normal(0, 1e-4, 7)}
        found = skein.fit(PULLED, data, E, threads=1, **{E: 3e6})
        low, high = found.interval(E)
        self.assertTrue(low <= YOUNG <= high, found)
        self.assertLess(high - low, 0.05 * YOUNG)
        self.assertEqual(found.figures["experiments"], 7)

    def test_kinds_of_data_have_errors_of_their_own(self):
        """Coarse axial energies beside good places: the interval is that of places alone."""
        data, random = noisy(shape(PULLED), 3), np.random.default_rng(3)
        alone = skein.fit(PULLED, data, E, threads=1, **{E: 3e6})
        bend = skein.equilibrium(PULLED, threads=1)["elastic_bend"]
        both = skein.fit(PULLED, {**data, "elastic_bend": bend * (1 + random.normal(0, 0.5, len(data["s"])))}, E, threads=1, **{E: 3e6})
        self.assertAlmostEqual(both.half_widths[E] / alone.half_widths[E], 1, delta=0.2)
        self.assertEqual(set(both.misfits), {"places", "elastic_bend"})

    def test_what_the_data_do_not_determine(self):
        straight = ARM.replace("rest_curvature = [0.0, 1.5, 0.0]", "start_curvature = [0.0, 0.0, 0.0]")
        density = "rods.arm.material.density"
        with self.assertRaisesRegex(skein.RunFailed, "do not determine") as failed:
            skein.fit(straight, shape(straight), [E, density], threads=1)
        self.assertEqual(failed.exception.code, 2)
        self.assertIn(E, str(failed.exception))
        self.assertIn(density, str(failed.exception))
        with self.assertRaisesRegex(skein.RunFailed, "do not depend on rods.arm.material.rotary_inertia_scale"):
            skein.fit(PULLED, shape(PULLED), [E, "rods.arm.material.rotary_inertia_scale"], threads=1)


# A rest curvature by values along the rod, under its weight both ways up.
BENT = ARM.replace("elements = 12, rest_curvature = [0.0, 1.5, 0.0]", 'elements = 40, rest_curvature_formula = ["0", "bend(s)", "0"]') + """
acceleration = [0.0, 0.0, -9.81]
[[table]]
name = "bend"
at = [0.0, 0.05, 0.1, 0.15, 0.2]
at_unit = "m"
value = [2.0, 5.0, 3.0, -2.0, 1.0]
unit = "1/m"
"""
VALUES = [f"table.bend.value.{k}" for k in range(5)]
TRUE = {E: YOUNG, **dict(zip(VALUES, (2.0, 5.0, 3.0, -2.0, 1.0)))}
GRAVITY = "load.gravity.acceleration.2"

WIRE = (APPS / "statics/straight_wire.toml").read_text()


class Along(unittest.TestCase):
    """Numbers along a rod."""

    def test_intervals_hold_the_truth_for_100_seeds(self):
        both = {name: [] for name in (GRAVITY, "s", "x", "y", "z")}
        for gravity in (-9.81, 9.81):
            for name, column in {GRAVITY: np.full(41, gravity), **shape(BENT, **{GRAVITY: gravity})}.items():
                both[name] = np.append(both[name], column)
        within, size = dict.fromkeys(TRUE, 0), 0.01 * np.ptp(both["z"])
        for seed in range(1, 101):
            random = np.random.default_rng(seed)
            data = {name: column if name in ("s", GRAVITY) else column + random.normal(0, size, 82) for name, column in both.items()}
            found = skein.fit(BENT, data, list(TRUE), threads=1, **{E: 1e6, "table.bend.value": [1.0] * 5})
            for key, truth in TRUE.items():
                low, high = found.interval(key)
                within[key] += low <= truth <= high
        for key, count in within.items():
            self.assertTrue(90 <= count <= 99, (key, count))

    def test_a_rest_shape_that_is_straight_under_its_weight(self):
        """The rest curvature is w (L - s)^2/2EI: each cell balances the weight beyond it."""
        s, keys = np.linspace(0, 1, 161), [f"table.bend.value.{k}" for k in range(41)]
        found = skein.fit(WIRE, {"s": s, "x": s, "y": 0 * s, "z": 0 * s}, keys, threads=1)
        bend = [found[key] for key in keys]
        rest = skein.equilibrium(WIRE, threads=1, **{"table.bend.value": bend}).positions["wire"][0]
        self.assertLess(np.max(np.linalg.norm(rest - np.stack([s, 0 * s, 0 * s], axis=1), axis=1)), 1e-6)
        weight, stiffness = 7850 * 9.81 * np.pi * 5e-4**2, 2e11 * np.pi / 4 * 5e-4**4
        inner = slice(2, 38)  # the end of the table acts on few cells
        np.testing.assert_allclose(np.array(bend)[inner], -0.5 * weight * (1 - np.arange(41) / 40)[inner] ** 2 / stiffness, atol=0.01)

    def test_what_is_not_determined_may_stay(self):
        """With 20 elements every other value acts between two cells, and on none."""
        wire, keys = WIRE.replace("elements = 160", "elements = 20"), [f"table.bend.value.{k}" for k in range(41)]
        s = np.linspace(0, 1, 21)
        data = {"s": s, "x": s, "y": 0 * s, "z": 0 * s}
        with self.assertRaisesRegex(skein.RunFailed, "do not depend on table.bend.value.0: .*--keep-undetermined") as failed:
            skein.fit(wire, data, keys, threads=1)
        self.assertEqual(failed.exception.code, 2)
        first = [-0.5 * (k % 2) for k in range(41)]
        found = skein.fit(wire, data, keys, keep_undetermined=True, threads=1, **{"table.bend.value": first})
        self.assertEqual([found[key] for key in keys[1::2]], [-0.5] * 20)
        self.assertTrue(all(np.isinf(found.half_widths[key]) for key in keys[1::2]))
        self.assertTrue(all(np.isfinite(found.half_widths[key]) for key in keys[2:-2:2]))
        self.assertLess(found.misfits["places"], 1e-4)


class Gradients(unittest.TestCase):
    def test_a_cantilever_has_the_slopes_of_its_closed_form(self):
        """Small deflections: F L^3/3EI, and the angle of each part of the rest curvature times the way to the tip."""
        stiffness, force, load = 2e11 * np.pi / 4 * 5e-4**4, 1e-5, '[[load]]\nkind = "end_force"\nend = [0.0, 0.0, 1e-5]\n'
        tip = {"rods.wire.material.youngs_modulus": -force / (3 * stiffness) / 2e11, "load.0.end.2": 1 / (3 * stiffness), "rods.wire.shape.length": force / stiffness,
               "table.bend.value.20": -0.025 * 0.5}
        wire = WIRE.replace('[[load]]\nkind = "gravity"\n', load)
        for of in ((), "tip_z"):
            errors = []
            for elements in (40, 80, 160):
                scene = wire.replace("elements = 160", f"elements = {elements}")
                found = skein.gradient(scene, list(tip), of=of, threads=1)
                self.assertEqual(found.figures["adjoint_solutions"], 1 if of else 0)
                errors.append([abs(found[key]["tip_z"] / slope - 1) for key, slope in tip.items()])
            for coarse, fine in zip(errors, errors[1:]):
                orders = np.log2(np.array(coarse[:3]) / fine[:3])
                self.assertTrue(np.all(np.abs(orders - 2) < 0.1), (of, errors))
            self.assertLess(max(errors[-1]), 1e-4)

    def test_slopes_by_one_and_by_many(self):
        keys = [E, *VALUES]
        every, adjoint = skein.gradient(BENT, keys, threads=1), skein.gradient(BENT, keys, of=["tip_z", "elastic_bend"], threads=1)
        self.assertEqual(set(adjoint.values), {"tip_z", "elastic_bend"})
        self.assertEqual(adjoint.units["tip_z"], "m")
        self.assertEqual(adjoint.figures["adjoint_solutions"], 2)
        self.assertIn("max_speed", every.values)
        for key in keys:
            for name, slope in adjoint[key].items():
                self.assertLess(abs(slope - every[key][name]), 2e-6 * abs(slope), (key, name))
        h = 1e-3 * YOUNG
        tip = {k: skein.equilibrium(BENT, threads=1, **{E: YOUNG + k * h})["tip_z"] for k in (-2, -1, 1, 2)}
        slope = (8 * (tip[1] - tip[-1]) - (tip[2] - tip[-2])) / (12 * h)
        self.assertLess(abs(adjoint[E]["tip_z"] - slope), 1e-6 * abs(slope))
        with self.assertRaisesRegex(skein.RunFailed, "is no observable of the scene"):
            skein.gradient(BENT, E, of="tipz", threads=1)


class Refusals(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "data.csv"

    def refused(self, data, words, numbers=(E,), **keys):
        if isinstance(data, str):
            self.file.write_text(data)
            data = self.file
        with self.assertRaisesRegex(skein.RunFailed, words) as failed:
            skein.fit(keys.pop("scene", PULLED), data, numbers, threads=1, **keys)
        self.assertEqual(failed.exception.code, 2, failed.exception)

    def test_of_data(self):
        for data, words in (("tip_z\n0.1\n", "1 measured values are too few for 1 numbers"), ("tipz\n0.1\n0.2\n", "no observable of the scene.*did you mean 'tip_z'"),
                            ("load.end_forse.end.2,tip_z\n0,0.1\n1,0.2\n", "is no number of"), ("no table at all\nnor here\n", "is not a number; data are a table"),
                            ("", "the data have no rows"), ("tip_z\n", "the data have no rows"), ("s,x,y\n0,0,0\n", "need the columns s, x, y and z"),
                            ("tip_z,tip_z\n1,2\n3,4\n", "two columns 'tip_z'"), ("tip_z[mm]\n1\n3\n", "is in mm and has to be in m"), ("s,x,y,z\n0.3,0,0,0\n", "is no place of the rod"),
                            ("tip_z,tip_x\n1\n", "expected 2 numbers"), (f"{E},tip_z\n1e6,0.1\n2e6,0.2\n", "is a column of the data"), (f"{FORCE},tip_z\nnan,0.1\n0,0.2\n", "row 1 of the data has no")):
            with self.subTest(data=data):
                self.refused(data, words)

    def test_of_numbers(self):
        data = {"tip_z": [0.0, 0.1, 0.2]}
        for number, words in (("rods.arm.shape.elements", "is a whole number"), ("rods.arm.name", "is no number"), ("rods.leg.section.radius", "is no number")):
            self.refused(data, words, [number])
        self.refused(data, "is given twice", [E, E])
        self.refused(shape(), "there are no rods 'leg'", rods="leg")
        self.refused(data, "no rods or bodies|no bodies", scene="time.duration = 1.0\n")


if __name__ == "__main__":
    unittest.main()
