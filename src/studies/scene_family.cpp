#include "studies/scene_family.hpp"

#include "kernels/kernels.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/walls/wall_plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace skein {

std::unique_ptr<StaticCase> static_case(const SceneText& text, const Machine& machine, double time) {
    auto made = std::make_unique<StaticCase>();
    made->scene = parse_scene(text.file, text.text, text.overrides);
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

namespace {

using Json = nlohmann::ordered_json;

/// The member or item that part of a path means; null where there is none.
const Json* inside(const Json& at, const std::string& part) {
    if (at.is_object()) return at.contains(part) ? &at.at(part) : nullptr;
    if (!at.is_array()) return nullptr;
    if (part.find_first_not_of("0123456789") == std::string::npos) {
        const std::size_t number = std::stoul(part);
        return number < at.size() ? &at.at(number) : nullptr;
    }
    for (const Json& item : at)
        for (const char* key : {"name", "kind"})
            if (item.is_object() && item.contains(key) && item.at(key) == part) return &item;
    return nullptr;
}

} // namespace

double number_at(const SceneSpec& scene, const std::string& path) {
    const Json root = Json::parse(scene_json(scene, false));
    const Json* at = &root;
    std::size_t from = 0;
    while (at && from <= path.size()) {
        const std::size_t dot = std::min(path.find('.', from), path.size());
        at = inside(*at, path.substr(from, dot - from));
        from = dot + 1;
    }
    if (!at || !at->is_number())
        throw InputError(
            fmt::format("'{}' is no number of {}; a path such as load.0.end.2 names one: a key, the name or "
                        "number of a table, the number of a component, counted from 0",
                        path, scene.file));
    return at->get<double>();
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
