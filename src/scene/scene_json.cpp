#include "joints/junction.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_tables.hpp"
#include "skein/core/index.hpp"

#include <cmath>
#include <type_traits>

#include <nlohmann/json.hpp>

namespace skein {

namespace {

using Json = nlohmann::json; // its objects sort their keys, its doubles read back to the same bits

Json json_of(const Vec3d& v) { return std::isnan(v.x) ? Json() : Json{v.x, v.y, v.z}; }

/// Copies what it visits into an object.
class JsonEcho : public FieldVisitor {
public:
    Json result() const { return open_.front(); }

    void visit(const Field& f, double& x) override { set(f, x); }
    void visit(const Field& f, long& i) override { set(f, i); }
    void visit(const Field& f, bool& b) override { set(f, b); }
    void visit(const Field& f, std::string& s) override { set(f, s); }
    void visit(const Field& f, Vec3d& v) override { set(f, json_of(v)); }
    void visit(const Field& f, std::vector<double>& v) override { set(f, v); }
    void visit(const Field& f, std::vector<long>& v) override { set(f, v); }
    void visit(const Field& f, std::vector<Vec3d>& v) override {
        Json list = Json::array();
        for (const Vec3d& item : v) list.push_back(json_of(item));
        set(f, list);
    }
    void visit(const Field& f, std::vector<std::string>& v) override { set(f, v); }
    void visit_choice(const Field& f, int& value, std::span<const std::string_view> names) override {
        set(f, nth(names, value));
    }
    bool enter(const Field& f) override {
        names_.emplace_back(f.name);
        open_.push_back(Json::object());
        return true;
    }
    void leave() override {
        Json closed = std::move(open_.back());
        open_.pop_back();
        open_.back()[names_.back()] = std::move(closed);
        names_.pop_back();
    }

private:
    template <class T> void set(const Field& f, const T& value) { open_.back()[std::string(f.name)] = value; }
    std::vector<Json> open_ = {Json::object()};
    std::vector<std::string> names_;
};

template <class Visit> Json echo(Visit visit) {
    JsonEcho echo;
    visit(echo);
    return echo.result();
}

template <class Spec> Json table_echo(Spec& spec) {
    return echo([&](FieldVisitor& f) { table_fields(f, spec); });
}

/// A table of contacts, with the word where its stiffness is automatic, and only there what goes with it.
template <class Spec> Json contact_echo(Spec& spec) {
    Json table = table_echo(spec);
    if (spec.law.stiffness_is_automatic()) table["stiffness"] = "auto";
    else table.erase("accepted_overlap");
    return table;
}

/// A joint, with the word where it has a common node in the place of a spring.
Json joint_echo(JointSpec& spec) {
    Json table = table_echo(spec);
    if (shares_node(spec)) table["stiffness"] = "auto";
    return table;
}

/// A load, with the word for what it chooses.
Json load_echo(LoadSpec& spec) {
    Json table = table_echo(spec);
    for (auto& [key, value] : table.items())
        if (const auto automatic = what_auto_means("load", key); automatic && value.is_number() && value == *automatic)
            value = "auto";
    return table;
}

} // namespace

std::string scene_json(const SceneSpec& scene, bool physics_only) {
    SceneSpec copy = scene; // fields() hands out references to change
    Json json;
    json["time"] = echo([&](FieldVisitor& f) { copy.time.fields(f); });
    json["rods"] = json["load"] = json["damping"] = Json::array();
    for (RodSpec& rods : copy.rods)
        json[rods.body ? "bodies" : "rods"].push_back(echo([&](FieldVisitor& f) { rods.fields(f); }));
    for (const FormulaConstant& c : copy.constants) json["constants"][c.name] = {{"value", c.value}, {"unit", c.unit}};
    if (copy.contact) json["contact"] = contact_echo(*copy.contact);
    if (copy.fluid) json["fluid"] = table_echo(*copy.fluid);
    if (copy.fluid && copy.rods.empty() && physics_only) // of plans alone, and of rods
    {
        json["fluid"].erase("expected_speed");
        json["fluid"].erase("largest_slip");
    }
    if (copy.fluid && physics_only) json["fluid"].erase("ranks_across"); // any ranks have the same results
    if (copy.has_immersed()) json["immersion"] = table_echo(copy.immersion);
    if (physics_only) copy.fluid_outputs.clear();
    for_each_list(copy, [&](const char* name, auto& specs) {
        for (auto& spec : specs)
            if constexpr (requires { spec.law.stiffness_is_automatic(); }) json[name].push_back(contact_echo(spec));
            else if constexpr (std::is_same_v<std::decay_t<decltype(spec)>, JointSpec>)
                json[name].push_back(joint_echo(spec));
            else if constexpr (std::is_same_v<std::decay_t<decltype(spec)>, LoadSpec>)
                json[name].push_back(load_echo(spec));
            else json[name].push_back(table_echo(spec));
    });
    if (!scene.start.from.empty()) json["start"] = echo([&](FieldVisitor& f) { copy.start.fields(f); });
    if (!physics_only) {
        json["title"] = scene.title;
        json["output"] = echo([&](FieldVisitor& f) { copy.output.fields(f); });
    }
    return json.dump(2) + "\n";
}

} // namespace skein
