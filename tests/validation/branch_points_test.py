"""Critical loads as branch and limit points of paths, against closed forms and independent solutions, at second order."""

import math
import unittest

import numpy

from solved_scenes import SolvedScenes, march, of_circle, of_rectangle, rod, root

HEAD = "[time]\nduration = 1.0\n"


def number(name, unit, value=1.0):
    return f'[constants]\n{name} = {{value = {value}, unit = "{unit}"}}\n'


def least_root(off, low, high):
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (off(middle) > 0) == (off(low) > 0) else (low, middle)
    return 0.5 * (low + high)


class BranchPoints(SolvedScenes):
    def first_branch(self, text, *arguments):
        found = self.places(text, "branch", *arguments)
        self.assertTrue(found, "no branch point")
        return found[0]

    def test_columns(self):
        """Euler's loads with shear and shortening: P (1 - P/(E A) + P/(alpha G A)) = B k^2 of the law "linear"."""
        r = 0.05
        bending, stretching = of_circle(1.0, r)
        for name, ends, k in (("cantilever", 'start = "clamped"', math.pi / 2),
                              ("guided column", 'start = "clamped"\nend = "clamped"\nend_free = "xz"', math.pi),
                              ("sliding clamp", 'start = "clamped"\nend = "clamped"\nend_free = "z"', 2 * math.pi)):
            slender = k * k * bending[0]
            exact = least_root(lambda p: p * (1 - p / stretching[2] + p / stretching[0]) - slender, 0, 2 * slender)
            loads = []
            for n in (10, 20, 40):
                text = HEAD + rod("rod", 1.0, n, 1.0, r, (0, 0, 1), (1, 0, 0), more=ends)
                text += f'[[load]]\nkind = "end_force"\nend = [0, 0, {-0.1 * exact}]\n'
                loads.append(self.first_branch(text, "--along", "load.0.end.2", "--to", -1.2 * exact, "--points", 60))
            error = self.assert_second_order(f"Euler's load, {name}", [-load for load in loads], exact)
            for n, one in zip((10, 20, 40), error):
                self.assertAlmostEqual(-one / ((k / n)**2 / 12), 1, delta=0.2)


if __name__ == "__main__":
    unittest.main()
