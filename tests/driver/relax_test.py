"""Rods that relax: the end is told, and is the same for any ranks, threads, lanes and restarts; what cannot be relaxed is refused."""

import pathlib
import subprocess
import unittest

import numpy

from driver import SKEIN, DriverTest, group, table

APPS = pathlib.Path(__file__).resolve().parents[2] / "apps"
X, Y, Z = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]


def relaxing(steps):
    return table("[time]", {"duration": float(steps), "relax": True})


def beams_and_chains(duration=20000):
    """Nine slender cantilevers under end forces, and three strips that hang between pins."""
    beams = group("beams", 1e9, 0.0002, 1.0, 50, start="clamped", tables={"placement": {"kind": "line", "counts": [9], "spacing": [0.1]}})
    chains = group("chains", 1e7, 0.01, 1.0, 30, start="pinned", end="pinned", tables={
        "section": {"kind": "elliptic", "radius_2": 0.02}, "shape": {"rest_curvature": [2.0, 0.0, 0.0]},
        "placement": {"kind": "line", "counts": [3], "spacing": [0.1], "origin": [0.0, 5.0, 0.0], "tangent": X, "normal": Y}})
    return (relaxing(duration) + beams + chains + table("[[load]]", {"kind": "gravity", "rods": ["chains"]})
            + table("[[load]]", {"kind": "end_force", "rods": ["beams"], "end": [1e-6, 2e-6, 0.0]})
            + table("[output]", {"checkpoint": 64.0, "series": 100.0}))


def coming_to_rest(rods, relax, duration, rate, series, contact=None):
    """Under gravity, by relaxation or by damped motion (duration s, rate 1/s); `contact`: tables."""
    text = relaxing(20000) if relax else table("[time]", {"duration": duration})
    text += rods + table("[[load]]", {"kind": "gravity"}) + (contact or "")
    if not relax:
        text += table("[[damping]]", {"kind": "uniform", "rate": rate})
    return text + table("[output]", {"series": 64.0 if relax else series})


def crossed(relax, friction=None):
    """Two cantilevers that cross, above a floor."""
    rods = "".join(group(name, 1e7, 0.01, 0.5, 20, start="clamped", tables={"placement": {"origin": origin, "tangent": tangent, "normal": Z}})
                   for name, origin, tangent in (("lower", [-0.4, 0.0, 0.06], X), ("upper", [0.0, -0.4, 0.083], Y)))
    law = {"stiffness": 2e3, "law": "linear", "damping": 2.0} | (friction or {})
    contact = table("[contact]", law) + table("[[wall]]", {"name": "floor", "kind": "plane"} | law)
    return coming_to_rest(rods, relax, 16.0, 15.0, 1.0, contact)


def ring(name, held, **placement):
    """Hangs from a node, 1 m round."""
    return group(name, 1e7, 0.01, 1.0, 36, tables={"shape": {"closed": True, "rest_curvature": [6.283185307179586, 0.0, 0.0]},
                                                   "placement": placement} | ({"hold": {"nodes": held}} if held else {}))


