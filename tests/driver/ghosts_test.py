"""Shares and ghosts of ranks as `skein plan --ranks` tells them before a run, and as the run then counts them."""

import pathlib
import subprocess
import unittest

import bodies_test
import rings_test
from contact_test import SCENE
from driver import SKEIN, DriverTest

NEST = pathlib.Path(__file__).resolve().parents[2] / "apps/nest/nest_460.toml"
QUIET = [f"--set=output.{key}=0" for key in ("trajectory", "tips", "checkpoint")]


class Ghosts(DriverTest):
    def forecast(self, ranks, *arguments):
        return self.plan("--ranks", str(ranks), *arguments)["forecast"]

    def compare(self, *arguments):
        for ranks in (2, 3, 4, 8):
            forecast = self.forecast(ranks, *arguments)["ranks"]
            self.assertEqual(len(forecast), ranks)
            out = f"{ranks}"
            self.run_skein(out, "--steps", "1", *QUIET, *arguments, ranks=ranks)
            counted = self.summary(out)["ghosts"]
            self.assertEqual(self.summary(out)["observables"]["rebuilds[-]"], 1)
            self.assertEqual(sum(counted["messages"]) > 0, True, "ranks that share nothing prove nothing")
            for name, of_plan in (("rods", "ghost_rods"), ("elements", "ghost_elements"), ("neighbours", "neighbours"),
                                  ("messages", "messages"), ("bytes", "bytes")):
                self.assertEqual(counted[name], [rank[of_plan] for rank in forecast], f"{name} of {ranks} ranks")
            self.assertEqual(sum(rank["candidates"] for rank in forecast) > self.summary(out)["observables"]["candidates[-]"], True,
                             "pairs of two ranks are worked out twice")

    def test_are_those_of_the_plan(self):
        self.scene.write_text(SCENE)
        self.compare()

    def test_of_bodies_are_those_of_the_plan(self):
        self.scene.write_text(bodies_test.SCENE.replace('paraview = "vtp"\n', ''))
        self.compare("--set=output.contacts=0")

    def test_of_rings_are_those_of_the_plan(self):
        self.scene.write_text(rings_test.SCENE)
        self.compare("--set=output.contacts=0")

    def test_of_long_rods_are_few_of_their_elements(self):
        """The nest of 460 rods with 30 elements each."""
        self.scene.write_text(NEST.read_text())
        self.compare("--set=rods.sticks.shape.elements=30", "--set=time.dt=1e-7")
        for ranks in (2, 4, 8):
            counted = self.summary(f"{ranks}")["ghosts"]
            self.assertLess(sum(counted["elements"]), 8 * sum(counted["rods"]), ranks)

    def test_machine_files_are_read_and_checked(self):
        self.scene.write_text(SCENE)
        machine = self.directory / "machine.toml"
        machine.write_text("[network]\nlatency_s = 1e-3\noverhead_s = 1e-6\nbandwidth_B_per_s = 1e9\nbandwidth_all_B_per_s = 5e8\n")
        slow, fast = (self.forecast(2, *more)["ranks"][0]["exchange_s"] for more in (["--machine", str(machine)], []))
        self.assertGreater(slow, fast + 1e-3)
        machine.write_text("[network]\nlatency = 1e-3\n")
        refused = subprocess.run([SKEIN, "plan", self.scene, "--ranks", "2", "--machine", str(machine)], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("machine.toml:2:1", refused.stderr)
        self.assertIn("did you mean 'latency_s'", refused.stderr)

    def test_waits_are_a_part_of_the_exchange(self):
        self.scene.write_text(SCENE)
        self.run_skein("waits", "--steps", "200", *QUIET, ranks=3)
        waits, phases = self.summary("waits")["waits"], self.summary("waits")["phases"]
        for seconds in waits.values():
            self.assertEqual(len(seconds), 3)
            self.assertGreater(min(seconds), 0)
        self.assertLess(max(map(sum, zip(waits["votes_s"], waits["ghosts_s"]))), phases["exchange"]["max_s"])
        self.assertLess(max(waits["rebuilds_s"]), phases["search"]["max_s"])
        self.run_skein("alone", "--steps", "3", *QUIET)
        self.assertNotIn("waits", self.summary("alone"))

    def test_nothing_is_sent_by_rods_that_do_not_meet(self):
        self.run_skein("apart", "--steps", "3", *QUIET, ranks=2)
        self.assertNotIn("ghosts", self.summary("apart"))
        for rank in self.forecast(2)["ranks"]:
            self.assertEqual((rank["bytes"], rank["messages"], rank["exchange_s"]), (0, 0, 0))


if __name__ == "__main__":
    unittest.main()
