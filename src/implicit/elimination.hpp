// Order in which the coupled rows of a cluster are eliminated, and where the blocks that come about lie. It depends on
// the joints alone, so all copies of an assembly and all steps share it.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace skein {

class Elimination {
public:
    /// `coupled`: pairs of different rows, in any order; each couples both ways.
    Elimination(std::size_t rows, std::span<const std::pair<std::size_t, std::size_t>> coupled);

    std::size_t rows() const { return pivot_.size(); }
    /// Number of blocks above the diagonal, and likewise below.
    std::size_t blocks() const { return later_.size(); }
    /// Place of a row in the order.
    std::size_t pivot(std::size_t row) const { return pivot_[row]; }
    /// Number of the block of two pivots, first < second.
    std::size_t block(std::size_t first, std::size_t second) const;
    /// Pivots that follow one and are coupled to it, in order; the first of them has the block first_block().
    std::span<const std::size_t> later(std::size_t pivot) const {
        return std::span(later_).subspan(begin_[pivot], begin_[pivot + 1] - begin_[pivot]);
    }
    std::size_t first_block(std::size_t pivot) const { return begin_[pivot]; }
    /// Blocks of all pairs among them, (0, 1), (0, 2) to (1, 2) and so on.
    std::span<const std::size_t> updated(std::size_t pivot) const {
        return std::span(updated_).subspan(first_update_[pivot], first_update_[pivot + 1] - first_update_[pivot]);
    }

private:
    std::vector<std::size_t> pivot_;                  ///< [rows]
    std::vector<std::size_t> begin_, later_;          ///< [rows + 1]; [blocks]
    std::vector<std::size_t> first_update_, updated_; ///< [rows + 1]; of all pairs
};

} // namespace skein
