"""Shapes of obstacles in a fluid: all kinds at any angle, moving and turning, on any layout; forces and couples; meshes of files, and files that
enclose no body."""

import math
import struct
import unittest

import numpy

from driver import FLUID_OF_RODS, DriverTest

HEAD = 'title = "shapes in a fluid"\n[time]\nduration = 0.2\n' + FLUID_OF_RODS + "acceleration = [0.5, 0.0, 0.0]\n"
SHAPES = """
[[obstacle]]
name = "pill"
kind = "capsule"
surface = "sharp"
centre = [0.5, 0.5, 0.4]
radius = 0.15
length = 0.3
axis = [1.0, 0.4, -0.3]
velocity = [0.0, 0.3, 0.5]
[[obstacle]]
name = "brick"
kind = "box"
surface = "sharp"
centre = [1.3, 1.8, 1.7]
sides = [0.5, 0.3, 0.4]
radius = 0.05
angular_velocity = [1.0, 0.0, 2.0]
[[obstacle]]
name = "egg"
kind = "ellipsoid"
surface = "sharp"
centre = [2.2, 0.6, 1.4]
half_axes = [0.3, 0.2, 0.15]
axis = [0.0, 1.0, 1.0]
normal = [1.0, 0.0, 0.2]
amplitude = [0.05, 0.0, 0.0]
frequency = 1.0
[[obstacle]]
name = "stone"
kind = "mesh"
surface = "sharp"
centre = [2.6, 1.7, 0.6]
file = "stone.stl"
unit = 1e-2
angular_velocity = [0.0, 1.0, 0.0]
[[obstacle]]
name = "sheet"
kind = "box"
centre = [1.4, 0.6, 1.0]
sides = [0.02, 0.5, 0.6]
axis = [0.3, 0.0, 1.0]
[[obstacle]]
name = "stick"
kind = "capsule"
centre = [0.5, 1.6, 1.2]
radius = 0.1
length = 0.4
angular_velocity = [0.0, 0.0, 1.0]
"""
OUTPUT = """
[output]
series = 0.02
checkpoint = 0.04
"""
CORNERS = numpy.array([[x, y, z] for z in (-15, 15) for y in (-20, 20) for x in (-25, 25)], float)
TRIANGLES = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]


def stl(triangles, corners=CORNERS):
    return b" " * 80 + struct.pack("<I", len(triangles)) + b"".join(struct.pack("<12fH", 0, 0, 0, *corners[t].ravel(), 0) for t in triangles)


