// Arrays of HDF5 files. Links out of the file are refused.
#include "io/array_file.hpp"
#include "io/h5_links.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

/// True for numbers of a common layout. HDF5 may convert others forever, above all those of a damaged type.
bool is_common(hid_t type) {
    const hid_t known[] = {H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE, H5T_IEEE_F64BE, H5T_STD_I8LE,
                           H5T_STD_I8BE,   H5T_STD_I16LE,  H5T_STD_I16BE,  H5T_STD_I32LE,  H5T_STD_I32BE,
                           H5T_STD_I64LE,  H5T_STD_I64BE,  H5T_STD_U8LE,   H5T_STD_U8BE,   H5T_STD_U16LE,
                           H5T_STD_U16BE,  H5T_STD_U32LE,  H5T_STD_U32BE,  H5T_STD_U64LE,  H5T_STD_U64BE};
    return std::any_of(std::begin(known), std::end(known), [&](hid_t one) { return H5Tequal(type, one) > 0; });
}

/// Runs a call without HDF5's own error messages; the caller reports errors.
template <class F> auto quietly(F&& call) {
    H5E_auto2_t print = nullptr;
    void* data = nullptr;
    H5Eget_auto2(H5E_DEFAULT, &print, &data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const struct Again {
        H5E_auto2_t print;
        void* data;
        ~Again() { H5Eset_auto2(H5E_DEFAULT, print, data); }
    } again{print, data};
    return call();
}

class Hdf5Arrays final : public ArrayFile {
public:
    explicit Hdf5Arrays(const std::string& path)
        : ArrayFile(path),
          file_(quietly([&] { return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT); }), H5Fclose) {
        if (!file_.valid()) refuse("cannot be read as HDF5");
    }

    std::string_view word() const override { return "dataset"; }

    std::vector<std::string> names() const override {
        std::vector<std::string> found;
        const auto add = [](hid_t, const char* name, const H5L_info_t*, void* into) -> herr_t {
            static_cast<std::vector<std::string>*>(into)->emplace_back(name);
            return 0;
        };
        const herr_t status =
            quietly([&] { return H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &found); });
        if (status < 0) refuse("is damaged: its list of datasets cannot be read");
        return found;
    }

    Shape shape(const std::string& name) const override {
        return quietly([&] { return checked_shape(name); });
    }

    void read(const std::string& name, std::int64_t begin, std::int64_t rows, double* into) const override {
        const H5Handle data = dataset(name), space(H5Dget_space(data), H5Sclose);
        std::vector<hsize_t> count(to_index(H5Sget_simple_extent_ndims(space)));
        H5Sget_simple_extent_dims(space, count.data(), nullptr);
        count[0] = static_cast<hsize_t>(rows);
        std::vector<hsize_t> start(count.size(), 0);
        start[0] = static_cast<hsize_t>(begin);
        const H5Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
        H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
        const herr_t status =
            quietly([&] { return H5Dread(data, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, into); });
        if (status < 0)
            refuse(fmt::format("dataset '{}', rows {} to {}: cannot be read", name, begin, begin + rows - 1));
    }

private:
    /// Opens a dataset, and refuses links to other files.
    H5Handle dataset(const std::string& name) const {
        std::string outside;
        H5Handle found = quietly([&] { return open_own_dataset(file_, name, outside); });
        if (!outside.empty()) refuse(fmt::format("dataset '{}': {}", name, outside));
        return found;
    }

    Shape checked_shape(const std::string& name) const {
        const htri_t there = H5Lexists(file_, name.c_str(), H5P_DEFAULT);
        if (there <= 0) refuse(fmt::format("is damaged: dataset '{}' cannot be found", name));
        const H5Handle data = dataset(name);
        if (!data.valid()) refuse(fmt::format("'{}' is not a dataset", name));
        const H5Handle type(H5Dget_type(data), H5Tclose), space(H5Dget_space(data), H5Sclose);
        const auto kind = H5Tget_class(type);
        if (kind != H5T_FLOAT && kind != H5T_INTEGER) refuse(fmt::format("dataset '{}' does not hold numbers", name));
        if (!is_common(type))
            refuse(fmt::format(
                "dataset '{}' has numbers of a type that is neither a float of 32 or 64 bits nor an integer", name));
        std::vector<hsize_t> shape(to_index(std::max(0, H5Sget_simple_extent_ndims(space))));
        if (!shape.empty()) H5Sget_simple_extent_dims(space, shape.data(), nullptr);
        return {shape.begin(), shape.end()};
    }

    H5Handle file_;
};

} // namespace

std::unique_ptr<ArrayFile> open_hdf5_arrays(const std::string& path) { return std::make_unique<Hdf5Arrays>(path); }

} // namespace skein
