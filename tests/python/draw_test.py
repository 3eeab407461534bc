"""skein draw: a picture of any run, by VTK and without; what it shows is where the rods are."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from types import SimpleNamespace

import h5py
import numpy as np

from package import APPS, SKEIN, Directory, skein

from PIL import Image
from skein.fluid import Field, cut, q_of, vorticity_of
from skein.needs import NotResults
from skein.picture import flow, shapes, sheet, sky, vtk_stage
from skein.picture.camera import framed
from skein.picture.colours import CHOICES, Scale, bright, named, phases, strain_of
from skein.picture.draw import Pictures, movie, when
from skein.picture.view import Choice, View
from skein.results import Group

# Fewer of the same rods, each of which takes milliseconds in matplotlib; pit_1024 and nest_460 have all of theirs.
SMALLER = {**{f"pit_{name}": "rods.snakes.placement.count=128" for name in ("1024_friction", "1024_published", "4096", "16384")},
           "swarm_224": "assembly.bot.placement.file='{mask}'"}
WHY_NOT = vtk_stage.why_not()
RENDERERS = ("plain",) if WHY_NOT else ("vtk", "plain")
if WHY_NOT:
    print(f"note: VTK is not tried: {WHY_NOT}")


class Shapes(unittest.TestCase):
    def test_tubes_are_closed_and_as_large_as_cylinders_with_caps(self):
        nodes = np.linspace([0, 0, 0], [0.3, 0.4, 0], 9)[None]
        mesh = shapes.tubes(nodes, np.full((1, 9), 0.02), np.ones((1, 9, 3)), 64)
        corner = mesh.points[mesh.faces]
        cross = 0.5 * np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
        volume = np.sum(cross * corner.mean(axis=1)) / 3
        exact = np.pi * 0.02**2 * 0.5 + 4 / 3 * np.pi * 0.02**3
        self.assertAlmostEqual(volume / exact, 1, delta=0.01)
        self.assertTrue(np.all(np.sum(cross * mesh.normals[mesh.faces].mean(axis=1), axis=1) > -1e-12), "normals point outwards")
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-12)

    def test_elliptic_sections_lie_along_their_directors(self):
        nodes = np.linspace([0, 0, 0], [0, 0, 1], 5)[None]
        normals = np.tile([0.6, 0.8, 0.0], (1, 5, 1))
        mesh = shapes.tubes(nodes, np.full((1, 5), 0.1), np.ones((1, 5, 3)), 32, normals, flat=0.5, caps=0)
        along, across = mesh.points @ [0.6, 0.8, 0], mesh.points @ [-0.8, 0.6, 0]
        self.assertAlmostEqual(along.max(), 0.1, places=6)
        self.assertAlmostEqual(across.max(), 0.05, places=6)

    def test_curves_pass_through_their_nodes(self):
        nodes = np.random.default_rng(1).normal(size=(3, 6, 3))
        np.testing.assert_allclose(shapes.refined(nodes, 4)[:, ::4], nodes)
        np.testing.assert_allclose(shapes.linear(nodes, 4)[:, ::4], nodes)

    def test_every_point_is_in_the_picture(self):
        random = np.random.default_rng(2)
        for _ in range(50):
            points, view, aspect = random.normal(size=(40, 3)) * random.uniform(0.1, 3, 3) + random.normal(size=3), random.normal(size=3), random.uniform(0.4, 2.5)
            place, depth = framed(points, view, (0, 0, 1), aspect).project(points)
            self.assertGreater(depth.min(), 0)
            self.assertLess(np.abs(place[:, 0]).max(), aspect)
            self.assertLess(np.abs(place[:, 1]).max(), 0.87)
            self.assertGreater(max(np.abs(place[:, 0]).max() / aspect, np.ptp(place[:, 1]) / 2), 0.75, "and fill it")

    def test_a_camera_along_the_upward_axis_sees_all(self):
        points = np.random.default_rng(3).normal(size=(40, 3))
        for view, up in (((0, 0, 1), (0, 0, 1)), ((0, 0, -2), (0, 0, 1)), ((0, 1, 0), (0, 3, 0)), ((1, 0, 0), (-1, 0, 0)), ((1, 1, 1), (2, 2, 2))):
            place, depth = framed(points, view, up, 1.3).project(points)
            self.assertGreater(depth.min(), 0)
            self.assertLess(np.abs(place).max(), 1.3)
            self.assertGreater(np.ptp(place, axis=0).min(), 0.3)

    def test_open_ground_is_fully_lit(self):
        points, normals = np.zeros((1, 3)), np.array([[0, 0, 1.0]])
        clear = np.full((64, 64), np.inf)
        for sun in ((0, 0, 1), (-0.5, -0.3, 0.8)):
            bright = sky.light(points, normals, lambda *axes: clear, np.array([0, 0, 1.0]), sun, np.zeros(3), 1.0, 64)
            self.assertAlmostEqual(bright[0], sky.AMBIENT + sky.SKY_SHARE + sky.SUN_SHARE, delta=0.03)
        dark = sky.light(points, normals, lambda *axes: np.zeros((64, 64)), np.array([0, 0, 1.0]), (0, 0, 1), np.zeros(3), 1.0, 64)
        self.assertAlmostEqual(dark[0], sky.AMBIENT)

    def test_phase_of_a_beat(self):
        time, phase = np.linspace(0, 10, 401), np.array([0, 0.25, 0.6, 0.9])
        tips = np.stack([np.cos(2 * np.pi * (time[:, None] / 1.25 + phase)), 0.1 * np.sin(time)[:, None] + 0 * phase, 0 * time[:, None] + phase], axis=-1)
        found, period = phases(time, tips)
        self.assertAlmostEqual(period, 1.25, delta=0.02)
        np.testing.assert_allclose((found - phase + 0.5) % 1 - 0.5, 0, atol=0.08)


    def test_sections_may_change_their_shape(self):
        """The file has the root of the product of both semi-axes, here constant; the ratio grows from 0.25 to 4."""
        nodes, flat = np.linspace([0, 0, 0], [0, 0, 1], 5)[None], np.array([[0.25, 0.5, 1, 2, 4]])
        mesh = shapes.tubes(nodes, 0.1 / np.sqrt(flat), np.ones((1, 5, 3)), 64, np.tile([1.0, 0, 0], (1, 5, 1)), flat, caps=0)
        for k, ratio in enumerate(flat[0]):
            ring = mesh.points[np.isclose(mesh.points[:, 2], 0.25 * k)]
            self.assertAlmostEqual(ring[:, 0].max(), 0.1 / np.sqrt(ratio), places=6)
            self.assertAlmostEqual(ring[:, 1].max(), 0.1 * np.sqrt(ratio), places=6)

    def test_ratio_of_both_radii_along_the_rod(self):
        """As src/rod/sections.cpp has them: the scale along d1 is that along d2 too, unless the latter has its own."""
        own = {"radius": 4e-3, "radius_2": 2e-3, "profile": [], "profile_2": [], "radius_formula": "", "radius_2_formula": "", "taper": 1.0}
        for given, shares, elements in (({}, [], [0.5, 0.5, 0.5, 0.5]),
                                        ({"taper": 0.2}, [], [0.5, 0.5, 0.5, 0.5]),
                                        ({"profile": [1, 2, 4, 8]}, [], [0.5, 0.5, 0.5, 0.5]),
                                        ({"profile_2": [1, 2, 4, 8]}, [], [0.5, 1, 2, 4]),
                                        ({"profile": [1, 2, 4, 8], "profile_2": [1, 1, 2, 2]}, [], [0.5, 0.25, 0.25, 0.125]),
                                        ({"taper": 0.2, "profile_2": [1, 1, 1, 1]}, [], [0.5 / 0.9, 0.5 / 0.7, 0.5 / 0.5, 0.5 / 0.3]),
                                        ({"radius_formula": "a*(1 + s/L)"}, [], [0.5, 0.5, 0.5, 0.5]),
                                        ({"radius_2_formula": "2e-3*(1 + s/L)"}, [], [0.5 * 1.125, 0.5 * 1.375, 0.5 * 1.625, 0.5 * 1.875]),
                                        ({"radius_formula": "a*(1 + s/L)", "radius_2_formula": "a"}, [], [1 / 1.125, 1 / 1.375, 1 / 1.625, 1 / 1.875]),
                                        ({"taper": 0.2, "radius_2_formula": "a"}, [], [1 / 0.9, 1 / 0.7, 1 / 0.5, 1 / 0.3]),
                                        ({"radius_2_formula": "2e-3*(1 + s/L)"}, [1, 1, 1, 5], [0.5 * 1.0625, 0.5 * 1.1875, 0.5 * 1.3125, 0.5 * 1.6875])):
            with self.subTest(given=given, shares=shares):
                rods = {"name": "flat", "section": own | {"kind": "elliptic"} | given, "shape": {"elements": 4, "length": 0.3, "length_profile": shares}}
                group = Group(SimpleNamespace(physics={"rods": [rods]}, constants={"a": 4e-3}), "flat")
                a, b, c, d = elements
                np.testing.assert_allclose(group.flatness, [a, (a + b) / 2, (b + c) / 2, (c + d) / 2, d], rtol=1e-12)

    def test_rectangular_sections_lie_along_their_directors(self):
        nodes = np.linspace([0, 0, 0], [0, 0, 1], 5)[None]
        d1, d2 = np.array([0.6, 0.8, 0]), np.array([-0.8, 0.6, 0])
        mesh = shapes.bars(nodes, np.full((1, 5), 0.1), np.full((1, 5), 0.03), np.ones((1, 5, 3)), np.tile(d1, (1, 5, 1)), 3)
        along, across = mesh.points @ d1, mesh.points @ d2
        np.testing.assert_allclose(np.maximum(np.abs(along) / 0.1, np.abs(across) / 0.03), 1, atol=1e-12)
        corner = mesh.points[mesh.faces]
        cross = 0.5 * np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
        self.assertAlmostEqual(np.sum(cross * corner.mean(axis=1)) / 3, 0.2 * 0.06 * 1.0, places=12)
        self.assertTrue(np.all(np.sum(cross * mesh.normals[mesh.faces].mean(axis=1), axis=1) > 0), "normals point outwards")

    def test_strain_of_elements(self):
        nodes = np.cumsum([[0, 0, 0], [0.11, 0, 0], [0, 0.22, 0], [0, 0, 0.3]], axis=0)[None]
        np.testing.assert_allclose(strain_of(nodes, np.array([0.1, 0.2, 0.3])), [[0.1, 0.1, 0.05, 0.0]], atol=1e-12)

    def test_maps_of_two_hues_have_their_middle_at_zero(self):
        middle = np.asarray(bright("RdBu_r")(0.5)[:3])
        self.assertLess(np.ptp(middle), 0.02)
        self.assertGreater(middle.min(), 0.9)
        for name in ("viridis", "cividis", "magma"):
            self.assertGreater(sum(bright(name)(0.0)[:3]), 0.3 + 0.05, "what is darkest stays readable")

    def test_words_of_colour_bars_do_not_touch(self):
        """Numbers of any size, on a bar of a small picture."""
        for low, high, unit in ((0, 3.2e-8, ""), (-4.1e-5, 4.1e-5, ""), (0, 2.3e-7, "1/m"), (0, 7.7e6, "1/s"), (1.0, 1.00003, "m"), (-123456, 98765, "1/s"), (0, 5.5e-13, "N"), (0, 0.31, "m/s"), (3, 3.0002, "Pa")):
            with self.subTest(low=low, high=high, unit=unit):
                words, factor = named("some quantity", unit, max(abs(low), abs(high)))
                figure = sheet.blank(480, 360)
                sheet.colour_bar(figure, [0.36, 0.062, 0.28, 0.011], Scale(words, low, high, bright("viridis"), factor), 4)
                figure.canvas.draw()
                axes = figure.axes[0]
                shown = [label for label in axes.get_xticklabels() if label.get_text()]
                boxes = [label.get_window_extent() for label in shown]
                self.assertGreaterEqual(len(boxes), 1)
                self.assertFalse([1 for a, b in zip(boxes, boxes[1:]) if a.x1 > b.x0], [label.get_text() for label in shown])
                self.assertEqual(len({label.get_text() for label in shown}), len(shown))
                for label, place in zip(shown, axes.get_xticks()):
                    self.assertAlmostEqual(float(label.get_text().replace("\u2212", "-")), place, delta=0.02 * factor * (high - low))

    def test_units_of_small_numbers(self):
        for most, unit, words, factor in ((2e-7, "1/m", "w [10⁻⁹ 1/m]", 1e9), (0.5, "1/m", "w [1/m]", 1), (3e-8, "", "w [10⁻⁹]", 1e9), (4e-5, "", "w [10⁻⁶]", 1e6), (2e-3, "N", "w [mN]", 1e3),
                                          (2e-14, "N", "w [10⁻¹⁵ N]", 1e15), (5e6, "1/s", "w [10⁶ 1/s]", 1e-6)):
            self.assertEqual(named("w", unit, most)[0], words)
            self.assertAlmostEqual(named("w", unit, most)[1] / factor, 1)


def vortex(cells, length=2.0, lower=(-1.0, -1.0, -1.0)):
    """A swirl about z that decays outwards: velocity, vorticity and Q [z, y, x(, 3)] at the middles of cells."""
    spacing = length / cells
    z, y, x = np.meshgrid(*[np.asarray(lower)[i] + spacing * (np.arange(cells) + 0.5) for i in (2, 1, 0)], indexing="ij")
    e = np.exp(-4 * (x**2 + y**2))
    velocity = np.stack([-y * e, x * e, 0.1 * np.sin(z)], axis=-1)
    vorticity = np.stack([0 * x, 0 * x, (2 - 8 * (x**2 + y**2)) * e], axis=-1)
    du_dx, du_dy, dv_dx, dv_dy, dw_dz = 8 * x * y * e, (8 * y**2 - 1) * e, (1 - 8 * x**2) * e, -8 * x * y * e, 0.1 * np.cos(z)
    return velocity, vorticity, -0.5 * (du_dx**2 + dv_dy**2 + dw_dz**2 + 2 * du_dy * dv_dx), spacing


class Vortices(unittest.TestCase):
    """Pictures of a fluid whose field is known."""

    @classmethod
    def setUpClass(cls):
        cls.directory = Directory()
        cls.out = cls.directory.path / "vortex"
        cls.write(cls.out, ("velocity", "vorticity", "q"))

    @classmethod
    def tearDownClass(cls):
        cls.directory.close()

    @classmethod
    def write(cls, out, fields, cells=24):
        """The files of a run that has written them at two times, the second with the swirl reversed; a sphere rests in it."""
        out.mkdir()
        velocity, vorticity, q, spacing = vortex(cells)
        (out / "physics.json").write_text(json.dumps({
            "time": {}, "fluid": {"cells": [cells] * 3, "spacing": spacing, "lower": [-1, -1, -1]},
            "obstacle": [{"kind": "sphere", "centre": [0.0, 0.0, 0.0], "radius": 0.1, "velocity": [0, 0, 0], "amplitude": [0, 0, 0], "frequency": 0}]}))
        for number, sign in enumerate((1, -1)):
            with h5py.File(out / f"fields_{number * 10:012d}.h5", "w") as file:
                file.attrs.update({"format": "skein fields", "kind": "box", "spacing": spacing, "time": 0.5 * number, "step": 10 * number, "lower_x": -1.0, "lower_y": -1.0, "lower_z": -1.0})
                for name, values in (("velocity", sign * velocity), ("vorticity", sign * vorticity), ("q", q)):
                    if name in fields:
                        file[name] = values.astype(np.float32)

    def image(self, out=None, time=0.0, **choice):
        return Pictures(out or self.out, [time], (320, 240), "plain", **choice)

    def test_vorticity_and_q_are_of_second_order(self):
        errors = []
        for cells in (16, 32, 64):
            velocity, vorticity, q, spacing = vortex(cells)
            errors.append([np.abs(vorticity_of(velocity, spacing) - vorticity).max(), np.abs(q_of(velocity, spacing) - q).max()])
        ratio = np.array(errors[1]) / errors[2]
        self.assertTrue(np.all((ratio > 3.3) & (ratio < 5)), errors)

    def test_velocities_alone_are_enough(self):
        """For vorticity and Q, which agree with those in the files of a run that has them."""
        alone = self.directory.path / "velocity_alone"
        self.write(alone, ("velocity",))
        output, full = skein.open(alone).fluid["fields"], skein.open(self.out).fluid["fields"]
        for quantity in ("vorticity_z", "vorticity", "q"):
            self.assertTrue(output.has(quantity))
            exact = full.read(0, quantity).values
            np.testing.assert_allclose(output.read(0, quantity).values, exact, atol=0.06 * np.abs(exact).max())
        self.assertFalse(output.has("pressure"))

    def test_cuts_are_linear_between_cells(self):
        z, y, x = np.meshgrid(*[np.arange(4) + 0.5] * 3, indexing="ij")
        field = Field(3 * x + 5 * y + 7 * z, np.zeros(3), 1.0)
        for axis, slope, at in (("x", 3, 1.2), ("y", 5, 2.0), ("z", 7, 3.4)):
            values = cut(field, axis, at).values
            others = field.values - slope * {"x": x, "y": y, "z": z}[axis]
            np.testing.assert_allclose(np.ravel(values), np.ravel(np.take(others, [0], 2 - "xyz".index(axis)) + slope * at))
        with self.assertRaisesRegex(NotResults, "between z = 0 and 4 m"):
            cut(field, "z", 4.5)

    def test_level_surfaces_of_a_ball(self):
        """Area and volume to second order, closed, normals outwards, values at points."""
        errors = []
        for cells in (12, 24):
            axis = (np.arange(cells) + 0.5) / cells * 2 - 1
            z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
            points, normals, triangles, values = flow.level_surface(0.49 - x**2 - y**2 - z**2, 0.0, x)
            points = (points + 0.5) / cells * 2 - 1
            corner = points[triangles]
            cross = 0.5 * np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
            self.assertTrue(np.all(np.sum(normals * points, axis=1) > 0.6))
            np.testing.assert_allclose(cross.sum(axis=0), 0, atol=1e-12)
            np.testing.assert_allclose(values, points[:, 0], atol=1e-12)
            errors.append([np.linalg.norm(cross, axis=1).sum() / (4 * np.pi * 0.49) - 1, np.sum(cross * corner.mean(axis=1)) / 3 / (4 / 3 * np.pi * 0.343) - 1])
        self.assertTrue(np.all(np.abs(errors[1]) < 0.03) and np.all(np.abs(errors[0]) > 2.5 * np.abs(errors[1])), errors)

    def test_colours_of_a_slice_are_those_of_the_bar(self):
        for renderer in RENDERERS:
            pictures = Pictures(self.out, [0.0], (320, 240), renderer, slices=(("z", 0.3),), fluid="vorticity_z")
            output = skein.open(self.out).fluid["fields"]
            field = cut(output.read(0, "vorticity_z"), "z", 0.3)
            for row, column in ((3, 3), (12, 20), (5, 17), (20, 9)):
                place = field.lower + field.spacing * (np.array([column, row, 0]) + 0.5)
                x, y = pictures.pixels(place[None])[0]
                expected = 255 * pictures.view.flow.scale.paint(field.values[0, row, column:column + 1])[0]
                np.testing.assert_allclose(pictures.images[0][int(y), int(x)], expected, atol=22, err_msg=f"{renderer} {row} {column}")

    def test_planes_and_times_differ(self):
        shown = {"slices": (("x", 0.2),), "fluid": "velocity_y", "fluid_limits": (-0.3, 0.3)}
        one = self.image(**shown).images[0].astype(int)
        for other in (self.image(**shown | {"slices": (("x", 0.6),)}), self.image(**shown | {"slices": (("y", 0.2),)}), self.image(time=0.5, **shown), self.image(**shown | {"fluid": "vorticity_z"})):
            self.assertGreater(np.mean(np.abs(other.images[0].astype(int) - one).max(axis=2) > 20), 0.02)

    def test_ranges_of_colours(self):
        speed = self.image(slices=(("z", 0.0),)).view.flow
        self.assertEqual((speed.quantity, speed.scale.low), ("speed", 0.0))
        signed = self.image(slices=(("z", 0.0),), fluid="vorticity_z").view.flow.scale
        self.assertEqual(signed.low, -signed.high)
        self.assertLess(signed.high, 2.01)
        given = self.image(slices=(("z", 0.0),), fluid_limits=(0.1, 0.2)).view.flow.scale
        self.assertEqual((given.low, given.high), (0.1, 0.2))

    def test_surfaces_lie_where_q_has_the_level(self):
        """Around the axis of the swirl, beyond the sphere; the automatic one around 2 % of the volume."""
        view = self.image(q=0.5).view
        points = view.flow.surfaces(0.0).points
        x, y, z = points.T
        radius = np.hypot(x, y)
        e = np.exp(-4 * radius**2)
        exact = -0.5 * ((8 * x * y * e)**2 * 2 + (0.1 * np.cos(z))**2 + 2 * (8 * y**2 - 1) * e * (1 - 8 * x**2) * e)
        np.testing.assert_allclose(exact, 0.5, atol=0.04)  # linear between cells
        automatic = self.image(q="auto").view.flow
        q = skein.open(self.out).fluid["fields"].read(0, "q").values
        self.assertAlmostEqual(np.mean(q > automatic.level), 0.02, delta=0.008)

    def changed(self, name, physics=None, moved=None):
        """A run as that of this class, with other physics, and the box of its second frame moved along x."""
        out = self.directory.path / name
        self.write(out, ("velocity", "vorticity", "q"))
        tree = json.loads((out / "physics.json").read_text())
        for key, value in (physics or {}).items():
            tree[key] = {**tree[key], **value} if isinstance(value, dict) else value
        (out / "physics.json").write_text(json.dumps(tree))
        if moved:
            with h5py.File(out / "fields_000000000010.h5", "r+") as file:
                file.attrs["lower_x"] = -1.0 + moved
        return out

    def test_the_automatic_level_of_an_output_of_means(self):
        """Of cubes of two cells an edge: the share is of the volume of the fluid."""
        level = self.image(q="auto").view.flow.level
        self.assertEqual(self.image(self.changed("means", {"fluid": {"cells": [48] * 3, "spacing": 1 / 24}}), q="auto").view.flow.level, level)

    def test_boxes_given_by_margins(self):
        """The scene has neither cells nor a corner: the files of the fluid have them."""
        column = {"kind": "cylinder", "centre": [0.0, 0.0, 0.0], "radius": 0.1, "second_radius": 0.0, "velocity": [0, 0, 0], "amplitude": [0, 0, 0], "frequency": 0}
        given, fitted = self.changed("given", {"obstacle": [column]}), self.changed("fitted", {"fluid": {"cells": [], "lower": [0, 0, 0]}, "obstacle": [column]})
        for choice in ({"q": "auto"}, {"slices": (("y", 0.2),)}, {"slices": (("z", 0.3),)}):
            with self.subTest(choice=choice):
                one, other = (self.image(out, **choice).view.flow for out in (given, fitted))
                self.assertEqual(one.level, other.level)
                columns = [shown.obstacles(0.0)[0].points for shown in (one, other)]
                np.testing.assert_array_equal(*columns)
                self.assertAlmostEqual(columns[1][:, 2].min(), -1)
                self.assertAlmostEqual(columns[1][:, 2].max(), 0.3 if choice.get("slices") == (("z", 0.3),) else 1, delta=2e-4)

    def test_boxes_that_move(self):
        """Pictures have room for the box at all of their times."""
        out = self.changed("moving", moved=3.0)
        for times, low, high in (([0.0], -1, 1), ([0.5], 2, 4), ([0.0, 0.5], -1, 4)):
            view = Pictures(out, times, (320, 240), "plain", slices=(("z", 0.0),)).view
            self.assertAlmostEqual(view.flow_corners[:, 0].min(), low)
            self.assertAlmostEqual(view.flow_corners[:, 0].max(), high)
            places = [float(words) for _, words, where in view.flow.marks() if where == "below"]
            self.assertTrue(low <= min(places) < low + 1 and high - 1 < max(places) <= high, places)
        for time, at in ((0.0, -0.5), (0.5, 3.5)):
            self.image(out, time=time, slices=(("x", at),))
        with self.assertRaisesRegex(NotResults, "the slice at -0.5 m"):
            self.image(out, time=0.5, slices=(("x", -0.5),))

    def test_obstacles_are_drawn(self):
        picture = self.image(slices=(("z", 0.0),), fluid="vorticity_z")
        x, y = picture.pixels(np.array([[0.0, 0.0, 0.1]]))[0]
        self.assertLess(np.ptp(picture.images[0][int(y), int(x)].astype(int)), 40, "grey over the reddest place")

    def test_axes_of_a_plane(self):
        """Words at places of the plane that they name; of two planes there are none."""
        view = self.image(slices=(("y", 0.2),)).view
        for point, words, where in view.flow.marks():
            if where in ("below", "left"):
                self.assertAlmostEqual(point[0 if where == "below" else 2], float(words))
            self.assertEqual(point[1], 0.2)
        self.assertEqual({words for _, words, where in view.flow.marks() if "all" in where}, {"x [m]", "z [m]"})
        self.assertFalse(self.image(slices=(("y", 0.2), ("x", 0.0))).view.flow.marks())

    def test_movies_have_the_frames_of_the_fluid(self):
        told = []
        to = movie(self.out, self.directory.path / "swirl.gif", size=(160, 120), renderer="plain", slices=(("z", 0.0),), fluid="vorticity_z", told=lambda *counts: told.append(counts))
        with Image.open(to) as drawn:
            self.assertEqual(drawn.n_frames, 2)
        self.assertEqual(told, [(1, 2), (2, 2)])

    def test_blocks_are_put_in_their_places(self):
        blocks = self.directory.path / "blocks"
        self.write(blocks, ("velocity",), 8)
        for path in blocks.glob("fields_*"):
            path.unlink()
        with h5py.File(blocks / "fluid_eddies_000000000004.h5", "w") as file:
            file.attrs.update({"format": "skein fields", "kind": "blocks", "spacing": 0.25, "time": 0.1, "step": 4, "lower_x": -1.0, "lower_y": -1.0, "lower_z": -1.0})
            file["lower"] = np.array([[-1.0, -1.0, -1.0], [0.0, -1.0, -1.0]])
            file["q"] = np.stack([np.full((4, 4, 4), 1.0), np.full((4, 4, 4), 2.0)])
        output = skein.open(blocks).fluid["eddies"]
        field = output.read(0, "q")
        np.testing.assert_allclose(field.lower, -1.25)
        self.assertEqual(field.values.shape, (6, 6, 10))
        np.testing.assert_array_equal(field.values[2, 2], [0, 1, 1, 1, 1, 2, 2, 2, 2, 0])
        np.testing.assert_array_equal(field.values[0], 0)
        np.testing.assert_allclose(output.corners(0), [[-1, -1, -1], [1, 0, 0]])

    def test_mistakes_are_sentences(self):
        for words, said in ((("--slice", "w=1"), "is no plane"), (("--slice", "z"), "is no plane"), (("--slice", "z=3"), "there is -1 to 1 m"), (("--q", "much"), "no level of Q"), (("--slice", "z=0", "--fluid", "heat"), "no quantity 'heat'"),
                            (("--slice", "z=0", "--fluid", "pressure"), "has pressure"), (("--slice", "z=0", "--html", "no.html"), "--slice and --q are of pictures"), ((), "--slice and --q draw the fluid")):
            done = subprocess.run([SKEIN, "draw", self.out, *words], capture_output=True, text=True, timeout=100, env=dict(os.environ, PYTHON=sys.executable))
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)

    def test_a_run_with_rods_in_a_fluid(self):
        """The frames of the program itself: of those with rods the picture takes one at which there is a fluid too."""
        out = self.directory.path / "filament"
        done = subprocess.run([SKEIN, "run", str(APPS / "recipes/fluid.toml"), "--out", str(out), "-q", "--set=time.duration=0.06", "--set=fluid.cells=[32,16,16]", "--set=fluid.spacing=0.1",
                               "--set=output.fields=0.05", "--set=output.trajectory=0.01", "--set=output.series=0.03"], capture_output=True, text=True, timeout=200)
        if "SKEIN_FLUID" in done.stderr:
            self.skipTest("built without the fluid")
        self.assertEqual(done.returncode, 0, done.stderr)
        run = skein.open(out)
        self.assertGreaterEqual(len(run.fluid["fields"].paths), 2)
        image = self.image(out, time=0.05, slices=(("y", 0.0),), fluid="vorticity_y", colour="group")
        self.assertEqual(image.view.legend, [])
        found = run.fluid["fields"]
        inner = (slice(1, -1),) * 3
        velocity = np.stack([found.read(-1, f"velocity_{axis}").values for axis in "xyz"], axis=-1)
        exact = found.read(-1, "vorticity_y").values[inner]
        np.testing.assert_allclose(vorticity_of(velocity, found.spacing)[inner][..., 1], exact, rtol=0, atol=2e-7 * np.abs(exact).max())  # single precision


class Draw(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = Directory()
        cls.out = cls.directory.out

    @classmethod
    def tearDownClass(cls):
        cls.directory.close()

    def command(self, *words, code=0, **environment):
        done = subprocess.run([SKEIN, "draw", *map(str, words)], capture_output=True, text=True, timeout=200, env=dict(os.environ, PYTHON=sys.executable, **environment))
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_pictures_from_above_are_not_empty(self):
        for renderer in RENDERERS:
            image = Pictures(self.out, [0.2], (320, 240), renderer, camera=(0, 0, 1), colour="group", ground=False, walls=False).images[0]
            self.assertGreater(np.mean(np.any(np.asarray(image)[..., :3] < 200, axis=-1)), 0.002, renderer)

    def test_words_that_draw_does_not_know(self):
        for words, said in ((("--colur", "speed"), "draw has no option '--colur'; did you mean '--colour'?"), (("--camera", "0,0"), "'0,0' is no direction")):
            done = self.command(self.out, *words, code=2)
            self.assertIn(said, done.stderr)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        done = self.command(self.out / "nothing", code=2)
        self.assertRegex(done.stderr, "^error: .*nothing: no such directory")

    def test_pictures_show_rods_where_they_are(self):
        """Along the axis of every rod that nothing hides there is its colour; in the corners there is paper."""
        for renderer in RENDERERS:
            with self.subTest(renderer=renderer):
                colours = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
                pictures = Pictures(self.out, [0.0, 0.2], (640, 480), renderer, groups=("reeds",), colour=colours, camera=(0, -1, 0.2))
                for number, frame in enumerate((0, -1)):
                    nodes = skein.open(self.out)["reeds"].position[frame]
                    for rod in range(3):
                        for point in pictures.pixels(nodes[rod, 1:-1]):
                            pixel = pictures.images[number][int(point[1]), int(point[0])].astype(int)
                            self.assertEqual(np.argmax(pixel), rod, (rod, point, pixel))
                            self.assertGreater(pixel[rod] - np.delete(pixel, rod).max(), 20)
                    np.testing.assert_array_equal(pictures.images[number][2, 2], 255)

    def test_elliptic_rods_have_their_axes(self):
        view = View(skein.open(self.out), [0], Choice(groups=("flat",), colour="group"), 1.0)
        points = view.shown(0).mesh.points
        normal, tangent = skein.open(self.out)["flat"].normal[0, 0, 3].astype(float), np.array([1.0, 0, 0])
        middle = np.abs(points[:, 0] - points[:, 0].mean()) < 0.02
        centre = points[middle].mean(axis=0)
        for axis, extent in ((normal, 4e-3), (np.cross(tangent, normal), 2e-3)):
            self.assertAlmostEqual(np.abs((points[middle] - centre) @ axis).max() / extent, 1, delta=0.02)

    def test_shadows(self):
        if WHY_NOT:
            self.skipTest(WHY_NOT)
        lit, bare = (Pictures(self.out, [0.2], (320, 240), "vtk", ground=ground, groups=("reeds",)).images[0] for ground in (True, False))
        grey = lambda image: np.sum((image.max(axis=2) < 250) & (np.ptp(image, axis=2) < 6))  # noqa: E731
        self.assertGreater(grey(lit), 3 * grey(bare) + 200)

    def test_groups_have_a_legend(self):
        """Of the groups that are shown, where the colour is theirs and there are several."""
        run = skein.open(self.out)
        view = View(run, [0], Choice(colour="group"), 1.0)
        self.assertEqual([name for name, _ in view.legend], ["reeds", "flat"])
        for name, colour in view.legend:
            np.testing.assert_array_equal(view.paint.of(run[name], 0)[0, 0], colour)
        self.assertFalse(View(run, [0], Choice(colour="group", groups=("flat",)), 1.0).legend)
        self.assertFalse(View(run, [0], Choice(colour="curvature"), 1.0).legend)
        plain, named_ones = (sheet.Sheet(400, 300, "t", [], True, legend).filled(np.full((300, 400, 3), 255, np.uint8), "") for legend in ([], view.legend))
        changed = np.any(plain != named_ones, axis=2)
        self.assertGreater(changed.sum(), 60)
        self.assertFalse(changed[:260].any(), "in the room for words")

    def test_many_groups_fit_their_legend(self):
        drawn = sheet.Sheet(400, 300, "t", [], True, [(f"a group with a long name {k}", (0.2, 0.4, 0.6)) for k in range(30)])
        drawn.figure.canvas.draw()
        box = drawn.figure.legends[0].get_window_extent()
        self.assertTrue(box.x0 >= 0 and box.x1 <= 400 and len(drawn.figure.legends[0].get_texts()) <= sheet.MOST_NAMED)

    def test_strain_of_a_relaxation(self):
        """It has no poly data of its last step; with frames the poly data has the same strain."""
        scene, out = APPS / "gallery/elastica.toml", [self.directory.path / name for name in ("relaxed", "with_frames")]
        for to, keys in zip(out, ((), ("--set=output.trajectory=0.1",))):
            subprocess.run([SKEIN, "run", str(scene), "--out", str(to), "-q", *keys], check=True, timeout=100)
        runs = [skein.open(to) for to in out]
        self.assertFalse(runs[0].has_field(0, "strain"))
        exact = runs[1].rods[0].field(len(runs[1].frames) - 1, "strain")
        found = View(runs[0], [0], Choice(colour="strain"), 1.0).paint._values_of(runs[0].rods[0], 0)
        np.testing.assert_allclose(found, exact, atol=0.05 * np.abs(exact).max())
        self.assertEqual(when(runs[0], 0), f"{runs[0].summary['steps']} steps")
        (out[0] / "summary.json").unlink()  # as during a run
        self.assertEqual(when(skein.open(out[0]), 0), when(runs[0], 0))
        self.assertEqual(when(skein.open(self.out), 0), "0.00 ms")

    def test_progress_is_for_terminals(self):
        """A line with the time that is left on a terminal, nothing in a pipe."""
        import pty
        words = [SKEIN, "draw", str(self.out), "--movie", str(self.directory.path / "told.gif"), "--every", "8", "--size", "160x120", "--renderer", "plain", "--detail", "0.2"]
        self.assertEqual(self.command(*words[2:]).stderr, "")
        ours, theirs = pty.openpty()
        subprocess.run(words, stdout=subprocess.DEVNULL, stderr=theirs, timeout=100, check=True, env=dict(os.environ, PYTHON=sys.executable))
        os.close(theirs)
        said = os.read(ours, 4096).decode()
        os.close(ours)
        self.assertRegex(said, r"frame 1 of 3, \d+ s left")
        self.assertRegex(said, r"frame 3 of 3, \d+ s")

    def test_every_colour(self):
        for colour in CHOICES:
            if colour == "magnetisation":
                continue
            with self.subTest(colour=colour):
                to = self.directory.path / f"{colour}.png"
                skein.draw(self.out, to, size=(320, 240), renderer="plain", colour=colour, detail=0.2)
                with Image.open(to) as image:
                    self.assertEqual(image.size, (320, 240))

    def test_command(self):
        for renderer in RENDERERS:
            to = self.directory.path / f"{renderer}.png"
            said = self.command(self.out, "--to", to, "--time", "0.1", "--size", "400x300", "--renderer", renderer).stdout
            self.assertIn(str(to), said)
            image = np.asarray(Image.open(to).convert("RGB"))
            self.assertEqual(image.shape, (300, 400, 3))
            self.assertGreater(np.sum(image.min(axis=2) < 200), 500)
        self.command(self.out, "--size", "200x150", "--renderer", "plain")
        self.assertTrue((self.out / "picture.png").exists())
        self.assertFalse(list(self.out.glob(".part*")))

    def test_every_scene_of_the_cases(self):
        """After a few steps, from frames or the checkpoint; but for the largest, which take minutes in matplotlib, and those without rods.
        In this process: to start Python and matplotlib takes as long as to draw, and test_command does."""
        mask = self.directory.path / "four.pbm"
        mask.write_text("P1\n2 2\n1 1\n1 1\n")
        for scene in sorted(APPS.glob("*/*.toml")):
            if scene.stem in ("farm_111797", "nest_1536", "nest_1536_published") or "\n[fluid]" in scene.read_text():
                continue
            with self.subTest(scene=scene.name):
                out = self.directory.path / scene.stem
                fewer = ["--set", SMALLER[scene.stem].format(mask=mask)] if scene.stem in SMALLER else []
                done = subprocess.run([SKEIN, "run", str(scene), "--out", str(out), "-q", "--steps", "16", *fewer], capture_output=True, text=True, timeout=100)
                self.assertIn(done.returncode, (0, 3), done.stderr)
                skein.draw(out, size=(240, 180), renderer="plain", detail=0.3)
                with Image.open(out / "picture.png") as image:
                    self.assertGreater(np.sum(np.asarray(image.convert("RGB")).min(axis=2) < 200), 100)

    def test_movie(self):
        to = self.directory.path / "movie.gif"
        self.command(self.out, "--movie", to, "--every", "4", "--size", "200x150", "--renderer", "plain", "--detail", "0.2")
        with Image.open(to) as movie:
            self.assertEqual(movie.n_frames, 6)
            first = np.asarray(movie.convert("RGB")).astype(int)
            movie.seek(5)
            self.assertGreater(np.abs(np.asarray(movie.convert("RGB")).astype(int) - first).max(), 60)
        self.assertIn("no such kind of movie", self.command(self.out, "--movie", "a.avo", code=2).stderr)

    def test_a_state_for_paraview(self):
        to = self.directory.path / "view.py"
        self.command(self.out, "--paraview", to, "--colour", "speed", "--time", "0.1")
        compile(to.read_text(), str(to), "exec")
        self.assertIn("no colour 'phase' in ParaView", self.command(self.out, "--paraview", to.with_name("no.py"), "--colour", "phase", code=2).stderr)
        if WHY_NOT or subprocess.run([sys.executable, "-c", "import paraview.simple"], capture_output=True).returncode:
            self.skipTest("no ParaView")
        shot = self.directory.path / "paraview.png"
        program = f"exec(open({str(to)!r}).read()); SaveScreenshot({str(shot)!r}, view, ImageResolution=[480, 270])"
        vtk_stage.why_not()  # there is a display from now on
        subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, timeout=200, env=dict(os.environ))
        with Image.open(shot) as image:
            pixels = np.asarray(image.convert("RGB")).astype(int)
        self.assertGreater(np.sum(np.ptp(pixels, axis=2) > 40), 300, "rods have colours")
        np.testing.assert_array_equal(pixels[3, 3], 255)

    def test_without_vtk_a_word_is_said(self):
        stub = self.directory.path / "stub"
        (stub / "vtkmodules").mkdir(parents=True)
        (stub / "vtkmodules/__init__.py").write_text("raise ImportError('none')\n")
        to = self.directory.path / "fallback.png"
        said = self.command(self.out, "--to", to, "--size", "200x150", PYTHONPATH=str(stub)).stderr
        self.assertIn("drawn by matplotlib", said)
        self.assertTrue(to.exists())
        self.assertIn("no picture by VTK", self.command(self.out, "--renderer", "vtk", code=2, PYTHONPATH=str(stub)).stderr)

    def test_mistakes_are_sentences(self):
        for words, text in ((["absent"], "no such directory"), ([self.out, "--colour", "sped"], "no colour 'sped'"), ([self.out, "--group", "red"], "no group 'red'"),
                            ([self.out, "--colour", "magnetisation"], "magnetisation")):
            done = self.command(*words, code=2)
            self.assertIn(text, done.stderr)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        self.assertIn("is no direction", self.command(self.out, "--camera", "1,2", code=2).stderr)

    def test_colours_of_rods_need_rods(self):
        door = self.directory.path / "door"
        subprocess.run([SKEIN, "run", str(APPS / "mechanisms/door.toml"), "--out", str(door), "-q", "--set=time.duration=0.04"], check=True)
        self.assertIn("bodies alone", self.command(door, "--colour", "speed", code=2).stderr)

    def test_a_run_with_frames_alone(self):
        alone = self.directory.path / "alone"
        subprocess.run([SKEIN, "run", str(self.directory.scene), "--out", str(alone), "-q", *(f"--set=output.{name}=0" for name in ("series", "tips", "contacts")),
                        "--set=output.paraview=none"], check=True)
        for colour in ("auto", "bending", "rod"):
            self.command(alone, "--size", "200x150", "--renderer", "plain", "--colour", colour)
        self.assertIn('set output.paraview = "vtp"', self.command(alone, "--colour", "speed", code=2).stderr)

    def test_a_run_without_frames(self):
        """Its checkpoint is drawn, as the frame of that step would be; without either that is said."""
        with_none = self.directory.path / "none"
        subprocess.run([SKEIN, "run", str(self.directory.scene), "--out", str(with_none), "-q", "--set", "output.trajectory=0"], check=True)
        self.assertIn("its newest checkpoint", self.command(with_none, "--size", "200x150", "--renderer", "plain").stderr)
        self.assertTrue((with_none / "picture.png").exists())
        framed, kept = skein.open(self.out), skein.open(with_none).of_checkpoint()
        for name in ("reeds", "flat"):
            half_a_step = 0.5 * framed.summary["dt_s"] * np.abs(framed.state()[name]["velocity"]).max()
            np.testing.assert_allclose(kept[name].position[0], framed[name].position[-1], rtol=0, atol=1.01 * half_a_step + 1e-7)
            np.testing.assert_allclose(kept[name].radius, framed[name].radius)
        for checkpoint in with_none.glob("checkpoint_*"):
            checkpoint.unlink()
        self.assertIn("set output.trajectory", self.command(with_none, code=2).stderr)

    def test_python_without_numpy(self):
        stub = self.directory.path / "no_numpy"
        stub.mkdir()
        (stub / "numpy.py").write_text("raise ModuleNotFoundError('No module named numpy')\n")
        done = self.command(self.out, code=1, PYTHONPATH=str(stub))
        self.assertIn("python3-numpy", done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)


class Gallery(unittest.TestCase):
    """Movies of all its scenes."""

    def run_script(self, *words):
        return subprocess.run([sys.executable, str(APPS / "gallery/movies.py"), *map(str, words), "--skein", SKEIN], capture_output=True, text=True, timeout=200,
                              env=dict(os.environ, PYTHON=sys.executable))

    def test_scenes_and_options_are_those_of_the_page(self):
        sys.path.insert(0, str(APPS / "gallery"))
        import movies
        known = movies.scenes((APPS / "gallery/README.md").read_text())
        own = {path.stem for path in (APPS / "gallery").glob("*.toml")}
        self.assertEqual(own - set(known), {"stokes_second"}, "a column of cells has no plane to draw")
        self.assertEqual(known["vortex_street"][2], ["--slice", "z=0.04", "--fluid", "vorticity_z"])
        self.assertEqual(known["hertz"][2], ["--ground", "0", "--zoom", "0.5"])
        self.assertEqual(known["ring"][1], ["--set", "time.duration=9.4"])
        self.assertEqual(movies.times_of(*known["ring"][:2]), (9.4, False, True))
        self.assertEqual(movies.times_of(*known["taylor_green"][:2])[2], False)
        self.assertTrue(movies.times_of(*known["elastica"][:2])[1])

    def test_movies_and_pictures(self):
        with tempfile.TemporaryDirectory() as folder:
            done = self.run_script(folder, "slope", "elastica", "--frames", "3", "--size", "160x120")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            with Image.open(f"{folder}/slope.gif") as drawn:
                self.assertEqual((drawn.size, drawn.n_frames), ((160, 120), 4))
            with Image.open(f"{folder}/elastica.png") as drawn:
                self.assertEqual(drawn.size, (160, 120))
            unknown = self.run_script(folder, "slpe")
            self.assertEqual((unknown.returncode, len(unknown.stderr.strip().splitlines())), (1, 1))


if __name__ == "__main__":
    unittest.main()
