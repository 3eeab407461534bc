#include "replay.hpp"

namespace skein::replay {

std::vector<Deviation> replay_curves(const Entry& file) { throw NotBuilt("curves (" + file.path() + ")"); }

} // namespace skein::replay
