"""Scenes from PyElastica's simulators, without PyElastica: objects with its attributes, made of recorded trajectories (SKEIN_REFERENCE_DIR), which Skein
then follows."""

import json
import os
import pathlib
import unittest

import numpy as np

from package import ROOT, skein  # noqa: F401  (skein: puts the package in reach)

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
