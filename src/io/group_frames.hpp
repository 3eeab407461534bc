// Part of a group in trajectory files. Frames of its rods wait in memory in file order, and are written many at a time.
#pragma once

#include "io/h5_file.hpp"
#include "io/output_spec.hpp"
#include "io/xdmf.hpp"
#include "partition/partition.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Quantity of a frame: numbers of one rod, computed from its state.
struct FrameField {
    std::string name;
    std::vector<std::uint64_t> shape; ///< dimensions of one rod's numbers
    void (*fill_single)(const RodCopy& rod, float* out);
    void (*fill_double)(const RodCopy& rod, double* out);

    std::size_t numbers() const {
        return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
    }
};

class GroupFrames {
public:
    /// `group` and `rods` must outlive the object. Collective.
    GroupFrames(const Communicator& comm, const RodGroup& group, const Rods& rods, FrameKind kind,
                const OutputSpec& spec);

    /// Takes rods with new owners. Pending frames must be written before the next take(). Collective.
    void rebind(const Communicator& comm, const Rods& rods);

    /// Upper bound of the size of a frame in the file.
    std::uint64_t frame_bytes() const;
    /// Size of a pending frame on this rank.
    std::uint64_t pending_bytes() const { return owned_.places.size() * rod_bytes(); }
    /// Upper bound of the size of the constants.
    std::uint64_t constant_bytes() const;

    void make(H5File& file, const Communicator& comm) const;
    std::vector<std::string> frame_datasets() const;

    /// Takes a frame of the rods, one of at most `most` pending ones.
    void take(double lag, std::size_t most);
    /// Writes the pending frames, one for each of `digests`, from frame `first` on. It adds this rank's part of their
    /// digests.
    void write(H5File& file, std::uint64_t first, std::span<std::uint64_t> digests);
    /// True if there are pending frames of earlier owners.
    bool has_left() const { return pending_blocks_.has_value(); }
    void drop_pending() {
        pending_frames_ = 0;
        pending_blocks_.reset();
    }

    /// Makes datasets of single frames in a closed file for the side-car, because no spelling of hyperslabs suits both
    /// XDMF readers in use. Root only.
    void make_views(const std::string& file, std::uint64_t frames) const;

    XdmfGroup xdmf() const { return {group_.name(), group_.count(), group_.slots(), directors(), magnetised()}; }

private:
    std::string path() const { return "/groups/" + group_.name(); }
    std::string path(const std::string& dataset) const { return path() + "/" + dataset; }
    std::uint64_t count() const { return static_cast<std::uint64_t>(group_.count()); }
    std::size_t block_rods() const { return to_index(blocks_.size()); }
    std::size_t record_bytes(const FrameField& field) const { return field.numbers() * bytes_of(type_); }
    std::size_t rod_bytes() const;
    bool directors() const { return fields_.size() > 1; }
    bool magnetised() const { return group_.spec().magnetisation.pattern != MagnetisationPattern::none; }

    /// Writes a constant dataset [rods, width] from the rows of this rank's block.
    template <class T>
    void write_rows(H5File& file, const std::string& name, const std::vector<T>& rows, std::uint64_t width) const;
    /// Writes a constant dataset from root.
    void write_table(H5File& file, const Communicator& comm, const std::string& name,
                     const std::vector<double>& numbers, std::vector<std::uint64_t> shape) const;
    void write_constants(H5File& file, const Communicator& comm) const;
    void write_parts(H5File& file, const Communicator& comm) const; ///< shape of a body
    /// Radii at nodes of the rods of this rank's block, or of one rod if all are alike. Collective.
    std::vector<double> node_radii() const;

    const RodGroup& group_;
    const Rods* rods_;
    FrameKind kind_;
    H5Type type_; ///< type of numbers in frames
    std::vector<FrameField> fields_;
    OwnedRods owned_;
    IndexBlocks blocks_;
    std::optional<IndexBlocks> pending_blocks_; ///< blocks of pending frames, if owners have changed since
    /// Pending records of a field: [frames, rods of this rank's block] and [frames, rods of others' blocks].
    struct Pending {
        UnsetArray<std::byte> block, sent;
    };
    std::vector<Pending> pending_; ///< by field
    std::size_t pending_frames_ = 0;
};

} // namespace skein
