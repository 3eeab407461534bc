"""skein draw: a picture of any run, by VTK and without; what it shows is where the rods are."""

import os
import subprocess
import sys
import unittest

import numpy as np

from package import APPS, SKEIN, Directory, skein

from PIL import Image
from skein.picture import shapes, sky, vtk_stage
from skein.picture.camera import framed
from skein.picture.colours import CHOICES, phases
from skein.picture.draw import Pictures
from skein.picture.view import Choice, View

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


if __name__ == "__main__":
    unittest.main()
