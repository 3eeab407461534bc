#include "equilibrium/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace skein {

namespace {

/// True where the first `count` unknowns of both slots are free, and those of the rows have numbers without gaps.
bool is_whole(const SlotNumbers& rows, const SlotNumbers& columns, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        if (rows[i] < 0 || columns[i] < 0 || rows[i] != rows[0] + static_cast<int>(i)) return false;
    return true;
}

template <std::size_t count> void add_whole(const StiffnessBlock& block, const int* place, double* value) {
    for (std::size_t j = 0; j < count; ++j) {
        double* const column = value + place[j];
        for (std::size_t i = 0; i < count; ++i) column[i] += block[i][j];
    }
}

} // namespace

void Assembly::share(const Communicator& ranks, std::vector<int> ends) {
    ranks_ = &ranks;
    ends_ = std::move(ends);
    rank_ = ranks.rank();
}

void Assembly::begin(int count) {
    known_ =
        count == count_ && !transposed_.empty() && matrix_.nonZeros() == static_cast<Eigen::Index>(transposed_.size());
    count_ = count;
    at_ = 0;
    if (!known_) {
        items_.clear();
        return;
    }
    value_ = matrix_.valuePtr();
    std::fill(value_ + own_begin(), value_ + own_end(), 0.0);
}

void Assembly::add_block(std::size_t row, std::size_t column, const SlotNumbers& rows, const SlotNumbers& columns,
                         const StiffnessBlock& block, std::size_t count) {
    const std::uint64_t key = key_of_block(row, column, count);
    if (!expects(key)) {
        record({key, is_whole(rows, columns, count) ? Kind::whole : Kind::parts, static_cast<std::uint8_t>(count),
                &rows, &columns});
        ++at_;
        return;
    }
    const Item& item = items_[at_++];
    const int* const place = place_.data() + item.first;
    if (item.kind == Kind::whole) {
        if (count == slot_unknowns) add_whole<slot_unknowns>(block, place, value_);
        else add_whole<3>(block, place, value_);
        return;
    }
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < count; ++j)
            if (const int at = place[i * count + j]; at >= 0) value_[at] += block[i][j];
}

/// Numbers places of items.
void Assembly::give_places() {
    std::size_t places = 0;
    for (Item& item : items_) {
        const std::size_t count = item.count;
        item.first = places;
        places += item.kind == Kind::entry ? 1 : item.kind == Kind::whole ? count : count * count;
    }
    place_.assign(places, -1);
}

/// Visits columns of items with their rows.
template <class Visit> void Assembly::for_runs(const Visit& visit) const {
    for (const Item& item : items_) {
        if (item.kind == Kind::entry) {
            visit(static_cast<std::size_t>(item.key >> 32),
                  Run{static_cast<int>(item.key & 0xffffffff), 1, item.first});
            continue;
        }
        const std::size_t count = item.count;
        for (std::size_t j = 0; j < count; ++j) {
            const int column = (*item.columns)[j];
            if (column < 0) continue;
            const auto c = static_cast<std::size_t>(column);
            if (item.kind == Kind::whole) {
                visit(c, Run{(*item.rows)[0], static_cast<int>(count), item.first + j});
                continue;
            }
            for (std::size_t i = 0; i < count; ++i)
                if (const int row = (*item.rows)[i]; row >= 0) visit(c, Run{row, 1, item.first + i * count + j});
        }
    }
}

void Assembly::find_pattern() {
    items_.resize(at_);
    give_places();
    const auto columns = static_cast<std::size_t>(count_);
    std::vector<std::size_t> end(columns + 1, 0);
    for_runs([&](std::size_t column, const Run&) { ++end[column + 1]; });
    for (std::size_t j = 0; j < columns; ++j) end[j + 1] += end[j];
    std::vector<std::size_t> next(end.begin(), end.end() - 1);
    std::vector<Run> runs(end.back());
    for_runs([&](std::size_t column, const Run& run) { runs[next[column]++] = run; });
    std::vector<int> first(columns + 1, 0), rows;
    rows.reserve(runs.size() * 4);
    for (std::size_t j = 0; j < columns; ++j) {
        const auto begin = runs.begin() + static_cast<std::ptrdiff_t>(end[j]),
                   last = runs.begin() + static_cast<std::ptrdiff_t>(end[j + 1]);
        const auto before = [](const Run& a, const Run& b) { return a.row < b.row; };
        if (!std::is_sorted(begin, last, before)) std::sort(begin, last, before);
        for (auto run = begin; run != last; ++run) {
            int from = run->row;
            if (static_cast<int>(rows.size()) > first[j]) from = std::max(from, rows.back() + 1);
            for (int row = from; row < run->row + run->count; ++row) rows.push_back(row);
        }
        auto at = static_cast<std::size_t>(first[j]);
        for (auto run = begin; run != last; ++run) {
            while (rows[at] < run->row) ++at;
            place_[run->place] = static_cast<int>(at);
        }
        first[j + 1] = static_cast<int>(rows.size());
    }
    if (ranks_) gather_pattern(first, rows);
    matrix_.resize(count_, count_);
    matrix_.resizeNonZeros(static_cast<Eigen::Index>(rows.size()));
    std::copy(first.begin(), first.end(), matrix_.outerIndexPtr());
    std::copy(rows.begin(), rows.end(), matrix_.innerIndexPtr());
    find_transposed();
}

