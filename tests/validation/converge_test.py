"""`skein converge` on four scenes: the error bar holds the true error, and is not more than three times it.

timoshenko and catenary have closed forms; carpet and snake are held against runs of eight and sixteen times their elements, made
here. Prints a line per observable: the true error over the error bar.
"""

import json
import math
import pathlib
import subprocess
import unittest

import h5py
import numpy

from driver import MPIRUN, SKEIN, DriverTest

SCENES = pathlib.Path(__file__).resolve().parents[1] / "data" / "converge"


def timoshenko():
    """The tip's deflection, m."""
    length, radius, youngs, shear, force = 3.0, 0.25, 1e6, 1e4, 0.15
    area = math.pi * radius**2
    return force * length / (27 / 28 * shear * area) + force * length**3 / (3 * youngs * 0.25 * area * radius**2)


def catenary():
    """The height of the centre of mass, m: x' = e H/T, z' = e V/T, T = sqrt(H^2 + V^2), e = 1/(1 - T/(E A)), span 0.8."""
    area = math.pi * 3e-4**2
    weight = area * 0.05
    n = 100001
    s = numpy.linspace(0, 1, n)
    vertical = weight * (s - 0.5)
    simpson = numpy.ones(n) / (3 * (n - 1))
    simpson[1:-1:2] *= 4
    simpson[2:-1:2] *= 2

    def line(horizontal):
        tension = numpy.hypot(horizontal, vertical)
        return 1 / (1 - tension / area) * horizontal / tension, 1 / (1 - tension / area) * vertical / tension

    low, high = 0.0, weight
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if simpson @ line(middle)[0] > 0.8 else (middle, high)
    slope = line(0.5 * (low + high))[1]
    return simpson @ (slope * (1 - s))  # the mean of z over s, by parts, as z(0) = 0


