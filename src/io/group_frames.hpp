// One group's part of trajectory files: frames of its rods wait in memory, in file order, and are written many at a
// time.
#pragma once

#include "io/h5_file.hpp"
#include "io/output_spec.hpp"
#include "io/xdmf.hpp"
#include "partition/partition.hpp"
#include "skein/core/aligned.hpp"
#include "tiles/rods.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// A quantity of a frame: numbers of one rod, worked out from its state.
struct FrameField {
    std::string name;
    std::vector<std::uint64_t> shape; ///< of one rod
    void (*fill_single)(const RodCopy& rod, float* out);
    void (*fill_double)(const RodCopy& rod, double* out);

    std::size_t numbers() const {
        std::size_t n = 1;
        for (const auto extent : shape) n *= extent;
        return n;
    }
};

class GroupFrames {
public:
    /// `group` and `rods` must outlive it. Collective.
    GroupFrames(const Communicator& comm, const RodGroup& group, const Rods& rods, FrameKind kind,
                const OutputSpec& spec);

    /// Rods have new owners from now on. Frames that are pending must be written before others are taken.
    /// Collective.
    void follow(const Communicator& comm, const Rods& rods);

    /// Of a frame in the file, or more.
    std::uint64_t frame_bytes() const;
    /// Of a pending frame on this rank.
    std::size_t pending_bytes() const { return owned_.places.size() * rod_bytes(); }
    /// Of what holds for all frames, or more.
    std::uint64_t constant_bytes() const;

    void make(H5File& file, const Communicator& comm) const;
    std::vector<std::string> frame_datasets() const;

    /// Takes a frame of the rods as they are, one of at most `most` that will be pending.
    void take(double lag, std::size_t most);
    /// Writes the pending frames, as many as there are `digests`, from frame `first` on; adds this rank's part to their
    /// digests.
    void write(H5File& file, std::uint64_t first, std::span<std::uint64_t> digests);
    /// Whether there are pending frames of other owners.
    bool has_left() const { return pending_blocks_.has_value(); }
    void drop_pending() {
        pending_frames_ = 0;
        pending_blocks_.reset();
    }

    /// Single frames under names of their own, for the side-car: of the XDMF readers in use one knows hyperslabs only
    /// in a spelling that the other does not. Root only, of a closed file.
    void make_views(const std::string& file, std::uint64_t frames) const;

    XdmfGroup xdmf() const { return {group_.name(), group_.count(), group_.slots(), directors(), magnetised()}; }

private:
    std::string path() const { return "/groups/" + group_.name(); }
    std::string path(const std::string& dataset) const { return path() + "/" + dataset; }
    std::uint64_t count() const { return static_cast<std::uint64_t>(group_.count()); }
    std::size_t block_rods() const { return static_cast<std::size_t>(blocks_.size()); }
    std::size_t number_bytes() const { return precision_ == Precision::single ? 4 : 8; }
    H5Type number_type() const { return precision_ == Precision::single ? H5Type::float32 : H5Type::float64; }
    std::size_t record_bytes(const FrameField& field) const { return field.numbers() * number_bytes(); }
    std::size_t rod_bytes() const;
    bool directors() const { return fields_.size() > 1; }
    bool magnetised() const { return group_.spec().magnetisation.pattern != MagnetisationPattern::none; }

    /// A dataset [rods, width] that holds for all frames: this rank's rows from row(index, out).
    template <class T, class Row>
    void write_rows(H5File& file, const std::string& name, std::uint64_t width, Row row) const;
    void write_constants(H5File& file, const Communicator& comm) const;

    const RodGroup& group_;
    const Rods* rods_;
    FrameKind kind_;
    Precision precision_;
    std::vector<FrameField> fields_;
    OwnedRods owned_;
    IndexBlocks blocks_;
    std::optional<IndexBlocks> pending_blocks_; ///< of pending frames, where owners have changed since
    /// Records of a field that wait to be written: [frames, rods of this rank's block] and [frames, rods of others'
    /// blocks].
    struct Pending {
        UnsetArray<std::byte> block, sent;
    };
    std::vector<Pending> pending_; ///< by field
    std::size_t pending_frames_ = 0;
};

} // namespace skein
