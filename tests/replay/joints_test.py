#!/usr/bin/env python3
"""reference_replay on joints of two rods whose motion is known in closed form, or in two unknowns.

    joints_test.py REFERENCE_REPLAY

Rods are loose: what moves a node or turns an element is the joint alone.
"""
import copy
import math
import unittest

from cases import DT, J1, L, M, N, STEPS, Replay, case, plus, rod, shifted, times, turned

R, K, NU, KT, NUT = 0.01, 40.0, 0.3, 2e-3, 1e-5


def loose(by=(0, 0, 0), angle=0.0):
    """A loose rod, shifted, whose directors are turned about y; without turning stiffness these need not lie along its edges."""
    made = rod(stiff=False)
    made.update(position=shifted(N, by), directors=[turned(angle, 1)] * N)
    return made


def joint(kind, **more):
    return {"system": 0, "other": 1, "kind": kind, "index": -1, "other_index": 0, "k": K, "nu": NU, **more}


IDENTITY = [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]


class Points(Replay):
    def test_a_spring_and_a_dashpot_draw_two_nodes_together(self):
        gap, start = 0.02, (0.4, -0.1)
        a, b = loose(), loose((gap, 0, N * L))
        a["velocity"] = [[start[0] * (i == N), 0, 0] for i in range(N + 1)]
        b["velocity"] = [[start[1] * (i == 0), 0, 0] for i in range(N + 1)]
        states, x, v = [([0.0, gap], list(start))], [0.0, gap], list(start)
        for _ in range(max(STEPS)):
            middle = [p + 0.5 * DT * q for p, q in zip(x, v)]
            force = K * (middle[1] - middle[0]) + NU * (v[1] - v[0])
            v = [v[0] + DT * force / M, v[1] - DT * force / M]
            x = [p + 0.5 * DT * q for p, q in zip(middle, v)]
            states.append((x, v))

        def motion(i, k):
            made, node = copy.deepcopy((a, b)[i]), (N, 0)[i]
            made["position"][node][0], made["velocity"][node][0] = states[k][0][i], states[k][1][i]
            return {f: made[f] for f in ("position", "velocity")}
        content = case([a, b], motion, [joint("free_joint")])
        self.replay(content, 0)
        content["forces_in_order"][0]["k"] *= 1.001
        self.replay(content, 1)

    def turning(self, entry, angles, spins, couple):
        """After a step from given turns and spins about y: `couple`, on B about y."""
        a, b = loose(angle=angles[0]), loose((0, 0, N * L), angles[1])
        a["omega"], b["omega"] = ([[0, w, 0]] * N for w in spins)
        at = {0: N - 1, 1: 0}

        def motion(i, k):
            rates = [spins[i] + DT * (-couple, couple)[i] / J1 * (e == at[i]) for e in range(N)]
            return {"omega": [[0, w, 0] for w in rates],
                    "directors": [turned(angles[i] + 0.5 * DT * (spins[i] + w), 1) for w in rates]}
        self.replay(case([a, b], motion, [entry], steps=(1,)), 0)

    def test_a_hinge_turns_the_tangent_out_of_its_normal(self):
        b = 0.3
        tangent = turned(b, 1)[2]
        couple = -KT * tangent[0] * tangent[2]
        self.turning(joint("hinge_joint", kt=KT, normal_direction=[2.0, 0, 0]), (0.0, b), (0.0, 0.0), couple)
        self.assertAlmostEqual(abs(tangent[0]), math.sin(b))

    def test_a_fixed_joint_turns_frames_back(self):
        a, b, spins = 0.4, 0.1, (0.2, -0.5)
        turn = (a + 0.5 * DT * spins[0]) - (b + 0.5 * DT * spins[1])
        couple = KT * turn - NUT * (spins[1] - spins[0])
        self.turning(joint("fixed_joint", kt=KT, nut=NUT, rest_rotation_matrix=IDENTITY), (a, b), spins, couple)

    def test_a_fixed_joint_keeps_the_rotation_of_rest(self):
        # C = Q_A Q_B^T at rest about one axis: no couple
        rest = [[sum(p * q for p, q in zip(r, s)) for s in turned(0.1, 1)] for r in turned(0.4, 1)]
        self.turning(joint("fixed_joint", kt=KT, nut=0.0, rest_rotation_matrix=rest), (0.4, 0.1), (0.0, 0.0), 0.0)


class Sides(Replay):
    def test_sides_are_drawn_together(self):
        apart, offset = 0.002, 0.004
        a, b = loose(), loose((2 * R + offset + apart, 0, 0))
        entry = {"system": 0, "other": 1, "kind": "surface_joint_side_by_side", "index": [0, 2], "other_index": [0, 2],
                 "direction_one": [[1.0, 0, 0]] * 2, "direction_two": [[-1.0, 0, 0]] * 2, "offset": [offset] * 2, "k": K, "nu": NU, "k_repulsive": 0.0}
        half = 0.5 * K * apart
        masses = [M] + [2 * M] * (N - 1) + [M]
        drawn = [DT * half / masses[i] * (i in (0, 1, 2, 3)) for i in range(N + 1)]

        def motion(i, k):
            rates = [[(1, -1)[i] * v, 0, 0] for v in drawn]
            return {"velocity": rates, "position": [plus(x, times(0.5 * DT, v)) for x, v in zip((a, b)[i]["position"], rates)]}
        self.replay(case([a, b], motion, [entry], steps=(1,)), 0)
        entry["k_repulsive"] = 1.0
        self.assertIn("surface_joint_side_by_side", self.replay(case([a, b], motion, [entry], steps=(1,)), 7).stderr)
        entry.update(k_repulsive=0.0, other_index=[0])
        self.assertIn("other_index", self.replay(case([a, b], motion, [entry], steps=(1,)), 2).stderr)


if __name__ == "__main__":
    unittest.main()
