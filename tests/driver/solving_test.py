"""skein equilibrium, modes and path as their users meet them: results, refusals, what is said and the same bits of any layout."""

import csv
import json
import pathlib
import re
import subprocess
import time
import tomllib
import unittest

import numpy

from driver import SKEIN, DriverTest

# Cantilevers of two groups, one of them a copy of an assembly of two rods with a hinge; a probe at a tip.
BODIES = """
[time]
duration = 1.0
[[rods]]
name = "reeds"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 2e6}
section.radius = 5e-3
shape = {length = 0.5, elements = 12}
placement = {kind = "line", counts = [5], spacing = [0.1], tangent = [1, 0, 0], normal = [0, 0, 1]}
[[assembly]]
name = "arm"
placement = {kind = "list", origins = [[0, 1, 0], [0, 2, 0], [0, 3, 0]], tangents = [[0, 0, 1], [0, 0, 1], [0, 0.6, 0.8]]}
[[rods]]
name = "upper"
assembly = "arm"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e7}
section.radius = 0.01
shape = {length = 0.5, elements = 8}
placement.tangent = [1, 0, 0]
[[rods]]
name = "lower"
assembly = "arm"
material = {density = 1000.0, youngs_modulus = 1e7}
section.radius = 0.01
shape = {length = 0.5, elements = 6}
placement = {origin = [0.5, 0, 0], tangent = [1, 0, 0]}
[[joint]]
kind = "hinge"
between = ["upper", "lower"]
axis = [0, 1, 0]
stiffness = 1e4
torsional_stiffness = 10.0
spring = 0.5
[[load]]
kind = "gravity"
acceleration = [0, 0, -2.0]
[[probe]]
name = "tip"
of = "reeds"
number = 2
[output]
series = 1.0
"""

DAMPED = BODIES.replace("spring = 0.5", "spring = 0.5\naxis_damping = 0.02") + """
[[damping]]
kind = "physical"
translational = 1e-2
rotational = 1e-6
"""

# A rod between two walls, with a rest curvature by a table and a start shape of its own.
HELD = """
[time]
duration = 1.0
[[table]]
name = "bend"
at = [0.0, 0.05, 0.1, 0.15, 0.2]
value = [1.0, 2.0, 1.0, -1.0, 1.0]
at_unit = "m"
unit = "1/m"
[[rods]]
name = "arm"
start = "clamped"
end = "clamped"
material = {density = 1200.0, youngs_modulus = 2e6}
section.radius = 3e-3
shape = {length = 0.2, elements = 16, rest_curvature_formula = ["0", "bend(s)", "0"], start_curvature = [0.0, 1.0, 0.0]}
placement = {origin = [0.1, 0.0, 0.0], tangent = [1.0, 0.0, 0.0]}
[[probe]]
name = "mid"
of = "arm"
at = 0.45
[[load]]
kind = "gravity"
acceleration = [0, 0.5, -9.81]
[output]
series = 1.0
"""

COLUMN = """
[time]
duration = 1.0
[[rods]]
name = "column"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 0.01
shape = {length = 1.0, elements = 16}
[[load]]
kind = "end_force"
end = [0, 0, -0.004]
[output]
series = 1.0
"""  # bears 0.0194 N

# An arch under a load along it, which buckles to a side before its limit load.
ARCH = f"""
[time]
duration = 1.0
[[rods]]
name = "arch"
start = "pinned"
end = "pinned"
material = {{density = 1000.0, youngs_modulus = 1e7, shear_modulus = 4e6}}
section.radius = 0.02
shape = {{length = 2.0, elements = 24, rest_curvature = [0.0, -1.0, 0.0], start_curvature = [0.0, -1.0, 0.0]}}
placement = {{tangent = [0.5403023058681398, 0.0, 0.8414709848078965], normal = [-0.8414709848078965, 0.0, 0.5403023058681398]}}
hold = {{nodes = {list(range(1, 24))}, directions = "y"}}
[[load]]
kind = "formula"
force = ["side", "0", "-push"]
[constants]
push = {{value = 0.1, unit = "N/m"}}
side = {{value = 0.0, unit = "N/m"}}
[output]
series = 1.0
"""
PUSH, MODULUS, SHEAR, RADIUS = "constants.push.value", "rods.arch.material.youngs_modulus", "rods.arch.material.shear_modulus", "rods.arch.section.radius"