/// Completes a pattern, of which this rank has its columns.
void Assembly::gather_pattern(std::vector<int>& first, std::vector<int>& rows) {
    const std::vector<std::int64_t> entries = ranks_->all_gather(static_cast<std::int64_t>(rows.size()));
    const auto before = static_cast<int>(std::accumulate(entries.begin(), entries.begin() + rank_, std::int64_t{0}));
    for (int& place : place_)
        if (place >= 0) place += before;
    std::vector<std::int64_t> columns;
    for (std::size_t r = 0; r + 1 < ends_.size(); ++r) columns.push_back(ends_[r + 1] - ends_[r]);
    const std::size_t begin = to_index(ends_[to_index(rank_)]), own = to_index(columns[to_index(rank_)]);
    std::vector<int> last(own);
    for (std::size_t j = 0; j < own; ++j) last[j] = before + first[begin + j + 1];
    first.front() = 0;
    ranks_->all_gather(std::as_bytes(std::span(last)), sizeof(int), columns,
                       std::as_writable_bytes(std::span(first).subspan(1)));
    std::vector<int> all(to_index(first.back()));
    ranks_->all_gather(std::as_bytes(std::span(rows)), sizeof(int), entries, std::as_writable_bytes(std::span(all)));
    rows = std::move(all);
}

void Assembly::gather_values() {
    const int* first = matrix_.outerIndexPtr();
    std::vector<std::int64_t> entries;
    for (std::size_t r = 0; r + 1 < ends_.size(); ++r) entries.push_back(first[ends_[r + 1]] - first[ends_[r]]);
    const std::vector<double> own(value_ + own_begin(), value_ + own_end());
    ranks_->all_gather(own, entries, std::span(value_, to_index(matrix_.nonZeros())));
}

/// Places of K_ji: row i of the columns j = 0, 1, ... in turn, where the pattern is that of its transposed.
void Assembly::find_transposed() {
    const int *first = matrix_.outerIndexPtr(), *row = matrix_.innerIndexPtr();
    std::vector<int> next(first, first + count_);
    transposed_.resize(static_cast<std::size_t>(matrix_.nonZeros()));
    symmetric_pattern_ = true;
    for (int j = 0; j < count_; ++j)
        for (int at = first[j]; at < first[j + 1]; ++at) {
            const auto i = static_cast<std::size_t>(row[at]);
            while (next[i] < first[i + 1] && row[next[i]] < j) ++next[i];
            const bool there = next[i] < first[i + 1] && row[next[i]] == j;
            transposed_[static_cast<std::size_t>(at)] = there ? next[i]++ : -1;
            symmetric_pattern_ &= there;
        }
}

void Assembly::take_symmetric_part() {
    for (std::size_t at = 0; at < transposed_.size(); ++at) {
        const int other = transposed_[at];
        if (other < static_cast<int>(at)) continue; // done, or none
        value_[at] = value_[other] = 0.5 * (value_[at] + value_[other]);
    }
}

double Assembly::asymmetry() const {
    double largest = 0, difference = 0;
    for (std::size_t at = own_begin(); at < own_end(); ++at) {
        const int place = transposed_[at];
        if (place >= 0 && place < static_cast<int>(at)) continue; // done
        const double one = value_[at], other = place < 0 ? 0 : value_[place];
        largest = std::max({largest, std::abs(one), std::abs(other)});
        difference = std::max(difference, std::abs(one - other));
    }
    if (ranks_) {
        double sizes[] = {largest, difference};
        ranks_->max(std::span(sizes));
        std::tie(largest, difference) = std::tie(sizes[0], sizes[1]);
    }
    return largest > 0 ? difference / largest : 0;
}

} // namespace skein
