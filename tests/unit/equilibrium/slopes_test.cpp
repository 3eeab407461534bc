// Numbers that are set in a scene beside those that are read, and adjoint solutions beside solutions.
#include "equilibrium/static_solution.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "skein/core/error.hpp"
#include "studies/number_effects.hpp"
#include "studies/scene_family.hpp"
#include "studies/scene_number.hpp"
#include "studies/static_slopes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace skein {
namespace {

/// A rod of length 1 with a rest curvature by a table, under a force on its tip.
SceneText rod(long elements, const char* start) {
    return {"rod.toml",
            fmt::format(R"toml(
time.duration = 1.0
constants.pull = {{value = 0.25, unit = "N"}}
[[table]]
name = "bend"
at = [0.0, 0.5, 1.0]
at_unit = "m"
value = [0.0, 0.0, 0.0]
[[rods]]
name = "rod"
start = "{}"
material = {{density = 1000.0, youngs_modulus = 1e9}}
section.radius = 2e-4
shape = {{length = 1.0, elements = {}, rest_curvature_formula = ["bend(s)", "0", "0"], start_curvature = [0.0, 0.0, 0.0]}}
placement = {{origin = [0.0, 0.0, 0.0], tangent = [1.0, 0.0, 0.0]}}
[[bodies]]
name = "ball"
density = 500.0
spheres.radii = [0.01]
placement.origin = [0.0, 9.0, 0.0]
[[load]]
kind = "end_force"
rods = ["rod"]
end = [0.0, 0.0, 1e-9]
[[probe]]
name = "tip"
of = "rod"
)toml",
                        start, elements),
            {}};
}

/// A rod and a strip with loads of many kinds; numbers that stand for others are left out.
SceneText everything() {
    return {"everything.toml",
            R"toml(
time.duration = 1.0
constants.pull = {value = 0.01, unit = "N/m"}
[[table]]
name = "bend"
at = [0.0, 0.5, 1.0]
at_unit = "m"
value = [0.1, 0.2, -0.3]
[[rods]]
name = "rod"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e8}
section = {radius = 0.01, taper = 0.7}
shape = {length = 1.0, elements = 5, rest_curvature = [0.1, 0.3, 0.5]}
placement = {origin = [0.1, 0.2, 0.3], tangent = [1.0, 0.1, 0.2]}
magnetisation = {pattern = "uniform", strength = 1e3, direction = [0.1, 0.0, 1.0]}
[[rods]]
name = "strip"
start = "clamped"
end = "clamped"
end_motion = {amplitude = [0.01, 0.0, -0.02], period = 3.0, phase = 0.4}
material = {density = 900.0, youngs_modulus = 1e7, law = "neo_hookean"}
section = {kind = "rectangular", radius = 0.01, radius_2 = 0.02}
shape = {length = 1.0, elements = 6, rest_curvature_formula = ["bend(s)", "0.1*bend(s)", "0"], start_curvature = [0.1, 0.0, 0.0]}
placement = {origin = [0.0, 3.0, 0.0], tangent = [1.0, 0.0, 0.0], normal = [0.0, 1.0, 0.0]}
[[load]]
kind = "gravity"
rods = ["rod", "strip"]
acceleration = [0.1, 0.2, -1.0]
[[load]]
kind = "end_force"
rods = ["rod"]
end = [0.01, 0.02, 0.03]
ramp = 2.0
[[load]]
kind = "end_couple"
rods = ["rod"]
end = [0.01, 0.02, 0.03]
[[load]]
kind = "magnetic_field"
rods = ["rod"]
constant = [0.0, 0.0, 1e-3]
rotating = 1e-3
period = 4.0
[[load]]
kind = "formula"
rods = ["strip"]
force = ["pull", "0.1*bend(0.1)", "0"]
[[probe]]
name = "tip"
of = "rod"
[[probe]]
name = "tip_of_strip"
of = "strip"
at = 0.5
)toml",
            {}};
}

