"""Probes of a fluid: velocity and pressure of vortices with a closed form, linear flow up to its walls, no layout changes a bit, and places that
the fluid does not have are refused."""

import unittest

import numpy

from driver import BALL_IN_IT, FLUID_IN_A_BOX, DriverTest

PLACES = {f"p{i}": (0.41 + 2.39 * i % (2 * numpy.pi), 1.07 + 3.77 * i % (2 * numpy.pi), 0.1 * i) for i in range(16)}
PLACES["beyond"] = (0.41 + 2 * numpy.pi, 1.07 - 2 * numpy.pi, 5.0)
NU = 0.05


def probes(places):
    return "".join(f'[[fluid_probe]]\nname = "{name}"\nat = {list(map(float, at))!r}\n' for name, at in places.items())


def vortices(cells):
    """Vortices of Taylor and Green in two dimensions."""
    return f"""
title = "probes in vortices"
[constants]
k = {{value = 1.0, unit = "1/m"}}
U = {{value = 1.0, unit = "m/s"}}
[time]
duration = 2.0
[fluid]
cells = [{cells}, {cells}, 1]
spacing = {2 * numpy.pi / cells!r}
density = 3.0
viscosity = {3 * NU}
velocity_formula = ["-U * cos(k*x) * sin(k*y)", "U * sin(k*x) * cos(k*y)", "0 * U"]
courant = 0.4
[output]
series = 0.5
""" + probes(PLACES)


COUETTE = """
title = "probes between walls"
[constants]
S = {value = 2.0, unit = "1/s"}
[time]
duration = 0.1
[fluid]
cells = [4, 8, 4]
spacing = 0.125
density = 1.0
viscosity = 0.1
along_y = "no_slip"
upper_wall_velocity = [2.0, 0.0, 0.0]
velocity_formula = ["S * y", "0 * S * y", "0 * S * y"]
[output]
series = 0.05
"""
WALLED = {"floor": (0.2, 0.0, 0.2), "near": (0.2, 0.01, 0.2), "middle": (0.4, 0.437, 0.01), "roof": (0.0, 1.0, 0.3)}
BALL = 'title = "probes beside a ball"\n[time]\nduration = 0.4\n' + FLUID_IN_A_BOX + """
velocity_formula = ["U * sin(k*y) * (1 + 0.2 * cos(2*k*z))", "0.3 * U * sin(2 * k * x / 2.4)", "0 * U"]
""" + BALL_IN_IT + "[output]\nseries = 0.05\ncheckpoint = 0.2\n"
ROUND_IT = {"left": (0.6, 0.03, 0.41), "top": (2.0, 0.97, 1.59), "seam": (2.9, -0.4, 0.801)}


class FluidProbes(DriverTest):
    def errors(self, cells):
        """Errors of velocity and of differences of pressure, over the largest velocity and pressure: square root of the mean square of all places."""
        self.scene.write_text(vortices(cells))
        self.run_skein(f"out{cells}")
        series = self.series(f"out{cells}")
        decay = numpy.exp(-2 * NU * series["times"])
        velocity, pressure = [], {}
        for name, (x, y, _) in PLACES.items():
            for c, exact in zip("xy", (-numpy.cos(x) * numpy.sin(y), numpy.sin(x) * numpy.cos(y))):
                velocity.append(series[f"{name}_velocity_{c}ms"] - exact * decay)
            self.assertLess(abs(series[f"{name}_velocity_zms"]).max(), 1e-15)
            pressure[name] = series[f"{name}_pressurePa"] + 3.0 / 4 * (numpy.cos(2 * x) + numpy.cos(2 * y)) * decay**2
        self.assertLess(abs(series["p0_velocity_xms"] - series["beyond_velocity_xms"]).max(), 1e-12, "a period further")
        return tuple(numpy.sqrt(numpy.mean(numpy.square(errors))) for errors in (velocity, [(pressure["p0"] - pressure[f"p{i}"])[1:] / 1.5 for i in range(1, 16)]))

    def test_vortices_have_their_velocity_and_pressure(self):
        coarse, fine = self.errors(32), self.errors(64)
        for what, was, now in zip(("velocity", "pressure"), coarse, fine):
            self.assertLess(now, 0.01, what)
            self.assertGreater(was / now, 3.4, f"{what}: second order")

    def test_linear_flow_is_exact_up_to_the_walls(self):
        self.scene.write_text(COUETTE + probes(WALLED))
        self.run_skein("out")
        series = self.series("out")
        for name, (_, y, _) in WALLED.items():
            self.assertLess(abs(series[f"{name}_velocity_xms"] - 2 * y).max(), 1e-12, name)

    def test_same_bits_on_any_ranks_and_after_a_stop(self):
        self.scene.write_text(BALL + probes(ROUND_IT))
        self.assertIn("'seam', velocity and pressure at [2.9, -0.4, 0.801] m", self.plan_text())
        self.run_skein("one")
        series = self.series("one")
        self.assertGreater(numpy.ptp(series["seam_velocity_xms"]), 1e-3)
        self.assertGreater(numpy.ptp(series["seam_pressurePa"]), 1e-3)
        self.run_skein("three", ranks=3)
        self.run_skein("rows", "--set", "fluid.ranks_across=2", ranks=4)
        self.run_skein("parts", "--until", "0.2", ranks=2)
        self.run_skein("parts")
        for out in ("three", "rows", "parts"):
            self.assertEqual((self.directory / out / "observables.csv").read_bytes(), (self.directory / "one/observables.csv").read_bytes(), out)

    def test_probes_change_no_bit_of_the_fluid(self):
        self.scene.write_text(BALL)
        self.run_skein("without")
        self.scene.write_text(BALL + probes(ROUND_IT))
        self.run_skein("with")
        self.assertEqual(self.digest("with"), self.digest("without"))

    def test_faults_name_key_and_cure(self):
        for text, words in {
            BALL + probes({"up": (1.0, 0.0, 1.7)}): "this place is outside of the fluid, which reaches from [0.5, -1, 0] to [2.9, 1, 1.6] m",
            BALL + 2 * probes({"two": (1.0, 0.0, 1.0)}): "two probes of the fluid are named 'two'",
            BALL + probes({"a b": (1.0, 0.0, 1.0)}): "'a b' cannot name columns: use letters, digits, _ and -",
            BALL.replace("series = 0.05", "fields = 0.2") + probes(ROUND_IT): "probes are columns of the time series: set output.series [s]",
        }.items():
            with self.subTest(words=words):
                self.scene.write_text(text)
                self.assertIn(words, self.skein_says("check", self.scene, expect=2).stderr)


if __name__ == "__main__":
    unittest.main()
