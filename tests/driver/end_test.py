"""Ways in which a run ends, and what it writes then: every output has its last step. A run that goes on takes that back: its files are
those of a run that never stopped."""

import pathlib
import signal
import subprocess
import sys
import time
import unittest

import h5py
import numpy

from driver import BALL_IN_IT, FLUID_IN_A_BOX, FLUID_OF_RODS, SCENE, SEARCH, DriverTest, bed_under_a_lid, group, rods_in_a_fluid, table

from failure_test import TORN

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
import skein  # noqa: E402

BED = bed_under_a_lid(12, 0.1, "cycles = 1\nends_run = true\n") + """
[output]
trajectory = 0.02
tips = 0.01
series = 0.005
contacts = 0.02
"""
FLUID = """
[time]
duration = 0.4
dt = 0.02
""" + FLUID_IN_A_BOX + BALL_IN_IT + """
[output]
fields = 0.1
series = 0.06
"""
BOTH = """
[time]
duration = 0.4
""" + FLUID_OF_RODS + rods_in_a_fluid((2.0, 2e3), (20.0, 1e4), [0.0, 1.0, 1.0]) + """
[output]
fields = 0.2
trajectory = 0.1
tips = 0.2
series = 0.08
"""
PARTS = "".join(table("[[fluid_output]]", keys) for keys in (
    {"name": "plane", "kind": "slice", "every": 0.1, "at": 0.75},
    {"name": "means", "kind": "box", "every": 0.2, "average": 4},
    {"name": "vortices", "kind": "blocks", "every": 0.1, "threshold": 2.0, "edge": 8}))
BEAM = (group("beam", 1e7, 0.01, 0.5, 20, start="clamped", tables={"placement": {"tangent": [1.0, 0.0, 0.0]}}) + table("[[load]]", {"kind": "gravity"}))
RELAX = table("[time]", {"duration": 20000.0, "relax": True}) + BEAM
REST = table("[time]", {"duration": 20.0, "rest_speed": 1e-3}) + BEAM + table("[[damping]]", {"kind": "uniform", "rate": 15.0})
EVERY = {"trajectory": 1000.0, "tips": 1000.0, "series": 1000.0}
FRAMES = ("trajectory_*.h5", "tips_*.h5", "vtp/rods_*.vtp", "vtp/walls_*.vtp", "contacts_*.csv", "fields_*.h5", "fluid_plane_*.h5", "fluid_means_*.h5",
          "fluid_vortices_*.h5", "fluid_vortices_*.xdmf")
ROD_OUTPUTS = {"trajectory_*.h5", "tips_*.h5", "vtp/rods_*.vtp", "row"}
FLUID_OUTPUTS = {"fields_*.h5", "fluid_plane_*.h5", "fluid_means_*.h5", "fluid_vortices_*.h5", "fluid_vortices_*.xdmf", "row"}
# Scene, arguments, exit code, and which outputs are to show the end.
ENDS = {
    "relax": (RELAX + table("[output]", EVERY), (), 0, ROD_OUTPUTS),
    "relax without outputs": (RELAX, (), 0, {"trajectory_*.h5", "row"}),
    "relax that is not done": (RELAX.replace("20000.0", "50.0") + table("[output]", dict.fromkeys(EVERY, 40.0)), (), 8, ROD_OUTPUTS),
    "rest": (REST + table("[output]", {"trajectory": 0.7, "tips": 0.5, "series": 0.1}), (), 0, ROD_OUTPUTS),
    "servo": (BED, (), 0, ROD_OUTPUTS | {"vtp/walls_*.vtp", "contacts_*.csv"}),
    "duration": (SCENE, ("--set", "time.duration=5.0"), 0, ROD_OUTPUTS),
    "steps": (SCENE, ("--steps", "333"), 0, ROD_OUTPUTS),
    "until": (SCENE, ("--until", "5"), 0, ROD_OUTPUTS),
    "walltime": (SCENE, ("--set", "time.duration=72000", "--walltime", "2"), 3, ROD_OUTPUTS),
    "fluid": (FLUID + PARTS, ("--steps", "8"), 0, FLUID_OUTPUTS),
    "rods and fluid": (BOTH + PARTS, ("--until", "0.33"), 0, ROD_OUTPUTS | FLUID_OUTPUTS),
}


