#include "scene/scene_rebuild.hpp"

#include "scene/scene_check.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_override.hpp"
#include "scene/scene_reader.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>

namespace skein {

namespace {

using Json = nlohmann::json;

/// A file of rods is known by what is in it, wherever it lies: physics has its digest, settings have its name.
constexpr const char *digest_of_file = "digest", *files_of_rods = "files_of_rods";

TomlValue tree_of(const Json& json, const Place& place) {
    if (json.is_boolean()) return {json.get<bool>(), place};
    if (json.is_number_integer()) return {json.get<std::int64_t>(), place};
    if (json.is_number()) return {json.get<double>(), place};
    if (json.is_string()) return {json.get<std::string>(), place};
    if (json.is_array()) {
        TomlArray items;
        for (const Json& item : json) items.push_back(tree_of(item, place));
        return {std::move(items), place};
    }
    TomlTable entries;
    for (const auto& [key, value] : json.items())
        if (!value.is_null()) entries.push_back({key, place, tree_of(value, place)}); // null: the key is absent
    return {std::move(entries), place};
}

Json parsed(const std::string& text, const std::string& name) {
    Json json = Json::parse(text, nullptr, false);
    if (!json.is_object()) throw InputError(name + ": the scene that it keeps cannot be read");
    return json;
}

/// "/rods/0/shape" as "rods.0.shape".
std::string dotted(std::string pointer) {
    pointer.erase(0, 1);
    std::replace(pointer.begin(), pointer.end(), '/', '.');
    return pointer;
}

/// True if a state keeps its meaning under another value of this key.
bool may_change(const KeyChange& change) {
    const std::string_view table = change.part(0), key = change.part(2);
    if (table == "rods") {
        if (key == "material") return change.parts() == 4 && change.part(3) != "law";
        const bool moved_file = key == "placement" && change.last() == "file";
        const bool ends = key.starts_with("start") || key.starts_with("end") || key == "hold"; // caught where they are
        return key == "magnetisation" || moved_file || ends;
    }
    if (table == "stage") return true;
    if (table == "bodies") return key == "density" || key == "mass";
    bool survives = true;
    for_each_list(SceneSpec{}, [&](std::string_view name, const auto& specs) {
        typename std::decay_t<decltype(specs)>::value_type spec;
        if constexpr (requires { state_survives(spec, change); })
            if (name == table) survives = state_survives(spec, change);
    });
    return survives;
}

/// A scene with one table of each kind, all defaults; `kind`: of tables that come in kinds.
Json default_tables(int kind) {
    SceneSpec scene;
    scene.start.from = "-"; // is only there where it says something
    scene.rods = {RodSpec{}, default_body()};
    for_each_table(scene, [](const char*, auto& member, bool) {
        if constexpr (is_optional_table<std::remove_cvref_t<decltype(member)>>) member.emplace();
    });
    for_each_list(scene, [&](const char*, auto& specs) {
        using Spec = typename std::decay_t<decltype(specs)>::value_type;
        if constexpr (HasKinds<Spec>) specs.push_back(Spec::of_kind(kind));
        else specs.emplace_back();
    });
    Json json = Json::parse(scene_json(scene, false));
    json["start"]["from"] = "";
    return json;
}

/// Number of the kind of a table in JSON, of a list whose tables come in kinds; else 0.
int kind_of(const std::string& list, const Json& table) {
    int number = 0;
    for_each_list(SceneSpec{}, [&](const std::string& name, const auto& specs) {
        using Spec = typename std::decay_t<decltype(specs)>::value_type;
        if constexpr (HasKinds<Spec>) {
            if (name != list) return;
            const auto kinds = Spec::kinds();
            const auto at = std::find(kinds.begin(), kinds.end(), table["kind"].template get<std::string>());
            if (at != kinds.end()) number = static_cast<int>(at - kinds.begin());
        }
    });
    return number;
}

/// Paths of the keys that a scene must give, being what it is.
class RequiredKeys : public FieldVisitor {
public:
    explicit RequiredKeys(SceneSpec scene) {
        const auto in = [&](const std::string& path, auto visit) {
            path_ = path;
            visit();
        };
        in("time", [&] { scene.time.fields(*this); });
        for_each_spec(scene, [&](const char* name, auto& spec) { in(name, [&] { spec.fields(*this); }); });
        for (std::size_t i = 0; i < scene.rods.size(); ++i)
            in(path_of_group(scene, i), [&] { scene.rods[i].fields(*this); });
        for_each_list(scene, [&](const char* name, auto& specs) {
            for (std::size_t i = 0; i < specs.size(); ++i)
                in(fmt::format("{}.{}", name, i), [&] { specs[i].fields(*this); });
        });
    }
    bool contains(const std::string& path) const { return paths_.contains(path); }

