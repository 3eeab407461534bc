"""Stages of a run: what they change, when they end, and that nothing in the results tells on how many ranks, threads and lanes they were computed, what was written,
nor where the run was interrupted."""

import math
import pathlib
import re
import sys
import unittest

import numpy

from driver import DriverTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
from skein import polydata  # noqa: E402

# Five rods fall onto a gate, which is taken away; the first three are joined meanwhile, and a floor stops all of them.
BED = """
title = "A gate"
time = {duration = 0.12, dt = 1e-4}
load = [{kind = "gravity", acceleration = [0, 0, -9.81]}, {kind = "uniform_force", force = [0.02, 0, 0], stages = ["open", "down"], ramp = 0.01}]
damping = [{kind = "uniform", rate = 20.0, stages = ["fall"]}, {kind = "uniform", rate = 2.0, stages = ["open", "down"]}]
contact = {law = "hertz", stiffness = 1e5, damping = 0.02, friction = "memory", static_friction = 0.5}
output = {series = 0.002, checkpoint = 0.01, observables = ["order"]}
[[rods]]
name = "rods"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 0.01
shape = {length = 0.2, elements = 6}
placement = {kind = "list", origins = [[0, 0, 0.011], [0.02, -0.1, 0.034], [0.05, -0.1, 0.034], [0.1, -0.1, 0.034], [0, 0, 0.06]], tangents = [[1, 0, 0], [0, 1, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0]]}
[[joint]]
kind = "spherical"
between = ["rods", "rods"]
pairs = "listed"
first = [0, 1]
second = [1, 2]
at = [0.5, 0.5]
stiffness = 200.0
damping = 0.02
stages = ["open"]
[[wall]]
name = "gate"
kind = "plane"
stiffness = 1e4
damping = 0.02
friction = "memory"
static_friction = 0.5
stages = ["fall"]
[[wall]]
name = "floor"
kind = "plane"
point = [0, 0, -0.02]
stiffness = 1e4
damping = 0.02
[[stage]]
name = "fall"
duration = 0.05
until = "gate_force > 2"
check_every = 0.001
[[stage]]
name = "open"
until = "floor_force > 0.5"
check_every = 0.001
change = ["contact.static_friction=0.1", "rods.rods.material.youngs_modulus=2e6"]
[[stage]]
name = "down"
change = ["wall.floor.velocity=[0, 0, 0.05]"]
"""

# The same with stages of given durations.
FIXED = BED.replace('duration = 0.05\nuntil = "gate_force > 2"\ncheck_every = 0.001', "duration = 0.05").replace('until = "floor_force > 0.5"\ncheck_every = 0.001', "duration = 0.03")

# A rod swings from a wall, falls, is caught by its other end, and is led by it.
ROD = """
title = "Let go and caught"
time = {duration = 0.4}
load = [{kind = "gravity", acceleration = [0, 0, -9.81]}]
damping = [{kind = "uniform", rate = 1.0}]
output = {series = 0.01, checkpoint = 0.05, audit = true}
[[rods]]
name = "rod"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 0.01
shape = {length = 0.5, elements = 12}
placement = {kind = "list", origins = [[0, 0, 0], [0, 1, 0], [0, 2, 0]], tangents = [[1, 0, 0], [1, 0, 0], [0.8, 0.6, 0]]}
[[stage]]
name = "swing"
duration = 0.1
[[stage]]
name = "fall"
duration = 0.1
change = ["rods.rod.start=free"]
[[stage]]
name = "caught"
duration = 0.1
change = ["rods.rod.end=clamped"]
[[stage]]
name = "led"
change = ['rods.rod.end_motion.translation_formula=["0", "0", "0.2*(t - stage_begin)"]']
"""


