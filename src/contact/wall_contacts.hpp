// Contacts of the rods of a group or of one rod with walls, per tile, lane and wall. They hold forces of the last step,
// sums since the start and springs of friction. Sums run along the rod and in time, lane by lane, so any ranks, threads
// and lanes have the same bits.
#pragma once

#include "contact/wall.hpp"
#include "contact/wall_points.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"
#include "tiles/rods.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <string>
#include <utility>

namespace skein {

/// Figures of one rod at one wall.
struct WallFigures {
    Vec3d force{0, 0, 0};                       ///< force of the rod on the wall at the last step, N
    double normal = 0;                          ///< sum of normal forces, N
    double touching = 0;                        ///< nodes
    double max_overlap = 0;                     ///< overlap over diameter
    double stiffness = 0;                       ///< largest tangent stiffness dN/dg of a node, N/m
    double elastic_energy = 0;                  ///< in all springs, J
    double friction_work = 0, viscous_work = 0; ///< sums since the start, J
};

/// The contacts of the rods of one program with walls, whatever the width of its tiles.
class WallContacts {
public:
    explicit WallContacts(std::string group) : group_(std::move(group)) {}
    virtual ~WallContacts() = default;
    const std::string& group() const { return group_; }
    /// Zeros where the wall does not act.
    virtual WallFigures figures(RodPlace rod, int wall) const = 0;
    /// Appends the force of each rod that pressed a wall at the last step, N: normal forces, and forces along a
    /// direction.
    virtual void append_normal(int wall, std::vector<double>& forces) const = 0;
    virtual void append_force(int wall, const Vec3d& direction, std::vector<double>& forces) const = 0;
    /// Largest overlap of a node with the wall at the last step, over its diameter.
    virtual double max_overlap(int wall) const = 0;
    /// Memory of a rod at all walls, as checkpoints have it.
    virtual std::vector<double> memory(RodPlace rod) const = 0;
    virtual void set_memory(RodPlace rod, std::span<const double> numbers) = 0;

private:
    std::string group_;
};

template <int W> class WallContactTiles final : public WallContacts {
public:
    using P = Pack<W>;
    /// Forces of the last step, lane by lane.
    struct Entry {
        Vec3<P> force{};
        P normal{}, touching{}, max_overlap{}, stiffness{}, elastic_energy{};
    };
    /// Dissipated since the start, lane by lane, J.
    struct Work {
        P friction{}, viscous{};
    };
    /// Contacts of the rods of one tile.
    struct TileContacts {
        AlignedVector<Entry> entry; ///< [wall], of those that act on the group
        AlignedVector<Work> work;   ///< [wall]
        AlignedVector<ContactMemory<double>>
            memory;                        ///< [point][wall][lane]: a line of the cache each, as few of them touch
        std::vector<std::uint8_t> touched; ///< [point][wall]: lanes whose springs may be other than zero, as bits
        std::vector<std::uint8_t> near;    ///< [wall]: the tile's box is within reach at this step
        std::vector<std::uint8_t> held;    ///< [wall]: some point touched at the last step
        std::vector<std::size_t> checked;  ///< walls near enough to be checked in this step
        std::vector<std::uint8_t> left,
            taken;         ///< [wall]: lanes of a point that touch it, to be worked on and under work
        int lanes = 0;     ///< lanes with rods of their own
        P slip_mobility{}; ///< of rods with sizes of their own, by lane, 1/kg

        ContactMemory<double>& memory_at(int point, std::size_t wall, int lane) {
            return memory[(to_index(point) * entry.size() + wall) * lanes_of<W> + to_index(lane)];
        }
        /// The energy of its spring counts as friction work when a point leaves a wall.
        void end_contact(int point, std::size_t wall, int lane) {
            ContactMemory<double>& left = memory_at(point, wall, lane);
            work[wall].friction.set(lane, work[wall].friction[lane] + left.energy());
            left = {};
        }

        /// For checkpoints: work by wall, memory by point and wall.
        void append_memory(int lane, std::vector<double>& numbers) const {
            for (const Work& w : work) numbers.insert(numbers.end(), {w.friction[lane], w.viscous[lane]});
            for (std::size_t i = to_index(lane); i < memory.size(); i += lanes_of<W>) {
                const auto one = std::bit_cast<MemoryNumbers>(memory[i]);
                numbers.insert(numbers.end(), one.begin(), one.end());
            }
        }
        std::size_t restore(int lane, std::span<const double> numbers) {
            std::size_t at = 0;
            for (Work& w : work) {
                w.friction.set(lane, numbers[at]);
                w.viscous.set(lane, numbers[at + 1]);
                at += 2;
            }
            for (std::size_t i = to_index(lane); i < memory.size(); i += lanes_of<W>) {
                MemoryNumbers one;
                std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(at), one.size(), one.begin());
                memory[i] = std::bit_cast<ContactMemory<double>>(one);
                at += one.size();
            }
            for (std::uint8_t& bits : touched)
                bits = static_cast<std::uint8_t>(bits | 1u << lane); // these have to be looked at
            std::fill(held.begin(), held.end(), std::uint8_t{1});
            return at;
        }
    };
    using MemoryNumbers = std::array<double, sizeof(ContactMemory<double>) / sizeof(double)>;

