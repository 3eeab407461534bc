// What a relaxation knows of contacts, and a run of a relaxation.                                            theory.md
// section 21
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace skein {

/// What contacts may do to a rod that relaxes.
struct RelaxationContacts {
    double stiffness = 0;            ///< of a node that is touched, N/m
    double turning = 0;              ///< of an element that friction may turn, N m
    double farthest_move = HUGE_VAL; ///< of a node in a step, m
    bool any() const { return stiffness > 0; }
};

/// What a run asks of rods that relax: the largest correction that any still wants, in its last step.
class RelaxationResidual {
public:
    explicit RelaxationResidual(std::size_t groups) : of_group_(groups) {}
    /// Of all tiles of a group, before they are visited.
    void expect(std::size_t group, std::size_t tiles) { of_group_[group].assign(tiles, HUGE_VAL); }
    /// Of one tile, from any thread.
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
