"""Rods with sharp surfaces in a fluid: nothing is lost between both whatever rods weigh, no layout changes a bit, and light discs on springs swing as
the fluid lets them."""

import math
import unittest

import numpy

from driver import FLUID_OF_RODS, DriverTest, disc_on_a_spring, rods_in_a_fluid

SCENE = ('title = "rods and a fluid"\n[time]\nduration = 0.4\n' + FLUID_OF_RODS + "largest_slip = 0\n" + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0])
         + '[immersion]\nrod_surface = "sharp"\n[output]\nseries = 0.02\ncheckpoint = 0.04\n')

# From four cells of thickness to less than one, where it has markers.
TAPERED = SCENE.replace("radius_2 = 0.2\n", "radius_2 = 0.2\ntaper = 0.08\n")

# As slender as that of FSI3, 4.1 cells thick, as heavy as the fluid; a force draws its end out of the plane in which the fluid flows around it.
PLATE_IN_FLUID = """
[fluid]
cells = [96, 40, 1]
spacing = 0.0048809523809523810
density = 1000.0
viscosity = 0.01
along_y = "no_slip"
courant = 0.8
expected_speed = 6.0
largest_slip = 0
[immersion]
rod_surface = "sharp"
"""
PLATE = """
title = "plate"
[time]
duration = 0.1
[[rods]]
name = "plate"
start = "clamped"
[rods.material]
density = 1000.0
youngs_modulus = 6.6667e6
[rods.section]
kind = "rectangular"
radius = 0.01
radius_2 = 0.0024404761904761905
[rods.shape]
length = 0.351
elements = 28
[rods.placement]
origin = [0.06, 0.1, 0.0024404761904761905]
tangent = [1.0, 0.0, 0.0]
[[load]]
kind = "end_force"
end = [0.0, 1e-4, 1e-4]
[output]
series = 0.01
checkpoint = 0.01
"""

# Rods of their own sizes: three with sharp surfaces, one of which is as long as the box is across it, and one too thin.
OF_OWN_SIZES = f"""
title = "rods of their own sizes"
[time]
duration = 0.4
{FLUID_OF_RODS}largest_slip = 0
[[rods]]
name = "own"
[rods.material]
density = 2.0
youngs_modulus = 2e3
[rods.section]
radius = 0.1
taper = 0.6
[rods.shape]
length = 1.0
elements = 6
velocity = [0.5, 0.3, 0.2]
[rods.placement]
kind = "file"
file = "rods.csv"
[immersion]
rod_surface = "sharp"
[output]
series = 0.02
checkpoint = 0.04
"""
SIZES = """x,y,z,tx,ty,tz,length,radius
0.5,0.6,0.4,0.6,0.0,0.8,1.2,0.3
1.9,1.8,0.5,0.0,0.0,1.0,0.9,0.16
2.6,0.4,0.3,0.0,0.6,0.8,1.0,0.06
1.5,1.9,1.5,1.0,0.0,0.0,2.0,0.15
"""

# A tube closed to a ring about an axis of symmetry of the box.
EDGE, CORNER = 0.15, math.pi / 8
RING = f"""
title = "ring"
[time]
duration = 0.4
{FLUID_OF_RODS}largest_slip = 0
[[rods]]
name = "ring"
[rods.material]
density = 2.0
youngs_modulus = 1e4
[rods.section]
radius = 0.12
[rods.shape]
length = {16 * EDGE}
elements = 16
closed = true
rest_curvature = [{CORNER / EDGE!r}, 0.0, 0.0]
velocity = [1.0, 0.0, 0.0]
[rods.placement]
origin = [1.6, {1.2 + EDGE / 2 / math.sin(CORNER / 2)!r}, 1.0]
normal = [1.0, 0.0, 0.0]
[immersion]
rod_surface = "sharp"
[output]
series = 0.02
trajectory = 0.1
checkpoint = 0.04
"""


