#include "physics/scene_spec.hpp"
#include "scene/scene_file.hpp"
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

/// A table as `spec` has it, tidied by its physics.
template <class Spec> Json table_echo(Spec& spec, const SceneSpec& scene, bool physics_only) {
    Json table = echo([&](FieldVisitor& f) { spec.fields(f); });
    if constexpr (requires { tidy_echo(table, spec, scene, physics_only); })
        tidy_echo(table, spec, scene, physics_only);
    return table;
}

} // namespace

std::string scene_json(const SceneSpec& scene, bool physics_only) {
    SceneSpec copy = scene; // fields() hands out references to change
    Json json;
    json["time"] = echo([&](FieldVisitor& f) { copy.time.fields(f); });
    json["rods"] = json["load"] = json["damping"] = Json::array();
    for (RodSpec& rods : copy.rods) {
        Json& table = json[rods.body ? "bodies" : "rods"].emplace_back(echo([&](FieldVisitor& f) { rods.fields(f); }));
        if (rods.material.rotary_inertia_for_dt == Material::automatic_inertia)
            table["material"]["rotary_inertia_for_dt"] = "auto";
    }
    for (const FormulaConstant& c : copy.constants) json["constants"][c.name] = {{"value", c.value}, {"unit", c.unit}};
    for_each_spec(copy, [&](const char* name, auto& spec) { json[name] = table_echo(spec, copy, physics_only); });
    for_each_list(copy, [&](const char* name, auto& specs) {
        if (physics_only && !decides_state<typename std::decay_t<decltype(specs)>::value_type>) return;
        for (auto& spec : specs) json[name].push_back(table_echo(spec, copy, physics_only));
    });
    if (!scene.start.from.empty()) json["start"] = echo([&](FieldVisitor& f) { copy.start.fields(f); });
    if (!physics_only) {
        json["title"] = scene.title;
        json["output"] = echo([&](FieldVisitor& f) { copy.output.fields(f); });
    }
    return json.dump(2) + "\n";
}

} // namespace skein
