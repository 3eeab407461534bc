"""Friction at rest as users meet it: sticks to its limit, goes on from the springs of a run, and stays at rest when stepped on."""

import csv
import json
import math
import pathlib
import unittest

import h5py
import numpy

from driver import DriverTest

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
RADIUS, STIFFNESS, SHARE, NODES = 2e-3, 100.0, 0.8, 7
LIES = f"""
[time]
duration = 1.0
[[rods]]
name = "rod"
material = {{density = 1000.0, youngs_modulus = 1e8}}
section.radius = {RADIUS}
shape = {{length = 0.05, elements = {NODES - 1}}}
placement = {{origin = [0.0, 0.0, {RADIUS - 1e-7}], tangent = [0.0, 1.0, 0.0], normal = [1.0, 0.0, 0.0]}}
[[load]]
kind = "gravity"
acceleration = [0.0, 1.0, -9.0]
[[wall]]
name = "floor"
kind = "plane"
law = "linear"
stiffness = {STIFFNESS}
tangential_share = {SHARE}
friction = "memory"
static_friction = 0.4
[[probe]]
name = "end"
of = "rod"
[output]
series = 1.0
"""
WEIGHT = 1000 * numpy.pi * RADIUS**2 * 0.05  # kg

# A soft rod that is pulled along a floor by its start.
PULL = "rods.rod.start_motion.amplitude.1"
PULLED = f"""
[time]
duration = 1.0
[[rods]]
name = "rod"
start = "clamped"
start_motion = {{amplitude = [0.0, 1e-5, 0.0], period = 4.0}}
material = {{density = 1000.0, youngs_modulus = 1e6}}
section.radius = {RADIUS}
shape = {{length = 0.5, elements = 10}}
placement = {{origin = [0.0, 0.0, {RADIUS - 6e-6}], tangent = [0.0, 1.0, 0.0], normal = [1.0, 0.0, 0.0]}}
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]
[[wall]]
name = "floor"
kind = "plane"
law = "linear"
stiffness = 1e3
friction = "memory"
static_friction = 0.4
[[probe]]
name = "end"
of = "rod"
[output]
series = 1.0
trajectory = 1.0
"""
LAG = 0.4 * 1000 * 9.81 * 0.5**2 / (2 * 1e6)  # by which a rod is longer whose floor pulls it back everywhere

CROSSING_RADIUS = 1.5e-3


def crossing_rods(layers, softer):
    """Layers of ten rods that are held at one end, turned by 20 degrees to either side in turn, and a twentieth of a diameter apart."""
    text = """
[time]
duration = 1.0
[[load]]
kind = "gravity"
[contact]
law = "linear"
stiffness = "auto"
[output]
trajectory = 1.0
precision = "double"
"""
    for i in range(layers):
        angle = math.radians(20 if i % 2 == 0 else -20)
        for j in range(10):
            y = (j - 4.5) * 0.015 - 0.1 * math.sin(angle)
            text += f"""
[[rods]]
name = "rod{10 * i + j}"
start = "clamped"
material = {{density = 1000.0, youngs_modulus = {3e8 * softer**i}}}
section.radius = {CROSSING_RADIUS}
shape = {{length = 0.2, elements = 20}}
placement = {{origin = [0.0, {y}, {i * 2.1 * CROSSING_RADIUS}], tangent = [{math.cos(angle)}, {math.sin(angle)}, 0.0]}}
"""
    return text


def gaps_where_crossed(low, high):
    """Heights of one polyline over another where they cross in the plan."""
    p, q = low[:-1, None], high[None, :-1]
    a, b = low[1:, None] - p, high[None, 1:] - q
    across = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    r = q - p
    s = (r[..., 0] * b[..., 1] - r[..., 1] * b[..., 0]) / across
    t = (r[..., 0] * a[..., 1] - r[..., 1] * a[..., 0]) / across
    met = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    return (q[..., 2] + t * b[..., 2] - p[..., 2] - s * a[..., 2])[met]


