// Fields of a fluid at the middles of cells: a file <prefix><step, 12 digits>.h5 for each frame, and an XDMF document,
// by which ParaView shows them all.
#pragma once

#include "io/h5_file.hpp"
#include "io/output_spec.hpp"
#include "parallel/communicator.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skein {

struct FieldName {
    std::string name, unit;
    int components;
};

/// What a frame shows: cells of a uniform grid, as datasets [z][y][x](3), or blocks of them, as datasets
/// [block][z][y][x](3).
struct FieldGrid {
    std::array<int, 3> cells; ///< of the grid, or of a block
    double spacing;           ///< m
    Vec3d lower;              ///< corner of the grid, or of the fluid that blocks are parts of, m
};

/// Numbers of a frame, which are asked for piece by piece.
class FieldFrame {
public:
    virtual ~FieldFrame() = default;

    /// Takes up field number `field`. Collective.
    virtual void begin(std::size_t field) = 0;
    /// This rank's parts of a dataset, without the dimension of components; of all fields.
    virtual const std::vector<H5Box>& pieces() const = 0;
    virtual void fill(std::size_t piece, std::span<double> out) = 0;
};

class FieldSeries {
public:
    /// Files go into `directory`: fields_<step>.h5 and fields.xdmf where the name is empty, else fluid_<name>_<step>.h5
    /// and fluid_<name>.xdmf. `labels`: texts that become attributes of each file.
    struct Names {
        std::string directory, name;
        std::vector<FieldName> fields;
        std::vector<std::pair<std::string, std::string>> labels;
    };
    /// Earlier frames that a resumed run goes on from.
    struct Earlier {
        std::int64_t resume_step = -1;                     ///< those up to here are kept; -1: none
        std::optional<std::int64_t> expected = {};         ///< the last that there should be; absent: not known
        std::function<void(const std::string&)> warn = {}; ///< called on root
    };
    /// The time of step s is shift + s dt. Earlier frames that are not what was written are put aside as *.damaged, and
    /// documents are made anew; `earlier.warn` gets that and gaps. Collective.
    FieldSeries(const Communicator& comm, Names names, FieldGrid grid, Precision precision, double dt, double shift,
                const Earlier& earlier);

    /// Name of the document that lists all frames of a series, without its ending.
    static std::string name_of(const std::string& name) { return name.empty() ? "fields" : "fluid_" + name; }
    /// Step of the last frame; -1: none.
    std::int64_t last_step() const { return last_step_; }

    /// Cells of a grid that has moved by `moved`, m. Collective, as all that writes; throws IoError on all ranks alike.
    void write(std::int64_t step, const Vec3d& moved, FieldFrame& frame);
    /// Blocks of `grid.cells` cells each from these cells of the fluid on, of which those beyond `fluid_cells` are
    /// none.
    void write_blocks(std::int64_t step, const Vec3d& moved, FieldFrame& frame,
                      std::span<const std::array<int, 3>> first_cells, const std::array<int, 3>& fluid_cells);

    /// Names in the directory of what is written of a step; blocks have a document for each.
    std::vector<std::string> files_of(std::int64_t step, bool blocks) const;

    /// Of a frame that is asked for in pieces: numbers in each, but for rows that are longer.
    static constexpr std::size_t most_numbers = 4 << 20;

private:
    /// Blocks of a frame: their first cells, and what each has of the fluid.
    struct Blocks {
        std::vector<double> lower; ///< corners, m, 3 each
        std::vector<std::array<int, 3>> cells;
    };
    Blocks blocks_of(const Vec3d& lower, std::span<const std::array<int, 3>> first_cells,
                     const std::array<int, 3>& fluid_cells) const;
    void write(std::int64_t step, const Vec3d& lower, FieldFrame& frame, std::vector<std::uint64_t> shape,
               const Blocks* blocks);
    void show_blocks(const std::string& path, const Blocks& blocks) const;
    /// Takes stock of the directory. Collective.
    void find_earlier(const Earlier& earlier);
    bool shows_same(const std::string& path) const; ///< a frame of these contents
    void list(std::int64_t step, const std::string& path);
    void write_documents() const;
    void write_block_document(std::int64_t step, const Blocks& blocks) const;
    std::string file_of(std::int64_t step, const char* ending) const;
    std::vector<std::int64_t> steps(const char* ending) const; ///< of files in the directory, rising
    std::string contents() const;                              ///< what frames that belong together have in common
    /// `group`: of datasets within the file; `suffix`: of their names.
    std::string grid_text(const std::string& file, const std::array<int, 3>& cells, const Vec3d& lower,
                          const std::string& group = "/", const std::string& suffix = "") const;
    std::string time_text(std::int64_t step) const;
    int number_bytes() const { return precision_ == Precision::single ? 4 : 8; }

    Communicator comm_;
    Names names_;
    FieldGrid grid_;
    Precision precision_;
    double dt_, shift_;
    /// Frames that show what this series does: their lower corners. Root only.
    std::map<std::int64_t, Vec3d> listed_;
    bool blocks_ = false; ///< frames have documents of their own; root only
    std::int64_t last_step_ = -1;
};

} // namespace skein
