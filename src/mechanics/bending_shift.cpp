#include "mechanics/bending_shift.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

namespace {

struct Deflection {
    double w, slope; ///< deflection of any size, and its slope per length of the rod
};

bool clamped(EndKind end) { return end == EndKind::clamped || end == EndKind::clamped_frozen; }

/// Lowest bending mode of a slender uniform rod of length 1, from the roots b of the frequency equation of its ends; x
/// counts from the end that is held more.
class SlenderMode {
public:
    SlenderMode(EndKind more, EndKind less) : start_(more), end_(less) {
        const bool same = clamped(more) == clamped(less) && (more == EndKind::free) == (less == EndKind::free);
        if (more == EndKind::pinned) root_ = same ? std::numbers::pi : 3.926602312047919;
        else if (same) root_ = 4.730040744862704;
        else root_ = less == EndKind::pinned ? 3.926602312047919 : 1.875104068711961;
        const double b = root_;
        if (start_ == EndKind::pinned) share_ = same ? 0 : std::sin(b) / std::sinh(b);
        else if (clamped(start_) && end_ == EndKind::free)
            share_ = (std::cosh(b) + std::cos(b)) / (std::sinh(b) + std::sin(b));
        else share_ = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
    }
    Deflection at(double x) const {
        const double b = root_, y = b * x;
        if (start_ == EndKind::pinned)
            return {std::sin(y) + share_ * std::sinh(y), b * (std::cos(y) + share_ * std::cosh(y))};
        const double sign = clamped(start_) ? -1 : 1;
        return {std::cosh(y) + sign * std::cos(y) - share_ * (std::sinh(y) + sign * std::sin(y)),
                b * (std::sinh(y) - sign * std::sin(y) - share_ * (std::cosh(y) + sign * std::cos(y)))};
    }

private:
    EndKind start_, end_;
    double root_, share_;
};

int held(EndKind end) { return clamped(end) ? 2 : end == EndKind::pinned ? 1 : 0; }

/// Support of an end against bending. A pinned end that slides sideways is free; a clamped one then holds its
/// direction.
struct Support {
    EndKind kind;
    bool guided = false;
};
/// Support of an end. `tangent` is that of the rod there, or zero where rods have directions of their own.
Support support(EndKind kind, const std::string& free, const Vec3d& tangent) {
    const Vec3d axes = lab_directions(free);
    const bool sideways = dot(axes, axes) > 1.5 || (!free.empty() && std::abs(dot(axes, tangent)) < 1 - 1e-9);
    if (!sideways) return {kind};
    return kind == EndKind::pinned ? Support{EndKind::free} : Support{kind, true};
}

/// Lowest mode at x from the start, over the length. A guided end is the middle of a rod of twice the length.
Deflection lowest_mode(const Support& start, const Support& end, double x) {
    if (start.guided && end.guided)
        return {std::cos(std::numbers::pi * x), std::numbers::pi * std::sin(std::numbers::pi * x)};
    if (start.guided) return lowest_mode(end, start, 1 - x);
    if (end.guided) {
        const Deflection d = SlenderMode(start.kind, start.kind).at(0.5 * x);
        return {d.w, 0.5 * d.slope};
    }
    const bool reversed = held(end.kind) > held(start.kind);
    return SlenderMode(reversed ? end.kind : start.kind, reversed ? start.kind : end.kind).at(reversed ? 1 - x : x);
}

/// Ratio of kinetic energy of rotation to that of translation, with and without the scale.
struct Ratio {
    double scaled, plain;
};

Ratio kinetic_ratio(const RodGroup& group) {
    const double length = group.spec().shape.length;
    const double Vec3d::*axis = group.element[0].bending.x <= group.element[0].bending.y ? &Vec3d::x : &Vec3d::y;
    const RodSpec& spec = group.spec();
    const auto tangent = [&](const Quaterniond& frame) {
        return group.turned() ? Vec3d{0, 0, 0} : third_director(frame);
    };
    const Support start = support(spec.start, spec.start_free, tangent(group.frame())),
                  end = support(spec.end, spec.end_free, tangent(group.end_frame()));
    double translation = 0, scaled = 0, plain = 0, s = 0;
    for (std::size_t k = 0; k < group.element.size(); ++k) {
        const ElementConstants& c = group.element[k];
        const double middle = (s + 0.5 * c.rest_length) / length, mass = group.spec().material.density * c.volume;
        Deflection d = lowest_mode(start, end, middle);
        // A ring deforms to a figure of two waves, w = cos 2a and -sin(2a)/2 along it. Its turn is 1.5 sin 2a over its
        // radius. The means are:
        if (group.closed()) d = {std::sqrt(1.25), 1.5 * 2 * std::numbers::pi};
        const double rotation = c.inertia.*axis * d.slope * d.slope / (length * length);
        translation += mass * d.w * d.w;
        scaled += rotation;
        plain += rotation / group.rotary_inertia_scale[k];
        s += c.rest_length;
    }
    return {scaled / translation, plain / translation};
}

} // namespace

double bending_shift(const RodGroup& group) {
    if (group.rotary_inertia_scale.empty()) return 0;
    const Ratio r = kinetic_ratio(group);
    return std::sqrt((1 + r.plain) / (1 + r.scaled)) - 1;
}

} // namespace skein
