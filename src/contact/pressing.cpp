#include "contact/pressing.hpp"

#include "placement/packing.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

constexpr double coordination = 6; // contacts per rod of a bed at rest: isostatic with friction 4, without 10
constexpr double densest = 0.6, crowded = 5.4; // phi of short rods; phi L/d of long ones
constexpr double sideways = 0.5;               // pressure at the sides over that from above, of a bed at rest
constexpr double euler = 0.5772156649015329;
constexpr std::int64_t looked_at = 1 << 16; // rods of a group whose places tell how far it reaches
constexpr std::size_t most_cells = 1024;    // in one direction

double volume(const RodGroup& group) {
    double sum = 0;
    for (const ElementConstants& c : group.element) sum += c.volume;
    return sum;
}

/// Sums over all rods of a scene.
struct Assembly {
    double rods = 0, volume = 0, diameter = 0; ///< the last: mean by volume, m
    Vec3d weight{0, 0, 0};                     ///< N
    double heaviest = 0;                       ///< weight of the heaviest rod, N
    double length() const { return volume / rods / (0.25 * M_PI * diameter * diameter); }
};

Assembly assemble(std::span<const RodGroup> groups, std::span<const Vec3d> gravity) {
    Assembly a;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        for_each_kind(groups[g], [&](const RodGroup& kind, double count) {
            const double of_rod = volume(kind);
            const Vec3d weight = kind.spec().material.density * of_rod * gravity[g];
            a.rods += count;
            a.volume += count * of_rod;
            a.diameter += count * of_rod * mean_diameter(kind);
            a.weight = a.weight + count * weight;
            a.heaviest = std::max(a.heaviest, norm(weight));
        });
    }
    a.diameter /= a.volume;
    return a;
}

/// Smallest and largest coordinate along a direction.
struct Extent {
    double least = HUGE_VAL, most = -HUGE_VAL;
    double size() const { return most - least; }
    void take(double x) {
        least = std::min(least, x);
        most = std::max(most, x);
    }
};

/// Pressure at the foot of the heaviest column, Pa: columns as wide as rods are long, and none wider than the
/// assembly's shadow.
double pressure_of_weight(std::span<const RodGroup> groups, std::span<const Vec3d> gravity, const Assembly& all) {
    const double whole = norm(all.weight);
    if (!(whole > 0)) return 0;
    const Vec3d down = (1 / whole) * all.weight;
    const auto [u, v] = directions_across(down);

    struct Place {
        double u, v, weight;
    };
    std::vector<Place> places;
    std::vector<Capsule> elements;
    Extent along_u, along_v;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const RodGroup& group = groups[g];
        const std::int64_t stride = group.count() / looked_at + 1;
        const double of_all = volume(group);
        for (std::int64_t i = 0; i < group.count(); i += stride) {
            elements.clear();
            group.append_capsules(i, elements);
            for (const Capsule& c : elements)
                for (const Vec3d& end : {c.start, c.end}) {
                    along_u.take(dot(end, u));
                    along_v.take(dot(end, v));
                }
            const auto stands_for = static_cast<double>(std::min(stride, group.count() - i));
            const double of_rod = group.heterogeneous() ? volume(group.single(i)) : of_all,
                         weight = dot(group.spec().material.density * of_rod * gravity[g], down);
            const Vec3d centre = group.centre(i);
            places.push_back({dot(centre, u), dot(centre, v), stands_for * weight});
        }
    }
    for (Extent* extent : {&along_u, &along_v}) extent->most = std::max(extent->most, extent->least + all.diameter);
    const auto cells = [&](const Extent& extent) {
        return std::clamp<std::size_t>(static_cast<std::size_t>(extent.size() / all.length() + 1e-6), 1, most_cells);
    };
    const std::size_t columns = cells(along_u), rows = cells(along_v);
    const auto cell = [](const Extent& extent, double x, std::size_t count) {
        const double share = (x - extent.least) / extent.size();
        return std::min(static_cast<std::size_t>(std::max(0.0, share) * static_cast<double>(count)), count - 1);
    };
    std::vector<double> weights(columns * rows);
    for (const Place& p : places) weights[cell(along_v, p.v, rows) * columns + cell(along_u, p.u, columns)] += p.weight;
    return *std::max_element(weights.begin(), weights.end()) * static_cast<double>(columns * rows) /
           (along_u.size() * along_v.size());
}

} // namespace

double mean_diameter(const RodGroup& group) {
    double sum = 0, elements = 0;
    for_each_kind(group, [&](const RodGroup& kind, double) {
        for (const ElementConstants& c : kind.element) sum += 2 * c.radius;
        elements += kind.elements();
    });
    return sum / elements;
}

Pressing pressing(std::span<const RodGroup> groups, std::span<const Vec3d> gravity, double pressure, double area) {
    const Assembly all = assemble(groups, gravity);
    const double of_weight = pressure_of_weight(groups, gravity, all), most = std::max(of_weight, pressure);
    if (!(most > 0)) return {};
    const double mean_pressure = (1 + 2 * sideways) / 3 * most,
                 fill = std::min(densest, crowded * all.diameter / all.length());
    const double mean = 6 * mean_pressure * (all.volume / all.rods) / (coordination * fill * all.diameter);
    const double largest = mean * (std::log(0.5 * coordination * all.rods) + euler);
    const double whole = norm(all.weight) + pressure * area;
    return {std::clamp(largest, std::min(all.heaviest, whole), whole), pressure > of_weight};
}

double overlap_under(const ContactLaw& law, double force) {
    const double ratio = force / law.stiffness;
    return law.normal == ContactNormal::linear ? ratio : std::cbrt(ratio * ratio);
}

double stiffness_for(ContactNormal normal, double force, double overlap) {
    return force / (normal == ContactNormal::linear ? overlap : overlap * std::sqrt(overlap));
}

double own_force(double youngs_modulus, double radius, double overlap) {
    return 8.0 / 9.0 * youngs_modulus * std::sqrt(radius) * overlap *
           std::sqrt(overlap); // 4/3 E* with nu = 1/2 in both
}

} // namespace skein
