#include "scene/scene_keys.hpp"

#include "scene/scene_check.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/index.hpp"

#include <cmath>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr std::string_view absent = "-";

/// An entry of [constants]: any name.
constexpr Field constant_field{.name = "(any name)",
                               .unit = "",
                               .text =
                                   "a number, or `{ value = 2.0, unit = \"N/m\" }`; its name in formulas is this key"};

std::string text_of(double x) { return fmt::format("{}", x); }
std::string text_of(long i) { return fmt::format("{}", i); }
std::string text_of(const std::string& s) {
    if (s.empty()) return std::string(absent);
    std::string text = "\"";
    for (const char c : s) {
        if (c == '"' || c == '\\') text += '\\';
        text += c == '\n' ? "\\n" : c == '\t' ? "\\t" : std::string(1, c);
    }
    return text + "\"";
}
std::string text_of(const Vec3d& v) {
    return std::isnan(v.x) ? std::string(absent) : fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}
template <class T> std::string text_of(const std::vector<T>& list) {
    std::string text;
    for (const T& item : list) text += (text.empty() ? "[" : ", ") + text_of(item);
    return list.empty() ? std::string(absent) : text + "]";
}

/// Writes down what it visits.
class KeyLister : public FieldVisitor {
public:
    explicit KeyLister(std::string table) : table_(std::move(table)) {}
    std::vector<KeyEntry> keys;

    void visit(const Field& f, double& x) override { add(f, "number", f.automatic == x ? "\"auto\"" : text_of(x)); }
    void visit(const Field& f, long& i) override { add(f, "integer", text_of(i)); }
    void visit(const Field& f, bool& b) override { add(f, "true or false", b ? "true" : "false"); }
    void visit(const Field& f, std::string& s) override { add(f, "text", text_of(s)); }
    void visit(const Field& f, Vec3d& v) override { add(f, "3 numbers", text_of(v)); }
    void visit(const Field& f, std::vector<double>& v) override { add(f, "numbers", text_of(v)); }
    void visit(const Field& f, std::vector<long>& v) override { add(f, "integers", text_of(v)); }
    void visit(const Field& f, std::vector<Vec3d>& v) override { add(f, "list of 3 numbers", text_of(v)); }
    void visit(const Field& f, std::vector<std::string>& v) override { add(f, "list of texts", text_of(v)); }
    void visit_choice(const Field& f, int& value, std::span<const std::string_view> names) override {
        add(f, "choice", text_of(std::string(nth(names, value))), names);
    }
    bool enter(const Field& f) override {
        add(f, "table", std::string(absent));
        table_ += table_.empty() ? "" : ".";
        table_ += f.name;
        return true;
    }
    void leave() override { table_.erase(table_.rfind('.')); }

private:
    void add(const Field& f, std::string_view type, std::string value, std::span<const std::string_view> choices = {}) {
        keys.push_back({table_, f, type, std::move(value), choices});
    }
    std::string table_;
};

/// True if the tables of a list come in kinds, each with its own keys.
bool has_kinds(std::string_view list) {
    bool found = false;
    for_each_list(SceneSpec{}, [&](std::string_view name, const auto& specs) {
        found |= name == list && HasKinds<typename std::decay_t<decltype(specs)>::value_type>;
    });
    return found;
}

using KeyList = std::vector<KeyEntry>;

template <class Visit> KeyList listed(const std::string& table, Visit visit) {
    KeyLister lister(table);
    visit(lister);
    return std::move(lister.keys);
}

template <class Spec> KeyList keys_of(Spec spec, const std::string& table) {
    return listed(table, [&](FieldVisitor& f) { spec.fields(f); });
}
KeyList title_key(std::string title) {
    return listed("", [&](FieldVisitor& f) { f.visit(title_field, title); });
}

