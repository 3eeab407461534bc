"""Equilibria that Newton's method finds, against independent solutions by shooting, at second order, and against the rest of relaxed runs."""

import unittest

import numpy

from solved_scenes import SolvedScenes, clamped_tip, of_circle, of_rectangle, rod

TIP = '[[probe]]\nname = "tip"\nof = "rod"\n'


def clamped(n, force, length, youngs_modulus, section, more="", **placement):
    text = "[time]\nduration = 1.0\n[output]\nseries = 1.0\n"
    text += rod("rod", length, n, youngs_modulus, section, more='start = "clamped"', **placement)
    return text + f'[[load]]\nkind = "end_force"\nend = {list(force)}\n' + TIP + more


class Equilibria(SolvedScenes):
    def test_cantilever(self):
        """Tip load of 1 and 10 E I/L^2."""
        length, E, r = 0.5, 2e6, 5e-3
        bending, stretching = of_circle(E, r)
        for share in (1, 10):
            force = (0, 0, -share * bending[0] / length**2)
            exact = clamped_tip(length, bending, stretching, ((0, 0, 1), (0, -1, 0), (1, 0, 0)), force)
            tips = [self.at_rest(clamped(n, force, length, E, r)) for n in (10, 20, 40)]
            for name, value in (("x", exact[0]), ("z", exact[2])):
                self.assert_second_order(f"cantilever, {share} EI/L^2, {name}", [tip[f"tip_{name}"] for tip in tips], value, length)

    def test_princeton_beam(self):
        """A flat bar that bends about both axes and twists."""
        length, E, G, force, half = 0.508, 7.17e10, 2.7e10, (0, 0, -13.345), 0.7071067811865476
        bending, stretching = of_rectangle(E, G, 2 * 6.3848e-3, 2 * 1.6012e-3, 0.8333)
        exact = clamped_tip(length, bending, stretching, ((0, half, half), (0, -half, half), (1, 0, 0)), force)
        section = 'kind = "rectangular", radius = 6.3848e-3, radius_2 = 1.6012e-3, shear_factors = [0.8333, 0.8333]'
        tips = [self.at_rest(clamped(n, force, length, E, section, normal=(0, half, half), shear_modulus=G)) for n in (10, 20, 40)]
        for name, value in (("y", exact[1]), ("z", exact[2])):
            self.assert_second_order(f"Princeton beam, {name}", [tip[f"tip_{name}"] for tip in tips], value, length)

    def test_an_end_that_turns_far(self):
        """A clamp that turns by more than half a turn: energy C angle^2/(2 L) of the twist, in as many turns."""
        bending, _ = of_circle(1e9, 0.01, 4e8)
        for angle in (1.0, 3.0, 5.6, 8.0, 20.0):
            text = '[time]\nduration = 1.0\n[output]\nseries = 1.0\n'
            text += rod("rod", 1.0, 20, 1e9, 0.01, more='start = "clamped"\nend = "clamped"\nend_motion = {times = [0, 1], '
                        f'translation = [[0, 0, 0], [0, 0, 0]], rotation = [[0, 0, 0], [{angle}, 0, 0]]}}', shear_modulus=4e8)
            self.assertAlmostEqual(self.at_rest(text)["elastic_twist"] / (bending[2] * angle**2 / 2), 1, delta=1e-9)

    def assert_relaxed_run_ends_there(self, name, bodies, length):
        """Every node of the last checkpoint of a run with time.relax to 1e-9 lengths."""
        self.solve("equilibrium", "rest", "[time]\nduration = 1.0\n" + bodies)
        self.scene.write_text("[time]\nduration = 400000\nrelax = true\nrelax_tolerance = 1e-14\n" + bodies)
        self.run_alone("relaxed")
        rest, relaxed = self.state("rest"), self.state("relaxed")
        self.assertEqual(rest.keys(), relaxed.keys())
        for group in rest:
            off = numpy.abs(rest[group]["state"][..., :3] - relaxed[group]["state"][..., :3]).max() / length
            print(f"  {name}, '{group}': {off:.1e} of the length from the rest of a relaxed run")
            self.assertLess(off, 1e-9, group)

    def test_relaxed_runs_end_there(self):
        weight = '[[load]]\nkind = "gravity"\nacceleration = [0, 0, -3.0]\n'
        self.assert_relaxed_run_ends_there("cantilever", rod("rod", 0.5, 20, 2e6, 5e-3, more='start = "clamped"') + weight, 0.5)
        arm = rod("arm", 0.5, 12, 1e7, 0.01, more='start = "clamped"') + rod("hand", 0.4, 10, 1e7, 0.01)
        arm = arm.rstrip().removesuffix("}") + ', origin = [0.5, 0, 0]}\n'
        joint = '[[joint]]\nkind = "hinge"\nbetween = ["arm", "hand"]\naxis = [0, 1, 0]\nstiffness = 1e4\ntorsional_stiffness = 10.0\nspring = 0.5\n'
        self.assert_relaxed_run_ends_there("joined", arm + joint + weight, 0.5)
        corner = joint.replace("hinge", "fixed").split("axis")[0]
        self.assert_relaxed_run_ends_there("one of two", arm + corner + weight, 0.5)


if __name__ == "__main__":
    unittest.main()
