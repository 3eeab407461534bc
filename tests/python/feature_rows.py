"""A row for every feature of scenes: what it adds to a small scene of two rods that touch each other and a floor. Every choice of every key that `skein describe` lists
has its row, or a reason in NOT_ROWS."""

from copy import deepcopy

RADIUS, LENGTH = 3e-3, 0.2
HEIGHT = RADIUS - 1e-4  # axis of the left rod
# Two rods that cross. The left one overlaps a floor at z = 0 a little, and the right one the left one. Fifteen steps are one of a fluid.
BASE = {
    "time": {"duration": 1.2e-5, "dt": 2e-7, "divide": 3e-6},
    "rods": [
        {"name": "left", "material": {"density": 1200.0, "youngs_modulus": 1e6}, "section": {"radius": RADIUS},
         "shape": {"length": LENGTH, "elements": 8, "rest_curvature": [3.0, 2.0, 1.0], "start_curvature": [0.0, 0.0, 0.0], "velocity": [0.1, 0.2, -1.0], "angular_velocity": [1.0, 2.0, 3.0], "element_spin": [30.0, 20.0, 10.0]},
         "placement": {"origin": [-0.1, 0.0, HEIGHT], "tangent": [1.0, 0.0, 0.0]}},
        {"name": "right", "material": {"density": 1100.0, "youngs_modulus": 2e6}, "section": {"radius": RADIUS},
         "shape": {"length": LENGTH, "elements": 6, "rest_curvature": [0.0, 1.0, 2.0], "start_curvature": [0.0, 0.0, 0.0], "velocity": [0.0, 0.1, -3.0]},
         "placement": {"origin": [0.0, -0.1, 2 * RADIUS + HEIGHT - 1e-4], "tangent": [0.0, 1.0, 0.0]}},
    ],
}
STILL = {"angular_velocity": [0.0, 0.0, 0.0], "velocity": [0.0, 0.0, 0.0]}
STRIPE = "P1\n2 1\n1 1\n"


class Row:
    """`edit(scene, group)` adds the feature to a scene, where it is of one group to that of this name. `sets`: what two rows cannot both set; `of_group`: it can
    be set for the other group instead. `steps`: those of a pair with it. `last`: it acts on what the other one has added. `looks`: it changes no state; returns what must be there to be read."""

    def __init__(self, name, edit, sets=None, of_group=False, last=False, looks=None, steps=15):
        self.name, self.edit, self.sets, self.of_group, self.last, self.looks, self.steps = name, edit, sets or name, of_group, last, looks, steps


def group(scene, name):
    return next(entry for entry in scene["rods"] if entry["name"] == name)


def merged(old, new):
    for key, value in new.items():
        if isinstance(value, dict): merged(old.setdefault(key, {}), value)
        else: old[key] = value


def of_group(name, sets, **keys):
    return Row(name, lambda scene, where: merged(group(scene, where), deepcopy(keys)), sets, True)


def straight(name, sets, placement, **shape):
    """As of_group, of a rod without curvature at rest."""
    def edit(scene, where):
        own = group(scene, where)["shape"]
        own.pop("rest_curvature", None), own.pop("start_curvature", None)
        own.update(shape)
        group(scene, where)["placement"].update(placement)
    return Row(name, edit, sets, True)


def of_scene(name, sets, looks=None, **tables):
    return Row(name, lambda scene, where: merged(scene, deepcopy(tables)), sets, looks=looks)


def entry(table, title, many=True, **keys):
    """An entry of a list of tables, for a group where the list has 'rods'."""
    def edit(scene, where):
        scene.setdefault(table, []).append(deepcopy(keys) | ({"rods": [where]} if table in ("load", "damping") else {}))
    return Row(title, edit, None if many else table, table in ("load", "damping"))


LISTED = {"pairs": "listed", "first": [0], "second": [0]}


def joint(name, points=True, **keys):
    def edit(scene, where):
        scene.setdefault("joint", []).append({"kind": name, "between": ["left", "right"], "stiffness": 100.0, **({"at": [0.0, 0.5], **LISTED} if points else {}), **keys})
    return Row(f"joint.kind = {name}", edit, "joint")


