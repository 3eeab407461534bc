"""A run that goes on among damaged frames: each is told and put aside, or nothing has come to harm; lists show what is there."""

import random
import re
import shutil
import unittest

import h5py
import numpy

from driver import DriverTest
from end_test import BED, FLUID, PARTS

ROD_FILES = ("vtp/rods_*.vtp", "vtp/walls_*.vtp", "rods.pvd", "walls.pvd")
FLUID_FILES = ("fields_*.h5", "fluid_plane_*.h5", "fluid_means_*.h5", "fluid_vortices_*.h5", "fluid_vortices_*.xdmf", "fields.xdmf", "fluid_plane.xdmf",
               "fluid_vortices.xdmf")
DAMAGES = ("bit", "bytes", "cut", "emptied", "swapped", "lost")


def damaged(content, damage, draw, other):
    """A file's new content; None: it is gone."""
    content = bytearray(content)
    if damage == "bit":
        content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
    elif damage == "bytes":
        at = draw.randrange(len(content))
        content[at : at + 64] = draw.randbytes(len(content[at : at + 64]))
    elif damage == "cut":
        content = content[: draw.randrange(1, len(content))]
    return {"emptied": b"", "swapped": other, "lost": None}.get(damage, bytes(content))


def same_numbers(path, other):
    """Of two files of fields: what readers see of them."""
    with h5py.File(path) as mine, h5py.File(other) as theirs:
        names = [name for name in theirs if name != "blocks"]
        return dict(mine.attrs) == dict(theirs.attrs) and all(
            numpy.array_equal(mine[name][:].view("u1"), theirs[name][:].view("u1")) for name in names)


class Damage(DriverTest):
    def go_on(self, patterns, trials):
        """Of a run that is half done one file is damaged, then it goes on: what has come of it is that of the whole run, or was told."""
        draw = random.Random(7)
        steps = self.summary("whole")["steps"]
        self.run_skein("half", "--steps", str(steps // 2))
        half, whole, out = (self.directory / name for name in ("half", "whole", "out"))
        end = f"_{self.summary('half')['steps']:012d}"
        told = 0
        for pattern in patterns:
            for damage in DAMAGES:
                for trial in range(trials):
                    shutil.rmtree(out, ignore_errors=True)
                    shutil.copytree(half, out)
                    files = [path for path in sorted(out.glob(pattern)) if end not in path.name]
                    victim = draw.choice(files)
                    others = [path.read_bytes() for path in files if path != victim]
                    if damage == "swapped" and not others:
                        continue
                    new = damaged(victim.read_bytes(), damage, draw, others[0] if others else b"")
                    victim.unlink() if new is None else victim.write_bytes(new)
                    done = self.run_skein("out")
                    with self.subTest(file=victim.name, damage=damage, trial=trial, text=done.stderr):
                        self.assertEqual(self.digest("out"), self.digest("whole"))
                        told += self.check(out, whole, victim, damage, done.stderr)
        self.assertGreater(told, 3 * sum(pattern.endswith((".h5", ".vtp")) for pattern in patterns))

    def check(self, out, whole, victim, damage, text):
        """Returns whether a frame has been lost, which then was told."""
        frame = re.search(r"_\d{12}\.(h5|vtp)$", victim.name)
        gone = frame is not None and not victim.exists()
        if gone and damage == "lost":
            self.assertIn("are missing", text)
        elif gone:
            self.assertTrue(victim.with_name(victim.name + ".damaged").exists())
            self.assertIn(victim.name, text)
        elif victim.read_bytes() != (whole / victim.relative_to(out)).read_bytes():
            self.assertEqual(victim.suffix, ".h5", "made anew, or put aside")
            self.assertTrue(same_numbers(victim, whole / victim.name), "in silence")
        expected = {str(path.relative_to(whole)): path.read_bytes() for path in whole.rglob("*") if path.is_file()}
        for name, content in expected.items():
            if name == "trajectory.xdmf" or (gone and name == victim.stem + ".xdmf"):
                continue  # of other segments; of the lost frame itself, which the list of all does not name
            if name.endswith((".pvd", ".xdmf")) and gone:
                listed = set(re.findall(r"[\w/]+_\d{12}\.\w+", content.decode()))
                lost = {frame_name for frame_name in listed if victim.stem in frame_name}
                if (out / name).exists():
                    self.assertEqual(set(re.findall(r"[\w/]+_\d{12}\.\w+", (out / name).read_text())), listed - lost, name)
            elif name.startswith(("vtp/", "fields", "fluid_")) or name.endswith((".pvd", ".xdmf")):
                if name != str(victim.relative_to(out)) or not frame:
                    self.assertEqual((out / name).read_bytes(), content, name)
        return gone

    def test_frames_for_paraview(self):
        self.scene.write_text(re.sub("cycles = 1\nends_run = true\n", "", BED).replace("duration = 0.2", "duration = 0.02").replace("trajectory = 0.02", "trajectory = 0.002")
                              .replace("tips = 0.01\nseries = 0.005\ncontacts = 0.02\n", ""))
        self.run_skein("whole")
        self.go_on(ROD_FILES, 1)

    def test_a_list_of_walls_at_rest_is_made_anew(self):
        self.scene.write_text(re.sub(r"\[wall.servo\].*?\[output\]", "[output]", BED, flags=re.DOTALL).replace("duration = 0.2", "duration = 0.02").replace("trajectory = 0.02", "trajectory = 0.005"))
        self.run_skein("whole")
        self.run_skein("out", "--until", "0.01")
        walls = self.directory / "out/walls.pvd"
        walls.write_bytes(walls.read_bytes().replace(b"walls_0", b"walls_1"))
        self.run_skein("out")
        self.assertEqual(walls.read_bytes(), (self.directory / "whole/walls.pvd").read_bytes())

    def test_frames_of_a_fluid(self):
        self.scene.write_text(FLUID.replace("dt = 0.02\n", "").replace("series = 0.06", "") + PARTS.replace("every = 0.2", "every = 0.1"))
        self.run_skein("whole")
        self.go_on(FLUID_FILES, 1)


if __name__ == "__main__":
    unittest.main()
