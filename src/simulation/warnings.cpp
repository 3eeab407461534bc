#include "simulation/warnings.hpp"

#include "core/troubleshooting.hpp"
#include "core/two_digits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace skein {

void print_warning(const std::string& text) { std::fprintf(stderr, "warning: %s\n", with_place_on_page(text).c_str()); }

void Warnings::warn(const std::string& about, bool bad, const std::string& text) {
    if (!bad || !printed_.insert(about).second) return;
    if (!world_.comm.root() || quiet_) return;
    end_line();
    print_warning(fmt::format("step {}: {}", world_.clock.done(), text));
}

bool Warnings::due() const {
    return (!world_.near_limit().empty() && !printed_.contains("limit")) || has_new_overlaps(world_.interactions());
}

void Warnings::warn_of_limits() {
    const std::string text = world_.comm.first_text(world_.near_limit());
    warn("limit", !text.empty(),
         text + (world_.plan.force_dt ? "" : "; beyond it the run is stopped: lower dt or time.e_min"));
    const std::string overlaps = new_overlaps(world_.comm, world_.interactions());
    warn("overlaps: " + overlaps, !overlaps.empty(), overlaps);
}

void Warnings::warn_of_gain() {
    const double share = world_.comm.max(world_.undamped_share());
    const double held = rounded_down(StepWatch::keeps * world_.plan.dt / std::max(share, StepWatch::feeds));
    warn("gain", share > 0,
         fmt::format("rods without damping may have gained energy: the step was up to {:.2g} of the limit that their "
                     "strains left, and beyond {:.2g} strain feeds them. time.dt = {:g} holds, {:g} of the least "
                     "limit; or give them damping",
                     share, StepWatch::feeds, held, StepWatch::keeps));
}

void Warnings::warn_of_strain(const Observation& observation) {
    const double turn = observation.turn(), strain = observation.strain();
    double room = HUGE_VAL; // to the lowest tension limit
    for (std::size_t g = 0; g < world_.groups.size(); ++g)
        room = std::min(room, world_.plan.groups[g].tension_limit - world_.groups[g].element[0].rest_stretch);
    warn("turn", turn > 2,
         fmt::format("neighbouring elements turn by {:.3g} rad against each other, and 3 rad stops the run: use more "
                     "elements",
                     turn));
    warn("strain", strain > 0.7,
         fmt::format("an axial strain of {:.3g}: elements are shorter than 0.3 or well on the way to 3 times their "
                     "length",
                     strain));
    warn("tension", strain > room,
         fmt::format("an axial strain of {:.3g} may be beyond the tension limit (plan): directors flip there", strain));
}

} // namespace skein
