#include "scene/scene_tables.hpp"

namespace skein {

void load_fields(FieldVisitor& f, LoadSpec& spec) {
    int kind = spec.load.number();
    f.visit_choice({.name = "kind", .unit = "", .text = "which load", .required = true}, kind, load_kinds());
    if (kind != spec.load.number()) spec.load = make_load(kind);
    f.visit({.name = "rods", .unit = "", .text = "groups it acts on; all where absent"}, spec.rods);
    spec.load.fields(f);
}

void damping_fields(FieldVisitor& f, DampingSpec& spec) {
    spec.damping.fields(f);
    f.visit({.name = "rods", .unit = "", .text = "groups it acts on; all where absent"}, spec.rods);
}

std::optional<double> what_auto_means(std::string_view table, std::string_view key) {
    if (table == "time" && key == "dt") return 0;
    const bool has_law = table == "contact" || table == "contact_pair" || table == "wall";
    if (has_law && key == "stiffness") return ContactLaw::automatic;
    return std::nullopt;
}

} // namespace skein
