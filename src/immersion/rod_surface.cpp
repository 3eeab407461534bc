#include "immersion/rod_surface.hpp"

#include "immersion/body_surface.hpp"
#include "immersion/markers.hpp"
#include "immersion/plate_markers.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Positions along a rod at rest.
class AlongRod {
public:
    explicit AlongRod(const RodGroup& group) : group_(group) {
        for (const ElementConstants& e : group.element) until_.push_back(length() + e.rest_length);
    }
    double length() const { return until_.empty() ? 0 : until_.back(); }

    struct Place {
        std::size_t element;
        double along;
    };
    Place at(double s) const {
        const auto found = std::upper_bound(until_.begin(), until_.end() - 1, s);
        const std::size_t k = to_index(found - until_.begin());
        return {k, std::clamp((s - first(k)) / group_.element[k].rest_length, 0.0, 1.0)};
    }
    /// Half axes, linear between the middles of elements.
    HalfAxes axes(double s) const {
        const Place place = at(s);
        const std::size_t k = place.element, last = until_.size() - 1,
                          other = place.along < 0.5 ? (k > 0 ? k - 1 : 0) : std::min(k + 1, last);
        const HalfAxes here = half_axes(group_, k), there = half_axes(group_, other);
        const double distance = std::abs(middle(other) - middle(k)),
                     w = distance > 0 ? std::abs(s - middle(k)) / distance : 0;
        return {(1 - w) * here.along_d1 + w * there.along_d1, (1 - w) * here.along_d2 + w * there.along_d2};
    }

private:
    double first(std::size_t k) const { return k > 0 ? until_[k - 1] : 0; }
    double middle(std::size_t k) const { return 0.5 * (first(k) + until_[k]); }

    const RodGroup& group_;
    std::vector<double> until_;
};

int parts_of(double length, double spacing) { return std::max(1, static_cast<int>(std::lround(length / spacing))); }

} // namespace

HalfAxes half_axes(const RodGroup& group, std::size_t element) {
    const ElementConstants& e = group.element[element];
    const double radius = e.radius;
    if (group.spec().section.kind == SectionKind::circular) return {radius, radius};
    const double ratio = std::sqrt(std::sqrt(e.inertia.y / e.inertia.x)); // (a/b)^(1/2) by J2/J1 = (a/b)^2
    return {radius * ratio, radius / ratio};
}

SectionMarkers section_markers(const HalfAxes& axes, double spacing, double retraction) {
    constexpr double thin = 1, flat = 2;
    const auto [least, most] = std::minmax(axes.along_d1, axes.along_d2);
    if (least < thin * spacing && most < flat * least) return SectionMarkers::centre_line;
    return plate_markers(least, spacing, retraction);
}

SectionMarkers plate_markers(double half_thickness, double spacing, double retraction) {
    constexpr double too_close = 0.3; // cells; fluid between closer sides belongs to neither
    return half_thickness - retraction < too_close * spacing ? SectionMarkers::sheet : SectionMarkers::ring;
}

namespace {

/// Direction along which rectangular sections span a periodic box along d2; -1: none.
int direction_across(const RodGroup& group, const FluidGrid& grid) {
    const RodSpec& spec = group.spec();
    if (spec.section.kind != SectionKind::rectangular || group.turned()) return -1;
    const Vec3d d2 = transpose_times(matrix(frame_of(spec.placement.tangent, spec.placement.normal)), Vec3d{0, 1, 0});
    constexpr double rounding = 1e-9;
    for (int d = 0; d < 3; ++d) {
        const double box = grid.h * nth(grid.cells, d);
        bool wide = grid.periodic(d) && std::abs(std::abs(component_of(d2, d)) - 1) < rounding;
        for (std::size_t k = 0; wide && k < group.element.size(); ++k)
            wide = std::abs(2 * half_axes(group, k).along_d2 - box) < rounding * box;
        if (wide) return d;
    }
    return -1;
}

/// Direction along which rods are as long as a periodic box; -1: none.
int direction_through(const RodGroup& group, const FluidGrid& grid) {
    if (group.turned() || group.closed()) return -1;
    double length = 0;
    for (const ElementConstants& e : group.element) length += e.rest_length;
    const Vec3d tangent = unit(group.spec().placement.tangent);
    constexpr double rounding = 1e-9;
    for (int d = 0; d < 3; ++d)
        if (const double box = grid.h * nth(grid.cells, d);
            grid.periodic(d) && std::abs(std::abs(component_of(tangent, d)) - 1) < rounding &&
            std::abs(length - box) < rounding * box)
            return d;
    return -1;
}

} // namespace

bool spans_box(const RodGroup& group, const FluidGrid& grid) { return direction_across(group, grid) >= 0; }

