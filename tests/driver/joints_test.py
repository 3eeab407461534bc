"""Copies of a robot that touch each other: nothing in the results tells on how many ranks and threads they were computed, where
copies went, nor where the run was interrupted."""

import pathlib
import re
import subprocess
import unittest

from driver import SEARCH, SKEIN, DriverTest

PARTS = pathlib.Path(__file__).resolve().parents[2] / "apps/millipede"

# In a row along their bodies, a sixth of a diameter into each other.
SWARM = f"""
include = ["{PARTS}/bot.part", "{PARTS}/drive.part"]
[time]
duration = 100.0
dt = 2e-3
[[assembly]]
name = "bot"
scatter = [0.0, 0.0, 0.01]
magnetisation_scatter = 0.01
[assembly.placement]
kind = "line"
normal = [1.0, 0.0, 0.0]
counts = [5]
spacing = [7.75]
[contact]
law = "linear"
stiffness = 1e4
damping = 100.0
allow_overlap = true
[output]
series = 0.1
trajectory = 0.2
tips = 0.2
both_ends = true
directors = false
checkpoint = 0.4
"""


ARMS = """
title = "Arms on the ground"
time = {duration = 0.01, dt = 1e-5}
load = [{kind = "gravity"}]
output = {series = 0.001, checkpoint = 0.005}

[[assembly]]
name = "arm"
placement = {kind = "list", origins = [[0, 0, 0], [0, 2, 0], [0, 4, 0], [3, 0, 0], [3, 2, 0]], tangents = [[0, 0, 1], [0, 0.6, 0.8], [0, 0, 1], [0, 0, 1], [0.6, 0, 0.8]]}

[[rods]]
name = "links"
assembly = "arm"
material = {density = 1000.0, youngs_modulus = 1e7}
section.radius = 0.02
shape = {length = 0.5, elements = 6}
placement = {kind = "list", origins = [[0, 0, 0], [0, 0, 0.5]], tangents = [[0, 0, 1], [1, 0, 0]]}

[[bodies]]
name = "hand"
assembly = "arm"
mass = 0.5
inertia = [0.001, 0.001, 0.001]
spheres.radii = [0.05]
placement.origin = [0.6, 0.0, 0.5]

[[joint]]
kind = "hinge"
between = ["links", "world"]
pairs = "listed"
first = [0]
at = [0.0]
axis = [0.0, 1.0, 0.0]
stiffness = 1e5
torsional_stiffness = 1e3
motor = {kind = "position", value = "0.4*sin(200*t)", stiffness = 200.0, damping = 0.5, most = 20.0}

[[joint]]
kind = "hinge"
between = ["links", "links"]
pairs = "next"
axis = [0.0, 1.0, 0.0]
stiffness = 1e5
torsional_stiffness = 1e3
friction = 0.3
friction_stiffness = 100.0
limits = [-0.01, 0.02]
stop_stiffness = 300.0
stop_damping = 0.2

[[joint]]
kind = "slider"
between = ["links", "hand"]
pairs = "listed"
first = [1]
second = [0]
at = [1.0, 0.0]
axis = [1.0, 0.0, 0.0]
stiffness = 1e5
torsional_stiffness = 1e3
friction = 0.5
friction_stiffness = 1e4
motor = {kind = "rate", value = "400*t - 0.8", damping = 5.0}
from = 0.002
break_force = 1.5
"""


CHAIN = """
title = "A chain of six links and a cart"
time = {duration = 0.01, dt = 1e-5}
load = [{kind = "gravity"}]
output = {series = 0.001, checkpoint = 0.001}

[[rods]]
name = "links"
material = {density = 1000.0, youngs_modulus = 1e7}
section.radius = 0.02
shape = {length = 0.5, elements = 6}
placement = {kind = "list", origins = [[0, 0, 1], [0.5, 0, 1], [1, 0, 1], [1.5, 0, 1], [2, 0, 1], [2.5, 0, 1]], tangents = [[1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0]]}

[[bodies]]
name = "carts"
mass = 0.5
inertia = [0.001, 0.001, 0.001]
spheres.radii = [0.05]
placement = {kind = "list", origins = [[0, 1, 0.5], [0, 2, 0.5], [0, 3, 0.5], [0, 4, 0.5]], tangents = [[0, 0, 1], [0, 0.6, 0.8], [1, 0, 0], [0.8, 0, 0.6]]}

[[joint]]
kind = "spherical"
between = ["links", "world"]
pairs = "listed"
first = [0]
at = [0.0]
stiffness = 1e4
from = 0.001

[[joint]]
kind = "spherical"
between = ["links", "links"]
pairs = "next"
stiffness = 1e4
from = 0.001
break_force = 8.0

[[joint]]
kind = "slider"
between = ["carts", "world"]
axis = [0.0, 0.6, 0.8]
stiffness = 1e4
torsional_stiffness = 10.0
motor = {kind = "force", value = "1.0"}
axis_damping = 1.0
break_force = 3.2
"""


