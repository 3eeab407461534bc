// Compiled once per level.
#include "kernels/static_rods_at.hpp"

#include "kernels/make_static_rods.hpp"
#include "loads/load_passes.hpp"

namespace skein {

template std::unique_ptr<TilePass<dual>> make_pass<dual, Across<dual>>(const Load&, const RodGroup&);

std::unique_ptr<StaticRods> make_static_rods_at(const Plan& plan, std::span<const RodGroup> groups,
                                                std::span<const LocalRod> owned, const Surroundings& around) {
    return std::make_unique<StaticRodsAt>(plan, groups, owned, around);
}

} // namespace skein
