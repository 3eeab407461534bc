"""Scenes from PyElastica's simulators, without PyElastica: objects with its attributes, made of recorded trajectories (SKEIN_REFERENCE_DIR), which Skein
then follows."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

from package import ROOT, SKEIN, skein

from skein import elastica

REFERENCE = pathlib.Path(os.environ.get("SKEIN_REFERENCE_DIR") or ROOT.parent / "shared/reference")


class Rod:
    ring_rod_flag = False

    def __init__(self, system):
        self.show(system)
        self.rest_lengths, self.volume, self.mass = (np.array(system[key]) for key in ("rest_lengths", "volume", "mass"))
        diagonal = lambda rows: np.stack([np.diag(row) for row in rows], axis=-1)  # noqa: E731
        self.shear_matrix, self.bend_matrix = diagonal(system["shear_matrix"]), diagonal(system["bend_matrix"])
        self.rest_kappa, self.rest_sigma = np.array(system["rest_kappa"]).T, np.array(system["rest_sigma"]).T

    def show(self, state):
        self.position_collection, self.velocity_collection, self.omega_collection = (np.array(state[key]).T for key in ("position", "velocity", "omega"))
        self.director_collection = np.moveaxis(np.array(state["directors"]), 0, 2)


def named(name, *parameters):
    """A class of PyElastica's name and parameters."""
    scope = {}
    exec(f"class {name}:\n    def __init__(self, {', '.join((*parameters, '**kwargs'))}): pass\n", scope)
    return scope[name]


CLASSES = {"endpoint_forces": ("_forcing_cls", named("EndpointForces", "start_force", "end_force", "ramp_up_time=0.0")),
           "gravity": ("_forcing_cls", named("GravityForces", "acc_gravity=None")),
           "one_end_fixed": ("_bc_cls", named("OneEndFixedBC", "fixed_position", "fixed_directors")),
           "analytical_linear": ("_damper_cls", named("AnalyticalLinearDamper", "time_step=None")),
           "laplace_filter": ("_damper_cls", named("LaplaceDissipationFilter", "filter_order"))}


FIELD, SINE = type("ConstantMagneticField", (), {}), type("SineMagneticField", (), {})
CLASSES["magnetic"] = ("_forcing_cls", named("MagneticForces", "external_magnetic_field", "magnetization_density", "magnetization_direction"))


class Feature:
    def __init__(self, entry, by_place=()):
        attribute, cls = CLASSES[entry["kind"]]
        setattr(self, attribute, cls)
        self._sys_idx = entry["system"]
        self._args = tuple(entry[key] for key in by_place)
        self._kwargs = {key: value for key, value in entry.items() if key not in ("kind", "system", *by_place)}
        if attribute == "_bc_cls":
            self.constrained_position_idx, self.constrained_director_idx = (0,), (0,)


class Simulator(list):
    def __init__(self, case, systems):
        super().__init__(Rod(case["systems"][number]) for number in systems)
        renamed = {number: place for place, number in enumerate(systems)}
        chosen = lambda key: [dict(entry, system=renamed[entry["system"]]) for entry in case[key] if entry["system"] in renamed]  # noqa: E731
        self._ext_forces_torques = [Feature(entry, ("start_force", "end_force") if entry["kind"] == "endpoint_forces" else ()) for entry in chosen("forces_in_order")]
        self._constraints_list = [Feature(entry) for entry in chosen("constraints_in_order")]
        self._damping_list = [Feature(entry) for entry in chosen("dampers_in_order")]
        self._outputs = {output["step"]: [output["systems"][number] for number in systems] for output in case["outputs"]}

    def at(self, step):
        for rod, state in zip(self, self._outputs[step]):
            rod.show(state)


N, DT, RADIUS, LENGTH, YOUNG, SHEAR, DENSITY = 10, 2e-4, 0.05, 1.0, 1e6, 1e6 / 3, 1000.0


def straight():
    """A rod along z in the format of reference files, with PyElastica's constants of a straight rod."""
    l, area = LENGTH / N, np.pi * RADIUS**2
    inertia = area**2 / (4 * np.pi)
    rows = lambda row, count: [list(row)] * count  # noqa: E731
    return {"kind": "rod", "ring": False, "n_elems": N, "position": [[0, 0, l * k] for k in range(N + 1)], "velocity": rows([0, 0, 0], N + 1), "omega": rows([0, 0, 0], N),
            "directors": [np.eye(3).tolist()] * N, "mass": [DENSITY * area * l * (0.5 if k in (0, N) else 1) for k in range(N + 1)],
            "mass_second_moment_of_inertia": rows(DENSITY * l * inertia * np.array([1, 1, 2]), N), "rest_lengths": [l] * N, "rest_voronoi_lengths": [l] * (N - 1), "volume": [area * l] * N,
            "shear_matrix": rows([27 / 28 * SHEAR * area] * 2 + [YOUNG * area], N), "bend_matrix": rows([YOUNG * inertia, YOUNG * inertia, 2 * SHEAR * inertia], N - 1),
            "rest_sigma": rows([0, 0, 0], N), "rest_kappa": rows([0, 0, 0], N - 1)}


