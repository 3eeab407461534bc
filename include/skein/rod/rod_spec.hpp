// Keys of a group of rods, alike in shape, material and ends, each at its own place; or of a group of rigid bodies.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/placement/placement_spec.hpp"
#include "skein/rod/body_spec.hpp"
#include "skein/rod/end_motion.hpp"
#include "skein/rod/hold_spec.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class Law { incompressible, linear, elastica, neo_hookean };
inline constexpr std::string_view law_names[] = {"incompressible", "linear", "elastica", "neo_hookean"};

struct Material {
    double density = 0;                ///< kg/m^3
    double youngs_modulus = 0;         ///< E, Pa; bodies have none
    double shear_modulus = 0;          ///< G, Pa; 0: E/3
    double shear_factor = 27.0 / 28.0; ///< alpha_c, Timoshenko shear correction
    Law law = Law::incompressible;
    double rotary_inertia_scale = 1; ///< j, factor on J1 and J2 of every element
    /// s; 0: off; else each element takes the smallest j that lifts its shear-rotation limit to it
    double rotary_inertia_for_dt = 0;
    static constexpr double automatic_inertia = -1; ///< value of rotary_inertia_for_dt that stands for "auto"
    bool inertia_chosen = false;                    ///< "auto" has chosen the step, which stands in its place

    /// True where rotary inertia is what "auto" chooses.
    bool chooses_inertia() const { return inertia_chosen || rotary_inertia_for_dt == automatic_inertia; }

    void fields(FieldVisitor& f);
};

enum class SectionKind { circular, elliptic, rectangular };
inline constexpr std::string_view section_names[] = {"circular", "elliptic", "rectangular"};

/// Cross-section: circle of radius `radius`, or ellipse or rectangle that reaches `radius` along d1 and `radius_2`
/// along d2. Its scale is linear from 1 at the start to `taper` at the end, or given element by element by `profile`.
/// Given constants replace those of the shape and go with the fourth power of the scale. Mass and inertia are those of
/// the shape.
struct Section {
    SectionKind kind = SectionKind::circular;
    double radius = 0;   ///< m
    double radius_2 = 0; ///< m, not of circles
    double taper = 1;
    std::vector<double> profile;                  ///< empty, or one factor per element
    std::vector<double> profile_2;                ///< factors of radius_2; empty: those of `radius`
    std::string radius_formula, radius_2_formula; ///< formulas of s for the profiles; empty: none
    double torsion_constant = 0;                  ///< m^4; 0: St Venant's of the shape
    std::vector<double> shear_factors;            ///< empty: Material::shear_factor, or alpha_c along d1 and d2
    std::vector<double> bending_stiffness;        ///< empty, or E I1, E I2 about d1 and d2, N m^2

    void fields(FieldVisitor& f);
};

/// Weights of cells and node masses beside the ends: those of the trapezoid rule, or Gregory's.
enum class EndWeights { plain, gregory };
inline constexpr std::string_view end_weight_names[] = {"plain", "gregory"};

/// Rest shape and start. Curvature components are in the body frame, about d1, d2, d3.
struct Shape {
    double length = 0; ///< m
    long elements = 0;
    std::vector<double> length_profile;        ///< empty, or the elements' lengths in any unit, scaled to `length`
    bool closed = false;                       ///< the end joins the start; the rest curvature defaults to a circle's
    Vec3d rest_curvature{0, 0, 0};             ///< kappa0, 1/m
    std::vector<Vec3d> rest_curvature_profile; ///< empty, or one per Voronoi cell (elements - 1)
    std::vector<std::string> rest_curvature_formula; ///< three formulas of s for the profile; empty: none
    Vec3d rest_strain{0, 0, 0};                      ///< sigma0, -
    std::optional<Vec3d> start_curvature;            ///< curvature at t = 0; the rest curvature where absent
    std::vector<Vec3d> start_curvature_profile;      ///< empty, or one per Voronoi cell
    EndWeights end_weights = EndWeights::plain;
    Vec3d velocity{0, 0, 0};         ///< at t = 0, lab, m/s
    Vec3d angular_velocity{0, 0, 0}; ///< whole rod at t = 0, lab, rad/s
    Vec3d element_spin{0, 0, 0};     ///< each element in its place at t = 0, body, rad/s

    /// Number of cells between elements: a ring has one more, where it closes.
    long cells() const { return closed ? elements : elements - 1; }
    void fields(FieldVisitor& f);
};

/// Support of an end. `clamped` is the second-order clamp: a half Voronoi cell between the wall frame and the first
/// element. `clamped_frozen` fixes the first node and the first element's director, as published codes do (first
/// order).
enum class EndKind { free, pinned, clamped, clamped_frozen };
inline constexpr std::string_view end_names[] = {"free", "pinned", "clamped", "clamped_frozen"};

/// 1 in the lab directions that are named, 0 in others.
inline Vec3d lab_directions(std::string_view letters) {
    const auto named = [&](char axis) { return letters.find(axis) == std::string_view::npos ? 0.0 : 1.0; };
    return {named('x'), named('y'), named('z')};
}

/// Magnetisation fixed in the material, in a pattern over the rods of a group (Gu et al. 2020; carpets of Parthasarathy
/// et al. 2026):
///   uniform  m = M direction
///   wave_x   m = M (sin px, 0, cos px)                                px = phase + 2 pi x / lambda_x
///   wave_xy  m = M (sin px, sin py, cos px + cos py)/|...|            py = phase + 2 pi y / lambda_y
/// Components are lab components at the rod's start frame; x and y count from the group's first corner. In an assembly
/// both refer to its axes and to its rods alone.
enum class MagnetisationPattern { none, uniform, wave_x, wave_xy };
inline constexpr std::string_view magnetisation_names[] = {"none", "uniform", "wave_x", "wave_xy"};
struct Magnetisation {
    MagnetisationPattern pattern = MagnetisationPattern::none;
    double strength = 0;                   ///< M, A/m
    Vec3d direction{0, 0, 1};              ///< uniform: lab, at the start shape
    double wavelength_x = 0;               ///< m; negative mirrors the wave
    double wavelength_y = 0;               ///< m
    double phase = 3.14159265358979323846; ///< rad, at the group's first corner

    void fields(FieldVisitor& f);
};

struct RodSpec {
    std::string name;
    std::string assembly; ///< assembly whose copies hold the rods; empty: none
    Material material;
    Section section;
    Shape shape;
    Placement placement;
    EndKind start = EndKind::free;
    EndKind end = EndKind::free;
    std::string start_free, end_free;   ///< lab directions in which the node of a held end slides, such as "z" or "xy"
    EndMotion start_motion, end_motion; ///< motion of held ends
    Hold hold;
    Magnetisation magnetisation;
    /// Number of the stage at whose begin the end has been caught where it was; 0: it is where the scene places it.
    std::size_t start_caught = 0, end_caught = 0;
    std::optional<BodySpec> body; ///< keys of a body, which else has name, density, rates at t = 0 and places
    std::string source;           ///< file:line of the table, for messages

    bool ends_caught() const { return start_caught + end_caught > 0; }
    /// True where ends are led: by their motion, or to where they have been caught.
    bool ends_move() const { return ends_caught() || has_motions(); }
    bool has_motions() const {
        return start_motion.moves() || start_motion.turns() || end_motion.moves() || end_motion.turns();
    }
    bool ends_slide() const { return !start_free.empty() || !end_free.empty(); }
    /// Keys of a [[rods]], or of a [[bodies]].
    void fields(FieldVisitor& f);
};

} // namespace skein
