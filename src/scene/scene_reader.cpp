#include "scene/scene_reader.hpp"

#include "core/nearest.hpp"
#include "scene/scene_keys.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace skein {

namespace {

std::string with_unit(std::string_view what, const Field& field) {
    const bool plain = field.unit.empty() || field.unit == "-";
    return plain ? std::string(what) : fmt::format("{} [{}]", what, field.unit);
}

bool is_table(const TomlValue& value) {
    if (const auto* list = value.as<TomlArray>()) return !list->empty() && list->front().as<TomlTable>();
    return value.as<TomlTable>() != nullptr;
}

/// "; [rods.shape] has a key of this name" where another table of the scene has one.
std::string elsewhere(std::string_view key) {
    for (const KeyEntry& other : all_keys())
        if (other.field.name == key && !other.table.empty())
            return fmt::format("; {} has a key of this name", table_heading(other.table));
    return "";
}

/// End of a message about a word that another table takes now.
std::optional<std::string> moved_to(std::string_view table, std::string_view key, std::string_view word) {
    if (table == "rods.material" && key == "law" && word == "rigid")
        return "; rigid bodies have tables of their own, [[bodies]]";
    return std::nullopt;
}

class TomlReader : public FieldVisitor {
public:
    /// `changes`: tables hold the keys that are to change alone, and the others keep their values.
    explicit TomlReader(Problems& problems, bool changes = false) : problems_(problems), changes_(changes) {}

    /// Opens a table that no spec's fields() enters; close with leave().
    void begin(const TomlValue& table, const std::string& path, const std::string& label, const Place& place) {
        open_.push_back({&table, path, label, place, {}, {}, false});
    }

    void visit(const Field& f, double& x) override {
        const TomlValue* v = find(f);
        if (!v) return;
        const bool automatic = f.takes_auto();
        if (const auto* word = v->as<std::string>(); automatic && word && *word == "auto") x = f.automatic;
        else if (number(f, *v, x, with_unit("a number", f) + (automatic ? " or \"auto\"" : "")) && automatic && x < 0)
            problems_.add(v->place, fmt::format("{} is {}; it must be at least 0, or \"auto\"", key_in_table(f), x));
    }
    void visit(const Field& f, long& i) override {
        if (const TomlValue* v = find(f)) integer(f, *v, i, with_unit("an integer", f));
    }
    void visit(const Field& f, bool& b) override {
        if (const TomlValue* v = find(f)) scalar(f, *v, b, "true or false");
    }
    void visit(const Field& f, std::string& s) override {
        if (const TomlValue* v = find(f)) scalar(f, *v, s, "a string");
    }
    void visit(const Field& f, Vec3d& x) override {
        if (const TomlValue* v = find(f)) vector(f, *v, x, with_unit("an array of 3 numbers", f));
    }
    void visit(const Field& f, std::vector<double>& list) override {
        const std::string expected = with_unit("an array of numbers", f);
        items(f, list, expected, [&](const TomlValue& v, double& x) { return number(f, v, x, expected); });
    }
    void visit(const Field& f, std::vector<long>& list) override {
        const std::string expected = with_unit("an array of integers", f);
        items(f, list, expected, [&](const TomlValue& v, long& i) { return integer(f, v, i, expected); });
    }
    void visit(const Field& f, std::vector<Vec3d>& list) override {
        const std::string expected = with_unit("an array of arrays of 3 numbers", f);
        items(f, list, expected, [&](const TomlValue& v, Vec3d& x) { return vector(f, v, x, expected); });
    }
    void visit(const Field& f, std::vector<std::string>& list) override {
        const std::string expected = "an array of strings";
        items(f, list, expected, [&](const TomlValue& v, std::string& s) { return scalar(f, v, s, expected); });
    }
    void visit_choice(const Field& f, int& value, std::span<const std::string_view> names) override {
        const TomlValue* v = find(f);
        std::string name;
        const bool given = v && scalar(f, *v, name, "one of the strings " + joined(names));
        const auto at = std::find(names.begin(), names.end(), name);
        if (given && at != names.end()) {
            value = static_cast<int>(at - names.begin());
            return;
        }
        if (given)
            problems_.add(
                v->place,
                fmt::format(
                    "{} knows no \"{}\"{}", key_in_table(f), name,
                    moved_to(open_.back().path, f.name, name).value_or(suggestion(name, names, "it is one of"))));
        // The other keys of such a table mean nothing without it.
        open_.back().abandoned = f.required && (given || !changes_);
    }

