#include "rod/automatic_inertia.hpp"

#include "rod/rod_modes.hpp"
#include "rod/shape_places.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

namespace skein {

namespace {

/// A fifth of the error of the elements, less what the estimate of both may be off.
constexpr double accepted_share = 0.19;
constexpr double right = 0.01; ///< relative error of a frequency that counts as right
/// More elements make the same errors over n^2, which digits would hide.
constexpr long most_elements = 32;
constexpr std::size_t known_modes = 4; ///< of a plane

/// Bending in a plane, or of a round rod in any: its lowest modes with this rod's elements and with twice as many.
struct Plane {
    std::vector<RodMode> modes;
    std::vector<double> frequency; ///< extrapolated to infinitely many elements, rad/s
    std::vector<double> error;     ///< relative, of the elements of the scene
};

bool round(const RodGroup& rod) {
    return std::all_of(rod.element.begin(), rod.element.end(), [](const ElementConstants& c) {
        return std::abs(c.bending.x - c.bending.y) < 0.01 * c.bending.x &&
               std::abs(c.inertia.x - c.inertia.y) < 0.01 * c.inertia.x;
    });
}

/// Modes by plane. Those of a round rod come in pairs, of which the second counts.
std::vector<std::vector<RodMode>> by_plane(const RodGroup& rod) {
    if (round(rod)) {
        std::vector<std::vector<RodMode>> one(1);
        const std::vector<RodMode> all = slowest_bending(rod, 2 * known_modes);
        for (std::size_t i = 1; i < all.size(); i += 2) one[0].push_back(all[i]);
        if (all.size() == 1) one[0] = all;
        return one;
    }
    std::vector<std::vector<RodMode>> planes(2);
    for (RodMode& mode : slowest_bending(rod, 4 * known_modes)) {
        double about_1 = 0, about_2 = 0;
        for (std::size_t k = 0; k < mode.turn.size(); ++k) {
            about_1 += rod.element[k].rest_length * mode.turn[k].x * mode.turn[k].x;
            about_2 += rod.element[k].rest_length * mode.turn[k].y * mode.turn[k].y;
        }
        std::vector<RodMode>& plane = planes[about_1 < about_2];
        if (plane.size() < known_modes) plane.push_back(std::move(mode));
    }
    return planes;
}

RodGroup at_rest(const RodSpec& spec, long elements) { return RodGroup(with_elements(spec, elements), 0, 0, ""); }

class Rule {
public:
    explicit Rule(const RodSpec& spec)
        : rod_(at_rest(spec, spec.shape.elements)),
          coarse_(at_rest(spec, std::min(spec.shape.elements, most_elements))) {
        const auto coarse = by_plane(coarse_), fine = by_plane(at_rest(spec, 2L * coarse_.elements()));
        const double fewer = static_cast<double>(coarse_.elements()) / static_cast<double>(spec.shape.elements);
        for (std::size_t p = 0; p < coarse.size(); ++p) {
            Plane& plane = planes_.emplace_back();
            for (std::size_t i = 0; i < std::min(coarse[p].size(), fine[p].size()); ++i) {
                const double a = std::sqrt(coarse[p][i].eigenvalue), b = std::sqrt(fine[p][i].eigenvalue),
                             exact = (4 * b - a) / 3;
                plane.modes.push_back(coarse[p][i]);
                plane.frequency.push_back(exact);
                plane.error.push_back((a / exact - 1) * fewer * fewer);
            }
        }
        for (const TimeLimit& limit : time_limits(rod_)) {
            double& of = limit.mode.starts_with("shear-rotation") ? shear_ : other_;
            of = std::min(of, limit.dt);
        }
    }

