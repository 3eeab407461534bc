#include "physics/contact/contact_plan.hpp"

#include "coupling/interaction.hpp"
#include "joints/joint_list.hpp"
#include "loads/gravity.hpp"
#include "neighbourhood/exposure.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "physics/contact/laws_of_group.hpp"
#include "physics/plan_input.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

/// The [[contact_pair]] of two groups; null: they have none.
const ContactPair* pair_of(std::span<const ContactPair> pairs, const std::string& a, const std::string& b) {
    for (const ContactPair& pair : pairs)
        if ((pair.between[0] == a && pair.between[1] == b) || (pair.between[0] == b && pair.between[1] == a))
            return &pair;
    return nullptr;
}

/// Law between two groups: that of their pair, or the common one.
const ContactLaw& law_between(const SceneSpec& scene, const std::string& a, const std::string& b) {
    const ContactPair* const pair = pair_of(scene.contact_pairs, a, b);
    return pair ? pair->law : scene.contact->law;
}

ContactLaws contact_laws(const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::vector<ContactLaw> laws;
    for (const RodGroup& a : groups)
        for (const RodGroup& b : groups)
            laws.push_back(law_between(scene, a.name(), b.name()).resolved(reduced_mass(a, b)));
    const bool alike = scene.contact_pairs.empty() && scene.contact->law.restitution == 0;
    return alike ? ContactLaws(laws.front()) : ContactLaws(groups.size(), std::move(laws));
}

/// Slip that friction without memory turns round within a step.
void find_trembling(const std::string& where, const ContactLaw& law, double force, double least,
                    std::vector<std::string>& found) {
    if (law.slip_speed >= least) return;
    found.push_back(
        fmt::format("{}: {} friction is too steep for the step under the {:.3g} N that are expected: slip trembles; "
                    "slip_speed = {:.2g} would do, or a shorter step",
                    where, nth(contact_friction_names, law.friction), force, least));
}

/// Friction without memory whose slip speed is too low for the step under the forces that are expected. `laws`: null
/// where rods do not feel each other; `pairs`: groups with laws of their own.
std::vector<std::string> slip_doubts(const ContactEstimate& estimate, const ContactLaws* laws,
                                     std::span<const ContactPair> pairs, std::span<const Wall> walls,
                                     std::span<const RodGroup> groups, double dt) {
    std::vector<std::string> found;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const ContactMobility mobility = contact_mobility(groups[g]);
        const auto look = [&](const std::string& where, const ContactLaw& law, int bodies) {
            find_trembling(where, law, estimate.force, least_slip_speed(mobility, law, estimate.force, bodies, dt),
                           found);
        };
        if (laws) look(fmt::format("contact of '{}'", groups[g].name()), laws->between(g, g), 2);
        for (std::size_t other = 0; laws && other < groups.size(); ++other)
            if (other != g && pair_of(pairs, groups[g].name(), groups[other].name()))
                look(fmt::format("contact of '{}' with '{}'", groups[g].name(), groups[other].name()),
                     laws->between(g, other), 2);
        for (const Wall& wall : walls)
            if (wall.acts_on(groups[g].name()))
                look(fmt::format("wall '{}' and '{}'", wall.name, groups[g].name()), wall.law, 1);
    }
    return found;
}

/// Overlap expected where something presses, and the stiffness that would hold it where that is too far. `only_law`: of
/// all contacts.
std::string overlap_text(const ContactEstimate& estimate, const ContactLaw& law, bool only_law, double assumed) {
    if (estimate.force == 0)
        return fmt::format("neither weight nor a lid presses; the step allows for up to {:g} of the diameter", assumed);
    std::string text =
        fmt::format("{:.2g} of the diameter expected under {:.3g} N ({}); the step allows for up to {:g}",
                    estimate.overlap, estimate.force, estimate.by, assumed);
    const double ratio = estimate.overlap / assumed, power = law.normal == ContactNormal::linear ? 1 : 1.5;
    if (ratio <= 1) return text;
    const double times = std::pow(ratio, power);
    if (only_law && law.restitution == 0)
        text += fmt::format(", which stiffness = {:.2g} would hold", times * law.stiffness);
    else text += fmt::format(", which {:.2g} times the stiffness would hold", times);
    return text;
}

