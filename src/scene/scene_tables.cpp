#include "scene/scene_tables.hpp"

#include <utility>

namespace skein {

Load make_load(int kind) {
    Load load;
    [&]<std::size_t... I>(std::index_sequence<I...>) {
        ((static_cast<int>(I) == kind ? static_cast<void>(load.emplace<I>()) : void()), ...);
    }
    (std::make_index_sequence<std::variant_size_v<Load>>{});
    return load;
}

void load_fields(FieldVisitor& f, LoadSpec& spec) {
    int kind = static_cast<int>(spec.load.index());
    f.visit_choice({.name = "kind", .unit = "", .text = "which load", .required = true}, kind, load_kinds);
    if (kind != static_cast<int>(spec.load.index())) spec.load = make_load(kind);
    f.visit({.name = "rods", .unit = "", .text = "groups it acts on; all where absent"}, spec.rods);
    std::visit([&](auto& load) { load.fields(f); }, spec.load);
}

void damping_fields(FieldVisitor& f, DampingSpec& spec) {
    spec.damping.fields(f);
    f.visit({.name = "rods", .unit = "", .text = "groups it acts on; all where absent"}, spec.rods);
}

} // namespace skein
