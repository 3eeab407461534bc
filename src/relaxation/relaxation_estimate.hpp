// Stiffness of contacts in a relaxation, and the residual of a run. theory.md section 21
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace skein {

/// Effects of contacts and joints on a rod that relaxes.
struct RelaxationContacts {
    double stiffness = 0;                     ///< stiffness at a touched node, N/m
    double turning = 0;                       ///< stiffness of an element against turns by friction, N m
    double farthest_move = HUGE_VAL;          ///< farthest move of a node in a step, m
    std::vector<double> node = {}, turn = {}; ///< stiffness of joints by node, N/m, and element, N m; empty: none
    std::vector<int> shared = {};             ///< nodes of the group's rods that are one with nodes of others
    bool any() const { return stiffness > 0 || !node.empty(); }
};

/// Largest correction of rods that relax, in their last step.
class RelaxationResidual {
public:
    explicit RelaxationResidual(std::size_t groups) : of_group_(groups) {}
    /// Sets the number of tiles of a group, before their sweeps.
    void expect(std::size_t group, std::size_t tiles) { of_group_[group].assign(tiles, HUGE_VAL); }
    /// Sets the residual of one tile, from any thread.
    void set(std::size_t group, std::size_t tile, double residual) { of_group_[group][tile] = residual; }
    double largest() const {
        double largest = 0;
        for (const auto& tiles : of_group_)
            for (const double r : tiles) largest = std::max(largest, std::isnan(r) ? HUGE_VAL : r);
        return largest;
    }

private:
    std::vector<std::vector<double>> of_group_;
};

} // namespace skein
