"""A fluid by itself: nothing in the results tells on how many ranks, threads and lanes they were computed, nor where the run was
interrupted; fields are those of the scene; what has no fluid never sees its library."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import unittest

import h5py
import numpy

from driver import BALL_IN_IT, FLUID_IN_A_BOX, SKEIN, DriverTest, rods_in_a_fluid

FLOW = pathlib.Path(__file__).resolve().parents[2] / "apps/flow"
WALLS = """
acceleration = [0.5, 0.0, 0.2]
upper_wall_velocity = [0.5, 0.0, -0.3]
frequency = 1.3
"""
FLUID = """
title = "vortices round a ball"
[time]
duration = 0.5
""" + FLUID_IN_A_BOX + """
velocity_formula = ["U * sin(k*y)", "0.3 * U * sin(2 * k * x / 2.4)", "0 * U"]
""" + WALLS + BALL_IN_IT + """
[output]
series = 0.05
fields = 0.25
checkpoint = 0.25
"""


RODS_IN_FLUID = """
title = "rods that stir a fluid"
[time]
duration = 0.2
[fluid]
cells = [32, 24, 20]
spacing = 0.1
density = 2.0
viscosity = 0.01
courant = 0.4
expected_speed = 1.5
[immersion]
coupling = "one_way"
""" + rods_in_a_fluid((1000.0, 1e6), (1000.0, 1e6), [0.0, 0.0, 1.0]) + """
[output]
series = 0.02
fields = 0.1
checkpoint = 0.1
"""


HAS_MULTIGRID = (pathlib.Path(SKEIN).parent.parent / "lib/libskein_multigrid.so").exists()


def multigrid(scene, keys=""):
    return scene.replace("[[obstacle]]", f'pressure = "multigrid"\n{keys}\n[[obstacle]]')


def libraries(process):
    return set(re.findall(r"/\S*?(lib\w+)[-.\d]*\.so", pathlib.Path(f"/proc/{process.pid}/maps").read_text()))

# Vortices in a stream with waves of three cells.
ROUGH = """
title = "a rough flow"
[constants]
k = { value = 6.283185307179586, unit = "1/m" }
U = { value = 1.0, unit = "m/s" }
[time]
duration = 5.0
[fluid]
cells = [32, 32, 1]
spacing = 0.03125
density = 1.0
viscosity = 1e-6
velocity_formula = ["U + U * sin(k*x) * cos(k*y) + 0.05 * U * sin(13*k*x) * cos(11*k*y)", "0 * U - U * cos(k*x) * sin(k*y)", "0 * U"]
[output]
series = 0.1
"""


class Fluid(DriverTest):
    def setUp(self):
        super().setUp()
        self.rods = self.scene.read_text()
        self.scene.write_text(FLUID)

    def fields(self, out):
        frames = {}
        for path in sorted((self.directory / out).glob("fields_*.h5")):
            with h5py.File(path) as file:
                frames[path.name] = {name: file[name][:] for name in file} | {"time": file.attrs["time"]}
        return frames

    def test_the_same_on_any_ranks_threads_and_lanes_and_after_a_stop(self):
        self.run_skein("one")
        whole = self.fields("one")
        self.assertEqual(len(whole), 3)
        self.assertGreater(self.series("one")["fluid_steps"][-1], 10, "the fluid divides steps of the run")
        runs = {"two": {"ranks": 2}, "three": {"ranks": 3}, "threads": {"threads": 2}}
        for out, layout in runs.items():
            self.run_skein(out, **layout)
        for lanes in ("4", "2"):
            self.run_skein("lanes" + lanes, "--lanes", lanes)
        self.run_skein("parts", "--steps", "4", ranks=2)
        resumed = self.run_skein("parts", ranks=3)
        self.assertIn("Resuming from", resumed.stdout)
        for out in (*runs, "lanes4", "lanes2", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assertEqual((self.directory / out / "observables.csv").read_bytes(), (self.directory / "one/observables.csv").read_bytes(), out)
            for name, frame in self.fields(out).items():
                for field in frame:
                    self.assertTrue(numpy.array_equal(frame[field], whole[name][field]), f"{out}/{name}: {field}")

    def test_rows_of_slabs_are_shared_with_the_same_bits(self):
        def across(n):
            return "--set", f"fluid.ranks_across={n}"

        self.run_skein("one")
        self.run_skein("four_by_one", *across(4), ranks=4)
        plan = self.run_skein("parts", "-v", "--steps", "4", *across(2), ranks=4).stdout
        self.assertRegex(plan, r"sent +2 slabs of planes, the rows of each on 2 ranks; by a rank in a step: ")
        self.assertIn("Resuming from", self.run_skein("parts", *across(3), ranks=3).stdout)
        for out in ("four_by_one", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assertEqual((self.directory / out / "observables.csv").read_bytes(), (self.directory / "one/observables.csv").read_bytes(), out)
            for name, frame in self.fields("one").items():
                for field in frame:
                    self.assertTrue(numpy.array_equal(frame[field], self.fields(out)[name][field]), f"{out}/{name}: {field}")
        self.scene.write_text(RODS_IN_FLUID)
        self.run_skein("rods")
        self.run_skein("rods_on_four", *across(2), ranks=4)
        self.assertEqual(self.digest("rods_on_four"), self.digest("rods"))

    def test_a_thin_box_has_more_ranks_than_planes(self):
        thin = FLUID.replace("[24, 20, 16]", "[24, 20, 2]").replace('"free_slip"', '"periodic"').replace('name = "ball"', 'name = "ball"\nkind = "cylinder"')
        self.scene.write_text(thin)
        self.run_skein("one")
        self.assertIn("1 slab of planes, the rows of each on 4 ranks", self.run_skein("four", "-v", ranks=4).stdout)
        self.assertEqual(self.digest("four"), self.digest("one"))
        done = self.run_skein("low", "--set", "fluid.cells=[24, 4, 2]", expect=2, ranks=3)
        self.assertIn("the fluid has 4 rows of cells along y and 2 planes along z, too few for 3 ranks: expected at most 1 slabs of planes times at most 2 ranks of each", done.stderr)

    def test_ranks_that_make_no_slabs_are_refused(self):
        self.scene.write_text(FLUID.replace("density = 2.0", "ranks_across = 2\ndensity = 2.0"))
        line = self.scene.read_text().splitlines().index("ranks_across = 2") + 1
        done = self.run_skein("out", expect=2, ranks=3)
        self.assertIn(f"{self.scene}:{line}: 'ranks_across': 3 ranks cannot form slabs of 2 ranks each: expected a divisor of 3", done.stderr)
        self.scene.write_text(FLUID.replace("[24, 20, 16]", "[24, 20, 4]"))
        done = self.run_skein("out", "--set", "fluid.ranks_across=1", expect=2, ranks=3)
        self.assertIn("'ranks_across': the fluid has 4 planes along z, too few for 3 slabs, of 3 ranks, 1 of them in each: expected at most 2 slabs", done.stderr)

    def test_rods_stir_a_fluid_alike_on_any_ranks_threads_and_lanes_and_however_often_one_looks(self):
        self.scene.write_text(RODS_IN_FLUID)
        plan = self.run_skein("one", "-v").stdout
        self.assertRegex(plan, r"'thick', half axes of 2 to 3 cells, \d+ markers a rod, on rings")
        self.assertIn("'threads', half axes of 0.4 to 0.4 cells", plan)
        runs = {"two": {"ranks": 2}, "three": {"ranks": 3}, "threads": {"threads": 2}}
        for out, layout in runs.items():
            self.run_skein(out, **layout)
        self.run_skein("lanes", "--lanes", "2")
        steps = int(self.series("one")["step"][5])
        self.run_skein("parts", "--steps", str(steps - 1), ranks=2)  # on to the end of a step of the fluid
        self.assertEqual(self.series("parts")["step"][-1], steps)
        self.run_skein("parts", ranks=3)
        for out in (*runs, "lanes", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)
        self.scene.write_text(RODS_IN_FLUID.replace("series = 0.02\nfields = 0.1\ncheckpoint = 0.1", "series = 0.1"))
        self.run_skein("seldom", "--set", "time.divide=0.02")
        self.assertEqual(self.digest("seldom"), self.digest("one"))

    def test_rods_give_the_fluid_what_it_gains(self):
        self.scene.write_text(RODS_IN_FLUID)
        self.run_skein("rods")
        series = self.series("rods")
        for axis in "xyz":
            momentum = series[f"fluid_momentum_{axis}kg_ms"]
            interval = series["times"][1]
            given = -interval * (series[f"thick_fluid_force_{axis}N"] + series[f"threads_fluid_force_{axis}N"])
            numpy.testing.assert_allclose(numpy.diff(momentum), given[1:], atol=1e-12 * abs(momentum).max())
        self.assertGreater(series["fluid_momentum_xkg_ms"][-1], 0.1)

    def test_implicit_viscosity_goes_on_with_forces_at_markers(self):
        self.scene.write_text(FLUID.replace("viscosity = 0.01", 'viscosity = 2.0\nscheme = "crank_nicolson"'))
        self.run_skein("one")
        self.assertLess(self.series("one")["fluid_steps"][-1], 50, "viscosity alone would want 150")
        self.run_skein("two", ranks=2)
        self.run_skein("parts", "--steps", "4", ranks=3)
        self.assertIn("Resuming from", self.run_skein("parts", ranks=2).stdout)
        for out in ("two", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assertEqual((self.directory / out / "observables.csv").read_bytes(), (self.directory / "one/observables.csv").read_bytes(), out)

    def test_rods_go_on_with_forces_at_markers(self):
        self.scene.write_text(RODS_IN_FLUID.replace("viscosity = 0.01", 'viscosity = 2.0\nscheme = "crank_nicolson"'))
        self.run_skein("one")
        self.run_skein("two", ranks=2)
        steps = int(self.series("one")["step"][5])
        self.run_skein("parts", "--steps", str(steps - 1), ranks=3)
        self.assertIn("Resuming from", self.run_skein("parts", ranks=2).stdout)
        for out in ("two", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)

    def test_a_cubic_array_of_spheres_has_its_drag(self):
        self.scene = FLOW / "sphere_array.toml"
        self.run_skein("array", "--overwrite", "--set", "fluid.cells=[32,32,32]", "--set", "fluid.spacing=0.03125")
        done = subprocess.run([sys.executable, str(FLOW / "plot.py"), str(self.directory / "array")], capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater((self.directory / "array/drag.png").stat().st_size, 10000)
        self.assertLess(abs(float(re.search(r"published 7.442, difference ([+-][\d.]+)%", done.stdout)[1])), 2)

    def test_an_ellipsoid_turns_the_flow_as_in_theory(self):
        """At two thirds of the cells of the scene. Spheres have the mobility of Hasimoto 1959: 1 - 2.837297 a/L + 4 pi/3 (a/L)^3, to fifth order."""
        sys.path[:0] = [str(FLOW), str(FLOW.parents[1] / "python")]
        self.addCleanup(lambda: sys.path.__delitem__(slice(0, 2)))
        import ellipsoids

        for size in (0.1, 0.2):
            mobility = 2.0 * ellipsoids.mobility(numpy.eye(3) * 2.0 * size, 2.0) * 6 * numpy.pi * size
            numpy.testing.assert_allclose(mobility, numpy.eye(3) * (1 - 2.837297 * size + 4 * numpy.pi / 3 * size**3), atol=1e-6)
        figures = self.measured("tilted_ellipsoid.toml", "drift.png", "fluid.cells=[40,40,40]", "fluid.spacing=0.025")
        along, across = (number for what, number in figures.items() if what.startswith("mean velocity along"))
        self.assertLess(abs(along), 1)
        self.assertLess(abs(across), 2.5)

    def test_fields_are_those_of_the_scene(self):
        """Means of faces at the middles of cells, and derivatives of what the scene says, to second order."""
        scene = FLUID[: FLUID.index("[[obstacle]]")] + FLUID[FLUID.index("[output]"):]
        self.scene.write_text(scene.replace("checkpoint = 0.25\n", "").replace('along_y = "no_slip"', 'along_y = "periodic"').replace(WALLS, ""))
        self.run_skein("out", "--steps", "1")
        frame = self.fields("out")["fields_000000000000.h5"]
        self.assertEqual(frame["velocity"].shape, (16, 20, 24, 3))
        x, y = 0.5 + 0.1 * (numpy.arange(24) + 0.5), -1 + 0.1 * (numpy.arange(20) + 0.5)
        k = numpy.pi
        u, v = numpy.sin(k * y)[:, None], 0.3 * numpy.sin(2 * k * x / 2.4)[None, :]
        numpy.testing.assert_allclose(frame["velocity"][5, ..., 0], u + 0 * v, atol=2e-6)
        numpy.testing.assert_allclose(frame["velocity"][5, ..., 1], v + 0 * u, atol=2e-6)
        vorticity = 0.3 * 2 * k / 2.4 * numpy.cos(2 * k * x / 2.4)[None, :] - k * numpy.cos(k * y)[:, None]
        numpy.testing.assert_allclose(frame["vorticity"][5, ..., 2], vorticity, atol=0.06 * abs(vorticity).max())
        numpy.testing.assert_allclose(frame["velocity"][..., 2], 0, atol=1e-6)
        text = (self.directory / "out/fields.xdmf").read_text()
        self.assertIn('Dimensions="17 21 25"', text)
        self.assertIn("fields_000000000000.h5:/velocity", text)

    def measured(self, scene, picture, *settings):
        """Percentages that apps/flow/plot.py prints of a scene of apps/flow beside a picture: {what stands before: number}."""
        self.scene = FLOW / scene
        self.run_skein(scene, "--overwrite", *(word for setting in settings for word in ("--set", setting)))
        done = subprocess.run([sys.executable, str(FLOW / "plot.py"), str(self.directory / scene)], capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater((self.directory / scene / picture).stat().st_size, 10000)
        return {what: float(number) for what, number in re.findall(r"(?m)^(.*?) ([+-]?[\d.]+)%", done.stdout)}

    def test_vortices_are_those_of_theory(self):
        fine = self.measured("lamb_oseen.toml", "vortex.png")
        coarse = self.measured("lamb_oseen.toml", "vortex.png", "fluid.cells=[64,64,4]", "fluid.spacing=0.25")
        error = "t = 25 s: largest error of u or v within 2 cores of the axis"
        self.assertLess(fine[error], 0.3)
        self.assertGreater(coarse[error] / fine[error], 2**1.7)
        ring = self.measured("vortex_ring.toml", "vortex.png", "fluid.cells=[64,48,48]", "fluid.spacing=0.2", "time.duration=5.0")
        speed, = (number for what, number in ring.items() if what.startswith("way 0 to 1 radii"))
        self.assertLess(abs(speed), 4, "twice as coarse as the scene")
        impulse, = (number for what, number in ring.items() if what.startswith("impulse"))
        self.assertLess(impulse, 0.5)

    def test_no_scheme_makes_a_flow_grow(self):
        """In steps as long as viscosity allows, and up to a Courant number of 1.2 where it is next to nothing. theory.md (77b)"""
        for scheme in ("rk3", "rk3_projected", "adams_bashforth", "crank_nicolson"):
            for viscosity, courant, duration in ((1e-6, 0.5, 5.0), (1e-6, 1.2, 5.0), (1e-3, 1.0, 5.0), (0.1, 1.5, 0.2)):
                with self.subTest(scheme=scheme, viscosity=viscosity, courant=courant):
                    self.scene.write_text(ROUGH)
                    out = f"{scheme}{viscosity}{courant}"
                    self.run_skein(out, "--set", f"fluid.scheme={scheme}", "--set", f"fluid.viscosity={viscosity}", "--set", f"fluid.courant={courant}", "--set", f"time.duration={duration}")
                    energy = self.series(out)["fluid_energyJ"]
                    print(scheme, viscosity, courant, energy[-1] / energy[0])
                    self.assertLess(energy.max(), 1.01 * energy[0])

    def test_a_wall_that_swings_drags_the_fluid_along_as_in_theory(self):
        errors = []
        for cells, spacing in ((32, 0.03125), (64, 0.015625)):
            figures = self.measured("oscillating_wall.toml", "profiles.png", f"fluid.cells=[4,4,{cells}]", f"fluid.spacing={spacing}")
            errors.append(figures["largest error of the velocity in the last period"])
        self.assertLess(errors[1], 1)
        self.assertGreater(errors[0] / errors[1], 2**1.7)

    def test_columns_slab_by_slab_find_the_flow_of_whole_ones_and_repeat_their_bits(self):
        self.run_skein("whole", ranks=3)
        self.scene.write_text(FLUID.replace(WALLS, WALLS + 'pressure_exchange = "interfaces"'))
        plan = self.run_skein("slabs", "-v", ranks=3).stdout
        self.assertRegex(plan, r"direct, by numbers at interfaces of slabs, 100 % of columns through all slabs; other numbers of ranks agree to about 1e-12")
        self.assertRegex(plan, r"sent +by a rank in a step: 17.9 kB at interfaces \(17.9 kB a solve\)")
        for name, frame in self.fields("slabs").items():
            for field in ("velocity", "pressure"):
                whole = self.fields("whole")[name][field]
                numpy.testing.assert_allclose(frame[field], whole, atol=1e-6 * abs(whole).max(), err_msg=f"{name}: {field}")  # single precision
        self.run_skein("threads", ranks=3, threads=2)
        self.run_skein("parts", "--steps", "4", ranks=3)
        self.assertIn("Resuming from", self.run_skein("parts", ranks=3).stdout)
        for out in ("threads", "parts"):
            self.assertEqual(self.digest(out), self.digest("slabs"), out)

    def test_an_unsteady_scene_is_refused_and_told(self):
        self.scene.write_text(FLUID.replace("viscosity = 0.01", "viscosity = 1e9"))
        done = self.run_skein("out", expect=4)
        self.assertIn("the velocity or the viscosity of the fluid leaves steps of", done.stderr)

    @unittest.skipUnless(HAS_MULTIGRID, "built without PETSc")
    def test_multigrid_finds_the_flow_of_the_direct_solver_and_repeats_its_bits(self):
        self.run_skein("direct")
        for cells in ("[24, 20, 16]", "[22, 19, 13]"):
            self.scene.write_text(multigrid(FLUID).replace("[24, 20, 16]", cells))
            done = self.run_skein("multigrid" + cells[1:3], ranks=2)
            self.assertIn("bits depend on the number of ranks", done.stdout)
        for name, frame in self.fields("multigrid24").items():
            for field in ("velocity", "pressure"):
                direct, other = self.fields("direct")[name][field], frame[field]
                if field == "pressure":  # free up to a constant
                    direct, other = direct - direct.mean(), other - other.mean()
                numpy.testing.assert_allclose(other, direct, atol=2e-6 * abs(direct).max(), err_msg=f"{name}: {field}")
        self.scene.write_text(multigrid(FLUID))
        self.run_skein("parts", "--steps", "4", ranks=2)
        self.run_skein("parts", ranks=2)
        self.assertEqual(self.digest("parts"), self.digest("multigrid24"))

    @unittest.skipUnless(HAS_MULTIGRID, "built without PETSc")
    def test_a_pressure_that_is_not_found_ends_the_run(self):
        """That of a ball whose speed has no square."""
        still = FLUID.replace(next(line for line in FLUID.splitlines() if "velocity_formula" in line), "")
        self.scene.write_text(multigrid(still).replace("frequency = 1.0", "frequency = 1e200"))
        done = self.run_skein("out", expect=4, ranks=2)
        self.assertIn("the velocity of the fluid is not finite, and has no pressure", done.stderr)

    def test_a_library_that_cannot_be_read_is_told(self):
        (self.directory / "libfftw3.so.3").touch()
        self.scene.write_text(FLUID)
        done = subprocess.run([SKEIN, "run", self.scene, "--out", self.directory / "out"], capture_output=True, text=True,
                              env=os.environ | {"LD_LIBRARY_PATH": f"{self.directory}:{os.environ.get('LD_LIBRARY_PATH', '')}"})
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("a fluid needs the library FFTW 3", done.stderr)

    @unittest.skipUnless(HAS_MULTIGRID, "built without PETSc")
    def test_a_library_that_is_not_there_is_told(self):
        """A program by itself, whose library lies nowhere."""
        alone = self.directory / "bin/skein"
        alone.parent.mkdir()
        shutil.copy(SKEIN, alone)
        self.scene.write_text(multigrid(FLUID))
        done = subprocess.run([alone, "run", self.scene, "--out", self.directory / "out"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("libskein_multigrid.so", done.stderr)

    def test_what_is_not_asked_for_is_not_loaded(self):
        fluid = FLUID.replace("duration = 0.5", "duration = 500.0").replace("cells = [24, 20, 16]", "cells = [96, 96, 96]")
        kinds = {"rods": (self.rods.replace("duration = 14.4", "duration = 14400.0"), False, False), "fluid": (fluid, True, False)}
        if HAS_MULTIGRID:
            kinds["multigrid"] = (multigrid(fluid.replace("[96, 96, 96]", "[64, 64, 64]")), None, True)  # PETSc may bring an FFTW
        for name, (scene, fftw, petsc) in kinds.items():
            self.scene.write_text(scene)
            run = subprocess.Popen([SKEIN, "run", str(self.scene), "--out", str(self.directory / name), "-q"], stdout=subprocess.DEVNULL)
            try:
                end = time.monotonic() + 60
                while not (self.directory / name / "observables.csv").exists() and run.poll() is None and time.monotonic() < end:
                    time.sleep(0.02)
                self.assertIsNone(run.poll())
                loaded = libraries(run)
                if fftw is not None:
                    self.assertEqual(any("fftw" in library for library in loaded), fftw, name)
                for library in ("petsc", "skein_multigrid"):
                    self.assertEqual(any(library in other for other in loaded), petsc, f"{name}: {library}")
            finally:
                run.kill()
                run.wait()


if __name__ == "__main__":
    unittest.main()
