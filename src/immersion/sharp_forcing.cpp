#include "immersion/sharp_forcing.hpp"

#include "core/timer.hpp"
#include "parallel/blocks.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Vector of one component.
Vec3d along(int component, double value) {
    return {component == 0 ? value : 0, component == 1 ? value : 0, component == 2 ? value : 0};
}

Vec3d vector(const double* numbers) { return {numbers[0], numbers[1], numbers[2]}; }

} // namespace

SharpForcing::SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                           double kinematic_viscosity, std::vector<SharpBody> bodies, int across)
    : SharpForcing(comm, threads, grid, kinematic_viscosity, std::move(bodies),
                   Pencils(grid, comm.rank(), comm.size(), across)) {}

SharpForcing::SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                           double kinematic_viscosity, std::vector<SharpBody> bodies, const Pencils& pencils)
    : comm_(comm), threads_(threads), h_(grid.h), viscosity_(kinematic_viscosity), cells_(grid.cells),
      rows_(pencils.rows()), planes_(pencils.planes()), layout_(pencils.layout()),
      nodes_(threads, grid, pencils, std::move(bodies)), given_(nodes_.bodies()), of_piece_(nodes_.pieces()),
      response_of_piece_(nodes_.pieces()) {}

double SharpForcing::pull_of(const SharpNode& node, const std::array<double*, 3>& fields) const {
    const double* const field = nth(fields, node.component) + node.at;
    const std::ptrdiff_t stride[] = {1, layout_.row, layout_.plane};
    double pull = node.pull;
    for (int d = 0; d < 3; ++d)
        if (nth(node.ahead, d) != 0) pull += nth(node.ahead, d) * field[nth(node.side, d) * stride[d]];
    return pull;
}

SharpForcing::Moments SharpForcing::moments(const SharpNode& node) const {
    const Vec3d whole = cross(node.arm, along(node.component, 1));
    return {whole, (1 - node.of_other) * whole, node.of_other * whole};
}

void SharpForcing::add(const SharpNode& node, double change, std::vector<RowSum>& sums, bool next_row) const {
    const std::uint32_t of = 3 * node.piece + node.component, other = 3 * node.other + node.component;
    if (next_row || sums.back().of != of || sums.back().other != other) sums.push_back({.of = of, .other = other});
    const Moments moment = moments(node);
    RowSum& sum = sums.back();
    sum.change += change;
    sum.at_end += node.along * change;
    sum.moment += change * moment.own;
    sum.moment_of_other += change * moment.of_other;
    sum.relative += node.share * node.relative;
    sum.relative_at_end += node.along * (node.share * node.relative);
}

template <class Give> double SharpForcing::velocity_after(std::span<const SharpNode> nodes, std::size_t& n,
                                                          const FlowStage& stage, Give&& give) const {
    const SharpNode& node = nodes[n];
    const double before = nth(stage.velocity, node.component)[node.at];
    if (node.excess == SharpNode::inside) {
        const double given = node.share * (node.velocity - before);
        give(node, Change{given, node.share});
        return node.share == 1 ? node.velocity : before + given;
    }
    const std::size_t first = n;
    double closed = node.closed;
    for (; nodes[n].again; ++n) closed += nodes[n + 1].closed;
    const double open = std::max(0.0, 1 - closed), per_closed = closed > 1 ? 1 / closed : 1,
                 rate = before - nth(stage.scratch, node.component)[node.at],
                 exchange = open * (stage.dt * viscosity_ / (h_ * h_));
    // The closed part of a face moves with the body, whatever the rates of the fluid are there.
    const auto carried = [&](const SharpNode& m) { return per_closed * m.closed * (m.gain - rate); };
    double weight = 1, sum = before;
    for (std::size_t m = first; m <= n; ++m) {
        weight += exchange * nodes[m].excess;
        sum += carried(nodes[m]) + exchange * pull_of(nodes[m], stage.scratch);
    }
    const double u = sum / weight; // theory.md (139)
    double after = u;
    for (std::size_t m = first; m <= n; ++m) {
        const SharpNode& one = nodes[m];
        const double whole =
            first == n ? u - before : carried(one) + exchange * (pull_of(one, stage.scratch) - one.excess * u);
        give(one, Change{one.share * whole, one.share *
                                                (per_closed * one.closed +
                                                 exchange * (one.excess - one.ahead[0] - one.ahead[1] - one.ahead[2])) /
                                                weight});
        after -= (1 - one.share) * whole; // markers have the rest, (158)
    }
    return after;
}

