// Compiled once per width, for the level that has it: all of the kernels that depends on which loads there are.
#include "loads/load_passes.hpp"

namespace skein {

template std::unique_ptr<TilePass<SKEIN_WIDTH>> make_pass<SKEIN_WIDTH, Across<SKEIN_WIDTH>>(const Load&,
                                                                                            const RodGroup&);
template std::unique_ptr<TilePass<SKEIN_WIDTH>> make_pass<SKEIN_WIDTH, Along<SKEIN_WIDTH>>(const Load&,
                                                                                           const RodGroup&);

} // namespace skein
