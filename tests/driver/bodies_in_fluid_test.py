"""Rigid bodies that feel a fluid: nothing is lost between both whatever bodies weigh and whatever holds them, no layout changes a bit, and
spheres sink, turn and float as is known of them."""

import math
import unittest

import numpy

from driver import FLUID_OF_RODS, DriverTest

BODIES = """
[[bodies]]
name = "balls"
density = 2.0
velocity = [1.0, 0.2, 0.0]
angular_velocity = [0.0, 1.0, 1.0]
[bodies.spheres]
radii = [0.25]
[bodies.placement]
kind = "lattice"
counts = [2, 1]
spacing = [0.52, 1.0]
origin = [0.3, 1.4, 0.5]
[[bodies]]
name = "block"
density = 1.5
velocity = [0.0, 0.2, -1.0]
angular_velocity = [0.0, 1.0, 1.0]
[bodies.boxes]
sizes = [[0.7, 0.4, 0.5]]
radii = [0.05]
[bodies.placement]
origin = [1.6, 0.3, 1.5]
tangent = [0.2, 0.1, 1.0]
[[bodies]]
name = "club"
density = 4.0
velocity = [0.0, -0.5, -0.3]
[bodies.capsules]
from = [[0.0, 0.0, -0.3]]
to = [[0.0, 0.0, 0.3]]
radii = [0.08]
[bodies.spheres]
centres = [[0.0, 0.0, 0.3]]
radii = [0.2]
[bodies.placement]
origin = [2.7, 1.8, 1.2]
tangent = [0.6, 0.0, 0.8]
"""
# A head with a tail that begins at its surface.
JOINED = """
[[bodies]]
name = "head"
assembly = "tadpole"
density = 2.0
velocity = [0.0, 0.5, 0.0]
[bodies.spheres]
radii = [0.2]
[bodies.placement]
origin = [1.8, 1.2, 0.6]
[[rods]]
name = "tail"
assembly = "tadpole"
[rods.material]
density = 2.5
youngs_modulus = 1e4
[rods.section]
radius = 0.06
[rods.shape]
length = 0.6
elements = 6
[rods.placement]
origin = [2.0, 1.2, 0.6]
tangent = [1.0, 0.0, 0.0]
[[assembly]]
name = "tadpole"
[[joint]]
kind = "fixed"
between = ["head", "tail"]
at = [0.0, 0.0]
pairs = "listed"
first = [0]
second = [0]
"""
CONTACT = """
[contact]
law = "linear"
stiffness = 1e3
damping = 0.5
"""
OUTPUT = """
[output]
series = 0.02
trajectory = 0.1
checkpoint = 0.1
precision = "double"
"""
HEAD = 'title = "bodies in a fluid"\n[time]\nduration = 0.4\n' + FLUID_OF_RODS + "largest_slip = 0\n"
SCENE = HEAD + BODIES + JOINED + CONTACT + OUTPUT
SHARP = SCENE + '\n[immersion]\nbody_surface = "sharp"\n'


def sphere(cells, density, duration, *, viscosity=1.0, speed=1.0, keys="", tables=""):
    """A sphere of an eighth in radius in a cube of 1 m with periods."""
    return f"""
title = "a sphere in a fluid"
[time]
duration = {duration}
[fluid]
cells = [{cells}, {cells}, {cells}]
spacing = {1 / cells!r}
density = 1.0
viscosity = {viscosity}
courant = 0.5
expected_speed = {speed!r}
{keys}
[[bodies]]
name = "ball"
density = {density}
[bodies.spheres]
radii = [0.125]
[bodies.placement]
origin = [0.51, 0.5, 0.497]
{tables}
[output]
series = {duration / 20!r}
trajectory = {duration / 20!r}
precision = "double"
"""


VOLUME = 4 / 3 * math.pi * 0.125 ** 3
GRAVITY = '[[load]]\nkind = "gravity"\nacceleration = [0.0, 0.0, {!r}]\n'