    bool enter(const Field& f) override {
        const Frame& parent = open_.back();
        const std::string path = parent.path + "." + std::string(f.name);
        open_.back().known.push_back(f.name);
        const TomlEntry* entry = parent.table->find(f.name);
        if (!entry) {
            if (f.required && !changes_)
                open_.back().missing.emplace_back(f.name, fmt::format("missing table [{}] in {}", path, parent.label));
            return false;
        }
        if (!entry->value.as<TomlTable>()) {
            wrong_type(f, entry->value, fmt::format("a table [{}]", path));
            return false;
        }
        begin(entry->value, path, fmt::format("[{}]", path), entry->place);
        return true;
    }
    void leave() override {
        Frame& frame = open_.back();
        for (const TomlEntry& entry : *frame.table->as<TomlTable>())
            if (!frame.abandoned && std::find(frame.known.begin(), frame.known.end(), entry.key) == frame.known.end())
                unknown(frame, entry);
        for (const auto& [key, message] : frame.missing) problems_.add(frame.place, message);
        open_.pop_back();
    }

    /// A top-level entry by name, which from here on is known; null where absent.
    const TomlEntry* top_level(std::string_view name, bool required) {
        Frame& scene = open_.back();
        scene.known.push_back(name);
        const TomlEntry* entry = scene.table->find(name);
        if (!entry && required)
            scene.missing.emplace_back(name, fmt::format("missing table [{}] in {}", name, scene.label));
        return entry;
    }

private:
    struct Frame {
        const TomlValue* table;
        std::string path;  ///< "rods.shape"
        std::string label; ///< "[rods.shape]"
        Place place;
        std::vector<std::string_view> known;
        std::vector<std::pair<std::string_view, std::string>> missing; ///< required keys, and what to say of them
        bool abandoned; ///< its kind is not known: what its keys should be, neither
    };

    const TomlValue* find(const Field& f) {
        Frame& frame = open_.back();
        frame.known.push_back(f.name);
        if (frame.abandoned) return nullptr;
        if (const TomlEntry* entry = frame.table->find(f.name)) return &entry->value;
        if (f.required && !changes_)
            frame.missing.emplace_back(
                f.name, fmt::format("missing key '{}' in {}: {}", f.name, frame.label, with_unit(f.text, f)));
        return nullptr;
    }

    std::string key_in_table(const Field& f) const { return fmt::format("'{}' in {}", f.name, open_.back().label); }

    bool wrong_type(const Field& f, const TomlValue& v, const std::string& expected) {
        problems_.add(v.place, fmt::format("{}: expected {}, found {}", key_in_table(f), expected, found(v)));
        return false;
    }

    bool in_range(const Field& f, const TomlValue& v, double x) {
        if (!std::isfinite(x)) {
            problems_.add(v.place, fmt::format("{} is {}; it must be a finite number", key_in_table(f),
                                               std::isnan(x) ? "not a number" : "infinite"));
            return false;
        }
        if (x > f.above && x >= f.at_least && x <= f.at_most) return true;
        problems_.add(v.place,
                      fmt::format("{} is {}; it must be {}", key_in_table(f), x, with_unit(bounds_text(f), f)));
        return false;
    }

    bool number(const Field& f, const TomlValue& v, double& x, const std::string& expected) {
        double given;
        if (const auto* real = v.as<double>()) given = *real;
        else if (const auto* whole = v.as<std::int64_t>()) given = static_cast<double>(*whole);
        else return wrong_type(f, v, expected);
        if (!in_range(f, v, given)) return false;
        x = given;
        return true;
    }
    bool integer(const Field& f, const TomlValue& v, long& i, const std::string& expected) {
        const auto* whole = v.as<std::int64_t>();
        if (!whole) return wrong_type(f, v, expected);
        if (!in_range(f, v, static_cast<double>(*whole))) return false;
        i = *whole;
        return true;
    }
    template <class T> bool scalar(const Field& f, const TomlValue& v, T& x, const std::string& expected) {
        const T* given = v.as<T>();
        if (!given) return wrong_type(f, v, expected);
        x = *given;
        return true;
    }
    bool vector(const Field& f, const TomlValue& v, Vec3d& x, const std::string& expected) {
        const auto* list = v.as<TomlArray>();
        if (!list || list->size() != 3) return wrong_type(f, v, expected);
        return number(f, (*list)[0], x.x, expected) && number(f, (*list)[1], x.y, expected) &&
               number(f, (*list)[2], x.z, expected);
    }
    template <class T, class ReadItem>
    void items(const Field& f, std::vector<T>& out, const std::string& expected, ReadItem read) {
        const TomlValue* v = find(f);
        if (!v) return;
        const auto* list = v->as<TomlArray>();
        if (!list) {
            wrong_type(f, *v, expected);
            return;
        }
        out.clear();
        for (const TomlValue& item : *list)
            if (!read(item, out.emplace_back())) return; // one message a list is enough
    }