/// Gravity that acts on all rods, if that is all there is.
std::optional<Vec3d> gravity_of(const LoadTables& tables) {
    std::optional<Vec3d> gravity;
    int found = 0;
    for (const LoadSpec& l : tables.loads)
        if (const auto* one = l.load.get_if<Gravity>(); one && ++found == 1 && l.rods.empty())
            gravity = one->acceleration;
    return found > 1 ? std::nullopt : gravity;
}

/// Places of joints, where rods of one copy touch each other; else null.
std::shared_ptr<const JoinedGaps> joined_gaps(const SceneSpec& scene, std::span<const RodGroup> groups) {
    if (!scene.contact->joined) return nullptr;
    auto gaps = std::make_shared<JoinedGaps>(groups, scene.contact->self_gap);
    for (const AssemblyGroups& of : assemblies_of(groups))
        for (const Joint& joint : joints_of(scene.joints, groups, of.assembly)) {
            if (joint.second.of_world()) continue;
            const auto place = [](const JointEnd& end) {
                return JoinedPlace{end.group, end.rod, end.element, end.share, end.arm};
            };
            gaps->add(place(joint.first), place(joint.second));
        }
    gaps->settle();
    return gaps;
}

/// Estimates, limits and doubts for rods that may touch each other or walls.
class PlannedTouch final : public PhysicsPlan, public TouchPlan {
public:
    PlannedTouch(const PlanInput& input, const std::optional<ContactLaws>& laws)
        : contact_(input.scene), walls_(input.scene), expanded_(expanded(input.scene.walls)), laws_(laws) {
        const ContactLaws* between = laws_ ? &*laws_ : nullptr;
        estimate = contact_estimate(input.scene, between, input.groups);
        speeds = speed_estimate(input.scene, between, input.groups);
        gravity = gravity_of(input.scene);
        for (const RodGroup& group : input.groups)
            for_each_kind(group, [&](const RodGroup& kind, double count) {
                const double of_kind = count * std::accumulate(kind.node_mass.begin(), kind.node_mass.end(), 0.0);
                mass += of_kind;
                mass_radius += of_kind * kind.element.front().radius;
            });
    }

    /// The contact that leaves the shortest step, among all that a group may have.
    void add_limits(GroupPlan& p, const RodGroup& group) const override {
        TimeLimit least{"contact", HUGE_VAL, 0};
        with_contact_laws(contact_, walls_, group, [&](const ContactLaw& law, double share, double mass) {
            const TimeLimit limit = contact_time_limit(group, law.resolved(mass), share);
            if (limit.dt < least.dt) least = limit;
        });
        if (!std::isfinite(least.dt)) return;
        if (!group.strained()) p.limits.clear();
        p.limits.push_back(least);
        std::stable_sort(p.limits.begin(), p.limits.end(),
                         [](const TimeLimit& a, const TimeLimit& b) { return a.dt < b.dt; });
    }
    double longest_step() const override { return speeds.longest_step(); }

    std::vector<PlanLine> describe(const Plan& p) const override {
        if (!p.automatic_dt || p.pseudo_time || !(p.dt > 0.5 * speeds.longest_step())) return {};
        const Meeting& fastest = speeds.fastest;
        return {{"speeds",
                 fmt::format("{} may meet at {:.3g} m/s, {:.3g} of the diameter in a step; {:g} is allowed for",
                             fastest.who, fastest.speed, fastest.speed * p.dt / fastest.diameter, fastest.allowed),
                 "",
                 {}}};
    }
    std::vector<std::string> notes(const Plan& p, std::span<const RodGroup> groups) const override {
        std::vector<std::string> all;
        if (!p.pseudo_time) {
            all = speeds.doubts;
            for (std::string& doubt : speeds.doubts_of_step(p.dt)) all.push_back(std::move(doubt));
        }
        for (std::string& doubt :
             slip_doubts(estimate, laws_ ? &*laws_ : nullptr, contact_.contact_pairs, expanded_, groups, p.dt))
            all.push_back(std::move(doubt));
        return all;
    }

private:
    ContactTables contact_;
    WallTables walls_;
    std::vector<Wall> expanded_;
    std::optional<ContactLaws> laws_;
};

