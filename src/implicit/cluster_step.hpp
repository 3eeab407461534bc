// Implicit step of rods and bodies that joints couple, in a block of copies of an assembly: corrections of all of them
// at once, by one system of their rows.                                                               theory.md (126)
// Each lane, a copy, counts its own corrections, so that no bit depends on its neighbours.
#pragma once

#include "implicit/corrections.hpp"
#include "implicit/joint_slopes.hpp"
#include "implicit/shared_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace skein {

template <int W> class ClusterStep {
    using P = Pack<W>;
    using Room = typename StepsTogether<W>::Room;

public:
    using Tiles = std::vector<SteppedTile<W>>;

    /// `tiles`: of a cluster of this assembly, whichever; `slots`: of it, with that of the world.
    ClusterStep(const ClusterJoints<W>& joints, const Tiles& tiles, std::size_t slots, int threads)
        : joints_(joints), first_row_(first_rows(tiles)), slopes_(joints, joined_slots(tiles, slots)),
          shared_(joints, slopes_.slots()), corrects_(tiles.front().pass->corrects()), apart_(HUGE_VAL), slots_(slots),
          rooms_(to_index(threads)) {
        std::vector<std::pair<std::size_t, std::size_t>> coupled = slopes_.coupled_rows();
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            const std::size_t first = first_row_[t], rows = first_row_[t + 1] - first;
            for (std::size_t k = 1; k < rows; ++k) coupled.emplace_back(first + k - 1, first + k);
            if (tiles[t].rod.group->closed()) coupled.emplace_back(first, first + rows - 1);
            apart_ = std::min(apart_, tiles[t].pass->apart());
        }
        shared_.couple(first_row_.back(), coupled);
        order_ = std::make_shared<Elimination>(first_row_.back(), coupled);
    }

    /// Makes a stage. `memory`: of the cluster's joints; before(tile, load): runs the passes before that of the step;
    /// moments(): those of muscles at the ends of rods, by tile, or null.
    template <class Before, class Moments>
    void run(const Tiles& tiles, const Step& step, P* memory, int thread, Before&& before, Moments&& moments) {
        Rooms& rooms = rooms_of(thread, tiles);
        Slot<W>* slot = tiles.front().rod.slot;
        shared_.gather(slot, step, memory);
        joints_.begin_step(slot, step, memory, rooms.joined.data());
        if (!corrects_) joints_.try_state(slot, moments(), step, memory, rooms.joined.data()); // for the passes before
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            before(joined(tiles, t, rooms), load_of(tiles[t].rod, tiles, rooms));
            tiles[t].pass->begin_step(tiles[t].rod, step, *rooms.of_tile[t]);
        }
        shared_.follow(tiles, memory, rooms.of_tile);
        Corrections<W> corrections;
        while (corrections.goes_on()) {
            const EndMoments<W>* of_muscles = moments();
            if (corrects_) joints_.try_state(slot, of_muscles, step, memory, rooms.joined.data());
            if (corrections.number() % 3 == 0)
                slopes_.compute(joints_, slot, of_muscles, step, memory, rooms.joined.data(), step.kick, apart_,
                                rooms.slopes);
            rooms.rows.begin(order_);
            for (std::size_t t = 0; t < tiles.size(); ++t) add_rows(tiles, t, step, corrections.number(), rooms);
            add_slopes(tiles, rooms);
            shared_.reduce(tiles, memory, rooms.of_tile, rooms.rows);
            rooms.rows.solve();
            shared_.spread(tiles, memory, rooms.of_tile, rooms.rows);
            P size(0.0);
            for (std::size_t t = 0; t < tiles.size(); ++t) {
                const P own =
                    tiles[t].pass->take_correction(tiles[t].rod, rooms.rows, first_row_[t], *rooms.of_tile[t]);
                size = max(size, own) + P(0.0) * own; // NaN stays
            }
            for (std::size_t t = 0; t < tiles.size(); ++t)
                tiles[t].pass->move_by(tiles[t].rod, step, corrections.share(size), *rooms.of_tile[t]);
            shared_.follow(tiles, memory, rooms.of_tile);
            corrections.note(size);
            if (!corrects_) break;
        }
        const P wrong = corrects_ ? corrections.wrong() : P(0.0);
        if (tiles.front().pass->books()) joints_.try_state(slot, moments(), step, memory, rooms.joined.data());
        P begins(0.0);
        for (const SteppedTile<W>& tile : tiles) begins = max(begins, tile.pass->begins_to_touch(tile.rod));
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            const RodTile<W> rod = joined(tiles, t, rooms);
            tiles[t].pass->put_off(rod, step, begins);
            tiles[t].pass->end_step(rod, load_of(rod, tiles, rooms), step, wrong, *rooms.of_tile[t]);
        }
        shared_.gather(slot, step, memory);
        if (step.last_stage) joints_.end_step(slot, step, memory, rooms.joined.data());
    }

    /// Gives shared nodes one place and velocity, after passes that follow a step.
    void gather(const Tiles& tiles, const Step& step, const P* memory) const {
        shared_.gather(tiles.front().rod.slot, step, memory);
    }