void SharpForcing::act_on(std::span<const SharpNode> nodes, const FlowStage& stage, std::vector<RowSum>& sums,
                          std::vector<SurfaceWork>& works) const {
    std::int32_t row = -1;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const SharpNode& node = nodes[n];
        const bool next_row = node.row != row;
        double given = 0, power = 0;
        const double u = velocity_after(nodes, n, stage, [&](const SharpNode& one, const Change& change) {
            add(one, change.given, sums, one.row != row);
            row = one.row;
            given += change.given;
            power += change.given * one.velocity;
        });
        nth(stage.velocity, node.component)[node.at] = u;
        if (!work_) continue;
        if (next_row) works.emplace_back();
        const double middle = 0.5 * (nth(stage.scratch, node.component)[node.at] + u); // theory.md (161)
        works.back() += {power, power - given * middle};
    }
}

void SharpForcing::add(const SharpNode& node, const Change& change, std::vector<ResponseSum>& sums,
                       bool next_row) const {
    const SweptSurface* const rod = nodes_.swept(node);
    if (!rod) return;
    const std::uint32_t of = 3 * node.piece + node.component, other = 3 * node.other + node.component;
    if (next_row || sums.empty() || sums.back().of != of || sums.back().other != other)
        sums.push_back({.of = of, .other = other});
    const std::size_t first = nodes_.first_piece(node.body);
    const auto squared = [&](std::uint32_t piece, const Vec3d& moment) {
        const Vec3d m = rod->frame(piece - first) * moment;
        return scale(m, m);
    };
    // Sums over rows of the drags of all spins together, so that equal spins have all of them. theory.md (155a)
    const auto [whole, own, of_other] = moments(node);
    const double a = node.along, s = node.of_other;
    const Vec3d about = squared(node.piece, whole);
    ResponseSum& sum = sums.back();
    sum.given[0] += (1 - a) * change.given;
    sum.given[1] += a * change.given;
    sum.drag[0] += (1 - a) * change.share;
    sum.drag[1] += a * change.share;
    sum.shared += a * (1 - a) * change.share;
    sum.relative[0] += (1 - a) * (node.share * node.relative);
    sum.relative[1] += a * (node.share * node.relative);
    sum.turn_given += change.given * own;
    sum.turn_drag += ((1 - s) * change.share) * about;
    if (s == 0) return;
    sum.turn_given_of_other += change.given * of_other;
    sum.turn_drag_of_other += (s * change.share) * squared(node.other, whole);
    sum.turn_shared[a < 0.5 ? 0 : 1] += (s * (1 - s) * change.share) * about;
}

void SharpForcing::find_responses(const FlowStage& stage) {
    const Timers::Guard timing(seconds_);
    nodes_.settle(stage.time, stage.dt);
    constexpr std::size_t columns = 19;
    std::vector<std::vector<ResponseSum>> of_planes(to_index(layout_.nz));
    threads_.for_each(of_planes.size(), [&](std::size_t k, int) {
        nodes_.for_lists(static_cast<int>(k), [&](std::span<const SharpNode> nodes) {
            std::int32_t row = -1;
            for (std::size_t n = 0; n < nodes.size(); ++n)
                velocity_after(nodes, n, stage, [&](const SharpNode& node, const Change& change) {
                    add(node, change, of_planes[k], node.row != row);
                    row = node.row;
                });
        });
    });
    std::vector<double> terms;
    std::vector<std::uint32_t> of;
    for (const auto& plane : of_planes)
        for (const ResponseSum& sum : plane) {
            const auto &g = sum.turn_given, &d = sum.turn_drag, &from = sum.turn_shared[0], &to = sum.turn_shared[1];
            terms.insert(terms.end(),
                         {sum.given[0], sum.given[1], sum.drag[0], sum.drag[1], sum.shared, sum.relative[0],
                          sum.relative[1], g.x, g.y, g.z, d.x, d.y, d.z, from.x, from.y, from.z, to.x, to.y, to.z});
            of.push_back(sum.of);
            if (sum.other == sum.of) continue;
            const auto &given = sum.turn_given_of_other, &drag = sum.turn_drag_of_other;
            terms.insert(terms.end(),
                         {0, 0, 0, 0, 0, 0, 0, given.x, given.y, given.z, drag.x, drag.y, drag.z, 0, 0, 0, 0, 0, 0});
            of.push_back(sum.other);
        }
    const std::vector<double> all = exact_sums(
        comm_, threads_, {terms.data(), of.size(), columns, columns, 3 * response_of_piece_.size(), of.data()});
    const double cell = h_ * h_ * h_;
    for (std::size_t p = 0; p < response_of_piece_.size(); ++p) {
        Response& here = response_of_piece_[p] = {};
        for (int c = 0; c < 3; ++c) {
            const double* const sum = &all[columns * (3 * p + to_index(c))];
            for (std::size_t end = 0; end < 2; ++end) {
                here.given[end] += cell * along(c, sum[end]);
                here.drag[end] += cell * along(c, sum[2 + end]);
                here.relative[end] += cell * along(c, sum[5 + end]);
                here.turn_shared[end] += cell * vector(sum + 13 + 3 * end);
            }
            here.shared += cell * along(c, sum[4]);
            here.turn_given += cell * vector(sum + 7);
            here.turn_drag += cell * vector(sum + 10);
        }
    }
}

