#include "immersion/sharp_forcing.hpp"

#include "core/timer.hpp"
#include "parallel/blocks.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

SharpForcing::SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                           double kinematic_viscosity, std::vector<SharpBody> bodies, int across)
    : SharpForcing(comm, threads, grid, kinematic_viscosity, std::move(bodies),
                   Pencils(grid, comm.rank(), comm.size(), across)) {}

SharpForcing::SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                           double kinematic_viscosity, std::vector<SharpBody> bodies, const Pencils& pencils)
    : comm_(comm), threads_(threads), h_(grid.h), viscosity_(kinematic_viscosity), cells_(grid.cells),
      rows_(pencils.rows()), planes_(pencils.planes()), layout_(pencils.layout()),
      nodes_(threads, grid, pencils, std::move(bodies)), given_(nodes_.bodies(), Vec3d{0, 0, 0}) {}

double SharpForcing::pull_of(const SharpNode& node, const std::array<double*, 3>& fields) const {
    const double* const field = nth(fields, node.component) + node.at;
    const std::ptrdiff_t stride[] = {1, layout_.row, layout_.plane};
    double pull = node.pull;
    for (int d = 0; d < 3; ++d)
        if (nth(node.ahead, d) != 0) pull += nth(node.ahead, d) * field[nth(node.side, d) * stride[d]];
    return pull;
}

void SharpForcing::act_on(std::span<const SharpNode> nodes, const FlowStage& stage, std::vector<RowSum>& sums) const {
    const double per_excess = stage.dt * viscosity_ / (h_ * h_);
    std::int32_t row = -1;
    const auto give = [&](const SharpNode& node, double change) {
        const std::uint32_t of = 3 * node.body + node.component;
        if (node.row != row || sums.back().of != of) sums.push_back({0, of});
        row = node.row;
        sums.back().change += change;
    };
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const SharpNode& node = nodes[n];
        double& u = nth(stage.velocity, node.component)[node.at];
        if (node.excess == SharpNode::inside) {
            give(node, node.velocity - u);
            u = node.velocity;
            continue;
        }
        std::size_t last = n;
        double weight = 1, sum = u;
        for (;; ++last) {
            const double a = per_excess * nodes[last].excess;
            weight += a;
            sum += per_excess * pull_of(nodes[last], stage.scratch);
            if (!nodes[last].again) break;
        }
        const double before = u;
        u = sum / weight; // theory.md (139)
        if (last == n) give(node, u - before);
        else
            for (std::size_t m = n; m <= last; ++m)
                give(nodes[m], per_excess * (pull_of(nodes[m], stage.scratch) - nodes[m].excess * u));
        n = last;
    }
}

void SharpForcing::act(const FlowStage& stage) {
    const Timers::Guard timing(seconds_);
    nodes_.settle(stage.time);
    std::vector<std::vector<RowSum>> sums(to_index(layout_.nz));
    threads_.for_each(sums.size(), [&](std::size_t k, int) {
        nodes_.for_lists(static_cast<int>(k), [&](std::span<const SharpNode> nodes) { act_on(nodes, stage, sums[k]); });
    });
    add_given(sums);
}

template <class Body> void SharpForcing::for_nodes(Body&& body) const {
    for_blocks(threads_, list_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t n = begin; n < end; ++n) body(n, list_[n]);
    });
}

double SharpForcing::slack(const SharpNode& node) const {
    return node.excess == SharpNode::inside ? 0 : h_ * h_ / (viscosity_ * stage_dt_ * node.excess);
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
    nodes_.settle(stage.time);
    list_nodes();
    for (std::size_t n = 0; n < list_.size(); ++n)
        nth(stage.velocity, list_[n].component)[list_[n].at] += stage.dt * held_.values()[n].x;
}

void SharpForcing::find_slips(const FlowStage& stage) {
    stage_dt_ = stage.dt;
    for_nodes([&](std::size_t n, const SharpNode& node) {
        const double u = nth(stage.velocity, node.component)[node.at];
        slip_[n] = node.excess == SharpNode::inside
                       ? node.velocity - u
                       : pull_of(node, stage.velocity) / node.excess - u - slack(node) * stage.dt * held_.values()[n].x;
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
        response_[n] = node.excess == SharpNode::inside
                           ? change
                           : change - pull_of(relative, stage.scratch) / node.excess + slack(node) * push_[n];
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
        const SharpNode& node = list_[n];
        const std::uint32_t of = 3 * node.body + node.component;
        const std::int64_t here = node.at / layout_.row;
        if (here != row || sums.back().of != of) sums.push_back({0, of});
        row = here;
        sums.back().change += stage.dt * held_.values()[n].x;
    }
    add_given({sums});
}

void SharpForcing::add_given(const std::vector<std::vector<RowSum>>& of_planes) {
    std::vector<double> changes;
    std::vector<std::uint32_t> of;
    for (const std::vector<RowSum>& sums : of_planes)
        for (const RowSum& sum : sums) {
            changes.push_back(sum.change);
            of.push_back(sum.of);
        }
    const std::vector<double> all =
        exact_sums(comm_, threads_, {changes.data(), changes.size(), 1, 1, 3 * given_.size(), of.data()});
    const double cell_volume = h_ * h_ * h_;
    for (std::size_t b = 0; b < given_.size(); ++b)
        given_[b] += cell_volume * Vec3d{all[3 * b], all[3 * b + 1], all[3 * b + 2]};
}

} // namespace skein