class Converge(DriverTest):
    def converge(self, scene, *arguments, out=None):
        done = subprocess.run([MPIRUN, "-n", "1", SKEIN, "converge", str(SCENES / f"{scene}.toml"), "-t", "1", "--out",
                               str(self.directory / (out or scene)), *arguments], capture_output=True, text=True, timeout=170)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        figures = json.loads((self.directory / (out or scene) / "converge.json").read_text())
        return figures, {o["name"]: o for o in figures["observables"]}

    def finest(self, scene, elements, sets=()):
        """The same scene with other elements, by itself; names of tips and columns as converge has them: [samples, components]."""
        out = f"{scene}_{elements}"
        group = {"carpet": "cilia", "snake": "snake"}[scene]
        done = subprocess.run([MPIRUN, "-n", "1", SKEIN, "run", str(SCENES / f"{scene}.toml"), "-q", "-t", "1", "--out", str(self.directory / out),
                               "--set", f"rods.{group}.shape.elements={elements}", "--set", "output.tips=" + {"carpet": "1.44", "snake": "0.1"}[scene],
                               "--set", "output.precision=double", *[a for s in sets for a in ("--set", s)]],
                              capture_output=True, text=True, timeout=170)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return self.samples(out, group)

    def samples(self, out, group):
        tips = self.frames(out, "tips")[f"groups/{group}/position"]
        series = self.series(out)
        values = {f"tip of {group} {rod}": tips[:, rod] for rod in (0, tips.shape[1] - 1)}
        values["centre"] = numpy.stack([series[f"centre_{x}m"] for x in "xyz"], 1)
        values["momentum"] = numpy.stack([series[f"momentum_{x}kg_ms"] for x in "xyz"], 1)
        for name in series.dtype.names:
            if name.startswith(("kinetic", "elastic")):
                values[name[:-1]] = series[name][:, None]
        return values

    def assert_holds(self, observable, true, bar=None, most=3.0):
        bar = observable["error_bar"]["total"] if bar is None else bar
        print(f"  {observable['name']}: true error {true / observable['range']:.2e} of its range, error bar {bar / true:.2f} times that, "
              f"order {observable['order'] or math.nan:.2f}, {observable['convergence']}")
        self.assertGreaterEqual(bar, true, observable["name"])
        self.assertLessEqual(bar, most * true, observable["name"])

    def test_timoshenko(self):
        figures, found = self.converge("timoshenko")
        self.assertTrue(figures["at_rest"])
        tip, deflection = found["tip of beam 0"], timoshenko()
        self.assertEqual(tip["convergence"], "second order")
        self.assertAlmostEqual(tip["order"], 2, delta=0.05)
        self.assert_holds(tip, abs(tip["at_end"][0] - deflection))
        self.assertLess(abs(tip["richardson_at_end"][0] - deflection), 1e-5 * deflection)

    def test_relaxed(self):
        """The same beam by time.relax: one run less, as its steps have no error, and the same error bar."""
        text = (SCENES / "timoshenko.toml").read_text().replace("rest_speed = 1e-11", "relax = true").replace("duration = 200.0", "duration = 2e5")
        self.scene.write_text(text[:text.index("[[damping]]")])
        done = subprocess.run([MPIRUN, "-n", "1", SKEIN, "converge", str(self.scene), "-t", "1", "--tolerance", "1e-3", "--out",
                               str(self.directory / "relaxed")], capture_output=True, text=True, timeout=170)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        figures = json.loads((self.directory / "relaxed" / "converge.json").read_text())
        self.assertEqual((len(figures["runs"]), figures["method"]), (3, "relaxation"))
        tip = next(o for o in figures["observables"] if o["name"] == "tip of beam 0")
        self.assertEqual(tip["error_bar"]["time"], 0)
        self.assert_holds(tip, abs(tip["at_end"][0] - timoshenko()))
        self.assertIn("elements, about", done.stdout)

    def test_catenary(self):
        _, found = self.converge("catenary")
        centre, height = found["centre"], catenary()
        self.assertEqual(centre["convergence"], "second order")
        self.assert_holds(centre, abs(centre["at_end"][2] - height))
        self.assertLess(abs(centre["richardson_at_end"][2] - height), 0.03 * abs(centre["at_end"][2] - height))

    def test_carpet(self):
        figures, found = self.converge("carpet")
        given = self.samples("carpet/" + next(r["directory"] for r in figures["runs"] if r["as_given"]), "cilia")
        fine, coarse = self.finest("carpet", 160), self.finest("carpet", 80)
        for name, observable in found.items():
            if not observable["counts"]:
                continue
            self.assertEqual(observable["convergence"], "second order", name)
            exact = (4 * fine[name] - coarse[name]) / 3
            self.assert_holds(observable, numpy.linalg.norm(given[name] - exact, axis=1).max())

    def test_snake(self):
        """Dry friction: no two runs agree better than to 1 % of the way, however fine, so there is no Richardson value of where it goes."""
        figures, found = self.converge("snake")
        given = self.samples("snake/" + next(r["directory"] for r in figures["runs"] if r["as_given"]), "snake")
        for elements in (160, 320):
            fine = self.finest("snake", elements, (f"load.anisotropic_plane.stiffness={50 / elements}",
                                                   f"load.anisotropic_plane.damping={5e-5 / elements}"))
            for name in ("tip of snake 0", "centre", "momentum", "kinetic_translation", "elastic_bend", "elastic_stretch"):
                self.assert_holds(found[name], numpy.linalg.norm(given[name] - fine[name], axis=1).max())
        for name in ("tip of snake 0", "centre"):
            self.assertEqual(found[name]["convergence"], "not smooth")
            self.assertIsNone(found[name]["richardson_at_end"])

    def test_what_tolerance_asks_for_is_met(self):
        figures, found = self.converge("timoshenko", "--tolerance", "1e-3", "--observable", "tip of beam 0")
        advice = figures["advice"]
        self.assertEqual(advice["by"], ["tip of beam 0"])
        out = "advised"
        done = subprocess.run([MPIRUN, "-n", "1", SKEIN, "run", str(SCENES / "timoshenko.toml"), "-q", "-t", "1", "--out",
                               str(self.directory / out), "--set", f"rods.beam.shape.elements={advice['elements']}", "--set",
                               f"time.dt={2.0 / math.ceil(2.0 / advice['dt_s'])}", "--set", "output.tips=2", "--set", "output.precision=double"],
                              capture_output=True, text=True, timeout=170)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        tip = self.frames(out, "tips")["groups/beam/position"][-1, 0, 0]
        error = abs(tip / timoshenko() - 1)
        print(f"  advised {advice['elements']} elements for 1e-3: error {error:.2e}")
        self.assertLessEqual(error, 1e-3)
        self.assertGreaterEqual(error, 2e-4)

    def test_coarser(self):
        _, found = self.converge("carpet", "--coarser", "--set", "rods.cilia.shape.elements=20", out="coarser")
        _, whole = self.converge("carpet", "--set", "rods.cilia.shape.elements=20")
        for name in ("tip of cilia 0", "elastic_bend", "centre"):
            ratio = found[name]["error_bar"]["total"] / whole[name]["error_bar"]["total"]
            self.assertGreater(ratio, 0.8, name)
            self.assertLess(ratio, 1.6, name)


if __name__ == "__main__":
    unittest.main()
