// Parallel HDF5 behind a few verbs. All calls are collective. HDF5 may fail on one rank and succeed on another (a full
// disk does that), so every call's outcome is agreed on: all ranks return, or all throw the same IoError with path,
// deed and HDF5's reason. Files depend on what is written only: no time stamps, no trace of the number of ranks.
#pragma once

#include "parallel/communicator.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace skein {

enum class H5Type { float32, float64, int64, uint64 };
template <class T> H5Type h5_type();
template <> inline H5Type h5_type<double>() { return H5Type::float64; }
template <> inline H5Type h5_type<std::int64_t>() { return H5Type::int64; }

/// A box of a dataset: its first corner and its size along each dimension. Empty (a zero in `count`) on ranks without a
/// share.
struct H5Box {
    std::vector<std::uint64_t> start, count;
};

class H5File {
public:
    enum class Mode { create, modify, read };

    H5File(const Communicator& comm, std::string path, Mode mode);
    /// A file that was being written and did not reach close() is emptied: it is of no use, and on a full disk it
    /// stands in the way.
    ~H5File();
    H5File(const H5File&) = delete;
    H5File& operator=(const H5File&) = delete;

    /// Ends the file well: everything is on the disk when this returns.
    void close();
    /// Takes disk space for `bytes` (and a little for HDF5 itself) beside what was reserved before. HDF5 may hang when
    /// the disk turns out to be full while it writes (one rank fails, the others wait for it), so ask first. Unlike
    /// require_space() this knows of quotas.
    void reserve(std::uint64_t bytes);

    void make_group(const std::string& path);
    void make_dataset(const std::string& path, H5Type type, const std::vector<std::uint64_t>& shape);
    /// A dataset that grows along its first dimension, from no frames, each `frame_shape`. It may take up to
    /// `frames_slack` bytes more than its frames.
    void make_frames(const std::string& path, H5Type type, const std::vector<std::uint64_t>& frame_shape);
    static constexpr std::uint64_t frames_slack = 8 << 10;
    /// Lets datasets of equally many frames have `frames`. Space is taken as if they grew frame by frame, all of them
    /// in turn: the file's bytes do not depend on how many frames are added at a time. On the way, after every
    /// `flush_every` frames of the file (0: never), its tables are brought to the disk, so that a process that is
    /// killed leaves a file that can be read.
    void set_frames(const std::vector<std::string>& paths, std::uint64_t frames, std::uint64_t flush_every = 0);
    std::vector<std::uint64_t> shape(const std::string& path) const;
    H5Type type(const std::string& path) const; ///< of a dataset's numbers
    bool has(const std::string& path) const;    ///< a dataset or group; false too where one above it is missing
    bool has(const std::string& object, const std::string& attribute) const;

    /// Every rank's box, as numbers of `type`, which is also the type on file: conversion would make transfers
    /// independent.
    void write(const std::string& path, H5Type type, const H5Box& box, const void* data);
    void read(const std::string& path, H5Type type, const H5Box& box, void* data) const;

    /// Attributes of the group or dataset `object`.
    void set(const std::string& object, const std::string& name, std::int64_t value);
    void set(const std::string& object, const std::string& name, std::uint64_t value);
    void set(const std::string& object, const std::string& name, double value);
    void set(const std::string& object, const std::string& name, const std::string& value);
    void get(const std::string& object, const std::string& name, std::int64_t& value) const;
    void get(const std::string& object, const std::string& name, std::uint64_t& value) const;
    void get(const std::string& object, const std::string& name, double& value) const;
    void get(const std::string& object, const std::string& name, std::string& value) const;

private:
    /// Has the disk begin with what was written, these `bytes` last, so that less is left to wait for in close(). A
    /// hint: nothing fails.
    void start_flush(std::uint64_t bytes);
    void agree(bool well, const std::string& deed) const;
    void set(const std::string& object, const std::string& name, H5Type type, const void* value);
    void get(const std::string& object, const std::string& name, H5Type type, void* value) const;

    Communicator comm_;
    std::string path_;
    Mode mode_;
    std::int64_t id_ = -1;
    std::uint64_t reserved_ = 0;
    int descriptor_ = -1;         ///< of the file, for start_flush; absent where it could not be opened
    std::uint64_t unflushed_ = 0; ///< bytes since its last
};

/// Shows each frame k of datasets <group>/<name>, `frames` of them, as a dataset <group>/frames/<k>/<name> of its own,
/// without a copy (HDF5 calls it virtual). For one rank alone, in a file that is closed: in one that is open on all
/// ranks HDF5 would duplicate the communicator for each.
void make_frame_views(const std::string& file, const std::string& group, const std::vector<std::string>& names,
                      std::uint64_t frames);

/// Part of a dataset that is shown as a dataset of its own, without the first dimension, of which it has one row.
struct PartView {
    std::string name, dataset;
    H5Box part;
};
/// Shows parts as datasets of a new group, without a copy; as make_frame_views.
void make_part_views(const std::string& file, const std::string& group, const std::vector<PartView>& views);

} // namespace skein