def bent_rod(density, modulus, force, duration=0.32):
    """A rod in a fluid of 2 kg/m^3, 4.4 cells thick, clamped, with a force across it at its end."""
    return f"""
title = "bent rod"
[time]
duration = {duration}
{FLUID_OF_RODS}largest_slip = 0
[[rods]]
name = "rod"
start = "clamped"
[rods.material]
density = {density}
youngs_modulus = {modulus}
[rods.section]
radius = 0.22
[rods.shape]
length = 1.2
elements = 6
[rods.placement]
origin = [1.6, 1.2, 0.3]
tangent = [0.0, 0.0, 1.0]
[[load]]
kind = "end_force"
end = [{force}, 0.0, 0.0]
[immersion]
rod_surface = "sharp"
[output]
trajectory = 0.005
series = 0.04
precision = "double"
"""


# Down to a tip that velocity nodes miss; nothing moves but the last sixth of it, below 0.25 cells in radius, as if it had no stiffness.
TIP = f"""
title = "tip"
[time]
duration = 0.2
{FLUID_OF_RODS}largest_slip = 0
[[rods]]
name = "rod"
[rods.material]
density = 2.0
youngs_modulus = 1e-3
[rods.section]
radius = 0.11
taper = 0.05
[rods.shape]
length = 2.4
elements = 24
[rods.placement]
origin = [0.4, 1.2, 1.0]
tangent = [1.0, 0.0, 0.0]
[[load]]
kind = "formula"
per = "mass"
force = ["0", "if(s > 0.84*L, 3, 0)", "0"]
[immersion]
coupling = "one_way"
rod_surface = "sharp"
[output]
series = 0.02
fluid_forces = ["rod"]
"""

# Rods, one end of which a post may hold.
POST = """
[[obstacle]]
name = "post"
kind = "cylinder"
centre = [1.0, 0.6, 0.0]
radius = 0.12
"""
THICK = FLUID_OF_RODS + """
[[rods]]
name = "thick"
[rods.material]
density = 2.0
youngs_modulus = 2e3
[rods.section]
radius = 0.15
[rods.shape]
length = 1.0
elements = 6
[rods.placement]
"""


SCENES = {"thick": SCENE, "tapered": TAPERED, "own": OF_OWN_SIZES}


