// Compiled once per width, for the level that has it.
#include "implicit/make_implicit_pass.hpp"

namespace skein {

template std::unique_ptr<TilePass<SKEIN_WIDTH>> make_implicit_pass<SKEIN_WIDTH>(const ImplicitParts<SKEIN_WIDTH>&);

} // namespace skein
