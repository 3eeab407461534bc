#include "plan/method_costs.hpp"

#include "plan/plan_words.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

std::string time_text(double s) {
    if (s < 9.5) return fmt::format("{:.1g} s", s);
    return s < 90 ? fmt::format("{:.0f} s", s) : duration_text(s);
}

/// Rounding over many steps leaves no smaller one.
std::string error_text(double error) {
    constexpr double rounding = 1e-9;
    return error < rounding ? fmt::format("below {:.0e}", rounding) : fmt::format("of {:.1g}", error);
}

std::string cost_text(const MethodCosts::Cost& cost, const char* takes) {
    const std::string name = fmt::format("\"{}\"", nth(integrator_names, cost.integrator));
    if (std::isinf(cost.seconds)) return name + " longer";
    std::string text = fmt::format("{} {}about {}", name, takes, time_text(cost.seconds));
    return cost.error > 0 ? text + fmt::format(" at an error {} of the length", error_text(cost.error)) : text;
}

} // namespace

MethodCosts::Pays MethodCosts::pays() const {
    if (2 * of_implicit.seconds < of_explicit.seconds) return Pays::implicit_steps;
    return of_explicit.seconds <= of_implicit.seconds ? Pays::explicit_steps : Pays::neither;
}

PlanLine line_of(const MethodCosts& costs) {
    const auto json = [](const MethodCosts::Cost& of) {
        return nlohmann::ordered_json{
            {"integrator", nth(integrator_names, of.integrator)}, {"predicted_s", of.seconds}, {"error", of.error}};
    };
    static constexpr std::string_view names[] = {"explicit", "implicit", "neither"};
    static constexpr std::string_view words[] = {"explicit steps pay", "implicit steps pay", "neither method pays"};
    return {"method",
            fmt::format("{}: {}, {}", nth(words, costs.pays()), cost_text(costs.of_explicit, "takes "),
                        cost_text(costs.of_implicit, "")),
            "methods",
            {{"explicit", json(costs.of_explicit)},
             {"implicit", json(costs.of_implicit)},
             {"pays", nth(names, costs.pays())},
             {"trial_s", costs.trial_s},
             {"covered", costs.covered}}};
}

} // namespace skein
