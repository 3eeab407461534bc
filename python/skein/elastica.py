"""Scenes from PyElastica's simulators (docs/references.md): the same rods, ends, loads and dampers, with law "elastica".

    import skein.elastica
    scene = skein.elastica.scene_of(simulator, time_step=1e-4, final_time=2.0)      # before simulator.finalize()
    scene.save("beam.toml")
    skein.elastica.compare(simulator, scene)                                        # steps both, prints how far they are apart

What is read are attributes of the simulator and its systems; PyElastica itself is imported by `compare` alone.
"""

import inspect

import numpy as np

from .scene import Scene
from .simulation import Simulation

SHEAR_FACTOR = 27 / 28
LOOKED_AT = 1, 10, 100, 1000  # steps


class NotConverted(ValueError):
    """A simulator has what scenes of Skein have not, or state otherwise; the message names all of it."""


def scene_of(simulator, time_step, final_time, name="elastica"):
    """The scene of a simulator that is not finalized yet; each of its rods becomes a group rod_<number>. Raises NotConverted."""
    entries, features = [], {"load": [], "damping": []}
    problems = []
    for number, rod in enumerate(simulator):
        try:
            entries.append(_rod(rod, f"rod_{number}"))
        except NotConverted as problem:
            problems.append(f"system {number}: {problem}")
            entries.append({"name": f"rod_{number}"})
    for what, number, cls, arguments in _features(simulator):
        try:
            _feature(what, cls, arguments, entries[number], features, simulator[number], time_step)
        except NotConverted as problem:
            problems.append(f"system {number}: {problem}")
    for attribute in ("_connections", "_contacts"):
        if getattr(simulator, attribute, None):
            problems.append(f"{len(getattr(simulator, attribute))} {attribute.strip('_')}, whose laws are not Skein's")
    if problems:
        raise NotConverted("not converted: " + "; ".join(problems))
    scene = Scene(name, title=f"{name}, from PyElastica", time={"duration": float(final_time), "dt": float(time_step)})
    for entry in entries:
        scene.add("rods", **entry)
    for table, found in features.items():
        for entry in found:
            scene.add(table, **entry)
    return scene


def _rod(rod, name):
    if not hasattr(rod, "bend_matrix"):
        raise NotConverted(f"a {type(rod).__name__}, which is no rod")
    if getattr(rod, "ring_rod_flag", False):
        raise NotConverted("a ring")
    x, q = np.asarray(rod.position_collection).T, np.moveaxis(np.asarray(rod.director_collection), 2, 0)
    lengths, volume, n = np.asarray(rod.rest_lengths), np.asarray(rod.volume), len(rod.rest_lengths)
    area = volume / lengths
    radius = np.sqrt(area / np.pi)
    shear, bend = np.asarray(rod.shear_matrix), np.asarray(rod.bend_matrix)
    inertia = area[0]**2 / (4 * np.pi)
    young, modulus = shear[2, 2, 0] / area[0], shear[0, 0, 0] / (SHEAR_FACTOR * area[0])
    edge = np.diff(x, axis=0)

    def require(right, words):
        if not right:
            raise NotConverted(words)

    require(np.allclose(radius, radius[0], rtol=1e-9), "radii that differ along the rod")
    require(np.allclose(lengths, lengths[0], rtol=1e-9), "elements of unlike lengths")
    require(np.allclose(edge, edge[0], atol=1e-9 * lengths[0]) and np.allclose(q, q[0], atol=1e-9), "a start that is not straight and untwisted")
    require(np.allclose(edge, lengths[0] * q[:, 2], atol=1e-9 * lengths[0]), "a start that is sheared or stretched")
    require(np.allclose(bend[:, :, 0], np.diag([young * inertia, young * inertia, modulus * 2 * inertia]), rtol=1e-6, atol=1e-9 * young * inertia), "a bend matrix that is not that of its radius")
    require(np.allclose(shear[0, 0], shear[1, 1]), "a shear matrix that differs about d1 and d2")
    velocity, spin = np.asarray(rod.velocity_collection).T, np.asarray(rod.omega_collection).T
    require(np.allclose(velocity, velocity[0]), "velocities that differ along the rod")
    require(np.allclose(spin, spin[0]), "angular velocities that differ along the rod")
    kappa, sigma = np.asarray(rod.rest_kappa).T, np.asarray(rod.rest_sigma).T
    require(not np.any(sigma), "a rest strain, which Skein's rods start with and this one does not")
    entry = {"name": name,
             "material": {"law": "elastica", "density": float(np.sum(rod.mass) / np.sum(volume)), "youngs_modulus": float(young), "shear_modulus": float(modulus)},
             "section": {"radius": float(radius[0])},
             "shape": {"length": float(np.sum(lengths)), "elements": n},
             "placement": {"origin": x[0].tolist(), "tangent": q[0, 2].tolist(), "normal": q[0, 0].tolist()}}
    if np.any(kappa):
        entry["shape"] |= {"rest_curvature_profile": kappa.tolist(), "start_curvature": [0.0, 0.0, 0.0]}
    if np.any(velocity):
        entry["shape"]["velocity"] = velocity[0].tolist()
    if np.any(spin):
        entry["shape"]["element_spin"] = spin[0].tolist()
    return entry


