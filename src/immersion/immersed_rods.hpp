// Rods of this rank as bodies in a fluid.
#pragma once

#include "immersion/markers.hpp"
#include "immersion/rod_surface.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <span>
#include <vector>

namespace skein {

class ImmersedRods {
public:
    /// Markers about a cell apart, `retraction` within the surface, m.
    ImmersedRods(std::span<const RodGroup> groups, const Rods& rods, const FluidGrid& grid, double retraction);
    /// This rank owns other rods from now on.
    void follow(const Rods& rods);

    /// Bodies are groups: what each gives the fluid is summed over its rods.
    std::size_t bodies() const { return groups_.size(); }
    /// Markers of own rods.
    std::size_t count() const { return before_.back(); }
    /// Appends markers as rods are now; positions are `lag` behind the rates, s.
    void place(double lag, std::uint32_t first_body, std::int64_t first_identity, Markers& markers) const;
    /// f(m, marker) of the markers of local()[i], by their number among count().
    template <class F> void for_markers(std::size_t i, F&& f) const {
        const std::vector<RodMarker>& on_rod = nth(of_group_, rods_->local()[i].group);
        for (std::size_t m = 0; m < on_rod.size(); ++m) f(before_[i] + m, on_rod[m]);
    }
    /// A marker of a rod in the lab, m.
    static Vec3d off_axis(const RodMarker& marker, const Mat3d& frame) {
        return marker.off_d1 * frame.d1 + marker.off_d2 * frame.d2;
    }
    static Vec3d place_of(const RodMarker& marker, const RodCopy& rod) {
        return along(marker, lane(rod.state[marker.element].position, 0),
                     lane(rod.state[marker.element + 1].position, 0)) +
               off_axis(marker, rod.frames[marker.element]);
    }
    /// Between what the nodes of its element have.
    static Vec3d along(const RodMarker& marker, const Vec3d& first, const Vec3d& second) {
        return (1 - marker.along) * first + marker.along * second;
    }
    const Rods& rods() const { return *rods_; }
    /// Copies of all own rods, moved on by `lag`.
    void read(double lag, const RodReader& reader) const { rods_->read(all_, Copy::frames, lag, reader); }

private:
    std::span<const RodGroup> groups_;
    const Rods* rods_;
    std::vector<std::vector<RodMarker>> of_group_;
    std::vector<std::int64_t> first_; ///< of a group's markers among those of all rods
    std::vector<std::size_t> all_;    ///< places of own rods
    std::vector<std::size_t> before_; ///< by own rod: markers of those before it
};

} // namespace skein
