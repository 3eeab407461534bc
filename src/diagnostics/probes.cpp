#include "diagnostics/probes.hpp"

#include "mechanics/rod_copies.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

constexpr std::string_view units[] = {"m", "m/s", "-", "rad/s", "-", "1/m", "N", "N m"};

/// Exact at both ends.
template <class T> T between(const T& first, const T& second, double share) {
    return (1 - share) * first + share * second;
}

/// Quantity at a place of a body.
Vec3d of_body(ProbeQuantity quantity, const RodCopy& body) {
    const Slot<1>& s = body.state.front();
    switch (quantity) {
    case ProbeQuantity::position:
        return lane(s.position, 0);
    case ProbeQuantity::velocity:
        return lane(s.velocity, 0);
    case ProbeQuantity::direction:
        return body.frames.front().d3;
    default:
        return transpose_times(body.frames.front(), lane(s.spin, 0));
    }
}

/// Quantity at a place of a rod; of strain and curvature the first component.
Vec3d of_rod(ProbeQuantity quantity, const RodCopy& rod, const ProbePlace& at) {
    const std::size_t k = at.element;
    const Slot<1>&s = rod.state[k], &next = rod.state[k + 1];
    switch (quantity) {
    case ProbeQuantity::position:
        return between(lane(s.position, 0), lane(next.position, 0), at.share);
    case ProbeQuantity::velocity:
        return between(lane(s.velocity, 0), lane(next.velocity, 0), at.share);
    case ProbeQuantity::direction:
        return rod.frames[k].d3;
    case ProbeQuantity::spin:
        return transpose_times(rod.frames[k], lane(s.spin, 0));
    case ProbeQuantity::strain:
        return {between(rod.profile[k].strain, rod.profile[k + 1].strain, at.share), 0, 0};
    case ProbeQuantity::curvature:
        return {between(rod.profile[k].curvature, rod.profile[k + 1].curvature, at.share), 0, 0};
    case ProbeQuantity::fluid_force:
    case ProbeQuantity::fluid_couple:
        break;
    }
    return {};
}

/// Rod or body of a probe on this rank, by its place in rods.local(); none on other ranks.
std::vector<std::size_t> own_of(const ProbeSpec& probe, std::span<const RodGroup> groups, const Rods& rods) {
    const auto group =
        std::find_if(groups.begin(), groups.end(), [&](const RodGroup& one) { return one.name() == probe.of; });
    const std::int64_t gid = group->first_gid() + probe.number;
    const auto local = rods.local();
    const auto own = std::find_if(local.begin(), local.end(), [&](const LocalRod& one) { return one.gid == gid; });
    if (own == local.end()) return {};
    return {static_cast<std::size_t>(own - local.begin())};
}

} // namespace

ProbePlace probe_place(const RodGroup& rod, double at) {
    double length = 0;
    for (const ElementConstants& e : rod.element) length += e.rest_length;
    double left = at * length;
    for (std::size_t k = 0; k < rod.element.size(); ++k) {
        const double here = rod.element[k].rest_length;
        if (left <= here || k + 1 == rod.element.size()) return {k, std::clamp(left / here, 0.0, 1.0)};
        left -= here;
    }
    return {0, 0};
}

void ProbeSpec::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "first part of its columns in observables.csv", .required = true},
            name);
    f.visit({.name = "of", .unit = "", .text = "group of rods or bodies", .required = true}, of);
    f.visit({.name = "number", .unit = "-", .text = "number of the rod or body in its group", .at_least = 0}, number);
    f.visit({.name = "at",
             .unit = "-",
             .text = "place on a rod over its length at rest, 0 at the start; unused for a body, whose centre of mass "
                     "is meant, and for forces and couples of the fluid, which are of a whole rod",
             .at_least = 0,
             .at_most = 1},
            at);
    f.choice({.name = "quantity",
              .unit = "",
              .text = "position [m], velocity [m/s], direction (d3 of the element; of a body the principal axis whose "
                      "1/J differs most from the others'), spin [rad/s], fluid_force [N], fluid_couple [N m] (of the "
                      "fluid on the rod or body; about its start, or the centre of mass): columns <name>_x, _y, _z; "
                      "strain of the axis, curvature [1/m]: one column <name>"},
             quantity, probe_quantity_names);
}

std::vector<std::string> probe_names(std::span<const ProbeSpec> probes) {
    std::vector<std::string> names;
    for (const ProbeSpec& probe : probes) {
        if (probe.of_fluid()) continue;
        const std::string_view unit = nth(units, probe.quantity);
        if (probe.strained()) names.push_back(fmt::format("{}[{}]", probe.name, unit));
        else
            for (const char axis : {'x', 'y', 'z'}) names.push_back(fmt::format("{}_{}[{}]", probe.name, axis, unit));
    }
    return names;
}

std::vector<double> probe_values(const Communicator& comm, std::span<const RodGroup> groups, const Rods& rods,
                                 double lag, std::span<const ProbeSpec> probes) {
    if (probes.empty()) return {};
    std::vector<std::vector<double>> columns; // one term each, on the rank that owns the rod
    for (const ProbeSpec& probe : probes) {
        if (probe.of_fluid()) continue;
        const std::size_t first = columns.size();
        columns.resize(first + (probe.strained() ? 1 : 3));
        const Copy copy = probe.strained() ? Copy::strained : Copy::frames;
        const std::vector<std::size_t> own_rods = own_of(probe, groups, rods);
        rods.read(own_rods, copy, lag, [&](int, std::size_t i, const RodCopy& one) {
            const LocalRod& local = rods.local()[own_rods[i]];
            Vec3d value;
            with_rod(nth(groups, local.group), local.index, [&](const RodGroup& own) {
                value = own.strained() ? of_rod(probe.quantity, one, probe_place(own, probe.at))
                                       : of_body(probe.quantity, one);
            });
            columns[first].push_back(value.x);
            if (probe.strained()) return;
            columns[first + 1].push_back(value.y);
            columns[first + 2].push_back(value.z);
        });
    }
    return exact_sums(comm, columns);
}

} // namespace skein
