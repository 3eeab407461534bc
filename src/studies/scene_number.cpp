#include "studies/scene_number.hpp"

#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

namespace skein {

namespace {

using Json = nlohmann::ordered_json;

bool is_count(const std::string& part) {
    return !part.empty() && part.size() < 10 && part.find_first_not_of("0123456789") == std::string::npos;
}

/// The member or item that part of a path means; null where there is none.
const Json* inside(const Json& at, const std::string& part) {
    if (at.is_object()) return at.contains(part) ? &at.at(part) : nullptr;
    if (!at.is_array()) return nullptr;
    if (is_count(part)) {
        const std::size_t number = std::stoul(part);
        return number < at.size() ? &at.at(number) : nullptr;
    }
    for (const Json& item : at)
        for (const char* key : {"name", "kind"})
            if (item.is_object() && item.contains(key) && item.at(key) == part) return &item;
    return nullptr;
}

/// Unit and type of a key as the reference page has them; `kind`: of the table that it is in.
void describe(SceneNumber& number, const std::string& table, const std::string& kind, const std::string& rest) {
    static const std::vector<KeyEntry> keys = all_keys();
    for (const KeyEntry& key : keys)
        if (key.path() == table + "." + kind + rest || key.path() == table + rest) {
            number.unit = key.field.unit;
            number.whole = key.type.starts_with("integer");
            return;
        }
}

SceneNumber number_in(const Json& root, const std::string& file, const std::string& path) {
    const Json *at = &root, *above = nullptr;
    std::string table, kind, rest; // of the key without the numbers of tables and components
    std::size_t from = 0;
    while (at && from <= path.size()) {
        const std::size_t dot = std::min(path.find('.', from), path.size());
        const std::string part = path.substr(from, dot - from);
        above = at;
        at = inside(*above, part);
        if (above == &root) table = part;
        else if (above->is_object()) rest += "." + part;
        else if (rest.empty() && at && at->is_object() && at->contains("kind") && at->at("kind").is_string())
            kind = at->at("kind").get<std::string>();
        from = dot + 1;
    }
    SceneNumber number;
    if (at && table == "constants") {
        const Json& constant = at->is_object() ? *at : *above;
        if (constant.contains("unit")) number.unit = constant.at("unit").get<std::string>();
        if (at->is_object() && number.unit.empty() && at->contains("value")) at = &at->at("value");
    } else if (at) {
        describe(number, table, kind, rest);
    }
    if (!at || !at->is_number())
        throw InputError(
            fmt::format("'{}' is no number of {}; a path such as load.0.end.2 names one: a key, the name or "
                        "number of a table, the number of a component, counted from 0",
                        path, file));
    number.value = at->get<double>();
    return number;
}

/// Sets a number of one table, `way`: the rest of its path.
class NumberSetter final : public FieldLooker {
public:
    using FieldLooker::visit;
    NumberSetter(std::vector<std::string> way, double value) : way_(std::move(way)), value_(value) {}
    bool is_done() const { return done_; }

    void visit(const Field& f, double& x) override {
        if (leads_to(f, 0)) set(f, x);
    }
    void visit(const Field& f, Vec3d& v) override {
        if (leads_to(f, 1)) set_component(f, v, 1);
    }
    void visit(const Field& f, std::vector<double>& all) override {
        if (leads_to(f, 1) && item(1) < all.size()) set(f, all[item(1)]);
    }
    void visit(const Field& f, std::vector<Vec3d>& all) override {
        if (leads_to(f, 2) && item(1) < all.size()) set_component(f, all[item(1)], 2);
    }
    bool enter(const Field& f) override {
        if (depth_ == way_.size() || way_[depth_] != f.name) return false;
        ++depth_;
        return true;
    }
    void leave() override { --depth_; }

private:
    /// True where the field is on the way, with so many numbers of items behind it.
    bool leads_to(const Field& f, std::size_t items) const {
        return way_.size() == depth_ + 1 + items && way_[depth_] == f.name;
    }
    std::size_t item(std::size_t after) const {
        const std::string& part = way_[depth_ + after];
        return is_count(part) ? std::stoul(part) : SIZE_MAX;
    }
    void set_component(const Field& f, Vec3d& v, std::size_t after) {
        if (double* const of[] = {&v.x, &v.y, &v.z}; item(after) < std::size(of)) set(f, *of[item(after)]);
    }
    void set(const Field& f, double& x) {
        if (!(value_ > f.above && value_ >= f.at_least && value_ <= f.at_most))
            throw InputError(fmt::format("'{}' does not accept {:g}: it has to be {}", f.name, value_, bounds_text(f)));
        x = value_;
        done_ = true;
    }