    void visit(const Field& f, double&) override { add(f); }
    void visit(const Field& f, long&) override { add(f); }
    void visit(const Field& f, bool&) override { add(f); }
    void visit(const Field& f, std::string&) override { add(f); }
    void visit(const Field& f, Vec3d&) override { add(f); }
    void visit(const Field& f, std::vector<double>&) override { add(f); }
    void visit(const Field& f, std::vector<long>&) override { add(f); }
    void visit(const Field& f, std::vector<Vec3d>&) override { add(f); }
    void visit(const Field& f, std::vector<std::string>&) override { add(f); }
    void visit_choice(const Field& f, int&, std::span<const std::string_view>) override { add(f); }
    bool enter(const Field& f) override {
        path_ += "." + std::string(f.name);
        return true;
    }
    void leave() override { path_.erase(path_.rfind('.')); }

private:
    void add(const Field& f) {
        if (f.required) paths_.insert(path_ + "." + std::string(f.name));
    }
    std::string path_;
    std::set<std::string> paths_;
};

/// Leaves what a scene file has to say: keys without their defaults, which need not be values that a scene may give.
class Pruner {
public:
    explicit Pruner(const SceneSpec& scene) : required_(scene) {}
    void prune(Json& scene) {
        for (const auto& [name, value] : scene.items()) {
            if (value.is_object()) table(value, tables(0)[name], name);
            if (!value.is_array()) continue;
            for (std::size_t i = 0; i < value.size(); ++i) {
                table(value[i], tables(kind_of(name, value[i]))[name][0], fmt::format("{}.{}", name, i));
            }
        }
    }

private:
    Json& tables(int kind) {
        if (const auto found = tables_.find(kind); found != tables_.end()) return found->second;
        return tables_[kind] = default_tables(kind);
    }
    /// Returns whether it differs from the default.
    bool table(Json& json, const Json& standard, const std::string& path) {
        std::vector<std::string> same;
        bool differs = false;
        for (const auto& [key, value] : json.items()) {
            const std::string inner = path + "." + key;
            const Json known = standard.contains(key) ? standard[key] : Json();
            const bool changed = value.is_object() ? table(value, known, inner) : value != known;
            differs = differs || changed;
            if (!changed && !required_.contains(inner)) same.push_back(key);
        }
        for (const std::string& key : same) json.erase(key);
        return differs;
    }
    RequiredKeys required_;
    std::map<int, Json> tables_; ///< by kind
};

/// Physics and settings in one, with the step as a number; "file" is no key of a scene.
Json whole(const std::string& physics, const std::string& settings, const std::string& name) {
    Json scene = parsed(physics, name);
    const Json dt = scene["time"]["dt"];
    scene.update(parsed(settings.empty() ? "{}" : settings, name));
    scene["time"]["dt"] = dt;
    const Json files = scene.value(files_of_rods, Json::object());
    scene.erase(files_of_rods);
    for (Json& rods : scene["rods"]) {
        Json& placement = rods["placement"];
        placement.erase(digest_of_file);
        if (const auto file = files.find(rods["name"].get<std::string>()); file != files.end())
            placement["file"] = *file;
    }
    return scene;
}

SceneSpec scene_of(Json scene, const std::string& name, const std::vector<std::string>& overrides) {
    const std::string file = scene.value("file", "");
    scene.erase("file");
    Problems defaults; // that no scene may give
    const Place place{std::make_shared<SourceText>(SourceText{name, {}})};
    Pruner(read_tables(tree_of(scene, place), defaults)).prune(scene);
    TomlValue root = tree_of(scene, place);
    // Keys at their defaults that the scene had to set: a rate of 0 is no absent one.
    Problems none;
    const std::set<std::string> needed = needed_keys(read_tables(root, none));
    for (const std::string& override : overrides) apply_override(root, override);
    Problems problems;
    SceneSpec spec = read_tables(root, problems);
    problems.raise();
    spec.file = file;
    std::set<std::string> given = given_keys(root);
    given.insert(needed.begin(), needed.end());
    // The step that a run has had, also of scenes that may give none.
    if (std::none_of(overrides.begin(), overrides.end(), [](const auto& o) { return o.starts_with("time.dt="); }))
        given.erase("time.dt");
    refuse_contradictions(spec, given);
    return spec;
}

/// A scene without its physics: title, times and outputs.
SceneSpec without_physics(SceneSpec scene) {
    scene.rods.clear();
    scene.constants.clear();
    scene.start = {};
    for_each_table(scene, [](const char*, auto& member, bool) { member = {}; });
    for_each_list(scene, [](const char*, auto& specs) {
        if (decides_state<typename std::decay_t<decltype(specs)>::value_type>) specs.clear();
    });
    return scene;
}

} // namespace

std::string physics_json(SceneSpec scene, std::span<const RodGroup> groups, double dt) {
    scene.time = {.dt = dt, .integrator = scene.time.integrator, .damping = scene.time.damping};
    const std::string text = scene_json(scene, true);
    const auto in_file = [](const RodGroup& group) { return group.places().from_file(); };
    if (std::none_of(groups.begin(), groups.end(), in_file)) return text;
    Json json = Json::parse(text);
    for (std::size_t g = 0, number = 0; g < groups.size(); number += groups[g++].strained()) {
        if (!in_file(groups[g])) continue; // bodies never are
        Json& placement = json["rods"][number]["placement"];
        placement["file"] = "";
        placement[digest_of_file] = fmt::format("{:016x} of {} rods", groups[g].file_digest(), groups[g].count());
    }
    return json.dump(2) + "\n";
}

std::string settings_json(const SceneSpec& scene) {
    const Json all = Json::parse(scene_json(without_physics(scene), false));
    Json settings = {{"file", scene.file}, {"title", all["title"]}, {"time", all["time"]}, {"output", all["output"]}};
    for_each_list(scene, [&](const char* name, const auto& specs) {
        if (!decides_state<typename std::decay_t<decltype(specs)>::value_type> && !specs.empty())
            settings[name] = all[name];
    });
    for (const RodSpec& rods : scene.rods)
        if (rods.placement.kind == PlacementKind::file) settings[files_of_rods][rods.name] = rods.placement.file;
    return settings.dump();
}

SceneSpec rebuilt_scene(const std::string& physics, const std::string& settings, const std::string& name) {
    return scene_of(whole(physics, settings, name), name, {});
}

bool has_automatic_step(const std::string& settings) {
    const Json json = Json::parse(settings, nullptr, false);
    return json.is_object() && json.contains("time") && json["time"].value("dt", Json()) == Json(0.0);
}

SceneSpec branched_scene(const std::string& physics, const std::string& settings, const std::string& name,
                         const std::string& from, const std::vector<std::string>& overrides) {
    Json scene = whole(physics, settings, name);
    scene["start"] = {{"from", from}};
    return scene_of(scene, name, overrides);
}

std::vector<KeyChange> key_changes(const std::string& old_json, const std::string& new_json) {
    const Json was = Json::parse(old_json, nullptr, false).flatten(),
               now = Json::parse(new_json, nullptr, false).flatten();
    Json all = was;
    all.update(now);
    std::vector<KeyChange> changes;
    for (const auto& item : all.items()) {
        const auto value_in = [&item](const Json& scene) {
            return scene.contains(item.key()) ? scene[item.key()].dump() : std::string("absent");
        };
        KeyChange change{dotted(item.key()), value_in(was), value_in(now)};
        if (change.was != change.now) changes.push_back(std::move(change));
    }
    return changes;
}

std::vector<KeyChange> forbidden_changes(const std::string& old_physics, const std::string& new_physics) {
    std::vector<KeyChange> forbidden;
    const Json was = Json::parse(old_physics, nullptr, false), now = Json::parse(new_physics, nullptr, false);
    const auto presence = [](bool there) { return there ? "present" : "absent"; };
    for_each_table(SceneSpec{}, [&](const std::string& name, const auto& member, bool) {
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (is_optional_table<Member>) {
            constexpr bool decides = !requires { requires !Member::value_type::presence_decides; };
            if (decides && was.contains(name) != now.contains(name))
                forbidden.push_back({name, presence(was.contains(name)), presence(now.contains(name))});
        }
    });
    for (KeyChange& change : key_changes(old_physics, new_physics))
        if (!may_change(change)) forbidden.push_back(std::move(change));
    return forbidden;
}

std::string text_of(const std::vector<KeyChange>& changes) {
    constexpr std::size_t most = 8;
    std::string lines;
    for (std::size_t i = 0; i < std::min(most, changes.size()); ++i)
        lines += fmt::format("\n  {}: was {}, now {}", changes[i].key, changes[i].was, changes[i].now);
    return changes.size() > most ? fmt::format("{}\n  and {} more", lines, changes.size() - most) : lines;
}

} // namespace skein
