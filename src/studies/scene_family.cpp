#include "studies/scene_family.hpp"

#include "kernels/kernels.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/walls/wall_plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_number.hpp"

#include <fmt/format.h>

namespace skein {

void refuse_unsolvable(const SceneSpec& scene) {
    if (scene.rods.empty()) throw InputError("the scene has no rods or bodies to solve for");
    if (scene.fluid && scene.immersion.coupling == RodCoupling::two_way)
        throw InputError("the scene has a [fluid], and its forces on rods at rest are a flow problem: run the scene "
                         "instead, or remove [fluid]; immersion.coupling = \"one_way\" leaves the forces out");
    if (!scene.stages.empty())
        throw InputError("the scene has [[stage]] tables, and a state at rest belongs to one of them: write the loads "
                         "of that stage into the scene and leave the tables out");
    for (const auto& load : scene.loads)
        if (load.load.acts_last())
            throw InputError(fmt::format("a load '{}' answers all other loads and holds bodies in many places, so "
                                         "that no equilibrium can be solved for: run the scene to rest",
                                         load.load.kind()));
    for (const JointSpec& joint : scene.joints)
        if (joint.events.from > 0)
            throw InputError(
                "a joint with 'from' is made where its bodies are at that time, which a state at rest does "
                "not know: leave 'from' out, or run the scene");
    for (const Wall& wall : scene.walls)
        if (wall.law.friction != ContactFriction::none && (wall.moves_steadily() || wall.servo.drives()))
            throw InputError("a wall that moves with friction drags bodies along, so that none is at rest: run the "
                             "scene, or give the wall friction = \"none\"");
}

bool has_friction(const SceneSpec& scene, bool (*holds)(ContactFriction)) {
    const auto rubs = [&](const ContactLaw& law) { return holds(law.friction); };
    const auto has_rubbing_law = [&](const auto& one) { return rubs(one.law); };
    return (scene.contact && rubs(scene.contact->law)) ||
           std::any_of(scene.contact_pairs.begin(), scene.contact_pairs.end(), has_rubbing_law) ||
           std::any_of(scene.walls.begin(), scene.walls.end(), has_rubbing_law);
}

std::unique_ptr<StaticSystem> make_static_system(const Plan& plan, std::span<const RodGroup> groups,
                                                 std::span<const LocalRod> rods, std::shared_ptr<Walls> walls,
                                                 const Threads& threads, const Communicator* ranks) {
    std::unique_ptr<StaticContacts> contacts;
    if (const auto* contact = plan.find<ContactPlan>())
        contacts = kernels(plan.machine.lanes).make_static_contacts(contact->scene(groups), groups, rods, threads);
    return std::make_unique<StaticSystem>(groups, rods, make_static_rods(plan, groups, rods, std::move(walls)),
                                          std::move(contacts), ranks);
}

std::unique_ptr<StaticCase> static_case(const SceneText& text, const Machine& machine, double time) {
    SceneSpec scene = parse_scene(text.file, text.text, text.overrides);
    refuse_unsolvable(scene);
    return static_case(std::move(scene), machine, time);
}

std::unique_ptr<StaticCase> static_case(SceneSpec scene, const Machine& machine, double time) {
    auto made = std::make_unique<StaticCase>();
    made->scene = std::move(scene);
    made->scene.time.dt = 0; // no step is made
    made->groups = make_whole_groups(made->scene);
    made->plan = make_plan(made->scene, made->groups, machine);
    for (const RodGroup& group : made->groups)
        for (std::int64_t i = 0; i < group.count(); ++i) made->rods.push_back({group.first_gid() + i, group.id(), i});
    std::shared_ptr<Walls> walls;
    if (const auto* plan = made->plan.find<WallPlan>()) walls = std::make_shared<Walls>(plan->walls);
    made->threads = std::make_unique<Threads>(machine.threads);
    made->system = make_static_system(made->plan, made->groups, made->rods, std::move(walls), *made->threads);
    made->system->hold_at(start_of(*made->system, made->groups, made->rods));
    made->system->set_time(time);
    return made;
}

StaticCase& SceneFamily::case_at(double value) {
    if (now_ && value == value_) return *now_;
    if (now_) with_number(now_->scene, key_, value); // which refuses what is no number
    SceneText own = text_;
    own.overrides.push_back(fmt::format("{}={:.17g}", key_, value));
    now_ = static_case(own, machine_, time_);
    value_ = value;
    return *now_;
}

} // namespace skein
