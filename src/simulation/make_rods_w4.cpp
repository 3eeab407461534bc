#include "simulation/make_rods_at.hpp"

namespace skein {

SKEIN_MAKE_PROGRAM(4);
SKEIN_MAKE_RODS_AT(4);

} // namespace skein
