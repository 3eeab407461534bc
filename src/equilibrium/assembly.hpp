// Sparse stiffness from blocks between slots and from entries, whose places are found once for all matrices of one
// pattern. Ranks that share a sum each add to columns of their own, and all get the whole matrix: an entry is the sum
// of one rank, in the order of one rank.
#pragma once

#include "equilibrium/factor.hpp"
#include "parallel/communicator.hpp"
#include "skein/core/index.hpp"
#include "tiles/slot_coupling.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace skein {

/// Unknowns of a slot by their numbers; -1 where one is held.
using SlotNumbers = std::array<int, slot_unknowns>;

class Assembly {
public:
    /// Sums are shared by these ranks from here on, which all ask for them: rank r adds to the columns between ends[r]
    /// and ends[r + 1]. `ranks` must outlive them.
    void share(const Communicator& ranks, std::vector<int> ends);

    /// The sum of all that `add_all` adds, in its order. Where the pattern is new it is called again, and has to add
    /// the same. The matrix stays until the next sum.
    template <class AddAll> Stiffness& sum(int count, const AddAll& add_all) {
        begin(count);
        add_all();
        while (!is_complete_on_all()) {
            find_pattern();
            begin(count);
            add_all();
        }
        if (ranks_) gather_values();
        return matrix_;
    }

    void add(int row, int column, double value) {
        const std::uint64_t key = static_cast<std::uint64_t>(column) << 32 | static_cast<std::uint32_t>(row);
        if (expects(key)) value_[place_[items_[at_].first]] += value;
        else record({key, Kind::entry, 0, nullptr, nullptr});
        ++at_;
    }
    /// True where the pattern has this block next, though it may be zero now.
    bool expects_block(std::size_t row, std::size_t column) const {
        return expects(key_of_block(row, column, slot_unknowns));
    }
    /// Adds the part of a block between the first `count` unknowns of two slots: all, or those of the nodes. Numbers of
    /// a slot have to stay.
    void add_block(std::size_t row, std::size_t column, const SlotNumbers& rows, const SlotNumbers& columns,
                   const StiffnessBlock& block, std::size_t count);

    /// True where the pattern has K_ji for each K_ij.
    bool has_symmetric_pattern() const { return symmetric_pattern_; }
    double asymmetry() const; ///< largest |K - K^T| over the largest |K|
    /// Leaves (K + K^T)/2, if the pattern has K_ji for each K_ij.
    void take_symmetric_part();

private:
    enum class Kind : std::uint8_t {
        entry,
        whole, ///< block of columns without gaps
        parts, ///< block with a place for each entry
    };
    struct Item {
        std::uint64_t key; ///< column and row
        Kind kind;
        std::uint8_t count;                ///< unknowns of a block
        const SlotNumbers *rows, *columns; ///< of a block
        std::size_t first = 0;             ///< among the places
    };
    /// Rows of a column without gaps.
    struct Run {
        int row, count;
        std::size_t place; ///< of the place of its first row
    };

    static std::uint64_t key_of_block(std::size_t row, std::size_t column, std::size_t count) {
        return std::uint64_t{count < slot_unknowns ? 3U : 2U} << 62 | std::uint64_t{column} << 31 | std::uint64_t{row};
    }
    void begin(int count);
    bool is_complete() const {
        return items_.empty() ? at_ == 0 && matrix_.rows() == count_ && own_end() == own_begin()
                              : known_ && at_ == items_.size();
    }
    bool is_complete_on_all() const { return ranks_ ? ranks_->min(std::int64_t{is_complete()}) > 0 : is_complete(); }
    /// Values of this rank's columns.
    std::size_t own_begin() const { return to_index(matrix_.outerIndexPtr()[ranks_ ? ends_[to_index(rank_)] : 0]); }
    std::size_t own_end() const {
        return to_index(matrix_.outerIndexPtr()[ranks_ ? ends_[to_index(rank_) + 1] : matrix_.outerSize()]);
    }
    bool expects(std::uint64_t key) const { return known_ && at_ < items_.size() && items_[at_].key == key; }
    void record(const Item& item) {
        if (known_) items_.resize(at_);
        known_ = false;
        items_.push_back(item);
    }
    void find_pattern();
    void gather_pattern(std::vector<int>& first, std::vector<int>& rows);
    void gather_values();
    void give_places();
    template <class Visit> void for_runs(const Visit& visit) const;
    void find_transposed();

    const Communicator* ranks_ = nullptr; ///< null: this rank adds to all columns
    std::vector<int> ends_;               ///< columns before those of each rank, and all
    int rank_ = 0, count_ = 0;
    bool known_ = false; ///< as far as the items before
    std::size_t at_ = 0;
    std::vector<Item> items_;
    std::vector<int> place_;      ///< among the values
    std::vector<int> transposed_; ///< place of K_ji for K_ij; -1: none
    bool symmetric_pattern_ = false;
    double* value_ = nullptr;
    Stiffness matrix_;
};

} // namespace skein
