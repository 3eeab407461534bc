#!/usr/bin/env python3
"""reference_replay on tiny files whose motion is known in closed form, on spoilt ones and on malformed ones.

    replay_test.py REFERENCE_REPLAY
"""
import copy
import json
import math
import subprocess
import unittest

from cases import DT, J3, L, M, N, PROGRAM, STEPS, Replay, case, plus, ring, rising, rod, shifted, times, travelled, turned


def free_case():
    v, w = [0.3, -0.2, 0.1], 7.0
    energy = {"translational": 0.5 * 2 * N * M * (0.09 + 0.04 + 0.01), "rotational": 0.5 * N * J3 * w * w, "bending": 0.0, "shear": 0.0}
    return case([rod(velocity=v, spin=[0, 0, w])], lambda _, k: {
        "position": shifted(N, times(k * DT, v)), "directors": [turned(w * k * DT)] * N, "sigma": [[0, 0, 0]] * N, "dilatation": [1.0] * N,
        "kappa": [[0, 0, 0]] * (N - 1), "energy": energy})


class Motions(Replay):
    # Motions

    def test_free_flight_and_spin(self):
        for stepper in ("PositionVerlet", "PEFRL"):
            done = self.replay({**free_case(), "stepper": stepper}, 0)
            self.assertEqual(done.stdout.count("energy"), len(STEPS))

    def test_loads_shared_by_mass(self):
        g, f, torque = [1.0, 2.0, -9.0], [0.5, 0.0, -1.0], 0.003
        fall = lambda a: lambda k: {"position": shifted(N, times(0.5 * (k * DT) ** 2, a)), "velocity": [times(k * DT, a)] * (N + 1)}
        total = 2 * N * M
        spin = torque / (N * J3)
        motions = [fall(g), fall(times(1 / total, f)),
                   lambda k: {"omega": [[0, 0, spin * k * DT]] * N, "directors": [turned(0.5 * spin * (k * DT) ** 2)] * N}]
        self.agrees([rod(), rod(), rod()], lambda i, k: motions[i](k),
                    [{"system": 0, "kind": "gravity", "acc": g}, {"system": 1, "kind": "uniform_forces", "force": f},
                     {"system": 2, "kind": "uniform_torques", "torque": [0, 0, torque]}])

    def test_loads_at_the_ends(self):
        f, ramp, start, end = [0.4, -0.2, 0.0], 0.5, 0.03, 0.05
        normal, roll = [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]  # roll = normal x tangent
        speeds = [rising(lambda t: min(1, t / ramp)), rising(lambda t: math.cos(0.5 * math.pi * t)), rising(lambda t: math.sin(0.5 * math.pi * t))]

        def motion(i, k):
            def ends(first, last):
                x, v = shifted(N, [0, 0, 0]), [[0, 0, 0]] * (N + 1)
                v[0], v[N] = first(lambda s: s(k)), last(lambda s: s(k))
                x[0], x[N] = plus(x[0], first(lambda s: travelled(s)(k))), plus(x[N], last(lambda s: travelled(s)(k)))
                return {"position": x, "velocity": v}
            if i == 0:
                return ends(lambda s: [0, 0, 0], lambda s: times(s(speeds[0]) / M, f))
            if i == 1:  # before the ramp
                return ends(lambda s: times(-2 * start / M * s(lambda j: j * DT), normal), lambda s: times(-2 * end / M * s(lambda j: j * DT), normal))
            along = lambda mag: lambda s: times(mag / M, plus(times(s(speeds[1]), roll), times(s(speeds[2]), normal)))
            return ends(along(start), along(end))

        sinusoidal = {"kind": "endpoint_forces_sinusoidal", "start_force_mag": start, "end_force_mag": end, "normal_direction": normal,
                      "tangent_direction": [0, 0, 1]}
        self.agrees([rod(stiff=False) for _ in range(3)], motion,
                    [{"system": 0, "kind": "endpoint_forces", "start_force": [0, 0, 0], "end_force": f, "ramp_up_time": ramp},
                     {**sinusoidal, "system": 1, "ramp_up_time": 10.0}, {**sinusoidal, "system": 2, "ramp_up_time": 0.0}])

    def test_muscles(self):
        s, spline = [0.25, 0.5, 0.75, 1.0], [0.001, 0.004, 0.002, 0.007]
        table = {"ramp_up_time": 0.02, "period": 0.3, "wave_number": 5.0, "phase_shift": 0.4, "s": s, "spline_at_s": spline, "direction": [0, 0, 1]}
        muscle = lambda j, t: min(1, t / 0.02) * spline[j] * math.sin(2 * math.pi * t / 0.3 - 5 * s[j] + 0.4)
        torque = lambda k, t: muscle(N - 1 - k, t) if 1 <= k < N else 0.0  # between elements k-1 and k
        speed = [rising(lambda t, k=k: (torque(k, t) - torque(k + 1, t)) / J3) for k in range(N)]
        self.agrees([rod(stiff=False)], lambda _, n: {"omega": [[0, 0, w(n)] for w in speed], "directors": [turned(travelled(w)(n)) for w in speed]},
                    [{"system": 0, "kind": "muscle_torques", **table}])

    def test_one_step_in_a_magnetic_field(self):
        m, b = 0.02, 0.3  # moment along d1, field along y: the couple is along d3
        field = {"kind": "magnetic", "amplitude": [0, b, 0], "moment_material_frame": [[m, 0, 0]] * N, "ramp_interval": 0.01, "start_time": 0.0, "end_time": 9.0}
        t = 0.5 * DT
        factors = [t / 0.01, t / 0.01 * math.sin(3 * t + 1), 0.0, max(0.0, 1 - (t - 1e-4) / 0.01)]
        speeds = [m * b * f / J3 * DT for f in factors]
        self.agrees([rod(stiff=False) for _ in factors], lambda i, k: {"omega": [[0, 0, speeds[i]]] * N, "directors": [turned(0.5 * DT * speeds[i])] * N},
                    [{**field, "system": 0, "field": "constant"},
                     {**field, "system": 1, "field": "oscillating", "angular_frequency": [0, 3, 0], "phase": [0, 1, 0]},
                     {**field, "system": 2, "field": "constant", "start_time": 0.1},
                     {**field, "system": 3, "field": "constant", "start_time": -1.0, "end_time": 1e-4}], steps=(1,))

    def test_slender_body(self):
        mu, v = 0.7, 0.4
        rate = 4 * math.pi * mu / math.log(N * L / 0.01) * L / (2 * M)
        motions = [[1 - rate * DT, [v, 0, 0]], [1 - 0.5 * rate * DT, [0, 0, v]]]  # across and along

        def motion(i, k):
            q, start = motions[i]
            speed = lambda j: q ** j
            return {"velocity": [times(speed(k), start)] * (N + 1), "position": shifted(N, times(travelled(speed)(k), start))}
        self.agrees([rod(velocity=start) for _, start in motions], motion,
                    [{"system": i, "kind": "slender_body", "dynamic_viscosity": mu} for i in range(2)])

    def test_dampers(self):
        c, v, w = 3.0, [0.3, 0.0, -0.1], 4.0
        uniform, legacy = math.exp(-c * DT), math.exp(-c * DT * 2 * M / J3 * 1e-4)  # its m_e is 2 M in every element
        ct, cr = 0.4, 5e-5
        translational, rotational = [math.exp(-ct * DT / m) for m in [M] + [2 * M] * (N - 1) + [M]], math.exp(-cr * DT / J3)

        def motion(i, k):
            spinning = lambda q: {"omega": [[0, 0, w * q ** k]] * N, "directors": [turned(w * travelled(lambda j: q ** j)(k))] * N}
            moving = lambda qs: {"velocity": [times(q ** k, v) for q in qs],
                                 "position": [plus([0, 0, L * n], times(travelled(lambda j: q ** j)(k), v)) for n, q in enumerate(qs)]}
            if i == 0:
                return {**spinning(uniform), **moving([uniform] * (N + 1))}
            if i == 1:
                return {**spinning(legacy), **moving([math.exp(-c * DT * 1e-4)] * (N + 1))}
            if i == 2:
                return spinning(rotational)
            if i == 3:
                return moving(translational)
            # A filter of order 1 halves the middle node's deviation from the mean of its neighbours.
            return {"velocity": [[0, 0, 0], [0.2 * 0.5 ** k, 0, 0], [0, 0, 0]],
                    "position": plus_middle(shifted(2, [0, 0, 0]), 0.2 * travelled(lambda j: 0.5 ** j)(k))}

        def plus_middle(x, by):
            return [x[0], plus(x[1], [by, 0, 0]), x[2]]
        linear = {"kind": "analytical_linear", "time_step": DT}
        filtered = rod(2, stiff=False)
        filtered["velocity"] = [[0, 0, 0], [0.2, 0, 0], [0, 0, 0]]
        self.agrees([rod(velocity=v, spin=[0, 0, w]), rod(velocity=v, spin=[0, 0, w]), rod(spin=[0, 0, w]), rod(velocity=v, stiff=False), filtered], motion,
                    dampers=[{**linear, "system": 0, "uniform_damping_constant": c}, {**linear, "system": 1, "damping_constant": c * 1e-4},
                             {**linear, "system": 2, "translational_damping_constant": 0.0, "rotational_damping_constant": cr},
                             {**linear, "system": 3, "translational_damping_constant": ct, "rotational_damping_constant": 0.0},
                             {"system": 4, "kind": "laplace_filter", "filter_order": 1}])

    def test_dampers_act_in_order(self):
        """Drag on unlike masses and a filter do not commute. Ends e and middle m: drag scales them, the filter takes m to (e + m)/2."""
        ct, start = 40.0, [0.1, 0.5]
        of_end, of_middle = math.exp(-ct * DT / M), math.exp(-ct * DT / (2 * M))
        drag = {"kind": "analytical_linear", "time_step": DT, "translational_damping_constant": ct, "rotational_damping_constant": 0.0}
        laplace = {"kind": "laplace_filter", "filter_order": 1}

        def speeds(i, k):
            e, m = start
            for _ in range(k):
                e, m = (of_end * e, 0.5 * (of_end * e + of_middle * m)) if i == 0 else (of_end * e, of_middle * 0.5 * (e + m))
            return e, m

        def motion(i, k):
            e, m = speeds(i, k)
            gone = [travelled(lambda j: speeds(i, j)[which])(k) for which in (0, 1)]
            return {"velocity": [[e, 0, 0], [m, 0, 0], [e, 0, 0]], "position": [[gone[0], 0, 0], [gone[1], 0, L], [gone[0], 0, 2 * L]]}
        systems = [rod(2, stiff=False) for _ in range(2)]
        for system in systems:
            system["velocity"] = [[start[0], 0, 0], [start[1], 0, 0], [start[0], 0, 0]]
        self.agrees(systems, motion, dampers=[{**drag, "system": 0}, {**laplace, "system": 1}, {**laplace, "system": 0}, {**drag, "system": 1}])

    def test_constraints(self):
        g, w, slack, time, turns = [1.0, -2.0, 0.5], 5.0, 0.02, 0.05, 0.3
        damped = math.exp(-2.0 * DT)  # dampers act on what constraints leave
        load = [{"system": i, "kind": "gravity", "acc": g} for i in range(3)]
        systems = [rod(stiff=False, spin=[0, 0, w]) for _ in range(2)] + [rod(stiff=False), rod(stiff=False)]
        systems[2]["omega"] = [[0, 0, 0], [0, 0, 0], [0, 0, w], [0, 0, 0]]  # the others change length, and with it their rate

        def motion(i, k):
            t = k * DT
            x, v = shifted(N, times(0.5 * t * t, g)), [times(t, g)] * (N + 1)
            q, omega = [turned(w * t)] * N, [[0, 0, w]] * N
            if i < 2:
                held, element = ((0, 0), (N, N - 1))[i]
                x[held], v[held], q[element], omega[element] = [0, 0, L * held], [0, 0, 0], turned(0), [0, 0, 0]
            if i == 2:  # y is free at node 1; element 2 turned for half a step before its rate was taken
                x[1], v[1] = [0, 0.5 * t * t * g[1], L], [0, t * g[1], 0]
                q, omega = [turned(0), turned(0), turned(0.5 * w * DT), turned(0)], [[0, 0, 0]] * N
            if i == 3:
                moving = t < time
                v, omega, q = [[0, 0, 0]] * (N + 1), [[0, 0, 0]] * N, [turned(0)] * N
                x = shifted(N, [0, 0, 0])
                speed, rate = damped * slack / (2 * time), damped * turns * math.pi / time
                closer = speed * (t - 0.5 * DT) if moving else 0.5 * slack
                angle = rate * (t - 0.5 * DT) if moving else turns * math.pi
                x[0], x[N] = [0, 0, closer], [0, 0, N * L - closer]
                q[0], q[N - 1] = turned(angle), turned(-angle)
                if moving:
                    v[0], v[N] = [0, 0, speed], [0, 0, -speed]
                    omega[0], omega[N - 1] = [0, 0, rate], [0, 0, -rate]
            return {"position": x, "velocity": v, "directors": q, "omega": omega}
        self.agrees(systems, motion, load,
                    [{"system": 0, "kind": "one_end_fixed"}, {"system": 1, "kind": "fixed", "position_index": [-1], "director_index": [-1]},
                     {"system": 2, "kind": "general", "position_index": [1], "director_index": [2], "translation_fixed": [1, 0, 1], "rotation_fixed_lab": [0, 0, 1]},
                     {"system": 3, "kind": "helical_buckling", "twisting_time": time, "slack": slack, "number_of_rotations": turns}],
                    [{"system": 3, "kind": "analytical_linear", "time_step": DT, "uniform_damping_constant": 2.0}])

    def test_ring(self):
        g = [1.0, 0.0, -3.0]
        start = ring()["position"]
        angle = 2 * math.pi / 6
        loose = {**ring(), "shear_matrix": [[0, 0, 0]] * 6, "bend_matrix": [[0, 0, 0]] * 6}

        def motion(i, k):
            x, v = [plus(x, times(0.5 * (k * DT) ** 2, g)) for x in start], [times(k * DT, g)] * 6
            if i == 1:  # its last node is held
                x[5], v[5] = start[5], [0, 0, 0]
            return {"position": x, "velocity": v, "kappa": [[angle / L, 0, 0]] * 6}
        self.agrees([ring(), loose], motion, [{"system": i, "kind": "gravity", "acc": g} for i in range(2)],
                    [{"system": 1, "kind": "fixed", "position_index": [-1], "director_index": []}])

    def test_dampers_on_a_ring(self):
        """Loose rings. The legacy rule gives element k the mass of node k; filters take the list of rates with its last item put before
        it and its first after it, and spare the ends of that list."""
        c, ct, w, n = 3.0, 0.4, 4.0, 6
        loose = lambda: {**ring(), "shear_matrix": [[0, 0, 0]] * n, "bend_matrix": [[0, 0, 0]] * n}
        rates = [[0.1 * (-1) ** i, 0.02 * i * i, 0.0] for i in range(n)]

        def filtered(v, order):
            f = [v[-1], *v, v[0]]
            for _ in range(order):
                f = [[0, 0, 0], *(times(0.25, plus(f[i], f[i], times(-1, f[i - 1]), times(-1, f[i + 1]))) for i in range(1, n + 1)), [0, 0, 0]]
            return [plus(a, times(-1, b)) for a, b in zip(v, f[1:])]

        def filter_motion(order):
            v = [rates]
            for _ in range(max(STEPS)):
                v.append(filtered(v[-1], order))
            start = ring()["position"]
            # Angular velocities are filtered alike; frames are left out of it by spins of zero.
            return lambda k: {"velocity": v[k], "position": [plus(x, [travelled(lambda j: v[j][i][a])(k) for a in range(3)]) for i, x in enumerate(start)]}
        drift = lambda q, v: lambda k: {"velocity": [times(q ** k, v)] * n, "position": [plus(x, times(travelled(lambda j: q ** j)(k), v)) for x in ring()["position"]]}
        v = [0.3, 0.0, -0.1]
        systems = [loose() for _ in range(5)]
        for system in systems[:2]:
            system["velocity"] = [v] * n
        for system in systems[3:]:
            system["velocity"] = rates
        systems[2].update(mass=[M * (1 + k) for k in range(n)], omega=[[0, 0, w]] * n)
        spin = [math.exp(-c * 1e-4 * DT * M * (1 + k) / J3) for k in range(n)]

        def spinning(k):
            turns = [w * travelled(lambda j: q ** j)(k) for q in spin]
            rolled = [[plus(times(math.cos(a), d1), times(math.sin(a), d2)), plus(times(math.cos(a), d2), times(-math.sin(a), d1)), d3]
                      for a, (d1, d2, d3) in zip(turns, ring()["directors"])]
            return {"omega": [[0, 0, w * q ** k] for q in spin], "directors": rolled}
        motions = [drift(math.exp(-c * DT), v), drift(math.exp(-ct * DT / (2 * M)), v), spinning, filter_motion(1), filter_motion(3)]
        linear = {"kind": "analytical_linear", "time_step": DT}
        self.agrees(systems, lambda i, k: motions[i](k),
                    dampers=[{**linear, "system": 0, "uniform_damping_constant": c},
                             {**linear, "system": 1, "translational_damping_constant": ct, "rotational_damping_constant": 0.0},
                             {**linear, "system": 2, "damping_constant": c * 1e-4},
                             {"system": 3, "kind": "laplace_filter", "filter_order": 1}, {"system": 4, "kind": "laplace_filter", "filter_order": 3}])

    def test_closing_element_of_a_damped_ring(self):
        """Node n is a copy of node 0 that keeps the velocity before damping until the next kick. A loose ring that grows evenly: the spin about
        d3 follows w' = w e'/e with the dilatation rate, which differs in the closing element alone."""
        c, w, speed, n = 30.0, 4.0, 0.5, 6
        q, start = math.exp(-c * DT), ring()["position"]
        outward = [times(1 / L, x) for x in start]
        grown = {**ring(), "shear_matrix": [[0, 0, 0]] * n, "bend_matrix": [[0, 0, 0]] * n, "velocity": [times(speed, r) for r in outward], "omega": [[0, 0, w]] * n}
        dot = lambda a, b: sum(x * y for x, y in zip(a, b))
        spins, radius, v, copy_of_first = [[w] * n], L, speed, speed
        for _ in range(max(STEPS)):
            radius += 0.5 * DT * v
            x = [times(radius, r) for r in outward]
            now = []
            for k in range(n):
                dx = plus(x[(k + 1) % n], times(-1, x[k]))
                dv = plus(times(copy_of_first if k == n - 1 else v, outward[(k + 1) % n]), times(-v, outward[k]))
                now.append((spins[-1][k] * (1 + DT * dot(dx, dv) / dot(dx, dx))) * q)
            spins.append(now)
            copy_of_first, v = v, q * v
            radius += 0.5 * DT * v
        self.assertGreater(abs(spins[-1][n - 1] / spins[-1][0] - 1), 1e-3)

        def motion(_, k):
            turns = [travelled(lambda j: spins[j][e])(k) for e in range(n)]
            rolled = [[plus(times(math.cos(a), d1), times(math.sin(a), d2)), plus(times(math.cos(a), d2), times(-math.sin(a), d1)), d3]
                      for a, (d1, d2, d3) in zip(turns, ring()["directors"])]
            r = L + travelled(lambda j: speed * q ** j)(k)
            return {"omega": [[0, 0, s] for s in spins[k]], "directors": rolled, "velocity": [times(speed * q ** k, o) for o in outward], "position": [times(r, o) for o in outward]}
        self.agrees([grown], motion, dampers=[{"system": 0, "kind": "analytical_linear", "time_step": DT, "uniform_damping_constant": c}])

    def test_ends_of_a_rings_lists(self):
        """What acts on the ends of an open rod acts on the first and last node of a ring's lists."""
        n, slack, time = 6, 0.02, 0.05
        loose = {**ring(), "shear_matrix": [[0, 0, 0]] * n, "bend_matrix": [[0, 0, 0]] * n}
        start = ring()["position"]
        towards = plus(start[n - 1], times(-1, start[0]))
        towards = times(1 / math.sqrt(sum(c * c for c in towards)), towards)
        turning = {"kind": "endpoint_forces_sinusoidal", "start_force_mag": 0.03, "end_force_mag": 0.05, "normal_direction": [0, 1, 0], "tangent_direction": [0, 0, 1], "ramp_up_time": 10.0}

        def motion(i, k):
            t, x, v = k * DT, list(start), [[0, 0, 0]] * n
            for at, mag, sign in ((0, 0.03, 1), (n - 1, 0.05, -1)):
                if i == 0:
                    v[at], x[at] = [0, -mag / M * t, 0], plus(x[at], [0, -0.5 * mag / M * t * t, 0])
                else:
                    v[at] = times(sign * slack / (2 * time), towards) if t < time else [0, 0, 0]
                    x[at] = plus(x[at], times(sign * (slack / (2 * time) * (t - 0.5 * DT) if t < time else 0.5 * slack), towards))
            return {"position": x, "velocity": v}
        self.agrees([loose, loose], motion, [{**turning, "system": 0}],
                    [{"system": 1, "kind": "helical_buckling", "twisting_time": time, "slack": slack, "number_of_rotations": 0.0}])

    def test_stretched_ring_pulls_itself_together(self):
        """One step: every node is drawn inwards by 2 T sin(pi/n), T = S3 (e - 1)/e."""
        n, e, stretched = 6, 1.05, ring()
        stretched.update(rest_lengths=[L / e] * n, rest_voronoi_lengths=[L / e] * n)
        speed = -DT * 2 * 900 * (e - 1) / e * math.sin(math.pi / n) / (2 * M)
        outwards = [times(1 / L, x) for x in stretched["position"]]  # the radius of a hexagon is its side
        self.agrees([stretched], lambda _, k: {"velocity": [times(speed, r) for r in outwards],
                                               "position": [times(L + 0.5 * DT * speed, r) for r in outwards]}, steps=(1,))

    def test_values_are_held_when_forces_are_taken(self):
        """A held node that starts with a velocity is back in place after the first half step, so the rod feels no strain."""
        moving = rod(1)
        moving["velocity"] = [[0, 0, 3.0], [0, 0, 0]]
        self.agrees([moving], lambda _, k: {"velocity": [[0, 0, 0]] * 2}, constraints=[{"system": 0, "kind": "one_end_fixed"}])

    def test_values_switch_between_kick_and_end_of_step(self):
        slack, time = 0.02, 9.75 * DT
        x, v = shifted(N, [0, 0, 0]), [[0, 0, 0]] * (N + 1)
        x[0], x[N], v[0], v[N] = [0, 0, slack / 2], [0, 0, N * L - slack / 2], [0, 0, slack / (2 * time)], [0, 0, -slack / (2 * time)]
        self.agrees([rod(stiff=False)], lambda _, k: {"position": x, "velocity": v},
                    constraints=[{"system": 0, "kind": "helical_buckling", "twisting_time": time, "slack": slack, "number_of_rotations": 0.0}], steps=(10,))

    def test_loads_pile_up_over_the_stages_of_a_step(self):
        """Published codes clear external loads once a step: with PEFRL gravity acts 1, 2, 3 and 4 times."""
        xi, lam, chi, g = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849, -9.0
        kicks, drifts = [0.5 - lam, lam, lam, 0.5 - lam], [xi, chi, 1 - 2 * (xi + chi), chi, xi]
        total = sum(kick * (j + 1) for j, kick in enumerate(kicks))
        carried = sum(kick * (j + 1) * sum(drifts[j + 1:]) for j, kick in enumerate(kicks))
        self.agrees([rod()], lambda _, k: {"velocity": [[0, 0, total * g * k * DT]] * (N + 1),
                                           "position": shifted(N, [0, 0, g * DT * DT * (total * k * (k - 1) / 2 + carried * k)])},
                    [{"system": 0, "kind": "gravity", "acc": [0, 0, g]}], stepper="PEFRL")

    def test_curves(self):
        """A straight curve whose frame turns evenly; its auxiliary line is a helix far thinner than a segment is long."""
        n, turn = 12, 0.05
        curve = {"position": [[0, 0, 0.1 * i] for i in range(n + 1)], "radius": [1e-6] * n,
                 "normal": [turned(2 * math.pi * turn * i)[0] for i in range(n)],
                 "twist": turn * (n - 1), "local_twist": [turn] * (n - 1), "writhe": {"next_tangent": 0.0, "end_to_end": 0.0}}
        done = self.replay({"case": "curves", "curves": [curve, curve]}, 0)
        self.assertIn("8 of 8", done.stdout)
        spoilt = {**curve, "twist": turn * (n - 1) + 1e-9}
        self.assertIn("curve 1 twist", self.replay({"curves": [curve, spoilt]}, 1).stdout)
        values = {"twist": turn * (n - 1)}
        bare = {k: curve[k] for k in ("position", "normal")}
        self.replay({"inputs": [bare, bare], "outputs": [values, values]}, 0)
        self.replay({"inputs": [bare, bare], "outputs": [values, {"twist": 0.0}]}, 1)
        self.replay({"curves": [bare]}, 2)
        self.replay({"curves": [{k: curve[k] for k in ("position", "twist")}]}, 2)

    def test_closed_curves(self):
        """A crooked ribbon over a circle. Pushed along z its edge never crosses it, so a frame that turns k times more than that one has link k;
        twist is what the writhe (by Gauss's integral over pairs of segments) leaves of it."""
        n, k = 60, 3
        at = lambda a: [math.cos(a), math.sin(a), 0.8 * math.sin(2 * a) + 0.6 * math.cos(3 * a + 0.5)]
        x = [at(2 * math.pi * i / n) for i in range(n)]
        cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        dot = lambda a, b: sum(p * q for p, q in zip(a, b))
        unit = lambda a: times(1 / math.sqrt(dot(a, a)), a)
        to = lambda a, b: plus(b, times(-1, a))
        normal = []
        for i in range(n):
            t = unit(to(x[i], x[(i + 1) % n]))
            up = unit(plus([0, 0, 1], times(-t[2], t)))
            a = 2 * math.pi * k * i / n
            normal.append(plus(times(math.cos(a), up), times(math.sin(a), cross(t, up))))

        def of_pair(i, j):
            a, b, c, d = x[i], x[(i + 1) % n], x[j], x[(j + 1) % n]
            r13, r14, r23, r24 = to(a, c), to(a, d), to(b, c), to(b, d)
            faces = [unit(cross(*pair)) for pair in ((r13, r14), (r14, r24), (r24, r23), (r23, r13))]
            flat = [cross(faces[m], faces[(m + 1) % 4]) for m in range(4)]  # arcsines by atan2: near 1 they lose half of their digits
            area = sum(0.5 * math.pi - math.atan2(math.sqrt(dot(f, f)), dot(faces[m], faces[(m + 1) % 4])) for m, f in enumerate(flat))
            return area * math.copysign(1, dot(cross(to(c, d), to(a, b)), r13)) / (2 * math.pi)
        writhe = sum(of_pair(i, j) for i in range(n) for j in range(i + 2, n if i else n - 1))
        self.assertGreater(abs(writhe), 0.01)
        curve = {"center_line": x, "normal_collection": normal, "radius": 1e-3, "lk": k, "total_writhe": writhe, "total_twist": k - writhe}
        self.assertIn("3 of 3", self.replay({"curves": [curve]}, 0).stdout)
        again = {**curve, "closed": True, "center_line": [*x, x[0]]}
        self.assertIn("3 of 3", self.replay({"curves": [again]}, 0).stdout)
        self.replay({"curves": [{**again, "lk": k + 1}]}, 1)
        self.assertIn("not its first", self.replay({"curves": [{**again, "center_line": [*x, [0, 0, 0]]}]}, 2).stderr)

    # Files that do not agree

    def test_spoilt_values_differ(self):
        for step, field, spoil in ((1, "position", lambda s: s["position"][2]), (10, "velocity", lambda s: s["velocity"][0]),
                                   (100, "directors", lambda s: s["directors"][1][0]), (100, "omega", lambda s: s["omega"][3]),
                                   (10, "sigma", lambda s: s["sigma"][0]), (1, "kappa", lambda s: s["kappa"][1]),
                                   (100, "dilatation", lambda s: s["dilatation"])):
            content = free_case()
            content["outputs"] = json.loads(json.dumps(content["outputs"]))
            output = content["outputs"][STEPS.index(step)]["systems"][0]
            spoil(output)[1] += 1e-6
            differing = [line.split()[:2] for line in self.replay(content, 1).stdout.splitlines() if "DIFFERS" in line]
            self.assertEqual(differing, [[str(step), field]])
        content = free_case()
        content["outputs"][2]["systems"][0]["energy"] = {**content["outputs"][2]["systems"][0]["energy"], "rotational": 0.1}
        self.replay(content, 1)

    def test_tolerance_follows_the_sensitivity(self):
        content = json.loads(json.dumps(free_case()))
        content["outputs"][2]["systems"][0]["velocity"][2][1] += 0.3 * 5e-9
        self.replay(content, 1)
        content["roundoff_sensitivity"][2]["velocity"] = 6e-11
        self.replay(content, 0)
        content["roundoff_sensitivity"][2]["velocity"] = 4e-11
        self.replay(content, 1)
        del content["roundoff_sensitivity"]
        self.replay(content, 1)

    # Files that cannot be replayed

    def test_what_is_not_built_is_named(self):
        def system(kind):
            def change(content):
                content["systems"].append({"kind": kind})
            return change

        def entry(key, **values):
            def change(content):
                content[key].append({"system": 0, **values})
            return change
        for name, change in (("cone", system("cone")), ("body_plane_contact", entry("forces_in_order", kind="body_plane_contact", k=1.0, nu=0.0)),
                             ("ball_joint", entry("forces_in_order", kind="ball_joint", other=0, index=0, other_index=0)),
                             ("spring", entry("constraints_in_order", kind="spring")), ("rayleigh", entry("dampers_in_order", kind="rayleigh")),
                             ("Euler", lambda content: content.update(stepper="Euler"))):
            content = copy.deepcopy(free_case())
            change(content)
            done = self.replay(content, 7)
            self.assertIn(f"'{name}'", done.stderr)
        content = case([ring()], lambda _, k: {}, [{"system": 0, "kind": "slender_body", "dynamic_viscosity": 1.0}])
        self.assertIn("on a ring", self.replay(content, 7).stderr)

    def test_malformed_files(self):
        whole = json.dumps(free_case())
        self.assertIn("parse error", self.replay(whole[:len(whole) // 2], 2).stderr)
        self.replay("", 2)
        self.replay("[1, 2]", 2)
        self.replay("{}", 2)

        def spoilt(*path, value=None):
            content = json.loads(whole)
            at = content
            for key in path[:-1]:
                at = at[key]
            if value is None:
                del at[path[-1]]
            else:
                at[path[-1]] = value
            return content
        load = {"kind": "gravity", "acc": [0, 0, -1]}
        for content, named in (
                (spoilt("dt"), "dt"), (spoilt("dt", value=-1.0), "dt"), (spoilt("dt", value="soon"), "dt"), (spoilt("stepper"), "stepper"),
                (spoilt("systems", value=3), "systems"), (spoilt("systems", 0, "kind"), "kind"), (spoilt("systems", 0, "mass"), "mass"),
                (spoilt("systems", 0, "mass", 1, value=0.0), "mass[1]"), (spoilt("systems", 0, "mass", 1), "mass"),
                (spoilt("systems", 0, "rest_lengths", value=[]), "too few"), (spoilt("systems", 0, "position", 2, value=[0, 0]), "position[2]"),
                (spoilt("systems", 0, "directors", 0, value=[[1, 0, 0]]), "directors[0]"), (spoilt("systems", 0, "omega", 0, 1, value="x"), "omega[0]"),
                (spoilt("forces_in_order"), "forces_in_order"), (spoilt("forces_in_order", value=[{"kind": "gravity"}]), "system"),
                (spoilt("forces_in_order", value=[{**load, "system": 1}]), "system"), (spoilt("forces_in_order", value=[{"system": 0, "kind": "gravity"}]), "acc"),
                (spoilt("constraints_in_order", value=[{"system": 0, "kind": "fixed", "position_index": [N + 1]}]), "position_index[0]"),
                (spoilt("dampers_in_order", value=[{"system": 0, "kind": "analytical_linear", "time_step": DT}]), "damping_constant"),
                (spoilt("outputs"), "outputs"), (spoilt("outputs", 1, "step", value=1), "outputs[1].step"), (spoilt("outputs", 0, "step", value=0), "outputs[0].step"),
                (spoilt("outputs", 0, "systems", value=[]), "outputs[0].systems"), (spoilt("outputs", 0, "systems", 0, "omega"), "omega"),
                (spoilt("outputs", 0, "systems", 0, "velocity", 1), "velocity"), (spoilt("outputs", value=[]), "outputs"), (spoilt("scale"), "scale")):
            self.assertIn(named, self.replay(content, 2).stderr)

    def test_command_line(self):
        for arguments, code in (([], 2), (["a.json", "b.json"], 2), ([str(self.file)], 2), (["--help"], 0)):
            self.assertEqual(subprocess.run([PROGRAM, *arguments], capture_output=True).returncode, code, arguments)


if __name__ == "__main__":
    unittest.main()