# Two bent rods hang like hangers on two held ones. Weight pulls them along, and they slide until friction holds them.
HANGERS = """
[time]
duration = 1.3
[[rods]]
name = "below"
start = "clamped"
end = "clamped"
material = {density = 1000.0, youngs_modulus = 1e8}
section.radius = 2e-3
shape = {length = 0.05, elements = 6}
placement = {kind = "list", origins = [[-0.01, -0.025, 0], [0.01, -0.025, 0]], tangents = [[0, 1, 0], [0, 1, 0]], normals = [[1, 0, 0], [1, 0, 0]]}
[[rods]]
name = "above"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 2e-3
shape = {length = 0.06, elements = 9, rest_curvature = [0, 20, 0]}
placement = {kind = "list", origins = [[-0.028, -0.01, -0.0034], [-0.03, 0.01, -0.0034]], tangents = [[0.825, 0, 0.565], [0.825, 0, 0.565]], normals = [[0.565, 0, -0.825], [0.565, 0, -0.825]]}
[[load]]
kind = "gravity"
acceleration = [0.8, 0.1, -9.81]
[[damping]]
kind = "uniform"
rate = 40.0
[contact]
stiffness = 1e3
damping = 0.2
law = "linear"
friction = "memory"
static_friction = 0.3
tangential_damping = 0.2
[output]
trajectory = 1.0
series = 0.02
"""

# Sticks in the air above a floor, in a tube.
FALLS = """
[time]
duration = 1.0
[[rods]]
name = "sticks"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 2e-3
shape = {length = 0.05, elements = 6}
placement = {kind = "packing", count = 8, seed = 1, region = "cylinder", point = [0.0, 0.0, 2e-3], radius = 0.04, height = 0.06}
[[load]]
kind = "gravity"
[contact]
stiffness = "auto"
[[wall]]
name = "floor"
kind = "plane"
stiffness = "auto"
[[wall]]
name = "side"
kind = "tube"
radius = 0.05
stiffness = "auto"
[output]
trajectory = 1.0
"""


# A ball in the hole of a frame of four stiff rods.
FRAME = """
[time]
duration = 1.0
[[rods]]
name = "rails"
start = "clamped"
end = "clamped"
material = {density = 1000.0, youngs_modulus = 1e10}
section.radius = 0.005
shape = {length = 0.016, elements = 5}
placement = {kind = "list", origins = [[-0.021, -0.008, 0], [0.021, -0.008, 0], [-0.008, -0.021, 0], [-0.008, 0.021, 0]], tangents = [[0, 1, 0], [0, 1, 0], [1, 0, 0], [1, 0, 0]], normals = [[1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0]]}
[[bodies]]
name = "ball"
density = 1000.0
spheres.radii = [0.02]
placement.origin = [0.0, 0.0, 0.0135]
[[load]]
kind = "gravity"
[contact]
stiffness = 1e3
law = "linear"
friction = "memory"
static_friction = 0.3
[[probe]]
name = "ball"
of = "ball"
[output]
series = 1.0
"""


