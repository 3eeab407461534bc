// Rods of this rank as bodies in a fluid.
#pragma once

#include "immersion/markers.hpp"
#include "immersion/rod_surface.hpp"
#include "rod/rods.hpp"

#include <span>
#include <vector>

namespace skein {

class ImmersedRods {
public:
    /// Markers about `spacing` apart, `retraction` within the surface, m.
    ImmersedRods(std::span<const RodGroup> groups, const Rods& rods, double spacing, double retraction);
    /// This rank owns other rods from now on.
    void follow(const Rods& rods);

    /// Bodies are groups: what each gives the fluid is summed over its rods.
    std::size_t bodies() const { return groups_.size(); }
    /// Appends markers as rods are now; positions are `lag` behind the rates, s.
    void place(double lag, std::uint32_t first_body, std::int64_t first_identity, Markers& markers) const;

private:
    std::span<const RodGroup> groups_;
    const Rods* rods_;
    std::vector<std::vector<RodMarker>> of_group_;
    std::vector<std::int64_t> first_; ///< of a group's markers among those of all rods
    std::vector<std::size_t> all_;    ///< places of own rods
    std::vector<std::size_t> before_; ///< by own rod: markers of those before it
};

} // namespace skein
