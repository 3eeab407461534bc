// Files of named arrays of numbers: HDF5 and NumPy. Ranks read rows without MPI.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

class ArrayFile {
public:
    using Shape = std::vector<std::uint64_t>;

    explicit ArrayFile(std::string path) : path_(std::move(path)) {}
    virtual ~ArrayFile() = default;
    const std::string& path() const { return path_; }
    /// Name of an array in the format's words.
    virtual std::string_view word() const = 0;
    /// Names of all that is in the file.
    virtual std::vector<std::string> names() const = 0;
    /// Shape of an array that the file has. Throws InputError where it does not hold numbers.
    virtual Shape shape(const std::string& name) const = 0;
    /// Reads rows [begin, begin + count) of the first dimension.
    virtual void read(const std::string& name, std::int64_t begin, std::int64_t count, double* into) const = 0;

    bool has(const std::string& name) const;
    [[noreturn]] void refuse(const std::string& what) const;

private:
    std::string path_;
};

std::unique_ptr<ArrayFile> open_hdf5_arrays(const std::string& path);
/// A `.npz` of stored arrays, or one `.npy`, whose array is named `points`.
std::unique_ptr<ArrayFile> open_numpy_arrays(const std::string& path);

} // namespace skein