void append(KeyList& all, KeyList some) {
    all.insert(all.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
}

template <class Spec>
void add_changed(std::set<std::string>& paths, const Spec& spec, const Spec& defaults, const std::string& table) {
    const KeyList now = keys_of(spec, table), before = keys_of(defaults, table);
    for (std::size_t i = 0; i < now.size(); ++i)
        if (now[i].value != before[i].value) paths.insert(now[i].path());
}

/// A scene as TOML, table by table.
class TomlWriter {
public:
    TomlWriter(Keys which, std::set<std::string> needed) : all_(which == Keys::all), needed_(std::move(needed)) {}
    const std::string& text() const { return text_; }

    void key(const KeyEntry& key, bool given) { text_ += line_of(key, given); }
    /// `path`: of this one among its list, where that is another than its name.
    template <class Spec> void table(const std::string& heading, const std::string& name, const Spec& spec,
                                     const Spec& defaults, const std::string& path = {}) {
        table(heading, name, path.empty() ? name : path, keys_of(spec, name), keys_of(defaults, name));
    }

    void constants(const std::vector<FormulaConstant>& constants) {
        if (!constants.empty()) text_ += "\n[constants]\n";
        for (const FormulaConstant& c : constants)
            text_ += c.unit.empty() ? fmt::format("{} = {}\n", c.name, c.value)
                                    : fmt::format("{} = {{ value = {}, unit = \"{}\" }}\n", c.name, c.value, c.unit);
    }

private:
    /// A key at its default stands as a comment, since a default may have no use beside other keys.
    std::string line_of(const KeyEntry& key, bool given) const {
        const std::string value = key.value == absent ? "" : key.value;
        if (!all_) return given ? fmt::format("{} = {}\n", key.field.name, value) : "";
        const std::string unit =
            key.field.unit.empty() || key.field.unit == "-" ? "" : fmt::format("[{}] ", key.field.unit);
        return fmt::format("{}{} = {}  # {}{}\n", given ? "" : "# ", key.field.name, value, unit, key.field.text);
    }

    /// With the tables in it. Its own keys come first: TOML knows no way back from an inner table.
    void table(const std::string& heading, const std::string& name, const std::string& path, const KeyList& now,
               const KeyList& defaults) {
        const auto needed = [&](const KeyEntry& key) {
            return needed_.contains(path + key.path().substr(name.size()));
        };
        std::vector<std::string> tables = {name};
        for (const KeyEntry& key : now)
            if (key.type == "table") tables.push_back(key.path());
        for (const std::string& inner : tables) {
            const auto in_it = [&](std::size_t i) { return now[i].table == inner && now[i].type != "table"; };
            const auto differs = [&](std::size_t i) {
                return now[i].value != absent && now[i].value != defaults[i].value;
            };
            bool any = inner == name;
            for (std::size_t i = 0; i < now.size(); ++i) any |= in_it(i) && differs(i);
            std::string lines;
            for (std::size_t i = 0; i < now.size(); ++i)
                if (in_it(i))
                    lines += line_of(now[i], any && (differs(i) || ((now[i].field.required || needed(now[i])) &&
                                                                    now[i].value != absent)));
            const std::string head = inner == name ? heading : fmt::format("[{}]", inner);
            if (!lines.empty()) text_ += fmt::format("\n{}{}\n{}", any ? "" : "# ", head, lines);
        }
    }

    bool all_;
    std::set<std::string> needed_; ///< keys that are written at their defaults too
    std::string text_;
};

} // namespace

std::string scene_toml(const SceneSpec& scene, Keys which) {
    TomlWriter out(which, needed_keys(scene));
    out.key(title_key(scene.title).front(), !scene.title.empty());
    if (!scene.start.from.empty()) out.table("[start]", "start", scene.start, StartSpec{});
    out.table("[time]", "time", scene.time, TimeSpec{});
    for (const RodSpec& rods : scene.rods)
        if (!rods.body) out.table("[[rods]]", "rods", rods, RodSpec{});
    for (const RodSpec& rods : scene.rods)
        if (rods.body) out.table("[[bodies]]", "bodies", rods, default_body());
    out.constants(scene.constants);
    for_each_spec(scene, [&](const char* name, const auto& spec) {
        out.table(fmt::format("[{}]", name), name, spec, defaults_of(spec));
    });
    for_each_list(scene, [&](const char* name, const auto& specs) {
        for (std::size_t i = 0; i < specs.size(); ++i)
            out.table(fmt::format("[[{}]]", name), name, specs[i], defaults_of(specs[i]),
                      fmt::format("{}.{}", name, i));
    });
    out.table("[output]", "output", scene.output, OutputSpec{});
    return out.text();
}

