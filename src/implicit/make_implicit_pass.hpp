// Implicit steps of a group, by its law.
#pragma once

#include "implicit/conserving_pass.hpp"
#include "implicit/implicit_pass.hpp"

namespace skein {

template <int W> std::unique_ptr<TilePass<W>> make_implicit_pass(const ImplicitParts<W>& parts) {
    return with_energy_law(parts.law, [&]<class L>(L) -> std::unique_ptr<TilePass<W>> {
        if (parts.conserves) return std::make_unique<ConservingPass<L, W>>(parts);
        return std::make_unique<ImplicitPass<L, W>>(parts);
    });
}

} // namespace skein
