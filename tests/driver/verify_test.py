"""`skein verify`: a segment between two checkpoints computed again, on any ranks; a changed number is found."""

import re
import unittest

import h5py
import numpy

from branch_test import BranchTest
from contact_test import SCENE as CONTACT_SCENE
from driver import digest_of


class Verify(BranchTest):
    def verify(self, out, *arguments, ranks=1, expect=0):
        return self.skein_says("verify", self.directory / out, "--threads", "1", *arguments, ranks=ranks, expect=expect)

    def alter(self, out, first_gid):
        """One number of the newest checkpoint, with digests that fit."""
        with h5py.File(self.newest(out), "r+") as file:
            state = file["groups/cilia/state"]
            numbers = state[7]
            before = digest_of(first_gid + 7, numbers)
            numbers[3, 1] = numpy.nextafter(numbers[3, 1], 1)
            state[7] = numbers
            change = digest_of(first_gid + 7, numbers) - before
            for attributes in (state.attrs, file.attrs):
                attributes.modify("digest", numpy.uint64((int(attributes["digest"]) + change) % 2**64))

    def test_rods(self):
        self.run_skein("run", "--set", "output.audit=true")
        before = self.results("run")
        ends = []  # of segments
        for path in sorted((self.directory / "run").glob("checkpoint_*.h5"))[1:]:
            with h5py.File(path) as file:
                ends.append(f"{int(file.attrs['digest']):016x}")
        self.assertEqual(ends[-1], self.digest("run"))
        for ranks in (1, 2):
            for segment, digests in (((), ends[-1:]), (("--segment", "0"), ends[:1]), (("--segment", "random"), ends)):
                self.assertIn(re.search("digest (.*)", self.verify("run", *segment, ranks=ranks).stdout)[1], digests)
        self.assertEqual(self.results("run"), before, "verify wrote into the directory")
        self.alter("run", 0)
        done = self.verify("run", ranks=2, expect=7)
        self.assertIn("1 of 28 rods differ; the first is rod 7 of 'cilia'", done.stderr)
        self.assertRegex(done.stderr, r"steps \d+ to \d+")
        self.assertIn("expected random", self.verify("run", "--segment", str(len(ends)), expect=2).stderr)

    def test_contact_and_branches(self):
        self.scene.write_text(CONTACT_SCENE)
        self.run_skein("run", "--until", "0.15", ranks=2)
        for ranks in (1, 2):
            self.verify("run", ranks=ranks)
        self.branch("run", "branch", "--set", "time.dt=4.1e-5")
        self.go_on("branch", "--until", "0.2")
        self.verify("branch")
        with h5py.File(self.newest("run"), "r+") as file:
            rows = file["kept/contact_memory_rows"]
            before = digest_of(3, rows[3])
            rows[3, 5] += 1e-12
            change = digest_of(3, rows[3]) - before
            rows.attrs.modify("digest", numpy.uint64((int(rows.attrs["digest"]) + change) % 2**64))
        self.assertIn("'contact_memory' differ", self.verify("run", expect=7).stderr)

    def test_one_checkpoint_is_not_enough(self):
        self.run_skein("run", "--until", "3.6")
        self.assertIn("holds 1 checkpoint", self.verify("run", expect=2).stderr)


if __name__ == "__main__":
    unittest.main()
