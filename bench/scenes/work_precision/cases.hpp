// The cases of the study, by kind.
#pragma once

#include "scenes/work_precision/study.hpp"

namespace skein::bench {

std::vector<Case> cases_at_rest();
std::vector<Case> cases_of_waves();
std::vector<Case> cases_of_energy();
std::vector<Case> driven_cases();

/// Tip of the thick cantilever over that of Timoshenko's line.
double relative_deflection(const test::Stage& stage);

/// Work until the tip of the thick cantilever is within 1 % of the line for good, over n: for Skein's default and
/// towards what published codes do, one choice at a time.
void one_percent(Table& table);

} // namespace skein::bench