class Stages(DriverTest):
    def change(self, old, new):
        text = self.scene.read_text()
        self.assertIn(old, text)
        self.scene.write_text(text.replace(old, new))

    def begins(self, done):
        """Steps at which stages have ended, by name."""
        return {name: int(step) for step, name in re.findall(r"Step (\d+), t = \S+ s: stage '(\w+)' ends", done.stdout)}

    def assert_any_way(self, steps, moves):
        whole = self.run_skein("one")
        for ranks, threads in ((1, 2), (2, 1), (3, 2)):
            out = f"{ranks}x{threads}"
            self.run_skein(out, "--balance", "always", ranks=ranks, threads=threads)
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assert_same_series(out, "one")
            if moves and ranks > 1: self.assertGreater(self.summary(out)["balance"]["migrations"], 0)
        for lanes in ("1", "2", "4"):
            self.run_skein("lanes" + lanes, "--lanes", lanes)
            self.assertEqual(self.digest("lanes" + lanes), self.digest("one"), lanes)
        for step in steps:  # before, at and after events
            out = f"parts{step}"
            self.run_skein(out, "--steps", str(step), ranks=2)
            self.run_skein(out)
            self.assertEqual(self.digest(out), self.digest("one"), step)
            self.assert_same_series(out, "one", besides=("candidates", "rebuilds", "skinm"))
            self.assertIn("the same bits", self.skein_says("verify", self.directory / out).stdout)
        return whole

    def test_bits(self):
        self.scene.write_text(BED)
        self.run_skein("first")
        ends = self.begins(self.run_skein("again", "--quiet"))
        self.assertEqual(ends, {})
        ends = self.begins(self.run_skein("told"))
        self.assertEqual(list(ends), ["fall", "open"])
        self.assertNotIn(ends["fall"], (500, 0))  # by its condition
        steps = [at + by for at in ends.values() for by in (-1, 0, 1)]
        self.assert_any_way(steps, moves=True)
        rows = self.series("one")
        self.assertTrue((rows["gate_forceN"][rows["step"] > ends["fall"]] == 0).all())
        joined = rows["joint_energyJ"] > 0
        self.assertTrue(joined.any())
        self.assertTrue((rows["step"][joined] > ends["fall"]).all() and (rows["step"][joined] <= ends["open"]).all())

    def test_output_changes_nothing(self):
        self.scene.write_text(BED)
        self.run_skein("one")
        self.change("output = {series = 0.002, checkpoint = 0.01,", "output = {series = 0.03, trajectory = 0.0007,")
        self.run_skein("other")
        self.assertEqual(self.digest("other"), self.digest("one"))

    def test_ends(self):
        self.scene.write_text(ROD)
        self.run_skein("told")
        dt = self.summary("told")["dt_s"]
        steps = [round(t / dt) + by for t in (0.1, 0.2, 0.3) for by in (0, 1)] + [round(0.35 / dt)]
        self.assert_any_way(steps, moves=False)
        rows = self.series("one")
        at = lambda t: int(numpy.argmin(abs(rows["times"] - t)))
        taken = max(abs(rows["work_loadsJ"]))
        self.assertLess(max(abs(rows["energy_defectJ"])), 2e-3 * taken)
        self.assertLess(rows["stage_workJ"][at(0.11)], 0)  # the half cell of the clamp
        self.assertEqual(rows["stage_workJ"][at(0.11)], rows["stage_workJ"][-1])  # catches and motions bring nothing
        self.assertLess(rows["work_wallsJ"][at(0.21)], 0)  # a catch takes the energy of the node

    def test_a_release_is_a_free_fall(self):
        """Pinned at rest and let go: no energy, no momentum, and the centre falls by g t^2/2."""
        self.scene.write_text(ROD.replace('start = "clamped"', 'start = "pinned"').replace("[1, 0, 0], [1, 0, 0], [0.8, 0.6, 0]", "[0, 0, -1], [0, 0, -1], [0, 0, -1]").replace("damping = [{kind = \"uniform\", rate = 1.0}]\n", "")
                              .split("[[stage]]\nname = \"caught\"")[0].replace("duration = 0.1\nchange", "change"))
        self.run_skein("one")
        rows = self.series("one")
        self.assertLess(abs(rows["stage_workJ"]).max(), 1e-12 * abs(rows["work_loadsJ"]).max())
        falling = rows["times"] > 0.1
        mass = 3 * 1000.0 * math.pi * 0.01**2 * 0.5
        momentum = rows["momentum_zkg_ms"] if "momentum_zkg_ms" in rows.dtype.names else rows["momentum_zkg_ms"]
        gained = momentum[falling] - momentum[falling][0] + mass * 9.81 * (rows["times"][falling] - rows["times"][falling][0])
        self.assertLess(abs(gained).max(), 1e-10 * mass)

    def test_catch_holds(self):
        """A node stays where it was caught, to the last bit."""
        self.scene.write_text(ROD.split("[[stage]]\nname = \"led\"")[0].replace("duration = 0.1\nchange = [\"rods.rod.end", "change = [\"rods.rod.end").replace("audit = true", "trajectory = 0.05, directors = true"))
        self.run_skein("one")
        ends = self.frames("one", "trajectory")["groups/rod/position"][:, :, -1, :]
        self.assertTrue((ends[5:] == ends[5]).all())
        self.assertLess(abs(ends[5] - ends[4]).max(), 1e-13)  # 0.2 s, when it is caught
        self.assertGreater(abs(ends[4] - ends[3]).max(), 1e-2)

    def test_order(self):
        """Second order in the step through a release and a catch: differences of successive halvings fall by four. A catch sends waves of all lengths, so
        the steps are short."""
        self.scene.write_text(ROD.split("[[stage]]\nname = \"led\"")[0].replace("duration = 0.1\nchange = [\"rods.rod.end", "change = [\"rods.rod.end").replace("duration = 0.4", "duration = 0.204"))
        found = []
        for halvings in range(4):
            out = f"h{halvings}"
            self.run_skein(out, "--set", f"time.dt={1.25e-5 / 2**halvings}", "--set", "output.checkpoint=0", "--set", "output.series=0.001")
            found.append(self.series(out)[-1])
        for name in ("centre_zm", "elastic_bendJ", "work_wallsJ"):
            differences = [abs(a[name] - b[name]) for a, b in zip(found, found[1:])]
            self.assertGreater(differences[1] / differences[2], 3.7, name)

    def test_no_change_no_difference(self):
        """Stages that change nothing leave the bits of one without stages."""
        for name, text in (("bed", BED), ("rod", ROD)):
            head = re.sub(r", stages = \[[^]]*\]|\nstages = \[[^]]*\]", "", text.split("[[stage]]")[0])
            self.scene.write_text(head)
            self.run_skein(name)
            self.scene.write_text(head + '[[stage]]\nname = "a"\nduration = 0.0213\n[[stage]]\nname = "b"\nuntil = "max_speed > 0.4"\ncheck_every = 0.0031\n[[stage]]\nname = "c"\n')
            done = self.run_skein(name + "s")
            self.assertEqual(list(self.begins(done)), ["a", "b"])
            self.assertEqual(self.digest(name + "s"), self.digest(name), name)

    def test_joints_are_those_of_from_and_until(self):
        self.scene.write_text(BED.replace('duration = 0.05\nuntil = "gate_force > 2"\ncheck_every = 0.001', "duration = 0.03").replace('until = "floor_force > 0.5"\ncheck_every = 0.001', "duration = 0.04"))
        self.run_skein("stages")
        self.change('stages = ["open"]\n[[wall]]', "from = 0.03\nuntil = 0.07\n[[wall]]")
        self.run_skein("times")
        self.assertEqual(self.digest("stages"), self.digest("times"))

    def test_relaxation_step_by_step(self):
        """Loads one after the other: each stage ends at rest, where a relaxation under that load alone ends."""
        self.scene.write_text(ROD.split("[[stage]]")[0].replace("duration = 0.4", "duration = 20000, relax = true, relax_tolerance = 1e-10").replace("output = {series = 0.01, checkpoint = 0.05, audit = true}", "output = {}")
                              .replace("damping = [{kind = \"uniform\", rate = 1.0}]\n", ""))
        self.run_skein("alone")
        text = self.scene.read_text().replace("-9.81", "-3.0")
        self.scene.write_text(text + '[[stage]]\nname = "light"\nduration = 9000\n[[stage]]\nname = "heavy"\nchange = ["load.gravity.acceleration=[0, 0, -9.81]"]\n')
        done = self.run_skein("path")
        self.assertIn("all rods have settled", done.stdout)
        self.assertTrue(self.summary("path")["relaxation"]["settled"])
        bend = [self.series(out)["elastic_bendJ"][()] for out in ("alone", "path")]
        self.assertLess(abs(numpy.ravel(bend[0])[-1] - numpy.ravel(bend[1])[-1]), 1e-7 * abs(numpy.ravel(bend[0])[-1]))

    def test_automatic_stiffness_is_that_of_all_rods(self):
        """One number for all stages, on any number of ranks."""
        self.scene.write_text(BED.replace('stiffness = 1e5, damping = 0.02, friction', 'stiffness = "auto", damping = 0.02, friction'))
        self.run_skein("one")
        self.run_skein("ranks", ranks=3)
        self.assertEqual(self.digest("ranks"), self.digest("one"))
        self.run_skein("parts", "--steps", "500", ranks=2)
        self.run_skein("parts")
        self.assertEqual(self.digest("parts"), self.digest("one"))
        self.assertIn("the same bits", self.skein_says("verify", self.directory / "parts").stdout)

    def test_a_damaged_checkpoint_of_a_later_stage(self):
        """The one before it, of an earlier stage, is taken."""
        self.scene.write_text(ROD)
        self.run_skein("whole")
        dt = self.summary("whole")["dt_s"]
        self.run_skein("parts", "--steps", str(round(0.09 / dt)))
        self.run_skein("parts", "--steps", str(round(0.14 / dt)))
        newest = max((self.directory / "parts").glob("checkpoint_*.h5"))
        data = bytearray(newest.read_bytes())
        for place in range(len(data) // 2, len(data) // 2 + 4000): data[place] ^= 255
        newest.write_bytes(data)
        self.assertIn("warning: ", self.run_skein("parts").stderr)
        self.assertEqual(self.digest("parts"), self.digest("whole"))

    def test_a_led_end_goes_on(self):
        """A motion that counts from the begin of a stage begins there, and a later stage that does not change it leads the end on without a jump."""
        self.scene.write_text(ROD.replace("duration = 0.4", "duration = 0.5").replace("audit = true", "trajectory = 0.01") + 'duration = 0.1\n[[stage]]\nname = "on"\nchange = ["damping.uniform.rate=2"]\n')
        self.run_skein("one")
        ends = self.frames("one", "trajectory")["groups/rod/position"][:, 0, -1, 2]
        steps = ends[31:] - ends[30:-1]  # from 0.3 s on
        self.assertLess(abs(steps - 0.002).max(), 1e-7)  # of frames in single precision

    def test_branches(self):
        """A branch from any step of a staged run is the run itself; ends may be held in another way, but not in the past."""
        self.scene.write_text(ROD.replace("checkpoint = 0.05,", "checkpoint = 0.05, keep = 20,"))
        self.run_skein("whole")
        dt = self.summary("whole")["dt_s"]
        for time in (0.05, 0.1, 0.15, 0.3):  # within stages, and where they end
            out = f"branch{time}"
            self.skein_says("branch", f"{self.directory / 'whole'}@{round(time / dt)}", self.directory / out)
            self.skein_says("run", self.directory / out)
            self.assertEqual(self.digest(out), self.digest("whole"), time)
        text = ROD.split("[[stage]]")[0].replace("duration = 0.4", "duration = 0.6") + '[start]\nfrom = "whole"\n'
        self.scene.write_text(text.replace('start = "clamped"', 'end = "clamped"'))
        self.assertIn("an end of 'rod' is led from the begin of a stage there", self.run_skein("other", expect=2).stderr)
        self.scene.write_text(text.replace('"whole"', f'"whole@{round(0.3 / dt)}"'))
        self.run_skein("other")  # caught by its start, and let go at its end
        self.scene.write_text(ROD.replace("duration = 0.4", "duration = 0.6").replace("rods.rod.start=free", "rods.rod.start=pinned") + f'[start]\nfrom = "whole@{round(0.3 / dt)}"\n')
        self.assertIn("hold ends of rods in another way", self.run_skein("past", expect=2).stderr)

    def test_a_branch_catches_as_a_stage_does(self):
        """Ends that a branch lets go, catches or leads have the bits of the stage that does the same, on any ranks, over restarts, and in a branch of a branch."""
        head = ROD.split("[[stage]]")[0].replace("checkpoint = 0.05,", "checkpoint = 0.05, keep = 20,").replace("duration = 0.4", "duration = 0.3, dt = 2e-5")
        led = 'rods.rod.start_motion.translation_formula=["0", "0", "0.05*sin(9*t)"]'
        for name, keys in (("free", ["rods.rod.start=free"]), ("caught", ["rods.rod.end=clamped"]), ("other", ["rods.rod.start=free", "rods.rod.end=pinned"]), ("led", [led])):
            changes = ", ".join(f"'{key}'" for key in keys)
            self.scene.write_text(head + f'[[stage]]\nname = "a"\nduration = 0.1\n[[stage]]\nname = "b"\nchange = [{changes}]\n')
            self.run_skein(name + "_stage")
            self.scene.write_text(head)
            parent, child = self.directory / "parent", self.directory / name
            if name == "free": self.run_skein("parent")
            self.skein_says("branch", f"{parent}@5000", child, *(word for key in keys for word in ("--set", key)))
            self.skein_says("run", child, "--steps", "9000", ranks=2)
            self.skein_says("run", child)
            self.assertEqual(self.digest(name), self.digest(name + "_stage"), name)
            self.assertIn("the same bits", self.skein_says("verify", child).stdout)
            rows = self.series(name)
            self.assertLess(abs(rows["energy_defectJ"]).max(), 1e-2 * abs(rows["work_loadsJ"]).max())
            self.skein_says("branch", f"{child}@10000", f"{child}_again")
            self.skein_says("run", f"{child}_again", ranks=3)
            self.assertEqual(self.digest(name + "_again"), self.digest(name), name)

    def test_books_of_contacts(self):
        """A stage that changes nothing brings no energy; stiffer contacts bring that of their springs. Restarts change no column."""
        head = re.sub(r", stages = \[[^]]*\]|\nstages = \[[^]]*\]", "", BED.split("[[stage]]")[0]).replace('observables = ["order"]', "audit = true").replace("[[joint]]", "[[joint]]\nfrom = 1.0").replace("duration = 0.12,", "duration = 0.2,").replace("contact = {", "contact = {joined = true, ")
        for name, change, least, most in (("same", "", -0.005, 0.005), ("stiffer", 'change = ["contact.stiffness=2e5"]', 0.6, 1.1)):
            self.scene.write_text(head + f'[[stage]]\nname = "a"\nduration = 0.13\n[[stage]]\nname = "b"\n{change}\n')
            self.run_skein(name)
            rows = self.series(name)
            after, at = rows["step"] > 1300, int(numpy.argmax(rows["step"] == 1300))
            held = rows["contact_energyJ"][at]
            self.assertGreater(held, 1e-4)
            self.assertTrue((rows["stage_workJ"][~after] == 0).all())
            self.assertTrue((rows["stage_workJ"][after] == rows["stage_workJ"][-1]).all())
            self.assertTrue(least < rows["stage_workJ"][-1] / held < most, rows["stage_workJ"][-1] / held)
            self.assertLess(abs(rows["energy_defectJ"][at + 1] - rows["energy_defectJ"][at]), 0.1 * held)
            self.run_skein(name + "parts", "--steps", "1300")
            self.run_skein(name + "parts")
            self.assert_same_series(name + "parts", name, besides=("candidates", "rebuilds", "skinm"))

    def test_a_lid_that_comes_later(self):
        """A wall of a later stage may stand where rods begin, and moves from its first stage on."""
        self.scene.write_text(BED.replace('[[wall]]\nname = "floor"', '[[wall]]\nname = "lid"\nkind = "plane"\npoint = [0, 0, 0.05]\nnormal = [0, 0, -1]\nvelocity = [0, 0, -0.1]\nstiffness = 1e4\nstages = ["down"]\n[[wall]]\nname = "floor"')
                              .replace('change = ["wall.floor.velocity=[0, 0, 0.05]"]', ""))
        ends = self.begins(self.run_skein("one"))
        rows = self.series("one")
        self.assertTrue((rows["lid_forceN"][rows["step"] <= ends["open"]] == 0).all())
        gap = lambda row: 0.05 - 0.1 * (row["times"] - ends["open"] * 1e-4)
        self.assertGreater(gap(rows[-1]), 0.045)  # had it moved from the start, it would be at 0.038

    def walls_of(self, out):
        """[(time, numbers of the walls that are drawn, their lowest height)] of frames."""
        found = []
        for time, path in polydata.listed(self.directory / out / "walls.pvd"):
            points, polygons, number = polydata.polygons(polydata.read(path))
            heights = {int(wall): float(points[polygon, 2].min()) for wall, polygon in zip(number, polygons)}
            found.append((time, set(heights), heights))
        return found

    def test_walls_are_drawn_while_they_stand_and_where_they_are(self):
        """The gate up to its last step, and the floor as it rises; a restart between shows the same."""
        self.scene.write_text(BED.replace("series = 0.002,", 'series = 0.002, trajectory = 0.005, paraview = "vtp",'))
        ends = self.begins(self.run_skein("one"))
        frames = self.walls_of("one")
        self.assertEqual(len(frames), 25)
        for time, drawn, _ in frames:
            self.assertEqual(drawn, {0} if time <= ends["fall"] * 1e-4 + 1e-9 else {1}, time)  # the gate cuts off what is below it
        self.assertAlmostEqual(frames[-1][2][1], -0.02 + 0.05 * (0.12 - ends["open"] * 1e-4), places=9)
        self.run_skein("parts", "--steps", str(ends["fall"] + 37))
        self.run_skein("parts")
        self.assertEqual(self.walls_of("parts"), frames)

    def test_nothing_to_draw(self):
        """Frames at which no wall stands are read."""
        self.scene.write_text(BED.replace("series = 0.002,", 'series = 0.002, trajectory = 0.005, paraview = "vtp",').replace('name = "floor"\n', 'name = "floor"\nstages = ["open", "down"]\n')
                              .replace('stages = ["fall"]\n[[wall]]', 'stages = ["open"]\n[[wall]]').replace('until = "gate_force > 2"\ncheck_every = 0.001\n', "").replace("duration = 0.05", "duration = 0.01"))
        self.run_skein("one")
        self.assertEqual([drawn for time, drawn, _ in self.walls_of("one")][:4], 3 * [set()] + [{0}])

    def test_a_servo_begins_with_its_stage(self):
        lid = '[[wall]]\nname = "lid"\nkind = "plane"\npoint = [0, 0, 0.3]\nnormal = [0, 0, -1]\nstiffness = 1e4\nstages = ["open"]\nservo = {speed = 0.5, watch = "floor", area = 0.01, turn_back_above = 1e9, turn_forth_below = 0}\n'
        text = FIXED.replace('[[wall]]\nname = "floor"', lid + '[[wall]]\nname = "floor"').replace("{series = 0.002,", "{series = 1e-4,")
        self.scene.write_text(text)
        self.run_skein("one")
        rows = self.series("one")
        way = 0.5 * numpy.clip(rows["step"] - 500, 0, 300) * 1e-4
        self.assertLess(abs(rows["lid_heightm"] - (0.3 - way)).max(), 1e-12)
        for step in (499, 500, 501, 799, 800, 801):
            self.run_skein(f"parts{step}", "--steps", str(step))
            self.run_skein(f"parts{step}")
            self.assertEqual(self.digest(f"parts{step}"), self.digest("one"), step)
        self.scene.write_text(text.replace('watch = "floor"', 'watch = "gate"'))
        self.assertIn("'gate' does not stand in stage 'open', in which its stress decides", self.run_skein("refused", expect=2).stderr)

    def test_a_wall_does_not_appear_in_rods(self):
        text = FIXED.replace('[[wall]]\nname = "floor"', '[[wall]]\nname = "blade"\nkind = "plane"\npoint = [0.1, 0, 0]\nnormal = [1, 0, 0]\nstiffness = 1e4\nstages = ["open", "down"]\n[[wall]]\nname = "floor"')
        self.scene.write_text(text)
        for ranks in (1, 3):
            said = self.run_skein(f"refused{ranks}", ranks=ranks, expect=2).stderr
            self.assertRegex(said, r"rod 0 of 'rods' \(node 0\) is 0\.1\d* m, 5\.\d* of its diameter, deep in the wall 'blade', which appears at t = 0\.05 s as stage 'open' begins")
            self.assertIn("allow_overlap = true", said)
            self.assertIn("checkpoint of step 500", said)
        new = self.directory / "new"
        self.skein_says("branch", f"{self.directory / 'refused1'}@500", new, "--set", "wall.blade.allow_overlap=true", "--set", "wall.blade.stiffness=1e-3")
        self.skein_says("run", new)
        self.scene.write_text(text.replace("point = [0.1, 0, 0]", "allow_overlap = true\npoint = [0.1, 0, 0]").replace("[1, 0, 0]\nstiffness = 1e4", "[1, 0, 0]\nstiffness = 1e-3"))
        self.run_skein("allowed")
        self.assertEqual(self.digest("new"), self.digest("allowed"))
        self.scene.write_text(text.replace("point = [0.1, 0, 0]", "point = [-0.05, 0, 0]"))
        self.run_skein("clear")

    def test_formulas_where_they_act(self):
        """A formula must have values in the stages of its load alone, and in those in which it leads an end or drives a motor."""
        load = '{kind = "formula", per = "rod", force = ["1e-3*sqrt(F)", "0", "0"], stages = ["open"]}'
        motor = '[[joint]]\nkind = "hinge"\nbetween = ["rods", "rods"]\npairs = "listed"\nfirst = [3]\nsecond = [4]\nat = [0.5, 0.5]\naxis = [0, 0, 1]\nstiffness = 20.0\ntorsional_stiffness = 0.01\nmotor = {kind = "force", value = "1e-6*sqrt(F + 1e-9)"}\n'
        gate = '[[wall]]\nname = "gate"'
        bare = re.sub(r", stages = \[[^]]*\]|\nstages = \[[^]]*\]", "", BED.split("[[stage]]")[0])
        led = """duration = 0.1\nchange = ["rods.rod.end=clamped", 'rods.rod.end_motion.translation_formula=["0", "0", "0.01*sqrt(F + 1e-3)"]']"""
        cases = []
        for formula, good in (("(t - 0.049)*(0.081 - t)", True), ("t - stage_begin", True), ("0.06 - t", False), ("t - 0.06", False)):
            cases.append((FIXED.replace("ramp = 0.01}]", "ramp = 0.01}, " + load.replace("F", formula) + "]"), good))
            cases.append((FIXED.replace(gate, motor.replace("F", formula) + 'stages = ["open"]\n' + gate), good))
            if "stage" not in formula:
                cases.append((bare.replace(gate, motor.replace("F", formula) + "from = 0.05\nuntil = 0.08\n" + gate), good))
        for formula, good in (("(t - 0.2)*(0.301 - t)", True), ("t - stage_begin", True), ("0.25 - t", False), ("t - 0.25", False)):
            cases.append((ROD.split('[[stage]]\nname = "led"')[0].replace('duration = 0.1\nchange = ["rods.rod.end=clamped"]', led.replace("F", formula)) + '[[stage]]\nname = "after"\nchange = [\'rods.rod.end_motion.translation_formula=["0", "0", "0"]\']\n', good))
        until = BED.replace("ramp = 0.01}]", "ramp = 0.01}, " + load.replace("F", "t - 0.01") + "]")
        cases.append((until, True))  # it begins where the gate has been pressed
        for number, (text, good) in enumerate(cases):
            with self.subTest(number):
                self.scene.write_text(text)
                done = self.run_skein(f"case{number}", "--until", "0.11", expect=0 if good else 2)
                if not good: self.assertRegex(done.stderr, "root of a negative number|not finite")
        self.scene.write_text(until.replace("t - 0.01", "0.01 - t"))
        said = self.run_skein("late", expect=2).stderr  # as soon as it is known when
        self.assertIn("is the root of a negative number", said)
        self.assertIn("is kept in the checkpoint of step", said)

    def test_a_jump_of_a_walls_velocity_keeps_the_order(self):
        """Second order in the step where a wall that presses rods changes its velocity."""
        rods = re.sub(r"placement = .*", 'placement = {kind = "list", origins = [[0, 0, 0.0098], [0, 0.5, 0.0099]], tangents = [[1, 0, 0], [0, 1, 0]]}', BED.split("[[rods]]")[1].split("[[joint]]")[0])
        self.scene.write_text('time = {duration = 0.024, dt = 4e-5}\nload = [{kind = "gravity"}]\noutput = {series = 0.008}\n[[rods]]' + rods
                              + '[[wall]]\nname = "floor"\nkind = "plane"\nlaw = "linear"\nstiffness = 300.0\n[[stage]]\nname = "rest"\nduration = 0.008\n'
                              '[[stage]]\nname = "up"\nchange = ["wall.floor.velocity=[0, 0, 0.004]"]\nduration = 0.008\n[[stage]]\nname = "faster"\nchange = ["wall.floor.velocity=[0, 0, 0.01]"]\n')
        found = []
        for halvings in range(4):
            out = f"h{halvings}"
            self.run_skein(out, "--set", f"time.dt={4e-5 / 2**halvings}")
            found.append(self.series(out)[-1])
        for name in ("centre_zm", "momentum_zkg_ms"):
            differences = [abs(a[name] - b[name]) for a, b in zip(found, found[1:])]
            self.assertGreater(differences[1] / differences[2], 3.7, (name, differences))

    def test_a_wall_of_later_stages_goes_on_from_where_it_is(self):
        """A lid that stands from the second stage on and stops in the third has the bits of one that rests above the rods in the first."""
        fall = '[[stage]]\nname = "fall"\nuntil = "max_speed > 0.2"\ncheck_every = 0.004\n[[stage]]\nname = "press"\nduration = 0.02\n'
        rods = "[[rods]]" + BED.split("[[rods]]")[1].split("[[joint]]")[0]
        lid = ('[[wall]]\nname = "lid"\nkind = "plane"\nnormal = [0, 0, -1]\npoint = [0, 0, 0.072]\nstiffness = 1e4\n'
               '[[wall]]\nname = "floor"\nkind = "plane"\nstiffness = 1e4\npoint = [0, 0, -0.02]\n')
        head = 'time = {duration = 0.1, dt = 1e-4}\nload = [{kind = "gravity"}]\noutput.series = 0.002\n'
        rest = '[[stage]]\nname = "rest"\nchange = ["wall.lid.velocity=[0, 0, 0]"]\n'
        self.scene.write_text(head + rods + lid.replace("stiffness = 1e4\n", 'stiffness = 1e4\nvelocity = [0, 0, -1.5]\nstages = ["press", "rest"]\n', 1) + fall + rest)
        self.assertNotIn("wall.lid.from", self.plan_text(), "its stage begins at a time that is not known yet")
        self.assertNotIn("wall 'lid' ends", self.plan_text(), "it has not begun in the first stage")
        self.assertEqual(self.plan_text().count("wall 'lid' begins"), 1)
        self.run_skein("later")
        self.scene.write_text(head + rods + lid + fall + 'change = ["wall.lid.velocity=[0, 0, -1.5]"]\n' + rest)
        self.run_skein("always")
        self.assertGreater(self.series("later")["lid_forceN"].max(), 0.1, "it presses")
        self.assertEqual(self.digest("later"), self.digest("always"))

    def test_tables_stay_and_formulas_change(self):
        text = BED.replace('{kind = "uniform_force", force', '{kind = "formula", per = "rod", force = ["push(t)", "0", "0"]}, {kind = "uniform_force", force')
        text = text.replace('[[wall]]\nname = "gate"', '[[table]]\nname = "push"\nat = [0, 1]\nvalue = [0, 0.01]\n[[table]]\nname = "pull"\nat = [0, 1]\nvalue = [0, -0.01]\n[[wall]]\nname = "gate"')
        self.scene.write_text(text.replace('change = ["contact.static_friction=0.1",', """change = ['load.formula.force=["pull(t)", "0", "0"]', "contact.static_friction=0.1","""))
        self.run_skein("changed")
        self.scene.write_text(text)
        self.run_skein("same")
        self.assertNotEqual(self.digest("changed"), self.digest("same"))
        self.change('change = ["contact.static_friction=0.1",', 'change = ["table.push.value=[0, 1]",')
        self.assertIn("a stage does not change the points of a [[table]]", self.run_skein("refused", expect=2).stderr)

    def test_a_frozen_end_does_not_snap(self):
        """The element of a clamp that is frozen keeps its frame."""
        self.scene.write_text(ROD.split("[[stage]]\nname = \"caught\"")[0].replace("duration = 0.1\nchange = [\"rods.rod.start=free\"]", "change = [\"rods.rod.start=clamped_frozen\"]"))
        self.run_skein("one")
        rows = self.series("one")
        self.assertLess(abs(rows["energy_defectJ"]).max(), 1e-3 * abs(rows["work_loadsJ"]).max())

    def test_refusals(self):
        for old, new, message in (
            ('stages = ["fall"]\n[[wall]]', 'stages = ["fal"]\n[[wall]]', "there is no stage 'fal'; did you mean 'fall'?"),
            ('stages = ["open"]\n[[wall]]', 'stages = ["fall", "down"]\n[[wall]]', "consecutive stages"),
            ('stages = ["open"]\n[[wall]]', 'stages = ["open"]\nfrom = 0.01\n[[wall]]', "'from' has no use with 'stages', from which both follow"),
            ('until = "gate_force > 2"', 'until = "gate_force = 2"', "is no condition"),
            ('until = "gate_force > 2"', 'until = "gates_force > 2"', "this scene's series has no 'gates_force'"),
            ('until = "floor_force > 0.5"\ncheck_every = 0.001\n', "", "stage 'open' never ends, so 'down' never begins"),
            ("duration = 0.05\n", "duration = 0.2\n", None),
            ("duration = 0.05\nuntil = \"gate_force > 2\"\ncheck_every = 0.001", "duration = 0.2", "stage 'open' would begin at 0.2 s, and time.duration ends the run at 0.12 s"),
            ('name = "open"', 'name = "fall"', "two stages are named 'fall'"),
            ("check_every = 0.001\n[[stage]]\nname = \"open\"", "check_every = 0.001\nchange = [\"contact.stiffness=1e4\"]\n[[stage]]\nname = \"open\"", "the first stage is the scene as it is"),
            ("rods.rods.material.youngs_modulus=2e6", "load.gravity.kind=uniform_force", "a stage does not change 'kind'"),
            ("youngs_modulus=2e6", "young_modulus=2e6", "did you mean 'youngs_modulus'?"),
            ("youngs_modulus=2e6", "youngs_modulus=-2e6", "must be"),
            ("rods.rods.material.youngs_modulus=2e6", "rods.rods.shape.length=2", "it cannot change:\n  rods.0.shape.length"),
            ("rods.rods.material.youngs_modulus=2e6", "time.dt=1e-5", "a stage changes rods, bodies and the tables of physics"),
            ("rods.rods.material.youngs_modulus=2e6", "wall.gates.stiffness=1", "there is no 'wall.gates'; did you mean 'gate'?"),
            ("rods.rods.material.youngs_modulus=2e6", "nothing", "expected path=value"),
            ("check_every = 0.001\n[[stage]]\nname = \"open\"", "check_every = 0.001\n[[stage]]\nname = \"open\"\nduration = 0.01", None),
        ):
            with self.subTest(new=new):
                self.scene.write_text(BED)
                self.change(old, new)
                done = self.run_skein("refused", "--steps", "1", "--overwrite", expect=0 if message is None else 2)
                if message: self.assertIn(message, done.stderr)

    def test_a_step_for_all_stages(self):
        """The stiffest stage decides; a step that is too long for it is refused before the run."""
        self.scene.write_text(ROD)
        plain = self.plan()["dt"]
        self.change('change = ["rods.rod.start=free"]', 'change = ["rods.rod.start=free", "rods.rod.material.youngs_modulus=1e8"]')
        stiff = self.plan()["dt"]
        self.assertLess(stiff, 0.2 * plain)
        self.assertIn("stage 'fall'", self.plan_text())
        self.change("time = {duration = 0.4}", f"time = {{duration = 0.4, dt = {plain}}}")
        self.assertIn("in stage 'fall'", self.run_skein("refused", expect=2).stderr)


if __name__ == "__main__":
    unittest.main()
