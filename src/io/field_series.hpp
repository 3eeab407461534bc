// Fields of a fluid at the middles of cells: a file fields_<step, 12 digits>.h5 for each frame, and fields.xdmf, by which ParaView
// shows them all.
#pragma once

#include "io/h5_file.hpp"
#include "parallel/communicator.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace skein {

/// A uniform grid, of which each rank has whole planes across z.
struct FieldGrid {
    std::array<int, 3> cells;
    double spacing;          ///< m
    Vec3d lower;             ///< corner, m
    int first_plane, planes; ///< of this rank
};

/// Of this rank's cells, x fastest.
struct CellField {
    std::string name, unit;
    int components;
    std::vector<float> value; ///< [plane][row][cell][component]
};

class FieldSeries {
public:
    /// Files go into `directory`. The time of step s is shift + s dt.
    FieldSeries(const Communicator& comm, std::string directory, FieldGrid grid, double dt, double shift);
    /// Collective; throws IoError on all ranks alike.
    void write(std::int64_t step, const std::vector<CellField>& fields);

private:
    std::string document(const std::vector<CellField>& fields) const;

    Communicator comm_;
    std::string directory_;
    FieldGrid grid_;
    double dt_, shift_;
};

} // namespace skein
