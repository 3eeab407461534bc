#include "loads/load_spec.hpp"

#include "time/stage_spec.hpp"

namespace skein {

namespace {
constexpr Field groups{.name = "rods", .unit = "", .text = "groups on which it acts; default: all"};
}

void LoadSpec::fields(FieldVisitor& f) {
    int kind = load.number();
    f.visit_choice({.name = "kind", .unit = "", .text = "kind of load", .required = true}, kind, load_kinds());
    if (kind != load.number()) load = make_load(kind);
    f.visit(groups, rods);
    f.visit(stages_field, stages);
    load.fields(f);
}

void DampingSpec::fields(FieldVisitor& f) {
    damping.fields(f);
    f.visit(groups, rods);
    f.visit(stages_field, stages);
}

} // namespace skein