void SharpForcing::act(const FlowStage& stage) {
    const Timers::Guard timing(seconds_);
    nodes_.settle(stage.time, stage.dt);
    std::vector<std::vector<RowSum>> sums(to_index(layout_.nz));
    std::vector<std::vector<SurfaceWork>> works(sums.size());
    threads_.for_each(sums.size(), [&](std::size_t k, int) {
        nodes_.for_lists(static_cast<int>(k),
                         [&](std::span<const SharpNode> nodes) { act_on(nodes, stage, sums[k], works[k]); });
    });
    add_given(sums);
    if (!work_) return;
    for (const std::vector<SurfaceWork>& of_plane : works)
        for (const SurfaceWork& work : of_plane) work_->add(work);
    work_->end_stage();
}

template <class Body> void SharpForcing::for_nodes(Body&& body) const {
    for_blocks(threads_, list_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t n = begin; n < end; ++n) body(n, list_[n]);
    });
}

double SharpForcing::slack(const SharpNode& node) const {
    const double whole = node.excess == SharpNode::inside ? 0 : h_ * h_ / (viscosity_ * stage_dt_ * node.excess);
    return whole / node.share + (1 / node.share - 1); // (158)
}

void SharpForcing::list_nodes() {
    if (listed_ && !nodes_.some_move()) return;
    list_.clear();
    std::vector<std::int64_t> identities;
    const std::int64_t rows = cells_[1], cells = cells_[0], bodies = static_cast<std::int64_t>(given_.size());
    for (int k = 0; k < layout_.nz; ++k)
        nodes_.for_lists(k, [&](std::span<const SharpNode> nodes) {
            for (const SharpNode& node : nodes) {
                const std::int64_t i = node.at - layout_.at(0, node.row, k),
                                   cell = ((planes_.first + k) * rows + rows_.first + node.row) * cells + i;
                identities.push_back(-1 - ((3 * cell + node.component) * bodies + node.body)); // markers have others
                list_.push_back(node);
            }
        });
    for (std::vector<double>* numbers : {&slip_, &push_, &response_}) numbers->assign(list_.size(), 0);
    held_.settle(comm_, identities);
    listed_ = true;
}

void SharpForcing::restore_held(std::span<const double> saved) {
    held_.restore(comm_, saved);
    listed_ = false;
}

void SharpForcing::add_held_forces(const FlowStage& stage) {
    nodes_.settle(stage.time, stage.dt);
    list_nodes();
    for (std::size_t n = 0; n < list_.size(); ++n)
        nth(stage.velocity, list_[n].component)[list_[n].at] += stage.dt * held_.values()[n].x;
}

void SharpForcing::find_slips(const FlowStage& stage) {
    stage_dt_ = stage.dt;
    for_nodes([&](std::size_t n, const SharpNode& node) {
        const double u = nth(stage.velocity, node.component)[node.at],
                     aim =
                         node.excess == SharpNode::inside ? node.velocity : pull_of(node, stage.velocity) / node.excess;
        slip_[n] = aim - u - slack(node) * stage.dt * held_.values()[n].x;
    });
}

double SharpForcing::largest_slip() const {
    double most = 0;
    for (const double slip : slip_) most = std::max(most, std::abs(slip));
    return comm_.max(most);
}

void SharpForcing::push(const FlowStage& stage) {
    for_nodes([&](std::size_t n, const SharpNode& node) { push_[n] = slip_[n] / (1 + slack(node)); });
    for (std::size_t n = 0; n < list_.size(); ++n) // bodies may share a node
        nth(stage.scratch, list_[n].component)[list_[n].at] += push_[n];
}

void SharpForcing::find_response(const FlowStage& stage) {
    for_nodes([&](std::size_t n, const SharpNode& node) {
        const double change = nth(stage.scratch, node.component)[node.at];
        SharpNode relative = node; // without the body's velocity
        relative.pull = 0;
        const double aim = node.excess == SharpNode::inside ? 0 : pull_of(relative, stage.scratch) / node.excess;
        response_[n] = change - aim + slack(node) * push_[n];
    });
}

void SharpForcing::add_terms(std::array<std::vector<double>, 2>& terms) const {
    for (std::size_t n = 0; n < list_.size(); ++n) {
        const double weighted = response_[n] / (1 + slack(list_[n]));
        terms[0].push_back(weighted * slip_[n]);
        terms[1].push_back(weighted * response_[n]);
    }
}

