// Ghosts of fields from neighbouring ranks.
#pragma once

#include "fluid/neighbours.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <map>
#include <vector>

namespace skein {

/// Messages of planes are prepared once for each list of arrays, messages of rows once for each number of fields.
class GhostExchange {
public:
    using Fields = std::span<double* const>;
    GhostExchange(const Communicator& comm, const Pencils& pencils, const FluidGrid& grid)
        : comm_(comm), layout_(pencils.layout()), along_y_(Neighbours::of_rows(pencils, grid.periodic(1))),
          along_z_(Neighbours::of_slabs(pencils, grid.periodic(2))), share_rows_(pencils.across() > 1),
          share_planes_(pencils.slabs() > 1) {}

    /// Exchanges rows in this rank's planes, with ghosts along x, unless it has all rows. Collective.
    void exchange_rows(Fields fields) {
        if (!share_rows_) return;
        auto found = rows_.find(fields.size());
        if (found == rows_.end())
            found = rows_.try_emplace(fields.size(), comm_, along_y_, fields.size() * rows_of_field()).first;
        Rows& rows = found->second;
        if (along_y_.below >= 0) copy_rows<true>(fields, 0, rows.lowest);
        if (along_y_.above >= 0) copy_rows<true>(fields, layout_.ny - width, rows.uppermost);
        rows.messages.start();
        rows.messages.finish();
        if (along_y_.below >= 0) copy_rows<false>(fields, -width, rows.from_below);
        if (along_y_.above >= 0) copy_rows<false>(fields, layout_.ny, rows.from_above);
    }
    /// Exchanges planes with all their ghosts. Collective.
    void exchange_planes(Fields fields) {
        if (!share_planes_) {
            if (along_z_.below >= 0)
                for (double* field : fields) wrap(field);
            return;
        }
        const std::vector<double*> key(fields.begin(), fields.end());
        auto found = planes_.find(key);
        if (found == planes_.end()) found = planes_.emplace(key, make(fields)).first;
        found->second.start();
        found->second.finish();
    }

private:
    static constexpr int width = FieldLayout::ghosts;
    struct Rows {
        Rows(const Communicator& comm, const Neighbours& neighbours, std::size_t numbers)
            : lowest(numbers), uppermost(numbers), from_below(numbers), from_above(numbers) {
            NeighbourParts parts(neighbours);
            parts.add(lowest, uppermost, from_below, from_above);
            messages = parts.messages(comm);
        }
        std::vector<double> lowest, uppermost, from_below, from_above; ///< [field][plane][row][x, with room before]
        RepeatedMessages messages;
    };
    std::size_t block() const { return to_index(layout_.row) * width; } ///< numbers in rows of ghosts of a plane
    std::size_t rows_of_field() const { return block() * to_index(layout_.nz); }
    /// Copies rows j, j + 1 in each plane of each field to or from a buffer.
    template <bool to_buffer> void copy_rows(Fields fields, int j, std::vector<double>& buffer) const {
        double* at = buffer.data();
        for (double* field : fields)
            for (int k = 0; k < layout_.nz; ++k, at += block()) {
                double* const rows = field + layout_.at(0, j, k) - FieldLayout::before;
                std::copy_n(to_buffer ? rows : at, block(), to_buffer ? at : rows);
            }
    }

    std::size_t numbers() const { return to_index(layout_.plane) * width; }
    double* planes(double* field, int k) const { return field + (k + width) * layout_.plane; }
    void wrap(double* field) const {
        std::copy_n(planes(field, layout_.nz - width), numbers(), planes(field, -width));
        std::copy_n(planes(field, 0), numbers(), planes(field, layout_.nz));
    }
    RepeatedMessages make(Fields fields) const {
        NeighbourParts parts(along_z_);
        for (double* field : fields) {
            const auto at = [&](int k) { return std::span(planes(field, k), numbers()); };
            parts.add(at(0), at(layout_.nz - width), at(-width), at(layout_.nz));
        }
        return parts.messages(comm_);
    }
    Communicator comm_;
    FieldLayout layout_;
    Neighbours along_y_, along_z_;
    bool share_rows_, share_planes_;
    std::map<std::size_t, Rows> rows_;
    std::map<std::vector<double*>, RepeatedMessages> planes_;
};

} // namespace skein
