// Fields of a fluid at the middles of cells. Each frame is a file <prefix><step, 12 digits>.h5, and an XDMF document
// lists all frames for ParaView.
#pragma once

#include "io/frame_files.hpp"
#include "io/h5_file.hpp"
#include "io/output_spec.hpp"
#include "parallel/communicator.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skein {

struct FieldName {
    std::string name, unit;
    int components;
};

/// Cells of a uniform grid in a frame, as datasets [z][y][x](3), or blocks of cells, as datasets [block][z][y][x](3).
struct FieldGrid {
    std::array<int, 3> cells; ///< numbers of cells of the grid, or of a block
    double spacing;           ///< m
    Vec3d lower;              ///< lower corner of the grid, or of the fluid that has the blocks, m
};

/// Numbers of a frame, piece by piece.
class FieldFrame {
public:
    virtual ~FieldFrame() = default;

    /// Starts with field number `field`. Collective.
    virtual void begin(std::size_t field) = 0;
    /// This rank's parts of the dataset of any field, without the dimension of components.
    virtual const std::vector<H5Box>& pieces() const = 0;
    virtual void fill(std::size_t piece, std::span<double> out) = 0;
};

class FieldSeries {
public:
    /// Files in `directory` are fields_<step>.h5 and fields.xdmf without a name, else fluid_<name>_<step>.h5 and
    /// fluid_<name>.xdmf. `labels` become attributes of each file.
    struct Names {
        std::string directory, name;
        std::vector<FieldName> fields;
        std::vector<std::pair<std::string, std::string>> labels;
    };
    /// Checks earlier frames and rewrites the documents. The time of step s is shift + s dt. Collective.
    FieldSeries(const Communicator& comm, Names names, FieldGrid grid, Precision precision, double dt, double shift,
                const EarlierFrames& earlier);

    /// Name of the document that lists all frames of a series, without its ending.
    static std::string name_of(const std::string& name) { return name.empty() ? "fields" : "fluid_" + name; }
    /// Step of the last frame; -1: none.
    std::int64_t last_step() const { return last_step_; }

    /// Writes a grid that has moved by `moved`, m. All writing is collective and throws IoError on all ranks alike.
    void write(std::int64_t step, const Vec3d& moved, FieldFrame& frame);
    /// Writes blocks of `grid.cells` cells from these cells of the fluid on. Cells beyond `fluid_cells` have no
    /// numbers.
    void write_blocks(std::int64_t step, const Vec3d& moved, FieldFrame& frame,
                      std::span<const std::array<int, 3>> first_cells, const std::array<int, 3>& fluid_cells);

    /// Names of the files of a step in the directory; a frame of blocks has a document too.
    std::vector<std::string> files_of(std::int64_t step, bool blocks) const;

    /// Most numbers in a piece of a frame, unless a row has more.
    static constexpr std::size_t most_numbers = 4 << 20;

private:
    /// Lower corners of the blocks of a frame, and their cells in the fluid.
    struct Blocks {
        std::vector<double> lower; ///< m, 3 numbers each
        std::vector<std::array<int, 3>> cells;
    };
    Blocks blocks_of(const Vec3d& lower, std::span<const std::array<int, 3>> first_cells,
                     const std::array<int, 3>& fluid_cells) const;
    /// Step of the frame before `step` in the directory, or `step` itself if it has that frame. Collective.
    std::int64_t step_before(std::int64_t step) const;
    void write(std::int64_t step, const Vec3d& lower, FieldFrame& frame, const std::vector<std::uint64_t>& shape,
               const Blocks* blocks);
    void write_attributes(H5File& file, std::int64_t step, std::int64_t before, const Vec3d& lower) const;
    void write_corners(H5File& file, const Blocks& blocks) const;
    void write_field(H5File& file, std::size_t number, FieldFrame& frame, std::vector<std::uint64_t> shape) const;
    void show_blocks(const std::string& path, const Blocks& blocks) const;
    /// Adds an earlier frame to the documents. Root only.
    void list(std::int64_t step, const H5File& file);
    void write_documents() const;
    void write_block_document(std::int64_t step, const Blocks& blocks) const;
    std::string prefix() const;
    std::string file_of(std::int64_t step, const char* ending) const;
    std::string contents() const; ///< equal in frames of one document
    /// Datasets are `group`<field>`suffix` of the file.
    std::string grid_text(const std::string& file, const std::array<int, 3>& cells, const Vec3d& lower,
                          const std::string& group = "/", const std::string& suffix = "") const;
    std::string time_text(std::int64_t step) const;

    Communicator comm_;
    Names names_;
    FieldGrid grid_;
    H5Type type_;
    double dt_, shift_;
    std::map<std::int64_t, Vec3d> listed_; ///< lower corners of frames in the document; root only
    bool blocks_ = false;                  ///< frames have documents of their own; root only
    std::int64_t last_step_ = -1;
};

} // namespace skein