    WallContactTiles(const Walls& walls, const RodGroup& group)
        : WallContacts(group.name()), points_(wall_points(group)) {
        for (std::size_t w = 0; w < walls.count(); ++w) {
            const bool acts = walls.wall[w].acts_on(group.name());
            place_.push_back(acts ? static_cast<int>(acting_.size()) : -1);
            if (acts) acting_.push_back(static_cast<int>(w));
        }
    }

    /// Numbers of the walls that act on the group.
    const std::vector<int>& acting() const { return acting_; }
    void expect(std::size_t tiles) { tiles_.resize(tiles); }
    /// Tiles may come in any order where they are expected.
    TileContacts& add_tile(const RodTile<W>& rod) {
        if (rod.number >= tiles_.size()) tiles_.resize(rod.number + 1);
        TileContacts& contacts = tiles_[rod.number];
        contacts.entry.resize(acting_.size());
        contacts.work.resize(acting_.size());
        contacts.memory.resize(points_ * acting_.size() * lanes_of<W>);
        contacts.touched.assign(points_ * acting_.size(), 0);
        contacts.near.assign(acting_.size(), 0);
        contacts.held.assign(acting_.size(), 0);
        contacts.left.assign(acting_.size(), 0);
        contacts.taken.assign(acting_.size(), 0);
        contacts.lanes = rod.lanes;
        return contacts;
    }
    TileContacts& of_tile(std::size_t tile) { return tiles_[tile]; }
    void keep(std::size_t place) { kept_[place] = tiles_; }
    void go_back(std::size_t place) { tiles_ = kept_[place]; }

    void append_normal(int wall, std::vector<double>& forces) const override {
        append(wall, forces, [](const Entry& e, int l) { return e.normal[l]; });
    }
    void append_force(int wall, const Vec3d& direction, std::vector<double>& forces) const override {
        append(wall, forces, [&](const Entry& e, int l) { return dot(lane(e.force, l), direction); });
    }
    double max_overlap(int wall) const override {
        const int at = nth(place_, wall);
        double most = 0;
        if (at < 0) return most;
        for (const TileContacts& contacts : tiles_)
            for (int l = 0; nth(contacts.held, at) && l < contacts.lanes; ++l)
                most = std::max(most, nth(contacts.entry, at).max_overlap[l]);
        return most;
    }
    std::vector<double> memory(RodPlace rod) const override {
        std::vector<double> numbers;
        tiles_[rod.tile].append_memory(rod.lane, numbers);
        return numbers;
    }
    void set_memory(RodPlace rod, std::span<const double> numbers) override {
        TileContacts& contacts = tiles_[rod.tile];
        const int last = rod.lane == contacts.lanes - 1 ? lanes_of<W> - 1 : rod.lane; // spare lanes repeat the last rod
        for (int l = rod.lane; l <= last; ++l) contacts.restore(l, numbers);
    }
    /// Spare lanes, which repeat the last rod, are for the reader to skip.
    WallFigures figures(RodPlace rod, int wall) const override {
        const int at = nth(place_, wall), l = rod.lane;
        if (at < 0) return {};
        const TileContacts& contacts = tiles_[rod.tile];
        const Entry& e = nth(contacts.entry, at);
        WallFigures all{lane(e.force, l), e.normal[l],    e.touching[l],
                        e.max_overlap[l], e.stiffness[l], e.elastic_energy[l]};
        const Work& work = nth(contacts.work, at);
        all.friction_work = work.friction[l];
        all.viscous_work = work.viscous[l];
        return all;
    }

private:
    template <class F> void append(int wall, std::vector<double>& forces, F&& value) const {
        const int at = nth(place_, wall);
        if (at < 0) return;
        for (const TileContacts& contacts : tiles_) {
            if (!nth(contacts.held, at)) continue;
            const Entry& e = nth(contacts.entry, at);
            for (int l = 0; l < contacts.lanes; ++l)
                if (const double force = value(e, l); force != 0) forces.push_back(force);
        }
    }

    std::size_t points_; ///< points of a rod
    std::vector<int> acting_, place_;
    AlignedVector<TileContacts> tiles_;
    std::array<AlignedVector<TileContacts>, 2> kept_; ///< for steps that are taken back
};

} // namespace skein
