// Input of the plans of physics, and the list of these.
#pragma once

#include "physics/loads/loads_with_formulas.hpp"
#include "physics/scene_spec.hpp"
#include "plan/physics_plan.hpp"
#include "skein/rod/rod_group.hpp"

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace skein {

struct PlanInput {
    PlanInput(const SceneSpec& resolved, const SceneSpec& written, std::span<const RodGroup> of)
        : scene(resolved), as_written(written), groups(of), loads(loads_with_formulas(resolved)) {}

    const SceneSpec& scene;      ///< with numbers in place of those that stand for "auto"
    const SceneSpec& as_written; ///< with these
    std::span<const RodGroup> groups;
    std::vector<Load> loads; ///< of the scene, with their formulas read
};

/// Plans of physics, in the order in which they act.
class PlannedPhysics {
public:
    template <class Planned, class... Parts> void add(Parts&&... parts) {
        all_.push_back(std::make_shared<Planned>(std::forward<Parts>(parts)...));
    }
    std::vector<std::shared_ptr<PhysicsPlan>> take() { return std::move(all_); }

private:
    std::vector<std::shared_ptr<PhysicsPlan>> all_;
};

} // namespace skein
