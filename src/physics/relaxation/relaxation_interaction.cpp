#include "physics/relaxation/relaxation_interaction.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace skein {

namespace {
constexpr Every measured{64};
}

std::int64_t RelaxationInteraction::next_coupling(std::int64_t done) const {
    return done < plan_.steps ? std::min(measured.next(done), plan_.steps) : measured.next(done);
}

void RelaxationInteraction::end_step(const Step& step, Timers& timers) {
    step_ = step.index;
    if (!measured.due(step_) && step_ != plan_.steps) return;
    const auto timing = timers.time(Phase::agree);
    correction_ = comm_.max(residual_->largest());
}

std::string RelaxationInteraction::progress() const { return fmt::format("  correction {:.3g}", correction_); }

void RelaxationInteraction::summarise(nlohmann::ordered_json& summary) const {
    summary["relaxation"] = {{"settled", settled()}, {"correction", correction_}, {"tolerance", tolerance_}};
}

std::string RelaxationInteraction::text() const {
    return fmt::format("the largest correction that a rod wants is {:.3g}, time.relax_tolerance {:g}", correction_,
                       tolerance_);
}

std::string RelaxationInteraction::report() const {
    return settled() ? fmt::format("Settled in {} steps: {}\n", step_, text()) : std::string();
}

std::string RelaxationInteraction::final_warning() const {
    return settled() || step_ < plan_.steps
               ? std::string()
               : fmt::format("not settled in the {} steps of time.duration: {}", plan_.steps, text());
}

std::string RelaxationInteraction::advice() const {
    return "the relaxation has left the way to rest: give a start nearer to it, weaker loads or more elements";
}

} // namespace skein