class Resting(DriverTest):
    def solve(self, out, *arguments, command="equilibrium", text=LIES, **layout):
        return self.solve_scene(command, out, *arguments, text=text, **layout)

    def places(self, out):
        """Of all nodes in the last frame."""
        with h5py.File(sorted((self.directory / out).glob("trajectory_*.h5"))[-1]) as file:
            return numpy.concatenate([file["groups"][f"{group}/position"][-1].reshape(-1, 3) for group in ("below", "above")])

    def test_a_slope_holds_up_to_friction(self):
        self.solve("holds")
        rows = self.series("holds")
        # Springs of all nodes share the weight along the slope; its moment about the floor tilts the rod upon the normal springs.
        spacing = 0.05 / (NODES - 1)
        squares = spacing**2 * sum((i - (NODES - 1) / 2) ** 2 for i in range(NODES))
        way = WEIGHT * 1.0 * (1 / (NODES * SHARE * STIFFNESS) + RADIUS**2 / (STIFFNESS * squares))
        moved = rows["end_ym"][-1] - rows["end_ym"][0]
        self.assertLess(abs(moved - way), 1e-3 * way)
        self.solve("limit", "--set", "load.0.acceleration=[0.0, 3.59, -9.0]")
        done = self.solve("slides", "--set", "load.0.acceleration=[0.0, 3.7, -9.0]", expect=4)
        self.assertIn("no equilibrium", done.stderr)
        self.assertNotIn("at the start", done.stderr)
        steep = ("--set", "load.0.acceleration=[0.0, 3.7, -9.0]")
        self.skein_says("run", self.scene, *steep, "--set", "time.duration=0.1", "--set", "output.series=0.1", "--out", self.directory / "slid", "--threads", 1)
        done = self.solve("after", *steep, text=f'[start]\nfrom = "{self.directory / "slid"}"\n' + LIES, expect=4)
        self.assertRegex(done.stderr, r"at the start 'rod' moves at 0\.0\d+ m/s: a longer or more damped run")

    def test_stability_is_that_of_contacts_that_stick(self):
        done = self.solve("stable", "--stable")
        self.assertIn("Stability: stable, by the symmetric part", done.stdout)
        self.solve("modes", "--count", 3, command="modes")

    def rows(self, out, name):
        with open(self.directory / out / name, newline="") as file:
            return list(csv.DictReader(file))

    def pull(self, out, to, *arguments):
        """Pull and place of the free end at the points of a path."""
        self.solve(out, "--along", PULL, "--to", to, *arguments, command="path", text=PULLED)
        rows = self.rows(out, "path.csv")
        return numpy.array([float(row[f"{PULL}[m]"]) for row in rows]), numpy.array([float(row["end_y[m]"]) for row in rows]) - 0.5

    def test_a_rod_that_is_pulled_sticks_and_then_slides(self):
        """Up to the pull at which friction acts along all of it, its end stays; then it follows, longer by LAG."""
        pull, end = self.pull("pulled", 2e-3, "--points", 300)
        self.assertEqual(pull[-1], 2e-3)
        self.assertLess(numpy.abs(end[pull < 0.8 * LAG]).max(), 0.02 * LAG)
        slides = pull > 1.1 * LAG
        self.assertGreater(slides.sum(), 2)
        self.assertLess(numpy.abs(pull - end - LAG)[slides].max(), 0.02 * LAG)

        for step in (0.02, 0.5):  # friction in one direction does not depend on the steps
            self.assertLess(abs(self.pull(f"by{step}", 2e-3, "--points", 300, "--step", step)[1][-1] - end[-1]), 1e-9)
        # On the way back friction turns from the pulled end on. The free end stays for a way of 2 LAG.
        back = PULLED.replace("1e-5", "2e-3")
        start = f'[start]\nfrom = "{self.directory / "pulled"}"\n'
        self.solve("back", "--along", PULL, "--to", 1.2e-3, command="path", text=start + back)
        returned = float(self.rows("back", "path.csv")[-1]["end_y[m]"]) - 0.5
        self.assertLess(abs(returned - end[-1]), 2e-3 * LAG)

    def test_a_path_of_a_load_ends_where_friction_does(self):
        """A rod on a slope: nothing balances a weight along it of more than 0.4 of that across it."""
        done = self.solve("steeper", "--along", "load.0.acceleration.1", "--to", 4.0, "--json", command="path", text=LIES)
        found = json.loads(done.stdout)
        self.assertFalse(found["complete"])
        self.assertLess(abs(found["points"][-1]["value"] - 3.6), 1e-3)

    def test_a_path_with_friction_goes_on_with_its_springs(self):
        """A path in parts has the bits of one in one piece; bodies stay where a path leaves them."""
        self.pull("whole", 1e-3, "--points", 40)
        self.pull("parts", 1e-3, "--points", 3)
        self.pull("parts", 1e-3, "--points", 40, "--restart")
        for name in ("path.csv", "observables.csv"):
            self.assertEqual((self.directory / "parts" / name).read_bytes(), (self.directory / "whole" / name).read_bytes(), name)
        end = float(self.rows("whole", "path.csv")[-1]["end_y[m]"])
        start = f'[start]\nfrom = "{self.directory / "whole"}"\n'
        self.solve("stays", "--set", f"{PULL}=1e-3", text=start + PULLED)
        self.assertLess(abs(self.series("stays")["end_ym"][-1] - end), 1e-9)
        done = self.solve("branch", "--along", PULL, "--to", 1e-3, "--branch", 1, command="path", text=PULLED, expect=2)
        self.assertIn("depend on the way there", done.stderr)

    def test_slopes_are_those_of_springs_that_hold(self):
        """Of contacts that stick, those of equilibria that go on from the same springs; where they slip, there are none."""
        key = "load.0.acceleration.1"
        self.scene.write_text(LIES)
        done = self.skein_says("gradient", self.scene, "--by", key, "--json")
        found = json.loads(done.stdout)
        self.assertTrue(found["contacts_stick"])
        self.solve("here")
        at = {}
        for value in (0.99, 1.01):
            self.solve(f"at{value}", "--set", f"{key}={value}", text=f'[start]\nfrom = "{self.directory / "here"}"\n' + LIES)
            at[value] = self.series(f"at{value}")["end_ym"][-1]
        slope, difference = found["numbers"][0]["slopes"]["end_y[m]"], (at[1.01] - at[0.99]) / 0.02
        self.assertLess(abs(slope - difference), 1e-4 * abs(difference))
        self.scene.write_text(PULLED)
        done = self.skein_says("gradient", self.scene, "--by", PULL, "--set", f"{PULL}=1e-4", expect=4)
        self.assertIn("slips at its limit", done.stderr)

    def test_a_fit_finds_the_springs_of_friction(self):
        rows = []
        for pull in (0.5, 1.0, 1.5):
            self.solve(f"fit{pull}", "--set", f"load.0.acceleration.1={pull}")
            rows.append(f"{pull},{float(self.series(f'fit{pull}')['end_ym'][-1])!r}")
        data = self.directory / "data.csv"
        data.write_text("\n".join(["load.0.acceleration.1,end_y[m]", *rows]) + "\n")
        key = "wall.floor.tangential_share"
        self.scene.write_text(LIES)
        done = self.skein_says("fit", self.scene, data, "--number", key, "--set", f"{key}=0.6", "--json")
        self.assertLess(abs(json.loads(done.stdout)["numbers"][0]["value"] - SHARE), 1e-6)

    def test_other_friction_is_zero_at_rest(self):
        slips = LIES.replace('friction = "memory"\nstatic_friction = 0.4', 'friction = "regularised"\nkinetic_friction = 0.4\nslip_speed = 1e-3')
        done = self.solve("slips", text=slips, expect=4)
        self.assertIn("zero at rest", done.stderr)
        self.assertRegex(done.stderr, r"nothing balances the loads on the translation along \(-?\S+, 1, -?\S+\)")

    def test_a_solution_goes_on_from_a_run_and_a_run_from_it(self):
        self.scene.write_text(HANGERS)
        self.skein_says("run", self.scene, "--out", self.directory / "run", "--threads", 1)
        start = f'[start]\nfrom = "{self.directory / "run"}"\n'
        told = json.loads(self.solve("rest", "--json", text=start + HANGERS).stdout)
        self.assertLess(told["residual"], 1e-9)
        moved = numpy.linalg.norm(self.places("rest") - self.places("run"), axis=1).max()
        self.assertLess(moved, 1e-3 * RADIUS, "the run had settled")
        without = self.solve("without", text=start + HANGERS.replace('friction = "memory"\nstatic_friction = 0.3\ntangential_damping = 0.2', ""), expect=4)
        self.assertIn("leaves, as nothing stops it", without.stderr)
        self.assertNotIn("at the start", without.stderr, "the run had settled")
        self.scene.write_text(f'[start]\nfrom = "{self.directory / "rest"}"\ntime = "zero"\n' + HANGERS)
        self.skein_says("run", self.scene, "--out", self.directory / "on", "--threads", 1)
        on = self.series("on")
        self.assertLess(numpy.linalg.norm(self.places("on") - self.places("rest"), axis=1).max(), 1e-6 * RADIUS)
        self.assertLess(on["max_speedms"].max(), 1e-9)

    def test_bodies_in_the_air_fall_to_rest_without_friction(self):
        done = self.solve("fallen", "--stable", "--json", text=FALLS)
        self.assertLess(json.loads(done.stdout)["residual"], 1e-9)
        with h5py.File(sorted((self.directory / "fallen").glob("trajectory_*.h5"))[-1]) as file:
            height = file["groups"]["sticks/position"][-1][..., 2]
        self.assertEqual(height.shape[0], 8)
        self.assertGreater(height.min(), 0.8 * RADIUS)
        self.assertLess(height.min(axis=1).max(), 0.01, "none is in the air: it was packed up to 0.06 m")

    def test_a_hundred_held_rods_rest_on_each_other(self):
        """Ten layers of ten that cross, each softer by a tenth than the one below, from straight rods that do not touch. Where two rods of
        neighbouring layers cross in the plan, the upper one is still above."""
        done = self.solve("layers", "--stable", "--json", text=crossing_rods(layers=10, softer=0.9))
        self.assertLess(json.loads(done.stdout)["residual"], 1e-9)
        with h5py.File(sorted((self.directory / "layers").glob("trajectory_*.h5"))[-1]) as file:
            place = numpy.array([file[f"groups/rod{i}/position"][-1][0] for i in range(100)]).reshape(10, 10, 21, 3)
        self.assertLess(place[..., 2].min(), -0.01, "they sag by much more than they were apart")
        crossings = [gap for low, high in zip(place, place[1:]) for one in low for other in high for gap in gaps_where_crossed(one, other)]
        self.assertGreater(len(crossings), 300)
        self.assertGreater(min(crossings), 0.95 * 2 * CROSSING_RADIUS)

    def test_a_rigid_body_rests_in_a_frame(self):
        weight = 9.81 * 1000 * 4 / 3 * numpy.pi * 0.02**3
        depth = 0.0
        for _ in range(50):  # N = W/(4 cos), k g = N, at the distance of the axes less g
            distance = 0.025 - depth
            height = numpy.sqrt(distance**2 - 0.021**2)
            depth = weight * distance / (4 * height) / 1e3
        without = FRAME.replace('"memory"', '"none"').replace("static_friction = 0.3\n", "")
        done = self.solve("without", "--stable", text=without)
        self.assertIn("Neutral: 3 motions", done.stdout, "the ball spins")
        self.assertLess(abs(self.series("without")["ball_zm"][-1] - height), 1e-3 * depth)
        done = self.solve("with", "--stable", text=FRAME)
        self.assertNotIn("Neutral", done.stdout)
        self.assertGreater(self.series("with")["ball_zm"][-1], height, "friction carries a part")

    def test_blocks_rest_on_each_other(self):
        text = (APPS / "gallery/stack.toml").read_text() + "".join(f'[[probe]]\nname = "{name}"\nof = "{name}"\n' for name in ("lowest", "middle", "highest"))
        self.solve("stack", "--stable", text=text)
        rows, weight, stiffness = self.series("stack"), 0.0648 * 9.81, 1e5
        # Four corners on the floor; of blocks on each other both faces push, each with the stiffness of a contact.
        sinks = numpy.cumsum([3 * weight / (4 * stiffness), 2 * weight / (2 * stiffness), weight / (2 * stiffness)])
        for name, height, sink in zip(("lowest", "middle", "highest"), (0.015, 0.045, 0.075), sinks):
            self.assertLess(abs(height - rows[f"{name}_zm"][-1] - sink), 1e-6 * sink, name)
        # Dashpots in proportion to the springs: a vertical mode has the damping ratio w c/(2 k).
        self.solve("modes", "--count", 18, command="modes", text=text)
        with (self.directory / "modes/modes.csv").open(newline="") as file:
            modes = [(float(row["frequency[Hz]"]), float(row["damping_ratio[-]"])) for row in csv.DictReader(file)]
        springs = stiffness / 0.0648 * numpy.array([[6, -2, 0], [-2, 4, -2], [0, -2, 2]])
        for square in numpy.linalg.eigvalsh(springs):
            ratio = numpy.sqrt(square) * 15.0 / (2 * stiffness)
            frequency = numpy.sqrt(square * (1 - ratio**2)) / (2 * numpy.pi)
            self.assertTrue(any(abs(f - frequency) < 1e-6 * frequency and abs(r - ratio) < 1e-6 * ratio for f, r in modes), (frequency, ratio, modes))

    def test_bits_are_those_of_any_ranks_threads_and_lanes(self):
        self.scene.write_text(HANGERS)
        self.skein_says("run", self.scene, "--out", self.directory / "run", "--threads", 1)
        start = f'[start]\nfrom = "{self.directory / "run"}"\n'
        self.solve("rest", text=start + HANGERS)
        for threads, lanes in ((2, 4), (1, 1), (1, 2)):
            out = f"rest_{threads}_{lanes}"
            self.solve(out, "--lanes", lanes, text=start + HANGERS, threads=threads)
            self.assertEqual(self.digest(out), self.digest("rest"), out)
        for ranks in (1, 2, 3):
            out, on = f"rest_of_{ranks}", f"on_{ranks}"
            done = self.solve(out, text=start + HANGERS, ranks=ranks)
            self.assertIn("in 1 pieces", done.stdout)
            self.assertEqual(self.digest(out), self.digest("rest"), out)
            self.scene.write_text(f'[start]\nfrom = "{self.directory / out}"\ntime = "zero"\n' + HANGERS)
            self.skein_says("run", self.scene, "--out", self.directory / on, "--threads", 1, "--steps", 200, ranks=ranks)
            self.assertEqual(self.digest(on), self.digest("on_1"), "springs are where they were")

    def test_rods_of_a_file_on_walls_are_shared_with_all_ranks(self):
        turns = [0.02 * i for i in range(5)]
        rows = [f"{3 * RADIUS * i},0,{RADIUS - 1e-7},{math.sin(a)},{math.cos(a)},0,{math.cos(a)},{-math.sin(a)},0" for i, a in enumerate(turns)]
        (self.directory / "rods.csv").write_text("\n".join(["x,y,z,tx,ty,tz,nx,ny,nz", *rows]) + "\n")
        start = LIES.index("placement =")
        text = LIES[:start] + 'start = "clamped"\nplacement = {kind = "file", file = "rods.csv"}' + LIES[LIES.index("\n", start) :]
        text = text.replace('of = "rod"', 'of = "rod"\nnumber = 4')
        text += '[contact]\nlaw = "linear"\nstiffness = 100.0\nfriction = "memory"\nstatic_friction = 0.3\n'
        found = {}
        for ranks in (1, 2, 3):
            out, on = f"file_{ranks}", f"modes_{ranks}"
            told = json.loads(self.solve(out, "--json", text=text, ranks=ranks).stdout)
            self.assertEqual(told["pieces"], 1)
            self.assertLess(told["residual"], 1e-9)
            begin = f'[start]\nfrom = "{self.directory / out}"\n'
            modes = json.loads(self.solve(on, "--json", "--count", 6, command="modes", text=begin + text, ranks=ranks).stdout)
            found[ranks] = (self.digest(out), self.digest(on), [one["frequency_Hz"] for one in modes["modes"]])
            self.assertEqual(len(found[ranks][2]), 6)
            self.assertEqual(found[ranks], found[1])


if __name__ == "__main__":
    unittest.main()