GIMBALS = """
title = "Gimbals and balls that turn round"
time = {duration = 0.03, dt = 1e-5}
load = [{kind = "gravity"}]
output = {series = 0.001, checkpoint = 0.001}

[[assembly]]
name = "rack"
placement = {kind = "list", origins = [[0, 0, 0], [0, 2, 0], [0, 4, 0], [3, 0, 0], [3, 2, 0]], tangents = [[0, 0, 1], [0, 0.6, 0.8], [0, 0, 1], [0, 0, 1], [0.6, 0, 0.8]]}

[[bodies]]
name = "wheels"
assembly = "rack"
mass = 0.5
inertia = [0.001, 0.001, 0.001]
spheres.radii = [0.05]
angular_velocity = [100.0, 600.0, 50.0]
placement = {kind = "list", origins = [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]]}

[[bodies]]
name = "frames"
assembly = "rack"
mass = 0.5
inertia = [0.001, 0.002, 0.003]
spheres.radii = [0.05]
placement = {kind = "list", origins = [[0, 0, 0.2], [0.5, 0, 0.2], [1, 0, 0.2]]}

[[joint]]
kind = "hinge"
between = ["wheels", "world"]
pairs = "listed"
first = [0]
axis = [0.0, 1.0, 0.0]
stiffness = 1e4
torsional_stiffness = 50.0
spring = 2.0
spring_rest = 9.0
friction = 0.1
friction_stiffness = 50.0
motor = {kind = "position", value = "1000*t", stiffness = 1.0, most = 5.0}

[[joint]]
kind = "universal"
name = "cross"
between = ["wheels", "frames"]
pairs = "listed"
first = [1]
second = [1]
axis = [0.0, 1.0, 0.0]
second_axis = [1.0, 0.0, 0.0]
stiffness = 1e4
torsional_stiffness = 50.0
friction = 0.1
friction_stiffness = 50.0
about_second = {limits = [-0.1, 8.0], stop_stiffness = 20.0, stop_damping = 1e-3, motor = {kind = "rate", value = "900", damping = 1e-3}}
from = 0.001

[[joint]]
kind = "spherical"
name = "ball"
between = ["wheels", "frames"]
pairs = "listed"
first = [2]
second = [2]
axis = [0.0, 0.6, 0.8]
stiffness = 1e4
spring = 1.0
cone = 0.5
limits = [-0.2, 0.4]
stop_stiffness = 20.0
stop_damping = 1e-3
friction = 0.1
friction_stiffness = 50.0
motor = {kind = "position", values = ["0.1*sin(300*t)", "20*t", "0"], stiffness = 1.0, damping = 1e-4, most = 0.5}
break_force = 300.0
"""


# Links that spin about their own middles pull each other apart.
WHIPS = """
title = "Whips that tear"
time = {duration = 0.1, dt = 5e-5}
load = [{kind = "gravity"}]
output = {series = 0.001, checkpoint = 0.001, audit = true}

[[assembly]]
name = "whip"
placement = {kind = "list", origins = [[0, 0, 0], [0, 2, 0], [0, 4, 0], [3, 0, 0], [3, 2, 0]], tangents = [[0, 0, 1], [0, 0.6, 0.8], [1, 0, 0], [0, 1, 0], [0.6, 0, 0.8]]}

[[rods]]
name = "links"
assembly = "whip"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 0.02
shape = {length = 0.5, elements = 6, angular_velocity = [8.0, 12.0, 4.0]}
placement = {kind = "list", origins = [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]], tangents = [[1, 0, 0], [1, 0, 0], [1, 0, 0]]}

[[joint]]
kind = "fixed"
between = ["links", "links"]
pairs = "next"
break_strain = 0.02
"""


