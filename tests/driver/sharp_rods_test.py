"""Rods with sharp surfaces in a fluid: nothing is lost between both whatever rods weigh, no layout changes a bit, and light discs on springs swing as
the fluid lets them."""

import math
import unittest

from driver import FLUID_OF_RODS, DriverTest, rods_in_a_fluid

SCENE = ('title = "rods and a fluid"\n[time]\nduration = 0.4\n' + FLUID_OF_RODS + "largest_slip = 0\n" + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0])
         + '[immersion]\nrod_surface = "sharp"\n[output]\nseries = 0.02\ncheckpoint = 0.04\n')

DISC = '''
title = "disc on a spring"
[time]
duration = 9.0
[fluid]
cells = [48, 48, 2]
spacing = 0.125
lower = [-3.0, -3.0, 0.0]
density = 1.0
viscosity = 0.01
courant = 0.5
expected_speed = 0.65
largest_slip = 0
[immersion]
rod_surface = "sharp"
[constants]
k = {{ value = {spring!r}, unit = "N/m^2" }}
[[rods]]
name = "disc"
[rods.material]
density = {density}
youngs_modulus = 1000.0
[rods.section]
radius = 0.5
[rods.shape]
length = 0.25
elements = 2
[rods.placement]
origin = [0.1, 0.0, 0.0]
[[load]]
kind = "formula"
force = ["-k*x", "-k*y", "0"]
[output]
series = 0.1
'''


class SharpRods(DriverTest):
    def test_momentum_is_kept_whatever_rods_weigh(self):
        """Beside thin rods, which have markers."""
        for density in (0.02, 1.0, 2.0, 20.0, 2000.0):
            self.scene.write_text(SCENE.replace("density = 2.0\nyoungs_modulus", f"density = {density}\nyoungs_modulus"))
            self.assertEqual(self.plan_text().count("a sharp surface"), 1)
            self.run_skein(f"rods{density}")
            series = self.series(f"rods{density}")
            exchanged = max(abs(series[f"fluid_momentum_{axis}kg_ms"]).max() for axis in "xyz")
            self.assertGreater(exchanged, 0.01)
            for axis in "xyz":
                kept = series[f"coupled_momentum_{axis}kg_ms"]
                self.assertLess(abs(kept - kept[0]).max(), 1e-12 * max(exchanged, abs(kept[0])), f"{density}: {axis}")
            self.assertLess(series["max_speedms"].max(), 2.5, density)

    def test_light_discs_on_springs_swing_with_their_own_inertia(self):
        """Eight cells across. The spring has a circular frequency of 1/s with the disc and its displaced fluid; the boundary layer adds 0.7 to 0.9 times that
        fluid at this viscosity, and amplitudes fall."""
        for density in (0.001, 1.0):
            self.scene.write_text(DISC.format(density=density, spring=(density + 1) * math.pi / 4))
            self.run_skein(f"disc{density}")
            series = self.series(f"disc{density}")
            x, t = series["centre_xm"], series["times"]
            crossing = [t[i] - x[i] * (t[i + 1] - t[i]) / (x[i + 1] - x[i]) for i in range(len(x) - 1) if x[i] * x[i + 1] < 0]
            inertia = ((crossing[1] - crossing[0]) / math.pi) ** 2 * (density + 1) - density - 1
            self.assertLess(abs(inertia - 0.8), 0.15, (density, crossing))
            turns = [abs(x[i]) for i in range(1, len(x) - 1) if (x[i] - x[i - 1]) * (x[i + 1] - x[i]) < 0]
            self.assertLess(turns[1], 0.65 * turns[0], (density, turns))

    def test_same_bits_on_other_ranks_lanes_and_threads_and_after_a_stop(self):
        self.scene.write_text(SCENE.replace("duration = 0.4", "duration = 0.12"))
        self.run_skein("one")
        self.run_skein("rows", "--set", "fluid.ranks_across=2", ranks=4)
        self.run_skein("lanes", "--lanes", "2")
        self.run_skein("threads", "--lanes", "1", threads=2)
        self.run_skein("parts", "--until", "0.05")
        self.run_skein("parts", ranks=2)
        for out in ("rows", "lanes", "threads", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)


if __name__ == "__main__":
    unittest.main()
