#include "physics/contact/contact_estimate.hpp"

#include "contact/contact_limits.hpp"
#include "contact/pressing.hpp"
#include "loads/gravity.hpp"
#include "physics/group_names.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

Pressing pressing_of(const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::vector<Vec3d> gravity(groups.size(), Vec3d{0, 0, 0});
    for (const LoadSpec& load : scene.loads)
        if (const auto* g = load.load.get_if<Gravity>())
            for (std::size_t i = 0; i < groups.size(); ++i)
                if (names_group(load.rods, groups[i].name())) gravity[i] = gravity[i] + g->acceleration;
    double pressure = 0, area = 0;
    for (const Wall& wall : scene.walls)
        if (wall.servo.drives() && wall.servo.turn_back_above > pressure) {
            pressure = wall.servo.turn_back_above;
            area = wall.servo.area;
        }
    return pressing(groups, gravity, pressure, area);
}

/// Diameter of the thinnest of some groups, m.
double smaller_diameter(std::span<const RodGroup> groups, const std::vector<std::string>& names) {
    double least = HUGE_VAL;
    for (const RodGroup& group : groups)
        if (names_group(names, group.name())) least = std::min(least, mean_diameter(group));
    return least;
}

/// Finds the stiffness of laws between some groups.
class Stiffnesses {
public:
    Stiffnesses(const SceneSpec& scene, std::span<const RodGroup> groups)
        : groups_(groups), force_(pressing_of(scene, groups).force) {
        for (const RodGroup& group : groups) ends_move_ |= group.spec().ends_move();
    }

    void choose(ContactLaw& law, const std::vector<std::string>& names, const std::string& where) const {
        if (!law.stiffness_is_automatic()) return;
        const double overlap = law.accepted_overlap * smaller_diameter(groups_, names);
        const double force = force_ > 0 && !ends_move_ ? force_ : std::max(force_, softest_force(names, overlap));
        if (!(force > 0))
            throw InputError(
                where + ": stiffness = \"auto\" finds neither weight nor a lid's pressure, and rigid bodies have no "
                        "stiffness of their own: give a number");
        law.stiffness = stiffness_for(law.normal, force, overlap);
    }

private:
    /// Force with which real rods of the softest material would push at this overlap, N; 0 where all are rigid.
    double softest_force(const std::vector<std::string>& names, double overlap) const {
        double least = HUGE_VAL;
        for (const RodGroup& group : groups_)
            if (const double young = group.spec().material.youngs_modulus;
                names_group(names, group.name()) && young > 0)
                least = std::min(least, own_force(young, 0.5 * mean_diameter(group), overlap));
        return std::isfinite(least) ? least : 0;
    }

    std::span<const RodGroup> groups_;
    double force_;
    bool ends_move_ = false;
};

} // namespace

SceneSpec with_stiffnesses(SceneSpec scene, std::span<const RodGroup> groups) {
    const auto automatic = [](const auto& spec) { return spec.law.stiffness_is_automatic(); };
    if (!(scene.contact && automatic(*scene.contact)) &&
        std::none_of(scene.contact_pairs.begin(), scene.contact_pairs.end(), automatic) &&
        std::none_of(scene.walls.begin(), scene.walls.end(), automatic))
        return scene;
    const Stiffnesses stiffnesses(scene, groups);
    if (scene.contact) stiffnesses.choose(scene.contact->law, {}, scene.file + ": [contact]");
    for (ContactPair& pair : scene.contact_pairs)
        stiffnesses.choose(pair.law, pair.between, pair.source + ": [[contact_pair]]");
    for (Wall& wall : scene.walls)
        stiffnesses.choose(wall.law, wall.rods, fmt::format("{}: wall '{}'", wall.source, wall.name));
    return scene;
}

ContactEstimate contact_estimate(const SceneSpec& scene, const ContactLaws* laws, std::span<const RodGroup> groups) {
    const Pressing press = pressing_of(scene, groups);
    ContactEstimate out{.force = press.force, .by = press.force == 0 ? "" : press.of_lid ? "pressure" : "weight"};
    const auto overlap = [&](const ContactLaw& law, double diameter) {
        out.overlap = std::max(out.overlap, overlap_under(law, press.force) / diameter);
    };
    if (laws && laws->materials() == 1) overlap(laws->between(0, 0), smaller_diameter(groups, {}));
    else if (laws)
        for (std::size_t a = 0; a < groups.size(); ++a)
            for (std::size_t b = 0; b <= a; ++b)
                overlap(laws->between(a, b), std::min(mean_diameter(groups[a]), mean_diameter(groups[b])));
    for (const Wall& wall : expanded(scene.walls)) {
        double most = 0;
        for (const RodGroup& group : groups)
            if (wall.acts_on(group.name()))
                most = std::max(most, overlap_under(wall.law.resolved(mass_at_wall(group)), press.force) /
                                          mean_diameter(group));
        out.wall_overlaps.push_back(most);
    }
    return out;
}

} // namespace skein