# Loads as PyElastica's classes take them, and as files state them.
WAVE = {"period": 0.4, "wave_number": 3.0, "phase_shift": 0.2, "ramp_up_time": 0.1}
TURN = {"start_force_mag": 0.3, "end_force_mag": 1.5, "ramp_up_time": 0.05}
LOADS = {"GravityForces": ({"acc_gravity": [0.3, -9.8, 1.0]}, {"kind": "gravity", "acc": [0.3, -9.8, 1.0]}),
         "EndpointForces": ({"start_force": [0.5, 0, 0], "end_force": [3.0, -1.0, 2.0], "ramp_up_time": 0.05},
                            {"kind": "endpoint_forces", "start_force": [0.5, 0, 0], "end_force": [3.0, -1.0, 2.0], "ramp_up_time": 0.05}),
         "UniformForces": ({"force": 2.0, "direction": [1.0, 2.0, -0.5]}, {"kind": "uniform_forces", "force": [2.0, 4.0, -1.0]}),
         "UniformTorques": ({"torque": 0.1, "direction": [1.0, 2.0, -0.5]}, {"kind": "uniform_torques", "torque": [0.1, 0.2, -0.05]}),
         "EndpointForcesSinusoidal": ({**TURN, "normal_direction": [0, 1, 0], "tangent_direction": [0, 0, 1]},
                                      {"kind": "endpoint_forces_sinusoidal", **TURN, "normal_direction": [0, 1, 0], "tangent_direction": [0, 0, 1]}),
         "SlenderBodyTheory": ({"dynamic_viscosity": 0.5}, {"kind": "slender_body", "dynamic_viscosity": 0.5}),
         "MuscleTorques": ({"base_length": LENGTH, "b_coeff": [], **WAVE, "direction": [0, 1, 0], "rest_lengths": None, "with_spline": False},
                           {"kind": "muscle_torques", "s": [(k + 1) / N for k in range(N)], "spline_at_s": [1.0] * N, **WAVE, "direction": [0, 1, 0]})}


REPLAY = pathlib.Path(SKEIN).with_name("reference_replay")


