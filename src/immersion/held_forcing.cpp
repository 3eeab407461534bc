#include "immersion/held_forcing.hpp"

#include "parallel/exact_sum.hpp"

#include <algorithm>

namespace skein {

void sweep_held_forces(const Communicator& comm, const FlowStage& stage, int sweeps, double slip,
                       std::span<HeldForcing* const> of_bodies) {
    for (HeldForcing* bodies : of_bodies) bodies->find_slips(stage);
    const auto small = [&] {
        return std::all_of(of_bodies.begin(), of_bodies.end(),
                           [slip](const HeldForcing* bodies) { return bodies->largest_slip() < slip; });
    };
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        if (slip > 0 && small()) break;
        stage.response->clear();
        for (HeldForcing* bodies : of_bodies) bodies->push(stage);
        stage.response->respond();
        std::array<std::vector<double>, 2> terms;
        for (HeldForcing* bodies : of_bodies) {
            bodies->find_response(stage);
            bodies->add_terms(terms);
        }
        const std::vector<double> sums = exact_sums(comm, terms);
        const double times = sums[1] > 0 ? sums[0] / sums[1] : 0; // (87)
        stage.response->add(times);
        for (HeldForcing* bodies : of_bodies) bodies->take(times, stage);
    }
    for (HeldForcing* bodies : of_bodies) bodies->end_sweeps(stage);
}

} // namespace skein
