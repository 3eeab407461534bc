// A study as text, JSON and CSV.
#pragma once

#include "studies/convergence_report.hpp"

#include <string>

namespace skein {

std::string to_text(const Study& study, const StudyFigures& figures);
std::string to_text(const Study& study, const Advice& advice);
std::string to_json(const Study& study, const StudyFigures& figures, const Advice* advice);
/// A row per observable and run: error against core-seconds.
std::string to_csv(const Study& study, const StudyFigures& figures);
/// The runs before they are made, with their predicted cost.
std::string runs_text(const Study& study);

inline constexpr const char* study_format = "skein-converge";

} // namespace skein