    AutomaticInertia choose() const {
        AutomaticInertia chosen;
        if (shear_ < other_) chosen.dt = longest();
        const std::vector<double> scales = chosen.dt > 0 ? *scales_for(chosen.dt) : std::vector<double>{};
        if (chosen.dt > 0) {
            chosen.gain = chosen.dt / shear_;
            chosen.share = share(scales);
        }
        chosen.highest = std::numeric_limits<int>::max();
        chosen.frequency = std::numeric_limits<double>::infinity();
        for (const Plane& plane : planes_) find_highest(plane, scales, chosen);
        return chosen;
    }

private:
    std::optional<std::vector<double>> scales_for(double dt) const {
        try {
            return rotary_inertia_for(rod_, dt);
        } catch (const InputError&) {
            return std::nullopt; // shear alone is faster
        }
    }
    /// Relative change of a frequency by scales of the elements: the energy of turning sections, Rayleigh.
    double change(const RodMode& mode, const std::vector<double>& scales) const {
        double added = 0;
        const std::size_t n = mode.turn.size();
        for (std::size_t k = 0; k < n && !scales.empty(); ++k) {
            const std::size_t at = (2 * k + 1) * scales.size() / (2 * n);
            const ElementConstants& c = rod_.element[at];
            const double more = (scales[at] - 1) * coarse_.element[k].rest_length / c.rest_length;
            added +=
                more * (c.inertia.x * mode.turn[k].x * mode.turn[k].x + c.inertia.y * mode.turn[k].y * mode.turn[k].y);
        }
        return 1 / std::sqrt(1 + added) - 1;
    }
    /// Largest change of the two lowest modes of each plane over their error.
    double share(const std::vector<double>& scales) const {
        double largest = 0;
        for (const Plane& plane : planes_)
            for (std::size_t i = 0; i < std::min<std::size_t>(2, plane.modes.size()); ++i)
                largest = std::max(largest, std::abs(change(plane.modes[i], scales) / plane.error[i]));
        return largest;
    }
    /// Longest step up to that of the other modes for which the change is accepted; 0: none. Its twelve bits are the
    /// same wherever the last bits of the modes differ.
    double longest() const {
        const auto accepted = [&](double dt) {
            const auto scales = scales_for(dt);
            return scales && share(*scales) <= accepted_share;
        };
        double low = shear_, high = other_;
        if (accepted(high)) low = high;
        for (int i = 0; i < 40 && low < high; ++i) {
            const double middle = std::sqrt(low * high);
            (accepted(middle) ? low : high) = middle;
        }
        int exponent = 0;
        const double mantissa = std::frexp(low, &exponent),
                     rounded = std::ldexp(std::floor(std::ldexp(mantissa, 12)), exponent - 12);
        return rounded > shear_ ? rounded : 0;
    }
    /// The error of a mode of frequency w is a w + b sqrt(w): of the elements along the rod, and of its ends.
    void find_highest(const Plane& plane, const std::vector<double>& scales, AutomaticInertia& chosen) const {
        std::vector<double> error;
        for (std::size_t i = 0; i < plane.modes.size(); ++i)
            error.push_back(std::abs(plane.error[i] + change(plane.modes[i], scales)));
        const auto limit = [&](int number, double frequency) {
            chosen.highest = std::min(chosen.highest, number);
            chosen.frequency = std::min(chosen.frequency, frequency / (2 * std::numbers::pi));
        };
        const auto& w = plane.frequency;
        const std::size_t known = w.size();
        if (known == 0) return limit(0, 0);
        for (std::size_t i = 0; i < known; ++i)
            if (error[i] > right) {
                const double below = i > 0 ? w[i - 1] : 0, small = i > 0 ? error[i - 1] : 0,
                             part = error[i] > small ? (right - small) / (error[i] - small) : 0;
                return limit(static_cast<int>(i), below + part * (w[i] - below));
            }
        if (known == 1 || !(w[known - 1] > w[known - 2])) return limit(static_cast<int>(known), w[known - 1]);
        const double x = std::sqrt(w[known - 2]), y = std::sqrt(w[known - 1]), p = error[known - 2] / x,
                     q = error[known - 1] / y, a = (q - p) / (y - x), b = p - a * x;
        const double root = a > 0 ? (std::sqrt(b * b + 4 * a * right) - b) / (2 * a) : y;
        limit(static_cast<int>(static_cast<double>(known) + std::max(0.0, std::floor((root - y) / (y - x)))),
              std::max(root, y) * std::max(root, y));
    }

    RodGroup rod_, coarse_;
    std::vector<Plane> planes_;
    double shear_ = std::numeric_limits<double>::infinity(), other_ = shear_; ///< limits of the step, s
};

/// Lengths of m pieces of a rod, each over the same share of the elements.
std::vector<double> shared_lengths(const Shape& was, long m) {
    const std::vector<double> nodes = nodes_of(was);
    const auto place = [&](long i) {
        const double at = static_cast<double>(i) * static_cast<double>(was.elements) / static_cast<double>(m);
        const std::size_t k = std::min(static_cast<std::size_t>(at), nodes.size() - 2);
        return nodes[k] + (at - static_cast<double>(k)) * (nodes[k + 1] - nodes[k]);
    };
    std::vector<double> lengths;
    for (long i = 0; i < m; ++i) lengths.push_back(place(i + 1) - place(i));
    return lengths;
}

Hold held_parts(const Hold& was, long n, long nodes, long m) {
    std::set<long> at, elements;
    for (const long i : was.nodes) at.insert(((i < 0 ? i + nodes : i) * m + n / 2) / n);
    for (const long given : was.elements) {
        const long k = given < 0 ? given + n : given;
        elements.insert(std::min(m - 1, k * m / n));
        for (long j = 0; j < m; ++j)
            if ((2 * j + 1) * n / (2 * m) == k) elements.insert(j);
    }
    Hold now = was;
    now.nodes.assign(at.begin(), at.end());
    now.elements.assign(elements.begin(), elements.end());
    return now;
}

} // namespace

RodSpec with_elements(RodSpec spec, long elements) {
    const Shape was = spec.shape;
    Shape& shape = spec.shape;
    shape.elements = elements;
    if (!was.length_profile.empty() && elements != was.elements) shape.length_profile = shared_lengths(was, elements);
    for (auto* profile : {&spec.section.profile, &spec.section.profile_2}) {
        if (profile->empty() || elements == was.elements) continue;
        const double least = 0.5 * *std::min_element(profile->begin(), profile->end());
        *profile = between(middles_of(was), *profile, middles_of(shape), was.closed);
        for (double& radius : *profile) radius = std::max(radius, least);
    }
    if (!shape.rest_curvature_profile.empty() && elements != was.elements)
        shape.rest_curvature_profile =
            between(vertices_of(was), was.rest_curvature_profile, vertices_of(shape), was.closed);
    shape.start_curvature.reset();
    shape.start_curvature_profile.clear();
    if (elements != was.elements)
        spec.hold = held_parts(spec.hold, was.elements, was.closed ? was.elements : was.elements + 1, elements);
    spec.material.rotary_inertia_scale = 1;
    spec.material.rotary_inertia_for_dt = 0;
    spec.magnetisation = {};
    Placement one;
    one.tangent = spec.placement.tangent;
    one.normal = spec.placement.normal;
    spec.placement = one;
    return spec;
}

AutomaticInertia automatic_inertia(const RodSpec& spec) { return Rule(spec).choose(); }

} // namespace skein
