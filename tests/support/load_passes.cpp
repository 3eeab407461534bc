// make_pass<1>() for tests, which read loads/load_pass.hpp alone: passes of all loads take longer to compile than the
// test.
#include "loads/load_passes.hpp"

namespace skein {

template std::unique_ptr<TilePass<1>> make_pass<1, Across<1>>(const Load&, const RodGroup&);

} // namespace skein
