// Compiled once per width, for the level that has it.
#include "implicit/make_bed_pass.hpp"

namespace skein {

template std::unique_ptr<TilePass<SKEIN_WIDTH>> make_bed_pass<SKEIN_WIDTH>(const BedParts<SKEIN_WIDTH>&);

} // namespace skein
