"""Figures of contacts and walls in the rows, tables and frames of solutions: those of the state at rest, on any number of ranks."""

import csv
import json
import pathlib
import unittest

import numpy

from driver import DriverTest
from paraview_test import read_vtp
from resting_test import FALLS, FRAME, HANGERS, LIES

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
STACK = (APPS / "gallery/stack.toml").read_text()
BLOCK, STIFFNESS = 0.0648 * 9.81, 1e5  # N, N/m
AT_REST = ("contacts[-]", "touching_pairs[-]", "coordination[-]", "max_overlap[-]", "contact_energy[J]", "floor_force[N]", "wall_contacts[-]", "wall_overlap[-]", "wall_energy[J]")
OF_STEPS = ("contact_friction_work[J]", "contact_viscous_work[J]", "wall_friction_work[J]", "wall_viscous_work[J]", "candidates[-]", "rebuilds[-]", "skin[m]")

# A rod that is held at its ends over a ball on a soft floor.
PRESSED = """
[time]
duration = 1.0
[[rods]]
name = "rod"
start = "clamped"
end = "clamped"
material = {density = 1000.0, youngs_modulus = 1e7}
section.radius = 2e-3
shape = {length = 0.1, elements = 10}
placement = {origin = [0.001, -0.05, 0.0118], tangent = [0.0, 1.0, 0.0], normal = [1.0, 0.0, 0.0]}
[[bodies]]
name = "ball"
density = 1000.0
spheres.radii = [0.005]
placement.origin = [0.0, 0.0, 0.005]
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]
[contact]
stiffness = 1e3
law = "linear"
FRICTION
[[wall]]
name = "floor"
kind = "plane"
law = "linear"
stiffness = 1e3
FRICTION
[output]
series = 1.0
trajectory = 1.0
"""
STICKS, SMOOTH = PRESSED.replace("FRICTION", 'friction = "memory"\nstatic_friction = 3.0'), PRESSED.replace("FRICTION", "")

# A clamp turns the end of a rod, a motor that of another one.
TURNED = """
[time]
duration = 1.0
[[rods]]
name = "turned"
start = "clamped"
end = "clamped"
start_motion = {rotation_amplitude = [0.5, 0.0, 0.0], period = 4.0}
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 2e-3
shape = {length = 0.1, elements = 8}
[[rods]]
name = "driven"
end = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 2e-3
shape = {length = 0.1, elements = 8}
placement = {origin = [0.1, 0.0, 0.0], normal = [1.0, 0.0, 0.0]}
[[joint]]
kind = "hinge"
between = ["driven", "world"]
place = [0.1, 0.0, 0.0]
axis = [1.0, 0.0, 0.0]
stiffness = 1e4
torsional_stiffness = 10.0
motor = {kind = "position", value = "0.3*sin(rate*t)", stiffness = 1e-2, damping = 0.0}
[constants]
rate = {value = 1.0, unit = "1/s"}
[output]
series = 1.0
"""


