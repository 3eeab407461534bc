// Numbers that are allowed and yet look like slips: so far from their neighbours that a unit or an exponent must be
// wrong. Bounds are wide, some orders beyond what studies use: a warning that is often false is not read.
#pragma once

#include "plan/core_tables.hpp"
#include "skein/core/fields.hpp"
#include "skein/rod/rod_group.hpp"

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skein {

/// Doubts about rods and times, one sentence each.
std::vector<std::string> doubts(const CoreTables& scene, std::span<const RodGroup> groups, double dt);

/// Comparison of a table's numbers with the scales of a scene, by their unit; but places, which may lie anywhere.
class ScaleDoubts {
public:
    ScaleDoubts(double duration, std::span<const RodGroup> groups);
    /// Compares the numbers that `fields` passes to the visitor; `table`: its name for messages.
    void look_at(std::string table, const std::function<void(FieldVisitor&)>& fields);
    std::vector<std::string> take() { return std::move(found_); }

private:
    double duration_, speed_; ///< s, and that of sound in the fastest rod, m/s
    std::vector<std::string> found_;
};

} // namespace skein
