// Between a field and markers in it: what the field is at the markers, and what changes at the markers do to the field.
#pragma once

#include "fluid/pencils.hpp"
#include "immersion/delta.hpp"
#include "parallel/communicator.hpp"
#include "parallel/messages.hpp"
#include "parallel/threads.hpp"
#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// Any rank may hold any marker: ranks whose cells it reaches work out their share of it, and the holder puts shares
/// together. Sums are made in the order of identities, rows and planes: the same bits on any ranks and threads.
class MarkerPlanes {
public:
    using Fields = std::array<double*, 3>; ///< components, as FieldLayout of this rank has them
    using ReadFields = std::array<const double*, 3>;

    MarkerPlanes(const Communicator& comm, const Threads& threads, const FluidGrid& grid, DeltaKind delta,
                 int across = 1);

    /// Markers of this rank are at these places from now on; each has an identity of its own among those of all ranks.
    /// Collective.
    void settle(std::span<const Vec3d> places, std::span<const std::int64_t> identities);
    /// What the fields are at markers of this rank. Ghosts are read where markers reach beyond walls. Collective.
    void interpolate(const ReadFields& fields, std::span<Vec3d> values);
    /// Adds changes of the markers of this rank to the fields near them; ghosts are left alone. Collective.
    void spread(std::span<const Vec3d> changes, const Fields& fields);
    /// What interpolate() finds at markers of this rank in fields of 0 to which a change of 1 at all markers is added;
    /// the fields are of no meaning before and after. Collective.
    void respond_to_ones(const Fields& fields, std::span<Vec3d> values);

    /// Whether markers reach this plane of this rank.
    bool reaches(int plane) const { return !nth(visits_, plane + FieldLayout::ghosts).empty(); }
    /// Whether they reach beyond a wall across x or y in it; beyond one across z in any.
    bool reaches_sides(int plane) const { return nth(sides_, plane); }
    bool reaches_beyond() const { return beyond_; }

private:
    static constexpr int width = DeltaWeights::most;
    /// Where a component feels a marker. Weights of cells that no field has, and of rows of other ranks, are 0; planes
    /// of other ranks are `none`.
    struct Footprint {
        std::array<double, width> along_x, along_y, along_z;
        std::array<std::int32_t, width> cell, row, plane; ///< of numbers within a row; of rows within a plane
        std::array<bool, width> inside_x, inside_y;       ///< no ghost
        bool run, beyond_sides; ///< cells are next to each other, and none is a ghost; some ghosts are beyond walls
                                ///< across x or y
    };
    /// A plane of a marker's footprint.
    struct Visit {
        std::uint32_t marker; ///< of those that come here, by identity
        std::uint8_t component, place;
    };
    struct Guest {
        Vec3d place;
        std::int64_t identity;
    };

    /// Shares of a marker, by component and plane: sums over the rows of a plane, or one for each row where ranks share
    /// these.
    std::size_t shares_of_marker() const { return 3 * width * rows_of_plane(); }
    std::size_t rows_of_plane() const { return pencils_.across() > 1 ? width : 1; }
    void lay_out(const Vec3d& place, Footprint* of_components) const;
    void order_arrivals(std::span<const Guest> guests);
    void visit_planes();
    /// Of a component of a field, from its number of the first cell of a plane on.
    template <int points> void sum_footprint(const Visit& visit, const double* plane);
    template <int points> void add_footprint(const Visit& visit, double change, double* plane) const;
    template <int points> void clear_footprint(const Visit& visit, double* plane) const;
    /// Sums of shares of planes at markers of this rank. Collective.
    void add_shares(std::span<Vec3d> values);
    const Footprint& footprint(const Visit& visit) const { return footprints_[3 * visit.marker + visit.component]; }
    /// body of as many points as weights have.
    template <class Body> void with_points(Body&& body) const;
    /// Number of a row or plane of the whole grid among those of this rank, ghosts beyond walls among them.
    int here(int cell, int direction, const Slab& own) const;
    template <class Body> void for_ranks_of(const Vec3d& place, Body&& body) const;
    void send_to_planes(std::span<const Vec3d> places);
    void make_messages(std::span<const std::int64_t> arriving);

    Communicator comm_;
    const Threads& threads_;
    FluidGrid grid_;
    DeltaKind delta_;
    Pencils pencils_;
    FieldLayout layout_;
    std::vector<std::uint8_t> sides_; ///< by plane
    bool beyond_ = false;

    std::vector<std::uint32_t> sent_; ///< markers of this rank, by the rank that they go to, rising
    std::vector<std::int64_t> sent_counts_;
    std::vector<double> shares_back_; ///< of sent_
    std::vector<Vec3d> changes_out_;  ///< of sent_

    std::vector<std::int64_t> arrived_;      ///< identities, by arrival
    std::vector<std::uint32_t> arrival_;     ///< of markers that come here, by identity: their number among arrivals
    std::vector<Footprint> footprints_;      ///< of these, [marker][component]
    std::vector<std::vector<Visit>> visits_; ///< by plane, ghosts beyond walls among them
    std::vector<double> shares_;             ///< by arrival
    std::vector<double> whole_;              ///< sums of shares, by marker of this rank
    std::vector<Vec3d> changes_;             ///< by arrival
    RepeatedMessages to_holders_, to_planes_;
};

} // namespace skein