/// Joints of many kinds between rods and a body.
SceneText joined() {
    return {"joined.toml",
            R"toml(
time.duration = 1.0
[[rods]]
name = "upper"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e8}
section.radius = 0.01
shape = {length = 0.5, elements = 4}
placement.tangent = [1.0, 0.0, 0.0]
[[rods]]
name = "lower"
material = {density = 1000.0, youngs_modulus = 1e8}
section.radius = 0.01
shape = {length = 0.5, elements = 4}
placement = {origin = [0.5, 0.0, 0.0], tangent = [1.0, 0.0, 0.0]}
[[rods]]
name = "fork"
material = {density = 1000.0, youngs_modulus = 1e8}
section.radius = 0.01
shape = {length = 0.4, elements = 4}
placement = {origin = [1.0, 0.0, 0.0], tangent = [0.0, 1.0, 0.0]}
[[bodies]]
name = "ball"
density = 500.0
spheres.radii = [0.05]
placement.origin = [1.0, 0.4, 0.2]
[[joint]]
kind = "hinge"
between = ["upper", "lower"]
axis = [0.0, 1.0, 0.0]
stiffness = 1e4
torsional_stiffness = 10.0
spring = 5.0
motor = {kind = "force", value = "0.1"}
[[joint]]
kind = "fixed"
between = ["lower", "fork"]
at = [1.0, 0.0]
[[joint]]
kind = "distance"
between = ["upper", "fork"]
at = [0.5, 0.5]
stiffness = 50.0
[[joint]]
kind = "bushing"
between = ["fork", "ball"]
stiffness = 1e3
torsional_stiffness = 3.0
at = [1.0, 0.0]
along = [1.0, 0.5, 0.7]
[[load]]
kind = "gravity"
acceleration = [0.1, 0.2, -1.0]
[[probe]]
name = "tip"
of = "fork"
[[probe]]
name = "tip_of_ball"
of = "ball"
)toml",
            {}};
}

/// A rod between supports that lies on a floor and bears another.
SceneText lying() {
    return {"lying.toml",
            R"toml(
time.duration = 1.0
[[rods]]
name = "rod"
start = "clamped"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 0.01
shape = {length = 0.5, elements = 3}
placement = {origin = [0.0, 0.0, 0.02], tangent = [1.0, 0.0, 0.0]}
[[rods]]
name = "upper"
start = "clamped"
material = {density = 1100.0, youngs_modulus = 1e6}
section.radius = 0.01
shape = {length = 0.5, elements = 4}
placement = {origin = [0.33, -0.21, 0.05], tangent = [0.0, 1.0, 0.0]}
[contact]
stiffness = "auto"
[[wall]]
name = "floor"
kind = "plane"
stiffness = "auto"
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]
[[probe]]
name = "tip"
of = "rod"
[[probe]]
name = "tip_of_upper"
of = "upper"
)toml",
            {}};
}

/// A rod on a slope, held by friction, which cannot roll.
SceneText sticking() {
    return {"sticking.toml",
            R"toml(
time.duration = 1.0
[[rods]]
name = "rod"
material = {density = 1000.0, youngs_modulus = 1e8}
section.radius = 0.02
shape = {length = 0.5, elements = 4}
placement = {origin = [0.0, 0.0, 0.0199], tangent = [0.0, 1.0, 0.0], normal = [1.0, 0.0, 0.0]}
hold = {nodes = [0, 1, 2, 3, 4], directions = "x"}
[[load]]
kind = "gravity"
acceleration = [0.0, 1.0, -9.0]
[[wall]]
name = "floor"
kind = "plane"
law = "linear"
stiffness = 300.0
friction = "memory"
static_friction = 0.4
)toml",
            {}};
}

TEST(SceneNumber, IsSetAsAnOverrideSetsIt) {
    const SceneText text = rod(8, "clamped");
    const SceneSpec scene = parse_scene(text.file, text.text);
    for (const std::string key : {"rods.rod.material.youngs_modulus", "rods.0.placement.origin.2", "table.bend.value.1",
                                  "load.0.end.1", "load.end_force.end.2", "rods.rod.shape.start_curvature.0",
                                  "constants.pull.value", "time.duration", "bodies.ball.density", "probe.tip.at"}) {
        const SceneSpec expected = parse_scene(text.file, text.text, {key + "=0.75"});
        EXPECT_EQ(scene_json(with_number(scene, key, 0.75), false), scene_json(expected, false)) << key;
        EXPECT_EQ(number_at(expected, key).value, 0.75) << key;
    }
    EXPECT_THROW(with_number(scene, "rods.rod.material.youngs_modulus", -1), InputError);
    for (const char* key :
         {"rods.bar.material.density", "load.0.end.3", "table.bend.value.3", "table.bend", "probe.1.at"})
        EXPECT_THROW(with_number(scene, key, 0.75), InputError) << key;
}

TEST(SceneNumber, IsTheOneThatTheSceneUses) {
    const SceneText text = rod(8, "clamped");
    const SceneSpec scene = parse_scene(text.file, text.text);
    EXPECT_EQ(number_at(scene, "rods.rod.material.shear_modulus").value, 1e9 / 3);
    EXPECT_EQ(
        number_at(with_number(scene, "rods.rod.material.shear_modulus", 7), "rods.rod.material.shear_modulus").value,
        7);
    EXPECT_THROW(with_number(scene, "rods.rod.material.shear_modulus", 0), InputError) << "stands for E/3";
    for (const char* key : {"rods.rod.section.torsion_constant", "rods.rod.placement.normal.0",
                            "rods.rod.shape.rest_curvature_formula.0"})
        EXPECT_THROW(number_at(scene, key), InputError) << key;
    const SceneText touching = lying();
    const SceneSpec floor = parse_scene(touching.file, touching.text);
    EXPECT_GT(number_at(floor, "wall.floor.stiffness").value, 0);
    const SceneText held = sticking();
    EXPECT_EQ(number_at(parse_scene(held.file, held.text), "wall.floor.kinetic_friction").value, 0.4);
    EXPECT_THROW(with_number(floor, "wall.floor.stiffness", -0.5), InputError);
}

