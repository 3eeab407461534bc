"""Every feature beside every other, in one process: a small scene has both, makes fifteen steps, and its state differs from that with either alone. What is refused
has its reason in REFUSED, and stands in docs/pairs.md, which SKEIN_UPDATE_PAIRS=1 writes."""

import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

from feature_rows import NOT_ROWS, STAGES, rows_of, scene_of
from package import ROOT, SKEIN, skein

PAGE = ROOT / "docs/pairs.md"
MOST_REFUSED = 0.02  # of all pairs, with a reason in physics
# Pattern of the message, one of the two features, what it does not go with, the reason in physics; no reason: not built yet.
REFUSED = (
    (r"'relax' has no motion for the fluid", "relaxation", "a fluid", "A relaxation makes pseudo-time steps, in which a fluid has no velocity to answer."),
    (r"time.relax needs friction that holds", "relaxation", "friction without memory", "Such friction vanishes at rest, so every state near rest is one of rest."),
    (r"time.relax needs loads that do not change|answers motion, which time.relax|slows .* down, and time.relax", "relaxation", "loads that change with time or answer motion",
     "A state of rest has constant loads and no velocities."),
    (r"time.relax chooses damping|has no use with relax = true", "relaxation", "damping, integrators", "It makes its own steps; damping does not change the state of rest."),
    (r"time.relax is not for walls that move", "relaxation", "walls that move", "A wall that moves leaves no state of rest."),
    (r"time.relax is not for ends that are moved", "relaxation", "moved ends", "A motion is a function of time, and the steps of a relaxation are none of time."),
    (r"time.relax is not for rigid bodies", "relaxation", "free rigid bodies", "A body has no stiffness by which it comes to rest."),
    (r"time.relax needs a law with an energy|no audit of group .* has no energy", "relaxation, audits", "`law = \"elastica\"`", "This law has no energy."),
    (r"no audit with time.relax", "relaxation", "audits", "Inertia in pseudo-time is not that of the rods, so there is no balance of energy."),
    (r"need.* the integrator \"verlet\"|needs? integrator = \"verlet\"", "`integrator = \"pefrl\"`", "contact, walls, filters of damping, fluids that rods feel",
     "Some of its kicks go backwards in time; friction, dashpots and fluids dissipate in forward time alone."),
    (r"time.integrator = \"implicit(_damped|_bed)?\" needs a law with an energy", "implicit steps", "`law = \"elastica\"`", "Newton corrections need the stiffness of an energy, and this law has none."),
    (r"with integrator = \"implicit", "implicit steps", "choices of explicit steps", "Stability does not limit these steps, so there is nothing to choose."),
    (r"a ring has no ends|needs rods with two ends", "rings", "held ends, loads on ends", "A ring has no ends."),
    (r"\"gregory\" has no use here|with end_weights = \"gregory\"", "`end_weights = \"gregory\"`", "tapered, frozen or joined rods, `law = \"elastica\"`",
     "The weights are derived for uniform rods with an energy, whose ends are free or clamped."),
    (r"is at an end of .* that is clamped", "common nodes", "clamped ends", "The place is the wall's: a second rod there is clamped, and the joint says nothing more."),
    (r"m off the axis of", "common nodes", "rods placed at random", "Their axes do not meet; a joint of given stiffness bridges a gap."),
    (r"must start straight, without rest_strain", "packings", "rods that are curved or strained at the start", "A packing places straight capsules; `start_curvature` lets curved rods begin straight."),
    (r"time.relax passes strains", "relaxation", "`break_strain`", "A relaxation passes strains that no motion has."),
    (r"'break_strain' needs two ends", "`break_strain`", "rings, held elements", "Rods tear where two ends meet that turn freely."),
    (r"time.relax has no time (that a motor could follow|for 'from' and 'until')", "relaxation", "motors, `from` and `until` of joints", "They are functions of time, and the steps of a relaxation are none of time."),
)
# Pairs that run and leave the state as one of them does, with the reason.
INERT = (
    (r"rods.start", r"load.kind = (guide|end_couple)", "a force on a node that is held"),
    (r"rods.end", r"load.kind = (end_force|sinusoidal_end_force)", "a force on a node that is held"),
    (r"contact", r"joint.kind = side_by_side", "the elements that touch are joined"),
)
HEAD = """# What goes with what

`python.pairs` (`tests/python/pairs_test.py`) runs every feature of scenes beside every other: {rows} features, {pairs} pairs, fifteen steps each, or sixty with stages. A pair passes if the
state differs from that with either feature alone. {refused} pairs ({share:.1f} %) are refused. A refusal names the table, the line and the feature to leave out.

## Refused for a reason in physics

{physical} pairs, {physical_share:.1f} %.

| feature | does not go with | reason | pairs |
|---|---|---|---|
"""


