"""Rods that feel a fluid: nothing is lost between both, nothing tells how a run was computed, and a disc on a spring swings as the
fluid lets it."""

import unittest

import numpy

from driver import DriverTest, rods_in_a_fluid

SCENE = """
title = "rods and a fluid"
[time]
duration = 0.4
[fluid]
cells = [32, 24, 20]
spacing = 0.1
density = 2.0
viscosity = 0.02
courant = 0.4
expected_speed = 2.0
""" + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0]) + """
[output]
series = 0.02
checkpoint = 0.1
"""

DISC = """
title = "disc on a spring"
[time]
duration = 20.0
[fluid]
cells = [96, 96, 4]
spacing = 0.0625
lower = [-3.0, -3.0, 0.0]
density = 1.0
viscosity = 0.01
courant = 0.5
expected_speed = 0.65
[constants]
k = { value = 1.5707963267948966, unit = "N/m^2" } # of a circular frequency of 1 rad/s with twice its mass
[[rods]]
name = "disc"
[rods.material]
density = 1.0
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
"""


class CoupledFlow(DriverTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(SCENE)

    def test_momentum_of_fluid_and_rods_is_kept_whatever_rods_weigh(self):
        for density in (1.8, 2.0, 2.5, 20.0, 2000.0):
            self.scene.write_text(SCENE.replace("density = 2.0\nyoungs_modulus", f"density = {density}\nyoungs_modulus"))
            self.run_skein(f"rods{density}")
            series = self.series(f"rods{density}")
            exchanged = max(abs(series[f"fluid_momentum_{axis}kg_ms"]).max() for axis in "xyz")
            self.assertGreater(exchanged, 0.01)
            for axis in "xyz":
                kept = series[f"coupled_momentum_{axis}kg_ms"]
                self.assertLess(abs(kept - kept[0]).max(), 1e-12 * max(exchanged, abs(kept[0])), f"{density}: {axis}")
            self.assertLess(series["max_speedms"].max(), 2.5, density)
            self.assertLess(series["slipms"][2:].max(), 0.2, density)

    def test_the_same_on_any_ranks_threads_and_lanes_and_after_a_stop(self):
        self.run_skein("one")
        for out, layout in {"two": {"ranks": 2}, "three": {"ranks": 3}, "threads": {"threads": 2}}.items():
            self.run_skein(out, **layout)
        self.run_skein("rows", "--set", "fluid.ranks_across=2", ranks=4)
        for lanes in ("4", "2", "1"):
            self.run_skein("lanes" + lanes, "--lanes", lanes)
        steps = int(self.series("one")["step"][5])
        self.run_skein("parts", "--steps", str(steps - 1), ranks=2)
        self.assertIn("Resuming from", self.run_skein("parts", ranks=3).stdout)
        for out in ("two", "three", "rows", "threads", "lanes4", "lanes2", "lanes1", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assertEqual((self.directory / out / "observables.csv").read_bytes(), (self.directory / "one/observables.csv").read_bytes(), out)

    def test_a_disc_as_heavy_as_the_fluid_swings_on_a_spring_as_stokes_found(self):
        """0.877 of the frequency without viscosity by the added mass 1 + 4 / sqrt(pi beta) (Stokes 1851), 0.874 with its images; 16
        cells across (8: 2.4 % lower)."""
        self.scene.write_text(DISC)
        self.run_skein("disc")
        series = self.series("disc")
        time, place = series["times"], series["centre_xm"]
        i = numpy.flatnonzero(place[1:] * place[:-1] < 0)
        zeros = time[i] - place[i] * (time[i + 1] - time[i]) / (place[i + 1] - place[i])
        self.assertGreaterEqual(len(zeros), 5)
        self.assertLess(abs(4 * numpy.pi / (zeros[4] - zeros[0]) / 0.874 - 1), 0.015)


if __name__ == "__main__":
    unittest.main()
