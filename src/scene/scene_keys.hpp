// Every key of a scene as a flat list: for the reference page, for messages, and to see which keys a scene sets.
#pragma once

#include "core/field_looker.hpp"
#include "physics/scene_spec.hpp"

#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

inline constexpr Field include_field{.name = "include",
                                     .unit = "",
                                     .text = "files beside this one whose tables are added to the scene: their lists "
                                             "come before its own; if both set a key, the scene's value is used"};
inline constexpr Field title_field{
    .name = "title", .unit = "", .text = "title of the scene, for summaries and pictures"};

/// True if scenes have a list of tables of this name.
bool is_list(std::string_view name);

struct KeyEntry {
    std::string table; ///< "time", "rods.material", "load.<kind>"; "" at top level
    Field field;
    std::string_view type; ///< "number", "3 numbers", "table", ...
    std::string value;     ///< as a scene spells it; "-" where absent
    std::span<const std::string_view> choices;

    std::string path() const { return table.empty() ? std::string(field.name) : table + "." + std::string(field.name); }
};

/// Finds the name of a table, or its kind.
class NameOfTable : public FieldLooker {
public:
    using FieldLooker::visit;
    void visit(const Field& f, std::string& s) override {
        if (depth_ == 0 && f.name == "name") name_ = s;
    }
    void visit_choice(const Field& f, int& value, std::span<const std::string_view> names) override {
        if (depth_ == 0 && f.name == "kind") kind_ = names[static_cast<std::size_t>(value)];
    }
    bool enter(const Field&) override {
        ++depth_;
        return true;
    }
    void leave() override { --depth_; }
    const std::string& found() const { return name_.empty() ? kind_ : name_; }
    bool is_called(std::string_view word) const { return word == name_ || word == kind_; }

private:
    std::string name_, kind_;
    int depth_ = 0;
};

/// Name of a table of a list, or its kind where it has none.
template <class Spec> std::string name_of_table(Spec spec) {
    NameOfTable finder;
    spec.fields(finder);
    return finder.found();
}

/// All keys with their defaults, table by table, each load kind as a table "load.<kind>".
std::vector<KeyEntry> all_keys();

/// Paths such as "rods.0.section.taper" of the keys that differ from their defaults: what a scene made in C++ has set.
std::set<std::string> changed_keys(const SceneSpec& scene);

/// KeyEntry::table as a scene opens it: "[rods.shape]", "[[load]] of kind "<kind>"".
std::string table_heading(const std::string& table);

/// "above 0 and at most 1"; empty where every value is accepted.
std::string bounds_text(const Field& field);

} // namespace skein