std::vector<KeyEntry> all_keys() {
    std::vector<std::string> none_included;
    KeyList all = listed("", [&](FieldVisitor& f) { f.visit(include_field, none_included); });
    append(all, title_key(""));
    append(all, keys_of(TimeSpec{}, "time"));
    append(all, keys_of(RodSpec{}, "rods"));
    append(all, keys_of(default_body(), "bodies"));
    all.push_back({"constants", constant_field, "number or table", std::string(absent), {}});
    const SceneSpec none;
    for_each_table(none, [&](const char* name, const auto& member, bool) {
        if constexpr (is_optional_table<std::remove_cvref_t<decltype(member)>>)
            append(all, keys_of(member.value_or(typename std::decay_t<decltype(member)>::value_type{}), name));
        else append(all, keys_of(member, name));
    });
    for_each_list(none, [&](const char* name, const auto& specs) {
        using Spec = typename std::decay_t<decltype(specs)>::value_type;
        if constexpr (HasKinds<Spec>) {
            for (int kind = 0; const std::string_view word : Spec::kinds())
                append(all, keys_of(Spec::of_kind(kind++), fmt::format("{}.{}", name, word)));
        } else {
            append(all, keys_of(Spec{}, name));
        }
    });
    append(all, keys_of(OutputSpec{}, "output"));
    append(all, keys_of(StartSpec{}, "start"));
    return all;
}

std::set<std::string> changed_keys(const SceneSpec& scene) {
    std::set<std::string> paths;
    add_changed(paths, scene.time, TimeSpec{}, "time");
    add_changed(paths, scene.output, OutputSpec{}, "output");
    add_changed(paths, scene.start, StartSpec{}, "start");
    for (std::size_t i = 0; i < scene.rods.size(); ++i)
        add_changed(paths, scene.rods[i], scene.rods[i].body ? default_body() : RodSpec{}, path_of_group(scene, i));
    for_each_table(scene, [&](const char* name, const auto& member, bool) {
        if constexpr (!is_optional_table<std::remove_cvref_t<decltype(member)>>)
            add_changed(paths, member, defaults_of(member), name);
        else if (member) add_changed(paths, *member, defaults_of(*member), name);
    });
    for_each_list(scene, [&](const char* name, const auto& specs) {
        for (std::size_t i = 0; i < specs.size(); ++i)
            add_changed(paths, specs[i], defaults_of(specs[i]), fmt::format("{}.{}", name, i));
    });
    return paths;
}

bool is_list(std::string_view name) {
    bool found = name == "rods" || name == "bodies";
    for_each_list(SceneSpec{}, [&](std::string_view list, const auto&) { found |= name == list; });
    return found;
}

std::string table_heading(const std::string& table) {
    if (table.empty()) return "top level";
    const std::size_t dot = table.find('.');
    if (dot != std::string::npos && has_kinds(table.substr(0, dot)))
        return fmt::format("[[{}]] of kind \"{}\"", table.substr(0, dot), table.substr(dot + 1));
    return is_list(table) ? fmt::format("[[{}]]", table) : fmt::format("[{}]", table);
}

std::string bounds_text(const Field& field) {
    std::vector<std::string> bounds;
    if (std::isfinite(field.above)) bounds.push_back(fmt::format("above {}", field.above));
    if (std::isfinite(field.at_least)) bounds.push_back(fmt::format("at least {}", field.at_least));
    if (std::isfinite(field.at_most)) bounds.push_back(fmt::format("at most {}", field.at_most));
    return fmt::format("{}", fmt::join(bounds, " and "));
}

} // namespace skein