    void unknown(Frame& frame, const TomlEntry& entry) {
        const char* what = is_table(entry.value) ? "table" : "key";
        std::string hint;
        if (const auto near = nearest_name(entry.key, frame.known); !near.empty()) {
            hint = fmt::format("; did you mean '{}'?", near);
            std::erase_if(frame.missing, [&](const auto& key) { return key.first == near; }); // misspelt, not missing
        } else {
            hint = elsewhere(entry.key) + fmt::format("; {} takes {}", frame.label, joined(frame.known));
        }
        problems_.add(entry.place, fmt::format("unknown {} '{}' in {}{}", what, entry.key, frame.label, hint));
    }

    Problems& problems_;
    bool changes_;
    std::vector<Frame> open_;
};

/// A top-level [table].
template <class Spec>
void read_table(TomlReader& reader, Problems& problems, const char* name, Spec& spec, bool required) {
    const TomlEntry* entry = reader.top_level(name, required);
    if (!entry) return;
    if (!entry->value.as<TomlTable>()) {
        problems.add(entry->place, fmt::format("'{0}' is one table [{0}], found {1}", name, found(entry->value)));
        return;
    }
    if constexpr (requires { spec.key_source; })
        for (const TomlEntry& key : *entry->value.as<TomlTable>()) spec.key_source[key.key] = key.place.table_name();
    reader.begin(entry->value, name, fmt::format("[{}]", name), entry->place);
    spec.fields(reader);
    reader.leave();
}

/// Every table of a top-level [[list]].
template <class Spec, class Fields>
void read_list(TomlReader& reader, Problems& problems, const char* name, std::vector<Spec>& specs, Fields fields) {
    const TomlEntry* entry = reader.top_level(name, false);
    if (!entry) return;
    const auto* list = entry->value.as<TomlArray>();
    const bool tables = list && (list->empty() || is_table(entry->value));
    if (!tables) {
        problems.add(entry->place,
                     fmt::format("'{0}' is a list of tables [[{0}]], found {1}", name, found(entry->value)));
        return;
    }
    for (const TomlValue& table : *list) {
        Spec& spec = specs.emplace_back();
        spec.source = table.place.table_name();
        reader.begin(table, name, fmt::format("[[{}]]", name), table.place);
        fields(reader, spec);
        reader.leave();
    }
}

/// [constants]: names that the scene chooses, each a number or a { value, unit }.
void read_constants(TomlReader& reader, Problems& problems, std::vector<FormulaConstant>& constants) {
    const TomlEntry* entry = reader.top_level("constants", false);
    if (!entry) return;
    const auto* table = entry->value.as<TomlTable>();
    if (!table) {
        problems.add(entry->place, fmt::format("'constants' is one table [constants], found {}", found(entry->value)));
        return;
    }
    for (const TomlEntry& one : *table) {
        FormulaConstant& constant = constants.emplace_back(FormulaConstant{.name = one.key});
        if (one.value.as<TomlTable>()) {
            reader.begin(one.value, "constants." + one.key, fmt::format("[constants.{}]", one.key), one.place);
            reader.visit({.name = "value", .unit = "", .text = "a number", .required = true}, constant.value);
            reader.visit({.name = "unit", .unit = "", .text = "as \"N/m\""}, constant.unit);
            reader.leave();
        } else if (const auto* real = one.value.as<double>(); real && std::isfinite(*real)) {
            constant.value = *real;
        } else if (const auto* integer = one.value.as<std::int64_t>()) {
            constant.value = static_cast<double>(*integer);
        } else {
            problems.add(
                one.value.place,
                fmt::format(
                    "'{}' in [constants]: expected a finite number or {{ value = .., unit = \"..\" }}, found {}",
                    one.key, found(one.value)));
        }
    }
}

} // namespace

namespace {

/// A change of a scene: the table that its path names, and in it the path that is left.
class SceneChange {
public:
    SceneChange(SceneSpec& scene, const KeyValue& change, Problems& problems)
        : scene_(scene), change_(change), problems_(problems) {}