class Relax(DriverTest):
    def assert_same_ends(self, one, other, columns):
        """To 3e-6."""
        for column in columns:
            mine, theirs = (self.series(out)[-1][column] for out in (one, other))
            self.assertLess(abs(mine - theirs), 3e-6 * max(abs(theirs), 1e-2), column)

    def assert_any_layout_relaxes(self, whole):
        """To the same bits, also from a checkpoint."""
        self.assertTrue(self.summary(whole)["relaxation"]["settled"])
        self.run_skein(whole + "2", ranks=2, threads=2)
        self.run_skein(whole + "3", "--steps", "100")
        self.run_skein(whole + "3", ranks=2)
        self.run_skein(whole + "4", "--lanes", "1")
        for out in (whole + "2", whole + "3", whole + "4"):
            self.assertEqual(self.digest(out), self.digest(whole), out)

    def test_settles_and_tells(self):
        self.scene.write_text(beams_and_chains())
        done = self.run_skein("out")
        self.assertIn("time counts steps", done.stdout)
        self.assertIn("Settled in", done.stdout)
        summary = self.summary("out")
        self.assertTrue(summary["relaxation"]["settled"])
        self.assertTrue(summary["finished"])
        self.assertLessEqual(summary["relaxation"]["correction"], 1e-9)
        self.assertLess(summary["steps"], 5000)
        self.assertEqual(summary["steps"] % 64, 0)
        again = self.run_skein("out")
        self.assertIn("Nothing to do", again.stdout)

    def test_bits_are_those_of_any_layout(self):
        self.scene.write_text(beams_and_chains())
        self.run_skein("one")
        self.run_skein("ranks", ranks=3)
        self.run_skein("threads", threads=2)
        self.run_skein("narrow", "--lanes", "1")
        self.run_skein("together", "--protocol", "synchronous")
        self.run_skein("along", "--mapping", "along")
        for other in ("ranks", "threads", "narrow", "together", "along"):
            self.assertEqual(self.digest(other), self.digest("one"), other)
            self.assertEqual(self.summary(other)["steps"], self.summary("one")["steps"])
            self.assertEqual(self.summary(other)["relaxation"], self.summary("one")["relaxation"])
            self.assert_same_series(other, "one")

    def test_goes_on_after_a_stop(self):
        self.scene.write_text(beams_and_chains())
        self.run_skein("whole")
        for steps in (64, 100):  # at a look, and between two
            out = f"parts{steps}"
            self.run_skein(out, "--steps", str(steps))
            self.assertNotIn("Settled", self.run_skein(out, "--steps", str(steps + 30)).stdout)
            self.run_skein(out, ranks=2)
            self.assertEqual(self.digest(out), self.digest("whole"))
            self.assertEqual(self.summary(out)["relaxation"], self.summary("whole")["relaxation"])

    def test_too_few_steps_are_told(self):
        self.scene.write_text(beams_and_chains(50).replace("checkpoint = 64.0\nseries = 100.0", "checkpoint = 25.0"))
        for ranks in (1, 2):
            done = self.run_skein(f"short{ranks}", ranks=ranks, expect=8)
            self.assertEqual(done.stderr.count("not settled in the 50 steps of time.duration"), 1, done.stderr)
            self.assertNotIn("Settled", done.stdout)
            self.assertFalse(self.summary(f"short{ranks}")["relaxation"]["settled"])
        self.run_skein("short1", expect=8)  # nothing to do, and still not settled

    def test_rods_that_touch_come_to_balance(self):
        """Cantilevers that press each other and a floor end where damped motion ends; with friction in some balance."""
        friction = {"friction": "memory", "static_friction": 0.3}
        for name, text in (("relaxed", crossed(True)), ("moved", crossed(False)), ("rubbed", crossed(True, friction))):
            self.scene.write_text(text)
            self.run_skein(name)
            if name != "moved":
                self.assert_any_layout_relaxes(name)
        self.assert_same_ends("relaxed", "moved",
                              ("centre_xm", "centre_ym", "centre_zm", "max_overlap", "wall_overlap", "elastic_bendJ"))
        self.assertGreater(self.series("rubbed")[-1]["wall_contacts"], 0)

    def test_joined_rods(self):
        """A cantilever, a hinge with a spring, a slider to the world: the rest of damped motion, of any layout."""
        rod = 'material = {density = 1000.0, youngs_modulus = 1e7}\nsection.radius = 0.01\nshape = {length = 0.5, elements = 12}\n'
        bodies = ('load = [{kind = "gravity", acceleration = [0, 0, -9.81]}]\n[[assembly]]\nname = "arm"\nplacement = {kind = "list", origins = [[0, 0, 0], [0, 1, 0], [0, 2, 0]], tangents = [[0, 0, 1], [0, 0, 1], [0, 0.6, 0.8]]}\n'
                  f'[[rods]]\nname = "a"\nassembly = "arm"\nstart = "clamped"\n{rod}placement.tangent = [1, 0, 0]\n[[rods]]\nname = "b"\nassembly = "arm"\n{rod}placement = {{origin = [0.5, 0, 0], tangent = [1, 0, 0]}}\n'
                  '[[joint]]\nkind = "hinge"\nbetween = ["a", "b"]\naxis = [0, 1, 0]\nstiffness = 1e4\ntorsional_stiffness = 10.0\ntorsional_damping = 1e-4\nspring = 0.5\n'
                  '[[joint]]\nkind = "slider"\nbetween = ["b", "world"]\nat = [1.0]\naxis = [0, 0, 1]\nstiffness = 1e3\ntorsional_stiffness = 0.5\nspring = 1.0\naxis_damping = 0.01\n')
        self.scene.write_text("time = {duration = 100000, relax = true, relax_tolerance = 1e-10}\n" + bodies)
        self.run_skein("rest")
        self.assertTrue(self.summary("rest")["relaxation"]["settled"])
        self.assertLess(self.summary("rest")["steps"], 20000)
        for ranks, threads in ((1, 2), (2, 1)):
            self.run_skein(f"{ranks}x{threads}", ranks=ranks, threads=threads)
            self.assertEqual(self.digest(f"{ranks}x{threads}"), self.digest("rest"))
        self.scene.write_text('time = {duration = 8.0}\ndamping = [{kind = "uniform", rate = 8.0}]\noutput = {series = 0.5}\n' + bodies)
        self.run_skein("motion")
        rest, motion = numpy.atleast_1d(self.series("rest"))[-1], self.series("motion")[-1]
        for name in ("elastic_bendJ", "joint_energyJ", "centre_zm"):
            self.assertLess(abs(rest[name] - motion[name]), 1e-6 * abs(motion[name]), name)

    def test_common_nodes(self):
        """A frame with a closed bay and rods at inner nodes: the rest of damped motion, of any layout."""
        rod = "material = {density = 1000.0, youngs_modulus = 3e8}\nsection.radius = 0.01\n"
        def group(name, origin, tangent, length, elements, more=""):
            return f'[[rods]]\nname = "{name}"\nassembly = "frame"\n{rod}shape = {{length = {length}, elements = {elements}}}\nplacement = {{origin = {origin}, tangent = {tangent}}}\n{more}'
        def joint(one, other, at): return f'[[joint]]\nkind = "fixed"\nbetween = ["{one}", "{other}"]\nat = {at}\n'
        bodies = ('load = [{kind = "gravity", acceleration = [0, 0, -9.81]}]\n[[assembly]]\nname = "frame"\nplacement = {kind = "list", origins = [[0, 0, 0], [0, 2, 0], [0, 4, 0]], tangents = [[0, 0, 1], [0, 0, 1], [0, 0.6, 0.8]]}\n'
                  + group("base", [0, 0, 0], [1, 0, 0], 0.6, 12, 'start = "clamped"\n') + group("up", [0.6, 0, 0], [0, 0, 1], 0.3, 8) + group("back", [0.6, 0, 0.3], [-1, 0, 0], 0.4, 8)
                  + group("down", [0.2, 0, 0.3], [0, 0, -1], 0.3, 6) + group("twig", [0.4, 0, 0.3], [0, 0.8, 0.6], 0.2, 4)
                  + joint("base", "up", [1, 0]) + joint("up", "back", [1, 0]) + joint("back", "down", [1, 0]) + joint("down", "base", [1, 0.3333333333333333]) + joint("back", "twig", [0.5, 0]))
        self.scene.write_text("time = {duration = 100000, relax = true, relax_tolerance = 1e-10}\n" + bodies)
        self.run_skein("rest")
        self.assertTrue(self.summary("rest")["relaxation"]["settled"])
        self.assertLess(self.summary("rest")["steps"], 20000)
        for ranks, threads in ((1, 2), (2, 1)):
            self.run_skein(f"{ranks}x{threads}", ranks=ranks, threads=threads)
            self.assertEqual(self.digest(f"{ranks}x{threads}"), self.digest("rest"))
        self.run_skein("lanes", "--lanes", "1")
        self.assertEqual(self.digest("lanes"), self.digest("rest"))
        self.scene.write_text('time = {duration = 3.0}\ndamping = [{kind = "uniform", rate = 20.0}]\noutput = {series = 0.5}\n' + bodies)
        self.run_skein("motion")
        rest, motion = numpy.atleast_1d(self.series("rest"))[-1], self.series("motion")[-1]
        for name in ("elastic_bendJ", "elastic_twistJ", "joint_energyJ", "centre_xm", "centre_ym", "centre_zm"):
            self.assertLess(abs(rest[name] - motion[name]), 1e-6 * abs(motion[name]), name)

    def test_rings(self):
        """Hang from a node each, beside a rod of another number of elements; and a chain of two links, which touch."""
        alone = ring("first", [0], normal=X, tangent=[0.0, -1.0, 0.0]) + ring("later", [-5], normal=X, tangent=[0.0, -1.0, 0.0], origin=[1.0, 0.0, 0.0])
        beam = group("beam", 1e7, 0.01, 0.5, 10, start="clamped", tables={"placement": {"tangent": X, "normal": Z, "origin": [0.0, 2.0, 0.0]}})
        touching = table("[contact]", {"stiffness": 2e3, "law": "linear", "damping": 0.5})
        chain = ring("upper", [0], normal=X, tangent=[0.0, -1.0, 0.0]) + ring("lower", [], normal=Y, tangent=X, origin=[0.0, 0.0, -0.29])
        for name, rods, contact in (("alone", alone + beam, None), ("chain", chain, touching)):
            for relax in (True, False):
                self.scene.write_text(coming_to_rest(rods, relax, 12.0, 10.0, 2.0, contact))
                self.run_skein(name if relax else name + "_moved")
                if relax:
                    self.assert_any_layout_relaxes(name)
            self.assert_same_ends(name, name + "_moved", ("centre_xm", "centre_ym", "centre_zm", "elastic_bendJ"))

    def test_a_ring_that_winds_up(self):
        """The supercoiled ring of apps/contact settles without passing through itself."""
        text = (APPS / "contact/minicircle.toml").read_text()
        head, tail = text.split("[[damping]]")
        self.scene.write_text(head.replace("duration = 12.0", "relax = true\nduration = 20000.0") + "[contact]"
                              + tail.split("[contact]")[1].replace("series = 0.1", "series = 64.0").replace("trajectory = 1.0", ""))
        self.run_skein("ring")
        self.assert_any_layout_relaxes("ring")
        series = self.series("ring")
        self.assertLess(numpy.abs(series["linkturns"]).max(), 1e-9, "it has passed through itself")
        self.assertGreater(series["writheturns"][-1], 3)
        self.assertGreater(series["contacts"][-1], 10)
        self.assertLess(series["max_overlap"][-1], 0.01)

    def test_motion_begins_at_rest(self):
        self.scene.write_text(beams_and_chains())
        self.run_skein("rest")
        at = self.directory / "motion"
        sets = [f"--set={change}" for change in ("time.relax=false", "time.dt=auto", "time.duration=5e-4", "start.time=zero",
                                                 "output.series=1e-4", "output.checkpoint=0")]
        for command in (["branch", str(self.directory / "rest"), str(at), *sets], ["run", str(at), "-q", "--threads", "1"]):
            done = subprocess.run([SKEIN, *command], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rest, motion = self.series("rest")[-1], self.series("motion")
        for name in ("centre_xm", "centre_ym", "centre_zm"):
            self.assertLess(abs(motion[name] - rest[name]).max(), 1e-9, name)
        self.assertLess(motion["kinetic_translationJ"].max(), 1e-9 * motion["elastic_bendJ"].max())

    def test_what_changes_with_time_is_refused(self):
        self.scene.write_text(beams_and_chains(100))
        for change, words in (("time.dt=0.1", "'dt' has no use"), ("rods.beams.shape.velocity=[1,0,0]", "begins at rest"),
                              ("load.end_force.ramp=0.5", "'ramp' [s]"), ("rods.beams.material.rotary_inertia_scale=10", "leave it out"),
                              ("output.audit=true", "no audit")):
            done = subprocess.run([SKEIN, "check", str(self.scene), "--set", change], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, change + done.stdout)
            self.assertIn(words, done.stderr + done.stdout)


if __name__ == "__main__":
    unittest.main()
