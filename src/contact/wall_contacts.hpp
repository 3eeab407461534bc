// Contacts of the rods of one group with walls, per tile, lane and wall: forces of the last step, sums since the start,
// and the springs of friction. Sums run along the rod and in time, lane by lane: the same bits for any ranks, threads and lanes.
#pragma once

#include "contact/wall.hpp"
#include "contact/wall_points.hpp"
#include "rod/rods.hpp"
#include "skein/core/aligned.hpp"
#include "skein/rod/tile.hpp"

#include <algorithm>

namespace skein {

/// Figures of one rod at one wall.
struct WallFigures {
    Vec3d force{0, 0, 0};                       ///< of the rod on the wall at the last step, N
    double normal = 0;                          ///< sum of normal forces, N
    double touching = 0;                        ///< nodes
    double max_overlap = 0;                     ///< overlap over diameter
    double stiffness = 0;                       ///< largest tangent stiffness dN/dg of a node, N/m
    double elastic_energy = 0;                  ///< in all springs, J
    double friction_work = 0, viscous_work = 0; ///< sums since the start, J
};

/// The contacts of one group with walls, whatever the width of its tiles.
class WallContacts {
public:
    virtual ~WallContacts() = default;
    /// Zeros where the wall does not act.
    virtual WallFigures figures(RodPlace rod, int wall) const = 0;
    /// Appends the force of each rod that pressed a wall at the last step, N: normal forces, and forces along a direction.
    virtual void append_normal(int wall, std::vector<double>& forces) const = 0;
    virtual void append_force(int wall, const Vec3d& direction, std::vector<double>& forces) const = 0;
    /// Largest overlap of a node with the wall at the last step, over its diameter.
    virtual double max_overlap(int wall) const = 0;
};

template <int W> class WallContactTiles final : public WallContacts {
public:
    using P = Pack<W>;
    /// Forces of the last step, lane by lane.
    struct Entry {
        Vec3<P> force{};
        P normal{}, touching{}, max_overlap{}, stiffness{}, elastic_energy{};
    };
    /// Memory of a node at a wall from step to step, and work since the start.
    struct Kept {
        ContactMemory<P> of_last;
        P friction_work{}, viscous_work{}; ///< J
    };
    /// Contacts of the rods of one tile.
    struct TileContacts {
        AlignedVector<Entry> entry;        ///< one per wall that acts on the group
        AlignedVector<Kept> kept;          ///< [point][wall]
        std::vector<std::uint8_t> touched; ///< [point][wall]: its spring may be other than zero
        std::vector<std::uint8_t> near;    ///< [wall]: the tile's box is within reach at this step
        bool any_touched = false;
        bool busy = false; ///< entries of the last step may be other than zero
        int lanes = 0;     ///< that have rods of their own
    };

    WallContactTiles(const Walls& walls, const RodGroup& group) : points_(wall_points(group)) {
        for (std::size_t w = 0; w < walls.count(); ++w) {
            const bool acts = walls.wall[w].acts_on(group.name());
            place_.push_back(acts ? static_cast<int>(acting_.size()) : -1);
            if (acts) acting_.push_back(static_cast<int>(w));
        }
    }

    /// Numbers of the walls that act on the group.
    const std::vector<int>& acting() const { return acting_; }
    void add_tile(const RodTile<W>& rod) {
        TileContacts& contacts = tiles_.emplace_back();
        contacts.entry.resize(acting_.size());
        contacts.kept.resize(points_ * acting_.size());
        contacts.touched.assign(points_ * acting_.size(), 0);
        contacts.near.assign(acting_.size(), 0);
        contacts.lanes = rod.lanes;
    }
    TileContacts& of_tile(std::size_t tile) { return tiles_[tile]; }

    void append_normal(int wall, std::vector<double>& forces) const override {
        append(wall, forces, [](const Entry& e, int l) { return e.normal[l]; });
    }
    void append_force(int wall, const Vec3d& direction, std::vector<double>& forces) const override {
        append(wall, forces, [&](const Entry& e, int l) { return dot(lane(e.force, l), direction); });
    }
    double max_overlap(int wall) const override {
        const int at = place_[static_cast<std::size_t>(wall)];
        double most = 0;
        if (at < 0) return most;
        for (const TileContacts& contacts : tiles_)
            for (int l = 0; contacts.busy && l < W; ++l)
                most = std::max(most, contacts.entry[static_cast<std::size_t>(at)].max_overlap[l]);
        return most;
    }
    /// Spare lanes, which repeat the last rod, are for the reader to skip.
    WallFigures figures(RodPlace rod, int wall) const override {
        const auto [tile, l] = rod;
        const int at = place_[static_cast<std::size_t>(wall)];
        if (at < 0) return {};
        const TileContacts& contacts = tiles_[tile];
        const Entry& e = contacts.entry[static_cast<std::size_t>(at)];
        WallFigures all{lane(e.force, l), e.normal[l], e.touching[l], e.max_overlap[l], e.stiffness[l], e.elastic_energy[l]};
        for (std::size_t i = static_cast<std::size_t>(at); i < contacts.kept.size(); i += acting_.size()) {
            all.friction_work += contacts.kept[i].friction_work[l];
            all.viscous_work += contacts.kept[i].viscous_work[l];
        }
        return all;
    }

private:
    template <class F> void append(int wall, std::vector<double>& forces, F&& value) const {
        const int at = place_[static_cast<std::size_t>(wall)];
        if (at < 0) return;
        for (const TileContacts& contacts : tiles_) {
            if (!contacts.busy) continue;
            const Entry& e = contacts.entry[static_cast<std::size_t>(at)];
            for (int l = 0; l < contacts.lanes; ++l)
                if (const double force = value(e, l); force != 0) forces.push_back(force);
        }
    }

    std::size_t points_; ///< of a rod
    std::vector<int> acting_, place_;
    std::vector<TileContacts> tiles_;
};

} // namespace skein
