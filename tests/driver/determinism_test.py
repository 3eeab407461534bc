"""The same bits for any ranks x threads, SIMD width, protocol and output cadence."""

import unittest

from driver import DriverTest


class Determinism(DriverTest):
    def test_ranks_threads_and_lanes(self):
        self.run_skein("one")
        one = self.results("one")

        def same(out):
            self.assertEqual(self.results(out).keys(), one.keys(), out)
            for name, content in one.items():
                self.assertEqual(self.results(out)[name], content, f"{name} of {out}")

        self.assert_layouts_give("one", same)

    def test_protocols(self):
        self.run_skein("asynchronous")
        for ranks, threads in ((1, 2), (2, 1)):
            out = f"synchronous {ranks}x{threads}"
            self.run_skein(out, "--protocol", "synchronous", ranks=ranks, threads=threads)
            self.assertEqual(self.summary(out)["protocol"], "synchronous")
            self.assertEqual(self.digest(out), self.digest("asynchronous"), out)
            self.assertEqual(self.results(out), self.results("asynchronous"), out)

    def test_output_cadence_leaves_no_trace(self):
        quiet = [f"--set=output.{key}=0" for key in ("trajectory", "tips", "series", "checkpoint")] + ["--set=time.divide=0.36"]
        self.run_skein("talkative")
        self.run_skein("silent", *quiet)
        self.assertEqual(self.digest("silent"), self.digest("talkative"))
        self.assertEqual([name for name in self.results("silent") if not name.startswith("checkpoint")], [])
        self.assertEqual(self.summary("silent")["observables"], self.summary("talkative")["observables"])
        self.assertGreater(self.summary("silent")["phases"]["observe"]["max_s"], 0, "the last sample and the digest are timed")

    def test_more_ranks_than_rods(self):
        self.run_skein("few", "--set", "rods.cilia.placement.counts=[1,1]", "--set", "rods.leaning.placement.counts=[1]")
        self.run_skein("many", "--set", "rods.cilia.placement.counts=[1,1]", "--set", "rods.leaning.placement.counts=[1]", ranks=4)
        self.assertEqual(self.digest("many"), self.digest("few"))


if __name__ == "__main__":
    unittest.main()
