"""Small scenes that between them have every kind of every list of `skein describe --json`, and every key with a dimension: what
scale_test.py makes larger, slower and heavier. As dictionaries; a few steps of each."""

import math

UP = [0.0, 0.0, 1.0]


def rods(name, length=0.1, elements=8, radius=0.004, material=None, section=None, shape=None, **keys):
    """A group of rods."""
    return {"name": name, "material": {"density": 1000.0, "youngs_modulus": 1e6} | (material or {}), "section": {"radius": radius} | (section or {}),
            "shape": {"length": length, "elements": elements} | (shape or {})} | keys


def at(x, y, z, tangent=(1.0, 0.0, 0.0), **keys):
    return {"placement": {"origin": [x, y, z], "tangent": list(tangent)} | keys}


def beam(name, y, **keys):
    """A rod along x that is held where it starts, unless `keys` say otherwise."""
    return rods(name, **({"start": "clamped"} | at(0.0, y, 0.0) | keys))


GRAVITY = {"kind": "gravity", "acceleration": [1.0, 0.5, -9.75]}
FRICTION = {"memory": {"static_friction": 0.4, "kinetic_friction": 0.3, "tangential_damping": 0.2}, "regularised": {"kinetic_friction": 0.4, "slip_speed": 0.02},
            "published": {"kinetic_friction": 0.4, "slip_speed": 0.02}}


def law(kind="linear", friction="memory", **keys):
    """A law of contact."""
    stiffness = {"linear": (200.0, 0.2), "hertz": (2e4, 20.0)}[kind]
    return {"law": kind, "stiffness": stiffness[0], "damping": stiffness[1], "friction": friction} | FRICTION.get(friction, {}) | keys


def pile(kind, friction, **keys):
    """Rods, a ring and bodies of all parts that fall onto each other between walls of all shapes. Some begin in walls and in each other."""
    deep = {"allow_overlap": True}
    one = law(kind, friction)
    return {"time": {"duration": 0.1}, "load": [GRAVITY],
            "rods": [rods("thin", radius=0.003, **{"placement": {"kind": "list", "origins": [[-0.05, 0.0, 0.0025], [0.0, -0.05, 0.0085], [-0.045, 0.01, 0.0145]],
                                                                 "tangents": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.25, 0.0]], "normals": [UP, UP, UP]}}),
                     rods("ring", length=0.15, elements=12, radius=0.003, shape={"closed": True}, **at(0.0, 0.0, 0.021))],
            "bodies": [{"name": "ball", "density": 1500.0, "spheres": {"radii": [0.006]}, "velocity": [0.0, 0.1, -0.5], **at(0.01, 0.03, 0.0135, UP)},
                       {"name": "bone", "mass": 0.01, "capsules": {"from": [[-0.01, 0.0, 0.0]], "to": [[0.01, 0.0, 0.0]], "radii": [0.004]},
                        "spheres": {"centres": [[0.01, 0.0, 0.0], [-0.01, 0.0, 0.0]], "radii": [0.005, 0.006]}, "centre": [0.001, 0.0, 0.0],
                        "inertia": [2e-7, 8e-7, 9e-7], "angular_velocity": [3.0, 1.0, 2.0], **at(-0.02, -0.03, 0.0155, UP)},
                       {"name": "brick", "density": 2000.0, "boxes": {"centres": [[0.0, 0.0, 0.0]], "sizes": [[0.02, 0.03, 0.012]], "radii": [0.002]},
                        "velocity": [0.0, 0.0, -0.3], **at(-0.03, 0.02, 0.025, UP)}],
            "contact": one | deep | {"self": True, "self_gap": 0.02} | keys,
            "wall": [{"name": "floor", "kind": "plane", "point": [0.0, 0.0, 0.0]} | law(kind, "anisotropic", kinetic_friction=0.2, kinetic_backward=0.3,
                                                                                 kinetic_sideways=0.5, slip_speed=0.01) | deep,
                     {"name": "drum", "kind": "tube", "point": [0.0, 0.0, 0.0], "axis": UP, "radius": 0.052, "side": "inside"} | one | deep,
                     {"name": "egg", "kind": "ball", "point": [0.03, 0.03, 0.0], "radius": 0.01, "side": "outside", "velocity": [0.0, 0.1, 0.0], "from": 0.001} | one | deep],
            "output": {"audit": False}}


def fluid(cells=(16, 16, 16), **keys):
    return {"cells": list(cells), "spacing": 0.01, "lower": [0.0, -0.02, 0.01], "density": 1000.0, "viscosity": 0.01} | keys


