"""Audits of implicit steps: what they take is a line of its own, books close, and parts that are taken back leave no trace."""

import unittest

import numpy

from driver import DriverTest
from scene_text import scene_text

DURATION = 0.2
DAMPING = [{"kind": "uniform", "rate": 3.0}, {"kind": "laplacian", "rate": 200.0, "order": 1}]
SHAKEN = {"amplitude": [0.0, 0.02, 0.0], "rotation_amplitude": [0.2, 0.0, 0.3], "period": 0.2}
CURVED = {"rest_curvature": [3.0, 1.0, 2.0], "start_curvature": [2.0, 0.5, 0.0], "angular_velocity": [3.0, 5.0, 1.0]}


def rod(youngs_modulus=1e6, tangent=(1.0, 0.0, 0.0), shape=None, **keys):
    return {"name": "rod", "material": {"density": 1000.0, "youngs_modulus": youngs_modulus}, "section": {"radius": 1e-2},
            "shape": {"length": 0.5, "elements": 8} | (shape or {}), "placement": {"tangent": list(tangent)}} | keys


def gravity(strength=9.81):
    return [{"kind": "gravity", "acceleration": [0.0, 0.0, -strength]}]


class ImplicitBooks(DriverTest):
    def books(self, out, scene, method, steps, *arguments, rows=20, **layout):
        time = {"duration": DURATION, "integrator": method} | ({"dt": DURATION / steps} if steps else {"tolerance": 1e-5})
        self.scene.write_text(scene_text({"time": time, "output": {"series": DURATION / rows, "checkpoint": DURATION / 2, "audit": True}} | scene))
        self.run_skein(out, "--overwrite" if layout.pop("anew", True) else "-q", *arguments, **layout)
        return self.series(out)

    def size(self, series):
        """Of the energies that move, J."""
        return sum(numpy.ptp(series[name]) for name in series.dtype.names if name.startswith(("kinetic", "elastic", "work")))

    def test_small_motion_closes(self):
        """The loss of steps is known for linear motion: the books close to a small part of it."""
        scene = {"rods": [rod(start="clamped")], "load": gravity(1e-3)}
        for steps in (25, 100):
            series = self.books("small", scene, "implicit_damped", steps)
            loss = abs(series["numerical_lossJ"]).max()
            print(f"{steps} steps: loss {loss / self.size(series)}, defect {abs(series['energy_defectJ']).max() / self.size(series)}")
            self.assertGreater(loss, 5e-8 * self.size(series))
            self.assertLess(abs(series["energy_defectJ"]).max(), 1e-3 * loss)

    def test_steps_that_keep_energy_lose_none(self):
        """In large motion, with damping and filters: no step takes anything, and what is dissipated is what damping and filters take."""
        for name, tables in {"free": {"rods": [rod(shape=CURVED)]}, "pendulum": {"rods": [rod(3e5, start="pinned", tangent=(0.8, 0.0, -0.6))], "load": gravity()},
                             "damped": {"rods": [rod(shape=CURVED)], "damping": DAMPING}, "ring": {"rods": [rod(shape={"closed": True, "angular_velocity": [3.0, 5.0, 1.0]})], "load": gravity()}}.items():
            series = self.books(name, tables, "implicit", 200)
            print(name, abs(series["energy_defectJ"]).max() / self.size(series), abs(series["numerical_lossJ"]).max() / self.size(series), series["dissipatedJ"][-1] / self.size(series))
            self.assertLess(abs(series["energy_defectJ"]).max(), 1e-7 * self.size(series), name)
            self.assertLess(abs(series["numerical_lossJ"]).max(), 1e-7 * self.size(series), name)
            if "damping" in tables: self.assertGreater(series["dissipatedJ"][-1], 1e-2 * self.size(series))

    def test_books_close_to_second_order(self):
        """With damping, filters, walls that shake, and loads that follow."""
        scenes = {"shaken": {"rods": [rod(1e5, start="clamped", start_motion=SHAKEN)], "load": gravity(), "damping": DAMPING},
                  "frozen": {"rods": [rod(1e5, start="clamped_frozen", start_motion=SHAKEN)], "load": gravity()},
                  "followed": {"rods": [rod(1e5, start="clamped")], "load": [{"kind": "end_force", "frame": "body", "end": [0.0, 0.02, 0.05]}], "damping": DAMPING}}
        for name, scene in scenes.items():
            for method in ("implicit", "implicit_damped"):
                defects = []
                for steps in (800, 1600, 3200):
                    series = self.books(name, scene, method, steps)
                    defects.append(abs(series["energy_defectJ"]).max() / self.size(series))
                print(name, method, defects)
                for coarse, fine in zip(defects, defects[1:]):
                    self.assertLess(fine, max(coarse / 3.3, 1e-8), (name, method, defects))
                self.assertLess(defects[-1], 1e-4, (name, method))

    def test_books_are_those_of_any_layout_and_go_on(self):
        """By tolerance: companions and parts that are taken back leave nothing in them."""
        scene = {"rods": [rod(1e5, start="clamped", placement={"kind": "lattice", "counts": [3, 3], "spacing": [0.6, 0.6]})], "load": gravity(), "damping": DAMPING}
        for steps in (0, 400):
            whole = self.books(f"whole{steps}", scene, "implicit_damped", steps)
            self.assertLess(abs(whole["energy_defectJ"]).max(), 1e-3 * self.size(whole))
            self.assertLess(abs(whole["numerical_lossJ"]).max(), 1e-2 * self.size(whole))
            self.books(f"two{steps}", scene, "implicit_damped", steps, ranks=2)
            self.books(f"parts{steps}", scene, "implicit_damped", steps, "--until", str(0.5 * DURATION), ranks=2)
            self.assertIn("Resuming from", self.run_skein(f"parts{steps}").stdout)
            for out in ("two", "parts"):
                self.assert_same_series(f"{out}{steps}", f"whole{steps}")


if __name__ == "__main__":
    unittest.main()
