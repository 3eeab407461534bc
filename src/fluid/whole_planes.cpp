#include "fluid/whole_planes.hpp"

#include "fluid/pressure_gain.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cstring>

namespace skein {

PlaneExchange::PlaneExchange(const Communicator& comm, const FluidGrid& grid, const Pencils& pencils, int ghosts)
    : comm_(comm), grid_(grid), pencils_(pencils), ghosts_(ghosts), planes_(planes_of(pencils.share())),
      layout_(grid.cells[0], grid.cells[1], planes_.count), of_rows_(pencils.layout()) {}

Slab PlaneExchange::planes_of(int share) const {
    return slab_of(grid_.cells[2], pencils_.rank_of(pencils_.slab(), share), pencils_.ranks());
}

Slab PlaneExchange::rows_with_ghosts(int share) const {
    Slab rows = pencils_.rows(share);
    if (share == 0) {
        rows.first -= ghosts_;
        rows.count += ghosts_;
    }
    if (share + 1 == pencils_.across()) rows.count += ghosts_;
    return rows;
}

template <class Body> void PlaneExchange::for_sent(Body&& body) const {
    const Slab rows = rows_with_ghosts(pencils_.share());
    for (int share = 0; share < pencils_.across(); ++share) {
        const Slab planes = planes_of(share);
        if (planes.count == 0) continue;
        const int first = planes.first - pencils_.planes().first;
        for (int k = -ghosts_; k < planes.count + ghosts_; ++k)
            for (int j = rows.first; j < rows.first + rows.count; ++j)
                body(share, j - pencils_.rows().first, first + k);
    }
}

template <class Body> void PlaneExchange::for_received(Body&& body) const {
    if (planes_.count == 0) return;
    for (int share = 0; share < pencils_.across(); ++share) {
        const Slab rows = rows_with_ghosts(share);
        for (int k = -ghosts_; k < planes_.count + ghosts_; ++k)
            for (int j = rows.first; j < rows.first + rows.count; ++j) body(share, j, k);
    }
}

std::vector<double> PlaneExchange::exchanged(std::span<const double> sent,
                                             std::span<const std::int64_t> of_shares) const {
    std::vector<std::int64_t> counts(to_index(comm_.size()), 0), come;
    for (int share = 0; share < pencils_.across(); ++share)
        nth(counts, pencils_.rank_of(pencils_.slab(), share)) = nth(of_shares, share);
    const std::vector<std::byte> arrived =
        comm_.all_to_all(std::as_bytes(sent), to_index(layout_.row) * sizeof(double), counts, come);
    std::vector<double> numbers(arrived.size() / sizeof(double));
    if (!arrived.empty()) std::memcpy(numbers.data(), arrived.data(), arrived.size());
    return numbers;
}

template <class ForSent, class ForReceived>
void PlaneExchange::exchange(std::span<const double> from, const FieldLayout& of_from, ForSent&& for_sent_rows,
                             std::span<double> to, const FieldLayout& of_to, ForReceived&& for_received_rows) const {
    std::vector<double> sent;
    std::vector<std::int64_t> counts(to_index(pencils_.across()), 0);
    for_sent_rows([&](int share, int j, int k) {
        const auto row = from.begin() + of_from.at(0, j, k) - FieldLayout::before;
        sent.insert(sent.end(), row, row + of_from.row);
        ++nth(counts, share);
    });
    const std::vector<double> come = exchanged(sent, counts);
    auto row = come.begin();
    for_received_rows([&](int, int j, int k) {
        std::copy_n(row, of_to.row, to.begin() + of_to.at(0, j, k) - FieldLayout::before);
        row += of_to.row;
    });
}

void PlaneExchange::to_planes(std::span<const double> rows, std::span<double> planes) const {
    exchange(
        rows, of_rows_, [this](auto&& body) { for_sent(body); }, planes, layout_,
        [this](auto&& body) { for_received(body); });
}

void PlaneExchange::to_rows(std::span<const double> planes, std::span<double> rows) const {
    exchange(
        planes, layout_, [this](auto&& body) { for_received(body); }, rows, of_rows_,
        [this](auto&& body) { for_sent(body); });
}

FlowPlanes::FlowPlanes(const Communicator& comm, const FlowSolver& flow)
    : flow_(flow), exchange_(comm, flow.constants().grid, flow.pencils(), FieldLayout::ghosts) {}

void FlowPlanes::take() {
    for (std::size_t f = 0; f < fields_.size(); ++f) {
        fields_[f] = f < 3 ? flow_.velocity(static_cast<int>(f)) : flow_.pressure();
        if (flow_.pencils().across() == 1) continue;
        copies_[f].resize(layout().size());
        exchange_.to_planes(fields_[f], copies_[f]);
        fields_[f] = copies_[f];
    }
    // Extrapolates the pressure to the time of the flow. theory.md (77a)
    const auto [field, times] = pressure_in_time(flow_).pressure_gain();
    if (times == 0) return;
    std::vector<double> gain;
    std::span<const double> in_planes = field;
    if (flow_.pencils().across() > 1) {
        gain.resize(layout().size());
        exchange_.to_planes(field, gain);
        in_planes = gain;
    } else copies_[3].assign(fields_[3].begin(), fields_[3].end());
    for (std::size_t at = 0; at < copies_[3].size(); ++at) copies_[3][at] += times * in_planes[at];
    fields_[3] = copies_[3];
}

void FlowPlanes::release() {
    for (auto& field : fields_) field = {};
    for (auto& copy : copies_) copy = {};
}

WholeState::WholeState(const Communicator& comm, FlowSolver& flow)
    : flow_(flow), exchange_(comm, flow.constants().grid, flow.pencils(), 0), fields_(flow.state()) {
    if (flow.pencils().across() == 1) return;
    copies_.resize(fields_.size());
    for (std::size_t f = 0; f < fields_.size(); ++f) {
        copies_[f].resize(exchange_.layout().size());
        exchange_.to_planes(fields_[f], copies_[f]);
        fields_[f] = copies_[f];
    }
}

std::size_t WholeState::numbers_of_plane() const {
    return fields_.size() * to_index(exchange_.layout().nx) * to_index(exchange_.layout().ny);
}

void WholeState::put_back() {
    const auto state = flow_.state();
    for (std::size_t f = 0; f < copies_.size(); ++f) exchange_.to_rows(copies_[f], state[f]);
}

} // namespace skein