@unittest.skipUnless(REPLAY.exists(), "reference_replay is not built")
class Replayed(unittest.TestCase):
    def test_every_load_is_what_reference_replay_takes_it_for(self):
        """Trajectories of the converted scene, replayed from the loads as files of recorded trajectories state them. Angular velocities part by the 1e-14 that the
        published drift adds to its angles (apps/reference_replay)."""
        for name, (given, stated) in LOADS.items():
            for clamped in (True, False):
                with self.subTest(load=name, clamped=clamped):
                    forces = [dict(stated, system=0)] + ([{"kind": "gravity", "acc": [1.0, 0, 0], "system": 0}] if name == "SlenderBodyTheory" else [])
                    case = self.case(forces, [{"system": 0, "kind": "one_end_fixed"}] if clamped else [])
                    simulator = Simulator(dict(case, forces_in_order=[]), (0,))
                    for cls, keys in ((name, given), *([("GravityForces", {"acc_gravity": [1.0, 0, 0]})] if name == "SlenderBodyTheory" else [])):
                        feature = Feature.__new__(Feature)
                        feature._forcing_cls, feature._sys_idx, feature._args, feature._kwargs = named(cls, *keys), 0, (), keys
                        simulator._ext_forces_torques.append(feature)
                    self.assert_replayed(simulator, case)

    def test_every_constraint_too(self):
        general = {"translational_constraint_selector": [True, False, True], "rotational_constraint_selector": [True, True, False]}
        cases = {"FixedConstraint": ({}, {"kind": "fixed"}), "GeneralConstraint": (general, {"kind": "general", "translation_fixed": [1, 0, 1], "rotation_fixed_lab": [1, 1, 0]})}
        for name, (given, stated) in cases.items():
            for nodes, elements in (((0,), (0,)), ((0, -2), (0, -1)), ((0, 4), (0, 4)), ((0, 6), ()), ((), (3,))):
                with self.subTest(constraint=name, nodes=nodes, elements=elements):
                    case = self.case([dict(LOADS["EndpointForces"][1], system=0)],
                                     [{"system": 0, **stated, "position_index": list(nodes), "director_index": list(elements)}])
                    simulator = Simulator(dict(case, constraints_in_order=[]), (0,))
                    feature = Feature.__new__(Feature)
                    feature._bc_cls, feature._sys_idx, feature._args, feature._kwargs = named(name), 0, (), given
                    feature.constrained_position_idx, feature.constrained_director_idx = nodes, elements
                    simulator._constraints_list.append(feature)
                    self.assert_replayed(simulator, case)

    def case(self, forces, constraints):
        return {"format": "rod-reference 1", "case": "made", "stepper": "PositionVerlet", "dt": DT, "start_time": 0.0, "systems": [straight()], "forces_in_order": forces,
                "constraints_in_order": constraints,
                "dampers_in_order": [{"system": 0, "kind": "analytical_linear", "time_step": DT, "uniform_damping_constant": 0.9}], "outputs": []}

    def assert_replayed(self, simulator, case):
        simulation = skein.Simulation(elastica.scene_of(simulator, DT, 1000 * DT))
        rod = simulation["rod_0"]
        for step in (1, 10, 100, 1000):
            simulation.step(step - simulation.steps_done)
            state = {"position": rod.position[0], "velocity": rod.velocity[0], "directors": rod.directors[0], "omega": rod.spin[0]}
            case["outputs"].append({"step": step, "time": step * DT, "systems": [{key: value.tolist() for key, value in state.items()}]})
        self.assertGreater(np.abs(rod.velocity).max(), 1e-5, "the load moves the rod")
        fields = ("position", "velocity", "directors", "omega")
        case["scale"] = {key: max(max(np.abs(output["systems"][0][key]).max() for output in case["outputs"]), 1e-3) for key in fields}
        case["roundoff_sensitivity"] = [{"step": step, **dict.fromkeys(fields, 1e-10), "omega": 1e-9} for step in (1, 10, 100, 1000)]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "case.json")
            path.write_text(json.dumps(case))
            done = subprocess.run([str(REPLAY), str(path)], capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


@unittest.skipUnless((REFERENCE / "02_clamped_tip_load_dampers.json").exists(), f"no reference files in {REFERENCE}")
class Converted(unittest.TestCase):
    def case(self, name):
        return json.loads((REFERENCE / f"{name}.json").read_text())

    def follow_case(self, case, systems, most):
        simulator = Simulator(case, systems)
        scene = elastica.scene_of(simulator, case["dt"], 1000 * case["dt"])
        print(case["case"])
        rows = elastica.compare(simulator, scene, stepped=simulator.at)
        self.assertEqual([row[0] for row in rows if row[1] == "rod_0"], [1, 10, 100, 1000])
        self.assertLess(max(max(row[2:]) for row in rows), most)
        return scene

    def test_a_clamped_rod_under_a_force_at_its_tip_and_dampers(self):
        scene = self.follow_case(self.case("02_clamped_tip_load_dampers"), (0, 1, 2), 1e-9)
        self.assertEqual([entry["kind"] for entry in scene["damping"]], ["legacy", "uniform", "physical"])

    def test_rods_in_a_magnetic_field(self):
        """Loads are told by the moment of each element in the file, by magnetisation in the simulator."""
        case = self.case("13_magnetic")
        for entry in case["forces_in_order"]:
            system = case["systems"][entry["system"]]
            moment, frame = np.array(entry.pop("moment_material_frame"))[0], np.array(system["directors"])[0]
            strength = np.linalg.norm(moment) / system["volume"][0]
            field = FIELD() if entry.pop("field") == "constant" else SINE()
            field.magnetic_field_amplitude = np.array(entry.pop("amplitude"))
            field.ramp_interval, field.start_time, field.end_time = (entry.pop(key) for key in ("ramp_interval", "start_time", "end_time"))
            for key in set(entry) - {"system", "kind"}:
                del entry[key]
            entry |= {"external_magnetic_field": field, "magnetization_density": strength, "magnetization_direction": moment / np.linalg.norm(moment) @ frame}
        self.follow_case(case, (0,), 1e-9)
        with self.assertRaisesRegex(elastica.NotConverted, "system 1: a SineMagneticField"):
            elastica.scene_of(Simulator(case, (0, 1)), case["dt"], 1.0)

    def test_rest_curvature_and_twist_are_kept(self):
        case = self.case("04_rest_curvature_twist")
        with self.assertRaisesRegex(elastica.NotConverted, "a rest strain"):
            elastica.scene_of(Simulator(case, (0,)), case["dt"], 1.0)
        case["systems"][0]["rest_sigma"] = np.zeros_like(case["systems"][0]["rest_sigma"]).tolist()
        scene = elastica.scene_of(Simulator(case, (0,)), case["dt"], 1.0).check()
        np.testing.assert_array_equal(scene["rods.rod_0.shape.rest_curvature_profile"], case["systems"][0]["rest_kappa"])

    def test_what_is_not_converted_is_named(self):
        for name, words in (("02_clamped_tip_load_dampers", "system 3: damper LaplaceDissipationFilter"), ("01_free_curved_random", "system 0: a start that is not straight")):
            case = self.case(name)
            with self.assertRaisesRegex(elastica.NotConverted, words):
                elastica.scene_of(Simulator(case, range(len(case["systems"]))), case["dt"], 1.0)
        case = self.case("02_clamped_tip_load_dampers")
        simulator = Simulator(case, (0,))
        with self.assertRaisesRegex(elastica.NotConverted, "for a step of 0.0002 s"):
            elastica.scene_of(simulator, 1e-4, 1.0)
        simulator[0].rest_lengths = simulator[0].rest_lengths * np.linspace(1, 1.1, 10)
        with self.assertRaisesRegex(elastica.NotConverted, "system 0: (radii|elements)"):
            elastica.scene_of(simulator, case["dt"], 1.0)


if __name__ == "__main__":
    unittest.main()
