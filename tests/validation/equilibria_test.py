"""Equilibria that Newton's method finds, against independent solutions by shooting, at second order, and against the rest of relaxed runs."""

import unittest

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


if __name__ == "__main__":
    unittest.main()
