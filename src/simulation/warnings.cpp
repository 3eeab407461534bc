// Warnings of a run: states near what the step, the rod law or the discretisation bears.
#include "core/two_digits.hpp"
#include "diagnostics/observables.hpp"
#include "simulation/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

namespace skein {

void print_warning(const std::string& text) { std::fprintf(stderr, "warning: %s\n", text.c_str()); }

void Simulation::warn(bool& told, bool bad, const std::string& text) {
    if (told || !bad) return;
    told = true;
    if (!comm_.root() || options_.quiet) return;
    progress_->finish();
    std::fprintf(stderr, "warning: step %lld: %s\n", static_cast<long long>(clock_.done()), text.c_str());
}

void Simulation::warn_of_limit() {
    const std::string text = comm_.first_text(near_limit_);
    warn(warned_limit_, !text.empty(),
         text + (plan_.force_dt ? "" : "; beyond it the run is stopped: lower dt or time.e_min"));
}

void Simulation::warn_of_gain() {
    const double share = comm_.max(undamped_share_);
    bool told = false;
    warn(told, share > 0,
         fmt::format(
             "rods without damping may have gained energy: the step was up to {:.2g} of the limit that their strains "
             "left, "
             "and beyond {:.2g} strain feeds them. time.dt = {:g} holds, {:g} of the least limit; or give them damping",
             share, StepWatch::feeds, rounded_down(StepWatch::keeps * plan_.dt / std::max(share, StepWatch::feeds)),
             StepWatch::keeps));
}

void Simulation::warn_of_overlap() {
    bool told = false;
    const std::string text = tell_of_overlaps(comm_, interactions_);
    warn(told, !text.empty(), text);
}

void Simulation::warn_of_strain() {
    if (groups_.empty()) return;
    const double turn = last_sample_[observed_turn_per_cell], strain = last_sample_[observed_axial_strain];
    double room = HUGE_VAL; // to the lowest tension limit
    for (std::size_t g = 0; g < groups_.size(); ++g)
        room = std::min(room, plan_.groups[g].tension_limit - groups_[g].element[0].rest_stretch);
    warn(warned_turn_, turn > 2,
         fmt::format(
             "neighbouring elements turn by {:.3g} rad against each other, and 3 rad stops the run: use more elements",
             turn));
    warn(warned_strain_, strain > 0.7,
         fmt::format(
             "an axial strain of {:.3g}: elements are shorter than 0.3 or well on the way to 3 times their length",
             strain));
    warn(warned_tension_, strain > room,
         fmt::format("an axial strain of {:.3g} may be beyond the tension limit (plan): directors flip there", strain));
}

} // namespace skein
