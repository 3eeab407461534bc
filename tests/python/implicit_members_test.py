"""Every feature of scenes in implicit steps: it comes to the explicit places with an error of second order, or is refused with the reason and a way out."""

import math
import re
import tempfile
import unittest
from pathlib import Path

import numpy as np

from feature_rows import rows_of, scene_of
from package import skein

DURATION, STEPS, EXPLICIT_STEPS = 2e-3, 240, 2400  # multiples of 15, which a step of a fluid has at least
METHODS = ("implicit", "implicit_damped")
BED, BED_STEPS = "implicit_bed", 2400
NOT_SMOOTH = r"friction = (regularised|published|anisotropic)|wall|contact"  # friction without memory, and contacts that begin, have errors of the first order at shorter steps alone
LEFT_OVER = {"position": 1e-10, "directors": 1e-10 * 2 * STEPS}  # m, 1: of corrections that have ended
# Pattern of the row and of the message: what has no implicit steps, with the reason and the way out in the message.
REFUSED = (
    (r"rods.material.law = elastica", r"needs a law with an energy"),
)
FIRST_ORDER = {"damping.kind = legacy": "the rates are far above 1/dt, where explicit steps are of first order"}
JUMPS = {"wall.law = linear": {"position": 5e-8, "directors": 5e-7}}  # m, 1: a dashpot acts from the first touch on; where that is within a step decides 1e-5 of the way of 6 mm, in explicit steps too
EVENTS = r"joint\.(from|until|break)"  # at the ends of steps
LAGGING = r"fluid|immersion|obstacle|output\.fluid"  # explicit rods lag half a step behind what such a fluid feels: in steps of the fluid that stay as they are they are of first order
OWN_TIMES = r"time\.|stage|(load|joint).stages|table|joint.break_strain"  # keys of other steps, stages whose ends go to the next step, a table that rises within a step, a joint that tears in the first
BEAM = {"material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 4e-3}}
LET_GO = {"length": 0.1, "elements": 8, "rest_curvature": [3.0, 4.0, 5.0], "start_curvature": [0.0, 0.0, 0.0]}  # straight at the start
ENDS = ("free", "pinned", "clamped", "clamped_frozen")
UNTIL = 2 * DURATION
MOTIONS = {
    "sine": {"amplitude": [0.001, 0.002, 0.003], "period": UNTIL},
    "turn": {"rotation_amplitude": [0.3, 0.2, 0.4], "period": UNTIL},
    "table": {"times": [0.0, UNTIL], "translation": [[0.0, 0.0, 0.0], [0.001, -0.002, 0.001]], "rotation": [[0.0, 0.0, 0.0], [0.3, 0.1, 1.0]], "smooth": True},
    "formula": {"translation_formula": ["0", "0.002*sin(w*t)", "0"], "rotation_formula": ["0.2*sin(w*t)", "0", "0.1*w*t"]},
}


def state(scene, **time):
    with skein.Simulation(skein.Scene("member", **scene | {"time": {"duration": DURATION} | time}), threads=1) as run:
        run.step(run.steps)
        return {(name, what): np.array(getattr(group, what)) for name, group in run.groups.items() for what in ("position", "directors")}


class ImplicitMembers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.rows = [row for row in rows_of(Path(cls.folder.name)) if not re.match(OWN_TIMES, row.name)]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def assert_agrees(self, scene, first_order=False, methods=(*METHODS, BED), less=3, less_in_beds=1.7, finer=1, finer_in_beds=1, lags=False, jump=None):
        """With the explicit state, group by group, at the order of the steps: the second, in beds the first."""
        steps = (4 * EXPLICIT_STEPS, 8 * EXPLICIT_STEPS) if first_order else (EXPLICIT_STEPS, 2 * EXPLICIT_STEPS)
        coarse, fine = (state(scene, dt=DURATION / n, force_dt=True) for n in steps)
        for method in methods:
            less_of, count = (less_in_beds, finer_in_beds * BED_STEPS) if method == BED else (less, finer * STEPS)
            one, two = (state(scene, dt=DURATION / n, integrator=method) for n in (count, 2 * count))
            for of, b in fine.items():
                change = b - coarse[of]
                explicit, unsure = b + change / 3, np.abs(change).max() / (1 if first_order else 3)
                if lags: explicit, unsure = b + change, np.abs(change).max() / 50
                first, second = (np.abs(end[of] - explicit).max() for end in (one, two))
                with self.subTest(group=of, method=method):
                    self.assertLessEqual(second, max(first / less_of, 2 * unsure, LEFT_OVER[of[1]], jump[of[1]] if jump else 0), (first, unsure))

    def beams(self, groups):
        """A scene of rods that begin straight and bend at once."""
        return {"rods": [BEAM | {"name": name, "shape": LET_GO, "placement": {"origin": [0.0, 0.1 * i, 0.0], "tangent": [1.0, 0.0, 0.0]}} | keys
                         for i, (name, keys) in enumerate(groups.items())], "load": [{"kind": "gravity"}]}

    def test_ends(self):
        groups = {f"{start}-{end}": {"start": start, "end": end} for start in ENDS for end in ENDS}
        for kind in ENDS[1:]:
            for free in ("x", "z", "yz"):
                groups |= {f"{kind}-{side}-slides-{free}": {side: kind, f"{side}_free": free} for side in ("start", "end")}
        self.assert_agrees(self.beams(groups))

    def test_moved_ends(self):
        groups = {}
        for kind in ENDS[1:]:
            for name, motion in MOTIONS.items():
                if kind == "pinned" and name != "sine": continue  # it turns as it likes
                for side, other in (("start", "end"), ("end", "start")):
                    groups |= {f"{side}-{kind}-{name}-{beyond}": {side: kind, f"{side}_motion": motion, other: beyond} for beyond in ("free", "clamped")}
        self.assert_agrees(self.beams(groups) | {"constants": {"w": {"value": math.pi / DURATION, "unit": "1/s"}}})

    def test_held_nodes_and_elements(self):
        groups = {f"nodes-{i}-{directions}": {"hold": {"nodes": nodes, "directions": directions}}
                  for i, nodes in enumerate(([0], [4], [-1], [2, 5])) for directions in ("x", "y", "yz", "xyz")}
        groups |= {f"elements-{i}-{axes}": {"hold": {"elements": elements, "axes": axes}}
                   for i, elements in enumerate(([0], [3], [-1], [2, 5])) for axes in ("x", "y", "z", "xy", "yz", "xyz")}
        self.assert_agrees(self.beams(groups))

    def test_rings_and_short_rods(self):
        """Rings of all remainders by three: loads' slopes are taken in three colours and what is left."""
        spun = {"angular_velocity": [30.0, 20.0, 10.0], "element_spin": [0.0, 0.0, 20.0]}
        groups = {f"ring-{n}": {"shape": {"length": 0.2, "elements": n, "closed": True} | spun} for n in (3, 4, 5, 12, 13, 14)}
        groups |= {f"ring-{n}-held": {"shape": {"length": 0.2, "elements": n, "closed": True}, "hold": {"nodes": [0], "elements": [-1]}} for n in (12, 13, 14)}
        groups |= {f"short-{n}": {"shape": LET_GO | {"elements": n}} for n in (2, 3, 4)}
        pulled = [{"kind": "formula", "force": ["-2*x/0.1", "-0.5*y/0.1", "0.2*sin(x/0.01)"]}]
        self.assert_agrees(self.beams(groups) | {"load": pulled})

    def test_loads_beside_each_other(self):
        """Of every kind that the rows have, on one rod: those that ignore motion beside those that answer it."""
        scene = {}
        for row in self.rows:
            if row.name.startswith("load.kind") and "magnetic" not in row.name:
                scene.setdefault("load", []).extend(scene_of((row, "left"))["load"])
        self.assertGreater(len(scene["load"]), 10)
        self.assert_agrees(scene_of() | scene)

    def test_each_agrees_or_is_refused(self):
        left = {pattern for pattern, _ in REFUSED}
        for row in self.rows:
            scene = scene_of((row, "left"))
            reasons = [(pattern, message) for pattern, message in REFUSED if re.match(pattern, row.name)]
            with self.subTest(row.name):
                if not reasons:
                    self.assert_agrees(scene, row.name in FIRST_ORDER or row.name.startswith(("wall", "contact")), less=1.0 if re.match(r"contact.friction = [rp]", row.name) else 1.7 if re.match(EVENTS, row.name) or re.search(NOT_SMOOTH, row.name) else 3, less_in_beds=1.0 if re.search(NOT_SMOOTH, row.name) else 1.7, jump=JUMPS.get(row.name), lags=re.match(LAGGING, row.name),
                                       finer=8 if row.name.startswith("contact") else 1,  # steps that contacts do not cut
                                       finer_in_beds=8 if row.name == "contact.friction = published" else 1)
                    continue
                left.discard(reasons[0][0])
                for method in (*METHODS, BED):
                    with self.assertRaisesRegex(skein.RunFailed, reasons[0][1]):
                        state(scene, dt=DURATION / STEPS, integrator=method)
        self.assertEqual(left, set(), "no row is refused by these")

    def test_keys_of_explicit_steps_have_no_use(self):
        for key, value in {"safety": 0.5, "e_min": 0.9, "damping": "after", "force_dt": True, "tolerance": 1e-3}.items():
            with self.subTest(key), self.assertRaisesRegex(skein.RunFailed, f"'?{key}'? .*no use"):
                state(scene_of(), dt=DURATION / STEPS, integrator="implicit", **{key: value})
        with self.assertRaisesRegex(skein.RunFailed, "tolerance.*no use"):
            state(scene_of(), tolerance=1e-3)


if __name__ == "__main__":
    unittest.main()
