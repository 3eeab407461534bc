"""skein.Simulation: the bits of skein run, in this process, looked at and driven between batches of steps."""

import os
import subprocess
import sys
import unittest

import numpy as np

from package import APPS, MPIRUN, ROOT, SKEIN, Directory, skein

CARPET = APPS / "cilia_carpet/carpet_8x8.toml"
SHORT = {"time.duration": 7.2, "output.checkpoint": 7.2, "output.trajectory": 3.6, "output.tips": 3.6, "output.series": 0.72}


class InProcess(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = Directory()

    @classmethod
    def tearDownClass(cls):
        cls.directory.close()

    def test_the_bits_of_a_run(self):
        written = skein.run(CARPET, self.directory.path / "carpet", quiet=True, **SHORT)
        simulation = skein.Simulation(CARPET, threads=1, **SHORT)
        while not simulation.finished:
            simulation.step(64)
        self.assertEqual(simulation.digest, written.summary["digest"])
        self.assertEqual(simulation.steps_done, written.summary["steps"])
        np.testing.assert_allclose(simulation["cilia"].position, written["cilia"].position[-1], atol=1e-6)
        for heading, value in written.summary["observables"].items():
            np.testing.assert_allclose(simulation.observables[heading], value, rtol=1e-12)

    def test_arrays(self):
        simulation = skein.Simulation(self.directory.scene)
        reeds, ball = simulation["reeds"], simulation["ball"]
        self.assertEqual([a.shape for a in (reeds.position, reeds.velocity, reeds.directors, reeds.spin)], [(3, 13, 3), (3, 13, 3), (3, 12, 3, 3), (3, 12, 3)])
        self.assertEqual((ball.position.shape, ball.directors.shape), ((1, 1, 3), (1, 1, 3, 3)))
        before = reeds.position
        copied, address = before.copy(), before.__array_interface__["data"][0]
        simulation.step(500)
        now = reeds.position
        self.assertEqual(now.__array_interface__["data"][0], address, "the same memory at every step")
        self.assertGreater(np.abs(now - copied).max(), 0)
        self.assertTrue(np.shares_memory(before, now))
        with self.assertRaises(ValueError):
            now[0, 0, 0] = 1
        np.testing.assert_allclose(reeds.directors @ reeds.directors.swapaxes(-1, -2), np.broadcast_to(np.eye(3), (3, 12, 3, 3)), atol=1e-9)
        moved = (now - copied) / (500 * simulation.dt)
        self.assertLess(np.abs(moved).max(), 2 * np.abs(reeds.velocity).max())
        with self.assertRaisesRegex(KeyError, "there are reeds, flat, ball"):
            simulation["reed"]

    def test_as_the_frames_of_a_run(self):
        """At the step of every frame the arrays are the frame, to its single precision; contacts are those of the tables."""
        run, simulation = skein.open(self.directory.out), skein.Simulation(self.directory.scene)
        for frame, step in enumerate(run.frames.step):
            simulation.step(int(step) - simulation.steps_done)
            for name in ("reeds", "flat", "ball"):
                np.testing.assert_allclose(simulation[name].position, run[name].position[frame], atol=1e-7)
                np.testing.assert_allclose(simulation[name].directors.reshape(run[name].directors[frame].shape), run[name].directors[frame], atol=1e-6)
            if step in run.contact_steps:
                written, now = run.contacts(int(step)), simulation.contacts
                self.assertEqual(list(now), list(written))
                for heading in now:
                    np.testing.assert_array_equal(now[heading], written[heading])
        self.assertEqual(simulation.digest, run.summary["digest"])

    def test_several_in_one_process(self):
        one, other = skein.Simulation(self.directory.scene), skein.Simulation(self.directory.scene)
        one.step(1000), other.step(1000)
        one.drive("push", 1.0, one.time + 0.01)
        one.step(1000), other.step(1000)
        self.assertNotEqual(one.digest, other.digest)
        alone = skein.Simulation(self.directory.scene).step(2000)
        self.assertEqual(other.digest, alone.digest, "what drives one leaves the other alone")

    def test_a_driven_run_is_a_scene(self):
        simulation, random = skein.Simulation(self.directory.scene), np.random.default_rng(7)
        simulation.step(600)
        while not simulation.finished:
            simulation.drive("push", random.uniform(-0.2, 0.2), simulation.time + 40 * simulation.dt)
            simulation.step(100)
        at, value = simulation.table("push")
        self.assertGreater(len(at), 20)
        again = skein.Simulation(self.directory.scene, **{"table.0.at": at, "table.0.value": value})
        again.step(again.steps)
        self.assertEqual(again.digest, simulation.digest)
        plain = skein.Simulation(self.directory.scene)
        plain.step(plain.steps)
        self.assertNotEqual(plain.digest, simulation.digest)

    def test_mistakes(self):
        for keys, words in (({"rods.reeds.shape.elments": 4}, "did you mean 'elements'"), ({"time.dt": 1e-3}, "stable limit")):
            with self.assertRaisesRegex(skein.RunFailed, words):
                skein.Simulation(self.directory.scene, **keys)
        simulation = skein.Simulation(self.directory.scene)
        for table, value, until, words in (("pull", 1, 1, "no table 'pull'; there are: push"), ("push", 1, -1, "cannot go to 1"), ("push", np.nan, 1, "cannot go")):
            simulation.step(2000)
            with self.assertRaisesRegex(skein.RunFailed, words):
                simulation.drive(table, value, until)

    def test_a_run_that_blows_up_says_where(self):
        simulation = skein.Simulation(self.directory.scene, **{"time.dt": 2e-3, "time.force_dt": True, "time.divide": 0, "output.series": 0.2, "output.trajectory": 0.2,
                                                               "output.tips": 0.2, "output.checkpoint": 0.2, "output.contacts": 0.2})
        with self.assertRaisesRegex(skein.RunFailed, "of '(reeds|flat)'"):
            simulation.step(simulation.steps)

    def test_runs_on_ranks_from_the_same_process(self):
        """What this process by itself needs of MPI does not reach the ranks that it starts."""
        program = f"""
import sys; sys.path.insert(0, {str(ROOT / "python")!r})
import skein, subprocess
def environment():
    return set(subprocess.run(["env"], capture_output=True, text=True, check=True).stdout.splitlines())
before = environment()
skein.Simulation({str(self.directory.scene)!r}, threads=1).step(1)
assert environment() - before <= {{"OMPI_MCA_sharedfp=individual"}}, environment() - before
subprocess.run([{MPIRUN!r}, "-n", "2", {SKEIN!r}, "run", {str(self.directory.scene)!r}, "--steps", "10", "--quiet", "--out", {str(self.directory.path / "ranks")!r}], check=True)
"""
        plain = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_MCA_pml", "OMPI_MCA_btl", "OMPI_MCA_mtl"))}
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100, env=plain)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(skein.open(self.directory.path / "ranks").summary["ranks"], 2)

    def test_under_mpirun(self):
        """Ranks write files of their own: what they print may be mixed."""
        folder = self.directory.path
        program = f"""
import sys; sys.path.insert(0, {str(ROOT / "python")!r})
import os, pathlib, skein
simulation = skein.Simulation({str(self.directory.scene)!r}, threads=1).step(1000)
here = pathlib.Path({str(folder)!r}, "rank" + os.environ["OMPI_COMM_WORLD_RANK"])
here.write_text(f"{{len(simulation['reeds'].numbers)}} {{simulation.digest}}")
"""
        subprocess.run([MPIRUN, "-n", "2", sys.executable, "-c", program], check=True, capture_output=True, text=True, timeout=100, env=dict(os.environ))
        ranks = [(folder / f"rank{rank}").read_text().split() for rank in range(2)]
        self.assertEqual(sum(int(rods) for rods, _ in ranks), 3)
        alone = skein.Simulation(self.directory.scene).step(1000)
        self.assertEqual({digest for _, digest in ranks}, {alone.digest})


if __name__ == "__main__":
    unittest.main()
