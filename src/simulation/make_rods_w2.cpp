#include "simulation/make_rods_at.hpp"

namespace skein {

SKEIN_MAKE_PROGRAM(2);
SKEIN_MAKE_RODS_AT(2);

} // namespace skein
