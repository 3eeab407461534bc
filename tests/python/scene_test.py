"""skein.Scene and skein.run, plan and sweep: scenes from Python are those of files, with the same words about what is wrong."""

import os
import pathlib
import subprocess
import tempfile
import unittest
import unittest.mock

import numpy as np

from package import APPS, SKEIN, Directory, skein


def filament():
    scene = skein.Scene("filament", time={"duration": 0.1}, output={"trajectory": 0.05})
    scene.rods("filament", start="clamped", material={"density": 1200.0, "youngs_modulus": 2e6}, section={"radius": 3e-3},
               shape={"length": 0.2, "elements": 10}, origins=[[0, 0, 0], [0.1, 0, 0]], directions=[[0, 1, 0], [0, 1, 1]])
    return scene.load("gravity").damping("uniform", rate=10.0)


class Scenes(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def test_runs_as_its_file_does(self):
        scene = filament().check()
        run = skein.run(scene, self.folder / "a", quiet=True)
        path = scene.save(self.folder / "filament.toml")
        subprocess.run([SKEIN, "run", str(path), "--out", str(self.folder / "b"), "-q"], check=True)
        self.assertEqual(run.summary["digest"], skein.open(self.folder / "b").summary["digest"])
        np.testing.assert_allclose(run["filament"].origin, [[0, 0, 0], [0.1, 0, 0]])

    def test_keys_by_path(self):
        scene = filament()
        scene["rods.filament.shape.elements"] = 7
        scene["load.0.acceleration"] = [0, 0, -1.0]
        scene["time.duration"] = 0.05
        self.assertEqual((scene["rods.filament.shape.elements"], scene["load.0.kind"]), (7, "gravity"))
        self.assertEqual(skein.Simulation(scene)["filament"].elements, 7)
        other = scene.copy()
        other["rods.filament.shape.elements"] = 9
        self.assertEqual(scene["rods.filament.shape.elements"], 7)
        for path, words in (("rods.fil.shape", "there are filament"), ("load.3.kind", "no entry '3'"), ("output.series", "skein describe output.series")):
            with self.assertRaisesRegex(KeyError, words):
                scene[path]

    def test_an_arm_on_the_ground(self):
        """Bodies, joints and assemblies by name are the lists of a file."""
        scene = skein.Scene("arms", time={"duration": 0.001, "dt": 1e-5})
        scene.rods("links", assembly="arm", material={"density": 1000.0, "youngs_modulus": 1e7}, section={"radius": 0.02}, shape={"length": 0.5, "elements": 4})
        scene.bodies("hand", assembly="arm", mass=0.5, inertia=[1e-3] * 3, spheres={"radii": [0.05]}, placement={"origin": [0.0, 0.0, 0.5]})
        scene.assembly("arm", placement={"kind": "line", "counts": [2], "spacing": [1.0]}).table("turn", [0.0, 0.001], [0.0, 0.1], unit="rad")
        scene.joint("hinge", "links", axis=[0.0, 1.0, 0.0], at=[0.0], stiffness=1e4, torsional_stiffness=100.0, motor={"kind": "position", "value": "turn(t)", "stiffness": 50.0})
        scene.joint("fixed", "links", "hand", stiffness=1e4, torsional_stiffness=100.0)
        self.assertEqual([joint["between"] for joint in scene["joint"]], [["links", "world"], ["links", "hand"]])
        with skein.Simulation(scene) as run:
            run.step(run.steps)
            self.assertLess(run.observables["joint_gap[m]"], 1e-3)
            self.assertGreater(run.observables["joint_motor_work[J]"], 0)

    def test_mistakes_are_told_as_the_program_tells_them(self):
        scene = filament()
        scene["rods.filament.shape.elemets"] = 4
        with self.assertRaisesRegex(skein.RunFailed, r"filament.toml:\d+:\d+: unknown key 'elemets' in \[rods.shape\]; did you mean 'elements'"):
            scene.check()
        with self.assertRaisesRegex(skein.RunFailed, "did you mean 'elements'") as caught:
            skein.run(scene, self.folder / "never", quiet=True)
        self.assertEqual(caught.exception.code, 2)
        self.assertFalse((self.folder / "never").exists())
        with self.assertRaisesRegex(ValueError, "origins 2, directions 1"):
            skein.Scene().rods("a", origins=np.zeros((2, 3)), directions=np.ones((1, 3)))
        with self.assertRaisesRegex(KeyError, "no list 'loads'"):
            skein.Scene().add("loads")

    def test_many_places_go_into_a_file(self):
        count = 500
        origins, ways = np.random.default_rng(1).normal(size=(2, count, 3))
        scene = skein.Scene("hair", time={"duration": 0.01}, output={"trajectory": 0.01})
        scene.rods("hair", start="clamped", material={"density": 1300, "youngs_modulus": 1e6}, section={"radius": 5e-4}, shape={"length": 0.02, "elements": 4},
                   origins=origins, directions=ways)
        run = skein.run(scene, self.folder / "hair", quiet=True)
        np.testing.assert_allclose(run["hair"].origin, origins, atol=1e-12)
        first = run["hair"].position[0].astype(float)
        np.testing.assert_allclose((first[:, -1] - first[:, 0]) / 0.02, ways / np.linalg.norm(ways, axis=1, keepdims=True), atol=1e-4)

    def test_scenes_of_files_are_kept(self):
        """Every scene of the cases comes back as it was, with the files it names. Where rods touch, predicted times are measured, and with
        them what a failure costs."""
        untimed = lambda plan: [line for line in plan.splitlines() if "predicted" not in line and "a failure" not in line and "  method  " not in line]
        for path in sorted(APPS.glob("*/*.toml")):
            with self.subTest(scene=path.name):
                before, after = skein.plan(path), skein.plan(skein.Scene(path))
                self.assertEqual(untimed(before), untimed(after))

    def test_ranks_threads_and_overrides(self):
        directory = Directory()
        self.addCleanup(directory.close)
        digests = {skein.run(directory.scene, self.folder / f"{ranks}_{threads}", ranks=ranks, threads=threads, quiet=True,
                             **{"rods.reeds.shape.elements": 8}).summary["digest"] for ranks, threads in ((None, 2), (2, 1))}
        self.assertEqual(len(digests), 1)
        self.assertEqual(skein.open(self.folder / "2_1")["reeds"].elements, 8)

    def test_sweep(self):
        scene = filament()
        keys = {"rods.filament.shape.elements": [4, 8], "damping.0.rate": [1.0, 20.0]}
        measure = {"tip": lambda run: float(run["filament"].position[-1][0, -1, 2])}
        rows = skein.sweep(scene, keys, self.folder / "sweep", measure=measure)
        self.assertEqual([(row["rods.filament.shape.elements"], row["damping.0.rate"]) for row in rows], [(4, 1.0), (4, 20.0), (8, 1.0), (8, 20.0)])
        self.assertGreater(rows[1]["tip"], rows[0]["tip"], "the more damped falls less")
        self.assertEqual(len(set(rows.column("digest"))), 4)
        html = rows._repr_html_()
        self.assertEqual(html.count("<tr>"), 5, "a heading and four runs")
        self.assertIn(f"<td>{rows[1]['tip']:.6g}</td>", html)
        again = skein.sweep(scene, keys, self.folder / "sweep", measure=measure)
        self.assertEqual(again, rows, "runs that have ended are left as they are")
        with self.assertRaisesRegex(FileExistsError, "another sweep"):
            skein.sweep(scene, {"damping.0.rate": [3.0]}, self.folder / "sweep")
        failed = skein.sweep(scene, {"damping.0.rate": [-1.0, 1.0]}, self.folder / "other")
        self.assertIn("rate", failed[0]["error"])
        self.assertNotIn("error", failed[1])

    def test_lists_are_those_of_the_program(self):
        """Every list of tables that scenes may have can be added to; a joint and its assembly make a scene that the program takes."""
        from skein.program import description, lists
        known = lists()
        self.assertLess({"rods", "bodies", "load", "damping", "contact_pair", "wall", "table", "joint", "assembly", "obstacle", "fluid_output"}, {*known, "time"})
        page = (APPS.parent / "docs/scene.md").read_text()
        self.assertEqual({line[6:-3] for line in page.splitlines() if line.startswith("## `[[") and " " not in line[4:] and "." not in line} | {"load"}, set(known) | {"load"})
        for table in known:
            self.assertIn(f"[[{table}]]", skein.Scene("x").add(table, name="a").text())
        with self.assertRaisesRegex(KeyError, "did you mean 'joint'"):
            skein.Scene("x").add("jiont")
        units = {key["path"]: key["unit"] for key in description()["keys"]}
        self.assertEqual((units["rods.shape.length"], units["rods.material.youngs_modulus"], units["load.gravity.acceleration"]), ("m", "Pa", "m/s^2"))
        arm = skein.Scene("arm", time={"duration": 0.01}).add("assembly", name="arm")
        for name, height in (("lower", 0.0), ("upper", 0.1)):
            arm.rods(name, assembly="arm", material={"density": 1100.0, "youngs_modulus": 1e6}, section={"radius": 5e-3}, shape={"length": 0.1, "elements": 8},
                     placement={"origin": [0.0, 0.0, height], "tangent": [0.0, 0.0, 1.0]})
        arm.add("joint", kind="spherical", between=["lower", "upper"], at=[1, 0], stiffness=1e3)
        arm.check()
        self.assertEqual(repr(arm), "<Scene 'arm': assembly 'arm'; rods 'lower', 'upper'; joint spherical; 0.01 s>")

    def test_a_sweep_without_a_queue_is_an_error(self):
        with unittest.mock.patch.dict(os.environ, PATH=os.path.dirname(SKEIN)), self.assertRaisesRegex(FileNotFoundError, "sbatch is not in PATH"):
            skein.sweep(filament(), {"damping.0.rate": [1.0]}, self.folder / "none", slurm=True)

    def test_a_table_says_how_its_runs_ended(self):
        rows = skein.sweep(filament(), {"damping.0.rate": [1.0, -1.0]}, self.folder / "two")
        first, one, two = repr(rows).splitlines()
        self.assertEqual(first, "<Table of 2 runs, 1 failed or not ended>")
        self.assertRegex(one, "damping.0.rate = 1.0 .*digest [0-9a-f]{16}")
        self.assertRegex(two, "damping.0.rate = -1.0 .*error: ")

    def test_sweep_on_slurm(self):
        """Of a queue of its own, which notes what it is given."""
        scene = filament().save(self.folder / "filament.toml")
        queue = self.folder / "queue"
        queue.mkdir()
        (queue / "sbatch").write_text(f'#!/bin/sh\necho "$@" >>"{queue}/submitted"\n')
        (queue / "sbatch").chmod(0o755)
        with unittest.mock.patch.dict(os.environ, PATH=f"{queue}:{os.environ['PATH']}"):
            rows = skein.sweep(scene, {"damping.0.rate": [1.0, 20.0]}, self.folder / "jobs", slurm=True)
            self.assertEqual(rows.column("error"), ["not ended"] * 2)
            self.assertIn("--array=1-2", (self.folder / "jobs/sweep.sbatch").read_text())
            for line in (self.folder / "jobs/commands.txt").read_text().splitlines():  # what the jobs do
                subprocess.run(["bash", "-c", line], check=True)
            rows = skein.sweep(scene, {"damping.0.rate": [1.0, 20.0]}, self.folder / "jobs", slurm=True)
        self.assertTrue(all(rows.column("digest")))
        self.assertEqual((queue / "submitted").read_text(), f"{self.folder}/jobs/sweep.sbatch\n", "submitted once")


if __name__ == "__main__":
    unittest.main()
