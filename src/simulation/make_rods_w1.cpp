#include "simulation/make_rods_at.hpp"

namespace skein {

SKEIN_MAKE_PROGRAM(1);
SKEIN_MAKE_RODS_AT(1);

} // namespace skein
