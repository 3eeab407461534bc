// Compiled once per width, for the level that has it.
#include "implicit/implicit_pass.hpp"

namespace skein {

template <int W> std::unique_ptr<TilePass<W>> make_implicit_pass(const ImplicitParts<W>& parts) {
    return with_energy_law(parts.law, [&]<class L>(L) -> std::unique_ptr<TilePass<W>> {
        return std::make_unique<ImplicitPass<L, W>>(parts);
    });
}

template std::unique_ptr<TilePass<SKEIN_WIDTH>> make_implicit_pass<SKEIN_WIDTH>(const ImplicitParts<SKEIN_WIDTH>&);

} // namespace skein
