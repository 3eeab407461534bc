#include "skein/rod/rod_spec.hpp"

namespace skein {

void Material::fields(FieldVisitor& f) {
    f.visit({.name = "density", .unit = "kg/m^3", .text = "mass density", .required = true, .above = 0}, density);
    f.choice({.name = "law",
              .text = "rod law (docs/theory.md 3); neo_hookean: sections of that material; elastica: the published "
                      "law, without an energy, for comparison"},
             law, law_names);
    f.visit({.name = "youngs_modulus", .unit = "Pa", .text = "E", .required = true, .above = 0}, youngs_modulus);
    f.visit(
        {.name = "shear_modulus", .unit = "Pa", .text = "G; 0 stands for E/3 (incompressible material)", .at_least = 0},
        shear_modulus);
    f.visit(
        {.name = "shear_factor", .unit = "-", .text = "alpha_c, Timoshenko shear correction", .above = 0, .at_most = 2},
        shear_factor);
    f.visit({.name = "rotary_inertia_scale",
             .unit = "-",
             .text = "factor on the rotary inertia about d1 and d2 (not d3): a longer step, slower bending; the plan "
                     "prints by how much",
             .at_least = 1},
            rotary_inertia_scale);
    f.visit({.name = "rotary_inertia_for_dt",
             .unit = "s",
             .text = "step to which `rotary_inertia_scale`, chosen as small as possible for every element, lifts its "
                     "shear-rotation limit; 0: off; or \"auto\": the longest step that changes the two lowest bending "
                     "frequencies by less than a fifth of their error (docs/theory.md 9)",
             .at_least = 0,
             .automatic = automatic_inertia},
            rotary_inertia_for_dt);
}

void Section::fields(FieldVisitor& f) {
    f.choice({.name = "kind", .text = "shape of the cross-section"}, kind, section_names);
    f.visit({.name = "radius",
             .unit = "m",
             .text = "radius; elliptic: semi-axis along d1; rectangular: half of the side along d1",
             .required = true,
             .above = 0},
            radius);
    f.visit({.name = "radius_2",
             .unit = "m",
             .text = "elliptic: semi-axis along d2; rectangular: half of the side along d2",
             .at_least = 0},
            radius_2);
    f.visit({.name = "taper",
             .unit = "-",
             .text = "radius at the end over radius at the start, linear between",
             .above = 0},
            taper);
    f.visit(
        {.name = "profile", .unit = "-", .text = "radius of every element over `radius`; replaces `taper`", .above = 0},
        profile);
    f.visit({.name = "profile_2",
             .unit = "-",
             .text = "not circular: semi-axis along d2 of every element over `radius_2`; default: the scale along d1",
             .above = 0},
            profile_2);
    f.visit({.name = "radius_formula",
             .unit = "m",
             .text = "formula of `s` [m], arc length at rest, and `L`: radius, or semi-axis along d1, at the middle of "
                     "every element; "
                     "instead of `profile`"},
            radius_formula);
    f.visit(
        {.name = "radius_2_formula",
         .unit = "m",
         .text =
             "formula of `s` [m] and `L`: semi-axis along d2 at the middle of every element; instead of `profile_2`"},
        radius_2_formula);
    f.visit({.name = "torsion_constant",
             .unit = "m^4",
             .text = "torsional stiffness over G for a section of `radius`; it varies with the fourth power of the "
                     "radius along the rod; 0: St Venant's constant of the shape",
             .at_least = 0},
            torsion_constant);
    f.visit({.name = "shear_factors",
             .unit = "-",
             .text = "alpha_c along d1 and along d2; replaces `shear_factor` of the material",
             .above = 0,
             .at_most = 2},
            shear_factors);
    f.visit({.name = "bending_stiffness",
             .unit = "N m^2",
             .text = "E I1 about d1 and E I2 about d2 for a section of `radius`; they vary with the fourth power of "
                     "the radius along the rod; default: values of the shape",
             .above = 0},
            bending_stiffness);
}

void Shape::fields(FieldVisitor& f) {
    f.visit({.name = "length", .unit = "m", .text = "rest length", .required = true, .above = 0}, length);
    f.visit({.name = "elements",
             .unit = "-",
             .text = "number of elements",
             .required = true,
             .at_least = 2,
             .at_most = 100000},
            elements);
    f.visit({.name = "length_profile",
             .unit = "-",
             .text = "lengths of the elements relative to each other; default: all equal",
             .above = 0},
            length_profile);
    f.visit({.name = "rest_curvature", .unit = "1/m", .text = "kappa0 about d1, d2, d3, uniform along the rod"},
            rest_curvature);
    f.visit({.name = "rest_curvature_profile",
             .unit = "1/m",
             .text = "kappa0 of every inner vertex (elements - 1; a ring: elements); replaces `rest_curvature`"},
            rest_curvature_profile);
    f.visit({.name = "rest_curvature_formula",
             .unit = "1/m",
             .text = "three formulas of `s` [m], arc length at rest, and `L`: kappa0 about d1, d2, d3 at every vertex; "
                     "instead of "
                     "the other two"},
            rest_curvature_formula);
    f.visit({.name = "rest_strain",
             .unit = "-",
             .text = "sigma0: shear along d1, d2 and stretch along d3; rods begin in their rest shape, free of forces"},
            rest_strain);
    f.visit(
        {.name = "closed",
         .text = "true makes a ring: the last element joins the first; without a curvature it is a circle about d1"},
        closed);
    f.visit_optional(
        {.name = "start_curvature", .unit = "1/m", .text = "curvature at t = 0; default: the rest curvature"},
        start_curvature);
    f.visit(
        {.name = "start_curvature_profile",
         .unit = "1/m",
         .text =
             "curvature at t = 0 of every inner vertex (elements - 1; a ring: elements); replaces `start_curvature`"},
        start_curvature_profile);
    f.choice({.name = "end_weights",
              .text = "weights of cells and node masses beside clamped and free ends; plain: 1/2, 1, 1; gregory: 3/8, "
                      "7/6, 23/24, in open rods of 6 equal elements or more, straight at rest and of one section"},
             end_weights, end_weight_names);
    f.visit({.name = "velocity", .unit = "m/s", .text = "velocity at t = 0, lab frame"}, velocity);
    f.visit(
        {.name = "angular_velocity",
         .unit = "rad/s",
         .text =
             "angular velocity of the whole rod at t = 0, lab frame: about its centre of mass, or about a pinned end"},
        angular_velocity);
    f.visit({.name = "element_spin",
             .unit = "rad/s",
             .text = "angular velocity of every element in its place at t = 0, body frame; nodes are not affected"},
            element_spin);
}

void Magnetisation::fields(FieldVisitor& f) {
    f.choice({.name = "pattern", .text = "variation of the magnetisation from rod to rod"}, pattern,
             magnetisation_names);
    f.visit({.name = "strength", .unit = "A/m", .text = "M, magnetic moment per volume", .at_least = 0}, strength);
    f.visit({.name = "direction", .unit = "-", .text = "uniform: direction in the lab frame at the start"}, direction);
    f.visit({.name = "wavelength_x", .unit = "m", .text = "wave_x, wave_xy: lambda_x; a negative one mirrors the wave"},
            wavelength_x);
    f.visit({.name = "wavelength_y", .unit = "m", .text = "wave_xy: lambda_y"}, wavelength_y);
    f.visit({.name = "phase", .unit = "rad", .text = "angle of the magnetisation at the group's first corner"}, phase);
}

void RodSpec::fields(FieldVisitor& f) {
    f.visit({.name = "name", .text = "name of the group, used by loads, outputs and messages", .required = true}, name);
    f.visit({.name = "assembly", .text = "assembly of the group; each copy contains its rods or bodies, in its axes"},
            assembly);
    if (body) {
        f.visit({.name = "density", .unit = "kg/m^3", .text = "mass density of all parts", .at_least = 0},
                material.density);
        body->fields(f);
        f.visit({.name = "velocity", .unit = "m/s", .text = "velocity of the centre of mass at t = 0, lab frame"},
                shape.velocity);
        f.visit({.name = "angular_velocity", .unit = "rad/s", .text = "angular velocity at t = 0, lab frame"},
                shape.angular_velocity);
        f.table({.name = "placement"}, placement);
        return;
    }
    f.table({.name = "material", .required = true}, material);
    f.table({.name = "section", .required = true}, section);
    f.table({.name = "shape", .required = true}, shape);
    f.table({.name = "placement"}, placement);
    f.choice({.name = "start", .text = "support of the first end"}, start, end_names);
    f.choice({.name = "end", .text = "support of the last end"}, end, end_names);
    f.visit({.name = "start_free",
             .text = "lab directions in which the held first end slides, such as \"z\" or \"xy\": its node is free in "
                     "them, while a clamp still holds its direction"},
            start_free);
    f.visit({.name = "end_free", .text = "lab directions in which the held last end slides"}, end_free);
    f.table({.name = "start_motion"}, start_motion);
    f.table({.name = "end_motion"}, end_motion);
    f.table({.name = "hold"}, hold);
    f.table({.name = "magnetisation"}, magnetisation);
}

} // namespace skein