class Joints(DriverTest):
    def test_robots_that_touch(self):
        self.scene.write_text(SWARM)
        steps = ["--steps", "500"]
        self.run_skein("one", *steps)
        self.assertGreater(self.series("one")["contact_energyJ"][-1], 0)
        self.assertGreater(self.series("one")["joint_energyJ"][-1], 0)
        self.assertLess(max(self.series("one")["joint_gapm"]), 0.1 * 0.15)  # of the radius
        self.assert_any_way("500", ((1, 2), (2, 1), (3, 1), (7, 1)), moves=True, besides=SEARCH)  # two ranks of seven have no robot
        for ranks, threads in ((1, 2), (2, 1), (3, 1), (7, 1)):
            self.assert_same_frames(f"{ranks}x{threads}", "one", "legs")

    def assert_any_way(self, steps, layouts, moves=False, besides=()):
        """The bits of the run `one` on these ranks x threads with changing owners, where `moves` rods change them; on any lanes; in three parts, whose series may differ in `besides`."""
        steps = ["--steps", steps]
        for ranks, threads in layouts:
            out = f"{ranks}x{threads}"
            self.run_skein(out, *steps, "--balance", "always", ranks=ranks, threads=threads)
            if moves and ranks > 1:
                self.assertGreater(self.summary(out)["balance"]["migrations"], 0)
            self.assertEqual(self.digest(out), self.digest("one"), out)
            self.assert_same_series(out, "one")
        for lanes in ("1", "2", "4"):
            self.run_skein("lanes" + lanes, *steps, "--lanes", lanes)
            self.assertEqual(self.digest("lanes" + lanes), self.digest("one"), lanes)
        self.run_skein("parts", "--steps", "111", ranks=3)
        self.run_skein("parts", "--steps", "400", ranks=2)
        self.run_skein("parts", *steps)
        self.assertEqual(self.digest("parts"), self.digest("one"))
        self.assert_same_series("parts", "one", besides=besides)

    def test_robots_by_themselves(self):
        """Without contact they take many steps in a visit, or one."""
        self.scene.write_text(SWARM.replace("[contact]\nlaw = \"linear\"\nstiffness = 1e4\ndamping = 100.0\nallow_overlap = true\n", ""))
        self.run_skein("one", "--steps", "300")
        for name, more in (("synchronous", ["--protocol", "synchronous"]), ("ranks", [])):
            self.run_skein(name, "--steps", "300", *more, ranks=3)
            self.assertEqual(self.digest(name), self.digest("one"), name)

    def test_axes_remember(self):
        """Friction, stops, motors, and joints that are made and break, of copies on the ground: any ranks, owners, lanes, and parts of a run."""
        self.scene.write_text(ARMS)
        steps = ["--steps", "600"]
        self.run_skein("one", *steps)
        self.run_skein("whole", *steps, "--set", "joint.2.break_force=1e9")
        self.assertNotEqual(self.digest("whole"), self.digest("one"), "some joint has broken")
        self.assert_any_way("600", ((1, 2), (2, 1), (3, 1)))

    def test_turns_are_remembered(self):
        """Hinges beyond a turn, both axes of universal joints, and spherical joints with friction, stops and motors: any ranks, owners, lanes, and parts of a run."""
        self.scene.write_text(GIMBALS)
        self.run_skein("one", "--steps", "2000")
        self.run_skein("held", "--steps", "2000", "--set", "joint.2.break_force=1e9")
        self.assertNotEqual(self.digest("held"), self.digest("one"), "some joint has broken")
        self.assertGreater(max(self.series("one")["cross_forceN"]), 0)
        self.assert_any_way("2000", ((1, 2), (2, 1), (3, 1)))

    def test_turns_of_one_copy(self):
        self.scene.write_text(re.sub(r"origins = \[\[0, 0, 0\], \[0, 2, 0\].*", "origins = [[0, 0, 0]]}", GIMBALS, count=1))
        self.run_skein("one", "--steps", "2000", "--lanes", "1")
        for lanes in ("2", "4"):
            self.run_skein("lanes" + lanes, "--steps", "2000", "--lanes", lanes)
            self.run_skein("parts" + lanes, "--steps", "700", "--lanes", lanes)
            self.run_skein("parts" + lanes, "--steps", "2000", "--lanes", lanes)
            for out in ("lanes" + lanes, "parts" + lanes):
                self.assertEqual(self.digest(out), self.digest("one"), out)
                self.assert_same_series(out, "one")

    def assert_tears(self, times):
        """At so many times rods of the run `one` tear, after the first part of the other runs and before the last."""
        loss, time = self.series("one")["joint_lossJ"], self.series("one")["times"]
        torn = [at for at, before, after in zip(time[1:], loss, loss[1:]) if after > before]
        self.assertGreaterEqual(len(torn), times)
        self.assertTrue(all(0.01 < at < 0.02 for at in torn), torn)

    def test_rods_that_tear(self):
        """Common nodes of copies that part at different steps: any ranks, owners, lanes, and parts of a run."""
        self.scene.write_text(WHIPS)
        self.run_skein("one", "--steps", "600")
        self.assert_tears(2)
        self.assert_any_way("600", ((1, 2), (2, 1), (3, 1)))

    def test_rods_of_one_copy_tear(self):
        self.scene.write_text(re.sub(r"origins = \[\[0, 0, 0\], \[0, 2, 0\].*", "origins = [[0, 0, 0]]}", WHIPS, count=1))
        self.run_skein("one", "--steps", "600", "--lanes", "1")
        self.assert_tears(1)
        for lanes in ("2", "4"):
            self.run_skein("lanes" + lanes, "--steps", "600", "--lanes", lanes)
            for steps in ("200", "400", "600"): self.run_skein("parts" + lanes, "--steps", steps, "--lanes", lanes)
            for out in ("lanes" + lanes, "parts" + lanes):
                self.assertEqual(self.digest(out), self.digest("one"), out)
                self.assert_same_series(out, "one")

    def test_joints_of_one_copy(self):
        """Joints that are made and break, whose lanes are joints: lanes, and a run in two parts."""
        self.scene.write_text(CHAIN)
        self.run_skein("one", "--steps", "600", "--lanes", "1")
        for lanes in ("2", "4"):
            self.run_skein("lanes" + lanes, "--steps", "600", "--lanes", lanes)
            self.run_skein("parts" + lanes, "--steps", "300", "--lanes", lanes)
            self.run_skein("parts" + lanes, "--steps", "600", "--lanes", lanes)
            for out in ("lanes" + lanes, "parts" + lanes):
                self.assertEqual(self.digest(out), self.digest("one"), out)
                self.assert_same_series(out, "one")

    def test_a_branch_begins_to_remember(self):
        """A joint that a branch lets break, or gives friction, starts with no memory, and another step takes no jump."""
        self.scene.write_text(CHAIN.replace("break_force = 8.0\n", "").replace("from = 0.001\n", ""))
        self.run_skein("parent", "--steps", "300")
        for number, change in enumerate((["joint.0.break_force=1e9"], ["joint.2.friction=1e-3", "joint.2.friction_stiffness=0.1"], ["time.dt=2e-6"])):
            out = self.directory / f"branch{number}"
            done = subprocess.run([SKEIN, "branch", self.directory / "parent", out, *(f"--set={key}" for key in change)], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            done = subprocess.run([SKEIN, "run", out, "--until", "0.006", "--quiet"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.run_skein("parent", "--steps", "600")
        whole, fine = (self.summary(out)["observables"] for out in ("parent", "branch2"))
        for heading in ("joint_motor_work[J]", "joint_loss[J]", "kinetic_translation[J]"):
            self.assertAlmostEqual(fine[heading] / whole[heading], 1, delta=2e-3, msg=heading)

    def test_branch_of_copies_by_a_mask(self):
        """A branch lies elsewhere than its scene, whose mask it needs too."""
        (self.directory / "two.pbm").write_text("P1\n2 1\n1 1\n")
        self.scene.write_text(SWARM.replace('kind = "line"\nnormal = [1.0, 0.0, 0.0]\ncounts = [5]\nspacing = [7.75]', 'kind = "mask"\nfile = "two.pbm"\nspacing = [7.75, 7.75]'))
        self.run_skein("parent", "--steps", "20")
        subprocess.run([SKEIN, "branch", self.directory / "parent", self.directory / "branch"], check=True, capture_output=True)
        self.run_skein("whole", "--steps", "30")
        subprocess.run([SKEIN, "run", self.directory / "branch", "--steps", "30", "--quiet"], check=True, capture_output=True)
        self.assertEqual(self.digest("branch"), self.digest("whole"))


if __name__ == "__main__":
    unittest.main()