def world(name, **keys):
    """A joint of a rod to the world."""
    def edit(scene, where):
        scene.setdefault("joint", []).append({"between": [where, "world"], "at": [0.5], "stiffness": 100.0, **keys})
    return Row(name, edit, None, True)


STAGES = [{"name": "before", "duration": 3e-6}, {"name": "after"}]


def stage(title, sets, **changes):
    """A second stage that changes keys of a group."""
    def edit(scene, where):
        if "stage" not in scene: scene["stage"] = deepcopy(STAGES)
        scene["stage"][1].setdefault("change", []).extend(f"rods.{where}.{key}={value}" for key, value in changes.items())
    return Row(title, edit, sets, True, steps=60)


def second(title, table, **keys):
    """A table that acts in the second stage alone."""
    def edit(scene, where):
        if "stage" not in scene: scene["stage"] = deepcopy(STAGES)
        scene.setdefault(table, []).append(deepcopy(keys) | {"stages": ["after"]} | ({"rods": [where]} if table == "load" else {}))
    return Row(title, edit, None, table == "load", steps=60)


def fluid(name, sets="fluid", **keys):
    tables = {"fluid": {"cells": [16, 16, 16], "spacing": 0.05, "lower": [-0.4, -0.4, -0.4], "density": 1000.0, "viscosity": 0.1}}
    merged(tables, keys)
    return of_scene(name, sets, **tables)


def fluid_loads():
    """Columns of the loads of a fluid on single rods."""
    in_fluid = fluid("output.fluid_forces", output={"fluid_forces": ["left"], "fluid_power": True, "series": 6e-6})

    def edit(scene, where):
        in_fluid.edit(scene, where)
        scene.setdefault("probe", []).extend({"name": f"seen_{quantity}", "of": "right", "quantity": quantity} for quantity in ("fluid_force", "fluid_couple"))
    return Row(in_fluid.name, edit, in_fluid.sets)


def sharp_body():
    """A ball that is thick enough for a sharp surface."""
    in_fluid = fluid("immersion.body_surface = sharp", immersion={"body_surface": "sharp"})

    def edit(scene, where):
        in_fluid.edit(scene, where)
        scene.setdefault("bodies", []).append({"name": "float", "density": 900.0, "spheres": {"radii": [0.08]}, "velocity": [0.0, 0.2, 0.0], "placement": {"origin": [0.2, 0.25, 0.2]}})
    return Row(in_fluid.name, edit, in_fluid.sets)


def sharp_rod():
    """A rod that is thick enough for a sharp surface."""
    in_fluid = fluid("immersion.rod_surface = sharp", immersion={"rod_surface": "sharp"})

    def edit(scene, where):
        in_fluid.edit(scene, where)
        scene["rods"].append({"name": "thick", "material": {"density": 1200.0, "youngs_modulus": 1e6}, "section": {"radius": 0.06},
                              "shape": {"length": 0.2, "elements": 4, "velocity": [0.0, 0.2, 0.0]}, "placement": {"origin": [0.2, 0.25, 0.1]}})
    return Row(in_fluid.name, edit, in_fluid.sets)


def body(name, parts):
    def edit(scene, where):
        scene.setdefault("bodies", []).append({"name": name, "density": 900.0, **parts, "velocity": [0.0, 0.0, -1.0], "angular_velocity": [0.0, 3.0, 0.0],
                                               "placement": {"origin": [0.05, 0.0, HEIGHT + RADIUS + 0.005 - 1e-4]}})
    return Row(f"bodies.{name}", edit)


def wall(title, **keys):
    return entry("wall", title, **({"name": "floor", "stiffness": 1e4, "damping": 1.0} | keys))


def relax(scene, where):
    """From rest, by steps of its own."""
    scene["time"] = {key: value for key, value in scene["time"].items() if key not in ("dt", "divide")} | {"relax": True, "duration": 4.0}
    for one in scene["rods"] + scene.get("bodies", []):
        for key in ("velocity", "angular_velocity", "element_spin"):
            one.get("shape", one).pop(key, None)


def stepping(name):
    """By implicit steps, of the given length."""
    def edit(scene, where):
        scene["time"] = {key: value for key, value in scene["time"].items() if key != "divide"} | {"integrator": name}
    return edit