def plain(message):
    return re.sub(r"\S*/skein_\w+/", "", message)


class Pairs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.rows = rows_of(Path(cls.folder.name))
        cls.alone = {}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def digest(self, *edits, steps=15, **tables):
        """After some steps of a scene with these rows, each for a group, and with these tables."""
        with skein.Simulation(skein.Scene("pair", **scene_of(*edits) | tables), threads=1) as run:
            run.step(steps)
            for row, _ in edits:
                if row.looks: self.assertIn(row.looks, run.observables, row.name)
            return run.digest

    def digest_alone(self, row, where, steps=15):
        if (row.name, where, steps) not in self.alone: self.alone[row.name, where, steps] = self.digest((row, where), steps=steps)
        return self.alone[row.name, where, steps]

    def pairs(self):
        for i, a in enumerate(self.rows):
            for b in self.rows[i + 1:]:
                if a.sets != b.sets: yield a, b, "left"
                elif a.of_group: yield a, b, "right"

    def test_every_choice_has_a_row(self):
        """A new choice of a key of `skein describe` needs a row, or a reason in NOT_ROWS."""
        keys = json.loads(subprocess.run([SKEIN, "describe", "--json"], capture_output=True, text=True, check=True).stdout)["keys"]
        names = {row.name for row in self.rows}
        for key in keys:
            path = re.sub(r"^load\.\w+\.", "load.", key["path"])
            if path in NOT_ROWS: continue
            for choice in key.get("choices", ()):
                if str(choice) == str(key.get("default", "")).strip('"'): continue
                self.assertTrue(f"{path} = {choice}" in names or f"{path} = {choice}" in NOT_ROWS, f"{path} = {choice} has no row in feature_rows.py")

    def test_each_alone(self):
        base = {steps: self.digest(steps=steps) for steps in (15, 60)}
        for row in self.rows:
            with self.subTest(row.name):
                self.assertEqual(self.digest_alone(row, "left", row.steps) == base[row.steps], bool(row.looks))

    def test_stages_that_change_nothing(self):
        """All is made anew as a stage begins, of every feature, and its bits stay."""
        for row in self.rows:
            if row.steps > 15: continue  # has stages
            with self.subTest(row.name):
                self.assertEqual(self.digest((row, "left"), steps=60, stage=STAGES), self.digest_alone(row, "left", 60))

    def test_every_pair(self):
        counts, pairs = [0] * len(REFUSED), 0
        for a, b, where in self.pairs():
            pairs += 1
            with self.subTest(a=a.name, b=b.name):
                steps = max(a.steps, b.steps)
                try:
                    both = self.digest((a, "left"), (b, where), steps=steps)
                except skein.RunFailed as failed:
                    reasons = [i for i, (pattern, *_) in enumerate(REFUSED) if re.search(pattern, plain(str(failed)).split("\n")[0])]
                    self.assertEqual(len(reasons), 1, plain(str(failed)))
                    counts[reasons[0]] += 1
                    continue
                one, other = self.digest_alone(a, "left", steps), self.digest_alone(b, where, steps)
                if a.looks or b.looks: self.assertIn(both, (one, other))
                elif both in (one, other): self.assertTrue(any(re.search(x, a.name) and re.search(y, b.name) for x, y, _ in INERT), "neither changes what the other does")
        self.assertTrue(all(counts), [REFUSED[i][0] for i, count in enumerate(counts) if not count])
        physical = sum(count for count, (*_, reason) in zip(counts, REFUSED) if reason)
        self.assertLessEqual(physical, MOST_REFUSED * pairs)
        self.compare_page(counts, pairs, physical)

    def compare_page(self, counts, pairs, physical):
        refused = sum(counts)
        text = HEAD.format(rows=len(self.rows), pairs=pairs, refused=refused, share=100 * refused / pairs, physical=physical, physical_share=100 * physical / pairs)
        rows = [(one, other, reason, count) for count, (_, one, other, reason) in zip(counts, REFUSED)]
        text += "".join(f"| {one} | {other} | {reason} | {count} |\n" for one, other, reason, count in rows if reason)
        text += f"\n## Not built yet\n\n{refused - physical} pairs.\n\n| feature | does not go with | pairs |\n|---|---|---|\n"
        text += "".join(f"| {one} | {other} | {count} |\n" for one, other, reason, count in rows if not reason)
        text += "\n## Without effect on each other\n\n" + "".join(f"* `{x}` and `{y}`: {why}.\n" for x, y, why in INERT)
        if os.environ.get("SKEIN_UPDATE_PAIRS"): PAGE.write_text(text)
        self.assertEqual(PAGE.read_text(), text, "SKEIN_UPDATE_PAIRS=1 python.pairs writes the page")

    def test_holds_are_copied(self):
        """A copy turned by a right angle about z moves as the first one, turned: its held and moved ends went along."""
        place = {"kind": "list", "origins": [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]], "tangents": [[0.0, 0.0, 1.0]] * 2, "normals": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]}
        motion = {"times": [0.0, 0.01], "translation": [[0.0, 0.0, 0.0], [0.001, 0.002, -0.003]], "rotation": [[0.0, 0.0, 0.0], [0.3, 0.2, 0.1]]}
        tried = 0
        for row in self.rows:
            if not row.name.startswith(("rods.start", "rods.end", "rods.hold")) or row.name == "rods.start_free": continue  # free in a lab direction
            scene = scene_of((row, "left")) | {"time": {"duration": 0.01}, "load": [{"kind": "gravity"}], "assembly": [{"name": "pair", "placement": place}]}
            for rods in scene["rods"]:
                rods["assembly"] = "pair"
                for key in ("velocity", "angular_velocity", "element_spin"): rods["shape"].pop(key, None)
                for key in ("start_motion", "end_motion"):
                    if key in rods: rods[key] = motion
            with self.subTest(row.name), skein.Simulation(skein.Scene("copies", **scene), threads=1) as run:
                one, other = run.step(run.steps)["left"].position
                turned = np.stack([1.0 - one[:, 1], 2.0 + one[:, 0], one[:, 2]], axis=1)
                self.assertGreater(np.abs(one - one[0]).max(axis=0)[2], 1e-4)
                np.testing.assert_allclose(other, turned, atol=1e-13)
                tried += 1
        self.assertEqual(tried, 11)

    def test_joined_rods_touch(self):
        """A joint too soft to be felt leaves the bits of contact alone, except near its place and where rods of one copy are not to touch."""
        contact = {"law": "hertz", "stiffness": 1e5, "damping": 1.0, "friction": "memory", "static_friction": 0.5}
        joint = {"kind": "spherical", "between": ["left", "right"], "at": [0.0, 0.5], "stiffness": 1e-200}

        def digest(joint=None, **keys):
            scene = scene_of() | {"contact": contact | keys} | ({"joint": [joint]} if joint else {})
            with skein.Simulation(skein.Scene("joined", **scene), threads=1) as run:
                return run.step(15).digest

        with skein.Simulation(skein.Scene("apart", **scene_of()), threads=1) as run:
            apart = run.step(15).digest
        touching = digest()
        self.assertNotEqual(touching, apart)
        self.assertEqual(digest(joint, joined=True), touching)
        self.assertEqual(digest(joint), apart)
        self.assertEqual(digest(joint | {"at": [0.5, 0.5]}, joined=True), apart, "elements at a joint do not touch")
        self.assertEqual(digest(joint | {"at": [0.3, 0.5]}, joined=True), touching, "a way of 0.015 m is longer than half the way round")
        self.assertEqual(digest(joint | {"at": [0.3, 0.5]}, joined=True, self_gap=0.05), apart)

        twig = {"material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 0.02}, "shape": {"length": 0.5, "elements": 10}}
        fork = {"time": {"duration": 1e-4}, "contact": contact | {"joined": True}, "joint": [{"kind": "fixed", "between": ["stem", "twigs"], "pairs": "listed", "first": [0, 0], "second": [0, 1]}],
                "rods": [twig | {"name": "stem", "placement": {"tangent": [0.0, 0.0, 1.0]}},
                         twig | {"name": "twigs", "placement": {"kind": "list", "origins": [[0.0, 0.0, 0.5]] * 2, "tangents": [[0.8, 0.0, 0.6], [-0.8, 0.0, 0.6]]}}]}
        with skein.Simulation(skein.Scene("fork", **fork), threads=1) as run:
            self.assertEqual(run.step(run.steps).observables["touching_pairs[-]"], 0, "twigs of one place do not touch there")


if __name__ == "__main__":
    unittest.main()
