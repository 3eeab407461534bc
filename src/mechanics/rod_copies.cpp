#include "mechanics/rod_copies.hpp"

#include "mechanics/figures.hpp"
#include "mechanics/rod_profile.hpp"
#include "mechanics/synchronise.hpp"

namespace skein {

void synchronise_positions(const RodGroup& group, std::span<Slot<1>> state, double h) {
    synchronise_positions(tile_of(group, state), h);
}

void synchronise(const RodGroup& group, std::span<Slot<1>> state, double h) { synchronise(tile_of(group, state), h); }

RodFigures figures_of(const RodGroup& group, std::span<const Slot<1>> state, double time, std::int64_t index) {
    std::vector<Slot<1>> copy(state.begin(), state.end()); // tiles need a state that may be written to
    RodFigures figures;
    put_figures(figures_of(tile_of(group, copy, index), time), std::span(&figures, 1));
    return figures;
}

void rod_profile(const RodGroup& group, std::span<const Slot<1>> state, double time, std::span<NodeProfile> out,
                 std::int64_t index) {
    std::vector<Slot<1>> copy(state.begin(), state.end());
    std::vector<NodeProfileOf<Pack<1>>> profile(state.size());
    rod_profile(tile_of(group, copy, index), time, profile.data());
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = {profile[i].strain[0], profile[i].curvature[0], profile[i].energy[0]};
}

} // namespace skein
