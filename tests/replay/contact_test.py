#!/usr/bin/env python3
"""reference_replay on contacts, rigid bodies and planes whose motion is known in closed form, or in two unknowns.

    contact_test.py REFERENCE_REPLAY

Rods are loose: what moves a node or turns an element is the load under test alone. Their radius is R, that of bodies BALL.
"""
import copy
import math
import unittest

from cases import DT, J1, J3, L, M, N, STEPS, Replay, case, plus, rod, shifted, times, travelled, turned

R, BALL, MASS = 0.01, 0.05, 0.7
RUBBING = {"friction_coefficient": 0.3, "velocity_damping_coefficient": 4.0}


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def crossing(n=3, along=2, x=0.0, still=None, speed=0.0):
    """A loose rod whose middle is at height x, lying along axis 1 or 2; the nodes of its middle element have a speed along x."""
    made = rod(n, stiff=False)
    made["position"] = [[x, 0, 0] for _ in range(n + 1)]
    for i in range(n + 1):
        made["position"][i][along] = L * (i - 0.5 * n)
        made["velocity"][i] = [speed if still is None or i not in still else 0.0, 0, 0]
    return made


def body(kind="sphere", position=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0), inertia=(0.01, 0.01, 0.003), directors=None, length=2 * BALL):
    return {"kind": kind, "position": [list(position)], "velocity": [list(velocity)], "directors": [directors or turned(0)], "omega": [list(spin)],
            "mass": MASS, "mass_second_moment_of_inertia": list(inertia), "radius": BALL, "length": length}


def turn(directors, vector):
    """Directors turned by a vector of body components."""
    angle = math.sqrt(dot(vector, vector))
    if angle == 0:
        return directors
    u, c, s = times(1 / angle, vector), math.cos(angle), math.sin(angle)
    # A vector of the lab has new body components: turned the other way.
    column = lambda a: plus(times(c, a), times(-s, cross(u, a)), times((1 - c) * dot(u, a), u))
    columns = [column([row[j] for row in directors]) for j in range(3)]
    return [[columns[j][i] for j in range(3)] for i in range(3)]


def verlet(x, v, acceleration, steps):
    """States after 0, 1, ... steps of lists of numbers; forces are taken in mid-step with the rates before it."""
    states = [(list(x), list(v))]
    for _ in range(steps):
        x, v = states[-1]
        middle = [a + 0.5 * DT * b for a, b in zip(x, v)]
        v = [b + DT * a for b, a in zip(v, acceleration(middle, v))]
        states.append(([a + 0.5 * DT * b for a, b in zip(middle, v)], v))
    return states


def moved(start, velocity):
    """Nodes after one step from rest."""
    return [plus(x, times(0.5 * DT, v)) for x, v in zip(start, velocity)]


