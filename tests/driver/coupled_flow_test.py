"""Rods that feel a fluid: nothing is lost between both, nothing tells how a run was computed, and a disc on a spring swings as the
fluid lets it."""

import math
import pathlib
import re
import subprocess
import sys
import unittest

import h5py
import numpy

from driver import FLUID_OF_RODS, SKEIN, DriverTest, disc_on_a_spring, rods_in_a_fluid

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"

SCENE = """
title = "rods and a fluid"
[time]
duration = 0.4
""" + FLUID_OF_RODS + """largest_slip = 0 # few steps: exchange_test.py lets slips shorten them
""" + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0]) + """
[output]
series = 0.02
checkpoint = 0.1
"""

PENALTY = "\n[immersion]\nforcing = 'penalty'\npenalty_stiffness = 2000.0\npenalty_damping = 20.0\ninner_inertia = false\n"
THIN = SCENE.replace("radius = 0.3", "radius = 0.12").replace("radius_2 = 0.2", "radius_2 = 0.1")  # markers outweigh it
HEAVIER = "\n[immersion]\ninner_inertia = false\n"
FOLLOWS = (SCENE.replace("courant", "along_x = 'free_slip'\nfollows_rods = true\ncourant")
           .replace("velocity = [0.0, 0.0, -1.0]", "velocity = [1.0, 0.0, -1.0]").replace("[[2.5, 0.4, 1.0], [2.5, 1.8, 1.0]]", "[[1.5, 0.4, 1.0], [1.5, 1.8, 1.0]]")) + "fields = 0.1\n"

SINKING = """
title = "a stiff rod sinks"
[time]
duration = 1.5
[fluid]
cells = [24, 24, 24]
spacing = 0.08333333333333333
density = 1.0
viscosity = 0.001
courant = 0.8
expected_speed = 1.0
largest_slip = 0
[[rods]]
name = "rod"
[rods.material]
density = 1.5
youngs_modulus = 1e4
[rods.section]
radius = 0.125
[rods.shape]
length = 1.0
elements = 16
[rods.placement]
origin = [0.5, 1.0, 1.4]
tangent = [1.0, 0.0, 0.0]
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -1.0]
[output]
series = 0.05
"""

# A rod that a stream carries out.
CARRIED = """
title = "a rod in a stream"
[time]
duration = 1.5
[fluid]
cells = [24, 12, 12]
spacing = 0.1
density = 1.0
viscosity = 0.01
along_x = "through"
along_y = "free_slip"
along_z = "free_slip"
inflow = [1.0, 0.0, 0.0]
courant = 0.8
expected_speed = 2.0
largest_slip = 0
[[rods]]
name = "rod"
[rods.material]
density = 1.5
youngs_modulus = 1e3
[rods.section]
radius = 0.12
[rods.shape]
length = 0.6
elements = 6
velocity = [1.0, 0.0, 0.0]
[rods.placement]
origin = [1.0, 0.6, 0.6]
tangent = [1.0, 0.0, 0.0]
[output]
series = 0.05
"""


