#include "physics/loads/load_tables.hpp"

#include "core/field_looker.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>

namespace skein {

namespace {

/// Writes the word for each number that stands for it.
class AutoWords final : public FieldLooker {
public:
    using FieldLooker::visit;
    explicit AutoWords(nlohmann::json& table) : table_(table) {}
    void visit(const Field& f, double& x) override {
        if (f.automatic == x) table_[std::string(f.name)] = "auto";
    }

private:
    nlohmann::json& table_;
};

/// Moves the onset of a load's rise.
class OnsetMover final : public FieldLooker {
public:
    using FieldLooker::visit;
    explicit OnsetMover(double begin) : begin_(begin) {}
    void visit(const Field& f, double& x) override {
        if (f.name == "onset") x = std::max(x, begin_);
    }

private:
    double begin_;
};

} // namespace

bool stays_in_stage(LoadSpec& load, const ActingStages& acting) {
    OnsetMover mover(acting.begin);
    if (acting.now) load.fields(mover);
    return acting.now;
}

void tidy_echo(nlohmann::json& table, const LoadSpec& spec, const CoreTables&, bool) {
    LoadSpec copy = spec; // fields() takes what it may change
    AutoWords words(table);
    copy.fields(words);
}

std::string_view LoadTables::remark(std::string_view table) {
    static const std::map<std::string_view, std::string_view> remarks = {
        {"load.formula",
         "A formula is a text of numbers, names, `+ - * / ^`, brackets and comparisons (`< <= > >= == !=`, which are 1 "
         "or 0). Names are the scene's `[constants]` and `[[table]]`s, `pi`, `e`, and these variables: `x y z` [m] and "
         "`vx vy vz` [m/s], lab position and velocity of the node (for couples: of the middle of the element). They "
         "also include `X Y Z` [m], its position at the start, and `s` [m], arc length at rest. The other variables "
         "are `L` [m], length of the rod, `rod`, its number in the group from 0, and `t` [s]. Functions are `sin cos "
         "tan atan exp log sqrt abs floor tanh sign`, `step(a)` (0 below 0, else 1), `ramp(a, b)` (0 below 0, a/b, 1 "
         "from b on), `min max hypot` of two or more, `atan2 mod` and `if(condition, then, else)`. Units are checked "
         "if all parts have one; a plain number fits any. Values must be finite at the start of the rods, at 16 times "
         "of the run, or of each stage in which the load acts."},
        {"load.magnetic_formula", "Formulas as in `[[load]]` of kind `formula`; places are the middles of elements. "
                                  "Rods need `[rods.magnetisation]`."},
        {"load.muscle_formula",
         "Formulas as in `[[load]]` of kind `formula`. Vertices are between two elements, at the closing point of a "
         "ring, and at clamped ends. The moments on the two elements beside a vertex are equal and opposite."},
        {"damping", "Rates of several `[[damping]]` on one group add up."},
    };
    const auto at = remarks.find(table);
    return at == remarks.end() ? "" : at->second;
}

} // namespace skein