    std::vector<std::string> way_;
    double value_;
    std::size_t depth_ = 0;
    bool done_ = false;
};

std::vector<std::string> parts_of(const std::string& path) {
    std::vector<std::string> parts;
    for (std::size_t from = 0; from <= path.size();) {
        const std::size_t dot = std::min(path.find('.', from), path.size());
        parts.push_back(path.substr(from, dot - from));
        from = dot + 1;
    }
    return parts;
}

bool set_in_table(auto& spec, std::span<const std::string> way, double value) {
    NumberSetter setter({way.begin(), way.end()}, value);
    spec.fields(setter);
    return setter.is_done();
}

/// Sets it in the table of a list that the first part of the way names: by its number, its name or its kind.
/// `counts`: tables that are of this list.
template <class Spec>
bool set_in_list(std::vector<Spec>& list, std::span<const std::string> way, double value, auto&& counts) {
    if (way.empty()) return false;
    std::size_t place = 0;
    for (Spec& spec : list) {
        if (!counts(spec)) continue;
        NameOfTable finder;
        spec.fields(finder);
        if (is_count(way[0]) ? place == std::stoul(way[0]) : finder.is_called(way[0]))
            return set_in_table(spec, way.subspan(1), value);
        ++place;
    }
    return false;
}

} // namespace

std::vector<SceneNumber> numbers_at(const SceneSpec& scene, std::span<const std::string> paths) {
    const Json root = Json::parse(scene_json(scene, false));
    std::vector<SceneNumber> all;
    for (const std::string& path : paths) all.push_back(number_in(root, scene.file, path));
    return all;
}

SceneNumber number_at(const SceneSpec& scene, const std::string& path) { return numbers_at(scene, {{path}}).front(); }

SceneSpec with_number(SceneSpec scene, const std::string& path, double value) {
    const std::vector<std::string> parts = parts_of(path);
    const std::span<const std::string> way = std::span(parts).subspan(1);
    const std::string& table = parts.front();
    bool done = false;
    const auto in_table = [&](std::string_view name, auto& spec) {
        if (name == table) done = set_in_table(spec, way, value);
    };
    if (table == "rods" || table == "bodies")
        done = set_in_list(scene.rods, way, value,
                           [&](const RodSpec& spec) { return spec.body.has_value() == (table == "bodies"); });
    for (FormulaConstant& constant : scene.constants)
        if (table == "constants" && !way.empty() && constant.name == way[0]) {
            constant.value = value;
            done = true;
        }
    in_table("time", scene.time);
    for_each_spec(scene, in_table);
    for_each_list(scene, [&](std::string_view name, auto& list) {
        if (name == table) done = set_in_list(list, way, value, [](const auto&) { return true; });
    });
    if (!done) throw InputError(fmt::format("'{}' is no number of {} that can be changed", path, scene.file));
    return scene;
}

void refuse_whole(const SceneNumber& number, const std::string& path) {
    if (number.whole)
        throw InputError(fmt::format("'{}' is a whole number, and has no values between: numbers of elements and of "
                                     "copies change what is unknown; skein converge compares numbers of elements",
                                     path));
}

} // namespace skein