private:
    /// Rooms of a thread.
    struct Rooms {
        std::vector<std::unique_ptr<Room>> of_tile;
        AlignedVector<JoinedLoad<W>> joined;
        AlignedVector<SlotLoad<W>> load; ///< by slot of the cluster
        typename JointSlopes<W>::Work slopes;
        ClusterRows<W> rows;
    };
    Rooms& rooms_of(int thread, const Tiles& tiles) {
        std::unique_ptr<Rooms>& rooms = rooms_[to_index(thread)];
        if (!rooms) {
            rooms = std::make_unique<Rooms>();
            for (const SteppedTile<W>& tile : tiles) rooms->of_tile.push_back(tile.pass->make_room());
            rooms->joined.resize(slots_);
            rooms->load.resize(slots_);
        }
        return *rooms;
    }

    static std::vector<std::size_t> first_rows(const Tiles& tiles) {
        std::vector<std::size_t> first{0};
        for (const SteppedTile<W>& tile : tiles)
            first.push_back(first.back() + to_index(tile.pass->last_row(tile.rod)) + 1);
        return first;
    }
    std::vector<JoinedSlot> joined_slots(const Tiles& tiles, std::size_t slots) const {
        std::vector<JoinedSlot> all;
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            const auto& [pass, rod] = tiles[t];
            for (int k = 0; k <= rod.last; ++k) {
                const int row = k <= pass->last_row(rod) ? k : 0; // the end of a ring
                all.push_back({first_row_[t] + to_index(row), k < rod.n, pass->turns_about_lab(), t, row});
            }
        }
        all.resize(slots); // the world
        return all;
    }

    static RodTile<W> joined(const Tiles& tiles, std::size_t t, const Rooms& rooms) {
        RodTile<W> rod = tiles[t].rod;
        rod.joined = rooms.joined.data() + (rod.slot - tiles.front().rod.slot);
        return rod;
    }
    static SlotLoad<W>* load_of(const RodTile<W>& rod, const Tiles& tiles, Rooms& rooms) {
        return rooms.load.data() + (rod.slot - tiles.front().rod.slot);
    }
    void add_rows(const Tiles& tiles, std::size_t t, const Step& step, int number, Rooms& rooms) const {
        const RodTile<W> rod = joined(tiles, t, rooms);
        RowsOfTile<W> rows(rooms.rows, first_row_[t], tiles[t].pass->last_row(rod), rod.group->closed());
        tiles[t].pass->add_rows(rod, load_of(rod, tiles, rooms), step, *rooms.of_tile[t], number, rows);
    }
    void add_slopes(const Tiles& tiles, Rooms& rooms) const {
        slopes_.for_all(rooms.slopes, [&](const JoinedSlot& feels, const JoinedSlot& moves, const RowBlock<W>& slopes) {
            RowBlock<W> block;
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) block[i][j] = slopes[i][j];
            const SteppedTile<W>&of = tiles[feels.tile], &by = tiles[moves.tile];
            by.pass->terms().hold_columns(by.rod, moves.k, block);
            of.pass->terms().hold_rows(of.rod, feels.k, block);
            RowBlock<W>& to = rooms.rows.at(feels.row, moves.row);
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) to[i][j] -= block[i][j];
        });
    }

    const ClusterJoints<W>& joints_;
    std::vector<std::size_t> first_row_; ///< by tile
    JointSlopes<W> slopes_;
    SharedNodes<W> shared_;
    bool corrects_;
    double apart_; ///< m
    std::size_t slots_;
    std::shared_ptr<const Elimination> order_;
    std::vector<std::unique_ptr<Rooms>> rooms_; ///< by thread
};

} // namespace skein