class RodRod(Replay):
    def crossed(self, k, nu, gravity, order):
        """Two rods cross with their middle elements, which move along x as beads of 2 M per node: a collision in one dimension."""
        weight = 2 * M * gravity

        def acceleration(x, v):
            overlap = 2 * R - (x[1] - x[0])
            pressing = -weight if order == "gravity first" else 0.0
            force = pressing + 0.5 * (k * overlap + nu * (v[0] - v[1])) if overlap > 0 else pressing if overlap >= -1e-5 else 0.0
            return [-force / (2 * M), gravity + force / (2 * M)]
        start = [0.0, 2 * R - 1e-4], [0.1, -0.3]
        states = verlet(*start, acceleration, max(STEPS))

        def motion(i, k):
            rods = [crossing(along=2 - i, x=start[0][i])]
            x, v, t = rods[0]["position"], rods[0]["velocity"], k * DT
            for n in range(4):
                inside = n in (1, 2)
                x[n][0] = states[k][0][i] if inside else start[0][i] + (0.5 * gravity * t * t if i else 0.0)
                v[n] = [states[k][1][i] if inside else gravity * t if i else 0.0, 0, 0]
            return {"position": x, "velocity": v}
        rods = [crossing(along=2 - i, x=start[0][i], speed=start[1][i], still=(0, 3)) for i in range(2)]
        loads = [{"system": 1, "kind": "gravity", "acc": [gravity, 0, 0]}, {"system": 0, "other": 1, "kind": "rod_rod_contact", "k": k, "nu": nu}]
        self.agrees(rods, motion, loads if order == "gravity first" else loads[::-1])
        return states

    def test_collision_of_equals_swaps_their_speeds(self):
        states = self.crossed(k=8e3, nu=0.0, gravity=0.0, order="gravity first")
        for (_, v) in states:
            self.assertAlmostEqual(sum(v), -0.2, delta=1e-14)
        self.assertAlmostEqual(states[-1][1][0], -0.3, delta=3e-3)

    def test_damped_collision(self):
        states = self.crossed(k=8e3, nu=8.0, gravity=0.0, order="gravity first")
        self.assertLess(states[-1][1][1] - states[-1][1][0], 0.9 * 0.4)

    def test_what_presses_rods_together_is_passed_on_where_it_is_there_already(self):
        first = self.crossed(k=8e3, nu=2.0, gravity=-3.0, order="gravity first")
        later = self.crossed(k=8e3, nu=2.0, gravity=-3.0, order="gravity last")
        self.assertGreater(abs(first[10][1][0] - later[10][1][0]), 1e-3)

    def test_end_elements(self):
        """Half of the spring's force on a node, moved by a third in the end elements: (2/3, 4/3) and (4/3, 2/3)."""
        k, overlap = 500.0, 0.002
        first, last = crossing(), crossing(along=1, x=2 * R - overlap)
        for x in first["position"]:
            x[2] += L  # its first element crosses the other's last
        for x in last["position"]:
            x[1] -= L
        push = 0.5 * k * overlap * DT
        speeds = [[-push * 2 / 3 / M, -push * 4 / 3 / (2 * M), 0, 0], [0, 0, push * 4 / 3 / (2 * M), push * 2 / 3 / M]]

        def motion(i, _):
            v = [[s, 0, 0] for s in speeds[i]]
            return {"velocity": v, "position": moved((first, last)[i]["position"], v)}
        self.agrees([first, last], motion, [{"system": 0, "other": 1, "kind": "rod_rod_contact", "k": k, "nu": 3.0}], steps=(1,))


class SelfContact(Replay):
    def test_hairpin(self):
        """Up, across, down: the third element touches the first, unless it is so thick that 1 + ceil(0.8 pi r/l) is 3 and not 2."""
        k, nu, gap, u = 500.0, 3.0, 0.015, 0.2
        bent = rod(3, stiff=False)
        bent["position"] = [[0, 0, 0], [0, 0, L], [gap, 0, L], [gap, 0, 0]]
        bent["velocity"] = [[u, 0, 0], [u, 0, 0], [-u, 0, 0], [-u, 0, 0]]
        load = {"system": 0, "kind": "rod_self_contact", "k": k, "nu": nu}
        for radius in (R, 0.39 * L):
            push = 0.5 * (k * (2 * radius - (gap - u * DT)) + nu * 2 * u) * DT
            v = [[u - push * 2 / 3 / M, 0, 0], [u - push * 4 / 3 / (2 * M), 0, 0], [-u + push * 4 / 3 / (2 * M), 0, 0], [-u + push * 2 / 3 / M, 0, 0]]
            x = [plus(p, times(0.5 * DT, plus(a, b))) for p, a, b in zip(bent["position"], bent["velocity"], v)]
            self.agrees([{**bent, "volume": [math.pi * radius ** 2 * L] * 3}], lambda *_: {"velocity": v, "position": x}, [load], steps=(1,))
        drifting = lambda _, n: {"position": [plus(p, times(n * DT, s)) for p, s in zip(bent["position"], bent["velocity"])]}
        self.agrees([{**bent, "volume": [math.pi * (0.41 * L) ** 2 * L] * 3}], drifting, [load], steps=(1, 10))


