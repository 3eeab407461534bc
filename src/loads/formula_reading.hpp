// Formulas of a load at set-up: read from texts, checked, and evaluated at the start of rods.
#pragma once

#include "formula/formula.hpp"
#include "loads/formula_vector.hpp"
#include "skein/core/objections.hpp"
#include "skein/loads/load.hpp"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

class FormulaReading {
public:
    explicit FormulaReading(const FormulaScope& scope) : graph(scope.tables), scope_(scope) {}

    /// Reads the three formulas of a key, in the unit expected. Returns their nodes in the graph, or none where they
    /// have faults.
    std::vector<int> read(const char* key, const std::vector<std::string>& texts, std::string_view unit);
    /// Program for the step; not given without values, or where too many are needed at once.
    FormulaVector compile(const char* key, const std::vector<int>& values);

    struct Fault {
        std::string key;
        Part part;
        std::string message;
    };
    const std::vector<Fault>& faults() const { return faults_; }
    void add_faults(Objections& objections) const;

    /// First value that is not finite over a group's start state, at the begin of the time in which the load acts, its
    /// end and some times between; empty where all are finite. Some rods and places of a group are sampled, of a file
    /// among the rods that this rank holds.
    std::string fault(const char* key, const RodGroup& group, const std::vector<int>& values, bool middles) const;

    /// Largest finite value of `worth(values of all of the graph, place)` over the same places and times of the whole
    /// run, except for rods of a file.
    using Worth = std::function<double(const std::vector<double>&, int)>;
    DragRate largest(const RodGroup& group, bool middles, const Worth& worth) const;

    Graph graph;

private:
    FormulaScope scope_;
    std::vector<std::string> text_;
    std::vector<Fault> faults_;
};

/// Throws InputError where the formulas of a load have not been read, or have faults.
void require_read(const FormulaReading* reading, std::string_view kind);

/// Largest sum along a row of |dF/dv| for three values F and three variables v from `first` on, times `weight(node)`.
/// theory.md (40c)
DragRate steepest(const FormulaReading& reading, const RodGroup& group, const std::vector<int>& force, Variable first,
                  const std::function<double(int)>& weight);

} // namespace skein
