// Nodes that go with others of their cluster: their unknowns are those of the node, or body, that leads.
//                                                                                                  theory.md (127)
//   node     u = U;  on a body at r: u = U + t x r,  t: turn of the body, lab
//   system   T^T A T,  T^T b:  rows of such a node are added to those of its leader, and columns too
#pragma once

#include "core/rotation.hpp"
#include "implicit/cluster_rows.hpp"
#include "implicit/elastic_rows.hpp"
#include "implicit/steps_together.hpp"
#include "tiles/clusters.hpp"

#include <set>
#include <vector>

namespace skein {

/// A slot of a cluster as joints see it.
struct JoinedSlot {
    std::size_t row = none; ///< of its node and element; none of the world
    bool turns = false;     ///< true where it has an element
    bool about_lab = false; ///< turns of its row are about axes of the lab
    std::size_t tile = 0;   ///< number in the cluster
    int k = 0;              ///< number of its row in the tile
    static constexpr std::size_t none = SIZE_MAX;
};

/// Tile of a cluster and the pass that makes its step.
template <int W> struct SteppedTile {
    const StepsTogether<W>* pass;
    RodTile<W> rod;
};

template <int W> class SharedNodes {
public:
    using P = Pack<W>;
    using V = Vec3<P>;
    using Tiles = std::vector<SteppedTile<W>>;
    using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
    using Rooms = std::vector<std::unique_ptr<typename StepsTogether<W>::Room>>;

    /// `slots`: by number in the cluster.
    SharedNodes(const ClusterJoints<W>& joints, const std::vector<JoinedSlot>& slots) : joints_(joints) {
        for (const SharedSlot& shared : joints.shared_slots()) {
            const JoinedSlot &own = slots[shared.slot], &leader = slots[shared.leader];
            nodes_.push_back({shared, own, leader, {}});
        }
    }
    bool any() const { return !nodes_.empty(); }

    /// Adds the pairs of rows that leaders couple, to those that are coupled without them.
    void couple(std::size_t rows, Pairs& pairs) {
        if (!any()) return;
        std::vector<std::set<std::size_t>> beside(rows);
        for (const auto& [i, j] : pairs) {
            beside[i].insert(j);
            beside[j].insert(i);
        }
        for (Node& node : nodes_) {
            beside[node.own.row].insert(node.leader.row);
            std::set<std::size_t> taken = beside[node.own.row];
            taken.insert(node.own.row);
            node.coupled.assign(taken.begin(), taken.end());
            for (const std::size_t row : taken) {
                if (row == node.leader.row) continue;
                pairs.emplace_back(node.leader.row, row);
                beside[node.leader.row].insert(row);
                beside[row].insert(node.leader.row);
            }
        }
    }

    /// Takes nodes to their leaders' places within a step.
    void follow(const Tiles& tiles, const P* memory, const Rooms& rooms) const {
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const Node& node = nodes_[i];
            const Slot<W>& leader = slot_of(tiles, node.leader);
            V place = leader.position, velocity = leader.velocity;
            if (node.shared.on_body) {
                const V r = arm(tiles, node, rooms);
                place += r;
                velocity += cross(transpose_times(leader.director, leader.spin), r);
            }
            tiles[node.own.tile].pass->follow(tiles[node.own.tile].rod, node.own.k, place, velocity,
                                              joints_.goes_along(i, memory), *rooms[node.own.tile]);
        }
    }
    /// The same between steps, with velocities that keep the momenta.
    void gather(Slot<W>* slot, const Step& step, const P* memory) const {
        if (!any()) return;
        Step still = step;
        still.dt = 0;
        joints_.gather(slot, memory, true);
        joints_.move_as_one(slot, memory, still, true);
    }