class CoupledFlow(DriverTest):
    def setUp(self):
        super().setUp()
        self.scene.write_text(SCENE)

    def test_momentum_of_fluid_and_rods_is_kept_whatever_rods_weigh(self):
        for density in (0.4, 1.0, 1.8, 2.0, 2.5, 20.0, 2000.0):
            self.scene.write_text(SCENE.replace("density = 2.0\nyoungs_modulus", f"density = {density}\nyoungs_modulus"))
            self.run_skein(f"rods{density}")
            series = self.assert_fluid_and_rods_keep_momentum(f"rods{density}")
            self.assertLess(series["max_speedms"].max(), 2.5, density)
            self.assertLess(series["slipms"][2:].max(), 0.2, density)

    def test_momentum_is_kept_by_many_sweeps_by_springs_and_by_rods_that_bear_the_fluid_within(self):
        for name, scene in {"sweeps": THIN + "\n[immersion]\nsweeps = 8\n", "springs": SCENE + PENALTY, "heavier": SCENE + HEAVIER}.items():
            self.scene.write_text(scene)
            self.run_skein(name)
            series = self.series(name)
            for axis in "xyz":
                kept = series[f"coupled_momentum_{axis}kg_ms"]
                self.assertLess(abs(kept - kept[0]).max(), 1e-12, f"{name}: {axis}")
            self.assertGreater(abs(series["fluid_momentum_xkg_ms"]).max(), 0.01)
            self.assertLess(series["max_speedms"].max(), 2.5, name)

    def test_any_number_of_sweeps_is_stable(self):
        """What is owed to a rod used to come back too late with more than three: 20 had 450 times the energy of stretch, and finer grids went on to break."""
        self.scene.write_text(SINKING)
        stretch, way = {}, {}
        for sweeps in (2, 3, 10, 20):
            self.run_skein(f"sweeps{sweeps}", "--set", f"immersion.sweeps={sweeps}")
            series = self.series(f"sweeps{sweeps}")
            stretch[sweeps], way[sweeps] = series["elastic_stretchJ"].max(), series["centre_zm"][-1] - series["centre_zm"][0]
        for sweeps in (10, 20):
            self.assertLess(stretch[sweeps], 3 * max(stretch[2], stretch[3]), stretch)
            self.assertLess(abs(way[sweeps] - way[3]), 0.01 * abs(way[3]), way)

    def test_a_rod_that_leaves_the_fluid_ends_the_run_and_what_the_message_says_holds(self):
        self.scene.write_text(CARRIED)
        told = self.run_skein("leaves", expect=4).stderr
        for words in ("rod 0 of 'rod': element 5 has left the fluid through its upper face across x (\"through\", x = 2.4 m) by t = ", "more cells along x"):
            self.assertIn(words, told)
        self.assertNotIn("likely cause", told)
        self.assertNotIn("follows_rods", told)
        end = re.search(r"time.duration = ([0-9.]+)", told).group(1)
        self.run_skein("shorter", "--set", f"time.duration={end}")
        self.run_skein("longer", "--set", "fluid.cells=[36,12,12]")
        self.run_skein("one_way", "--set", "immersion.coupling='one_way'")
        two = self.run_skein("two", "--set", "time.duration=1.4", ranks=2, expect=4).stderr
        self.assertIn(re.search("rod 0 of .* s:", told).group(0), two)
        self.scene.write_text(CARRIED.replace("through", "free_slip").replace("inflow = [1.0, 0.0, 0.0]\n", "").replace("density = 1.5", "density = 20.0"))
        self.assertIn("fluid.follows_rods = true", self.run_skein("walls", expect=4).stderr)
        self.run_skein("follows", "--set", "fluid.follows_rods=true")

    def test_two_dimensions_are_one_cell_deep(self):
        """Forces by depth and motion of plates that span the box, thick and thin: one cell of depth used to put both sides of a plate on one sheet."""
        def scene(source, depth, spacing, more):
            text = (APPS / source).read_text()
            width = 0.5 * spacing * depth
            for before, after in more + [(r"cells = \[(\d+), (\d+), 1\]", rf"cells = [\1, \2, {depth}]"), (r"radius_2 = [0-9.]+", f"radius_2 = {width!r}"),
                                         (r"radius_2_formula = .*", f'radius_2_formula = "{width!r}"'), (r"(origin = \[[0-9.]+, [0-9.]+), [0-9.]+\]", rf"\1, {width!r}]"),
                                         (r"include = \[\"", f'include = ["{APPS}/school/'), (r"(?s)\[\[fluid_output.*", "")]:
                text = re.sub(before, after, text)
            self.scene.write_text(text)

        coarse, fine = 0.41 / 42, 0.025
        plate = [(r"\[512, 84, 1\]", "[256, 42, 1]"), (r"spacing = .*", f"spacing = {coarse!r}"), (r"duration = .*", "duration = 0.1\ndt = 2e-5")]
        swimmer = [(r"\[320, 160, 1\]", "[160, 80, 1]"), (r"spacing = .*", f"spacing = {fine!r}"), (r"rotary_inertia_for_dt.*", ""), (r"duration = .*", "duration = 0.02\ndt = 5e-6")]
        for name, source, spacing, more in (("thick", "flow/elastic_splitter.toml", coarse, plate), ("thin", "flow/elastic_splitter.toml", coarse, plate + [("radius = 0.01\n", "radius = 0.005\n")]),
                                                  ("swimmer", "school/plane_swimmer.toml", fine, swimmer)):
            series = {}
            for depth in (1, 2, 4):
                scene(source, depth, spacing, more)
                out = f"{name}{depth}"
                self.run_skein(out, "--set", "output.series=0.01", "--set", "output.trajectory=0")
                series[depth] = self.series(out)
            one = series[1]
            self.assertGreater(one["elastic_bendJ"].max(), 0, name)
            forces = [key for key in one.dtype.names if re.search("_force_[xy]N", key)]
            most = max(abs(one[key]).max() for key in forces)
            for depth in (2, 4):
                for key in ("centre_xm", "centre_ym", "max_speedms", "fluid_max_speedms"):
                    self.assertLess(abs(series[depth][key] - one[key]).max(), 1e-11 if "speed" in key else 1e-12, f"{name} {depth}: {key}")
                for key in forces if name != "swimmer" else []: # which has hardly begun
                    self.assertLess(abs(series[depth][key] / depth - one[key]).max(), 1e-12 * most, f"{name} {depth}: {key}")

    def test_hard_springs_and_hard_dampers_are_one_sweep(self):
        for name, keys in {"sweep": "sweeps = 1\n", "dampers": "forcing = 'penalty'\npenalty_damping = 1e9\n", "springs": "forcing = 'penalty'\npenalty_stiffness = 1e12\n"}.items():
            self.scene.write_text(SCENE + "\n[immersion]\n" + keys)
            self.run_skein(name)
        sweep = self.series("sweep")
        for hard in ("dampers", "springs"):
            series = self.series(hard)
            for name in ("centre_xm", "centre_zm", "elastic_bendJ", "fluid_energyJ", "slipms"):
                self.assertLess(abs(series[name] - sweep[name]).max(), 1e-6 * abs(sweep[name]).max(), f"{hard}: {name}")

    def test_springs_hold_whatever_the_step(self):
        """Of the stiffness of published swimmers; springs that saw the fluid before it was pushed used to grow by a tenth in a step."""
        self.scene = APPS / "school/fine_swimmer.toml"
        springs = ["--set", "immersion.forcing='penalty'", "--set", "immersion.penalty_stiffness=32000", "--set", "immersion.penalty_damping=32"]
        for inner in ("true", "false"):
            for speed in (5, 40):
                out = f"springs_{inner}_{speed}"
                self.run_skein(out, *springs, "--set", "fluid.spacing=0.025", "--set", f"fluid.expected_speed={speed}", "--set", f"immersion.inner_inertia={inner}",
                               "--set", "output.series=0.01", "--until", "0.2")
                series = self.series(out)
                self.assertGreater(series["fluid_max_speedms"].max(), 0.05, out)
                self.assertLess(series["fluid_max_speedms"].max(), 0.5, out)  # 0.35 with sweeps
                self.assertLess(series["slipms"].max(), 0.03, out)
            long, short = (self.series(f"springs_{inner}_{speed}") for speed in (5, 40))
            for name in ("fluid_energyJ", "elastic_bendJ"):
                self.assertLess(abs(long[name] - short[name]).max(), 0.1 * short[name].max(), f"{inner}: {name}")

    def test_threads_on_one_line_of_markers_turn_alike_whatever_they_weigh(self):
        """With more elements than markers too. Those up to 1.1 times as heavy as the fluid, and those of more elements, used to shake."""
        thread = ["--set", "fluid.spacing=0.08", "--set", "fluid.cells=[24,24,16]", "--set", "fluid.viscosity=1.0", "--set", "rods.filament.section.radius=0.06",
                  "--set", "time.duration=1.0", "--set", "immersion.retraction=0.4"]
        self.scene.write_text((APPS / "flow/free_filament_in_shear.toml").read_text())
        speeds = {}
        for density in (0.5, 1.0, 1.1, 10.0):
            for elements in (12, 48):
                out = f"thread{density}_{elements}"
                self.run_skein(out, *thread, "--set", f"rods.filament.material.density={density}", "--set", f"rods.filament.shape.elements={elements}")
                series = self.series(out)
                self.assertLess(series["max_speedms"].max(), 0.4, out)  # 0.35 at its ends where it is let go
                speeds[out] = series["max_speedms"][-1]
        self.assertLess(max(speeds.values()), 1.1 * min(speeds.values()), speeds)

    def test_a_light_rod_in_a_stream_holds_in_short_steps(self):
        """With 0.3 of the fluid's density and as much weight upwards. It used to shake where what added inertia takes came back by a share of each step, however short."""
        self.scene.write_text((APPS / "flow/rod_in_cross_flow.toml").read_text())
        self.run_skein("light", "--set", "rods.rod.material.density=0.3", "--set", "load.gravity.acceleration=[0,0,42.476]", "--set", "fluid.spacing=0.018",
                       "--set", "fluid.cells=[64,54,80]", "--set", "fluid.lower=[-0.486,-0.486,-1.2]", "--set", "fluid.courant=0.1", "--set", "time.duration=0.3", "--set", "output.fields=0")
        series = self.series("light")
        self.assertGreater(series["centre_xm"][-1], 0.1)
        self.assertLess(series["max_speedms"].max(), 2.5)

    def test_a_row_of_cilia_pumps_the_way_of_its_wave_and_is_drawn(self):
        """Half the cells of the scene: those that run ahead of the ones before them pump towards larger x, the others back."""
        self.scene.write_text((APPS / "flow/cilia_row.toml").read_text())
        for delay, sign in ((-0.125, 1), (0.125, -1)):
            out = f"cilia{delay}"
            self.run_skein(out, "--set", "fluid.cells=[48,8,24]", "--set", "fluid.spacing=0.08333333333333333", "--set", f"constants.delay={delay}")
            series = self.series(out)
            self.assertLess(series["max_speedms"].max(), 7, out)  # of the stroke: 6.3
            self.assertGreater(sign * series["fluid_momentum_xkg_ms"][-1] / (4 * 2 / 3 * 2), 0.03, out)
        done = subprocess.run([sys.executable, str(APPS / "flow/rods.py"), str(self.directory / "cilia-0.125")], capture_output=True, text=True, timeout=100)
        self.assertIn("mean velocity of the fluid along the wall over the last beat +0.3", done.stdout, done.stderr)
        self.assertGreater((self.directory / "cilia-0.125/pumping.png").stat().st_size, 10000)

    def test_springs_and_a_box_that_follows_have_the_same_bits_on_other_ranks_and_after_a_stop(self):
        """Springs for a part of the time; a box that follows begins to move late in it."""
        for name, scene in {"springs": SCENE.replace("duration = 0.4", "duration = 0.26") + PENALTY, "follows": FOLLOWS}.items():
            self.scene.write_text(scene)
            self.run_skein(name)
            self.run_skein(name + "_rows", "--set", "fluid.ranks_across=2", ranks=4)
            self.run_skein(name + "_lanes", "--lanes", "2")
            self.run_skein(name + "_threads", "--lanes", "1", threads=2)  # a rod each
            self.run_skein(name + "_parts", "--until", "0.21")
            self.assertIn("Resuming from", self.run_skein(name + "_parts", ranks=2).stdout)
            for out in (name + "_rows", name + "_lanes", name + "_threads", name + "_parts"):
                self.assertEqual(self.digest(out), self.digest(name), out)

    def test_a_box_that_follows_its_rods_is_where_they_are(self):
        """It has moved by whole cells with the mean place of all nodes, its fields say so, and rods move as in a box that stays, but for its walls."""
        self.scene.write_text(FOLLOWS)
        self.run_skein("follows")
        self.run_skein("stays", "--set", "fluid.follows_rods=false")
        with h5py.File(sorted((self.directory / "follows").glob("fields_*.h5"))[-1]) as file:
            moved = file.attrs["lower_x"] / 0.1
            self.assertAlmostEqual(moved, round(moved), 9)
            self.assertGreaterEqual(round(moved), 1)
        centre = {out: self.series(out)["centre_xm"] for out in ("follows", "stays")}
        self.assertLess(abs(centre["follows"] - centre["stays"]).max(), 0.03 * (centre["stays"][-1] - centre["stays"][0]))

    def test_a_rod_that_fails_in_a_fluid_is_told_with_where_it_began(self):
        """From a copy of the end of a step of the fluid: within one its stages could not be done again."""
        self.scene.write_text(SCENE.replace("youngs_modulus = 2000.0", "youngs_modulus = 2e6"))
        told = self.run_skein("fails", "--set", "time.dt=1e-3", "--set", "time.force_dt=true", expect=4).stderr
        for words in ("rod 0 of 'thick'", "where it began", "likely cause: dt"):
            self.assertIn(words, told)

    def test_ranks_that_exchange_interfaces_agree_to_rounding(self):
        self.run_skein("one")
        self.run_skein("interfaces", "--set", "fluid.pressure_exchange=interfaces", ranks=2)
        one, other = self.series("one"), self.series("interfaces")
        self.assertGreaterEqual(one["fluid_steps"][-1], 15)
        for name in one.dtype.names:
            if name == "fluid_max_divergence1s": continue
            self.assertLess(abs(one[name] - other[name]).max(), 1e-10 * max(1, abs(one[name]).max()), name)

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
        self.scene.write_text(disc_on_a_spring(96, 1.0, math.pi / 2, 20.0))  # 1 rad/s with twice its mass
        self.run_skein("disc")
        series = self.series("disc")
        time, place = series["times"], series["centre_xm"]
        i = numpy.flatnonzero(place[1:] * place[:-1] < 0)
        zeros = time[i] - place[i] * (time[i + 1] - time[i]) / (place[i + 1] - place[i])
        self.assertGreaterEqual(len(zeros), 5)
        self.assertLess(abs(4 * numpy.pi / (zeros[4] - zeros[0]) / 0.874 - 1), 0.015)

    def test_a_segment_computed_again_has_the_same_bits_whatever_the_outputs(self):
        """A checkpoint keeps the step that was chosen: with it rods and fluid are to meet as often as before."""
        for name, intervals in (("even", "series = 0.02\ncheckpoint = 0.1"),
                                ("uneven", "series = 0.045454545454545456\ntrajectory = 0.038461538461538464\ncheckpoint = 0.125")):
            self.scene.write_text(SCENE.replace("series = 0.02\ncheckpoint = 0.1", intervals))
            self.run_skein(name)
            for segment in "01":
                done = subprocess.run([SKEIN, "verify", str(self.directory / name), "--threads", "1", "--segment", segment], capture_output=True, text=True, timeout=200)
                self.assertEqual(done.returncode, 0, f"{name}: {done.stdout}{done.stderr}")


if __name__ == "__main__":
    unittest.main()
