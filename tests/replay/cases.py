"""Tiny reference files whose motion is known, and a test case that replays them: for tests of reference_replay, which call it with the
program as first argument.

A rod of n elements lies along z with its directors along x, y, z. Stiff rods move as one where loads are shared by mass; rods
without stiffness are loose beads and spinning tops. Node masses are M at the ends and 2 M inside.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop(1)
DT, L, M, J1, J3, N = 1e-3, 0.1, 0.2, 2e-5, 4e-5, 4
STEPS = (1, 10, 100)
FIELDS = ("position", "velocity", "directors", "omega")


def times(a, v):
    return [a * c for c in v]


def plus(*vectors):
    return [sum(c) for c in zip(*vectors)]


def turned(angle, axis=2):
    """Directors along the axes, turned about one of them."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    q = [[float(r == c) for c in range(3)] for r in range(3)]
    q[j][j] = q[k][k] = math.cos(angle)
    q[j][k], q[k][j] = math.sin(angle), -math.sin(angle)
    return q


def rod(n=N, velocity=(0, 0, 0), spin=(0, 0, 0), stiff=True):
    s = 1.0 if stiff else 0.0
    return {"kind": "rod", "ring": False, "n_elems": n,
            "position": [[0, 0, L * i] for i in range(n + 1)], "velocity": [list(velocity)] * (n + 1),
            "directors": [turned(0)] * n, "omega": [list(spin)] * n,
            "mass": [M] + [2 * M] * (n - 1) + [M], "mass_second_moment_of_inertia": [[J1, J1, J3]] * n,
            "rest_lengths": [L] * n, "rest_voronoi_lengths": [L] * (n - 1), "volume": [math.pi * 1e-4 * L] * n,
            "shear_matrix": [[300 * s, 300 * s, 900 * s]] * n, "bend_matrix": [[0.08 * s, 0.08 * s, 0.05 * s]] * (n - 1),
            "rest_sigma": [[0, 0, 0]] * n, "rest_kappa": [[0, 0, 0]] * (n - 1)}


def ring(n=6):
    """A straight rod bent to a regular polygon in the x-y plane, d1 along z: the same moment in every cell, so at rest."""
    r, ring = L / (2 * math.sin(math.pi / n)), rod(n)
    corner = lambda k: [r * math.cos(2 * math.pi * k / n), r * math.sin(2 * math.pi * k / n), 0]
    tangent = [times(1 / L, plus(corner(k + 1), times(-1, corner(k)))) for k in range(n)]
    ring.update(ring=True, position=[corner(k) for k in range(n)], velocity=[[0, 0, 0]] * n, mass=[2 * M] * n,
                directors=[[[0, 0, 1], [t[1], -t[0], 0], t] for t in tangent],
                rest_voronoi_lengths=[L] * n, bend_matrix=[[0.08, 0.08, 0.05]] * n, rest_kappa=[[0, 0, 0]] * n)
    return ring


def case(systems, motion, forces=(), constraints=(), dampers=(), stepper="PositionVerlet", steps=STEPS):
    """`motion(system, k)`: fields after k steps that differ from the start; more than the state may be given."""
    outputs = []
    for k in steps:
        states = []
        for i, system in enumerate(systems):
            states.append(None if system["kind"] == "plane" else {**{f: system[f] for f in FIELDS}, **motion(i, k)})
        outputs.append({"step": k, "time": k * DT, "systems": states})
    flat = lambda a: max(map(flat, a)) if isinstance(a, list) else abs(a)
    scale = {f: max(flat(s[f]) for o in outputs for s in o["systems"] if s) for f in FIELDS}
    return {"format": "rod-reference 1", "case": "closed form", "stepper": stepper, "dt": DT, "start_time": 0.0, "systems": systems,
            "forces_in_order": list(forces), "constraints_in_order": list(constraints), "dampers_in_order": list(dampers),
            "outputs": outputs, "scale": scale, "roundoff_sensitivity": [{"step": k, **{f: 0.0 for f in FIELDS}} for k in steps]}


def shifted(n, by):
    """All nodes of a rod moved by a vector."""
    return [plus([0, 0, L * i], by) for i in range(n + 1)]


def travelled(velocity):
    """Of a rate whose value after step k is velocity(k): half steps at both ends."""
    return lambda k: DT * (0.5 * velocity(0) + sum(velocity(j) for j in range(1, k)) + 0.5 * velocity(k))


def rising(rate):
    """Rate after k steps under rate(t) at mid-steps."""
    return lambda k: DT * sum(rate((j + 0.5) * DT) for j in range(k))


class Replay(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.file = pathlib.Path(self.folder.name) / "case.json"

    def tearDown(self):
        self.folder.cleanup()

    def replay(self, content, expect):
        self.file.write_text(content if isinstance(content, str) else json.dumps(content))
        done = subprocess.run([PROGRAM, str(self.file)], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done

    def agrees(self, *arguments, **named):
        return self.replay(case(*arguments, **named), 0)
