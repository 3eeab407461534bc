// Exchange between the transforms along x and along y, if ranks share the rows of their planes.
#pragma once

#include "fluid/neighbours.hpp"
#include "fluid/pencils.hpp"
#include "fluid/plane_transform.hpp"
#include "parallel/communicator.hpp"
#include "parallel/messages.hpp"
#include "skein/core/index.hpp"

#include <span>
#include <vector>

namespace skein {

/// Ranks of a slab exchange coefficients along x: all modes in a rank's rows for its modes in all rows, and back.
class RowExchange {
public:
    RowExchange(const Communicator& comm, const FluidGrid& grid, const Pencils& pencils) {
        const int planes = pencils.planes().count, rows = pencils.rows().count, mine = width(pencils, pencils.share());
        const auto numbers = [&](int of_rows, int of_modes) {
            return to_index(planes) * to_index(of_rows) * to_index(of_modes);
        };
        rows_ = AlignedVector<double>(numbers(rows, (grid.cells[0] + 7) / 8 * 8), 0.0);
        modes_ = AlignedVector<double>(numbers(grid.cells[1], mine), 0.0);
        std::vector<RepeatedMessages::Part> of_rows, of_modes;
        for (int s = 0; s < pencils.across(); ++s) {
            const int rank = pencils.rank_of(pencils.slab(), s), wide = width(pencils, s);
            const Slab others = pencils.rows(s);
            double* const to = rows_.data() + numbers(rows, pencils.modes(s).first);
            double* const from = modes_.data() + numbers(others.first, mine);
            of_rows.push_back(message_part(rank, {to, numbers(rows, wide)}));
            of_modes.push_back(message_part(rank, {from, numbers(others.count, mine)}));
            for (int m = 0; m < wide; m += 8) packs_.add(to + m, static_cast<std::ptrdiff_t>(rows) * wide, wide);
            for (int j = 0; j < others.count; ++j)
                whole_.add(from + static_cast<std::ptrdiff_t>(j) * mine,
                           static_cast<std::ptrdiff_t>(others.count) * mine);
        }
        to_modes_ = RepeatedMessages(comm, of_rows, of_modes);
        to_rows_ = RepeatedMessages(comm, of_modes, of_rows);
    }

    /// Packs of all modes along x in the rows of this rank.
    const PlanePacks& of_rows() const { return packs_; }
    /// Rows of this rank's modes for all of y.
    const PlaneRows& of_modes() const { return whole_; }
    /// Collective, like to_rows().
    void to_modes() {
        to_modes_.start();
        to_modes_.finish();
    }
    void to_rows() {
        to_rows_.start();
        to_rows_.finish();
    }

    std::size_t bytes() const { return (rows_.size() + modes_.size()) * sizeof(double); }

private:
    /// Number of modes of a share in whole packs.
    static int width(const Pencils& pencils, int share) { return (pencils.modes(share).count + 7) / 8 * 8; }

    AlignedVector<double> rows_;  ///< [share][plane][row][x mode]
    AlignedVector<double> modes_; ///< [share][plane][row of the share][x mode]
    PlanePacks packs_;
    PlaneRows whole_;
    RepeatedMessages to_modes_, to_rows_;
};

} // namespace skein
