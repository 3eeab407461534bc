#include "studies/scene_number.hpp"

#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <optional>
#include <string_view>
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
    bool absent = false;
    while (at && from <= path.size()) {
        const std::size_t dot = std::min(path.find('.', from), path.size());
        const std::string part = path.substr(from, dot - from);
        above = at;
        at = inside(*above, part);
        absent = absent || (at && at->is_null());
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
    if (at && at->is_string() && *at == "auto") return number; // of which the caller finds what is used
    if (at && at->is_string())
        throw InputError(fmt::format("'{}' is no number of {} but a text: a number in a formula has to be a constant, "
                                     "[constants] NAME = VALUE, whose key is constants.NAME.value",
                                     path, file));
    if (absent)
        throw InputError(
            fmt::format("'{}' is not given in {}, and follows from other keys: write it into the scene", path, file));
    if (!at || !at->is_number())
        throw InputError(
            fmt::format("'{}' is no number of {}; a path such as load.0.end.2 names one: a key, the name or "
                        "number of a table, the number of a component, counted from 0",
                        path, file));
    number.value = at->get<double>();
    return number;
}

/// Acts on a number in its place, with what is known of its key.
using NumberAct = std::function<void(const Field&, double&)>;

/// Finds a number of one table, `way`: the rest of its path.
class NumberFinder final : public FieldLooker {
public:
    using FieldLooker::visit;
    NumberFinder(std::span<const std::string> way, const NumberAct& act) : way_(way), act_(act) {}
    bool is_done() const { return done_; }

