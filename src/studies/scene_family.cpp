#include "studies/scene_family.hpp"

#include "kernels/kernels.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/walls/wall_plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

namespace skein {

void refuse_unsolvable(const SceneSpec& scene) {
    if (scene.rods.empty()) throw InputError("the scene has no rods or bodies to solve for");
    if (scene.fluid && scene.immersion.coupling == RodCoupling::two_way)
        throw InputError("the scene has a [fluid], and its forces on rods at rest are a flow problem: run the scene "
                         "instead, or remove [fluid]; immersion.coupling = \"one_way\" leaves the forces out");
}

std::unique_ptr<StaticCase> static_case(const SceneText& text, const Machine& machine, double time) {
    auto made = std::make_unique<StaticCase>();
    made->scene = parse_scene(text.file, text.text, text.overrides);
    refuse_unsolvable(made->scene);
    made->scene.time.dt = 0; // no step is made
    made->groups = make_whole_groups(made->scene);
    made->plan = make_plan(made->scene, made->groups, machine);
    for (const RodGroup& group : made->groups)
        for (std::int64_t i = 0; i < group.count(); ++i) made->rods.push_back({group.first_gid() + i, group.id(), i});
    std::shared_ptr<Walls> walls;
    if (const auto* plan = made->plan.find<WallPlan>()) walls = std::make_shared<Walls>(plan->walls);
    made->threads = std::make_unique<Threads>(machine.threads);
    std::unique_ptr<StaticContacts> contacts;
    if (const auto* contact = made->plan.find<ContactPlan>())
        contacts = kernels(machine.lanes)
                       .make_static_contacts(contact->scene(made->groups), made->groups, made->rods, *made->threads);
    made->system = std::make_unique<StaticSystem>(
        made->groups, made->rods, make_static_rods(made->plan, made->groups, made->rods, std::move(walls)),
        std::move(contacts));
    made->system->set_time(time);
    return made;
}

StaticCase& SceneFamily::case_at(double value) {
    if (now_ && value == value_) return *now_;
    SceneText own = text_;
    own.overrides.push_back(fmt::format("{}={:.17g}", key_, value));
    now_ = static_case(own, machine_, time_);
    value_ = value;
    return *now_;
}

} // namespace skein