/// Values that stand for other numbers, of all keys that are numbers.
TEST(SceneNumber, PlaceholdersAreThoseOfTheReference) {
    std::set<std::string> found;
    for (const KeyEntry& key : all_keys())
        for (const double value : {0.0, -1.0})
            if (key.type == "number" && is_placeholder(key.field, value)) found.insert(key.path());
    for (const char* key : {"rods.material.shear_modulus",
                            "rods.section.torsion_constant",
                            "rods.material.rotary_inertia_for_dt",
                            "rods.placement.gap",
                            "contact.stiffness",
                            "contact.kinetic_friction",
                            "contact.restitution",
                            "contact.self_gap",
                            "contact_pair.stiffness",
                            "wall.stiffness",
                            "wall.kinetic_friction",
                            "joint.length",
                            "joint.gap",
                            "joint.stiffness",
                            "joint.cone",
                            "joint.motor.most",
                            "joint.about_second.motor.most",
                            "joint.from",
                            "joint.until",
                            "joint.break_force",
                            "joint.break_strain",
                            "load.magnetic_field.until",
                            "load.anisotropic_plane.tolerance",
                            "load.anisotropic_plane.slip_speed",
                            "time.dt"})
        EXPECT_EQ(found.count(key), 1) << key;
    for (const char* key : {"rods.material.density", "joint.torsional_stiffness", "contact.static_friction",
                            "load.gravity.ramp", "rods.shape.length", "load.end_force.start"})
        EXPECT_EQ(found.count(key), 0) << key;
}

/// Paths of all numbers of a scene, given or not.
void collect(const nlohmann::json& at, const std::string& path, std::vector<std::string>& paths) {
    if (at.is_structured())
        for (const auto& [name, inner] : at.items()) collect(inner, path.empty() ? name : path + "." + name, paths);
    else if (at.is_number() || at.is_null() || at == "auto") paths.push_back(path);
}

/// Places of all nodes.
Unknown places_of(const StaticCase&, const StaticState& state) {
    Unknown all(3 * static_cast<Eigen::Index>(state.slot.size()));
    for (Eigen::Index s = 0; s < all.size() / 3; ++s) {
        const Vec3d at = lane(state.slot[static_cast<std::size_t>(s)].position, 0);
        all.segment(3 * s, 3) << at.x, at.y, at.z;
    }
    return all;
}

/// Places, and energies of contacts and walls where there are some.
RestQuantity quantity_of(ObservedCase& observed) {
    RestQuantity quantity{places_of, {}};
    const std::vector<std::string>& names = observed.names();
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == "contact_energy[J]" || names[i] == "wall_energy[J]") quantity.observables.push_back(i);
    return quantity;
}

/// Differences of second order of a quantity at rest, which go on from a state and its springs of friction; none where
/// a scene has no values so far away.
std::optional<Unknown> differences(const StaticCase& one, const StaticState& state, const RestQuantity& quantity,
                                   const std::string& key, double value, double h) {
    const SceneSpec& scene = one.scene;
    const auto at = [&](double by) {
        SceneSpec own = by == 0 ? scene : with_number(scene, key, value + by);
        check_scene(own);
        refuse_unsolvable(own);
        const auto other = static_case(std::move(own), {}, 1);
        StaticState moved = state;
        other->system->set_friction_memory(one.system->friction_memory(state));
        other->system->lead_ends(moved);
        NewtonSolver newton(*other->system, {});
        const NewtonResult found = newton.solve(moved, Unknown::Zero(other->system->unknowns()));
        EXPECT_TRUE(found.converged) << key << ": " << found.reason;
        const Communicator comm = Communicator::alone();
        const Threads threads(1);
        ObservedCase observed(comm, threads, *other, 1);
        observed.take_friction(one.system->friction_memory(state));
        return quantity.at(observed, moved);
    };
    const auto beside = [&](double by) -> std::optional<Unknown> {
        try {
            return at(by);
        } catch (const InputError&) {
            return {};
        }
    };
    const std::optional<Unknown> less = beside(-h), more = beside(h);
    if (less && more) return (*more - *less) / (2 * h);
    if (!less && !more) return {};
    const double side = more ? h : -h;
    return (4 * (more ? *more : *less) - 3 * at(0) - at(2 * side)) / (2 * side);
}

