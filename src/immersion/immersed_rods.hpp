// Rods of this rank as immersed bodies.
#pragma once

#include "immersion/immersed_kinds.hpp"
#include "immersion/markers.hpp"
#include "immersion/rod_surface.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

namespace skein {

/// A rod or body of the scene.
struct RodNumber {
    std::size_t group = 0;
    std::int64_t index = 0; ///< in its group

    auto operator<=>(const RodNumber&) const = default;
};

class ImmersedRods {
public:
    /// `single`: rods and bodies whose loads are summed alone.
    ImmersedRods(std::span<const RodGroup> groups, const Rods& rods, std::shared_ptr<const ImmersedKinds> kinds,
                 std::vector<RodNumber> single = {});
    /// Takes the rods that this rank owns from now on.
    void rebind(const Rods& rods);

    /// Number of bodies: one a group, whose momentum given to the fluid is summed over its rods.
    std::size_t bodies() const { return groups_.size(); }
    /// Number of markers of own rods.
    std::size_t count() const { return before_.back(); }
    /// True if some rod or body of the scene has markers.
    bool has_markers() const { return has_markers_; }
    /// True if some rod, which is no rigid body, has a sharp surface somewhere.
    bool has_sharp_rods() const { return has_sharp_rods_; }
    /// True if local()[i] is one.
    bool is_sharp_rod(std::size_t i) const { return kind_[i]->sharp && !constants(i).body(); }
    /// Bodies and rods of the scene with sharp surfaces.
    std::size_t sharp_bodies() const { return sharp_.size(); }
    /// Group of a body with a sharp surface, its constants, and its surface.
    std::size_t group_number_of_sharp(std::size_t sharp) const { return sharp_[sharp].group; }
    const RodGroup& constants_of_sharp(std::size_t sharp) const {
        return groups_[sharp_[sharp].group].kind(sharp_[sharp].index);
    }
    SweptSurface swept_surface_of(std::size_t sharp, const FluidGrid& grid) const;
    /// Number of local()[i] among the bodies with sharp surfaces; -1: it is none.
    std::int64_t sharp_number(std::size_t i) const { return sharp_number_[i]; }
    /// The same of any rod or body of the scene.
    std::int64_t sharp_number(const RodNumber& rod) const;
    const std::vector<RodNumber>& single() const { return single_; }
    /// Appends markers of rods as they are now; positions lag behind rates by `lag` [s]. Parts of rods of single() have
    /// the numbers from `first_body` on. Arms are those after `ahead` [s], from the first node of a rod or the centre
    /// of mass of a body.
    void place(double lag, double ahead, std::uint32_t first_body, std::int64_t first_identity, Markers& markers) const;
    /// Calls f(m, marker) for the markers of local()[i], m being their number among count().
    template <class F> void for_markers(std::size_t i, F&& f) const {
        const std::vector<RodMarker>& on_rod = kind_[i]->markers;
        for (std::size_t m = 0; m < on_rod.size(); ++m) f(before_[i] + m, on_rod[m]);
    }
    /// Vector from the axis, or the centre of a body, to a marker, m, lab.
    static Vec3d off_axis(const RodMarker& marker, const Mat3d& frame) {
        const Vec3d across = marker.off_d1 * frame.d1 + marker.off_d2 * frame.d2;
        return marker.off_d3 == 0 ? across : across + marker.off_d3 * frame.d3;
    }
    /// Place of a marker, m, lab.
    static Vec3d place_of(const RodMarker& marker, const RodCopy& rod) {
        return along(marker, lane(rod.state[marker.element].position, 0),
                     lane(rod.state[second_slot(marker, rod.state.size())].position, 0)) +
               off_axis(marker, rod.frames[marker.element]);
    }
    /// Slot of the second node of a marker's element; a body has one slot.
    static std::size_t second_slot(const RodMarker& marker, std::size_t slots) {
        return std::min<std::size_t>(marker.element + 1, slots - 1);
    }
    /// Interpolates between the nodes of a marker's element.
    static Vec3d along(const RodMarker& marker, const Vec3d& first, const Vec3d& second) {
        return (1 - marker.along) * first + marker.along * second;
    }
    const Rods& rods() const { return *rods_; }
    /// Constants of local()[i], and its inertia in the fluid.
    const RodGroup& constants(std::size_t i) const { return *constants_[i]; }
    const InertiaInFluid& inertia(std::size_t i) const { return *kind_[i]->inertia; }
    /// Reads copies of all own rods, drifted by `lag` [s].
    void read(double lag, const RodReader& reader) const { rods_->read(all_, Copy::frames, lag, reader); }

private:
    /// Finds the numbers of own rods in single_.
    void number_single();
    /// Sets parts and arms of the markers of local()[i], of which `first` is the first one.
    void place_arms(std::size_t i, const RodCopy& rod, std::size_t first, double ahead, std::uint32_t first_part,
                    Markers& markers) const;

    std::span<const RodGroup> groups_;
    const Rods* rods_;
    std::shared_ptr<const ImmersedKinds> kinds_;
    /// Number of the first marker of a group in the scene, and by rod, or once, of markers from one rod to the next.
    struct OfGroup {
        std::int64_t first;
        std::vector<std::int64_t> before; ///< from the first one, of rods with sizes of their own
        std::int64_t of_each;             ///< of rods that are alike

        std::int64_t of_rod(std::int64_t i) const { return first + (before.empty() ? i * of_each : nth(before, i)); }
    };
    std::vector<OfGroup> groups_in_scene_;
    std::vector<RodNumber> sharp_; ///< those with sharp surfaces, in their order
    bool has_markers_ = false, has_sharp_rods_ = false, has_shares_ = false;
    std::vector<std::size_t> all_;                 ///< numbers of own rods
    std::vector<std::size_t> before_;              ///< by own rod: markers of own rods before it
    std::vector<const RodGroup*> constants_;       ///< by own rod
    std::vector<const ImmersedKinds::Kind*> kind_; ///< by own rod
    std::vector<std::int64_t> sharp_number_;       ///< by own rod
    std::vector<RodNumber> single_;
    std::vector<std::uint32_t> single_number_; ///< by own rod, or Markers::no_part; empty without single_
};

} // namespace skein