class ShapesInFluid(DriverTest):
    def setUp(self):
        super().setUp()
        (self.directory / "stone.stl").write_bytes(stl(TRIANGLES))
        self.scene.write_text(HEAD + SHAPES + OUTPUT)

    def says(self, text, **files):
        for name, content in files.items():
            (self.directory / f"{name}.stl").write_bytes(content)
        self.scene.write_text(HEAD + text + OUTPUT)
        return self.skein_says("check", self.scene, expect=2).stderr

    def test_all_shapes_have_the_same_bits_on_any_layout_and_after_a_stop(self):
        self.run_skein("one")
        for out, arguments, layout in (("rows", ["--set", "fluid.ranks_across=2"], {"ranks": 4}), ("threads", ["--lanes", "2"], {"threads": 2})):
            self.run_skein(out, *arguments, **layout)
            self.assertEqual(self.digest(out), self.digest("one"), out)
        self.run_skein("parts", "--until", "0.1")
        self.run_skein("parts", ranks=2)
        self.assertEqual(self.digest("parts"), self.digest("one"))
        series = self.series("one")
        for name in ("pill", "brick", "egg", "stone", "sheet", "stick"):
            self.assertGreater(abs(series[f"{name}_couple_{'xyz'[name == 'brick']}N_m"]).max(), 0, name)
        for out in ("rows", "threads", "parts"):
            self.assertEqual((self.directory / out / "observables.csv").read_bytes(), (self.directory / "one/observables.csv").read_bytes(), out)
        plan = self.plan_text()
        for words in ("'pill', capsule of 3 x 3 x 6 cells, sharp surface, moves", "'stone', mesh of 12 triangles, of 5 x 4 x 3 cells, sharp surface, moves",
                      "'egg', ellipsoid of 6 x 4 x 3 cells", "'sheet', box of 0.2 x 5 x 6 cells, 20 markers"):
            self.assertIn(words, plan)

    def test_a_mesh_that_changes_between_a_run_and_its_resume_is_refused(self):
        stone = self.directory / "stone.stl"
        self.run_skein("one", "--until", "0.1")
        self.run_skein("parts", "--until", "0.05")
        as_it_was = stone.read_bytes()
        longer = CORNERS.copy()
        longer[0, 0] -= 1
        stone.write_bytes(stl(TRIANGLES, longer))
        for ranks in (1, 2):
            said = self.run_skein("parts", "--until", "0.1", expect=2, ranks=ranks).stderr
            for words in ("obstacle 'stone'", "its mesh 'stone.stl' has changed since the checkpoint", "put that file back"):
                self.assertIn(words, said)
        stone.write_bytes(as_it_was)
        self.run_skein("parts", "--until", "0.1")
        self.assertEqual(self.digest("parts"), self.digest("one"))

    def test_a_mesh_of_a_box_is_that_box(self):
        keys = 'surface = "sharp"\ncentre = [1.0, 1.2, 1.0]\naxis = [0.2, -0.3, 1.0]\nvelocity = [0.5, 0.0, 0.0]\nangular_velocity = [0.0, 1.0, 0.5]\n'
        for kind in ('kind = "box"\nsides = [0.5, 0.4, 0.3]\n', 'kind = "mesh"\nfile = "stone.stl"\nunit = 0.01\n'):
            self.scene.write_text(HEAD + '[[obstacle]]\nname = "it"\n' + kind + keys + OUTPUT)
            self.run_skein(kind[8:11])
        box, mesh = self.series("box"), self.series("mes")
        for name in ("fluid_energyJ", "it_force_xN", "it_force_zN", "it_couple_yN_m"):
            self.assertLess(abs(box[name] - mesh[name]).max(), 1e-9 * abs(box[name]).max(), name)

    def test_faults_name_key_and_cure(self):
        it = '[[obstacle]]\nname = "it"\ncentre = [1.0, 1.0, 1.0]\nsurface = "sharp"\n'
        for keys, words in {
            'kind = "sphere"\n': "'radius' [m] above 0 is needed for an obstacle of kind \"sphere\"",
            'kind = "box"\nradius = 0.1\n': "'sides' [m] above 0 is needed",
            'kind = "box"\nsides = [0.5, 0.4, 0.3]\nradius = 0.2\n': "edges of 0.2 m in radius do not fit the shortest side of 0.3 m",
            'kind = "ellipsoid"\nhalf_axes = [0.5, 0.4, -0.3]\n': "'half_axes' [m] above 0 is needed",
            'kind = "ellipsoid"\nhalf_axes = [0.5, 0.4, 0.03]\n': "half of its thickness, 0.03 m, is too thin for cells of 0.1 m: at least 0.1 m, or fluid.spacing = 0.03 at most",
            'kind = "box"\nsides = [0.5, 0.4, 0.1]\n': "half of its thickness, 0.05 m, is too thin for cells of 0.1 m: at least 0.1 m, or fluid.spacing = 0.05 at most, or surface = \"markers\"",
            'kind = "mesh"\n': "'file' is needed for an obstacle of kind \"mesh\": .stl or .obj",
            'kind = "sphere"\nradius = 0.2\nlength = 0.1\n': "length",
            'kind = "capsule"\nradius = 0.2\naxis = [0.0, 0.0, 0.0]\n': "'axis' has no direction",
            'kind = "box"\nsides = [0.5, 0.4, 0.3]\nnormal = [0.0, 0.0, 2.0]\n': "'normal' needs a direction across 'axis'",
            'kind = "cylinder"\nradius = 0.2\nangular_velocity = [1.0, 0.0, 0.0]\n': "a cylinder through the whole box along z turns about z alone",
        }.items():
            with self.subTest(keys=keys):
                self.assertIn(words, self.says(it + keys))
        walled = HEAD.replace("acceleration", 'along_x = "no_slip"\nacceleration') + OUTPUT
        self.scene.write_text(walled + it.replace("[1.0, 1.0, 1.0]", "[4.0, 1.0, 1.0]") + 'kind = "sphere"\nradius = 0.3\n')
        self.assertIn("obstacle 'it' at [4, 1, 1] m lies outside of the fluid, which reaches from [0, 0, 0] to [3.2, 2.4, 2] m: change its 'centre'",
                      self.skein_says("check", self.scene, expect=2).stderr)
        self.scene.write_text(walled + it.replace("[1.0, 1.0, 1.0]", "[3.4, 1.0, 1.0]") + 'kind = "sphere"\nradius = 0.3\n')
        self.skein_says("check", self.scene)
        for keys, words in {'delta = "four_point"': "'delta' has no use with sharp surfaces alone", "sweeps = 3": "'sweeps' has no use with sharp surfaces alone and an explicit scheme"}.items():
            self.assertIn(words, self.says(it + f'kind = "sphere"\nradius = 0.3\n[immersion]\n{keys}\n'))
        marked = '[[obstacle]]\ncentre = [1.0, 1.0, 1.0]\nkind = "ellipsoid"\nhalf_axes = [0.5, 0.4, 0.3]\n'
        self.assertIn("an obstacle of kind \"ellipsoid\" has no markers: use surface = \"sharp\"", self.says(marked))

    def test_meshes_that_enclose_no_body_are_refused_with_their_triangle(self):
        it = '[[obstacle]]\nname = "it"\ncentre = [1.0, 1.0, 1.0]\nsurface = "sharp"\nkind = "mesh"\nfile = "bad.stl"\nunit = 0.01\n'
        nan = bytearray(stl(TRIANGLES))
        nan[84 + 50 * 2 + 12:84 + 50 * 2 + 16] = struct.pack("<f", math.nan)
        for words, content in (("bad.stl: triangle 11: the edge from", stl(TRIANGLES[:-1])), ("bad.stl: triangle 3: a corner is at (nan,", bytes(nan)), ("bad.stl: no triangles in it", stl([])),
                               ("encloses -0.06 m^3: turn its triangles", stl([t[::-1] for t in TRIANGLES])), ("of 12 triangles has 684 bytes, this one 680", stl(TRIANGLES)[:-4])):
            said = self.says(it, bad=content)
            self.assertIn("scene.toml:", said)
            self.assertIn(words, said)
        self.assertIn("too thin for cells of 0.1 m: at least two cells; 'unit' [m] is the length of 1 in the file", self.says(it.replace("unit = 0.01", "unit = 1e-3"), bad=stl(TRIANGLES)))
        self.assertIn("none.stl", self.says(it.replace("bad", "none")))


if __name__ == "__main__":
    unittest.main()