/// Numbers of a scene that slopes are found by; the others are refused, with their key.
std::vector<ChangedNumber> accepted_numbers(const StaticCase& one) {
    std::vector<std::string> paths;
    collect(nlohmann::json::parse(scene_json(one.scene, true)), "", paths);
    std::vector<ChangedNumber> numbers;
    for (const std::string& path : paths) {
        try {
            const SceneNumber found = number_at(one.scene, path);
            refuse_whole(found, path);
            const ChangedNumber number{path, found.value, 1e-6 * (found.value != 0 ? std::abs(found.value) : 1)};
            require_changes(one, {&number, 1}, {}, 1);
            numbers.push_back(number);
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << path << ": " << error.what();
        }
    }
    return numbers;
}

TEST(Slopes, AreThoseOfEquilibriaOfEveryNumberOrRefused) {
    static int argc = 0;
    static char** argv = nullptr;
    static const MpiSession session(argc, argv); // a communicator needs one, up to the end
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    std::size_t compared = 0;
    Eigen::Index compared_energies = 0;
    std::vector<std::string> jump, alone;
    for (const SceneText& text : {everything(), joined(), lying(), sticking()}) {
        const auto one = static_case(text, {}, 1);
        const StaticState state = equilibrium_of(*one, 1);
        ObservedCase observed(comm, threads, *one, 1);
        observed.take_friction(one->system->friction_memory(state));
        StaticSystem::Balance balance = one->system->balance(state, true);
        const Stiffness coupled = *balance.stiffness;
        const StaticSolution solution(*one->system, state, balance);
        const std::vector<ChangedNumber> numbers = accepted_numbers(*one);
        const RestQuantity quantity = quantity_of(observed);
        const auto energies = static_cast<Eigen::Index>(quantity.observables.size());
        const Unknown stored = quantity.at(observed, state).tail(energies);
        const std::vector<NumberEffect> effects =
            NumberEffects(comm, threads, {}, 1, *one, state, coupled).find(numbers, quantity, observed);
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const auto& [key, value, step] = numbers[i];
            const Unknown change = solution.solve(effects[i].loads);
            if (effects[i].jumps || (one->system->rubs() && slips_along(change, solution, *one->system, state))) {
                jump.push_back(key);
                continue;
            }
            const Unknown slope = effects[i].quantity + slope_along(change, quantity, observed, state);
            SCOPED_TRACE(key);
            const std::optional<Unknown> expected = differences(*one, state, quantity, key, value, 100 * step);
            if (!expected) {
                alone.push_back(key);
                continue;
            }
            const Unknown off = slope - *expected;
            const Eigen::Index places = off.size() - energies;
            EXPECT_LT(off.head(places).norm(), 2e-3 * expected->head(places).norm() + 1e-12 / step)
                << key << " = " << value;
            for (Eigen::Index i = 0; i < energies; ++i)
                EXPECT_LT(std::abs(off[places + i]),
                          2e-3 * std::abs((*expected)[places + i]) + 1e-13 * stored[i] / step)
                    << key << " = " << value;
            ++compared;
            compared_energies += energies;
        }
    }
    EXPECT_GT(compared, 100);
    EXPECT_GT(compared_energies, 30);
    // Beyond them the rod leaves the axis that its joint without a spring needs.
    EXPECT_EQ(alone, (std::vector<std::string>{"rods.1.shape.rest_curvature.0", "rods.1.shape.rest_curvature.1"}));
    // A knot at a vertex, to whose sides the curvature rises otherwise; a spring that replaces half elements.
    EXPECT_EQ(jump, (std::vector<std::string>{"table.0.at.1", "joint.1.torsional_stiffness"}));
}

TEST(StaticSolution, AdjointIsTheTranspose) {
    for (const char* start : {"clamped", "pinned", "free"}) {
        const auto one = static_case(rod(6, start), {}, 1);
        const StaticState state = start_of(*one->system, one->groups, one->rods);
        StaticSystem::Balance balance = one->system->balance(state, true);
        const StaticSolution solution(*one->system, state, balance);
        std::mt19937_64 bits(7);
        std::normal_distribution<double> normal;
        Unknown a(one->system->unknowns()), b(a.size());
        for (Eigen::Index i = 0; i < a.size(); ++i) {
            a[i] = normal(bits);
            b[i] = normal(bits);
        }
        const double expected = a.dot(solution.solve(b));
        EXPECT_NEAR(solution.adjoint(a).dot(b), expected, 1e-9 * a.norm() * solution.solve(b).norm()) << start;
    }
}

} // namespace
} // namespace skein
