// What a simulation saves of a run that an I/O error ends, and what is told of it.
#include "simulation/simulation.hpp"

#include <fmt/format.h>

namespace skein {

std::string Simulation::save_what_can_be_saved() {
    if (saving_ || !options_.checkpoint || last_checkpoint_ == clock_.done()) return {};
    for (const auto& output : outputs_) try {
            output->flush();
        } catch (const IoError&) { // the first error is the one that is told
        }
    try {
        keep_state();
    } catch (const IoError& error) {
        return fmt::format("\n  there is no last checkpoint either: {}", error.what());
    }
    std::string text = fmt::format(
        "\n  the state of step {} is kept in a last checkpoint, from which the same command goes on", clock_.done());
    for (const auto& output : outputs_) text += output->lost_before(clock_.done());
    return text;
}

} // namespace skein