def _features(simulator):
    """(kind, number of the system, class, arguments by name) of all that was added: lists of what remembers a class, its arguments and its system."""
    for attribute in vars(simulator).values():
        for entry in attribute if isinstance(attribute, list) else []:
            for kind, name in (("force", "_forcing_cls"), ("constraint", "_bc_cls"), ("damper", "_damper_cls")):
                cls = getattr(entry, name, None)
                if cls is not None:
                    given = list(getattr(entry, "_args", ()))
                    names = [p.name for p in inspect.signature(cls.__init__).parameters.values()][1:]
                    places = [key for key in names if not key.startswith("_")] if kind != "constraint" else []
                    arguments = dict(zip(places, given)) | dict(getattr(entry, "_kwargs", {}))
                    for key in ("constrained_position_idx", "constrained_director_idx"):
                        if hasattr(entry, key):
                            arguments[key] = tuple(getattr(entry, key))
                    yield kind, int(entry._sys_idx), cls, arguments


def _feature(what, cls, given, entry, features, rod, time_step):
    kind, name = cls.__name__, entry["name"]

    def vector(key, default=None):
        return np.asarray(given.get(key, default), float).ravel().tolist()

    def load(**keys):
        features["load"].append({"rods": [name], **keys})

    def damping(**keys):
        if given.get("time_step") not in (None, time_step):
            raise NotConverted(f"{kind} for a step of {given['time_step']:g} s")
        features["damping"].append({"rods": [name], **keys})

    if kind == "GravityForces":
        load(kind="gravity", acceleration=vector("acc_gravity", [0, -9.80665, 0]))
    elif kind == "EndpointForces":
        load(kind="end_force", start=vector("start_force"), end=vector("end_force"), ramp=float(given.get("ramp_up_time", 0)))
    elif kind in ("UniformForces", "UniformTorques"):
        word = "force" if kind == "UniformForces" else "torque"
        total = (float(given[word]) * np.asarray(given["direction"], float)).tolist()
        load(**({"kind": "uniform_force", "force": total} if word == "force" else {"kind": "uniform_couple", "couple": total}))
    elif kind == "EndpointForcesSinusoidal":
        load(kind="sinusoidal_end_force", start=float(given["start_force_mag"]), end=float(given["end_force_mag"]), hold=float(given.get("ramp_up_time", 0)),
             normal=vector("normal_direction", [0, 1, 0]), tangent=vector("tangent_direction", [0, 0, 1]))
    elif kind == "SlenderBodyTheory":
        load(kind="slender_body_drag", viscosity=float(given["dynamic_viscosity"]))
    elif kind == "MuscleTorques":
        wave = {"coefficients": vector("b_coeff")} if given.get("with_spline") else {"table": [1.0] * len(rod.rest_lengths)}
        load(kind="muscle_torques", period=float(given["period"]), wave_number=float(given["wave_number"]), phase=float(given["phase_shift"]), direction=vector("direction"),
             ramp=float(given.get("ramp_up_time", 0)), **wave)
    elif kind == "MagneticForces":
        _magnetic(given, entry, load)
    elif kind in ("FreeBC", "FreeRod"):
        pass
    elif kind in ("OneEndFixedBC", "OneEndFixedRod"):
        if tuple(given.get("constrained_position_idx", (0,))) != (0,):
            raise NotConverted(f"{kind} at another node than the first")
        entry["start"] = "clamped_frozen"
    elif kind == "FixedConstraint":
        ends = {0: "start", -1: "end"}
        nodes, elements = (tuple(given.get(f"constrained_{key}_idx", ())) for key in ("position", "director"))
        if not set(nodes) | set(elements) <= set(ends):
            _hold(entry, kind, nodes, elements, "xyz", "xyz")
            return
        for at, end in ends.items():
            if at in nodes and at in elements:
                entry[end] = "clamped_frozen"
            elif at in nodes:
                entry[end] = "pinned"
            elif at in elements:
                _hold(entry, kind, (), (at,), "xyz", "xyz")
    elif kind == "GeneralConstraint":
        chosen = ["".join(axis for axis, held in zip("xyz", np.ravel(given.get(f"{word}_constraint_selector", [True] * 3))) if held) for word in ("translational", "rotational")]
        _hold(entry, kind, *(tuple(given.get(f"constrained_{key}_idx", ())) for key in ("position", "director")), *chosen)
    elif kind == "AnalyticalLinearDamper":
        if "damping_constant" in given:
            damping(kind="legacy", rate=float(given["damping_constant"]))
        elif "uniform_damping_constant" in given:
            damping(kind="uniform", rate=float(given["uniform_damping_constant"]))
        else:
            damping(kind="physical", translational=float(given["translational_damping_constant"]), rotational=float(np.ravel(given["rotational_damping_constant"])[0]))
    else:
        raise NotConverted(f"{what} {kind}" + (", which removes in one step what Skein's laplacian damping removes at a rate" if kind == "LaplaceDissipationFilter" else ""))


