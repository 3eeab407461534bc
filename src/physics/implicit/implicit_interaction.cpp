#include "physics/implicit/implicit_interaction.hpp"

#include "physics/implicit/body_speeds.hpp"
#include "plan/plan.hpp"
#include "rod/body_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Parts of the period of a drive. With two of them the companion may find the drive at its zeros alone, and with one
/// both would find it the same at all times.
constexpr double parts_in_a_period = 4;

/// Parts so much shorter than the limit of explicit steps that these would keep the tolerance, too.
std::int64_t resolving_parts(const Plan& plan, double tolerance) {
    constexpr auto most = static_cast<double>(StepControl::most_parts);
    if (!std::isfinite(plan.limit) || tolerance == 0) return StepControl::most_parts;
    const double shorter = 4 * std::sqrt(std::max(1.0, 1e-2 / tolerance));
    return static_cast<std::int64_t>(std::clamp(std::ceil(shorter * plan.dt / plan.limit), 2.0, most));
}

} // namespace

ImplicitInteraction::ImplicitInteraction(const InteractionParts& parts, const Needs& needs)
    : comm_(parts.comm), rods_(&parts.rods),
      control_(needs.tolerance * needs.length, parts.plan.steps, resolving_parts(parts.plan, needs.tolerance),
               parts_in_a_period * parts.plan.dt / needs.period),
      companion_(needs.remembers), groups_(parts.groups), walls_(parts.around.walls), tolerance_(needs.tolerance),
      length_(needs.length), way_(needs.way) {}

double ImplicitInteraction::fastest() const {
    return std::isfinite(way_) ? std::max(fastest_node(*rods_, groups_).speed, fastest_wall(walls_.get())) : 0;
}

std::string ImplicitInteraction::fastest_body() const {
    if (!std::isfinite(way_)) return {};
    const FastestNode node = fastest_node(*rods_, groups_);
    return (fastest_wall(walls_.get()) > node.speed ? "a wall" : name_of_body(groups_, node.gid)) + " moves";
}

std::string ImplicitInteraction::advice() const {
    using Obstacle = StepControl::Obstacle;
    switch (control_.obstacle()) {
    case Obstacle::contact:
        return "contacts are too stiff for these steps: integrator = \"verlet\" or \"implicit_bed\", or a smaller "
               "contact.stiffness, may do";
    case Obstacle::speed:
        return "something throws it, or it starts so fast: a softer load, a smaller velocity or a smaller time.dt may "
               "do";
    case Obstacle::error:
        return "a larger time.tolerance, or a given time.dt, may do";
    case Obstacle::corrections:
        break;
    }
    return "an implicit step does not converge: integrator = \"implicit_damped\", a larger time.tolerance, or a given, "
           "smaller time.dt may do";
}

void ImplicitInteraction::summarise(nlohmann::ordered_json& summary) const {
    summary["implicit"] = {{"parts", control_.parts()}, {"largest_parts", control_.largest()}};
    if (tolerance_ == 0) return;
    summary["implicit"]["error"] = control_.distance() / length_;
    summary["implicit"]["largest_error"] = control_.most() / length_;
}

std::string ImplicitInteraction::final_warning() const {
    const double most = control_.most() / length_;
    if (tolerance_ == 0 || most <= tolerance_) return {};
    return fmt::format(
        "warning: places may be wrong by {:.2g} of the largest length, {:.2g} at the end, and time.tolerance is {:g}: "
        "a run in steps twice as long went there. A smaller time.tolerance shows which holds",
        most, control_.distance() / length_, tolerance_);
}

SavedNumbers ImplicitInteraction::saved() const {
    if (tolerance_ == 0) return {.name = saved_name(), .numbers = control_.numbers()};
    return {.name = saved_name(),
            .numbers = control_.numbers(),
            .columns = Companion::columns,
            .rows = companion_.rows(*rods_)};
}

void ImplicitInteraction::restore(const SavedNumbers& saved) {
    control_.set(saved.numbers);
    if (tolerance_ > 0) companion_.set(comm_, *rods_, saved.rows);
}

} // namespace skein
