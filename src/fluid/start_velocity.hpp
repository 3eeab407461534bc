// Start velocity of a fluid by formulas of a scene.
#pragma once

#include "formula/formula.hpp"
#include "formula/program.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Three formulas of x, y and z, m/s.
class StartVelocity {
public:
    StartVelocity(const std::vector<std::string>& texts, const FormulaScope& names);

    const std::vector<FormulaFault>& faults() const { return faults_; }
    /// Writes a component at places along x that are `spacing` apart, by formulas without faults. Any thread may call
    /// it.
    void operator()(int component, const Vec3d& first, double spacing, std::span<double> row) const;

private:
    std::array<FormulaProgram, 3> program_; ///< by component
    std::vector<FormulaFault> faults_;
};

} // namespace skein
