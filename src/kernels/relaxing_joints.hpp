// Joints of rods that relax and share nodes. Each rod has been solved by itself; forces at shared nodes bring their
// corrections together, which is the solution of the stiffness of all rods as one. Then all rods of a copy move, and
// keep or forget their rates, as one. theory.md (66a)
//   (sum C) F = gaps       C: corrections at shared nodes by unit forces there, rod by rod; F: forces, no resultant
#pragma once

#include "joints/cluster_joints.hpp"
#include "relaxation/envelope_matrix.hpp"
#include "relaxation/relaxing_tile.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace skein {

template <int W> class RelaxingJoints final : public JointsOfCluster<W> {
    using P = Pack<W>;
    using Tiles = std::vector<RelaxingTile<W>>;

public:
    RelaxingJoints(std::span<const JointSpec> tables, std::span<const Joint> joints, std::span<const RodGroup> groups,
                   int assembly, const Junctions& junctions, const KickGains& gains)
        : JointsOfCluster<W>(tables, joints, groups, assembly, junctions, gains) {
        for (const Hub& hub : junctions.hubs) {
            std::vector<Place>& places = hubs_.emplace_back();
            for (const Hub::Member& m : hub.members)
                places.push_back({this->place(groups, m.group, m.rod, m.node), m.node});
        }
    }

    void gather(Slot<W>* slot, const P* memory, bool across) const override {
        relaxing_tiles<W>().clear();
        JointsOfCluster<W>::gather(slot, memory, across);
    }
    void move_as_one(Slot<W>* slot, const P*, const Step& step, bool across) const override {
        Tiles& tiles = relaxing_tiles<W>();
        const std::vector<Member> members = find_members(tiles, slot, across);
        if (across)
            for (int l = 0; l < W; ++l) bring_together(tiles, members, l, l + 1);
        else bring_together(tiles, members, -1, -1);
        move(tiles, step.kick, across);
    }

private:
    struct Place {
        ClusterPlace at;
        int node;
    };
    /// A node of a hub: its tile, and its number among the tile's shared nodes.
    struct Member {
        std::size_t tile, number;
        int node, lane, end_lane;
    };
    /// Members of all hubs, one hub after another.
    std::vector<Member> find_members(const Tiles& tiles, const Slot<W>* slot, bool across) const {
        std::vector<Member> members;
        for (const std::vector<Place>& hub : hubs_)
            for (const Place& place : hub) {
                const std::size_t at = across ? place.at.across : place.at.within;
                const auto tile = std::find_if(tiles.begin(), tiles.end(), [&](const RelaxingTile<W>& one) {
                    const auto first = static_cast<std::size_t>(one.rod.slot - slot);
                    return at >= first && at <= first + to_index(one.rod.last);
                });
                const auto number = std::find(tile->shared.begin(), tile->shared.end(), place.node);
                members.push_back({static_cast<std::size_t>(tile - tiles.begin()),
                                   static_cast<std::size_t>(number - tile->shared.begin()), place.node, place.at.lane,
                                   place.at.end_lane});
            }
        return members;
    }

    /// Shared nodes in one lane of all tiles or, with lane -1, in the lanes of each.
    void bring_together(Tiles& tiles, std::vector<Member> members, int lane, int end_lane) const {
        if (lane >= 0)
            for (Member& m : members) {
                m.lane = lane;
                m.end_lane = end_lane;
            }
        struct Pair {
            const Member *leader, *follower;
        };
        std::vector<Pair> pairs;
        std::size_t at = 0;
        for (const std::vector<Place>& hub : hubs_) {
            for (std::size_t i = 1; i < hub.size(); ++i) pairs.push_back({&members[at], &members[at + i]});
            at += hub.size();
        }
        const std::size_t n = 3 * pairs.size();
        std::map<std::pair<std::size_t, int>, std::size_t> first_pair; // at a rod, by its tile and lane
        EnvelopeMatrix matrix;
        std::vector<double> force(n);
        for (std::size_t p = 0; p < pairs.size(); ++p) {
            std::size_t first = p;
            for (const Member* m : {pairs[p].leader, pairs[p].follower})
                first = std::min(first, first_pair.try_emplace({m->tile, m->lane}, p).first->second);
            for (std::size_t c = 0; c < 3; ++c) {
                const auto now = [&](const Member& m) {
                    return tiles[m.tile].correction[to_index(m.node)].u[c][m.lane];
                };
                const auto [leader, follower] = pairs[p];
                force[3 * p + c] = now(*leader) - now(*follower);
                double* const row = matrix.add_row(3 * first);
                for (std::size_t j = 3 * first; j <= 3 * p + c; ++j) {
                    const Pair& column = pairs[j / 3];
                    const auto by = [&](const Member& x, const Member& y) { return moved(tiles, x, c, y, j % 3); };
                    row[j] = by(*follower, *column.follower) - by(*follower, *column.leader) -
                             by(*leader, *column.follower) + by(*leader, *column.leader);
                }
            }
        }
        matrix.solve(force);
        for (std::size_t i = 0; i < n; ++i) {
            push(tiles, *pairs[i / 3].follower, i % 3, force[i]);
            push(tiles, *pairs[i / 3].leader, i % 3, -force[i]);
        }
    }

    /// Component c of the correction at a by a unit force along d at b.
    static double moved(const Tiles& tiles, const Member& a, std::size_t c, const Member& b, std::size_t d) {
        if (a.tile != b.tile || a.lane != b.lane) return 0;
        return tiles[b.tile].unit(b.number, static_cast<int>(d), a.node).u[c][b.lane];
    }
    static void push(Tiles& tiles, const Member& at, std::size_t direction, double force) {
        RelaxingTile<W>& tile = tiles[at.tile];
        for (int k = 0; k <= tile.last; ++k) {
            const BandVector<W>& unit = tile.unit(at.number, static_cast<int>(direction), k);
            for (std::size_t i = 0; i < BandBlock<W>::size; ++i) {
                P& u = tile.correction[to_index(k)].u[i];
                for (int l = at.lane; l < at.end_lane; ++l) u.set(l, u[l] + force * unit.u[i][l]);
            }
        }
    }
    /// All rods of a copy as one: their power, and what is left of their step.
    static void move(const Tiles& tiles, double h, bool across) {
        P power(0.0), reach(1.0), excess(0.0);
        for (const RelaxingTile<W>& tile : tiles)
            if (across) power = power + tile.power;
            else
                for (int l = 0; l < tile.rod.lanes; ++l) power = power + P(tile.power[l]);
        const Mask<W> against = power < P(0.0);
        const P kept = select(against, P(0.0), P(1.0));
        for (const RelaxingTile<W>& tile : tiles) {
            tile.pass->note_residual(tile);
            reach = min(reach, tile.pass->reach(tile, against));
            const P own = tile.pass->move(tile, kept, h);
            if (across) excess = max(excess, own);
            else
                for (int l = 0; l < tile.rod.lanes; ++l) excess = max(excess, P(own[l]));
        }
        const Mask<W> beyond = excess > reach;
        if (!any(beyond)) return;
        const P share = select(beyond, reach / excess, P(1.0));
        for (const RelaxingTile<W>& tile : tiles) tile.pass->slow_down(tile, share);
    }

    std::vector<std::vector<Place>> hubs_;
};

} // namespace skein
