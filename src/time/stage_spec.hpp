// Keys of [[stage]]: parts of a run, one after the other, each with changes of the scene. docs/stages.md
#pragma once

#include "skein/core/fields.hpp"

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

struct StageSpec {
    std::string name;
    double duration = 0;             ///< s; 0: to its condition, or to the end of the run
    std::string until;               ///< condition that ends it, "column < number"; empty: none
    double check_every = 0;          ///< s: interval at which the condition is looked at; 0: a thousandth of the run
    std::vector<std::string> change; ///< "path=value", which hold from its begin on
    std::string source;              ///< file:line of the table, for messages

    bool comes_to_an_end() const { return duration > 0 || !until.empty(); }
    void fields(FieldVisitor& f);
};

/// Name in formulas for the time at which the present stage has begun.
inline constexpr const char* stage_begin_name = "stage_begin";

/// Key `stages` of tables that act in some stages alone.
inline constexpr Field stages_field{
    .name = "stages", .unit = "", .text = "names of consecutive stages in which it acts; default: all"};

/// Stages in which a table acts, as the present one sees them.
struct ActingStages {
    static constexpr double never = std::numeric_limits<double>::max();
    double begin = never, end = never; ///< s: when the first has begun, and the first after them
    bool now = true, throughout = true;
};

/// True if a table acts in a stage.
bool acts_in(const std::vector<std::string>& stages, const StageSpec& stage);

/// A condition on a column of the time series.
struct StageEnd {
    std::string column;    ///< with or without its unit
    bool is_above = false; ///< holds where the column is larger than the number
    double number = 0;

    bool holds(double value) const { return is_above ? value > number : value < number; }
};

/// Reads "column < number" or "column > number"; none where the text is something else.
std::optional<StageEnd> stage_end(std::string_view text);

} // namespace skein