class Bodies(Replay):
    def test_free_bodies(self):
        g, torque, w = [0.3, 0.0, -9.0], 0.002, [1.0, -2.0, 0.5]
        bodies = [body("cylinder", velocity=(0.1, 0, 0), length=0.4), body(spin=w, inertia=(0.01, 0.01, 0.01))]

        def motion(i, k):
            t = k * DT
            if i == 1:
                return {"directors": [turn(turned(0), times(t, w))]}
            rate = torque / 0.003
            return {"position": [plus([0.1 * t, 0, 0], times(0.5 * t * t, g))], "velocity": [plus([0.1, 0, 0], times(t, g))],
                    "omega": [[0, 0, rate * t]], "directors": [turned(0.5 * rate * t * t)]}
        self.agrees(bodies, motion, [{"system": 0, "kind": "gravity", "acc": g}, {"system": 0, "kind": "uniform_torques", "torque": [0, 0, torque]}])

    def test_gyroscopic_term(self):
        inertia, w = [0.01, 0.01, 0.003], [3.0, -2.0, 40.0]
        momentum = [j * a for j, a in zip(inertia, w)]
        after = [a + DT * c / j for a, c, j in zip(w, cross(momentum, w), inertia)]
        half = turn(turned(0), times(0.5 * DT, w))
        self.agrees([body("cylinder", spin=w, inertia=inertia)], lambda *_: {"omega": [after], "directors": [turn(half, times(0.5 * DT, after))]}, steps=(1,))

    def test_constraints_and_dampers(self):
        c, v, w = 3.0, [0.2, 0, -0.1], 4.0
        kept = math.exp(-c * DT)
        decayed = travelled(lambda j: kept ** j)
        bodies = [body(velocity=v, spin=(0, 0, w)), body(velocity=v, spin=(0, 0, w))]

        def motion(i, k):
            if i == 0:
                return {"velocity": [[0, 0, 0]], "omega": [[0, 0, 0]]}
            return {"velocity": [times(kept ** k, v)], "position": [times(decayed(k), v)], "omega": [[0, 0, w * kept ** k]],
                    "directors": [turned(w * decayed(k))]}
        self.agrees(bodies, motion, constraints=[{"system": 0, "kind": "one_end_fixed"}],
                    dampers=[{"system": 1, "kind": "analytical_linear", "time_step": DT, "uniform_damping_constant": c}])

    def test_sphere_glances_off_a_rod(self):
        """The ball is opposite the node that follows the middle element, where no other element reaches. Momentum is kept, also along y."""
        k, nu, mu, cv = 2e3, 3.0, RUBBING["friction_coefficient"], RUBBING["velocity_damping_coefficient"]

        def acceleration(x, v):
            gap, slip = [x[2] - x[0], x[3] - x[1]], [v[2] - v[0], v[3] - v[1]]
            distance = math.hypot(*gap)
            overlap = R + BALL - distance
            if overlap <= 0:
                return [0.0] * 4
            d = times(1 / distance, gap)
            approach = dot(slip, d)
            normal = 0.5 * (k * overlap - nu * approach)
            slip = plus(slip, times(-approach, d))
            speed = math.hypot(*slip)
            f = plus(times(normal, d), times(-min(cv * speed, mu * abs(normal)) / speed, slip))
            return [-f[0] / (2 * M), -f[1] / (2 * M), 2 * f[0] / MASS, 2 * f[1] / MASS]
        start = [0, 0, R + BALL - 1e-3, 0], [0, 0, -0.25, 0.15]
        states = verlet(*start, acceleration, max(STEPS))
        for _, v in states:
            self.assertAlmostEqual(MASS * v[2] + 4 * M * v[0], MASS * -0.25, delta=1e-14)
            self.assertAlmostEqual(MASS * v[3] + 4 * M * v[1], MASS * 0.15, delta=1e-14)
        self.assertGreater(states[-1][1][2], states[-1][1][0])
        self.assertGreater(states[-1][1][1], 0.01)

        def motion(i, n):
            x, v = states[n]
            if i == 1:
                return {"position": [[x[2], x[3], 0.5 * L]], "velocity": [[v[2], v[3], 0]], "directors": [turn(turned(0), [0, 0, 2.0 * n * DT])]}
            at = [[0, 0], x[:2], x[:2], [0, 0]]
            return {"position": [[*xy, L * (j - 1.5)] for j, xy in enumerate(at)], "velocity": [[0, 0, 0], [*v[:2], 0], [*v[:2], 0], [0, 0, 0]]}
        ball = body(position=(start[0][2], 0, 0.5 * L), velocity=(*start[1][2:], 0), spin=(0, 0, 2.0), inertia=(0.01, 0.01, 0.01))
        self.agrees([crossing(), ball], motion, [{"system": 0, "other": 1, "kind": "rod_sphere_contact", "k": k, "nu": nu, **RUBBING}])

    def test_cylinder_is_turned(self):
        """The axis along y passes at a distance from its centre; friction small (viscous) and large (Coulomb) along the axis."""
        k, overlap, arm = 2e3, 0.001, 0.03
        lying = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]  # d3 along y
        for slip in (1e-3, 0.4):
            normal = 0.5 * k * overlap
            friction = min(RUBBING["velocity_damping_coefficient"] * slip, RUBBING["friction_coefficient"] * normal)
            force = [normal, -friction, 0]
            at = [R + BALL - overlap, arm, 0.5 * L]
            roll = body("cylinder", at, [0, slip, 0], directors=lying, length=0.3)
            at = plus(at, [0, 0.5 * DT * slip, 0])
            torque = times(2, cross([0, -at[1], 0], force))
            spin = [DT * dot(row, torque) / j for row, j in zip(lying, roll["mass_second_moment_of_inertia"])]
            v = plus([0, slip, 0], times(2 * DT / MASS, force))
            speed = times(-DT / (2 * M), force)
            bent = crossing()

            def motion(i, _):
                if i == 1:
                    return {"velocity": [v], "position": [plus(at, times(0.5 * DT, v))], "omega": [spin], "directors": [turn(lying, times(0.5 * DT, spin))]}
                speeds = [[0, 0, 0], speed, speed, [0, 0, 0]]
                return {"velocity": speeds, "position": moved(bent["position"], speeds)}
            self.agrees([bent, roll], motion, [{"system": 0, "other": 1, "kind": "rod_cylinder_contact", "k": k, "nu": 3.0, **RUBBING}], steps=(1,))


