// Plan of rotary inertia by "auto": what it has chosen, or what it would gain.
#include "physics/plan_input.hpp"
#include "physics/rods/rod_tables.hpp"
#include "physics/rods/rotary_inertia.hpp"
#include "physics/table_objections.hpp"
#include "plan/plan.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace skein {

namespace {

constexpr const char* inertia_key = "material.rotary_inertia_for_dt";
constexpr const char* without_auto = "leave the key out, or give a step as a number if only slow bending counts";

class PlannedRotaryInertia final : public PhysicsPlan {
public:
    explicit PlannedRotaryInertia(const SceneSpec& scene) : scene_(scene) {}

    void act_on(GroupPlan& p, const RodGroup& group) const override {
        const RodSpec& rods = group.spec();
        if (!group.strained() || !rods.material.inertia_chosen) return;
        const auto refuse = [&](const std::string& why) {
            throw InputError(fmt::format("{}: {} = \"auto\" of '{}': {}; {}", rods.source, inertia_key, rods.name, why,
                                         without_auto));
        };
        if (group.heterogeneous()) return; // each rod has its own
        p.automatic_inertia = automatic_inertia(scene_, rods);
        if (const std::string why = driven_beyond(scene_, rods, *p.automatic_inertia); !why.empty()) refuse(why);
    }
    std::vector<std::string> notes(const Plan& plan, std::span<const RodGroup> groups) const override {
        std::vector<std::string> notes;
        for (const GroupPlan& p : plan.groups)
            if (p.automatic_inertia) notes.push_back(fmt::format("'{}': {}", p.name, text_of(*p.automatic_inertia)));
        if (plan.pseudo_time || !plan.automatic_dt) return notes;
        if (std::string hint = possible_gain(plan, groups); !hint.empty()) notes.push_back(std::move(hint));
        return notes;
    }

private:
    static std::string text_of(const AutomaticInertia& chosen) {
        const std::string right =
            chosen.highest > 0
                ? fmt::format("bending is right to 1 % up to mode {} and {:.4g} Hz", chosen.highest, chosen.frequency)
                : fmt::format("bending is right to 1 % up to {:.4g} Hz, below its lowest mode", chosen.frequency);
        if (chosen.dt == 0)
            return fmt::format("rotary inertia does not limit its step, and \"auto\" adds none; {}", right);
        return fmt::format("rotary inertia allows steps {:.3g} times longer; the two lowest bending modes change by at "
                           "most {:.2g} of the error of its elements; {}",
                           chosen.gain, chosen.share, right);
    }
    static double other_limit(const GroupPlan& p) {
        double least = HUGE_VAL;
        for (const TimeLimit& limit : p.limits)
            if (!limit.mode.starts_with("shear-rotation")) least = std::min(least, limit.dt);
        return least;
    }
    /// Limit of the step with what "auto" would choose, s; as it is where that is refused, or given otherwise.
    double longer_limit(const GroupPlan& p, const RodGroup& group) const {
        const double now = p.limits.front().dt;
        const Material& material = group.spec().material;
        if (!group.strained() || group.heterogeneous() || material.inertia_chosen) return now;
        if (material.rotary_inertia_for_dt != 0 || material.rotary_inertia_scale != 1) return now;
        if (!(other_limit(p) > least_gain * now) || !rotary_inertia_matters(scene_, group.spec()).empty()) return now;
        const AutomaticInertia chosen = automatic_inertia(scene_, group.spec());
        if (chosen.dt == 0 || !driven_beyond(scene_, group.spec(), chosen).empty()) return now;
        return std::min(other_limit(p), chosen.gain * now);
    }
    /// Gain of the step, in words, if all groups took "auto" where they can, from the slowest on; empty: too little.
    std::string possible_gain(const Plan& plan, std::span<const RodGroup> groups) const {
        if (is_implicit(plan.integrator)) return "";
        std::vector<std::size_t> order(groups.size());
        std::iota(order.begin(), order.end(), 0);
        const auto limit = [&](std::size_t g) { return plan.groups[g].limits.front().dt; };
        std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return limit(a) < limit(b); });
        double longest = HUGE_VAL;
        std::vector<std::string> lifted;
        for (const std::size_t g : order) {
            if (limit(g) >= longest) break;
            const double longer = longer_limit(plan.groups[g], groups[g]);
            longest = std::min(longest, longer);
            if (longest <= least_gain * limit(order.front())) return "";
            if (longer > limit(g)) lifted.push_back("'" + plan.groups[g].name + "'");
        }
        if (lifted.empty()) return "";
        return fmt::format("{} = \"auto\" of {} would take steps {:.3g} times longer, and change slow bending by less "
                           "than a fifth of the error of the elements",
                           inertia_key, fmt::join(lifted, ", "), longest / limit(order.front()));
    }

    static constexpr double least_gain = 2; ///< worth a line
    const SceneSpec scene_;
};

} // namespace

bool RodTables::look_at_whole_rods(const SceneSpec&, const RodSpec& rods) {
    return rods.section.kind != SectionKind::circular || rods.material.law == Law::elastica || rods.shape.closed ||
           rods.ends_move() || rods.ends_slide() || rods.hold.any() || rods.material.chooses_inertia();
}

void RodTables::check(const SceneSpec& scene, Objections& objections) {
    for (std::size_t g = 0; g < scene.rods.size(); ++g) {
        const RodSpec& rods = scene.rods[g];
        if (rods.body || !rods.material.chooses_inertia()) continue;
        if (const std::string why = rotary_inertia_matters(scene, rods); !why.empty())
            TableObjections(objections, path_of_group(scene, g))
                .add(inertia_key, fmt::format("\"auto\" is not for '{}': {}, so that rotary inertia counts; {}",
                                              rods.name, why, without_auto));
    }
}

void RodTables::plan(const PlanInput& input, PlannedPhysics& out) {
    const auto strained = [](const RodGroup& group) { return group.strained(); };
    if (std::any_of(input.groups.begin(), input.groups.end(), strained)) out.add<PlannedRotaryInertia>(input.scene);
}

void RodTables::resolve(SceneSpec& scene, std::span<const RodGroup> groups) {
    for (std::size_t g = 0; g < scene.rods.size(); ++g) {
        Material& material = scene.rods[g].material;
        if (material.rotary_inertia_for_dt != Material::automatic_inertia) continue;
        material.rotary_inertia_for_dt = groups[g].spec().material.rotary_inertia_for_dt;
        material.inertia_chosen = true;
    }
}

} // namespace skein