def _hold(entry, kind, nodes, elements, directions, axes):
    if "hold" in entry:
        raise NotConverted(f"{kind} beside another that holds nodes or elements")
    hold = {}
    if nodes and directions:
        hold |= {"nodes": list(nodes), "directions": directions}
    if elements and axes:
        hold |= {"elements": list(elements), "axes": axes}
    entry["hold"] = hold


def _magnetic(given, entry, load):
    field = given["external_magnetic_field"]
    if type(field).__name__ != "ConstantMagneticField":
        raise NotConverted(f"a {type(field).__name__}")
    entry["magnetisation"] = {"pattern": "uniform", "strength": float(np.ravel(given["magnetization_density"])[0]), "direction": np.ravel(given["magnetization_direction"]).tolist()}
    load(kind="magnetic_field", constant=np.ravel(field.magnetic_field_amplitude).tolist(), ramp=float(field.ramp_interval), onset=float(field.start_time),
         until=float(field.end_time))


def compare(simulator, scene, steps=LOOKED_AT, stepped=None, told=print):
    """Steps both, and tells of each of `steps` how far nodes and directors of each rod are apart: [(step, rod, position over the rod's length, directors)].
    `stepped(step)`: brings the simulator to that step; by default finalizes it and steps it by PyElastica's PositionVerlet."""
    stepped = stepped or _verlet(simulator, scene["time.dt"])
    rows = []
    with Simulation(scene) as ours:
        told(f"{'step':>6}  {'rod':<10}{'position/length':>16}{'directors':>12}")
        for step in steps:
            if step > ours.steps:
                break
            ours.step(step - ours.steps_done)
            stepped(step)
            for number, group in enumerate(ours.groups.values()):
                rod = simulator[number]
                length = np.sum(rod.rest_lengths)
                apart = np.abs(group.position[0] - np.asarray(rod.position_collection).T).max() / length
                turned = np.abs(group.directors[0] - np.moveaxis(np.asarray(rod.director_collection), 2, 0)).max()
                rows.append((step, group.name, float(apart), float(turned)))
                told(f"{step:>6}  {group.name:<10}{apart:>16.1e}{turned:>12.1e}")
    return rows


def _verlet(simulator, dt):
    from elastica.timestepper import PositionVerlet, extend_stepper_interface  # PyElastica
    simulator.finalize()
    stepper = PositionVerlet()
    do_step, stages = extend_stepper_interface(stepper, simulator)
    state = {"time": np.float64(0.0), "step": 0}

    def stepped(step):
        while state["step"] < step:
            state["time"] = do_step(stepper, stages, simulator, state["time"], dt)
            state["step"] += 1

    return stepped