class OnPlane(Replay):
    """A rod along z on the plane x = 0, pressed by gravity: every element bears G = 2 M g. Forward is +z, rolling +y."""
    g = 9.0
    G = 2 * M * g
    plane = {"kind": "plane", "origin": [0, 0, 0], "normal": [1, 0, 0]}
    law = {"kind": "rod_plane_anisotropic_friction", "system": 0, "other": 1, "k": 200.0, "nu": 5.0, "surface_tol": 1e-4, "slip_velocity_tol": 1e-3,
           "kinetic_mu": [0.2, 0.3, 0.4], "static_mu": [0.5, 0.6, 0.7]}
    weight = {"system": 0, "kind": "gravity", "acc": [-g, 0, 0]}

    def lying(self, height=R, **rates):
        return {**rod(stiff=False, **rates), "position": shifted(N, [height, 0, 0])}

    def slides(self, start, motion, loads, steps=STEPS, **named):
        self.agrees([start, self.plane], lambda i, k: motion(k), loads, steps=steps, **named)

    def test_sliding_along(self):
        for speed, mu in ((1.5, 0.2), (-1.5, 0.3)):
            sign = math.copysign(1, speed)
            self.slides(self.lying(velocity=(0, 0, speed)), lambda k: {
                "velocity": [[0, 0, speed - sign * mu * self.g * k * DT]] * (N + 1),
                "position": shifted(N, [R, 0, speed * k * DT - sign * 0.5 * mu * self.g * (k * DT) ** 2])}, [self.weight, self.law])

    def test_sliding_across_turns_the_rod(self):
        speed, f = 1.5, 0.4 * self.G
        spin = R * f / J3

        def motion(k):
            t = k * DT
            return {"velocity": [[0, speed - f / (2 * M) * t, 0]] * (N + 1), "position": shifted(N, [R, speed * t - 0.5 * f / (2 * M) * t * t, 0]),
                    "omega": [[0, 0, spin * t]] * N, "directors": [turned(0.5 * spin * t * t)] * N}
        self.assertGreater(speed - 0.1 * (f / (2 * M) + R * spin), 0.01)  # not yet rolling
        self.slides(self.lying(velocity=(0, speed, 0)), motion, [self.weight, self.law])

    def test_half_way_between_sticking_and_slipping(self):
        """At 1.25 times the tolerated speed the kinetic force is a quarter; the static one stands against what pulls, here nothing."""
        speed = 1.25e-3
        after = [[0, 0, speed - DT * 0.25 * 0.2 * self.g + DT * min(0.25 * 0.2, 0.75 * 0.6) * self.g]] * (N + 1)
        x = [plus(p, times(0.5 * DT, plus([0, 0, speed], v))) for p, v in zip(shifted(N, [R, 0, 0]), after)]
        self.slides(self.lying(velocity=(0, 0, speed)), lambda _: {"velocity": after, "position": x}, [self.weight, self.law], steps=(1,))

    def test_rest_under_a_pull(self):
        """Static friction holds what it can, by direction; the ends' nodes have half of the force."""
        for pull, mu in ((0.4, 0.5), (-0.55, 0.6), (0.9, 0.5), (-0.9, 0.6)):
            force = {"system": 0, "kind": "uniform_forces", "force": [0, 0, pull * self.G * N]}
            left = math.copysign(max(0.0, abs(pull) - mu), pull) * self.g
            v = [[0, 0, left * DT]] * (N + 1)
            self.slides(self.lying(), lambda _: {"velocity": v, "position": moved(shifted(N, [R, 0, 0]), v)}, [self.weight, force, self.law], steps=(1,))

    def test_rolling_without_slip(self):
        """(2 T/r - F)/3 on an element that is turned by T and pulled by F across, up to the static limit; its couple is about the axis."""
        for torque, pull in ((0.002, 0.3), (-0.001, 0.3), (0.2, 0.0)):
            rolling = 2 * torque / R / 3 - pull / 3
            rolling = math.copysign(min(abs(rolling), 0.7 * self.G), rolling)
            v, w = [[0, (pull + rolling) / (2 * M) * DT, 0]] * (N + 1), (torque - R * rolling) / J3 * DT
            self.slides(self.lying(), lambda _: {"velocity": v, "position": moved(shifted(N, [R, 0, 0]), v), "omega": [[0, 0, w]] * N,
                                                 "directors": [turned(0.5 * DT * w)] * N},
                        [self.weight, {"system": 0, "kind": "uniform_torques", "torque": [0, 0, torque * N]},
                         {"system": 0, "kind": "uniform_forces", "force": [0, pull * N, 0]}, self.law], steps=(1,))

    def test_landing_without_friction(self):
        """Spring and damper of every element; the plane answers the weight only where it comes after it, and nothing beyond the tolerance."""
        k, nu = self.law["k"], self.law["nu"]
        for order in (1, -1):
            def acceleration(x, v):
                height = x[0] - R
                if height > 1e-4:
                    return [-self.g]
                return [(-k * min(height, 0.0) - nu * v[0]) / (2 * M) - (self.g if order < 0 else 0.0)]
            states = verlet([R + 5e-4], [-0.2], acceleration, max(STEPS))
            self.assertLess(min(x[0] for x, _ in states), R)
            self.slides(self.lying(height=R + 5e-4, velocity=(-0.2, 0, 0.7)),
                        lambda n: {"position": shifted(N, [states[n][0][0], 0, 0.7 * n * DT]), "velocity": [[states[n][1][0], 0, 0.7]] * (N + 1)},
                        [self.weight, {**self.law, "kind": "rod_plane"}][::order])

    def test_snake(self):
        """Muscles, weight, friction, damper: muscles about the axis turn elements, which roll and take their nodes along."""
        c, spline = 5.0, [1e-3, 4e-4, 2e-4, 7e-4]
        t, s = 0.5 * DT, [0.25, 0.5, 0.75, 1.0]
        muscle = [min(1, t / 0.02) * a * math.sin(2 * math.pi * t / 0.3 - 5 * b + 0.4) for a, b in zip(spline, s)]
        between = [0, *muscle[N - 2::-1], 0]  # at node k, between elements k-1 and k
        torque = [between[k] - between[k + 1] for k in range(N)]
        rolling = [2 * a / R / 3 for a in torque]
        self.assertLess(max(map(abs, rolling)), 0.7 * self.G)
        kept = math.exp(-c * DT)
        push = [0.5 * a for a in plus([0, *rolling], [*rolling, 0])]
        v = [[0, kept * DT * f / m, 0] for f, m in zip(push, self.lying()["mass"])]
        w = [kept * DT * (a - R * f) / J3 for a, f in zip(torque, rolling)]
        muscles = {"system": 0, "kind": "muscle_torques", "ramp_up_time": 0.02, "period": 0.3, "wave_number": 5.0, "phase_shift": 0.4, "s": s,
                   "spline_at_s": spline, "direction": [0, 0, 1]}
        self.slides(self.lying(), lambda _: {"velocity": v, "position": moved(shifted(N, [R, 0, 0]), v), "omega": [[0, 0, a] for a in w],
                                             "directors": [turned(0.5 * DT * a) for a in w]}, [self.weight, muscles, self.law], steps=(1,),
                    dampers=[{"system": 0, "kind": "analytical_linear", "time_step": DT, "uniform_damping_constant": c}])


