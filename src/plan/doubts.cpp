#include "plan/doubts.hpp"

#include "core/field_looker.hpp"
#include "rod/cell_turn.hpp"
#include "skein/core/index.hpp"
#include "time/stage_spec.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr double beyond = 1e6; // times what a number is measured by

/// Cells that turn so far that a little motion ends the run: a look stops it at 3 rad (mechanics/invalid_state.hpp).
void find_large_turns(const RodGroup& group, std::vector<std::string>& found) {
    constexpr double near = 0.75 * CellTurn::largest;
    const Shape& s = group.spec().shape;
    const auto [most, curvature] = largest_turn(s);
    if (most.angle > near)
        found.push_back(fmt::format("rods.{}.shape: the {} curvature {}; at 3 rad a run stops, and up to 1 rad cells "
                                    "follow a bend: elements = {} would do",
                                    group.name(), curvature, text_of(most),
                                    static_cast<long>(std::ceil(static_cast<double>(s.elements) * most.angle))));
}

/// Lengths and moduli as they look with a wrong unit.
void find_odd_units(const RodGroup& group, std::vector<std::string>& found) {
    constexpr double slender = 2e4; // radii; a hair is 2500 long, the thinnest sutures and cables 10 000
    constexpr double softest = 20,
                     heavy = 100;     // Pa and kg/m^3: jellies have 100 Pa; what is as light may have units of its own
    constexpr double stiffest = 2e12; // Pa: diamond has 1.1e12
    const RodSpec& spec = group.spec();
    const double length = spec.shape.length, radius = spec.section.radius, modulus = spec.material.youngs_modulus;
    if (!group.heterogeneous() && radius > length)
        found.push_back(fmt::format(
            "rods.{}.section: radius = {:g} m is {:.3g} times the length of {:g} m: lengths are in m; were {:g} mm "
            "meant, write {:g}",
            spec.name, radius, radius / length, length, radius, 1e-3 * radius));
    if (!group.heterogeneous() && length > slender * radius)
        found.push_back(fmt::format(
            "rods.{}.shape: length = {:g} m is {:.3g} radii of {:g} m: lengths are in m; were {:g} mm meant, write "
            "{:g}",
            spec.name, length, length / radius, radius, length, 1e-3 * length));
    if (modulus < softest && spec.material.density > heavy)
        found.push_back(fmt::format(
            "rods.{}.material: youngs_modulus = {:g} Pa is softer than any jelly: moduli are in Pa; were {:g} MPa "
            "meant, write {:g}, of GPa {:g}",
            spec.name, modulus, modulus, 1e6 * modulus, 1e9 * modulus));
    if (modulus > stiffest && spec.material.density > heavy)
        found.push_back(fmt::format(
            "rods.{}.material: youngs_modulus = {:g} Pa is stiffer than diamond: moduli are in Pa, 1e9 of them a "
            "GPa",
            spec.name, modulus));
}

/// Ends whose motion is not 0 when it begins.
void find_jumps(const RodGroup& group, std::vector<std::string>& found) {
    constexpr double share = 1e-3; // of an element, and rad
    const RodSpec& spec = group.spec();
    const auto look = [&](const EndMotion& motion, const char* end, const ElementConstants& element) {
        const double moved = norm(motion.displacement(0).value), turned = norm(motion.turn(0).value);
        if (moved > share * element.rest_length)
            found.push_back(fmt::format(
                "rods.{}.{}_motion: the displacement is {:.3g} m at t = 0, {:.2g} of an element's length: the end "
                "jumps there in the first step",
                spec.name, end, moved, moved / element.rest_length));
        if (turned > share)
            found.push_back(fmt::format(
                "rods.{}.{}_motion: the rotation is {:.3g} rad at t = 0: the end jumps there in the first step",
                spec.name, end, turned));
    };
    look(spec.start_motion, "start", group.element.front());
    look(spec.end_motion, "end", group.element.back());
}

/// Compares numbers with the scales of the scene, by their unit; but places, which may lie anywhere.
class ScaleLooker final : public FieldLooker {
public:
    using FieldLooker::visit;
    ScaleLooker(double duration, double speed, std::string table, std::vector<std::string>& found)
        : duration_(duration), speed_(speed), table_(std::move(table)), found_(found) {}

