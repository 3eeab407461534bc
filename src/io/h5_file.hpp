// Parallel HDF5 behind a few verbs. All calls are collective. HDF5 may fail on one rank alone, for example on a full
// disk, so ranks agree on every outcome. All return, or all throw the same IoError with path, deed and HDF5's reason.
// Files contain no time stamps and do not depend on the number of ranks.
#pragma once

#include "parallel/communicator.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace skein {

enum class H5Type { float32, float64, int64, uint64 };
inline std::size_t bytes_of(H5Type type) { return type == H5Type::float32 ? 4 : 8; }
template <class T> constexpr H5Type h5_type() {
    if constexpr (std::is_same_v<T, float>) return H5Type::float32;
    else if constexpr (std::is_same_v<T, double>) return H5Type::float64;
    else if constexpr (std::is_same_v<T, std::int64_t>) return H5Type::int64;
    else if constexpr (std::is_same_v<T, std::uint64_t>) return H5Type::uint64;
}

/// Box of a dataset: its first corner and its size along each dimension. Ranks without a share have a zero in `count`.
struct H5Box {
    std::vector<std::uint64_t> start, count;
};

class H5File {
public:
    enum class Mode { create, modify, read };

    H5File(const Communicator& comm, std::string path, Mode mode);
    /// Empties a file that was written without close(): it is useless and takes space on a full disk.
    ~H5File();
    H5File(const H5File&) = delete;
    H5File& operator=(const H5File&) = delete;

    /// Closes the file; all its data is on the disk afterwards.
    void close();
    /// Reserves `bytes` more of disk space, and a little for HDF5 itself. HDF5 may hang on a full disk, because ranks
    /// wait for the one that fails. Unlike require_space() this respects quotas.
    void reserve(std::uint64_t bytes);

    void make_group(const std::string& path);
    void make_dataset(const std::string& path, H5Type type, const std::vector<std::uint64_t>& shape);
    /// Makes a dataset that grows along its first dimension, with no frames yet. It may take up to `frames_slack` bytes
    /// more than its frames.
    void make_frames(const std::string& path, H5Type type, const std::vector<std::uint64_t>& frame_shape);
    static constexpr std::uint64_t frames_slack = 8 << 10;
    /// Extends datasets of equally many frames to `frames`. Space is taken as if all grew frame by frame in turn. So
    /// the bytes of the file do not depend on the frames added at a time. Tables are flushed after every `flush_every`
    /// frames (0: never), so that a killed process leaves a readable file.
    void set_frames(const std::vector<std::string>& paths, std::uint64_t frames, std::uint64_t flush_every = 0);
    std::vector<std::uint64_t> shape(const std::string& path) const;
    H5Type type(const std::string& path) const; ///< type of a dataset's numbers
    /// True if the dataset or group and all groups above it exist.
    bool has(const std::string& path) const;
    bool has(const std::string& object, const std::string& attribute) const;

    /// Transfers every rank's box. `type` is also the type in the file, since conversion makes transfers independent.
    void write(const std::string& path, H5Type type, const H5Box& box, const void* data);
    void read(const std::string& path, H5Type type, const H5Box& box, void* data) const;

    /// Attributes of the group or dataset `object`.
    void set(const std::string& object, const std::string& name, const std::string& value);
    template <class T>
    requires std::is_arithmetic_v<T>
    void set(const std::string& object, const std::string& name, const T& value) {
        set_number(object, name, h5_type<T>(), &value);
    }
    template <class T> T get(const std::string& object, const std::string& name) const {
        T value{};
        if constexpr (std::is_same_v<T, std::string>) get_text(object, name, value);
        else get_number(object, name, h5_type<T>(), &value);
        return value;
    }
    /// Attribute, if the object has it.
    template <class T> std::optional<T> find(const std::string& object, const std::string& name) const {
        return has(object, name) ? std::optional(get<T>(object, name)) : std::nullopt;
    }

private:
    /// Starts to write data to the disk, `bytes` since the last call, so that close() waits less. It cannot fail.
    void start_flush(std::uint64_t bytes);
    void agree(bool well, const std::string& deed) const;
    void set_number(const std::string& object, const std::string& name, H5Type type, const void* value);
    void get_number(const std::string& object, const std::string& name, H5Type type, void* value) const;
    void get_text(const std::string& object, const std::string& name, std::string& value) const;
    /// read(attribute, its type) returns true on success.
    template <class Read> void read_attribute(const std::string& object, const std::string& name, Read&& read) const;
    /// call(dataset, memory space, file space) returns HDF5's status.
    template <class Call>
    void transfer(const std::string& path, const H5Box& box, const std::string& failure, Call&& call) const;

    Communicator comm_;
    std::string path_;
    Mode mode_;
    std::int64_t id_ = -1;
    std::uint64_t reserved_ = 0;
    int descriptor_ = -1;         ///< descriptor of the file for start_flush, -1 if there is none
    std::uint64_t unflushed_ = 0; ///< bytes since the last flush
};

/// Shows frames k < `frames` of datasets <group>/<name> as virtual datasets <group>/frames/<k>/<name>, without copies.
/// It is for one rank and a closed file, because in a file of all ranks HDF5 duplicates the communicator for each.
void make_frame_views(const std::string& file, const std::string& group, const std::vector<std::string>& names,
                      std::uint64_t frames);

/// Part of a dataset as a virtual dataset. It has one row of the first dimension, which is left out.
struct PartView {
    std::string name, dataset;
    H5Box part;
};
/// Shows parts as virtual datasets of a new group, under the conditions of make_frame_views.
void make_part_views(const std::string& file, const std::string& group, const std::vector<PartView>& views);

} // namespace skein
