#include "physics/scene_spec.hpp"

#include <fmt/format.h>

namespace skein {

void AuditTables::check(const SceneSpec& scene, Objections& objections) {
    if (!scene.output.audit) return;
    for (const RodSpec& rods : scene.rods)
        if (rods.material.law == Law::elastica)
            objections.add(
                "output.audit",
                fmt::format("there is no audit of group '{}': its law \"elastica\" has no energy", rods.name));
}

} // namespace skein