    void visit(const Field& f, double& x) override { look(f, std::abs(x)); }
    void visit(const Field& f, Vec3d& v) override { look(f, norm(v)); }
    void visit(const Field& f, std::vector<double>& list) override {
        for (const double x : list) look(f, std::abs(x));
    }
    bool enter(const Field& f) override {
        inner_.emplace_back(f.name);
        return true;
    }
    void leave() override { inner_.pop_back(); }

private:
    void look(const Field& f, double x) {
        const auto compare = [&](std::string_view unit, double scale, std::string_view what) {
            if (f.unit != unit || !(x > beyond * scale) || !std::isfinite(x) || !(scale > 0)) return;
            if (x == ActingStages::never) return; // a stage after one with a condition: none knows when
            std::string key = table_;
            for (const std::string& table : inner_) key += "." + table;
            found_.push_back(fmt::format("{}.{} = {:g} {} is {:.0e} times {}", key, f.name, x, unit, x / scale, what));
        };
        compare("s", duration_, "the duration");
        compare("m/s", speed_, "the speed of sound in the fastest rod");
    }

    double duration_, speed_;
    std::string table_;
    std::vector<std::string>& found_;
    std::vector<std::string> inner_; ///< tables within it
};

double sound_speed(std::span<const RodGroup> groups) {
    double speed = 0;
    for (const RodGroup& group : groups)
        if (const Material& m = group.spec().material; group.strained())
            speed = std::max(speed, std::sqrt(m.youngs_modulus / m.density));
    return speed;
}

/// Materials that look like slips.
void find_odd_materials(const RodGroup& group, double duration, std::vector<std::string>& found) {
    const Material& m = group.spec().material;
    const double sound = std::sqrt(m.youngs_modulus / m.density),
                 crossings = duration * sound / group.spec().shape.length,
                 ratio = m.shear_modulus > 0 ? m.youngs_modulus / m.shear_modulus : 3;
    if (ratio > 1e4 || ratio < 1e-3)
        found.push_back(fmt::format(
            "rods.{}.material: youngs_modulus is {:.0e} times shear_modulus; it is 2 to 3 times of solids that "
            "are alike in all directions",
            group.name(), ratio));
    if (crossings < 1e-3)
        found.push_back(
            fmt::format("rods.{}.material: sound takes {:.0e} times the duration to pass along a rod (density = {:g} "
                        "kg/m^3, youngs_modulus = {:g} Pa): nothing will be seen to move",
                        group.name(), 1 / crossings, m.density, m.youngs_modulus));
}

/// Ends that slide along an axis along which the other end is free: the support turns no load of that direction.
void find_sliding_rods(const RodGroup& group, std::vector<std::string>& found) {
    if (group.assembly()) return; // others may hold it
    const RodSpec& rods = group.spec();
    const std::string start = rods.start == EndKind::free ? "xyz" : rods.start_free,
                      end = rods.end == EndKind::free ? "xyz" : rods.end_free;
    if (rods.start == rods.end && rods.start == EndKind::free) return;
    for (const char axis : std::string_view("xyz")) {
        const bool held = !rods.hold.nodes.empty() && rods.hold.directions.find(axis) != std::string::npos;
        if (held || start.find(axis) == std::string::npos || end.find(axis) == std::string::npos) continue;
        found.push_back(fmt::format("rods.{}.{}_free: no end is held along {}, so loads along {} move the whole rod",
                                    group.name(), rods.start_free.empty() ? "end" : "start", axis, axis));
    }
}

} // namespace

ScaleDoubts::ScaleDoubts(double duration, std::span<const RodGroup> groups)
    : duration_(duration), speed_(sound_speed(groups)) {}

void ScaleDoubts::look_at(std::string table, const std::function<void(FieldVisitor&)>& fields) {
    ScaleLooker looker(duration_, speed_, std::move(table), found_);
    fields(looker);
}

std::vector<std::string> doubts(const CoreTables& scene, std::span<const RodGroup> groups, double dt) {
    std::vector<std::string> found;
    for (const RodGroup& group : groups) {
        if (!group.strained()) continue;
        if (!group.heterogeneous()) find_large_turns(group, found);
        find_jumps(group, found);
        find_odd_units(group, found);
        find_odd_materials(group, scene.time.duration, found);
        find_sliding_rods(group, found);
    }
    if (scene.time.duration / dt > 1e13)
        found.push_back(fmt::format("time.duration = {:g} s is {:.0e} steps of {:g} s", scene.time.duration,
                                    scene.time.duration / dt, dt));
    ScaleDoubts scales(scene.time.duration, groups);
    for (RodSpec rods : scene.rods) // copies: fields() hands out references to change
        scales.look_at((rods.body ? "bodies." : "rods.") + rods.name, [&](FieldVisitor& f) { rods.fields(f); });
    for (std::string& doubt : scales.take()) found.push_back(std::move(doubt));
    return found;
}

} // namespace skein
