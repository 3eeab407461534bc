#include "fluid/pencils.hpp"

namespace skein {

namespace {

std::string number(int n) { return std::to_string(n); }

} // namespace

int fewest_across(const FluidGrid& grid, int ranks) {
    for (int across = 1; across <= std::min(ranks, most_across(grid)); ++across)
        if (ranks % across == 0 && ranks / across <= most_slabs(grid)) return across;
    return 0;
}

std::string unshared(const FluidGrid& grid, int ranks, int across) {
    const std::string rows = number(grid.cells[1]) + " rows of cells along y",
                      planes = number(grid.cells[2]) + " planes along z";
    if (across < 1)
        return "the fluid has " + rows + " and " + planes + ", too few for " + number(ranks) +
               " ranks: expected at most " + number(most_slabs(grid)) + " slabs of planes times at most " +
               number(most_across(grid)) + " ranks of each";
    if (ranks % across != 0)
        return number(ranks) + " ranks cannot form slabs of " + number(across) + " ranks each: expected a divisor of " +
               number(ranks);
    if (across > most_across(grid))
        return "the fluid has " + rows + ", too few for " + number(across) + " ranks: expected at most " +
               number(most_across(grid));
    if (ranks / across > most_slabs(grid))
        return "the fluid has " + planes + ", too few for " + number(ranks / across) + " slabs, of " + number(ranks) +
               " ranks, " + number(across) + " of them in each: expected at most " + number(most_slabs(grid)) +
               " slabs";
    return {};
}

} // namespace skein