class Entries(Replay):
    def test_entries_that_cannot_be_read(self):
        systems = [rod(stiff=False), body(position=(9, 9, 9)), body("cylinder", position=(9, 0, 9)), {**OnPlane.plane, "origin": [-9, 0, 0]}]
        good = {"rod_rod_contact": {"system": 0, "other": 0, "k": 1.0, "nu": 0.0}, "rod_self_contact": {"system": 0, "k": 1.0, "nu": 0.0},
                "rod_sphere_contact": {"system": 0, "other": 1, "k": 1.0, "nu": 0.0, **RUBBING},
                "rod_cylinder_contact": {"system": 0, "other": 2, "k": 1.0, "nu": 0.0, **RUBBING},
                "rod_plane_anisotropic_friction": {**OnPlane.law, "other": 3}}
        read = lambda entry, expect: self.replay(case(systems, lambda *_: {}, [entry], steps=(1,)), expect).stderr
        for kind, entry in good.items():
            entry = {**entry, "kind": kind}
            if kind != "rod_rod_contact":
                read({**entry, "remark": "texts are not read"}, 0)
            self.assertIn("unknown key 'stickiness'", read({**entry, "stickiness": 1.0}, 2))
            for key in set(entry) - {"kind"}:
                without = {k: v for k, v in entry.items() if k != key}
                if (kind, key) != ("rod_self_contact", "other"):
                    self.assertIn(f"'{key}'", read(without, 2))
        for entry, what in (({"kind": "rod_sphere_contact", **good["rod_sphere_contact"], "other": 2}, "not the body of a 'rod_sphere_contact'"),
                            ({"kind": "rod_sphere_contact", **good["rod_sphere_contact"], "other": 0}, "is not a body"),
                            ({"kind": "rod_self_contact", **good["rod_self_contact"], "system": 1}, "is not a rod"),
                            ({**OnPlane.law, "other": 1}, "is not a plane")):
            self.assertIn(what, read(entry, 2))
        for system, kind in ((1, "uniform_forces"), (3, "gravity")):
            self.assertIn(f"'{kind}'", read({"system": system, "kind": kind, "force": [1, 0, 0], "acc": [1, 0, 0]}, 7))

    def test_bodies_that_cannot_be_read(self):
        for key in ("radius", "mass", "mass_second_moment_of_inertia", "position", "directors", "length"):
            short = body("cylinder")
            content = case([short], lambda *_: {}, steps=(1,))
            content["systems"] = [{k: v for k, v in short.items() if k != key}]
            self.assertIn(f"'{key}'", self.replay(content, 2).stderr)
        spoilt = copy.deepcopy(case([body(velocity=(1, 0, 0))], lambda _, k: {"position": [[k * DT, 0, 0]]}))
        self.replay(spoilt, 0)
        spoilt["outputs"][1]["systems"][0]["omega"][0][1] += 1e-6
        self.assertIn("omega", self.replay(spoilt, 1).stdout)


if __name__ == "__main__":
    unittest.main()