class BodiesInFluid(DriverTest):
    def assert_momentum_kept(self, out, most=2.5):
        series = self.assert_fluid_and_rods_keep_momentum(out)
        self.assertLess(series["max_speedms"].max(), most, out)
        self.assertLess(series["slipms"][3:].max(), 0.3, out)

    def test_momentum_is_kept_whatever_bodies_weigh(self):
        for density in (0.02, 0.2, 1.0, 2.0, 2000.0):
            self.scene.write_text(SCENE.replace("density = 2.0\nvelocity", f"density = {density}\nvelocity"))
            self.run_skein(f"bodies{density}")
            self.assert_momentum_kept(f"bodies{density}")

    def test_sharp_surfaces_keep_momentum_whatever_bodies_weigh(self):
        """Beside the club, whose handle is too thin, and the tail of the head, which have markers."""
        for density in (0.02, 0.2, 1.0, 2.0, 2000.0):
            self.scene.write_text(SHARP.replace("density = 2.0\nvelocity", f"density = {density}\nvelocity"))
            self.assertEqual(self.plan_text().count("a sharp surface"), 3)
            self.run_skein(f"sharp{density}")
            self.assert_momentum_kept(f"sharp{density}")

    def test_light_sharp_spheres_swing_on_springs_without_growth(self):
        """Eight cells across. The inertia is that of the sphere and half of the displaced fluid's, and some of the boundary layer's; amplitudes fall."""
        steepness = (2 * math.pi) ** 2 * VOLUME
        for density in (1e-4, 0.01, 0.1, 0.5, 1.0, 10.0):
            spring = (density + 0.5) * steepness
            tables = f'[[joint]]\nkind = "spherical"\nbetween = ["ball", "world"]\nstiffness = {spring!r}\n[[load]]\nkind = "uniform_force"\nforce = [0.0, 0.0, {0.05 * spring!r}]\n[immersion]\nbody_surface = "sharp"\n'
            self.scene.write_text(sphere(32, density, 4.0, viscosity=0.001, speed=1.5, tables=tables).replace(f"series = {4.0 / 20!r}", "series = 0.025"))
            out = f"spring{density}"
            self.run_skein(out)
            series = self.series(out)
            way = series["centre_zm"] - 0.497 - 0.05
            turns = [abs(way[i]) for i in range(1, len(way) - 1) if (way[i] - way[i - 1]) * (way[i + 1] - way[i]) < 0]
            self.assertGreater(len(turns), 4, (density, turns))
            self.assertLess(max(b / a for a, b in zip([0.05] + turns, turns) if b > 5e-4), 0.97, (density, turns))
            crossing = next(i for i in range(len(way)) if way[i] > 0)
            quarter = series["times"][crossing] - 0.025 * way[crossing] / (way[crossing] - way[crossing - 1])
            added = (density + 0.5) * (4 * quarter) ** 2 - density
            self.assertGreater(added, 0.5, (density, added))
            if density < 1:
                self.assertLess(added, 1.3, (density, added))

    def test_momentum_is_kept_by_all_ways_of_coupling(self):
        for name, keys in {"sweeps": "sweeps = 8\n", "springs": "forcing = 'penalty'\npenalty_stiffness = 2000.0\npenalty_damping = 20.0\n", "heavier": "inner_inertia = false\n",
                           "wide": "delta = 'four_point'\n"}.items():
            self.scene.write_text(SCENE + "\n[immersion]\n" + keys)
            self.run_skein(name)
            self.assert_momentum_kept(name)

    def test_same_bits_on_other_ranks_lanes_and_threads_and_after_a_stop(self):
        for surface, scene in {"markers": SCENE, "sharp": SHARP}.items():
            with self.subTest(surface=surface):
                self.scene.write_text(scene.replace("duration = 0.4", "duration = 0.24"))
                one, rows, lanes, threads, parts = outs = [f"{surface}_{how}" for how in ("one", "rows", "lanes", "threads", "parts")]
                self.run_skein(one)
                self.run_skein(rows, "--set", "fluid.ranks_across=2", ranks=4)
                self.run_skein(lanes, "--lanes", "2")
                self.run_skein(threads, "--lanes", "1", threads=2)
                self.run_skein(parts, "--until", "0.15")
                self.assertIn("Resuming from", self.run_skein(parts, ranks=2).stdout)
                for out in outs: self.assertEqual(self.digest(out), self.digest(one), out)

    def test_bodies_step_implicitly_too(self):
        """Joined to rods or not, and in a bed with contact: as explicit bodies, and with the same momentum."""
        free = HEAD + BODIES + JOINED + OUTPUT
        self.scene.write_text(free)
        self.run_skein("explicit")
        self.scene.write_text(SCENE)
        self.run_skein("touching")
        for method, text, other, bound in (("implicit", free, "explicit", 0.02), ("implicit_damped", free, "explicit", 0.02), ("implicit_bed", HEAD + BODIES + CONTACT + OUTPUT, "touching", 0.05)):
            self.scene.write_text(text)
            self.run_skein(method, "--set", f"time.integrator='{method}'")
            self.assert_momentum_kept(method)
            frames, others = self.frames(method, "trajectory"), self.frames(other, "trajectory")
            for name in ("balls", "block", "club"):
                places = {key: frames[key][-1] for key in frames if f"{name}/position" in key or key.endswith(f"{name}/position")}
                self.assertTrue(places)
                for key, place in places.items():
                    way = abs(others[key][-1] - others[key][0]).max()
                    self.assertLess(abs(place - others[key][-1]).max(), bound * way, f"{method}: {key}")

    def test_spheres_sink_and_rise_as_an_array_does(self):
        """In slow flow, 8 cells across; Hasimoto's drag of a cubic array."""
        drag = 1 / (1 - 1.7601 * VOLUME ** (1 / 3) + VOLUME - 1.5593 * VOLUME ** 2)
        for density in (0.5, 1.001, 2.0):
            gravity = -10 / abs(density - 1)
            force = (density - 1) * VOLUME * gravity
            speed = force / (6 * math.pi * 0.125 * drag)
            self.scene.write_text(sphere(32, density, 0.2, speed=2 * abs(speed), keys=f"acceleration = [0.0, 0.0, {-force!r}]", tables=GRAVITY.format(gravity)))
            out = f"array{density}"
            self.run_skein(out)
            series = self.series(out)
            found = series["momentum_zkg_ms"][-1] / (density * VOLUME) - series["fluid_momentum_zkg_ms"][-1]
            self.assertLess(abs(found / speed - 1), 0.01, (density, found, speed))

    def test_a_couple_turns_a_sphere_against_the_fluid(self):
        """8 pi mu a^3, with markers as deep as Stokes flow wants them."""
        couple = 8 * math.pi * 0.125 ** 3 * 10.0
        errors = []
        for cells in (32, 48):
            self.scene.write_text(sphere(cells, 1.0, 0.06, speed=1.25, tables=f'[[load]]\nkind = "uniform_couple"\ncouple = [0.0, 0.0, {couple!r}]\n[immersion]\nretraction = 0.3\n'))
            self.run_skein(f"spins{cells}")
            spin = math.sqrt(2 * self.series(f"spins{cells}")["kinetic_rotationJ"][-1] / (0.4 * VOLUME * 0.125 ** 2))
            errors.append(spin / (10.0 * (1 - VOLUME)) - 1)
        self.assertLess(abs(errors[0]), 0.035, errors)
        self.assertLess(abs(errors[1]), 0.015, errors)

    def test_a_body_as_heavy_as_the_fluid_stays(self):
        self.scene.write_text(sphere(24, 1.0, 0.5, viscosity=0.01, speed=0.5, tables=GRAVITY.format(-10.0)))
        self.run_skein("floats")
        self.assertLess(self.series("floats")["max_speedms"].max(), 1e-12)

    def test_a_body_whose_weight_is_off_its_middle_turns_upright(self):
        """Buoyancy acts at the middle of the volume: a sphere whose centre of mass lies beside it ends with that below."""
        text = sphere(24, 1.0, 6.0, viscosity=0.02, speed=0.5, tables=GRAVITY.format(-1.0)).replace("density = 1.0\n[bodies.spheres]", f"mass = {VOLUME!r}\ncentre = [0.03, 0.0, 0.0]\n[bodies.spheres]")
        self.scene.write_text(text)
        self.run_skein("upright")
        frames = self.frames("upright", "trajectory")
        name = next(key for key in frames if key.endswith("ball/position"))
        place = numpy.concatenate([frame.reshape(-1, 3) for frame in frames[name]])
        series = self.series("upright")
        middle = numpy.array([0.51, 0.5, 0.497])
        arm = place[0] - middle
        self.assertAlmostEqual(numpy.linalg.norm(arm), 0.03, 6)
        # The middle hardly moves, as the weight is the buoyancy: the centre of mass goes down by the arm.
        self.assertLess(abs(series["centre_zm"][-1] - (0.497 - 0.03)), 0.006, series["centre_zm"])
        self.assertLess(series["max_speedms"].max(), 0.3)
        self.assertLess(series["max_speedms"][-1], 0.02)


if __name__ == "__main__":
    unittest.main()
