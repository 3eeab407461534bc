"""The predicted time of stepping, as `skein plan` prints it: by passes, or timed where rods touch."""

import pathlib
import re
import unittest

from driver import DriverTest

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
BED = APPS / "active_matter/pit_1024.toml"
SHORT = ["--set=time.duration=4", "--set=rods.snakes.placement.count=400", "--set=output.checkpoint=4", *(f"--set=output.{key}=0" for key in ("trajectory", "tips"))]


class Cost(DriverTest):
    def test_of_rods_that_do_not_touch_follows_from_passes(self):
        self.scene = APPS / "cilia_carpet/carpet_8x8.toml"
        self.assertNotIn("timed here", self.plan_text())
        self.assertEqual(self.plan()["predicted_most_s"], 0)

    def test_of_a_bed_is_timed_and_has_a_bound_until_it_has_formed(self):
        self.scene = BED
        before = self.plan(*SHORT)
        self.assertGreater(before["predicted_most_s"], before["predicted_s"])
        self.assertRegex(self.plan_text(*SHORT), r"predicted +\S+ s of stepping, up to \S+ s if a bed forms \(timed here: \d+ steps, 0\.?\d* pairs touch")
        self.run_skein("out", *SHORT, "--steps", "8000")
        touching = self.summary("out")["observables"]["touching_pairs[-]"] / before["elements"]
        self.assertGreater(touching, 0.5, "a bed has formed")
        left = [*SHORT, "--out", str(self.directory / "out")]
        self.assertEqual(self.plan(*left)["predicted_most_s"], 0)
        timed = re.search(r"timed here: \d+ steps from (\S+) s on, (\S+) pairs touch an element", self.plan_text(*left))
        self.assertAlmostEqual(float(timed[1]), 8000 * before["dt"], places=2)
        self.assertLess(abs(float(timed[2]) - touching), 0.25 * touching)

    def test_under_mpirun_follows_from_passes(self):
        self.scene = BED
        self.assertNotIn("timed here", self.skein_says("plan", str(self.scene), ranks=2).stdout)


if __name__ == "__main__":
    unittest.main()
