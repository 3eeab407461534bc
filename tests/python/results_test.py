"""skein.open: what a run has written comes back as it was written, across segments, and no more of it than is asked for."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from package import ROOT, Directory, skein


class Results(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = Directory()
        cls.run_ = skein.open(cls.directory.out)

    @classmethod
    def tearDownClass(cls):
        cls.run_.frames.close()
        cls.directory.close()

    def whole(self, name, group, kind="trajectory"):
        parts = []
        for path in sorted(self.directory.out.glob(f"{kind}_*.h5")):
            with h5py.File(path) as file:
                parts.append(file[f"groups/{group}/{name}"][:])
        self.assertGreater(len(parts), 1)
        return np.concatenate(parts)

    def test_groups_in_the_scenes_order(self):
        self.assertEqual(list(self.run_.groups), ["reeds", "flat", "ball"])
        self.assertEqual([(g.count, g.elements, g.is_body) for g in self.run_.groups.values()], [(3, 12, False), (1, 6, False), (1, 1, True)])
        with self.assertRaisesRegex(KeyError, "did you mean 'reeds'"):
            self.run_["reds"]

    def test_html_for_notebooks_is_escaped(self):
        html = self.run_._repr_html_()
        self.assertIn(self.run_.summary["digest"], html)
        self.assertIn("<th style='text-align:left'>group reeds</th><td>3 rods of 12 elements</td>", html)
        self.assertNotIn("<img", html)
        (self.directory.out / "picture.png").write_bytes(b"a picture")
        self.addCleanup((self.directory.out / "picture.png").unlink)
        self.assertIn("<img style='max-width:480px' src='data:image/png;base64,YSBwaWN0dXJl'>", self.run_._repr_html_())
        scene = skein.Scene("filament", time={"duration": 2.0}, title="<script>alert(1)</script>", rods=[{"name": "arm", "section": {"radius": 1e-3}}])
        html = scene._repr_html_()
        self.assertIn("&lt;script&gt;", html)
        self.assertNotIn("<script>", html)
        self.assertIn("<th style='text-align:left'>rods arm</th><td>section = {radius = 0.001}</td>", html)

    def test_every_way_of_indexing_is_numpys(self):
        for group, name in (("reeds", "position"), ("flat", "directors"), ("ball", "position")):
            whole, lazy = self.whole(name, group), getattr(self.run_[group], name)
            self.assertEqual((lazy.shape, lazy.dtype, len(lazy)), (whole.shape, whole.dtype, len(whole)))
            for key in (5, -1, slice(None), slice(3, 17), slice(None, None, 3), slice(None, None, -1), slice(18, 2, -5), [7, 2, 19], slice(0, 0),
                        (slice(2, 9), 0), (4, slice(None), -1), (slice(None), 0, slice(None), 2), (..., 1), np.arange(21) % 2 == 0):
                with self.subTest(group=group, key=key):
                    np.testing.assert_array_equal(lazy[key], whole[key])
            np.testing.assert_array_equal(np.asarray(lazy), whole)
            np.testing.assert_array_equal(np.stack(list(lazy)), whole)
            with self.assertRaises(IndexError):
                lazy[len(whole)]
        np.testing.assert_array_equal(np.asarray(self.run_["reeds"].tips), self.whole("position", "reeds", "tips"))

    def test_fields_are_those_of_the_nodes(self):
        """Velocities in the poly data of the last frame are those of the checkpoint there."""
        reeds = self.run_["reeds"]
        velocity = reeds.field(-1, "velocity")
        np.testing.assert_allclose(velocity, self.run_.state()["reeds"]["velocity"], atol=1e-6 * np.abs(velocity).max())
        self.assertGreater(np.abs(velocity).max(), 0)
        self.assertEqual(self.run_["flat"].field(-1, "strain").shape, (1, 7))
        with self.assertRaisesRegex(skein.NotResults, "no sped in"):
            reeds.field(0, "sped")

    def test_series_and_energies(self):
        series = self.run_.series
        text = (self.directory.out / "observables.csv").read_text().splitlines()
        self.assertEqual(series.headings, text[0].split(","))
        np.testing.assert_array_equal(series["time"], [float(line.split(",")[1]) for line in text[1:]])
        np.testing.assert_array_equal(series["elastic_bend[J]"], series["elastic_bend"])
        self.assertIn("elastic_bend", self.run_.energies)
        self.assertTrue(all(series.units[name] == "J" for name in self.run_.energies))
        with self.assertRaisesRegex(skein.NotResults, "did you mean elastic_bend"):
            series["elastic_bnd"]

    def test_pandas_and_xarray_where_they_are(self):
        for name, method in (("pandas", "to_pandas"), ("xarray", "to_xarray")):
            with self.subTest(package=name):
                try:
                    __import__(name)
                except ImportError:
                    continue
                table = getattr(self.run_.series, method)()
                np.testing.assert_array_equal(np.asarray(table["elastic_bend"]), self.run_.series["elastic_bend"])

    def test_contacts(self):
        self.assertTrue(self.run_.contact_steps)
        contacts = self.run_.contacts()
        self.assertIn("normal[N]", contacts)
        with self.assertRaisesRegex(skein.NotResults, "no contacts of step 1;"):
            self.run_.contacts(1)

    def test_state_of_a_checkpoint(self):
        """Half a step from the last frame, in double precision."""
        state, reeds = self.run_.state(), self.run_["reeds"]
        self.assertEqual(state["reeds"]["quaternion"].shape, (3, 12, 4))
        np.testing.assert_allclose(np.linalg.norm(state["reeds"]["quaternion"], axis=-1), 1, atol=1e-12)
        half = 0.5 * self.run_.summary["dt_s"] * np.abs(state["reeds"]["velocity"]).max()
        self.assertLess(np.abs(state["reeds"]["position"] - reeds.position[-1]).max(), 1.01 * half + 1e-7)
        self.assertEqual(state["ball"]["position"].shape, (1, 1, 3))

    def test_walls(self):
        points, polygons, number = self.run_.walls()
        self.assertEqual(len(polygons), len(number))
        np.testing.assert_allclose(points[:, 2], 0, atol=1e-12)

    def test_what_is_not_there_is_told(self):
        with self.assertRaisesRegex(skein.NotResults, "no such directory"):
            skein.open(self.directory.path / "absent")
        with self.assertRaisesRegex(skein.NotResults, "set output.contacts"):
            run = skein.open(self.directory.out)
            run.contact_steps = []
            run.contacts()

    def test_errors_are_exceptions(self):
        self.assertTrue(issubclass(skein.NotResults, Exception) and issubclass(skein.Damaged, skein.NotResults))
        for what in (lambda: skein.open(self.directory.path / "absent"), lambda: self.run_.contacts(1), lambda: self.run_.series["sped"]):
            try:
                what()
            except Exception as error:  # as scripts and notebooks catch it
                self.assertIsInstance(error, skein.NotResults)

    def copied(self, folder):
        for path in self.directory.out.iterdir():
            if path.is_file():
                (Path(folder) / path.name).write_bytes(path.read_bytes())
        return Path(folder)

    def test_a_damaged_file_is_named(self):
        """Of every kind: cut, emptied, filled with noise; whatever reads it says which one it is."""
        def everything(folder):
            run = skein.open(folder)
            for group in run.groups.values():
                np.asarray(group.position), np.asarray(group.tips), group.origin
            run["reeds"].field(-1, "velocity"), run.walls(), run.series, run.energies, run.contacts(), run.state(), run.title
        noise = np.random.default_rng(7).bytes(700)
        names = ["physics.json", "summary.json", "observables.csv"] + [sorted(self.directory.out.glob(pattern))[-1].name
                                                                       for pattern in ("trajectory_*.h5", "tips_*.h5", "checkpoint_*.h5", "contacts_*.csv", "*.pvd")]
        with tempfile.TemporaryDirectory() as folder:
            everything(self.copied(folder) if not (self.directory.out / "vtp").exists() else self.directory.out)
        for name in names:
            for damage in (b"", noise, (self.directory.out / name).read_bytes()[:300][::-1]):
                with self.subTest(name=name, bytes=len(damage)), tempfile.TemporaryDirectory() as folder:
                    self.copied(folder)
                    if (self.directory.out / "vtp").exists():
                        (Path(folder) / "vtp").symlink_to(self.directory.out / "vtp")
                    (Path(folder) / name).write_bytes(damage)
                    if (name == "observables.csv" and not damage) or len((self.directory.out / name).read_bytes()) < 300 and 0 < len(damage) < 300:
                        continue  # a run that has just begun; a first line alone
                    with self.assertRaises(skein.NotResults) as caught:
                        everything(folder)
                    self.assertIn(name, str(caught.exception))
                    self.assertNotIn("\n", str(caught.exception))

    def test_what_leads_out_of_a_file_is_not_followed(self):
        """Links to other files, virtual datasets of them, numbers in files beside: each is refused by its name."""
        secret = self.directory.path / "secret.h5"
        with h5py.File(secret, "w") as file:
            file["numbers"] = np.zeros((30, 3, 13, 3))
        (self.directory.path / "secret.bin").write_bytes(bytes(8 * 3 * 13 * 3))

        def external(file, at):
            file[at] = h5py.ExternalLink(str(secret), "/numbers")

        def soft(file, at):
            file["away"] = h5py.ExternalLink(str(secret), "/numbers")
            file[at] = h5py.SoftLink("/away")

        def virtual(file, at):
            layout = h5py.VirtualLayout((30, 3, 13, 3), float)
            layout[:] = h5py.VirtualSource(str(secret), "numbers", (30, 3, 13, 3))
            file.create_virtual_dataset(at, layout)

        def beside(file, at):
            file.create_dataset(at, (3, 13, 3), float, external=[(str(self.directory.path / "secret.bin"), 0, h5py.h5f.UNLIMITED)])

        for kind, at, read in [(kind, at, read) for kind in (external, soft, virtual, beside) for at, read in (
                ("trajectory", lambda run: run["reeds"].position[-1]), ("checkpoint", lambda run: run.state()))]:
            with self.subTest(kind=kind.__name__, file=at), tempfile.TemporaryDirectory() as folder:
                self.copied(folder)
                path = sorted(Path(folder).glob(f"{at}_*.h5"))[-1]
                dataset = "groups/reeds/position" if at == "trajectory" else "groups/reeds/state"
                with h5py.File(path, "a") as file:
                    del file[dataset]
                    kind(file, dataset)
                with self.assertRaisesRegex(skein.Damaged, f"{path.name}.*(another file|is a link)"):
                    read(skein.open(folder))

    def test_what_things_say_of_themselves(self):
        run = self.run_
        self.assertRegex(repr(run), r"<Results .*out: 'Two groups and a ball', ended at step \d+, 21 frames from 0 to 0.2 s, 41 of tips, groups 'reeds', 'flat', 'ball'>")
        self.assertEqual(repr(run["reeds"]), "<Group 'reeds': 3 rods of 12 elements, 21 frames>")
        self.assertEqual(repr(run["ball"]), "<Group 'ball': 1 rigid bodies, 21 frames>")
        self.assertRegex(repr(run.series), r"<Series .*: 21 rows from 0 to 0.2 s, columns step, time, .*>")

    def test_a_run_that_goes_on(self):
        """A row that is being written, and a summary that is not there yet."""
        with tempfile.TemporaryDirectory() as folder:
            for name in ("physics.json", "observables.csv"):
                Path(folder, name).write_bytes((self.directory.out / name).read_bytes()[: None if name[0] == "p" else -7])
            series = skein.open(folder).series
            self.assertEqual(len(series["time"]), len(self.run_.series["time"]) - 1)


class Large(unittest.TestCase):
    def test_little_of_much(self):
        """Of a gigabyte of frames, all at the bounds of what is asked for: a plot's worth at once, and memory for that alone."""
        frames, rods, nodes, segments = 50, 20000, 21, 4
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder)
            (out / "physics.json").write_text('{"rods": [{"name": "many", "shape": {"elements": 20, "closed": false}}]}')
            for k in range(segments):
                with h5py.File(out / f"trajectory_{k * frames:012d}.h5", "w") as file:
                    file["step"], file["time"] = np.arange(k * frames, (k + 1) * frames), 0.1 * np.arange(k * frames, (k + 1) * frames)
                    file.attrs["title"] = "large"
                    file["groups/many/origin"] = np.zeros((rods, 3))
                    data = file.create_dataset("groups/many/position", (frames, rods, nodes, 3), "f4", chunks=(1, rods // 2, nodes, 3))
                    for frame in range(frames):
                        data[frame] = np.full((rods, nodes, 3), k * frames + frame, "f4")
            size = sum(path.stat().st_size for path in out.glob("*.h5"))
            self.assertGreater(size, 0.9e9)
            program = f"""
import sys, time, resource; sys.path.insert(0, {str(ROOT / "python")!r})
import numpy as np, h5py, skein, skein.results
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
began = time.monotonic()
run = skein.open({str(out)!r})
tips = run["many"].position[::20, :, -1, 2]
print(time.monotonic() - began)
frames = run["many"].position[10:60]
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / frames.nbytes, frames[:, 0, 0, 0].tolist() == list(range(10, 60)), tips.shape)
"""
            seconds, share, right, *shape = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout.split(maxsplit=3)
            print(f"{size / 1e9:.2f} GB: opened, and tips of every twentieth frame, in {float(seconds):.2f} s; a quarter of all in {float(share):.2f} times its size")
            self.assertEqual((right, "".join(shape).strip()), ("True", "(10, 20000)"))
            self.assertLess(float(share), 1.2)


if __name__ == "__main__":
    unittest.main()