    /// Makes the rows and columns of nodes those of their leaders.
    void reduce(const Tiles& tiles, const P* memory, const Rooms& rooms, ClusterRows<W>& rows) const {
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const Node& node = nodes_[i];
            const Mask<W> along = joints_.goes_along(i, memory);
            if (!skein::any(along)) continue;
            const Three<P> turns = by_turn(tiles, node, rooms);
            const std::size_t own = node.own.row, leader = node.leader.row;
            for (const std::size_t column : node.coupled)
                take_row(tiles, node, turns, along, rows.at(own, column), rows.at(leader, column));
            take_right(tiles, node, turns, along, rows.right(own), rows.right(leader));
            for (const std::size_t row : node.coupled)
                take_columns(node, turns, along, rows.at(row, own), rows.at(row, leader));
            for (int j = 0; j < 3; ++j) {
                P& diagonal = rows.at(own, own)[j][j];
                diagonal = select(along, P(1.0), diagonal);
            }
        }
    }
    /// Gives nodes the displacements of their leaders.
    void spread(const Tiles& tiles, const P* memory, const Rooms& rooms, ClusterRows<W>& rows) const {
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const Node& node = nodes_[i];
            const Mask<W> along = joints_.goes_along(i, memory);
            const Three<P> turns = by_turn(tiles, node, rooms);
            const P* u = rows.solution(node.leader.row).u;
            P* own = rows.solution(node.own.row).u;
            for (int j = 0; j < 3; ++j) {
                P way = u[j];
                if (node.shared.on_body)
                    way += fma(turns.a[j][0], u[3], fma(turns.a[j][1], u[4], turns.a[j][2] * u[5]));
                own[j] = select(along, way, own[j]);
            }
        }
    }

private:
    struct Node {
        SharedSlot shared;
        JoinedSlot own, leader;
        std::vector<std::size_t> coupled; ///< rows that it is coupled to, with its own and its leader's
    };

    static Slot<W>& slot_of(const Tiles& tiles, const JoinedSlot& of) { return tiles[of.tile].rod.slot[of.k]; }
    static V arm(const Tiles& tiles, const Node& node, const Rooms& rooms) {
        const SteppedTile<W>& body = tiles[node.leader.tile];
        return body.pass->arm(body.rod, node.shared.arm, *rooms[node.leader.tile]);
    }
    /// Displacement by the body's turn: t x r = -[r] t, of a turn in the body -[r] Q^T t.
    static Three<P> by_turn(const Tiles& tiles, const Node& node, const Rooms& rooms) {
        if (!node.shared.on_body) return {};
        const Slot<W>& body = slot_of(tiles, node.leader);
        const Three<P> across = detail::skew(-arm(tiles, node, rooms));
        if (node.leader.about_lab) return across;
        return detail::product_with_transpose(across, detail::three<W>(body.director));
    }

    /// Moves the lines of the node, and those that they give the body's turn.
    static void take_row(const Tiles& tiles, const Node& node, const Three<P>& turns, const Mask<W>& along,
                         RowBlock<W>& from, RowBlock<W>& to) {
        RowBlock<W> moved;
        const P none(0.0);
        for (int j = 0; j < row_size; ++j) {
            for (int i = 0; i < 3; ++i) {
                moved[i][j] = select(along, from[i][j], none);
                from[i][j] = select(along, none, from[i][j]);
            }
            for (int i = 0; i < 3; ++i)
                moved[3 + i][j] =
                    !node.shared.on_body
                        ? none
                        : fma(turns.a[0][i], moved[0][j], fma(turns.a[1][i], moved[1][j], turns.a[2][i] * moved[2][j]));
        }
        const SteppedTile<W>& leader = tiles[node.leader.tile];
        leader.pass->terms().hold_rows(leader.rod, node.leader.k, moved);
        for (int i = 0; i < row_size; ++i)
            for (int j = 0; j < row_size; ++j) to[i][j] += moved[i][j];
    }
    static void take_right(const Tiles& tiles, const Node& node, const Three<P>& turns, const Mask<W>& along,
                           P (&from)[row_size], P (&to)[row_size]) {
        RowBlock<W> own, sum; // in their first columns
        clear<W>(own);
        clear<W>(sum);
        for (int i = 0; i < row_size; ++i) own[i][0] = from[i];
        take_row(tiles, node, turns, along, own, sum);
        for (int i = 0; i < row_size; ++i) {
            from[i] = own[i][0];
            to[i] += sum[i][0];
        }
    }
    static void take_columns(const Node& node, const Three<P>& turns, const Mask<W>& along, RowBlock<W>& from,
                             RowBlock<W>& to) {
        const P none(0.0);
        for (int i = 0; i < row_size; ++i) {
            P moved[3];
            for (int j = 0; j < 3; ++j) {
                moved[j] = select(along, from[i][j], none);
                from[i][j] = select(along, none, from[i][j]);
                to[i][j] += moved[j];
            }
            for (int j = 0; node.shared.on_body && j < 3; ++j)
                to[i][3 + j] += fma(moved[0], turns.a[0][j], fma(moved[1], turns.a[1][j], moved[2] * turns.a[2][j]));
        }
    }

    const ClusterJoints<W>& joints_;
    std::vector<Node> nodes_;
};

} // namespace skein
