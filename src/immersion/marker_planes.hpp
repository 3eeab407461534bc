// Interpolation of fields to markers, and spreading of changes at markers to fields. theory.md (80)
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

/// Any rank may hold any marker. Ranks whose cells it reaches compute their shares, and the holder adds them. Sums
/// follow the order of identities, rows and planes, so all ranks and threads give the same bits.
class MarkerPlanes {
public:
    using Fields = std::array<double*, 3>; ///< components in the FieldLayout of this rank
    using ReadFields = std::array<const double*, 3>;

    MarkerPlanes(const Communicator& comm, const Threads& threads, const FluidGrid& grid, DeltaKind delta,
                 int across = 1);

    /// Places the markers of this rank. Each has a unique identity among markers of all ranks. Collective.
    void settle(std::span<const Vec3d> places, std::span<const std::int64_t> identities);
    /// Interpolates fields to markers of this rank, from ghosts too if markers reach beyond walls. Collective.
    void interpolate(const ReadFields& fields, std::span<Vec3d> values);
    /// Adds changes at markers of this rank to fields near them, but not to ghosts. Collective.
    void spread(std::span<const Vec3d> changes, const Fields& fields);
    /// Interpolates fields of 0 after a change of 1 at all markers. `fields` are scratch memory. Collective.
    void respond_to_ones(const Fields& fields, std::span<Vec3d> values);

    /// True if markers reach this plane of this rank.
    bool reaches(int plane) const { return !nth(visits_, plane + FieldLayout::ghosts).empty(); }
    /// True if markers reach beyond a wall across x or y in this plane.
    bool reaches_sides(int plane) const { return nth(sides_, plane); }
    /// True if markers reach beyond a wall across z.
    bool reaches_beyond() const { return beyond_; }

private:
    static constexpr int width = DeltaWeights::most;
    /// Cells of one component that a marker reaches, with their weights. Cells without numbers and rows of other ranks
    /// have the weight 0; planes of other ranks are `none`.
    struct Footprint {
        std::array<double, width> along_x, along_y, along_z;
        std::array<std::int32_t, width> cell, row, plane; ///< index in a row, of a row in a plane, of a plane
        std::array<bool, width> inside_x, inside_y;       ///< no ghost
        bool run;                                         ///< cells are adjacent, and none is a ghost
        bool beyond_sides;                                ///< some cells lie beyond walls across x or y
    };
    /// Plane of a marker's footprint.
    struct Visit {
        std::uint32_t marker; ///< number by identity among markers that arrive here
        std::uint8_t component, place;
    };
    /// Marker that arrives at a rank whose cells it reaches.
    struct Guest {
        Vec3d place;
        std::int64_t identity;
    };

    /// Number of shares of a marker, by component and plane. Shares sum over the rows of a plane, unless ranks share
    /// rows.
    std::size_t shares_of_marker() const { return 3 * width * rows_of_plane(); }
    std::size_t rows_of_plane() const { return pencils_.across() > 1 ? width : 1; }
    void lay_out(const Vec3d& place, Footprint* of_components) const;
    void order_arrivals(std::span<const Guest> guests);
    void visit_planes();
    /// `plane` points to the first cell of a plane of the visit's component.
    template <int points> void sum_footprint(const Visit& visit, const double* plane);
    template <int points> void add_footprint(const Visit& visit, double change, double* plane) const;
    template <int points> void clear_footprint(const Visit& visit, double* plane) const;
    /// Adds the shares of planes at markers of this rank. Collective.
    void add_shares(std::span<Vec3d> values);
    const Footprint& footprint(const Visit& visit) const { return footprints_[3 * visit.marker + visit.component]; }
    /// Calls body with the number of points of the delta function as a constant.
    template <class Body> void with_points(Body&& body) const;
    /// Index on this rank of a row or plane of the whole grid, ghosts beyond walls included; `none` elsewhere.
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
    std::vector<std::uint8_t> sides_; ///< by plane: markers reach beyond walls across x or y
    bool beyond_ = false;             ///< markers reach beyond walls across z

    std::vector<std::uint32_t> sent_;       ///< markers of this rank, ordered by the rank that they are sent to
    std::vector<std::int64_t> sent_counts_; ///< by rank
    std::vector<double> shares_back_;       ///< by number in sent_
    std::vector<Vec3d> changes_out_;        ///< by number in sent_

    std::vector<std::int64_t> arrived_;      ///< identities, by arrival
    std::vector<std::uint32_t> arrival_;     ///< number of arrival of each marker, by identity
    std::vector<Footprint> footprints_;      ///< [marker by identity][component]
    std::vector<std::vector<Visit>> visits_; ///< by plane, ghosts beyond walls included
    std::vector<double> shares_;             ///< by arrival
    std::vector<double> whole_;              ///< sums of shares, by marker of this rank
    std::vector<Vec3d> changes_;             ///< by arrival
    RepeatedMessages to_holders_, to_planes_;
};

} // namespace skein