def branch(scene, where, **keys):
    """A rod from the start of `left`, with a joint as within a rod."""
    start = group(scene, "left")["placement"].get("origin", [-0.1, 0.0, HEIGHT])
    scene["rods"].append({"name": "branch", "material": {"density": 1200.0, "youngs_modulus": 1e6}, "section": {"radius": RADIUS}, "shape": {"length": 0.1, "elements": 4},
                          "placement": {"origin": start, "tangent": [0.0, 0.6, 0.8]}})
    scene.setdefault("joint", []).append({"kind": "fixed", "between": ["left", "branch"], "at": [0.0, 0.0], **LISTED, **keys})


def scene_of(*edits):
    """The scene with these rows, each for a group."""
    scene = deepcopy(BASE)
    for row, where in sorted(edits, key=lambda edit: edit[0].last):
        row.edit(scene, where)
    if "contact" in scene and ("joint" in scene or "assembly" in scene): scene["contact"]["joined"] = True
    return scene


def rows_of(folder):
    """All rows. Files that they need are written into `folder`."""
    (folder / "two.pbm").write_text(STRIPE)
    (folder / "stone.obj").write_text("v -0.1 -0.1 -0.1\nv 0.15 -0.1 -0.1\nv 0 0.15 -0.1\nv 0 0 0.15\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    (folder / "rods.csv").write_text("x,y,z,tx,ty,tz,length\n-0.1,0,0.0029,1,0,0,0.2\n-0.1,0.02,0.0029,1,0,0,0.15\n")
    touching = {"law": "hertz", "stiffness": 1e5, "damping": 1.0}
    magnetised = {"strength": 1e5, "direction": [1.0, 0.0, 0.2]}
    rows = [
        of_scene("time.integrator = pefrl", "time.integrator", time={"integrator": "pefrl"}),
        *(Row(f"time.integrator = {name}", stepping(name), sets="time.integrator", last=True) for name in ("implicit", "implicit_damped", "implicit_bed")),
        Row("time.relax", relax, last=True),
        of_scene("time.damping = exponential", "time.damping", time={"damping": "exponential"}, damping=[{"kind": "uniform", "rate": 7.0}]),
        of_scene("time.damping = after", "time.damping", time={"damping": "after"}, damping=[{"kind": "uniform", "rate": 7.0}]),
        *(of_group(f"rods.material.law = {law}", "law", material={"law": law}) for law in ("linear", "neo_hookean")),
        of_group("rods.material.law = elastica", "law", material={"law": "elastica"}),
        of_group("rods.section.kind = elliptic", "section", section={"kind": "elliptic", "radius": 3e-3, "radius_2": 2.97e-3}),
        of_group("rods.section.kind = rectangular", "section", section={"kind": "rectangular", "radius": 3e-3, "radius_2": 2.97e-3}),
        of_group("rods.section.taper", "section", section={"taper": 0.98}),
        straight("rods.shape.closed", "shape", {"origin": [0.0, 0.0, HEIGHT], "normal": [0.0, 0.0, 1.0]}, closed=True),
        straight("rods.shape.end_weights = gregory", "shape", {}, end_weights="gregory", start_curvature=[0.0, 0.0, 5.0]),
        of_group("rods.shape.rest_strain", "shape", shape={"rest_strain": [0.0, 0.0, 0.01]}),
        of_group("rods.placement.kind = line", "placement", placement={"kind": "line", "counts": [2], "spacing": [0.21]}),
        of_group("rods.placement.kind = lattice", "placement", placement={"kind": "lattice", "counts": [1, 2], "spacing": [0.21, 0.01]}),
        of_group("rods.placement.kind = mask", "placement", placement={"kind": "mask", "file": str(folder / "two.pbm"), "spacing": [0.21, 0.21]}),
        Row("rods.placement.kind = list", lambda scene, where: group(scene, where).update(placement={"kind": "list", "origins": [[-0.1, 0.0, HEIGHT], [-0.1, 0.01, HEIGHT]],
            "tangents": [[1.0, 0.0, 0.0], [1.0, 0.1, 0.0]]}), "placement", True),
        Row("rods.placement.kind = packing", lambda scene, where: (group(scene, where).update(placement={"kind": "packing", "count": 3, "lower": [-0.2, -0.2, -2e-4],
            "upper": [0.2, 0.2, 2 * RADIUS - 1e-4], "elevation": [0, 0]})), "placement", True),
        Row("rods.placement.kind = file", lambda scene, where: group(scene, where).update(placement={"kind": "file", "file": str(folder / "rods.csv")}), "placement", True),
        *(of_group(f"rods.start = {kind}", "start", start=kind, shape=STILL)
          for kind in ("pinned", "clamped", "clamped_frozen")),
        *(of_group(f"rods.end = {kind}", "end", end=kind, shape=STILL)
          for kind in ("pinned", "clamped", "clamped_frozen")),
        of_group("rods.start_free", "start", start="clamped", start_free="x", shape=STILL),
        of_group("rods.start_motion", "start", start="clamped", start_motion={"times": [0.0, 1.0], "translation": [[0.0, 0.0, 0.0], [0.1, 0.2, -1.0]]},
                 shape=STILL),
        of_group("rods.end_motion", "end", end="clamped", end_motion={"times": [0.0, 1.0], "rotation": [[0.0, 0.0, 0.0], [0.0, 2.0, 1.0]]},
                 shape=STILL),
        of_group("rods.hold", "hold", hold={"nodes": [3]}, shape=STILL),
        *(of_group(f"rods.hold.axes = {axes}", "hold", hold={"elements": [3], "axes": axes}, shape=STILL) for axes in ("z", "xy")),
        *(Row(f"rods.magnetisation.pattern = {pattern}", lambda scene, where, pattern=pattern, keys=keys: (
            group(scene, where).update(magnetisation={"pattern": pattern, "strength": 1e5, **keys}),
            scene.setdefault("load", []).append({"kind": "magnetic_field", "rods": [where], "constant": [0.0, 0.01, 0.02]})), "magnetisation", True)
          for pattern, keys in (("uniform", {"direction": [1.0, 0.0, 0.2]}), ("wave_x", {"wavelength_x": 0.3}), ("wave_xy", {"wavelength_x": 0.3, "wavelength_y": 0.2}))),
        body("spheres", {"spheres": {"radii": [0.005]}}), body("capsules", {"capsules": {"from": [[-0.01, 0.0, 0.0]], "to": [[0.01, 0.0, 0.0]], "radii": [0.005]}}),
        body("boxes", {"boxes": {"sizes": [[0.02, 0.02, 0.01]], "radii": [0.002]}}),
        of_scene("contact.law = hertz", "contact", contact=touching),
        of_scene("contact.law = linear", "contact", contact=touching | {"law": "linear"}),
        of_scene("contact.self", "contact", contact=touching | {"self": True}),
        of_scene("contact.friction = memory", "contact", contact=touching | {"friction": "memory", "static_friction": 0.5}),
        of_scene("contact.friction = regularised", "contact", contact=touching | {"friction": "regularised", "kinetic_friction": 0.5, "slip_speed": 1e-3}),
        of_scene("contact.friction = published", "contact", contact=touching | {"friction": "published", "kinetic_friction": 0.5, "slip_speed": 1e-3}),
        of_scene("contact_pair", "contact", contact=touching, contact_pair=[{"between": ["left", "right"], "law": "hertz", "stiffness": 3e5}]),
        fluid("fluid.scheme = rk3"), fluid("fluid.scheme = rk3_projected", fluid={"scheme": "rk3_projected"}),
        fluid("fluid.scheme = adams_bashforth", fluid={"scheme": "adams_bashforth"}),
        fluid("fluid.scheme = crank_nicolson", fluid={"scheme": "crank_nicolson"}, immersion={"coupling": "one_way"}),
        fluid("fluid.pressure = multigrid", fluid={"pressure": "multigrid"}),
        fluid("fluid.pressure_exchange = interfaces", fluid={"pressure_exchange": "interfaces"}),
        *(fluid(f"fluid.along = {kind}", fluid={"along_x": kind, "along_y": kind}) for kind in ("free_slip", "no_slip")),
        fluid("fluid.along = through", fluid={"along_x": "through", "inflow": [0.1, 0.0, 0.0]}),
        fluid("fluid.inflow_profile = parabolic", fluid={"along_x": "through", "inflow": [0.1, 0.0, 0.0], "along_y": "no_slip", "inflow_profile": "parabolic"}),
        fluid_loads(),
        fluid("immersion.coupling = one_way", immersion={"coupling": "one_way"}),
        sharp_body(),
        sharp_rod(),
        fluid("immersion.delta = four_point", immersion={"delta": "four_point"}),
        fluid("immersion.forcing = penalty", immersion={"forcing": "penalty", "penalty_damping": 10.0}),
        fluid("obstacle.kind = sphere", obstacle=[{"centre": [0.15, 0.2, 0.15], "radius": 0.1}]),
        fluid("obstacle.kind = cylinder", obstacle=[{"kind": "cylinder", "centre": [0.15, 0.2, 0.15], "radius": 0.1}]),
        fluid("obstacle.kind = capsule", obstacle=[{"kind": "capsule", "centre": [0.15, 0.2, 0.15], "radius": 0.1, "length": 0.1, "axis": [1.0, 1.0, 0.0]}]),
        fluid("obstacle.kind = box", obstacle=[{"kind": "box", "centre": [0.15, 0.2, 0.15], "sides": [0.2, 0.25, 0.2], "angular_velocity": [0.0, 0.0, 1.0]}]),
        fluid("obstacle.kind = ellipsoid", obstacle=[{"kind": "ellipsoid", "surface": "sharp", "centre": [0.15, 0.2, 0.15], "half_axes": [0.12, 0.1, 0.1]}]),
        fluid("obstacle.kind = mesh", obstacle=[{"kind": "mesh", "surface": "sharp", "centre": [0.15, 0.2, 0.15], "file": str(folder / "stone.obj")}]),
        fluid("obstacle.surface = sharp", obstacle=[{"surface": "sharp", "centre": [0.15, 0.2, 0.15], "radius": 0.1}]),
        entry("load", "load.kind = gravity", kind="gravity"),
        entry("load", "load.kind = uniform_force", kind="uniform_force", force=[0.01, 0.02, 0.03]),
        entry("load", "load.kind = uniform_couple", kind="uniform_couple", couple=[0.01, 0.02, 0.03]),
        entry("load", "load.kind = end_force", kind="end_force", end=[0.01, 0.02, 0.03]),
        Row("load.kind = magnetic_field", lambda scene, where: (group(scene, where).update(magnetisation={"pattern": "uniform"} | magnetised),
            scene.setdefault("load", []).append({"kind": "magnetic_field", "rods": [where], "constant": [0.0, 0.01, 0.02], "rotating": 0.1, "period": 1e-4})), "magnetisation", True),
        entry("load", "load.kind = muscle_wave", kind="muscle_wave", amplitude=1e-3, period=1e-3, wavelength=0.1),
        entry("load", "load.kind = sinusoidal_end_force", kind="sinusoidal_end_force", end=0.1, normal=[0.0, 1.0, 0.0], tangent=[1.0, 0.0, 0.0]),
        entry("load", "load.kind = slender_body_drag", kind="slender_body_drag", viscosity=0.1),
        entry("load", "load.kind = muscle_torques", kind="muscle_torques", coefficients=[1e-3, 2e-3, 1e-3, 2e-3], period=1e-3, wave_number=6.0),
        entry("load", "load.kind = anisotropic_plane", kind="anisotropic_plane", stiffness=10.0, kinetic_forward=1.0, kinetic_sideways=1.5, tolerance=1e-2, slip_speed=1e-3),
        entry("load", "load.kind = end_couple", kind="end_couple", start=[1e-3, 2e-3, 3e-3], frame="body"),
        entry("load", "load.kind = formula", kind="formula", force=["0.1*s/L", "0.1*x/L", "0.1*exp(-s/L)"]),
        Row("load.kind = magnetic_formula", lambda scene, where: (group(scene, where).update(magnetisation={"pattern": "uniform"} | magnetised),
            scene.setdefault("load", []).append({"kind": "magnetic_formula", "rods": [where], "field": ["0.01", "0.1*x/L", "0.02"]})), "magnetisation", True),
        entry("load", "load.kind = muscle_formula", kind="muscle_formula", moment=["0.001", "0.002*s", "0"]),
        entry("load", "load.kind = guide", kind="guide", stiffness=3.0, place=["0", "0.1", "0"]),
        Row("table", lambda scene, where: (scene.setdefault("table", []).append({"name": "push", "at": [0.0, 1e-6], "value": [0.0, 1.0]}),
            scene.setdefault("load", []).append({"kind": "formula", "rods": [where], "force": ["push(t)", "0", "0"]}))),
        entry("damping", "damping.kind = uniform", kind="uniform", rate=10.0), entry("damping", "damping.kind = legacy", kind="legacy", rate=10.0),
        entry("damping", "damping.kind = physical", kind="physical", translational=1e-3, rotational=1e-9),
        entry("damping", "damping.kind = laplacian", kind="laplacian", rate=100.0, order=1),
        joint("spherical"), joint("hinge", axis=[0.0, 0.0, 1.0], torsional_stiffness=0.1), joint("fixed", torsional_stiffness=0.1),
        Row("joint.stiffness = auto", branch, "joint"), Row("joint.break_strain", lambda scene, where: branch(scene, where, break_strain=1e-9), "joint"),
        joint("universal", axis=[0.0, 0.0, 1.0], second_axis=[0.0, 1.0, 0.0], torsional_stiffness=0.1),
        joint("slider", axis=[0.0, 0.0, 1.0], torsional_stiffness=0.1), joint("distance", length=0.09),
        joint("bushing", torsional_stiffness=0.1, along=[1.0, 0.5, 0.2], about=[0.1, 1.0, 0.3]),
        world("joint to the world", kind="spherical"),
        world("joint.limits", kind="hinge", axis=[0.0, 0.0, 1.0], torsional_stiffness=0.1, limits=[1e-9, 1.0], stop_stiffness=0.1, stop_damping=1e-6),
        world("joint.friction", kind="hinge", axis=[0.0, 0.0, 1.0], torsional_stiffness=0.1, friction=1e-3, friction_stiffness=0.1),
        world("joint.cone", kind="spherical", axis=[0.0, 0.0, 1.0], cone=1e-3, limits=[1e-9, 1.0], stop_stiffness=0.1, spring=0.01, friction=1e-3, friction_stiffness=0.1),
        world("joint.about_second", kind="universal", axis=[0.0, 0.0, 1.0], second_axis=[0.0, 1.0, 0.0], torsional_stiffness=0.1, spring=0.01, about_second={"spring": 0.01, "limits": [1e-9, 1.0], "stop_stiffness": 0.1}),
        world("joint.motor.values", kind="spherical", motor={"kind": "position", "values": ["0.01", "0.02", "0"], "stiffness": 0.1}),
        world("joint.until", kind="spherical", until=1e-6), world("joint.from", kind="spherical", **{"from": 1e-6}), world("joint.break_force", kind="spherical", break_force=1e-4),
        *(world(f"joint.motor.kind = {kind}", kind="hinge", axis=[0.0, 0.0, 1.0], torsional_stiffness=0.1, motor={"kind": kind, "value": "0.01", **keys})
          for kind, keys in (("position", {"stiffness": 0.1}), ("rate", {"damping": 1e-6}), ("force", {}))),
        joint("side_by_side", False, gap=0.03, repulsion=1e4), joint("tip_to_side", False, at=[0, 0], gap=1.0, torsional_stiffness=0.1),
        Row("assembly", lambda scene, where: (scene.setdefault("assembly", []).append({"name": "pair", "placement": {"kind": "list", "origins": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.3]]}}),
            [one.update(assembly="pair") for one in scene["rods"]]), last=True),
        wall("wall.kind = plane", kind="plane"),
        wall("wall.kind = tube", name="tube", kind="tube", axis=[1.0, 0.0, 0.0], point=[0.0, 0.0, 200.0], radius=200.0),
        wall("wall.kind = ball", name="ball", kind="ball", point=[0.0, 0.0, 200.0], radius=200.0),
        wall("wall.kind = box", name="box", kind="box", lower=[-1.0, -1.0, 0.0], upper=[1.0, 1.0, 1.0]),
        wall("wall.law = linear", name="linear", kind="plane", law="linear"),
        wall("wall.friction = memory", name="sticky", kind="plane", friction="memory", static_friction=0.5),
        wall("wall.friction = regularised", name="rough", kind="plane", friction="regularised", kinetic_friction=0.5, slip_speed=1e-3),
        wall("wall.friction = published", name="old", kind="plane", friction="published", kinetic_friction=0.5, slip_speed=1e-3),
        wall("wall.friction = anisotropic", name="scales", kind="plane", friction="anisotropic", kinetic_friction=0.5, kinetic_backward=1.0, kinetic_sideways=0.7, slip_speed=1e-3),
        wall("wall.touches = axis", name="axis", kind="plane", touches="axis", point=[0.0, 0.0, 3e-3]),
        wall("wall.velocity", name="lift", kind="plane", velocity=[0.0, 0.0, 2.0]),
        Row("wall.servo", lambda scene, where: scene.setdefault("wall", []).extend([
            {"name": "ground", "kind": "plane", "stiffness": 1e4},
            {"name": "lid", "kind": "plane", "point": [0.0, 0.0, 0.5], "normal": [0.0, 0.0, -1.0], "stiffness": 1e4,
             "servo": {"speed": 2.0, "watch": "ground", "area": 0.01, "turn_back_above": 1.0, "turn_forth_below": 0.5}}])),
        stage("stage.change", "stage.change", **{"material.youngs_modulus": 3e7}), stage("stage: an end is caught", "start", start="clamped"),
        stage("stage: an end slides", "end", end="pinned", end_free="xy"), stage("stage: nodes are held", "hold", **{"hold.nodes": [2]}),
        second("load.stages", "load", kind="uniform_force", force=[0.03, 0.02, 0.01]), second("wall.stages", "wall", name="late", kind="plane", stiffness=1e4),
        second("joint.stages", "joint", kind="spherical", between=["left", "right"], at=[0.0, 0.5], stiffness=1e3, **LISTED),
        of_scene("output.audit", "output.audit", "work_loads[J]", output={"audit": True}),
        Row("probe", lambda scene, where: scene.setdefault("probe", []).extend(
            {"name": f"seen_{quantity}", "of": where, "at": 0.3, "quantity": quantity}
            for quantity in ("position", "velocity", "direction", "spin", "strain", "curvature")), "probe", True, looks="seen_position_x[m]"),
        of_scene("output.observables", "output.observables", "angular_momentum_x[kg m^2/s]", output={"observables": ["angular_momentum", "curvature", "order"]}),
    ]
    names = [row.name for row in rows]
    assert len(set(names)) == len(names), [name for name in names if names.count(name) > 1]
    return rows


