"""The scenes of apps/formulas, to their ends: gusts travel over the reeds as fast as the formula says, the force and the couple of a field
with a gradient together bend a magnetised rod as a force on the pole at its tip does, and a flagellum swims at the speed of its wave's small
amplitude."""

import math
import unittest

import h5py
import numpy

from single_runs import APPS, SingleRuns


class Formulas(SingleRuns):
    def tips(self, out):
        """Times, places of rods at the start, and how far tips lean towards x, [times, rods]."""
        times, nodes = [], []
        for path in sorted((self.directory / out).glob("trajectory_*.h5")):
            with h5py.File(path) as file:
                times.append(file["time"][:])
                nodes.append(next(iter(file["groups"].values()))["position"][:, :, [0, -1], 0].astype(float))
        nodes = numpy.concatenate(nodes)
        return numpy.concatenate(times), nodes[0, :, 0], nodes[:, :, 1] - nodes[:, :, 0]

    def test_gusts_travel(self):
        self.run_alone("gusts", scene=APPS / "formulas" / "gusts.toml")
        time, place, lean = self.tips("gusts")
        strongest = time > 1.95  # the second gust: the first finds reeds that have just been let go
        at = []
        for rod in lean[strongest].T:
            k = 1 + int(numpy.argmax(rod[1:-1]))
            before, here, after = rod[k - 1:k + 2]
            at.append(time[strongest][k] + 0.5 * (time[1] - time[0]) * (before - after) / (before - 2 * here + after))
        speed = 1 / numpy.polyfit(place, at, 1)[0]
        print(f"  gusts travel at {speed:.3f} m/s")
        self.assertAlmostEqual(speed, 2.5, delta=0.05)
        self.assertGreater(lean.max(), 0.2)

    def test_a_pole_is_pulled(self):
        """m B_x on the tip for bending, as couple and force have it together; the force alone shears."""
        strength, away, length, radius = 1e-13, 0.04, 0.05, 1e-3
        moment, bending, shear = 5e4 * math.pi * radius**2, 1e6 * math.pi * radius**4 / 4, 27 / 28 * 1e6 / 3 * math.pi * radius**2
        below = numpy.linspace(-length, 0, 1001)
        field = strength * (3 * away**2 / numpy.hypot(away, below)**5 - 1 / numpy.hypot(away, below)**3)
        closed = moment * (field[-1] * length**3 / (3 * bending) + length * numpy.mean(field[-1] - field) / shear)
        error = []
        for n in (12, 24, 48):
            self.run_alone(f"{n}", f"constants.strength.value={strength}", "damping.0.rate=40", f"rods.rod.shape.elements={n}",
                           scene=APPS / "formulas" / "magnet.toml")
            error.append(self.tips(f"{n}")[2][-1, 0] / closed - 1)
        order = math.log2((error[0] - error[1]) / (error[1] - error[2]))
        print(f"  lean of the tip over the closed form, less 1: {error[0]:.1e}, {error[1]:.1e}, {error[2]:.1e}, order {order:.2f}")
        self.assertLess(abs(order - 2), 0.05)
        self.assertLess(abs(4 * error[2] - error[1]) / 3, 1e-5)

    def test_a_strong_magnet_takes_the_rod(self):
        self.run_alone("magnet", scene=APPS / "formulas" / "magnet.toml")
        _, _, lean = self.tips("magnet")
        self.assertGreater(lean[-1, 0], 0.02)
        self.assertLess(abs(lean[-1, 0] - lean[-10, 0]), 1e-3)

    @staticmethod
    def swimming_speed(curvature, wavelength=0.05, period=1.0, length=0.1):
        """Of a wave of small curvature that is prescribed, in a fluid twice as hard to go across as along: minus the mean of y_s y_t over rod and
        period, y without net force and couple of the drag (Gray, Hancock 1955)."""
        k, w = 2 * math.pi / wavelength, 2 * math.pi / period
        s = (numpy.arange(2000) + 0.5) * length / 2000
        across = numpy.stack([numpy.ones_like(s), s - length / 2])
        times = numpy.arange(400) * period / 400
        rates, slopes, tilts = [], [], []
        for t in times:
            rate = curvature * w / k**2 * numpy.sin(w * t - k * s)
            rigid = numpy.linalg.solve(across @ across.T, across @ rate)
            rates.append(rate - rigid @ across)
            slopes.append(-curvature / k * numpy.sin(w * t - k * s))
            tilts.append(-rigid[1])
        tilt = numpy.cumsum(tilts) * period / 400  # its mean does nothing, as the rates have none
        return float(numpy.mean(numpy.array(rates) * (numpy.array(slopes) + tilt[:, None])))

    def test_a_flagellum_swims(self):
        """Against its wave, at a speed that falls with the square of the curvature; corrections are of its square again."""
        error = []
        for curvature in (20.0, 10.0):
            out = f"swims_{curvature:g}"
            self.run_alone(out, f"constants.curvature.value={curvature}", scene=APPS / "formulas" / "flagellum.toml")
            series = self.series(out)
            at = lambda t: float(numpy.interp(t, series["time"], series["centre_x"]))
            error.append((at(6.0) - at(2.0)) / 4 / self.swimming_speed(curvature) - 1)
        small = (4 * error[1] - error[0]) / 3
        print(f"  swims {error[0]:+.2%}, {error[1]:+.2%} off the speed of small waves, {small:+.2%} where they vanish")
        self.assertLess(self.swimming_speed(10.0), 0)
        self.assertLess(abs(small), 0.01)  # drag bends the rod by 1 % of what its muscles do


if __name__ == "__main__":
    unittest.main()