    void visit(const Field& f, double& x) override {
        if (leads_to(f, 0)) found(f, x);
    }
    void visit(const Field& f, Vec3d& v) override {
        if (leads_to(f, 1)) find_component(f, v, 1);
    }
    void visit(const Field& f, std::vector<double>& all) override {
        if (leads_to(f, 1) && item(1) < all.size()) found(f, all[item(1)]);
    }
    void visit(const Field& f, std::vector<Vec3d>& all) override {
        if (leads_to(f, 2) && item(1) < all.size()) find_component(f, all[item(1)], 2);
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
    void find_component(const Field& f, Vec3d& v, std::size_t after) {
        if (double* const of[] = {&v.x, &v.y, &v.z}; item(after) < std::size(of)) found(f, *of[item(after)]);
    }
    void found(const Field& f, double& x) {
        act_(f, x);
        done_ = true;
    }

    std::span<const std::string> way_;
    const NumberAct& act_;
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

bool find_in_table(auto& spec, std::span<const std::string> way, const NumberAct& act) {
    NumberFinder finder(way, act);
    spec.fields(finder);
    return finder.is_done();
}

/// Finds it in the table of a list that the first part of the way names: by its number, its name or its kind.
/// `counts`: tables that are of this list.
template <class Spec>
bool find_in_list(std::vector<Spec>& list, std::span<const std::string> way, const NumberAct& act, auto&& counts) {
    if (way.empty()) return false;
    std::size_t place = 0;
    for (Spec& spec : list) {
        if (!counts(spec)) continue;
        NameOfTable finder;
        spec.fields(finder);
        if (is_count(way[0]) ? place == std::stoul(way[0]) : finder.is_called(way[0]))
            return find_in_table(spec, way.subspan(1), act);
        ++place;
    }
    return false;
}

/// Acts on the number of a path; false where no key holds one.
bool find_number(SceneSpec& scene, const std::string& path, const NumberAct& act) {
    const std::vector<std::string> parts = parts_of(path);
    const std::span<const std::string> way = std::span(parts).subspan(1);
    const std::string& table = parts.front();
    bool done = false;
    const auto in_table = [&](std::string_view name, auto& spec) {
        if (name == table) done = find_in_table(spec, way, act);
    };
    if (table == "rods" || table == "bodies")
        done = find_in_list(scene.rods, way, act,
                            [&](const RodSpec& spec) { return spec.body.has_value() == (table == "bodies"); });
    in_table("time", scene.time);
    for_each_spec(scene, in_table);
    for_each_list(scene, [&](std::string_view name, auto& list) {
        if (name == table) done = find_in_list(list, way, act, [](const auto&) { return true; });
    });
    return done;
}

std::string text_of_placeholder(const Field& f, const std::string& path, double value) {
    return fmt::format("'{}' = {:g} stands for another number or for none ({})", path, value, f.text);
}

/// Number that a scene uses where the key at `number` holds a value that stands for it; none where none is known.
std::optional<double> used_in_place(SceneSpec& scene, const double* number) {
    for (const RodSpec& rods : scene.rods)
        if (number == &rods.material.shear_modulus) return rods.material.youngs_modulus / 3;
    std::optional<double> friction;
    const auto look = [&](const ContactLaw& law) {
        if (number == &law.kinetic_friction) friction = law.static_friction;
    };
    if (scene.contact) look(scene.contact->law);
    for (const ContactPair& pair : scene.contact_pairs) look(pair.law);
    for (const Wall& wall : scene.walls) look(wall.law);
    return friction;
}

/// The number of a path that a key holds or, where its value stands for another, the one that the scene uses.
double used_number(SceneSpec& scene, const std::string& path, double given) {
    double used = given;
    std::string wrong;
    find_number(scene, path, [&](const Field& f, double& x) {
        if (!is_placeholder(f, x)) return;
        if (const std::optional<double> own = used_in_place(scene, &x)) used = *own;
        else wrong = text_of_placeholder(f, path, x);
    });
    if (wrong.empty()) return used;
    SceneSpec with_numbers = resolved(scene, make_whole_groups(scene));
    find_number(with_numbers, path, [&](const Field& f, double& x) {
        if (is_placeholder(f, x)) return;
        used = x;
        wrong.clear();
    });
    if (!wrong.empty())
        throw InputError(fmt::format("{}: {}: write the number that is meant into the scene", scene.file, wrong));
    return used;
}

} // namespace

bool is_placeholder(const Field& field, double value) {
    if (value == field.automatic) return true;
    const auto says = [&](std::string_view words) { return field.text.find(words) != std::string_view::npos; };
    if (value == 0) return says(" 0: ") || says(" 0 stands for ");
    return value < 0 && says(" below 0: ");
}

std::vector<SceneNumber> numbers_at(const SceneSpec& scene, std::span<const std::string> paths) {
    const Json root = Json::parse(scene_json(scene, false));
    SceneSpec own = scene; // fields() hands out references to change
    std::vector<SceneNumber> all;
    for (const std::string& path : paths) {
        all.push_back(number_in(root, scene.file, path));
        all.back().value = used_number(own, path, all.back().value);
    }
    return all;
}

SceneNumber number_at(const SceneSpec& scene, const std::string& path) { return numbers_at(scene, {{path}}).front(); }

SceneSpec with_number(SceneSpec scene, const std::string& path, double value) {
    bool done = find_number(scene, path, [&](const Field& f, double& x) {
        if (!(value > f.above && value >= f.at_least && value <= f.at_most))
            throw InputError(fmt::format("'{}' does not accept {:g}: it must be {}", f.name, value, bounds_text(f)));
        if (f.takes_auto() && value < 0)
            throw InputError(fmt::format("'{}' does not accept {:g}: it must be at least 0", f.name, value));
        if (is_placeholder(f, value))
            throw InputError(fmt::format("{}, and no number is next to it", text_of_placeholder(f, path, value)));
        x = value;
    });
    const std::vector<std::string> parts = parts_of(path);
    for (FormulaConstant& constant : scene.constants)
        if (parts.size() > 1 && parts[0] == "constants" && constant.name == parts[1]) {
            constant.value = value;
            done = true;
        }
    if (!done) throw InputError(fmt::format("'{}' is no number of {} that can be changed", path, scene.file));
    return scene;
}

void refuse_whole(const SceneNumber& number, const std::string& path) {
    if (path == "time.duration")
        throw InputError("'time.duration' is the time of loads and ends where --time is absent, and this stays as it "
                         "is; give another --time, or vary a constant of the formulas");
    if (number.whole)
        throw InputError(fmt::format("'{}' is a whole number, and has no values between: numbers of elements and of "
                                     "copies change what is unknown; skein converge compares numbers of elements",
                                     path));
}

} // namespace skein
