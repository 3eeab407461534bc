"""Power that bodies give a fluid at their surfaces: closed by dissipation and by what is lost there, in obstacles and rods of all surfaces and schemes; the same bits on any layout and
after a stop."""

import unittest

import numpy

from driver import FLUID_OF_RODS, DriverTest, rods_in_a_fluid
from fluid_books_test import stiff_rod

SURFACES = ("markers", "sharp")
SCHEMES = ("rk3", "rk3_projected", "adams_bashforth", "crank_nicolson")


def spinning(surface, scheme, cells=24):
    """A disc that turns slowly in a box with walls, until the flow is steady."""
    return f"""
title = "a disc turns"
[time]
duration = 4.0
[fluid]
cells = [{cells}, {cells}, 1]
spacing = {1 / cells!r}
density = 2.0
viscosity = 0.2
courant = 0.5
scheme = "{scheme}"
along_x = "no_slip"
along_y = "no_slip"
[[obstacle]]
name = "disc"
kind = "cylinder"
surface = "{surface}"
centre = [0.51, 0.48, 0.0]
radius = 0.2
angular_velocity = [0.0, 0.0, 1.0]
[output]
series = 0.1
checkpoint = 1.0
fluid_power = true
"""


RODS = 'title = "power"\n[time]\nduration = 0.2\n' + FLUID_OF_RODS + "largest_slip = 0\n" + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0])
OUTPUT = "[output]\nseries = 0.02\ncheckpoint = 0.04\n"
POWER = "fluid_power = true\n"


class FluidPower(DriverTest):
    def rows(self, out):
        return (self.directory / out / "observables.csv").read_bytes()

    def test_steady_power_is_dissipated_or_lost_at_the_surface(self):
        """It is the couple times the spin, and in slow flow nothing else takes it. A sharp surface loses friction in cut faces, markers next to nothing."""
        for surface in SURFACES:
            for scheme in SCHEMES:
                with self.subTest(surface=surface, scheme=scheme):
                    self.scene.write_text(spinning(surface, scheme))
                    self.run_skein(surface + scheme)
                    last = self.series(surface + scheme)[-1]
                    given, lost, taken = (last[name] for name in ("fluid_power_givenW", "fluid_power_lostW", "fluid_dissipationW"))
                    print(surface, scheme, "given", given, "lost", lost / given, "missing", 1 - (lost + taken) / given)
                    self.assertGreater(given, 0)
                    self.assertLess(abs(given + last["disc_couple_zN_m"]), 1e-9 * given)
                    self.assertLess(abs(given - lost - taken), (1e-5 if surface == "sharp" else 3e-3) * given)
                    self.assertGreater(abs(given - taken), (0.05 if surface == "sharp" else -1) * given)

    def test_rods_give_what_their_audits_take(self):
        """And what the fluid within them gains; the fluid has it, or it is dissipated or lost. After the start at once."""
        for surface in SURFACES:
            self.scene.write_text(stiff_rod(32).replace("series = 0.01\n", "series = 0.005\n" + POWER) + f'[immersion]\nrod_surface = "{surface}"\n')
            self.run_skein(surface)
            series = self.series(surface)
            series = series[numpy.searchsorted(series["times"], 0.1):]

            def until_end(power):
                return numpy.sum(0.5 * (series[power][1:] + series[power][:-1]) * numpy.diff(series["times"]))
            given, lost, taken = map(until_end, ("fluid_power_givenW", "fluid_power_lostW", "fluid_dissipationW"))
            work, translation, rotation, fluid = (series[name][-1] - series[name][0] for name in ("work_fluidJ", "kinetic_translationJ", "kinetic_rotationJ", "fluid_energyJ"))
            print(surface, "given", given, "not by the rod", (given + work - (translation + rotation) / 4) / given, "missing", (given - lost - taken - fluid) / given)
            self.assertLess(abs(given + work - (translation + rotation) / 4), 0.04 * given)
            self.assertLess(abs(given - lost - taken - fluid), 0.04 * given)

    def test_same_bits_on_any_layout_and_after_a_stop(self):
        for surface in SURFACES:
            for text in (RODS + f'[immersion]\nrod_surface = "{surface}"\n' + OUTPUT + POWER, spinning(surface, "crank_nicolson").replace("duration = 4.0", "duration = 0.4").replace("checkpoint = 1.0", "checkpoint = 0.1")):
                kind = f"{surface}{len(text)}"
                self.scene.write_text(text)
                self.run_skein(kind)
                for out, arguments, layout in (("two", (), {"ranks": 2}), ("threads", ("--lanes", "2"), {"threads": 2})):
                    self.run_skein(out + kind, *arguments, **layout)
                    self.assertEqual(self.rows(out + kind), self.rows(kind), out + kind)
                self.run_skein("parts" + kind, "--until", "0.1", ranks=2)
                self.assertIn("Resuming from", self.run_skein("parts" + kind).stdout)
                self.assertEqual(self.rows("parts" + kind), self.rows(kind))

    def test_no_bit_depends_on_it(self):
        for surface in SURFACES:
            scene = RODS + f'[immersion]\nrod_surface = "{surface}"\n' + OUTPUT
            self.scene.write_text(scene)
            self.assertNotRegex(self.plan_text(), r"\n +power ")
            self.run_skein("without" + surface)
            self.scene.write_text(scene + POWER)
            self.assertRegex(self.plan_text(), r"\n +power +of bodies at their surfaces, in each stage")
            self.run_skein("with" + surface)
            self.assertEqual(self.digest("with" + surface), self.digest("without" + surface))
            mine, others = self.series("with" + surface), self.series("without" + surface)
            self.assertEqual(set(mine.dtype.names) - set(others.dtype.names), {"fluid_power_givenW", "fluid_power_lostW"})
            for name in others.dtype.names:
                self.assertTrue(numpy.array_equal(mine[name], others[name]), name)

    def test_scenes_without_use_for_it_are_refused(self):
        dry = RODS.replace(FLUID_OF_RODS + "largest_slip = 0\n", "")
        self.assertNotEqual(dry, RODS)
        for text, words in ((dry + OUTPUT + POWER, "'fluid_power' has no use without rods, bodies or obstacles in a [fluid]"), (RODS + "[output]\n" + POWER, "powers are columns of the time series: set output.series")):
            self.scene.write_text(text)
            self.assertIn(words, self.run_skein("refused", expect=2).stderr)


if __name__ == "__main__":
    unittest.main()
