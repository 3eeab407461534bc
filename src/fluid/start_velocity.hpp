// The velocity of a fluid at the start, from formulas of a scene.
#pragma once

#include "formula/formula.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <string>
#include <vector>

namespace skein {

/// Three formulas of x, y and z, m/s.
class StartVelocity {
public:
    StartVelocity(const std::vector<std::string>& texts, const FormulaScope& names);

    const std::vector<FormulaFault>& faults() const { return faults_; }
    /// Of formulas without faults.
    Vec3d operator()(const Vec3d& place) const;

private:
    Graph graph_;
    std::array<std::size_t, 3> node_{};
    std::vector<FormulaFault> faults_;
};

} // namespace skein