void SharpForcing::take(double times, const FlowStage& stage) {
    for (std::size_t n = 0; n < list_.size(); ++n) {
        slip_[n] -= times * response_[n];
        held_.values()[n].x += times / stage.dt * push_[n];
    }
}

void SharpForcing::end_sweeps(const FlowStage& stage) {
    std::vector<RowSum> sums;
    std::int64_t row = -1;
    for (std::size_t n = 0; n < list_.size(); ++n) {
        const std::int64_t here = list_[n].at / layout_.row;
        const double change = stage.dt * held_.values()[n].x;
        if (work_) {
            const SharpNode& node = list_[n];
            const double slip = node.velocity - nth(stage.velocity, node.component)[node.at];
            // Lists of two clusters may meet in one row, or not, as ranks share rows.
            const bool same_row = here == row && list_[n - 1].body == node.body;
            work_->add({change * node.velocity, change * slip}, same_row);
        }
        add(list_[n], change, sums, here != row);
        row = here;
    }
    add_given({sums});
    if (work_) work_->end_stage();
}

void SharpForcing::add_given(const std::vector<std::vector<RowSum>>& of_planes) {
    constexpr std::size_t columns = 7;
    std::vector<double> changes;
    std::vector<std::uint32_t> of;
    for (const std::vector<RowSum>& sums : of_planes)
        for (const RowSum& sum : sums) {
            changes.insert(changes.end(), {sum.change, sum.moment.x, sum.moment.y, sum.moment.z, sum.at_end,
                                           sum.relative, sum.relative_at_end});
            of.push_back(sum.of);
            if (sum.other == sum.of) continue;
            const Vec3d& other = sum.moment_of_other;
            changes.insert(changes.end(), {0, other.x, other.y, other.z, 0, 0, 0});
            of.push_back(sum.other);
        }
    const std::vector<double> all =
        exact_sums(comm_, threads_, {changes.data(), of.size(), columns, columns, 3 * of_piece_.size(), of.data()});
    const double cell_volume = h_ * h_ * h_;
    for (std::size_t b = 0; b < given_.size(); ++b) {
        const SweptSurface* const rod = nodes_.swept(b);
        for (std::size_t p = nodes_.first_piece(b); p < nodes_.first_piece(b + 1); ++p) {
            GivenByElement& here = of_piece_[p] = {};
            for (int c = 0; c < 3; ++c) {
                const double* const sum = &all[columns * (3 * p + to_index(c))];
                here.whole.linear += cell_volume * along(c, sum[0]);
                here.whole.angular += cell_volume * vector(sum + 1);
                here.at_end += cell_volume * along(c, sum[4]);
                here.relative[0] += cell_volume * along(c, sum[5] - sum[6]);
                here.relative[1] += cell_volume * along(c, sum[6]);
            }
            given_[b] += rod ? about_first_node(here, *rod, p - nodes_.first_piece(b)) : here.whole;
        }
    }
}

GivenMomentum SharpForcing::about_first_node(const GivenByElement& given, const SweptSurface& rod,
                                             std::size_t element) {
    const auto& [whole, at_end, _] = given;
    return {whole.linear,
            whole.angular + cross(rod.node(element), whole.linear - at_end) + cross(rod.node(element + 1), at_end)};
}

std::vector<RigidMotion> SharpForcing::inner_motions(double time, const std::array<const double*, 3>& velocity) {
    nodes_.settle(time, 0);
    std::vector<std::vector<std::pair<std::uint32_t, RigidFit>>> of_planes(to_index(layout_.nz)); // by body and row
    threads_.for_each(of_planes.size(), [&](std::size_t k, int) {
        nodes_.for_lists(static_cast<int>(k), [&](std::span<const SharpNode> nodes) {
            auto& fits = of_planes[k];
            std::int32_t row = -1;
            for (const SharpNode& node : nodes) {
                if (node.excess != SharpNode::inside || nodes_.swept(node)) continue;
                if (node.row != row || fits.back().first != node.body) fits.push_back({node.body, RigidFit()});
                row = node.row;
                fits.back().second.add(node.arm, along(node.component, 1),
                                       nth(velocity, node.component)[node.at] - node.velocity);
            }
        });
    });
    std::vector<double> terms;
    std::vector<std::uint32_t> body;
    for (const auto& fits : of_planes)
        for (const auto& [of, fit] : fits) {
            terms.insert(terms.end(), fit.sums().begin(), fit.sums().end());
            body.push_back(of);
        }
    constexpr std::size_t columns = RigidFit::numbers;
    const std::vector<double> all =
        exact_sums(comm_, threads_, {terms.data(), body.size(), columns, columns, given_.size(), body.data()});
    std::vector<RigidMotion> motions;
    for (std::size_t b = 0; b < given_.size(); ++b)
        motions.push_back(RigidFit(std::span(all).subspan(columns * b).first<columns>()).solve());
    return motions;
}

} // namespace skein