class PlannedContact final : public PhysicsPlan, public ContactPlan, public StartsInteraction {
public:
    PlannedContact(const PlanInput& input, const ContactLaws& by_pair)
        : ContactPlan{*input.scene.contact, by_pair, input.as_written.contact->law.stiffness_is_automatic(),
                      joined_gaps(input.scene, input.groups)},
          copies_(!assemblies_of(input.groups).empty()) {}

    std::string summary(const Plan&) const override { return "contact"; }
    std::vector<PlanLine> describe(const Plan& p) const override {
        const ContactEstimate& expected = estimate(p);
        const std::string ghosts =
            p.machine.ranks > 1 ? fmt::format("ghosts, {} B each; ", Exposure::sent_numbers_per_slot * sizeof(double))
                                : "";
        return {{"contact",
                 law_text(spec.law) + (automatic_stiffness ? " (auto)" : "") +
                     (spec.self ? ", of rods with themselves too" : "") +
                     (!copies_      ? ""
                      : spec.joined ? ", of joined rods too"
                                    : ", not of joined rods"),
                 "contact",
                 {}},
                {"  overlap",
                 overlap_text(expected, spec.law, laws.materials() == 1, spec.overlap),
                 "contact_estimate",
                 {{"stiffness", spec.law.stiffness},
                  {"automatic", automatic_stiffness},
                  {"force_N", expected.force},
                  {"by", expected.by},
                  {"expected_overlap", expected.overlap},
                  {"overlap_of_step", spec.overlap}}},
                {"  cost", fmt::format("{}{:g} ns an element", ghosts, ns_per_element()), "", {}}};
    }
    std::vector<std::string> notes(const Plan& p, std::span<const RodGroup>) const override {
        if (!(estimate(p).overlap > spec.overlap)) return {};
        return {"contact: overlap of " + overlap_text(estimate(p), spec.law, laws.materials() == 1, spec.overlap)};
    }
    bool acts_between_rods() const override { return true; }
    Coupling coupling() const override { return Coupling::every_step; }
    /// Median of bench/scenes/nest: contacts at its density, half a candidate per element, with their exposure.
    double ns_per_element() const override { return 40; }

    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return std::make_unique<ContactInteraction>(parts, *this);
    }

private:
    static const ContactEstimate& estimate(const Plan& p) { return p.find<TouchPlan>()->estimate; }
    bool copies_; ///< some rods are joined, or copied together
};

} // namespace

std::string law_text(const ContactLaw& law) {
    std::string text = fmt::format("{} {:.4g}", nth(contact_normal_names, law.normal), law.stiffness);
    if (law.restitution > 0)
        text = fmt::format("{}, restitution {:g} in {:g} s", nth(contact_normal_names, law.normal), law.restitution,
                           law.collision_time);
    else if (law.damping > 0) text += fmt::format(", dashpot {:.4g}", law.damping);
    if (law.friction != ContactFriction::none)
        text += fmt::format(", friction {} {:g} / {:g}", nth(contact_friction_names, law.friction), law.static_friction,
                            law.kinetic());
    if (law.friction == ContactFriction::anisotropic)
        text += fmt::format(" / {:g} / {:g}", law.kinetic_backward, law.kinetic_sideways);
    if (law.soft_until > 0) text += fmt::format(", soft until {:g} s", law.soft_until);
    if (law.friction_from > 0) text += fmt::format(", friction from {:g} s", law.friction_from);
    return text;
}

void ContactTables::resolve(SceneSpec& scene, std::span<const RodGroup> groups) {
    scene = with_stiffnesses(std::move(scene), groups);
}

bool ContactTables::needs_all_rods(const SceneSpec& scene) { return scene.contact || !scene.walls.empty(); }

void ContactTables::plan(const PlanInput& input, PlannedPhysics& out) {
    const SceneSpec& scene = input.scene;
    if (!scene.contact && scene.walls.empty()) return;
    std::optional<ContactLaws> laws;
    if (scene.contact) laws = contact_laws(scene, input.groups);
    out.add<PlannedTouch>(input, laws);
    if (!scene.contact) return;
    out.add<PlannedContact>(input, *laws);
}

} // namespace skein