    void apply() {
        const std::string &table = change_.path.front(), &key = change_.path.back();
        if (key == "kind" || key == "name" || key == "stages")
            fail(fmt::format("a stage does not change '{}', by which a table is known", key));
        bool found = false;
        const auto each = [&](std::string_view name, auto& specs, auto&& accept) {
            if (name != table || found) return;
            found = true;
            change_one(specs, accept);
        };
        each("rods", scene_.rods, [](const RodSpec& spec) { return !spec.body; });
        each("bodies", scene_.rods, [](const RodSpec& spec) { return spec.body.has_value(); });
        for_each_list(scene_, [&](const char* name, auto& specs) {
            using Spec = typename std::decay_t<decltype(specs)>::value_type;
            if constexpr (decides_state<Spec> && !std::is_same_v<Spec, StageSpec> &&
                          !std::is_same_v<Spec, FormulaTable>)
                each(name, specs, [](const auto&) { return true; });
        });
        for_each_spec(scene_, [&](const char* name, auto& spec) {
            if (name != table || found) return;
            found = true;
            read(spec, name, 1);
        });
        if (table == "table")
            fail("a stage does not change the points of a [[table]], which hold for all of the run, and which a "
                 "program may drive: give another [[table]], and let the stage change the formula that names it");
        if (!found)
            fail(fmt::format("a stage changes rods, bodies and the tables of physics that the scene has, not '{}'",
                             table));
    }

private:
    [[noreturn]] void fail(const std::string& message) const {
        throw InputError(message_at(change_.value.place, message));
    }

    template <class Spec, class Accept> void change_one(std::vector<Spec>& specs, Accept&& accept) {
        const std::string& table = change_.path.front();
        if (change_.path.size() < 2) fail("a path names a key, not a whole table");
        std::vector<Spec*> tables;
        std::vector<std::string> names;
        for (Spec& spec : specs) {
            if (!accept(spec)) continue;
            tables.push_back(&spec);
            names.push_back(name_of_table(spec));
        }
        const std::vector<std::string_view> known(names.begin(), names.end());
        read(*tables[number_of_table(table, change_.path[1], known, change_.value.place)], table, 2);
    }

    /// Reads the key, which is in as many tables as the path has parts from `first` on.
    template <class Spec> void read(Spec& spec, const std::string& path, std::size_t first) {
        if (change_.path.size() <= first) fail("a path names a key, not a whole table");
        const Place& place = change_.value.place;
        TomlValue value = change_.value;
        for (std::size_t i = change_.path.size(); i-- > first;)
            value = TomlValue{TomlTable{{change_.path[i], place, std::move(value)}}, place};
        TomlReader reader(problems_, true);
        reader.begin(value, path, fmt::format("[{}]", path), place);
        spec.fields(reader);
        reader.leave();
    }

    SceneSpec& scene_;
    const KeyValue& change_;
    Problems& problems_;
};

} // namespace

void change_scene(SceneSpec& scene, const KeyValue& change) {
    Problems problems;
    SceneChange(scene, change, problems).apply();
    problems.raise();
}

SceneSpec read_tables(const TomlValue& root, Problems& problems) {
    SceneSpec scene;
    TomlReader reader(problems);
    reader.begin(root, "", "the scene", {root.place.text, 1, 1, 1});
    std::vector<std::string> included; // they are part of the tree
    reader.visit(include_field, included);
    reader.visit(title_field, scene.title);
    read_table(reader, problems, "time", scene.time, true);
    read_list(reader, problems, "rods", scene.rods, [](FieldVisitor& f, RodSpec& spec) { spec.fields(f); });
    std::vector<RodSpec> bodies;
    read_list(reader, problems, "bodies", bodies, [](FieldVisitor& f, RodSpec& spec) {
        spec.body.emplace();
        spec.fields(f);
    });
    scene.rods.insert(scene.rods.end(), std::make_move_iterator(bodies.begin()), std::make_move_iterator(bodies.end()));
    read_constants(reader, problems, scene.constants);
    for_each_table(scene, [&](const char* name, auto& member, bool) {
        if constexpr (is_optional_table<std::remove_cvref_t<decltype(member)>>) {
            if (root.find(name)) member.emplace();
            typename std::decay_t<decltype(member)>::value_type none; // an absent table is known all the same
            read_table(reader, problems, name, member ? *member : none, false);
        } else {
            read_table(reader, problems, name, member, false);
        }
    });
    for_each_list(scene, [&](const char* name, auto& specs) {
        read_list(reader, problems, name, specs, [](FieldVisitor& f, auto& spec) { spec.fields(f); });
    });
    read_table(reader, problems, "output", scene.output, false);
    read_table(reader, problems, "start", scene.start, false);
    reader.leave();
    return scene;
}

MachineFile read_machine_tables(const TomlValue& root, Problems& problems) {
    MachineFile file;
    TomlReader reader(problems);
    reader.begin(root, "", "the machine file", {root.place.text, 1, 1, 1});
    read_table(reader, problems, "network", file.network, true);
    read_table(reader, problems, "machine", file.machine, false);
    reader.leave();
    return file;
}

} // namespace skein
