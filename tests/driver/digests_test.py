"""Digests of all shipped scenes after some steps, at every level of instructions that this processor runs, against those kept in
tests/data/digests.csv, which hold for all processors. Bits are those of commit fde2bc51: `git diff fde2bc51 -- tests/data/digests.csv` shows which
have changed since. SKEIN_UPDATE_DIGESTS=1 in the environment writes all."""

import csv
import json
import os
import pathlib
import subprocess
import tempfile
import tomllib
import unittest

from driver import SKEIN

ROOT = pathlib.Path(__file__).resolve().parents[2]
KEPT = ROOT / "tests/data/digests.csv"
STEPS = {"gripper": 40000, "dish": 60000, "knit": 20000, "net": 41000, "farm_111797": 16, "ball_on_rods": 20000, "boxes": 20000, "knot": 20000, "minicircle": 20000, "rods_on_box": 20000, "nest_110": 60000, "nest_460": 1000, "nest_1536": 300, "nest_1536_published": 300, **dict.fromkeys(("collision", "rails", "stack"), 20000), "pit_96": 2000, "pit_96_boiling": 2000, "pit_256": 2000,
         "pit_1024": 100, "pit_1024_friction": 100, "pit_1024_published": 50, "pit_4096": 30, "pit_16384": 10, "swarm_224": 16}  # others: 640
APART = {"pit_1024", "pit_1024_friction", "pit_1024_published", "pit_4096", "pit_16384", "swarm_224", "nest_460", "nest_1536", "nest_1536_published", "plectoneme", "solenoid"}  # rods that have not touched by then; in other scenes with contact they have
ONLY_WIDEST = {"pit_256", "pit_1024", "pit_1024_friction", "pit_1024_published", "pit_4096", "pit_16384", "swarm_224", "farm_111797", "nest_110", "nest_460", "nest_1536", "nest_1536_published"}  # at the two widest levels; others at all


def lanes_here():
    """As `skein info` has it."""
    text = subprocess.run([SKEIN, "info"], capture_output=True, text=True, check=True).stdout
    widest = int(text.split(" lanes")[0].split()[-1])
    return [lanes for lanes in (8, 4, 2, 1) if lanes <= widest]


class Digests(unittest.TestCase):
    def digest(self, scene, steps, lanes):
        keys = tomllib.loads(scene.read_text())
        series = keys["time"]["duration"] if "expect" in keys else 0  # a scene with expected values has rows; one at the end leaves steps as they are
        with tempfile.TemporaryDirectory() as out:
            subprocess.run([SKEIN, "run", scene, "-q", "--no-checkpoint", "--steps", str(steps), "--lanes", str(lanes), "--out", out,
                            "--set=output.trajectory=0", "--set=output.tips=0", f"--set=output.series={series!r}"],
                           stdout=subprocess.DEVNULL, check=False)
            summary = json.loads(pathlib.Path(out, "summary.json").read_text())
            if summary["lanes"] != lanes: return None  # of a width that is not built
            self.touched |= any(summary["observables"].get(f"contact_{kind}[J]", 0) != 0 for kind in ("energy", "friction_work", "viscous_work"))
            return summary["digest"]

    def test_are_those_kept(self):
        kept = {row["scene"]: row for row in csv.DictReader(KEPT.open())} if KEPT.exists() else {}
        # Bits of a fluid depend on how FFTW works on a processor.
        scenes = {path.stem: path for path in sorted(ROOT.glob("apps/*/*.toml")) if "\n[fluid]" not in path.read_text()}
        self.assertGreater(len(scenes), 10)
        fresh = {}
        for name, path in scenes.items():
            steps = STEPS.get(name, 640)
            self.touched = False
            for lanes in lanes_here()[: 2 if name in ONLY_WIDEST else 4]:
                digest = self.digest(path, steps, lanes)
                if digest is None: continue
                fresh.setdefault(name, {"scene": name, "steps": str(steps), "digest": digest})
                with self.subTest(scene=name, lanes=lanes):
                    self.assertEqual(digest, fresh[name]["digest"], "another level of instructions, other bits")
            if "[contact]" in path.read_text() and name not in APART:
                self.assertTrue(self.touched, f"{name}: no contact is in its digest")
        if os.environ.get("SKEIN_UPDATE_DIGESTS"):
            with KEPT.open("w", newline="") as file:
                writer = csv.DictWriter(file, ["scene", "steps", "digest"], lineterminator="\n")
                writer.writeheader()
                writer.writerows(fresh.values())
            kept = fresh
        self.assertEqual(fresh, kept)


if __name__ == "__main__":
    unittest.main()