ALONG = ("--along", "load.0.end.2", "--to", -0.03, "--points", 12)


class Solving(DriverTest):
    def solve(self, command, out, *arguments, text=BODIES, **layout):
        arguments = ("--along", "load.0.acceleration.2", "--to", -4.0, "--points", 6, *arguments) if command == "path" and text == BODIES else arguments
        return self.solve_scene(command, out, *arguments, text=text, **layout)

    def rows(self, out, name):
        with open(self.directory / out / name, newline="") as file:
            return list(csv.DictReader(file))

    def test_results_are_those_of_a_run(self):
        self.solve("equilibrium", "rest")
        rows = self.series("rest")
        self.assertEqual(len(rows), 2, "a row at the start and one at the end")
        self.assertTrue(self.summary("rest")["finished"])
        self.assertEqual(rows["kinetic_translationJ"][-1], 0)
        self.assertLess(rows["tip_zm"][-1], -1e-3)
        self.solve("modes", "modes", "--count", 3, "--movies", 1)
        frequencies = [float(row["frequency[Hz]"]) for row in self.rows("modes", "modes.csv")]
        self.assertEqual(frequencies, sorted(frequencies))
        self.assertEqual(len(frequencies), 3)
        self.assertTrue((self.directory / "modes/mode_1/summary.json").exists())
        self.solve("path", "path")
        rows = self.rows("path", "path.csv")
        self.assertEqual(float(rows[0]["load.0.acceleration.2[m/s^2]"]), -2)
        self.assertEqual(len(rows), len(self.series("path")) - 1)
        for name in ("tip_z[m]", "residual[-]"):
            self.assertIn(name, rows[0])

    def test_a_couple_of_fixed_direction_takes_load_steps(self):
        """As the gallery has it, where relaxation finds it; corrections fall with their square."""
        text = (pathlib.Path(__file__).resolve().parents[2] / "apps/gallery/rod_under_couple.toml").read_text()
        done = self.solve("equilibrium", "couple", text=text)
        corrections = [float(value) for value in re.findall(r"correction (\S+)", done.stdout)]
        self.assertLess(len(corrections), 9)
        self.assertLess(corrections[-1], 10 * corrections[-2] ** 2 + 1e-12)
        row = self.series("couple")
        for value in tomllib.loads(text)["expect"]:
            column = next(name for name in row.dtype.names if name.startswith(value["column"]))
            self.assertLess(abs(numpy.atleast_1d(row[column])[-1] - value["value"]), abs(value["tolerance"] * value["value"]), column)

    def test_modes_have_what_damps(self):
        plain = self.solve("modes", "plain", "--count", 3, "--movies", 1).stdout
        for word in ("decay", "Arnoldi"):
            self.assertNotIn(word, plain)
        damped = self.solve("modes", "damped", "--count", 3, "--movies", 1, text=DAMPED).stdout
        self.assertIn("decay", damped)
        for row in self.rows("damped", "modes.csv"):
            decay, angular = float(row["decay[1/s]"]), 2 * numpy.pi * float(row["frequency[Hz]"])
            self.assertGreater(decay, 0)
            self.assertAlmostEqual(float(row["damping_ratio[-]"]), decay / numpy.hypot(decay, angular))
            self.assertAlmostEqual(float(row["eigenvalue[1/s^2]"]) / (decay**2 + angular**2), 1)
        self.solve("modes", "without", "--count", 3, "--movies", 1, "--undamped", text=DAMPED)
        self.assertEqual(self.rows("without", "modes.csv"), self.rows("plain", "modes.csv"))
        for out in ("damped", "without"):
            self.assertTrue((self.directory / out / "mode_1/summary.json").exists())
        done = json.loads(self.solve("modes", "told", "--count", 1, "--json", text=DAMPED).stdout)["modes"][0]
        self.assertGreater(done["decay"], 0)
        self.assertGreater(done["damping_ratio"], 0)

    def test_results_that_exist_are_safe(self):
        for command in ("equilibrium", "modes", "path"):
            self.solve(command, command)
            files = sorted(path.name for path in (self.directory / command).iterdir())
            before = self.digest(command)
            again = self.solve(command, command, expect=2)
            self.assertEqual(self.digest(command), before, again.stdout)
            self.assertEqual(sorted(path.name for path in (self.directory / command).iterdir()), files)
            self.solve(command, command, "--set", "load.0.acceleration=[0, 0, -3.0]", expect=2)
            self.assertEqual(self.digest(command), before, "refused without harm")
            self.solve(command, command, "--set", "load.0.acceleration=[0, 0, -3.0]", "--overwrite")
            self.assertNotEqual(self.digest(command), before)
            self.assertEqual(json.loads((self.directory / command / "previous_1/summary.json").read_text())["digest"], before)

    def observed(self, text, *arguments):
        """Observables at rest, {name with unit: value}."""
        out = f"at{len(list(self.directory.iterdir()))}"
        self.solve("equilibrium", out, *arguments, text=text)
        return {name: float(value) for name, value in self.rows(out, "observables.csv")[-1].items()}

    def slopes(self, text, keys, *arguments):
        """What skein gradient finds: {key: {observable: slope}}."""
        self.scene.write_text(text)
        words = [word for key in keys for word in ("--by", key)]
        found = json.loads(self.skein_says("gradient", self.scene, *words, *arguments, "--json").stdout)
        return {one["key"]: one["slopes"] for one in found["numbers"]}, found

    def differences(self, text, key, value, h):
        """The same by differences of fourth order of equilibria."""
        at = {k: self.observed(text, "--set", f"{key}={value + k * h!r}") for k in (-2, -1, 1, 2)}
        return {name: (8 * (at[1][name] - at[-1][name]) - (at[2][name] - at[-2][name])) / (12 * h) for name in at[1]}

    def test_slopes_are_those_of_equilibria(self):
        values = {"rods.reeds.material.youngs_modulus": 2e6, "load.0.acceleration.2": -2.0, "rods.reeds.shape.length": 0.5}
        found, _ = self.slopes(BODIES, values)
        for key, value in values.items():
            slope = self.differences(BODIES, key, value, 1e-3 * abs(value))["tip_z[m]"]
            self.assertLess(abs(found[key]["tip_z[m]"] - slope), 1e-6 * abs(slope), key)

    def test_a_modulus_that_is_left_out_is_the_one_in_use(self):
        """Of a twisted rod with G = E/3: by gradient and path."""
        twisted = COLUMN.replace('"end_force"\nend = [0, 0, -0.004]', '"end_couple"\nend = [0, 0, 1e-3]')
        key = "rods.column.material.shear_modulus"
        found, _ = self.slopes(twisted, [key])
        slopes = self.differences(twisted, key, 1e6 / 3, 1e2)
        self.assertLess(abs(found[key]["elastic_twist[J]"] - slopes["elastic_twist[J]"]), 1e-6 * abs(slopes["elastic_twist[J]"]))
        self.solve("path", "softer", "--along", key, "--to", 2e5, "--points", 5, text=twisted)
        self.assertEqual(float(self.rows("softer", "path.csv")[0][f"{key}[Pa]"]), 1e6 / 3)

    def test_what_is_held_moves_with_the_number(self):
        values = {"rods.arm.shape.length": 0.2, "rods.arm.placement.origin.0": 0.1, "rods.arm.shape.start_curvature.1": 1.0, "rods.arm.material.youngs_modulus": 2e6}
        found, _ = self.slopes(HELD, values)
        for key, value in values.items():
            slopes = self.differences(HELD, key, value, 1e-3 * abs(value))
            largest = max(abs(slopes[f"mid_{axis}[m]"]) for axis in "xyz")
            for axis in "xyz":
                self.assertLess(abs(found[key][f"mid_{axis}[m]"] - slopes[f"mid_{axis}[m]"]), 1e-6 * largest, (key, axis))

    def test_a_path_moves_what_is_held(self):
        self.solve("path", "longer", "--along", "rods.arm.shape.length", "--to", 0.204, "--points", 40, text=HELD)
        end = self.rows("longer", "path.csv")[-1]
        self.assertEqual((float(end["rods.arm.shape.length[m]"]), end["place"]), (0.204, "end"))
        rest = self.observed(HELD, "--set", "rods.arm.shape.length=0.204")
        for name in ("mid_x[m]", "mid_y[m]", "mid_z[m]"):
            self.assertLess(abs(float(end[name]) - rest[name]), 1e-9, name)

    def test_numbers_along_a_rod(self):
        """Values of a table are changed several at a time, and are as if each were changed alone."""
        knots = [f"table.bend.value.{k}" for k in range(5)]
        free = HELD.replace('end = "clamped"\n', "")
        for text in (HELD, free):
            together, _ = self.slopes(text, knots)
            for key in knots:
                alone, _ = self.slopes(text, [key])
                for name, slope in alone[key].items():
                    if not name.startswith("max"):
                        self.assertLess(abs(together[key][name] - slope), 1e-6 * abs(slope) + 1e-12, (key, name))
        slopes = self.differences(free, "table.bend.value.2", 1.0, 1e-2)
        for name in ("mid_x[m]", "mid_y[m]", "mid_z[m]", "elastic_bend[J]", "elastic_twist[J]", "centre_y[m]"):
            self.assertLess(abs(together["table.bend.value.2"][name] - slopes[name]), 1e-6 * abs(slopes[name]), name)

    def test_a_table_that_loads_have_too(self):
        """Its values do not act on their part of the rod alone."""
        both = HELD.replace("[output]", '[[load]]\nkind = "formula"\nforce = ["0", "1e-3*bend(0.1)", "0"]\n[output]')
        knots = [f"table.bend.value.{k}" for k in range(1, 5)]
        together, _ = self.slopes(both, knots)
        for key in knots:
            alone, _ = self.slopes(both, [key])
            self.assertLess(abs(together[key]["mid_y[m]"] - alone[key]["mid_y[m]"]), 1e-9 * abs(alone[key]["mid_y[m]"]), key)

    def test_adjoint_slopes_are_those_of_each_number(self):
        for text, keys in ((HELD, [f"table.bend.value.{k}" for k in range(5)] + ["load.0.acceleration.1", "rods.arm.section.radius"]),
                           (BODIES, ["rods.upper.material.youngs_modulus", "rods.lower.material.youngs_modulus", "joint.0.spring", "rods.reeds.shape.length"])):
            probe = "mid" if text == HELD else "tip"
            of = [f"{probe}_x[m]", f"{probe}_z", "centre_x", "centre_z[m]", "elastic_stretch", "elastic_shear", "elastic_bend", "elastic_twist"]
            every, figures = self.slopes(text, keys)
            self.assertEqual(figures["adjoint_solutions"], 0)
            adjoint, figures = self.slopes(text, keys, *[word for name in of for word in ("--of", name)])
            self.assertEqual(figures["adjoint_solutions"], len(of))
            for key in keys:
                self.assertEqual(len(adjoint[key]), len(of))
                for name, slope in adjoint[key].items():
                    self.assertLess(abs(slope - every[key][name]), 2e-6 * abs(every[key][name]) + 1e-13, (key, name))
        _, figures = self.slopes(HELD, ["table.bend.value.1"], "--of", "mid_x", "--of", "max_axial_strain")
        self.assertEqual(figures["adjoint_solutions"], 0, "an extreme has no slope in closed form")
        done = self.skein_says("gradient", self.scene, "--by", "table.bend.value.1", "--of", "mid_w", expect=2)
        self.assertIn("'mid_w' is no observable", done.stderr)

    def test_slopes_at_a_bound_are_those_of_its_side(self):
        field = '[[load]]\nkind = "magnetic_field"\nconstant = [0, 0, 1e-3]\nsine_axis = [0, 1, 0]\nperiod = 4.0\nrotating = 0.0\n[[load]]'
        magnetised = BODIES.replace("[[load]]", field).replace("5e-3", '5e-3\nmagnetisation = {pattern = "uniform", strength = 1e4}', 1)
        key = "load.0.rotating"  # no less than 0
        found, _ = self.slopes(magnetised, [key])
        tip = {}
        for value in (1e-5, 2e-5):
            self.solve("equilibrium", f"at_{value}", "--set", f"{key}={value}", text=magnetised)
            tip[value] = self.series(f"at_{value}")["tip_ym"][-1]  # 0 without the field
        slope = (4 * tip[1e-5] - tip[2e-5]) / 2e-5
        self.assertLess(abs(found[key]["tip_y[m]"] - slope), 1e-4 * abs(slope))

    def test_a_path_stops_when_it_is_told(self):
        self.scene.write_text(BODIES)
        words = [SKEIN, "path", self.scene, "--out", self.directory / "long", "--threads", 1, "--along", "load.0.acceleration.2", "--to", -40,
                 "--points", 1000000, "--step", 1e-5]
        running = subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        running.stdout.readline()
        running.terminate()
        running.communicate(timeout=20)
        self.assertEqual(running.returncode, 3)
        self.assertEqual(len(self.rows("long", "path.csv")), self.summary("long")["steps"])

    def test_one_document(self):
        for command, key in (("equilibrium", "residual"), ("modes", "modes"), ("equilibrium", "iterations")):
            done = self.solve(command, f"{command}_{key}", "--json")
            self.assertIn(key, json.loads(done.stdout))
            self.assertIn("Newton", done.stderr)

    def test_what_is_wrong_is_named(self):
        for command, arguments, words in (
                ("equilibrium", ("--set", "rods.reeds.material.stiffnes=1"), "stiffnes"),
                ("equilibrium", ("--time", "soon"), "--time"), ("modes", ("--count", "0"), "--count"), ("modes", ("--count", "many"), "--count"),
                ("path", ("--along", "load.0.end.7", "--to", "1"), "load.0.end.7"), ("path", ("--along", "load.0.kind", "--to", "1"), "load.0.kind"),
                ("path", ("--along", "rods.none.shape.length", "--to", "1"), "rods.none.shape.length"), ("path", ("--along", "load.0.end.2"), "--to"),
                ("path", ("--to", "1"), "--along"), ("path", ("--along", "load.0.end.2", "--to", "-0.004"), "--to"),
                ("path", (*ALONG, "--by", "rods.column.section.radius_2"), "cannot be varied"), ("path", (*ALONG, "--by", "rods.column.section.torsion_constant"), "stands for another"),
                ("path", (*ALONG, "--by", "time.duration"), "--time"), ("path", ("--along", "rods.column.material.shear_modulus", "--to", "0"), "stands for another"),
                ("path", (*ALONG, "--branch", "3"), "--branch"), ("path", (*ALONG, "--step", "-1"), "--step")):
            done = self.solve(command, "wrong", *arguments, text=COLUMN, expect=2)
            self.assertIn(words, done.stderr, (command, arguments))
            self.assertFalse((self.directory / "wrong").exists(), (command, arguments))

    def test_what_cannot_be_solved_is_refused(self):
        free = COLUMN.replace('start = "clamped"\n', "").replace('kind = "end_force"\nend = [0, 0, -0.004]', 'kind = "gravity"\nacceleration = [0, 0, -9.81]')
        done = self.solve("equilibrium", "free", text=free, expect=4)
        self.assertRegex(done.stderr, r"nothing balances the loads on the translation along \(-?\S+, -?\S+, -?1\) of 'column'")
        wet = COLUMN + "[fluid]\ncells = [24, 24, 24]\nspacing = 0.1\nlower = [-1.2, -1.2, -0.5]\ndensity = 1.0\nviscosity = 0.1\ncourant = 0.4\nexpected_speed = 1.0\n"
        self.assertIn("[fluid]", self.solve("equilibrium", "wet", text=wet, expect=2).stderr)
        plane = free + '[[load]]\nkind = "anisotropic_plane"\nstiffness = 10.0\n'
        self.assertIn("anisotropic_plane", self.solve("equilibrium", "plane", text=plane, expect=2).stderr)
        done = self.solve("path", "ranks", *ALONG, text=COLUMN, ranks=2, expect=2)
        self.assertIn("without mpirun", done.stderr)

    def test_stability_is_told(self):
        self.solve("equilibrium", "stable", "--stable", text=COLUMN)
        done = self.solve("equilibrium", "unstable", "--stable", "--set", "load.0.end=[0, 0, -0.03]", text=COLUMN, expect=10)
        self.assertIn("unstable", done.stdout)
        self.solve("equilibrium", "allowed", "--set", "load.0.end=[0, 0, -0.03]", text=COLUMN)

    def test_a_path_leaves_at_a_branch_point(self):
        for side in (1, -1):
            self.solve("path", f"branch{side}", "--along", "load.0.end.2", "--to", -0.03, "--points", 60, "--branch", side, text=COLUMN)
            rows = self.rows(f"branch{side}", "path.csv")
            self.assertIn("1", {row["branch"] for row in rows})
            self.assertEqual({row["negative"] for row in rows if row["branch"] == "1"}, {"0"}, "the bent column is stable")

    def test_slopes_along_a_path(self):
        """At a point those of skein gradient, and those of two paths."""
        keys = ("rods.reeds.material.youngs_modulus", "joint.0.spring", "rods.reeds.shape.length")
        by = [word for key in keys for word in ("--by", key)]
        along = ("--along", "load.0.acceleration.2", "--to", -4.0)
        self.solve_scene("path", "along", *along, *by, "--of", "tip_z", "--of", "centre_z", text=BODIES)
        points, slopes = self.rows("along", "path.csv"), self.rows("along", "slopes.csv")
        load = "load.0.acceleration.2[m/s^2]"
        self.assertEqual([row[load] for row in points], [row[load] for row in slopes])
        for row in (slopes[1], slopes[-1]):
            there, _ = self.slopes(BODIES, keys, "--set", f"load.0.acceleration.2={row[load]}", "--of", "tip_z", "--of", "centre_z")
            for key in keys:
                for name in ("tip_z", "centre_z"):
                    expected = there[key][f"{name}[m]"]
                    slope = next(float(value) for heading, value in row.items() if heading.startswith(f"d({name})/d({key})"))
                    # Loads by a soft spring are differences of large forces, which round off to 2e-9 of the slope.
                    bound = 5e-9 if key == "joint.0.spring" else 1e-9
                    self.assertLess(abs(slope - expected), bound * abs(expected) + 1e-20, (key, name))
        ends = []
        for modulus in (1.999e6, 2.001e6):
            self.solve_scene("path", f"at{modulus}", *along, "--set", f"rods.reeds.material.youngs_modulus={modulus}", text=BODIES)
            ends.append(float(self.rows(f"at{modulus}", "path.csv")[-1]["tip_z[m]"]))
        slope = (ends[1] - ends[0]) / 2e3
        self.assertLess(abs(float(slopes[-1]["d(tip_z)/d(rods.reeds.material.youngs_modulus)[m/Pa]"]) - slope), 1e-6 * abs(slope))

    def critical(self, out, *arguments, text=ARCH, points=20):
        """Rows of critical_slopes.csv, by numbers without their headings."""
        self.solve("path", out, "--along", PUSH, "--to", 60, "--points", points, *arguments, text=text)
        named = re.compile(r"d\(.*\)/d\((.*?)\)")
        return [{(named.match(key) or [None, "value" if key == f"{PUSH}[N/m]" else key])[1]: value for key, value in row.items()} for row in self.rows(out, "critical_slopes.csv")]

    def test_slopes_of_limit_and_branch_points(self):
        """Loads go with stiffness: their slopes by moduli, times these, add up to them. Differences of paths have the others."""
        by = [word for key in (MODULUS, SHEAR, RADIUS, "constants.side.value", "rods.arch.material.density", PUSH) for word in ("--by", key)]
        rows = self.critical("arch", *by, "--of", "centre_z")
        self.assertEqual([row["place"] for row in rows], ["branch", "limit"])
        for row, bound in zip(rows, (2e-6, 1e-9)):
            value = float(row["value"])
            self.assertEqual(value, float(self.rows("arch", "path.csv")[int(row["point"])][f"{PUSH}[N/m]"]))
            by_moduli = 1e7 * float(row[MODULUS]) + 4e6 * float(row[SHEAR])
            self.assertLess(abs(by_moduli - value), bound * value, row["place"])
            self.assertEqual(float(row["rods.arch.material.density"]), 0.0)
            self.assertEqual(row[PUSH], "nan", "the path's own number")
        self.assertEqual(rows[0]["constants.side.value"], "nan", "a load to a side leaves no branch point")
        said = self.skein_says("path", self.scene, "--along", PUSH, "--to", 60, "--points", 6, "--out", self.directory / "said", "--by", RADIUS, "--by", "constants.side.value").stdout
        self.assertRegex(said, r"Slopes of constants.push.value at limit and branch points.*\n  branch +11\.\d+ +by rods.arch.section.radius +2\d+\.\d+ \(N/m\)/m\n  branch +11\.\d+ +by constants.side.value +none\n")
        limits = [float(self.critical(f"limit{radius}", "--set", f"{RADIUS}={radius}", "--by", MODULUS, "--of", "centre_z")[1]["value"]) for radius in (0.01999, 0.02001)]
        slope = (limits[1] - limits[0]) / 2e-5
        self.assertLess(abs(float(rows[1][RADIUS]) - slope), 1e-5 * slope)
        # In a short range the branch point is located to more digits.
        near = ("--from", float(rows[0]["value"]) - 0.1, "--step", 0.005, "--by", RADIUS, "--of", "centre_z")
        branches = []
        for radius in (0.01996, 0.02, 0.02004):
            self.solve("path", f"near{radius}", "--along", PUSH, "--to", float(rows[0]["value"]) + 0.1, *near, "--set", f"{RADIUS}={radius}", text=ARCH)
            branches.append(next(iter(self.rows(f"near{radius}", "critical_slopes.csv"))))
        at = [float(branch[f"{PUSH}[N/m]"]) for branch in branches]
        slope = (at[2] - at[0]) / 8e-5
        self.assertLess(abs(float(branches[1][f"d({PUSH})/d({RADIUS})[(N/m)/m]"]) - slope), 2e-5 * slope)

    def test_a_limit_point_of_loads_without_potential(self):
        """Its left null vector is another than the right one."""
        pushed = ARCH + '[[load]]\nkind = "formula"\nforce = ["0.6 - 20*x", "0", "0.5*z"]\n[[load]]\nkind = "formula"\nforce = ["3*z", "0", "0"]\n'
        by = ("--by", RADIUS, "--by", "constants.side.value", "--of", "centre_z")
        rows = [row for row in self.critical("pushed", *by, text=pushed, points=30) if row["place"] == "limit"]
        self.assertEqual({row["negative"] for row in self.rows("pushed", "path.csv")}, {"-1"})
        limits = [float([row for row in self.critical(f"pushed{radius}", *by, "--set", f"{RADIUS}={radius}", text=pushed, points=30) if row["place"] == "limit"][0]["value"])
                  for radius in (0.01999, 0.02001)]
        slope = (limits[1] - limits[0]) / 2e-5
        self.assertLess(abs(float(rows[0][RADIUS]) - slope), 1e-5 * abs(slope))

    def test_slopes_of_a_path_that_is_cut_off(self):
        words = ("--along", PUSH, "--to", 60, "--by", RADIUS, "--of", "centre_z")
        self.solve("path", "whole", *words, "--points", 15, text=ARCH)
        for points in (4, 5, 6, 12, 15):
            self.solve("path", "parts", *words, "--points", points, *["--restart"] * (points > 4), text=ARCH)
        for name in ("path.csv", "slopes.csv", "critical_slopes.csv"):
            self.assertEqual((self.directory / "parts" / name).read_bytes(), (self.directory / "whole" / name).read_bytes(), name)
        said = self.solve("path", "parts", *words[:4], "--points", 20, "--restart", text=ARCH, expect=2).stderr
        self.assertIn('--by ["rods.arch.section.radius"], not []', said)
        for wrong, message in ((("--of", "centre_z"), "--of names observables"), (("--by", RADIUS, "--of", "centre_w"), "'centre_w' is no observable"),
                               (("--by", "rods.arch.shape.elements"), "is a whole number"), (("--by", "rods.arc.section.radius"), "is no number of")):
            self.assertIn(message, self.solve("path", "wrong", *words[:4], *wrong, text=ARCH, expect=2).stderr)
            self.assertFalse((self.directory / "wrong").exists(), wrong)

    def test_a_branch_goes_on_from_it(self):
        self.solve("equilibrium", "rest")
        self.skein_says("branch", self.directory / "rest", self.directory / "on", "--set", "time.duration=1e-3", "--set", "output.series=1e-3", "--set", "start.time=zero")
        self.skein_says("run", self.directory / "on", "--threads", 1)
        rest, on = self.series("rest"), numpy.atleast_1d(self.series("on"))
        self.assertLess(abs(on["tip_zm"][-1] - rest["tip_zm"][-1]), 1e-9)

    def test_bits_are_those_of_any_layout(self):
        for command, text, first in (("equilibrium", BODIES, "rest"), ("modes", BODIES, "swings"), ("modes", DAMPED, "decays")):
            self.solve(command, first, text=text)
            for ranks, threads in ((1, 2), (2, 1), (4, 1), (2, 2)):
                out = f"{first}{ranks}x{threads}"
                self.solve(command, out, text=text, ranks=ranks, threads=threads)
                self.assertEqual(self.digest(out), self.digest(first), out)
                for name in ("observables.csv", "modes.csv") if command == "modes" else ("observables.csv",):
                    self.assertEqual(self.rows(out, name), self.rows(first, name), f"{name} of {out}")
        self.solve("path", "path1")
        self.solve("path", "path2", threads=2)
        self.assertEqual(self.rows("path1", "path.csv"), self.rows("path2", "path.csv"))

    def test_a_path_that_is_cut_off_goes_on(self):
        """By the points it may have, at any point: between a critical point and the end of its step, at a branch point that it leaves, on the
        branch; the same files, bit for bit."""
        words = ("--along", "load.0.end.2", "--to", -0.03, "--branch", 1, "--points", 60, "--set", "load.0.end=[0, 0, -0.004]")
        self.solve("path", "whole", *words, text=COLUMN)
        places = [row["place"] for row in self.rows("whole", "path.csv")]
        branch = places.index("branch") + 1
        self.assertEqual(places[-1], "end")
        for points in (1, 2, branch - 1, branch, branch + 1, branch + 4, 60):
            self.solve("path", "parts", *words[:6], "--points", points, *words[8:], *["--restart"] * (points > 1), text=COLUMN)
        for name in ("path.csv", "observables.csv"):
            self.assertEqual((self.directory / "parts" / name).read_bytes(), (self.directory / "whole" / name).read_bytes(), name)
        self.assertEqual(self.digest("parts"), self.digest("whole"))
        mine, theirs = self.frames("parts", "trajectory"), self.frames("whole", "trajectory")
        self.assertEqual(mine.keys(), theirs.keys())
        for name in mine:
            self.assertTrue(numpy.array_equal(mine[name], theirs[name]), name)

    def test_a_path_that_was_stopped_goes_on(self):
        """By a signal, after some points."""
        words = ("--along", "load.0.end.2", "--to", -0.03, "--step", 0.002, "--points", 300)
        self.scene.write_text(COLUMN)
        command = [SKEIN, "path", self.scene, "--out", self.directory / "stopped", "--threads", 1, *words]
        running = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True)
        rows = self.directory / "stopped/observables.csv"
        while running.poll() is None and not (rows.exists() and rows.read_text().count("\n") > 4):
            time.sleep(0.001)
        running.terminate()
        said = running.communicate(timeout=100)[0]
        self.assertEqual(running.returncode, 3, said)
        self.assertIn("The path ends: it was stopped\nThe same command with --restart continues from there.\n", said)
        self.solve("path", "stopped", *words, "--restart", text=COLUMN)
        self.solve("path", "whole", *words, text=COLUMN)
        self.assertEqual((self.directory / "stopped/path.csv").read_bytes(), (self.directory / "whole/path.csv").read_bytes())
        self.assertEqual(self.digest("stopped"), self.digest("whole"))

    def test_paths_that_do_not_go_on(self):
        words = ("--along", "load.0.end.2", "--to", -0.03)

        def said(*more, out="path", text=COLUMN):
            return self.solve("path", out, *words, *more, "--restart", text=text, expect=2).stderr

        self.assertIn("holds no path to continue", said())
        self.solve("path", "path", *words, "--points", 3, text=COLUMN)
        self.assertIn("the path has its 3 points; --points allows more", said("--points", 3))
        self.assertIn("the path has --from -0.004, not -0.005; a path continues as it began", said("--from", -0.005))
        self.assertIn("--step 0.05, not 0.1", said("--step", 0.1))
        self.assertIn("excludes", said("--overwrite"))
        self.assertIn("/rods/0/section/radius: was 0.01, now 0.011", said(text=COLUMN.replace("radius = 0.01", "radius = 0.011")))
        record = self.directory / "path/path_state.json"
        whole = record.read_text()
        record.write_text(whole[: len(whole) // 2])
        self.assertIn("is damaged", self.solve("path", "path", *words, "--restart", text=COLUMN, expect=5).stderr)
        record.write_text(whole)
        table = self.directory / "path/path.csv"
        rows = table.read_text()
        table.write_text(rows + "1,2,3\n")
        self.assertIn("is not as the path left it", self.solve("path", "path", *words, "--restart", text=COLUMN, expect=5).stderr)
        table.write_text(rows)
        self.solve("path", "path", *words, "--restart", text=COLUMN)
        self.assertIn("the path is complete", said())


if __name__ == "__main__":
    unittest.main()
