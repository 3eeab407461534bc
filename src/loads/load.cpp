#include "skein/loads/load.hpp"

#include <algorithm>

namespace skein {

namespace {

/// Key at fault where a load acts on rods that it does not apply to: 'rods', if the scene has it.
std::string_view choice_of_groups(const Objections& objections) { return objections.given("rods") ? "rods" : ""; }

void object_to_rings(const std::string& what, RodSpecs groups, Objections& objections) {
    for (const RodSpec* rods : groups)
        if (rods->shape.closed)
            objections.add(choice_of_groups(objections), what + " needs rods with two ends, but those of group '" +
                                                             rods->name +
                                                             "' are rings (closed = true): name open ones in 'rods'");
}

} // namespace

void object_to_rigid_bodies(const std::string& what, RodSpecs groups, Objections& objections) {
    for (const RodSpec* rods : groups)
        if (rods->body)
            objections.add(choice_of_groups(objections), what + " is not for rigid bodies, such as group '" +
                                                             rods->name + "': name other groups in 'rods'");
}

int Load::number() const {
    const auto kinds = load_kinds();
    return static_cast<int>(std::find(kinds.begin(), kinds.end(), kind()) - kinds.begin());
}

void Load::check(RodSpecs groups, Objections& objections) const {
    const std::string what = "a load of kind " + std::string(kind());
    if (!held_->traits().for_rigid_bodies) object_to_rigid_bodies(what, groups, objections);
    if (!held_->traits().for_rings) object_to_rings(what, groups, objections);
    held_->check(groups, objections);
}

} // namespace skein
