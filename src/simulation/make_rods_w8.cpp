#include "simulation/make_rods_at.hpp"

namespace skein {

SKEIN_MAKE_PROGRAM(8);
SKEIN_MAKE_RODS_AT(8);

} // namespace skein
