// Ghosts of fields, from neighbouring ranks.
#pragma once

#include "fluid/neighbours.hpp"

#include <algorithm>
#include <map>
#include <vector>

namespace skein {

/// Messages of planes are made once for each array, those of rows once for each number of fields.
class GhostExchange {
public:
    using Fields = std::span<double* const>;
    GhostExchange(const Communicator& comm, const Pencils& pencils, const FluidGrid& grid)
        : comm_(comm), layout_(pencils.layout()), along_y_(Neighbours::of_rows(pencils, grid.periodic(1))),
          along_z_(Neighbours::of_slabs(pencils, grid.periodic(2))), share_rows_(pencils.across() > 1),
          share_planes_(pencils.slabs() > 1) {}

    /// With the ghosts along x in them, of this rank's planes; none where it has all rows.
    void exchange_rows(Fields fields) {
        if (!share_rows_) return;
        auto found = rows_.find(fields.size());
        if (found == rows_.end())
            found = rows_.try_emplace(fields.size(), comm_, along_y_, fields.size() * rows_of_field()).first;
        Rows& rows = found->second;
        const int last = layout_.ny - width;
        if (along_y_.below >= 0)
            copy_rows(fields, 0, [&](double* from, std::size_t at) { to_buffer(rows.lowest, at, from); });
        if (along_y_.above >= 0)
            copy_rows(fields, last, [&](double* from, std::size_t at) { to_buffer(rows.uppermost, at, from); });
        rows.messages.start();
        rows.messages.finish();
        if (along_y_.below >= 0)
            copy_rows(fields, -width, [&](double* to, std::size_t at) { from_buffer(rows.from_below, at, to); });
        if (along_y_.above >= 0)
            copy_rows(fields, layout_.ny, [&](double* to, std::size_t at) { from_buffer(rows.from_above, at, to); });
    }
    /// With all ghosts in them.
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
    std::size_t block() const { return static_cast<std::size_t>(layout_.row) * width; } ///< rows of ghosts of a plane
    std::size_t rows_of_field() const { return block() * static_cast<std::size_t>(layout_.nz); }
    void to_buffer(std::vector<double>& buffer, std::size_t at, const double* from) const {
        std::copy_n(from, block(), &buffer[at]);
    }
    void from_buffer(const std::vector<double>& buffer, std::size_t at, double* to) const {
        std::copy_n(&buffer[at], block(), to);
    }
    /// body(rows, place in a buffer) of as many rows as ghosts, from j on, in each plane of each field.
    template <class Body> void copy_rows(Fields fields, int j, Body&& body) const {
        std::size_t at = 0;
        for (double* field : fields)
            for (int k = 0; k < layout_.nz; ++k, at += block())
                body(field + layout_.at(0, j, k) - FieldLayout::before, at);
    }

    std::size_t numbers() const { return static_cast<std::size_t>(layout_.plane) * width; }
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