# Keys and choices without a row, with the reason.
NOT_ROWS = {
    "rods.placement.trace": "of files of centrelines", "rods.placement.region": "shapes of packings", "rods.placement.elevation_law": "angles of packings",
    **{f"{table}.placement.{key}": "as of rods" for table in ("bodies", "assembly") for key in ("kind", "trace", "region", "elevation_law")},
    "rods.magnetisation.pattern = none": "the default", "contact.friction = anisotropic": "for walls alone", "contact_pair.friction": "as of [contact]", "contact_pair.law": "as of [contact]",
    "fluid.along_x": "rows fluid.along", "fluid.along_y": "rows fluid.along", "fluid.along_z": "rows fluid.along", "fluid.moving_walls": "which walls a velocity is of",
    "load.ramp_shape": "shape of a ramp", "load.frame": "axes of a load", "load.per": "unit of a formula", "load.at": "place of a formula",
    "joint.pairs": "which rods are joined", "joint.about_second.motor.kind": "as joint.motor.kind", "wall.side": "side of tubes and balls",
    "fluid_output.kind": "files", "fluid_output.precision": "files", "fluid_output.across": "files", "fluid_output.criterion": "files",
    "probe.quantity": "all in the rows probe and fluid_forces", "expect.take": "compares numbers of a run that has ended",
    "obstacle.surface = markers": "the default", "output.precision": "files", "output.paraview": "files", "start.time": "of branches",
}