CURVED = {"rest_curvature": [0.5, -1.0, 0.3], "velocity": [0.1, 0.0, -0.2], "element_spin": [0.0, 0.2, 1.0]}
RAMP = {"ramp": 0.003, "onset": 0.0005, "ramp_shape": "cosine"}
STIR = ["0.05*sin(2*pi*(y + 0.02)/0.16)", "0", "0.03*cos(2*pi*x/0.16)"]
IN_WATER = {"density": 1100.0, "youngs_modulus": 1e5}


def swimmer(**keys):
    """A thick rod within the box of fluid()."""
    return rods("swimmer", length=0.08, elements=6, radius=0.012, material=IN_WATER, shape={"velocity": [0.05, 0.02, 0.0]}, **at(0.04, 0.05, 0.09), **keys)


# name: (scene, steps; of a fluid many of these are one of its own)
SCENES = {
    "loads": ({"time": {"duration": 0.1},
               "probe": [{"name": f"seen_{quantity}", "of": "r1", "at": 0.3, "quantity": quantity} for quantity in ("position", "velocity", "direction", "spin", "strain", "curvature")],
               "expect": [{"column": "seen_strain", "take": take, "value": 0.0, "scale": 1.0, "tolerance": 1.0, "reference": "a bound"} |
                          ({} if take == "end" else {"from": 0.01, "until": 0.09}) for take in ("end", "largest", "least", "mean")],
               "rods": [beam(f"r{i}", 0.05 * i, shape=CURVED if i % 2 else {}) for i in range(8)],
               "load": [GRAVITY | RAMP, {"kind": "uniform_force", "force": [0.01, 0.0, 0.02], "rods": ["r0"]} | RAMP,
                        {"kind": "uniform_couple", "couple": [1e-4, 0.0, 2e-4], "rods": ["r1"]} | RAMP,
                        {"kind": "end_force", "start": [0.0, 0.01, 0.0], "end": [0.0, 0.0, 0.02], "rods": ["r0", "r2"]} | RAMP,
                        {"kind": "end_force", "frame": "body", "end": [0.01, 0.0, 0.01], "rods": ["r2"]},
                        {"kind": "end_couple", "start": [1e-5, 0.0, 0.0], "end": [0.0, 1e-4, 0.0], "frame": "body", "rods": ["r2"]} | RAMP,
                        {"kind": "end_couple", "end": [0.0, 1e-4, 0.0], "rods": ["r3"]},
                        {"kind": "sinusoidal_end_force", "start": 0.01, "end": 0.02, "hold": 0.001, "period": 0.01, "rods": ["r4"]},
                        {"kind": "slender_body_drag", "viscosity": 0.5, "rods": ["r1", "r5"]},
                        {"kind": "muscle_wave", "amplitude": 1e-4, "period": 0.02, "wavelength": 0.07, "frame": "body", "rods": ["r5"]} | RAMP,
                        {"kind": "muscle_wave", "amplitude": 1e-4, "period": 0.02, "wavelength": 0.07, "direction": [0.0, 1.0, 1.0], "rods": ["r3"]},
                        {"kind": "muscle_torques", "coefficients": [1e-4, 2e-4, 3e-4, 1e-4], "period": 0.02, "wave_number": 6.0, "rods": ["r6"]} | RAMP,
                        {"kind": "muscle_torques", "table": [1e-4] * 8, "period": 0.02, "wave_number": 6.0, "frame": "body", "rods": ["r7"]},
                        {"kind": "guide", "stiffness": 5.0, "place": ["-0.05 + 0.3*t", "0", "0.001*sin(90*t)"], "rods": ["r7"]}],
               "damping": [{"kind": "uniform", "rate": 3.0, "rods": ["r0", "r1"]}, {"kind": "uniform", "rate": 2.0, "rods": ["r2"]},
                           {"kind": "physical", "translational": 1e-3, "rotational": 1e-8, "rods": ["r3"]},
                           {"kind": "laplacian", "rate": 100.0, "order": 4, "rods": ["r4"]}],
               "output": {"series": 0.05, "audit": True, "observables": ["angular_momentum", "curvature", "order"]}}, 200),
    "magnets": ({"time": {"duration": 0.1},
                 "rods": [beam("one", 0.0, magnetisation={"pattern": "uniform", "strength": 1e4, "direction": [0.6, 0.0, 0.8]}),
                          beam("row", 0.1, placement={"kind": "line", "counts": [3], "spacing": [0.05], "origin": [0.0, 0.1, 0.0]},
                               magnetisation={"pattern": "wave_x", "strength": 1e4, "wavelength_x": 0.12, "phase": 0.3}),
                          beam("field", 0.3, placement={"kind": "lattice", "counts": [2, 2], "spacing": [0.05, 0.06], "stagger": 0.02, "origin": [0.0, 0.3, 0.0]},
                               magnetisation={"pattern": "wave_xy", "strength": 1e4, "wavelength_x": 0.12, "wavelength_y": 0.2})],
                 "load": [{"kind": "magnetic_field", "constant": [0.0, 0.001, 0.002], "rotating": 0.02, "period": 0.03, "until": 0.004, "rods": ["one", "row"]} | RAMP,
                          {"kind": "magnetic_formula", "field": ["0.01*sin(90*t)", "0.2*x", "0.01"], "rods": ["field"]},
                          {"kind": "magnetic_formula", "field": ["0", "0.01", "0.01*z/0.1"], "magnetisation": ["0", "5e3", "1e4*s/L"], "rods": ["one"]}]}, 200),
    "formulas": ({"time": {"duration": 0.1},
                  "constants": {"k": {"value": 30.0, "unit": "1/m"}, "F": {"value": 0.2, "unit": "N/m"}, "w": {"value": 90.0, "unit": "1/s"}, "two": 2.0},
                  "table": [{"name": "gust", "at": [0.0, 0.001, 0.05], "value": [0.0, 0.1, 0.3], "unit": "N/m"},
                            {"name": "profile", "at": [0.0, 0.05, 0.1], "value": [1.0, 2.0, 1.5], "at_unit": "m", "unit": "-", "periodic": True}],
                  "rods": [beam("a", 0.0, section={"radius_formula": "0.004*(1 - 0.3*s/L)"}), beam("b", 0.1, shape={"rest_curvature_formula": ["3*sin(k*s)", "1", "0.5*s/L/L"]}),
                           beam("c", 0.2, section={"kind": "elliptic", "radius": 0.004, "radius_2": 0.003, "radius_2_formula": "0.003 - 0.01*s"}), beam("d", 0.3), beam("e", 0.4), beam("f", 0.5),
                           beam("moved", 0.6, end="pinned", start_motion={"translation_formula": ["0", "0.01*sin(w*t)", "0.05*t"], "rotation_formula": ["0.1*sin(w*t)", "0", "2*t"]},
                                end_motion={"translation_formula": ["0", "0", "-0.02*ramp(t, 0.01)"]})],
                  "load": [{"kind": "formula", "force": ["F*sin(w*t)*s/L", "gust(t)*profile(s)", "-0.05*vz"], "couple": ["0.001*cos(k*x)", "0", "0"], "rods": ["a"]},
                           {"kind": "formula", "per": "mass", "force": ["3*step(z)", "-9.81*if(t > 0.001, 1, two)", "max(x, y)/0.01"], "rods": ["b"]},
                           {"kind": "formula", "per": "rod", "force": ["0.01*tanh(vx/0.1)", "0", "0.02*exp(-t/0.01)"], "couple": ["0", "1e-4", "0"], "frame": "body", "rods": ["c"]},
                           {"kind": "formula", "at": "start", "couple": ["0", "1e-4*sin(w*t)", "0"], "rods": ["d"]},
                           {"kind": "formula", "at": "end", "force": ["0", "0.01*hypot(x, z)/L", "-1*(z - Z)"], "rods": ["d"]},
                           {"kind": "muscle_formula", "moment": ["1e-4*sin(k*s - w*t)", "0", "0"], "frame": "lab", "rods": ["e"]},
                           {"kind": "muscle_formula", "curvature": ["5*sin(k*s - w*t)", "0", "X*9"], "rods": ["f"]}]}, 200),
    "rods": ({"time": {"duration": 0.1, "damping": "midpoint"},
              "rods": [rods("a", shape=CURVED | {"angular_velocity": [0.5, 1.0, -0.3], "rest_strain": [0.01, 0.0, 0.02]}, material={"law": "linear"}, start="pinned", **at(0.0, 0.0, 0.0)),
                       rods("b", shape={"rest_curvature_profile": [[0.1 * i, 1.0, 0.0] for i in range(7)]}, material={"law": "neo_hookean"}, start="clamped", end="clamped", **at(0.0, 0.1, 0.0)),
                       rods("c", shape={"start_curvature": [2.0, 1.0, 0.5]}, material={"law": "elastica", "shear_modulus": 3e5}, start="clamped_frozen", **at(0.0, 0.2, 0.0)),
                       rods("d", shape={"start_curvature_profile": [[0.1 * i, 2.0, 0.0] for i in range(7)]}, section={"kind": "rectangular", "radius": 0.003, "radius_2": 0.002}, **at(0.0, 0.3, 0.0)),
                       rods("e", section={"kind": "elliptic", "radius_2": 0.003, "torsion_constant": 3e-10, "shear_factors": [0.8, 0.9]}, shape={"end_weights": "gregory"}, **at(0.0, 0.4, 0.0)),
                       rods("f", section={"bending_stiffness": [2e-4, 3e-4], "profile": [1.0, 1.1, 1.2, 1.1, 1.0, 0.9, 0.8, 0.7]}, material={"rotary_inertia_for_dt": 1.5e-4}, hold={"nodes": [0], "elements": [0]}, **at(0.0, 0.5, 0.0)),
                       rods("g", section={"taper": 0.7}, material={"rotary_inertia_scale": 2.0}, shape={"length_profile": [1.0, 2.0] * 4}, start="clamped", start_free="z", **at(0.0, 0.6, 0.0)),
                       rods("h", radius=0.002, material={"rotary_inertia_for_dt": "auto"}, start="clamped", **at(0.0, 0.7, 0.0))],
              "load": [GRAVITY], "damping": [{"kind": "uniform", "rate": 2.0, "rods": ["a", "b"]}]}, 200),
    "moved": ({"time": {"duration": 0.1, "divide": 0.004, "rest_speed": 1e-6, "damping": "after"},
               "rods": [beam("a", 0.0, end="clamped", start_motion={"times": [0.0, 0.01, 0.03], "translation": [[0.0, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.01, 0.005]],
                                                                     "rotation": [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.2, 0.0]], "smooth": True},
                             end_motion={"amplitude": [0.001, 0.0, 0.003], "rotation_amplitude": [0.1, 0.0, 0.0], "period": 0.02, "phase": 0.0}),
                        beam("b", 0.1, end="pinned", end_motion={"times": [0.0, 0.02], "translation": [[0.0, 0.0, 0.0], [0.0, 0.01, 0.0]]},
                             start_motion={"amplitude": [0.0, 0.002, 0.0], "period": 0.03})],
               "damping": [{"kind": "uniform", "rate": 30.0}], "output": {"series": 0.004}}, 200),
    "stages": ({"time": {"duration": 0.1}, "load": [GRAVITY, {"kind": "uniform_force", "force": [0.01, 0.0, 0.02], "stages": ["late"]} | RAMP],
                "rods": [beam("a", 0.0, end="clamped"), beam("b", 0.1)], "damping": [{"kind": "uniform", "rate": 3.0, "stages": ["early"]}],
                "stage": [{"name": "early", "duration": 0.002}, {"name": "late", "duration": 0.05, "until": "max_speed > 1e9", "check_every": 0.001, "change": ["rods.a.end=free", "rods.b.end=pinned"]}, {"name": "last"}]}, 200),
    "pefrl": ({"time": {"duration": 0.1, "integrator": "pefrl", "dt": 1e-5}, "rods": [beam("a", 0.0, shape=CURVED)], "load": [GRAVITY], "damping": [{"kind": "uniform", "rate": 2.0}]}, 100),
    "implicit": ({"time": {"duration": 0.1, "integrator": "implicit", "dt": 1e-3}, "rods": [beam("a", 0.0, shape=CURVED)], "load": [GRAVITY], "damping": [{"kind": "uniform", "rate": 2.0}]}, 20),
    "implicit_damped": ({"time": {"duration": 0.1, "integrator": "implicit_damped", "tolerance": 1e-3}, "rods": [beam("a", 0.0, shape=CURVED)], "load": [GRAVITY], "damping": [{"kind": "uniform", "rate": 2.0}]}, 10),
    "implicit_bed": (pile("hertz", "memory") | {"time": {"duration": 0.1, "integrator": "implicit_bed", "dt": 1e-4}}, 100),
    "legacy": ({"time": {"duration": 0.1}, "rods": [beam("a", 0.0, shape=CURVED)], "damping": [{"kind": "legacy", "rate": 0.01}]}, 100),
    "exponential": ({"time": {"duration": 0.1, "damping": "exponential"}, "rods": [beam("a", 0.0, shape=CURVED)], "damping": [{"kind": "uniform", "rate": 200.0}]}, 100),
    "relaxed": ({"time": {"duration": 400, "relax": True}, "rods": [beam("a", 0.0, shape={"start_curvature": [2.0, 1.0, 0.0]})], "load": [GRAVITY]}, 0),
    "hertz": (pile("hertz", "memory", soft_until=0.002, soft_stiffness=1e4, soft_damping=3.0, friction_from=0.001), 300),
    "linear": (pile("linear", "regularised", soft_until=0.001, soft_stiffness=100.0, soft_damping=0.1) | {"output": {"contacts": 0.01}}, 300),
    "published": (pile("linear", "published"), 300),
    "automatic": ({"time": {"duration": 0.1}, "load": [GRAVITY],
                   "rods": [rods("a", **{"placement": {"kind": "list", "origins": [[-0.05, 0.0, 0.004], [0.0, -0.05, 0.0119]], "tangents": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]}}),
                            rods("b", radius=0.003, **at(-0.03, 0.0, 0.0188, (1.0, 0.3, 0.0)))],
                   "contact": {"law": "hertz", "stiffness": "auto"}, "contact_pair": [{"between": ["a", "b"], "law": "hertz", "restitution": 0.5, "collision_time": 0.002, "collision_speed": 0.1}],
                   "wall": [{"name": "floor", "kind": "plane", "law": "hertz", "stiffness": "auto", "touches": "axis", "point": [0.0, 0.0, 0.0041], "rods": ["a"]},
                            {"name": "other", "kind": "plane", "law": "linear", "restitution": 0.4, "collision_time": 0.002, "rods": ["b"]}]}, 200),
    "press": ({"time": {"duration": 0.2}, "load": [GRAVITY],
               "rods": [rods("bed", length=0.06, elements=6, placement={"kind": "packing", "count": 8, "region": "box", "lower": [-0.04, -0.04, 0.0], "upper": [0.04, 0.04, 0.06], "elevation": [-20.0, 20.0], "gap": 1e-4})],
               "contact": law("linear", "memory"),
               "wall": [{"name": "cup", "kind": "box", "lower": [-0.04, -0.04, 0.0], "upper": [0.04, 0.04, 0.2], "open": ["z+"]} | law("linear", "memory"),
                        {"name": "lid", "kind": "plane", "point": [0.0, 0.0, 0.061], "normal": [0.0, 0.0, -1.0], "velocity": [0.0, 0.0, -1.0], "rods": ["bed"],
                         "servo": {"speed": 1.0, "watch": "cup z-", "area": 0.0064, "turn_back_above": 150.0, "turn_forth_below": 60.0, "cycles": 4, "average": 5e-4, "approach": 2.0,
                                   "approach_to": 0.05, "not_before": -0.07}} | law("linear", "none")]}, 400),
    "snake": ({"time": {"duration": 0.1}, "rods": [rods("snake", shape={"velocity": [0.25, 0.125, 0.0]}, **at(0.0, 0.0, 0.00401)), rods("given", **at(0.0, 0.1, 0.0041))],
               "load": [GRAVITY] + [{"kind": "anisotropic_plane", "stiffness": 50.0, "damping": 0.1, "kinetic_forward": 0.2, "kinetic_backward": 0.3, "kinetic_sideways": 0.4,
                                     "static_forward": 0.4, "static_backward": 0.5, "static_sideways": 0.6, "rods": [name]} | more
                                    for name, more in (("snake", {}), ("given", {"point": [0.0, 0.0, 0.0001], "tolerance": 1e-4, "slip_speed": 1e-3}))]}, 300),
    "weightless": ({"time": {"duration": 0.1}, "rods": [rods("snake", shape={"velocity": [0.25, 0.0, -0.1]}, **at(0.0, 0.0, 0.00401))],
                    "load": [{"kind": "anisotropic_plane", "stiffness": 50.0, "kinetic_forward": 0.2, "static_forward": 0.4}]}, 300),
    "joints": ({"time": {"duration": 0.1}, "load": [GRAVITY], "damping": [{"kind": "uniform", "rate": 2.0}],
                "rods": [rods("arm", assembly="robot", **at(0.0, 0.0, 0.0)), rods("hand", assembly="robot", **at(0.1, 0.0, 0.0)), rods("leg", assembly="robot", **at(0.05, 0.0, 0.0, (0.0, 0.0, -1.0))),
                         rods("left", assembly="robot", placement={"kind": "line", "counts": [2], "spacing": [0.008], "origin": [0.0, 0.1, 0.0], "tangent": [0.0, 1.0, 0.0]}),
                         rods("tip", assembly="robot", **at(0.06, 0.008, 0.104, (0.0, 0.0, -1.0))), rods("beside", assembly="robot", **at(0.0, 0.008, 0.0)),
                         rods("torn", assembly="robot", **at(0.0, -0.1, 0.0)), rods("off", assembly="robot", shape={"velocity": [0.5, 0.25, 0.0]}, **at(0.1, -0.1, 0.0))],
                "bodies": [{"name": "fist", "assembly": "robot", "density": 1000.0, "spheres": {"radii": [0.005]}, **at(0.2, 0.0, 0.0)}],
                "assembly": [{"name": "robot", "scatter": [0.001, 0.0, 0.002], "placement": {"kind": "line", "counts": [2], "spacing": [0.5]}}],
                "joint": [{"kind": "spherical", "between": ["arm", "hand"], "stiffness": 500.0, "damping": 0.01},
                          {"kind": "hinge", "between": ["arm", "leg"], "at": [0.5, 0.0], "axis": [0.0, 1.0, 0.0], "stiffness": 500.0, "torsional_stiffness": 0.02, "torsional_damping": 1e-5},
                          {"kind": "fixed", "between": ["hand", "fist"], "stiffness": 500.0, "torsional_stiffness": 0.02, "pairs": "listed", "first": [0], "second": [0]},
                          {"kind": "fixed", "between": ["torn", "off"], "break_strain": 0.005},
                          {"kind": "spherical", "between": ["left", "left"], "at": [0.0, 0.0], "pairs": "next", "stiffness": 20.0},
                          {"kind": "side_by_side", "between": ["left", "left"], "stiffness": 50.0, "gap": 1e-3, "repulsion": 2e3},
                          {"kind": "tip_to_side", "between": ["tip", "beside"], "at": [1.0, 0.0], "stiffness": 50.0, "damping": 0.001, "repulsion": 2e3, "torsional_stiffness": 1e-3}]}, 200),
    "axes": ({"time": {"duration": 0.1}, "load": [GRAVITY],
              "rods": [rods("arm", **at(0.0, 0.0, 0.0))],
              "bodies": [{"name": name, "mass": 0.01, "inertia": [2e-7, 3e-7, 4e-7], "spheres": {"radii": [0.005]}, "velocity": [0.1, 0.2, -0.1], **at(0.05, y, 0.0, UP)}
                         for name, y in (("swing", 0.1), ("cart", 0.2), ("bucket", 0.3), ("shaft", 0.4), ("fly", 0.5), ("ram", 0.6), ("gimbal", 0.7), ("ball", 0.8), ("led", 0.9), ("spun", 1.0))],
              "joint": [{"kind": "hinge", "between": ["swing", "world"], "place": [0.0, 0.1, 0.0], "axis": [0.0, 1.0, 0.0], "stiffness": 100.0, "torsional_stiffness": 0.05, "spring": 1e-3, "spring_rest": 0.1,
                         "axis_damping": 1e-6, "limits": [-0.002, 0.3], "stop_stiffness": 0.01, "stop_damping": 1e-6, "friction": 1e-5, "friction_stiffness": 0.01, "friction_damping": 1e-7,
                         "motor": {"kind": "position", "value": "0.1*sin(6*t/s0)", "stiffness": 1e-3, "damping": 1e-7, "most": 1e-4}},
                        {"kind": "slider", "between": ["cart", "world"], "axis": [1.0, 0.0, 0.0], "stiffness": 100.0, "torsional_stiffness": 0.05, "spring": 1.0, "spring_rest": 0.001, "axis_damping": 0.01,
                         "limits": [-0.01, 1e-4], "stop_stiffness": 10.0, "stop_damping": 0.01, "friction": 0.01, "friction_stiffness": 10.0, "friction_damping": 0.01,
                         "motor": {"kind": "rate", "value": "0.05", "damping": 0.05, "most": 0.01}},
                        {"kind": "distance", "between": ["bucket", "world"], "place": [0.05, 0.3, 0.1], "length": 0.0999, "stiffness": 10.0, "rope": True, "until": 0.002,
                         "motor": {"kind": "force", "value": "-0.02"}},
                        {"kind": "universal", "between": ["shaft", "world"], "axis": [1.0, 0.0, 0.0], "second_axis": [0.0, 1.0, 0.0], "stiffness": 100.0, "torsional_stiffness": 0.05, "break_force": 0.1},
                        {"kind": "bushing", "between": ["ram", "world"], "stiffness": 100.0, "torsional_stiffness": 0.05, "damping": 0.01, "torsional_damping": 1e-6, "along": [1.0, 0.5, 0.1], "about": [0.2, 1.0, 0.6]},
                        {"kind": "universal", "between": ["gimbal", "world"], "axis": [1.0, 0.0, 0.0], "second_axis": [0.0, 1.0, 0.0], "stiffness": 100.0, "torsional_stiffness": 0.05, "spring": 1e-3,
                         "about_second": {"spring": 1e-3, "spring_rest": 0.1, "axis_damping": 1e-6, "limits": [-0.002, 0.3], "stop_stiffness": 0.01, "stop_damping": 1e-6, "friction": 1e-5,
                                          "friction_stiffness": 0.01, "friction_damping": 1e-7, "motor": {"kind": "position", "value": "0.1*sin(6*t/s0)", "stiffness": 1e-3, "damping": 1e-7, "most": 1e-4}}},
                        {"kind": "spherical", "between": ["ball", "world"], "axis": [1.0, 0.0, 0.0], "place": [0.04, 0.8, 0.0], "stiffness": 100.0, "cone": 1e-4, "limits": [-1e-4, 1e-4], "stop_stiffness": 0.01, "stop_damping": 1e-6,
                         "spring": 1e-3, "axis_damping": 1e-6, "friction": 1e-5, "friction_stiffness": 0.01, "friction_damping": 1e-7,
                         "motor": {"kind": "position", "values": ["0.1*sin(6*t/s0)", "0.05", "0.1"], "stiffness": 1e-3, "damping": 1e-7, "most": 1e-4}},
                        {"kind": "spherical", "between": ["led", "world"], "stiffness": 100.0, "motor": {"kind": "rate", "values": ["1", "2", "3"], "damping": 1e-6}},
                        {"kind": "spherical", "between": ["spun", "world"], "stiffness": 100.0, "motor": {"kind": "force", "values": ["1e-5", "2e-5", "0"]}},
                        {"kind": "spherical", "between": ["arm", "fly"], "at": [1.0, 0.0], "stiffness": 10.0, "from": 0.001}],
              "constants": {"s0": {"value": 1.0, "unit": "s"}}}, 300),
    "placed": ({"time": {"duration": 0.1}, "load": [GRAVITY],
                "rods": [rods("cylinder", length=0.05, elements=5, placement={"kind": "packing", "count": 5, "seed": 2, "region": "cylinder", "point": [0.3, 0.0, 0.0], "radius": 0.05, "height": 0.08}),
                         rods("slab", length=0.05, elements=5, placement={"kind": "packing", "count": 5, "seed": 3, "region": "slab", "lower": [0.0, 0.0, 0.0], "upper": [0.1, 0.1, 0.0], "elevation_law": "uniform"}),
                         rods("mask", length=0.05, elements=5, placement={"kind": "mask", "file": "mask.pbm", "spacing": [0.02, 0.03], "origin": [0.0, 0.5, 0.0]}),
                         rods("file", length=0.05, elements=5, placement={"kind": "file", "file": "rods.csv", "origin": [0.0, 1.0, 0.0]}),
                         rods("traced", elements=4, placement={"kind": "file", "file": "traced.h5", "trace": "start", "origin": [0.0, 2.0, 0.0]}),
                         rods("points", elements=5, placement={"kind": "file", "file": "points.csv", "unit": 0.01, "id": "piece", "ignore": ["note"], "origin": [0.0, 3.0, 0.0]})]}, 100),
    "drops": ({"time": {"duration": 0.4}, "fluid": fluid(velocity_formula=STIR, expected_speed=0.1, acceleration=[0.1, 0.0, 0.0], frequency=3.0),
               "obstacle": [{"name": "ball", "centre": [0.08, 0.06, 0.09], "radius": 0.025, "amplitude": [0.0, 0.0, 0.02], "frequency": 2.0, "velocity": [0.02, 0.0, 0.0]}],
               "fluid_output": [{"name": "cut", "kind": "slice", "every": 0.1, "across": "z", "at": 0.08, "precision": "double"}, {"name": "part", "kind": "box", "every": 0.1, "lower": [0.0, -0.02, 0.01], "upper": [0.08, 0.06, 0.09]},
                                {"name": "q", "kind": "blocks", "every": 0.1, "threshold": 0.5}, {"name": "v", "kind": "blocks", "every": 0.1, "criterion": "vorticity", "threshold": 0.5}],
               "fluid_probe": [{"name": "seen", "at": [0.05, 0.03, 0.02]}],
               "output": {"fields": 0.1, "series": 0.1}, "immersion": {"delta": "four_point", "slip": 1e-4}}, 8),
    "channel": ({"time": {"duration": 0.4}, "fluid": fluid(cells=(16, 16, 4), along_x="through", along_y="no_slip", inflow=[0.05, 0.0, 0.0], inflow_profile="parabolic", scheme="adams_bashforth"),
                 "obstacle": [{"name": "post", "kind": "cylinder", "centre": [0.05, 0.06, 0.0], "radius": 0.02, "second_radius": 0.015}]}, 8),
    "sharp": ({"time": {"duration": 0.4}, "fluid": fluid(velocity_formula=STIR, expected_speed=0.1),
               "obstacle": [{"name": "ball", "surface": "sharp", "centre": [0.08, 0.06, 0.09], "radius": 0.025, "amplitude": [0.0, 0.0, 0.02], "frequency": 2.0, "velocity": [0.02, 0.0, 0.0]},
                            {"name": "rest", "surface": "sharp", "centre": [0.03, 0.02, 0.03], "radius": 0.02},
                            {"name": "egg", "kind": "ellipsoid", "surface": "sharp", "centre": [0.03, 0.12, 0.12], "half_axes": [0.03, 0.02, 0.025], "axis": [1.0, 0.0, 1.0]},
                            {"name": "stone", "kind": "mesh", "surface": "sharp", "centre": [0.08, 0.12, 0.03], "file": "stone.obj", "unit": 0.01, "axis": [0.0, 1.0, 3.0]},
                            {"name": "brick", "kind": "box", "surface": "sharp", "centre": [0.12, 0.1, 0.03], "sides": [0.03, 0.04, 0.03], "radius": 0.002, "angular_velocity": [0.0, 0.0, 2.0]},
                            {"name": "pill", "kind": "capsule", "centre": [0.13, 0.12, 0.12], "radius": 0.016, "length": 0.02, "axis": [0.0, 1.0, 0.0]}, {"name": "marked", "centre": [0.12, 0.02, 0.03], "radius": 0.02}]}, 8),
    "floats": ({"time": {"duration": 0.2}, "fluid": fluid(expected_speed=0.2), "load": [GRAVITY], "immersion": {"body_surface": "sharp"},
                "bodies": [{"name": "float", "density": 900.0, "spheres": {"radii": [0.025]}, "velocity": [0.0, 0.05, 0.0], "angular_velocity": [1.0, 0.0, 0.0], **at(0.08, 0.06, 0.09, UP)}]}, 100),
    "thick": ({"time": {"duration": 0.2}, "fluid": fluid(expected_speed=0.2), "load": [GRAVITY], "immersion": {"rod_surface": "sharp"}, "output": {"series": 0.02, "fluid_forces": ["thick"]},
               "rods": [rods("thick", length=0.08, elements=4, radius=0.022, placement={"origin": [0.08, 0.06, 0.05], "tangent": [0.0, 0.0, 1.0]})]}, 100),
    "plates": ({"time": {"duration": 0.4}, "fluid": fluid(along_x="free_slip", along_y="no_slip", along_z="free_slip", lower_wall_velocity=[0.05, 0.0, 0.0], upper_wall_velocity=[0.0, 0.0, 0.02], moving_walls="y", scheme="rk3_projected")}, 8),
    "walls": ({"time": {"duration": 0.4}, "fluid": fluid(along_x="no_slip", along_y="free_slip", lower_wall_velocity=[0.0, 0.0, 0.02], moving_walls="x")}, 8),
    "viscous": ({"time": {"duration": 0.4}, "fluid": fluid(along_z="no_slip", lower_wall_velocity=[0.05, 0.0, 0.0], moving_walls="z", scheme="crank_nicolson", viscosity=1.0),
                 "obstacle": [{"name": "ball", "surface": "sharp", "centre": [0.08, 0.06, 0.09], "radius": 0.025, "velocity": [0.02, 0.0, 0.0]}]}, 8),
    "swims": ({"time": {"duration": 0.2}, "fluid": fluid(expected_speed=0.2), "rods": [swimmer()], "load": [GRAVITY],
               "probe": [{"name": f"seen_{quantity}", "of": "swimmer", "quantity": quantity} for quantity in ("fluid_force", "fluid_couple")],
               "immersion": {"sweeps": 2}}, 400),
    "springs": ({"time": {"duration": 0.2}, "fluid": fluid(expected_speed=0.2), "rods": [swimmer()],
                 "immersion": {"forcing": "penalty", "penalty_stiffness": 1e5, "penalty_damping": 1e3}}, 400),
    "margins": ({"time": {"duration": 0.2}, "rods": [swimmer()], "immersion": {"coupling": "one_way"},
                 "fluid": {"spacing": 0.01, "margin_lower": [0.04, 0.04, 0.04], "margin_upper": [0.05, 0.05, 0.05], "density": 1000.0, "viscosity": 0.01, "expected_speed": 0.2}}, 300),
}

FILES = {"mask.pbm": "P1\n3 2\n1 0 1\n0 1 1\n",
         "stone.obj": "v -2 -2 -1.5\nv 2 -2 -1.5\nv 0 2.5 -1.5\nv 0 0 2.5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
         "points.csv": "piece,x,y,z,diameter,note\n" + "".join(f"{rod},{i},{0.1 * i * i},{5 * rod},{0.5 + 0.01 * i},0\n" for rod in range(2) for i in range(4 + rod))}
CSV = [("x", "m", [0.0, 0.1, 0.2]), ("y", "m", [0.0, 0.01, 0.0]), ("z", "m", [0.0, 0.02, 0.01]), ("tx", "-", [1.0, 0.0, 1.0]), ("ty", "-", [0.0, 1.0, 0.5]), ("tz", "-", [0.0, 0.0, 0.2]),
       ("length", "m", [0.05, 0.06, 0.04]), ("radius", "m", [0.004, 0.003, 0.005])]
NODES = [[[0.02 * i + 0.002 * j * i, 0.1 * j, 0.003 * math.sin(i + j)] for i in range(5)] for j in range(2)]