class SharpRods(DriverTest):
    def test_momentum_is_kept_whatever_rods_weigh(self):
        """Beside thin rods, which have markers."""
        (self.directory / "rods.csv").write_text(SIZES)
        for name, scene in SCENES.items():
            for density in (0.02, 1.0, 2.0, 20.0, 2000.0) if name == "thick" else (0.02, 2000.0):
                with self.subTest(rods=name, density=density):
                    self.scene.write_text(scene.replace("density = 2.0\nyoungs_modulus", f"density = {density}\nyoungs_modulus"))
                    self.assertEqual(self.plan_text().count("cells, a sharp surface"), 1)
                    self.run_skein(f"{name}{density}")
                    series = self.assert_fluid_and_rods_keep_momentum(f"{name}{density}")
                    self.assertLess(series["max_speedms"].max(), 2.5)

    def test_light_discs_on_springs_swing_with_their_own_inertia(self):
        """Eight cells across. The spring has a circular frequency of 1/s with the disc and its displaced fluid; the boundary layer adds 0.7 to 0.9 times that
        fluid at this viscosity, and amplitudes fall."""
        for density in (0.001, 1.0):
            self.scene.write_text(disc_on_a_spring(48, density, (density + 1) * math.pi / 4, 9.0) + '[immersion]\nrod_surface = "sharp"\n')
            self.run_skein(f"disc{density}")
            series = self.series(f"disc{density}")
            x, t = series["centre_xm"], series["times"]
            crossing = [t[i] - x[i] * (t[i + 1] - t[i]) / (x[i + 1] - x[i]) for i in range(len(x) - 1) if x[i] * x[i + 1] < 0]
            inertia = ((crossing[1] - crossing[0]) / math.pi) ** 2 * (density + 1) - density - 1
            self.assertLess(abs(inertia - 0.8), 0.15, (density, crossing))
            turns = [abs(x[i]) for i in range(1, len(x) - 1) if (x[i] - x[i - 1]) * (x[i + 1] - x[i]) < 0]
            self.assertLess(turns[1], 0.65 * turns[0], (density, turns))

    def test_notes_name_what_keeps_markers_and_what_is_known_of_thin_surfaces(self):
        self.scene.write_text(SCENE)
        self.assertIn("immersion.rod_surface = \"sharp\" does not apply, and these rods have markers: the thickest part has", self.plan_text())
        self.scene.write_text(disc_on_a_spring(48, 10.0, 1.0, 1.0).replace("radius = 0.5", "radius = 0.2") + '[immersion]\nrod_surface = "sharp"\n')
        plan = self.plan_text()
        self.assertIn("1.6 cells in half the thickness, too few for the fluid: drag of sharp surfaces was compared with known values from four cells in radius on; "
                      "fluid.spacing = 0.05 gives four cells", plan)
        self.assertNotIn("which the fluid sees about", plan)

    def test_bending_does_not_depend_on_the_length_of_steps(self):
        """Velocities within the surface that had a divergence would make a rod stiffer the shorter steps are, by a twentieth here."""
        ways = []
        for courant in (0.4, 0.05):
            self.scene.write_text(bent_rod(20.0, 2e3, 2.0).replace("courant = 0.4", f"courant = {courant}"))
            self.run_skein(f"steps{courant}")
            x = self.frames(f"steps{courant}", "trajectory")["groups/rod/position"][:, 0, -1, 0]
            ways.append(x[-1] - x[0])
        self.assertGreater(ways[0], 0.1)
        self.assertLess(abs(ways[1] - ways[0]), 0.006 * ways[0], ways)

    def test_short_waves_of_soft_rods_do_not_grow(self):
        """Elements of one cell in a fluid of next to no viscosity: couples of the fluid go to the elements whose spins move it."""
        scene = bent_rod(4.0, 200.0, 0.02, 0.5).replace("radius = 0.22", "radius = 0.15").replace("elements = 6", "elements = 12").replace("courant = 0.4", "courant = 0.1")
        self.scene.write_text(scene.replace("viscosity = 0.02", "viscosity = 0.0002"))
        self.run_skein("soft")
        angles = self.frames("soft", "trajectory")["groups/rod/directors"][:, 0, :, 2, 0]
        waves = numpy.cos(math.pi * numpy.outer(numpy.arange(12) + 0.5, [10, 11]) / 12) / 6
        self.assertGreater(numpy.abs(angles).max(), 0.01)
        self.assertLess(numpy.abs(angles @ waves)[-20:].max(), 1.5e-4)

    def test_short_waves_of_rods_that_lean_do_not_grow(self):
        """Elements of one cell, as heavy as the fluid. Few velocity nodes sample a section that leans, so that stretch, shear and spins move fluid along each other."""
        scene = bent_rod(2.0, 200.0, 0.0002, 0.7).replace("radius = 0.22", "radius = 0.15").replace("elements = 6", "elements = 12").replace("courant = 0.4", "courant = 0.1")
        for degrees in (8, 14):
            with self.subTest(degrees=degrees):
                lean = math.radians(degrees)
                self.scene.write_text(scene.replace("viscosity = 0.02", "viscosity = 0.0002").replace("tangent = [0.0, 0.0, 1.0]", f"tangent = [{math.sin(lean)}, 0.0, {math.cos(lean)}]").replace("origin = [1.6, 1.2, 0.3]", f"origin = [{1.6 - 0.6 * math.sin(lean)}, 1.2, 0.5]"))
                self.run_skein(f"lean{degrees}")
                places = self.frames(f"lean{degrees}", "trajectory")["groups/rod/position"][:, 0]
                stretch = numpy.diff(places, axis=1) @ [math.sin(lean), 0, math.cos(lean)] / 0.1 - 1
                waves = numpy.cos(math.pi * numpy.outer(numpy.arange(12) + 0.5, range(7, 12)) / 12) / 6
                amplitudes = numpy.linalg.norm(stretch @ waves, axis=1)
                self.assertGreater(amplitudes.max(), 1e-7)
                self.assertLess(amplitudes[-20:].max(), 3e-6)

    def test_light_rods_with_a_held_end_do_not_stretch_without_limit(self):
        """A quarter of the fluid's density. Their waves of stretch move no fluid around, and are faster than steps of the fluid."""
        rod = bent_rod(0.5, 2e3, 0.2, 1.7).replace("radius = 0.22", "radius = 0.15").replace("elements = 6", "elements = 12")
        self.scene.write_text(rod.replace("viscosity = 0.02", "viscosity = 0.001"))
        self.run_skein("light")
        stretch, bend = (self.series("light")[f"elastic_{kind}J"].max() for kind in ("stretch", "bend"))
        self.assertGreater(bend, 0.01)
        self.assertLess(stretch, 0.01 * bend)

    def test_light_rods_that_slide_move_along_themselves_as_free_ones_do(self):
        ways = []
        for start in ('start = "clamped"\nstart_free = "z"\n', ''):
            rod = bent_rod(0.5, 2e4, 0.0, 0.2).replace("radius = 0.22", "radius = 0.15").replace("elements = 6", "elements = 12").replace("end = [0.0, 0.0, 0.0]", "end = [0.0, 0.0, 0.02]")
            self.scene.write_text(rod.replace("viscosity = 0.02", "viscosity = 0.001").replace('start = "clamped"\n', start))
            self.run_skein(f"slides{len(ways)}")
            z = self.frames(f"slides{len(ways)}", "trajectory")["groups/rod/position"][:, 0, :, 2].mean(axis=1)
            ways.append(z[-1] - z[0])
        self.assertGreater(ways[1], 1e-3)
        self.assertLess(abs(ways[0] / ways[1] - 1), 0.02, ways)

    def test_a_note_names_elements_that_are_too_short(self):
        """Of rods about as heavy as the fluid: waves of shorter elements grow."""
        rod = bent_rod(2.0, 200.0, 0.0002).replace("radius = 0.22", "radius = 0.15")
        for elements, density, noted in ((18, 2.0, True), (14, 2.0, False), (18, 3.2, False)):
            for surface in ("sharp", "markers"):
                with self.subTest(elements=elements, density=density, surface=surface):
                    self.scene.write_text(rod.replace("elements = 6", f"elements = {elements}").replace("density = 2.0\nyoungs", f"density = {density}\nyoungs").replace('"sharp"', f'"{surface}"'))
                    self.assertEqual("elements of 0.667 cells are too short for a sharp surface" in self.plan_text(), noted and surface == "sharp")

    def test_axial_waves_have_the_inertia_of_the_fluid_that_ends_push(self):
        """The disc at the end of a rod moves 4/3 rho a^3 on one side. Sides slip, so the fluid within adds nothing, however coarse cells are."""
        scene = bent_rod(4.0, 2e3, 0.0, 1.0).replace("radius = 0.22", "radius = 0.3").replace("viscosity = 0.02", "viscosity = 0.0002")
        self.scene.write_text(scene.replace("end = [0.0, 0.0, 0.0]", "end = [0.0, 0.0, 0.002]").replace("courant = 0.4", "courant = 0.1").replace("series = 0.04", "series = 0.005"))
        self.run_skein("axial")
        series = self.series("axial")
        p, t = series["momentum_zkg_ms"], series["times"]
        crossing = [t[i] - p[i] * (t[i + 1] - t[i]) / (p[i + 1] - p[i]) for i in range(1, len(p) - 1) if p[i] * p[i + 1] < 0]
        dry = math.pi / 2 / 1.2 * math.sqrt(2e3 / 4.0)
        inertia = (dry * (crossing[-1] - crossing[0]) / (len(crossing) - 1) / math.pi) ** 2 - 1
        of_disc = 4 / 3 * 2.0 * 0.3**3 / (4.0 * math.pi * 0.3**2 * 1.2 / 2)  # over half of the rod's mass
        self.assertGreater(inertia, of_disc)
        self.assertLess(inertia, 2 * of_disc)  # walls are near: the end is half a metre from one

    def test_a_note_names_rods_with_an_end_within_markers(self):
        """However rods are placed, and whichever end it is."""
        (self.directory / "far.csv").write_text("x,y,z\n2.4,1.6,1.0\n2.4,0.6,1.0\n")
        (self.directory / "near.csv").write_text("x,y,z\n2.4,1.6,1.0\n1.1,0.6,1.0\n")
        note = "rods.thick: an end of these rods, which have sharp surfaces, lies within obstacle 'post', which has markers"
        for place, within in {
            "origin = [1.1, 0.6, 1.0]\ntangent = [1.0, 0.0, 0.0]": True,
            "origin = [1.4, 0.6, 1.0]\ntangent = [1.0, 0.0, 0.0]": False,
            "origin = [2.1, 0.6, 1.0]\ntangent = [-1.0, 0.0, 0.0]": True,
            'kind = "list"\norigins = [[2.4, 1.6, 1.0], [1.1, 0.6, 1.0]]\ntangent = [0.0, 1.0, 0.0]': True,
            'kind = "list"\norigins = [[2.4, 1.6, 1.0], [2.4, 0.6, 1.0]]\ntangent = [0.0, 1.0, 0.0]': False,
            'kind = "lattice"\ncounts = [2, 2]\nspacing = [1.3, 1.0]\norigin = [1.0, 0.6, 1.0]\ntangent = [0.0, 1.0, 0.0]': True,
            'kind = "file"\nfile = "near.csv"\ntangent = [0.0, 1.0, 0.0]': True,
            'kind = "file"\nfile = "far.csv"\ntangent = [0.0, 1.0, 0.0]': False,
        }.items():
            for surface in ("markers", "sharp"):
                with self.subTest(place=place, surface=surface):
                    held = "end" if "-1.0" in place else "start"
                    rods = THICK.replace('name = "thick"\n', f'name = "thick"\n{held} = "clamped"\n')
                    self.scene.write_text('title = "ends"\n[time]\nduration = 0.1\n' + rods + place + POST + f'surface = "{surface}"\n[immersion]\nrod_surface = "sharp"\n')
                    self.assertEqual(note in self.plan_text(), within and surface == "markers")

    def test_a_note_of_light_rods_looks_at_each_of_their_sizes(self):
        """A stout rod in front of a slender one, and behind it; thin ones have markers."""
        head, stout, slender, thin = SIZES.splitlines()[0], "0.5,0.6,0.4,0.6,0.0,0.8,1.2,0.3", "1.5,1.9,1.5,1.0,0.0,0.0,2.0,0.15", "2.6,0.4,0.3,0.0,0.6,0.8,1.0,0.06"
        light = OF_OWN_SIZES.replace("density = 2.0\nyoungs_modulus", "density = 1.0\nyoungs_modulus")
        for rods, noted in (((stout, slender), True), ((slender, stout), True), ((stout, stout), False), ((stout, thin), False)):
            with self.subTest(rods=rods):
                (self.directory / "rods.csv").write_text("\n".join((head, *rods)) + "\n")
                self.scene.write_text(light)
                self.assertEqual("slender rods that are lighter than the fluid may grow slowly" in self.plan_text(), noted)

    def test_a_thin_tip_acts_on_the_fluid(self):
        """As that of a rod with markers alone, and where it is."""
        loads = []
        for surface in ("sharp", "markers"):
            self.scene.write_text(TIP.replace('"sharp"', f'"{surface}"'))
            self.assertEqual("a sharp surface along" in self.plan_text(), surface == "sharp")
            self.run_skein(surface)
            series = self.series(surface)
            loads.append(numpy.array([series["rod_0_fluid_force_yN"][1:], series["rod_0_fluid_couple_zN_m"][1:]]))
        (force, couple), (by_markers, couple_by_markers) = loads
        self.assertLess(force.max(), -0.09)
        self.assertLess(abs(force / by_markers - 1).max(), 0.02, force)
        arm = couple / force
        self.assertLess(abs(arm / (couple_by_markers / by_markers) - 1).max(), 0.01, arm)
        self.assertGreater(arm.min(), 0.8 * 2.4)
        self.assertLess(arm.max(), 2.4)

    def test_slender_plates_as_heavy_as_the_fluid_do_not_shake(self):
        """Short waves of nodes move less fluid than their loads count. Out of its plane the fluid adds no inertia, so a plate moves as without it, but for the
        layer that sticks to it."""
        for density in (1000.0, 3000.0):
            plate = PLATE.replace("density = 1000.0", f"density = {density}")
            self.scene.write_text(plate)
            self.run_skein(f"alone{density}")
            self.scene.write_text(plate + PLATE_IN_FLUID)
            self.run_skein(f"plate{density}")
            alone, within = self.series(f"alone{density}"), self.series(f"plate{density}")
            way = alone["centre_zm"][-1] - alone["centre_zm"][0]
            for row in (3, 6, -1):
                ratio = (within["centre_zm"][row] - within["centre_zm"][0]) / (alone["centre_zm"][row] - alone["centre_zm"][0])
                self.assertLess(ratio, 1, (density, row))
                self.assertGreater(ratio, 0.95, (density, row))
            self.assertLess(within["centre_ym"][-1] - within["centre_ym"][0], 0.5 * way, density)
            self.assertLess(within["elastic_stretchJ"].max(), 2 * alone["elastic_stretchJ"].max() + 1e-9, density)

    def test_rings_have_no_seam(self):
        self.scene.write_text(RING)
        self.assertEqual(self.plan_text().count("cells, a sharp surface"), 1)
        self.run_skein("one")
        self.assert_fluid_and_rods_keep_momentum("one")
        x = self.frames("one", "trajectory")["groups/ring/position"][-1, 0, :16, 0]
        self.assertGreater(x.min(), 1.65)
        for node in range(8):  # opposite ones, of which 0 closes the ring
            self.assertLess(abs(x[node] - x[node + 8]), 1e-3 * abs(x[node] - 1.6), x)
        self.scene.write_text(RING.replace("duration = 0.4", "duration = 0.08").replace("trajectory = 0.1", "trajectory = 0.02"))
        self.run_skein("short")
        self.run_skein("rows", "--set", "fluid.ranks_across=2", "--lanes", "2", ranks=4)
        self.run_skein("parts", "--until", "0.04")
        self.run_skein("parts", threads=2)
        for out in ("rows", "parts"):
            self.assertEqual(self.digest(out), self.digest("short"), out)

    def test_plates_have_the_same_bits_on_other_ranks_lanes_and_threads_and_after_a_stop(self):
        self.scene.write_text(PLATE.replace("duration = 0.1", "duration = 0.03") + PLATE_IN_FLUID)
        self.run_skein("one")
        self.run_skein("lanes", "--lanes", "2")
        self.run_skein("threads", "--lanes", "1", threads=2)
        self.run_skein("parts", "--until", "0.015")
        self.run_skein("parts", ranks=2)
        for out in ("lanes", "threads", "parts"):
            self.assertEqual(self.digest(out), self.digest("one"), out)

    def test_same_bits_on_other_ranks_lanes_and_threads_and_after_a_stop(self):
        (self.directory / "rods.csv").write_text(SIZES)
        for name, scene in SCENES.items():
            with self.subTest(rods=name):
                self.scene.write_text(scene.replace("duration = 0.4", "duration = 0.12"))
                self.run_skein(f"{name}_one")
                self.run_skein(f"{name}_rows", "--set", "fluid.ranks_across=2", ranks=4)
                self.run_skein(f"{name}_lanes", "--lanes", "2")
                self.run_skein(f"{name}_threads", "--lanes", "1", threads=2)
                self.run_skein(f"{name}_parts", "--until", "0.05")
                self.run_skein(f"{name}_parts", ranks=2)
                for out in ("rows", "lanes", "threads", "parts"):
                    self.assertEqual(self.digest(f"{name}_{out}"), self.digest(f"{name}_one"), out)

    def test_rods_that_taper_act_by_markers_where_they_are_thin(self):
        """Also where forces at nodes and markers persist from step to step."""
        self.scene.write_text(TAPERED)
        plan = self.plan_text()
        self.assertRegex(plan, r"a sharp surface along \d\d(\.\d)? % of the rods, and \d+ markers a rod, on")
        self.assertRegex(plan, r"rods.thick: \d+(\.\d+)? % of their length, down to 0.313 cells in half the thickness, is too thin for a sharp surface and acts by markers")
        forces = []
        for scheme in ("rk3", "crank_nicolson"):
            self.scene.write_text(TAPERED.replace("courant = 0.4", f'courant = 0.1\nscheme = "{scheme}"').replace("[immersion]", '[immersion]\ncoupling = "one_way"'))
            self.run_skein(scheme)
            forces.append(numpy.array([self.series(scheme)[f"thick_fluid_force_{d}N"][5:].mean() for d in "xyz"]))
        self.assertLess(numpy.linalg.norm(forces[1] - forces[0]), 0.06 * numpy.linalg.norm(forces[0]), forces)


if __name__ == "__main__":
    unittest.main()
