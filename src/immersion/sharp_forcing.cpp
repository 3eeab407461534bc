#include "immersion/sharp_forcing.hpp"

#include "core/timer.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

SharpForcing::SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                           double kinematic_viscosity, std::vector<SharpBody> bodies, int across)
    : comm_(comm), threads_(threads), h_(grid.h), viscosity_(kinematic_viscosity),
      layout_(Pencils(grid, comm.rank(), comm.size(), across).layout()),
      nodes_(threads, grid, Pencils(grid, comm.rank(), comm.size(), across), std::move(bodies)),
      given_(nodes_.bodies(), Vec3d{0, 0, 0}) {}

double SharpForcing::pull_of(const SharpNode& node, const FlowStage& stage) const {
    const double* const before = nth(stage.scratch, node.component) + node.at;
    const std::ptrdiff_t stride[] = {1, layout_.row, layout_.plane};
    double pull = node.pull;
    for (int d = 0; d < 3; ++d)
        if (nth(node.ahead, d) != 0) pull += nth(node.ahead, d) * before[nth(node.side, d) * stride[d]];
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
            sum += per_excess * pull_of(nodes[last], stage);
            if (!nodes[last].again) break;
        }
        const double before = u;
        u = sum / weight; // theory.md (129)
        if (last == n) give(node, u - before);
        else
            for (std::size_t m = n; m <= last; ++m)
                give(nodes[m], per_excess * (pull_of(nodes[m], stage) - nodes[m].excess * u));
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
