// Steps of a group in a bed, by its law.
#pragma once

#include "implicit/bed_pass.hpp"

namespace skein {

template <int W> std::unique_ptr<TilePass<W>> make_bed_pass(const BedParts<W>& parts) {
    return with_energy_law(parts.rod.law, [&]<class L>(L) -> std::unique_ptr<TilePass<W>> {
        return std::make_unique<BedPass<L, W>>(parts);
    });
}

} // namespace skein