std::vector<double> sharp_shares(const RodGroup& group, const FluidGrid& grid) {
    const bool plate = spans_box(group, grid), ring = group.closed();
    const std::size_t last = group.element.size() - 1;
    std::vector<double> half; // of elements, cells
    for (std::size_t k = 0; k <= last; ++k) {
        const HalfAxes axes = half_axes(group, k);
        half.push_back(std::min(axes.along_d1, plate ? axes.along_d1 : axes.along_d2) / grid.h);
    }
    if (*std::max_element(half.begin(), half.end()) < thick_for_sharp) return {};
    std::vector<double> shares;
    for (std::size_t i = 0; i <= last + 1; ++i) {
        const double before = half[i > 0 ? i - 1 : ring ? last : 0], after = half[i <= last ? i : ring ? 0 : last];
        shares.push_back(
            std::clamp((0.5 * (before + after) - thin_for_sharp) / (all_sharp - thin_for_sharp), 0.0, 1.0));
    }
    return shares;
}

SweptSurface swept_surface(const RodGroup& group, const FluidGrid& grid, std::vector<double> sharp) {
    std::vector<SweptSurface::Element> elements;
    for (std::size_t k = 0; k < group.element.size(); ++k) {
        const HalfAxes half = half_axes(group, k);
        elements.push_back({half.along_d1, half.along_d2, group.element[k].rest_length});
    }
    const bool rectangular = group.spec().section.kind == SectionKind::rectangular;
    const int across = direction_across(group, grid);
    const double near = 3 * grid.h; // nodes are cut within 1.75 cells, and look one further
    return SweptSurface({.section = across >= 0   ? SweptSection::plate
                                    : rectangular ? SweptSection::rectangle
                                                  : SweptSection::ellipse,
                         .elements = std::move(elements),
                         .through = across >= 0 ? across : direction_through(group, grid),
                         .shares = std::move(sharp),
                         .near = near,
                         .closed = group.closed()});
}

std::vector<RodMarker> rod_markers(const RodGroup& group, const FluidGrid& grid, double retraction,
                                   std::span<const double> sharp) {
    const double spacing = grid.h;
    if (const BodyShape* body = group.body()) return body_markers(*body, spacing, retraction);
    const bool rectangular = group.spec().section.kind == SectionKind::rectangular, spans = spans_box(group, grid);
    const AlongRod rod(group);
    std::vector<RodMarker> markers;
    const auto add = [&](double s, double off_d1, double off_d2) {
        const auto [element, along] = rod.at(s);
        const double share = sharp.empty() ? 1 : 1 - share_at(sharp, element, along);
        if (share > 0)
            markers.push_back({.element = static_cast<std::uint32_t>(element),
                               .along = along,
                               .off_d1 = off_d1,
                               .off_d2 = off_d2,
                               .share = share});
    };
    /// Adds markers across the rod from -half to half, `off` from its axis in the other direction.
    const auto line = [&](double s, double half, bool along_d1, double off = 0) {
        const int parts = parts_of(2 * half, spacing);
        for (int i = 0; i < parts; ++i) {
            const double at = half * ((2 * i + 1.0) / parts - 1);
            add(s, along_d1 ? at : off, along_d1 ? off : at);
        }
    };
    const auto ring = [&](double s, double a, double b) {
        if (!rectangular) {
            for (const Vec3d& at : ellipse_markers(a, b, spacing)) add(s, at.x, at.y);
            return;
        }
        for (const double side : {-1.0, 1.0}) {
            line(s, b, false, side * a);
            if (!spans) line(s, a, true, side * b);
        }
    };
    const auto section = [&](double s, bool filled) {
        const HalfAxes axes = rod.axes(s);
        const double a = axes.along_d1 - retraction, b = axes.along_d2 - (spans ? 0 : retraction);
        const SectionMarkers kind =
            spans ? plate_markers(axes.along_d1, spacing, retraction) : section_markers(axes, spacing, retraction);
        if (kind == SectionMarkers::centre_line) return add(s, 0, 0);
        if (kind == SectionMarkers::sheet) return spans ? line(s, b, false) : line(s, std::max({a, b, 0.0}), a >= b);
        ring(s, a, b);
        if (!filled) return;
        double within = spacing;
        for (; within < (spans ? a : std::min(a, b)) - 0.5 * spacing; within += spacing)
            ring(s, a - within, spans ? b : b - within);
        if (spans) return line(s, b, false);
        line(s, std::max(std::max(a, b) - within, 0.0), a >= b); // a line, or a point, is left
    };
    const bool closed = group.closed();
    const double end = closed ? 0 : std::min(retraction, 0.5 * rod.length()), length = rod.length() - 2 * end;
    // Rings at both ends of an open rod belong to its caps.
    const int parts = parts_of(length, spacing);
    if (closed)
        for (int i = 0; i < parts; ++i) section(length * (i + 0.5) / parts, false);
    else
        for (int i = 0; i <= parts; ++i) section(end + length * i / parts, i == 0 || i == parts);
    return markers;
}

} // namespace skein