class End(DriverTest):
    def last_steps(self, out):
        """{output: the last step that it shows}."""
        folder = self.directory / out
        found = {}
        for pattern in FRAMES:
            files = sorted(folder.glob(pattern))
            if not files:
                continue
            found[pattern] = int(files[-1].stem[-12:])
            if pattern.startswith(("trajectory", "tips")):
                with h5py.File(files[-1]) as file:
                    found[pattern] = int(file["step"][-1])
            elif files[-1].suffix == ".h5":
                with h5py.File(files[-1]) as file:
                    self.assertEqual(file.attrs["step"], found[pattern])
        rows = folder / "observables.csv"
        if rows.exists():
            found["row"] = int(rows.read_text().splitlines()[-1].split(",")[0])
        return found

    def assert_shows_end(self, out, outputs):
        summary, folder = self.summary(out), self.directory / out
        step = summary["steps"]
        self.assertEqual(self.last_steps(out), {output: step for output in outputs}, out)
        if "row" in outputs:
            self.assertEqual({name: values[-1] for name, values in skein.open(folder).series.items() if name not in ("step", "time")},
                             {name.split("[")[0]: value for name, value in summary["observables"].items()}, out)
        for pvd, frames in (("rods.pvd", "vtp/rods_*.vtp"), ("walls.pvd", "vtp/walls_*.vtp"), ("trajectory.xdmf", "trajectory_*.h5"), ("fields.xdmf", "fields_*.h5"),
                            ("fluid_plane.xdmf", "fluid_plane_*.h5"), ("fluid_vortices.xdmf", "fluid_vortices_*.xdmf")):
            if frames in outputs:
                self.assertIn(sorted(folder.glob(frames))[-1].name, (folder / pvd).read_text(), f"{out}: {pvd}")
        if "trajectory_*.h5" not in outputs:
            return
        results = skein.open(folder)
        self.assertEqual(results.time[-1], summary["time_s"], out)
        state = results.state()
        for name, of_group in results.groups.items():
            moved = 0.51 * summary["dt_s"] * numpy.abs(state[name]["velocity"]).max()  # positions of a checkpoint are half a step behind
            numpy.testing.assert_allclose(of_group.position[-1], state[name]["position"], atol=moved + 1e-6 * numpy.abs(state[name]["position"]).max(), rtol=0)

    def files(self, out):
        """All that a run leaves but for times of its own."""
        folder = self.directory / out
        return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
                if path.is_file() and path.name not in ("summary.json", ".lock")}

    def test_every_way_to_end_shows_the_end_in_every_output(self):
        for name, (scene, arguments, code, outputs) in ENDS.items():
            with self.subTest(name):
                self.scene.write_text(scene)
                out = name.replace(" ", "_")
                self.run_skein(out, *arguments, expect=code)
                self.assert_shows_end(out, outputs)
                if code == 0:
                    before = self.files(out)
                    self.assertIn("Nothing to do", self.run_skein(out, *arguments).stdout)
                    self.assertEqual(self.files(out), before)
        with self.subTest("the end of a relaxation"):
            tip = skein.open(self.directory / "relax")["beam"].position[-1][0, -1]
            self.assertLess(tip[2], -1e-3, "a picture of the start")

    def test_a_signal(self):
        run = subprocess.Popen(self.command("out", "--set", "time.duration=72000")[3:], stdout=subprocess.DEVNULL)
        while run.poll() is None and not (self.directory / "out/observables.csv").exists():
            time.sleep(0.01)
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(timeout=100), 3)
        self.assert_shows_end("out", ROD_OUTPUTS)

    def test_a_failure_is_shown_at_the_step_where_it_began(self):
        """Twice: the second run goes on from the checkpoint before, and takes the first end back."""
        self.scene.write_text(SCENE + TORN.format(before=5.03, after=5.04))
        for _ in range(2):
            self.run_skein("out", expect=4)
            with h5py.File(self.directory / "out/failure.h5") as file:
                step = int(file["step"][0])
            self.assertEqual(self.last_steps("out"), dict.fromkeys(ROD_OUTPUTS, step))
            self.assertIn(f"{step}", (self.directory / "out/end.json").read_text())
            steps = self.frames("out", "trajectory")["step"]
            self.assertTrue((numpy.diff(steps) > 0).all())
            self.assertGreater(len(steps), 3)

    def test_a_run_that_goes_on_has_the_files_of_one_that_never_stopped(self):
        """Byte for byte, segments and indices included: the other one has checkpoints at the same steps."""
        bed = BED.replace("cycles = 1\nends_run = true\n", "")
        for name, scene, checkpoint in (("rods", SCENE.replace("checkpoint = 3.6\n", ""), 5.0), ("bed", bed.replace("duration = 0.2", "duration = 0.03"), 0.011),
                                        ("fluid", FLUID + PARTS, 0.16), ("both", BOTH + PARTS, 0.14)):
            self.scene.write_text(scene)
            self.run_skein(name)
            dt, steps = self.summary(name)["dt_s"], self.summary(name)["steps"]
            whole, parts = name + "_whole", name + "_parts"
            at = ("--set", f"time.dt={dt!r}", "--set", f"output.checkpoint={checkpoint}")
            self.run_skein(whole, *at)
            ends = [int(path.stem[11:]) for path in sorted((self.directory / whole).glob("checkpoint_*.h5"))]
            shown = []
            for end in [end for end in ends if end < steps]:
                self.run_skein(parts, *at, "--steps", str(end), ranks=2 if name in ("rods", "both") else 1)
                self.assertEqual({step for step in self.last_steps(parts).values()}, {end}, name)
                shown.append(self.files(parts))
            self.assertIn("end.json", shown[0], "no step was off the intervals")
            self.run_skein(parts, *at)
            mine, theirs = self.files(parts), self.files(whole)
            self.assertEqual(set(mine), set(theirs), name)
            for file in mine:
                if file != "observables.csv" and not (name == "bed" and file.startswith("checkpoint")):
                    self.assertEqual(mine[file], theirs[file], f"{name}: {file}")
            self.assert_same_series(parts, whole, besides=SEARCH if name == "bed" else ())

    def test_a_kill_between_the_last_checkpoint_and_the_end_costs_nothing(self):
        """The record of the end is there before what it names, and none of that needs to be."""
        self.run_skein("whole")
        self.run_skein("parts", "--steps", "333")
        folder = self.directory / "parts"
        (folder / "summary.json").unlink()
        names = [path for path in folder.rglob("*_000000000333.*") if "checkpoint" not in path.name]
        self.assertGreater(len(names), 2)
        names[0].unlink()
        self.run_skein("parts")
        self.assertFalse((folder / "end.json").exists())
        self.assertEqual([path for path in folder.rglob("*_000000000333.*") if "checkpoint" not in path.name], [])
        self.assert_same_frames("parts", "whole", "cilia")
        self.assertEqual((folder / "observables.csv").read_text(), (self.directory / "whole/observables.csv").read_text())

    def test_a_record_names_nothing_but_frames_and_tables_of_its_step(self):
        self.run_skein("out", "--steps", "333")
        folder = self.directory / "out"
        bystander = self.directory / "fluid_x_000000000333.h5"
        bystander.write_text("of another")
        record = folder / "end.json"
        named = record.read_text()
        more = ["../fluid_x_000000000333.h5", "checkpoint_000000000333.h5", "physics.json", "trajectory_000000000000.h5"]
        record.write_text(named.replace('"files": [', '"files": [' + "".join(f'"{name}", ' for name in more)))
        self.run_skein("out", "--steps", "400")
        self.assertTrue(bystander.exists())
        self.assertTrue((folder / "physics.json").exists() and (folder / "trajectory_000000000000.h5").exists() and (folder / "checkpoint_000000000333.h5").exists())
        record.write_text("not a record")
        self.run_skein("out")
        self.assertEqual((folder / "end.json.foreign").read_text(), "not a record")


if __name__ == "__main__":
    unittest.main()