class RestFigures(DriverTest):
    def rows(self, out, name="observables.csv"):
        with (self.directory / out / name).open(newline="") as file:
            return list(csv.DictReader(file))

    def solve(self, out, *arguments, text, command="equilibrium", **layout):
        self.solve_scene(command, out, *arguments, text=text, **layout)
        return self.rows(out)[-1]

    def after(self, out, text):
        """The scene from the checkpoint of a directory on."""
        return f'{text}\n[start]\nfrom = "{self.directory / out}"\ntime = "zero"\n'

    def test_figures_are_those_of_the_first_step_from_there(self):
        """Bit for bit, as a step from rest finds bodies where they are; sums over steps have no value."""
        self.scene.write_text(HANGERS)
        self.skein_says("run", self.scene, "--out", self.directory / "run", "--threads", 1)
        scenes = {"rod on a slope": LIES, "ball in a frame": FRAME, "sticks in a tube": FALLS.replace("trajectory = 1.0", "series = 1.0"), "blocks": STACK, "hangers": self.after("run", HANGERS), "pressed ball": STICKS, "smooth ball": SMOOTH}
        seen = set()
        for number, (name, text) in enumerate(scenes.items()):
            plain = HANGERS if name == "hangers" else text
            known = self.solve(f"rest_{number}_1", text=text)
            columns = [column for column in AT_REST if column in known]
            seen.update(column for column in columns if float(known[column]) != 0)
            for column in OF_STEPS:
                self.assertEqual(known.get(column, "nan"), "nan", (name, column))
            for ranks in (1, 2, 3):
                out, on = f"rest_{number}_{ranks}", f"on_{number}_{ranks}"
                if ranks > 1:
                    self.assertEqual(self.solve(out, text=text, ranks=ranks), known, (name, ranks))
                self.scene.write_text(self.after(out, plain))
                self.skein_says("run", self.scene, "--out", self.directory / on, "--threads", 1, "--steps", 1, ranks=ranks)
                row = self.rows(on)[-1]
                self.assertEqual({column: row[column] for column in columns}, {column: known[column] for column in columns}, (name, ranks))
                for column in OF_STEPS:
                    self.assertNotEqual(row.get(column, "0"), "nan")
        self.assertEqual(seen, set(AT_REST))

    def test_a_stack_has_the_figures_of_its_springs(self):
        row = self.solve("stack", text=STACK)
        # Faces push with both springs of a contact, the floor with one at each of four corners.
        deepest = 2 * BLOCK / (2 * STIFFNESS)
        expected = {
            "contacts[-]": 2,
            "coordination[-]": 4 / 3,
            "max_overlap[-]": deepest / 4e-3,
            "contact_energy[J]": (BLOCK**2 + (2 * BLOCK) ** 2) / (2 * 2 * STIFFNESS),
            "floor_force[N]": 3 * BLOCK,
            "wall_contacts[-]": 4,
            "wall_overlap[-]": 3 * BLOCK / (4 * STIFFNESS) / 4e-3,
            "wall_energy[J]": (3 * BLOCK) ** 2 / (2 * 4 * STIFFNESS),
        }
        for column, value in expected.items():
            self.assertLess(abs(float(row[column]) - value), 1e-6 * value, column)
        largest = self.summary("stack")["largest_overlap"]
        self.assertLess(abs(largest["rods"] - expected["max_overlap[-]"]), 1e-6 * largest["rods"])
        self.assertLess(abs(largest["wall floor"] - expected["wall_overlap[-]"]), 1e-6 * largest["wall floor"])
        self.assertIsNone(self.summary("stack")["observables"]["contact_friction_work[J]"])

    def test_a_solution_is_no_relaxation(self):
        """Which its summary would say had not settled."""
        text = """
[time]
duration = 20000.0
relax = true
[[rods]]
name = "arm"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 2e-3
shape = {length = 0.1, elements = 8}
[[load]]
kind = "end_force"
end = [1e-3, 0.0, 0.0]
"""
        self.scene.write_text(text)
        self.skein_says("run", self.scene, "--out", self.directory / "run", "--threads", 1)
        self.assertTrue(self.summary("run")["relaxation"]["settled"])
        self.solve_scene("equilibrium", "rest", text=text)
        self.assertNotIn("relaxation", self.summary("rest"))

    def test_the_start_has_figures_too(self):
        self.solve("start", text=SMOOTH)
        start = self.rows("start")[0]
        overlap = 0.007 - numpy.hypot(0.001, 0.0118 - 0.005)
        self.assertLess(abs(float(start["max_overlap[-]"]) - overlap / 4e-3), 1e-9)
        self.assertLess(abs(float(start["contact_energy[J]"]) - 0.5 * 1e3 * overlap**2), 1e-6 * 0.5 * 1e3 * overlap**2)
        self.assertEqual(float(start["contact_friction_work[J]"]), 0)

    def test_tables_and_frames_have_the_forces(self):
        """A ball under a smooth rod: what the rod presses with is what the floor carries beyond its weight."""
        for ranks in (1, 2):
            out = f"table_{ranks}"
            row = self.solve(out, "--set", "output.contacts=1.0", "--set", "output.paraview=vtp", text=SMOOTH.replace("0.001, -0.05", "0.0, -0.05"), ranks=ranks)
            (table,) = sorted((self.directory / out).glob("contacts_*.csv"))
            with table.open(newline="") as file:
                lines = list(csv.DictReader(file))
            pressed = sum(abs(float(line["force_z[N]"])) for line in lines)
            carried = float(row["floor_force[N]"]) - 1000 * 4 / 3 * numpy.pi * 0.005**3 * 9.81
            self.assertGreater(pressed, 0)
            self.assertLess(abs(pressed - carried), 1e-6 * pressed)
            self.assertEqual(len(lines), float(row["touching_pairs[-]"]))
            frame = read_vtp(sorted((self.directory / out).glob("**/rods_*.vtp"))[-1])
            on_rod = frame["PointData", "contact_force"][:11]
            self.assertLess(abs(on_rod[:, 2].sum() - pressed), 1e-6 * pressed)

    def test_points_of_a_path_are_equilibria(self):
        key = "load.0.acceleration.2"
        self.solve("path", "--along", key, "--to", -12.0, "--points", 4, text=SMOOTH, command="path")
        points = self.rows("path", "path.csv")
        self.assertEqual([row["contact_energy[J]"] for row in self.rows("path")[1:]], [point["contact_energy[J]"] for point in points])
        for point in points:
            row = self.solve(f"at{point['point']}", "--set", f"{key}={point[f'{key}[m/s^2]']}", text=SMOOTH)
            for column in ("max_overlap[-]", "contact_energy[J]", "floor_force[N]", "wall_energy[J]"):
                self.assertLess(abs(float(point[column]) - float(row[column])), 1e-7 * float(row[column]), column)

    def test_modes_stretch_springs(self):
        """A swing and its mirror image have the figures of rest where they pass it, with springs of friction as well."""
        row = self.solve("modes", "--count", 3, "--movies", 1, text=STICKS, command="modes")
        swing = [float(one["contact_energy[J]"]) for one in self.rows("modes/mode_1")[1:]]
        rest = float(row["contact_energy[J]"])
        self.assertEqual(len(swing), 24)
        for passes in (swing[11], swing[23]):
            self.assertLess(abs(passes - rest), 1e-9 * rest)
        self.assertGreater(max(swing), rest)

    def test_figures_have_the_time_of_the_solution(self):
        """Energies of a clamp and a motor that turn with time, by --time as in a scene that ends then."""
        text = TURNED
        by_time, by_end = self.solve("by_time", "--time", 0.4, text=text), self.solve("by_end", "--set", "time.duration=0.4", "--set", "output.series=0.4", text=text)
        for column in ("elastic_bend[J]", "joint_energy[J]"):
            self.assertGreater(float(by_end[column]), 0)
            self.assertLess(abs(float(by_time[column]) - float(by_end[column])), 1e-6 * float(by_end[column]), column)

    def test_slopes_are_those_of_equilibria(self):
        """Energies of all springs: those of friction go on from where they are."""
        key, value, step = "load.0.acceleration.2", -9.81, 1e-2
        for text in (SMOOTH, STICKS):
            self.scene.write_text(text)
            found = json.loads(self.skein_says("gradient", self.scene, "--by", key, "--json").stdout)
            slopes = found["numbers"][0]["slopes"]
            here = self.solve(f"here{text == SMOOTH}", text=text)
            at = {}
            for side in (-1, 1):
                begun = text if text == SMOOTH else self.after(f"here{text == SMOOTH}", text)
                at[side] = self.solve(f"{side}{text == SMOOTH}", "--set", f"{key}={value + side * step}", text=begun)
            for column in ("contact_energy[J]", "wall_energy[J]", "max_overlap[-]", "floor_force[N]", "potential[J]"):
                difference = (float(at[1][column]) - float(at[-1][column])) / (2 * step)
                self.assertLess(abs(found["values"][column] - float(here[column])), 1e-12 + 1e-9 * abs(float(here[column])), column)
                self.assertNotEqual(difference, 0)
                self.assertLess(abs(slopes[column] - difference), 1e-4 * abs(difference), (column, text == SMOOTH))
            self.assertEqual(slopes["contacts[-]"], 0)
            self.assertIsNone(slopes["contact_friction_work[J]"])

    def test_slopes_and_fits_begin_with_a_checkpoint(self):
        """Rods that a run has hung upon each other: from the scene's start they do not come to rest there."""
        self.scene.write_text(HANGERS)
        self.skein_says("run", self.scene, "--out", self.directory / "run", "--threads", 1)
        key, value, step = "load.0.acceleration.1", 0.1, 2e-4
        begun = self.after("run", HANGERS)
        self.scene.write_text(begun)
        found = json.loads(self.skein_says("gradient", self.scene, "--by", key, "--json").stdout)
        here = self.solve("here", text=begun)
        at = {side: self.solve(f"at{side}", "--set", f"{key}={value + side * step}", text=self.after("here", HANGERS)) for side in (-1, 1)}
        self.assertEqual(found["values"]["kinetic_translation[J]"], 0)
        for column in ("centre_y[m]", "elastic_bend[J]", "contact_energy[J]", "max_overlap[-]"):
            difference = (float(at[1][column]) - float(at[-1][column])) / (2 * step)
            self.assertLess(abs(found["values"][column] - float(here[column])), 1e-9 * abs(float(here[column])), column)
            self.assertLess(abs(found["numbers"][0]["slopes"][column] - difference), 1e-3 * abs(difference), column)
        # A fit goes on from the same springs for each row: what is measured is what an equilibrium has.
        data = self.directory / "data.csv"
        rows = [f"{value + side * step},{at_side['centre_y[m]']}" for side, at_side in ((side, self.solve(f"fit{side}", "--set", f"{key}={value + side * step}", text=begun)) for side in (-1, 0, 1))]
        data.write_text("\n".join([f"{key},centre_y[m]", *rows]) + "\n")
        self.scene.write_text(begun)
        number = "rods.above.material.youngs_modulus"
        done = self.skein_says("fit", self.scene, data, "--number", number, "--set", f"{number}=1.001e6", "--json")
        self.assertLess(abs(json.loads(done.stdout)["numbers"][0]["value"] - 1e6), 10)

    def test_an_end_that_was_caught_has_no_slopes(self):
        """A branch holds an end where a run has brought it, and no number of the scene places it there."""
        free = SMOOTH.replace('end = "clamped"\n', "").replace("1e7", "1e6")
        self.solve("bent", text=free)
        self.scene.write_text(self.after("bent", SMOOTH.replace("1e7", "1e6")))
        done = self.skein_says("gradient", self.scene, "--by", "rods.rod.material.youngs_modulus", expect=2)
        self.assertIn("elsewhere than the scene places it", done.stderr)

    def test_a_fit_has_energies_of_contacts(self):
        rows = []
        for force in (-9.0, -10.0, -11.0):
            row = self.solve(f"fit{force}", "--set", f"load.0.acceleration.2={force}", text=SMOOTH)
            rows.append(f"{force},{row['contact_energy[J]']}")
        data = self.directory / "data.csv"
        data.write_text("\n".join(["load.0.acceleration.2,contact_energy[J]", *rows]) + "\n")
        self.scene.write_text(SMOOTH)
        key = "contact.stiffness"
        done = self.skein_says("fit", self.scene, data, "--number", key, "--set", f"{key}=1.2e3", "--json")
        self.assertLess(abs(json.loads(done.stdout)["numbers"][0]["value"] - 1e3), 1e-3)
        data.write_text("load.0.acceleration.2,contact_friction_work[J]\n-9,0.0\n-10,0.0\n-11,0.0\n")
        done = self.skein_says("fit", self.scene, data, "--number", key, expect=2)
        self.assertIn("has no value at rest", done.stderr)


if __name__ == "__main__":
    unittest.main()
