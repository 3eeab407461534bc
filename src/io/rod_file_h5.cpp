// Files of rods in HDF5. Each rank reads its own part without MPI.
#include "io/h5_links.hpp"
#include "io/rod_file_kind.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace skein {

namespace {

std::string quantity_names() {
    std::vector<std::string_view> names;
    for (const RodQuantity& q : RodFile::quantities) names.push_back(q.name);
    return fmt::format("{}", fmt::join(names, ", "));
}

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

class Hdf5RodFile final : public RodFile {
public:
    explicit Hdf5RodFile(const std::string& path)
        : RodFile(path), file_(quietly([&] { return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT); }), H5Fclose) {
        if (!file_.valid()) refuse("cannot be read as HDF5");
        quietly([&] {
            check_file();
            return 0;
        });
    }

private:
    void check_file() {
        for (std::size_t q = 0; q < std::size(quantities); ++q) check_dataset(q);
        const auto other = [](hid_t, const char* name, const H5L_info_t*, void* found) -> herr_t {
            const bool known = std::any_of(std::begin(quantities), std::end(quantities),
                                           [&](const RodQuantity& q) { return q.name == name; });
            if (!known) *static_cast<std::string*>(found) = name;
            return known ? 0 : 1;
        };
        std::string unknown;
        if (H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, other, &unknown) < 0)
            refuse("is damaged: its list of datasets cannot be read");
        if (!unknown.empty()) refuse(fmt::format("unknown dataset '{}'; a rod file has {}", unknown, quantity_names()));
        check_quantities();
    }

    /// Opens a dataset, and refuses links to other files.
    H5Handle dataset(std::size_t q) const {
        std::string outside;
        const std::string name(quantities[q].name);
        H5Handle found = quietly([&] { return open_own_dataset(file_, name, outside); });
        if (!outside.empty()) refuse(fmt::format("dataset '{}': {}", name, outside));
        return found;
    }

    void check_dataset(std::size_t q) {
        const std::string name(quantities[q].name);
        const htri_t there = H5Lexists(file_, name.c_str(), H5P_DEFAULT);
        if (there < 0) refuse(fmt::format("is damaged: dataset '{}' cannot be found", name));
        if (there == 0) return;
        const H5Handle data = dataset(q);
        if (!data.valid()) refuse(fmt::format("'{}' is not a dataset", name));
        const H5Handle type(H5Dget_type(data), H5Tclose), space(H5Dget_space(data), H5Sclose);
        const auto kind = H5Tget_class(type);
        if (kind != H5T_FLOAT && kind != H5T_INTEGER) refuse(fmt::format("dataset '{}' does not hold numbers", name));
        if (!is_common(type))
            refuse(fmt::format(
                "dataset '{}' has numbers of a type that is neither a float of 32 or 64 bits nor an integer", name));
        std::vector<hsize_t> shape(to_index(std::max(0, H5Sget_simple_extent_ndims(space))));
        if (!shape.empty()) H5Sget_simple_extent_dims(space, shape.data(), nullptr);
        const RodQuantity& quantity = quantities[q];
        std::vector<std::string_view> wanted = {"rods"};
        if (quantity.per != Per::rod) wanted.push_back(quantity.per == Per::node ? "elements + 1" : "elements");
        if (quantity.components > 1) wanted.insert(wanted.end(), quantity.components == 9 ? 2 : 1, "3");
        bool fits = shape.size() == wanted.size();
        for (std::size_t d = 1; fits && d < shape.size(); ++d) fits = wanted[d] == "3" ? shape[d] == 3 : shape[d] > 1;
        if (!fits)
            refuse(fmt::format("dataset '{}' has the shape [{}]; it must be [{}]", name, fmt::join(shape, ", "),
                               fmt::join(wanted, ", ")));
        constexpr hsize_t most = hsize_t{1} << 40; // sums of numbers of rods, by which ranks share them, need 64 bits
        if (shape[0] > most) refuse(fmt::format("dataset '{}' has {} rows: more than 2^40 rods", name, shape[0]));
        const auto rods = static_cast<std::int64_t>(shape[0]);
        if (!first_.empty() && rods != count_)
            refuse(fmt::format("dataset '{}' has {} rows, but '{}' has {}: a row per rod", name, rods, first_, count_));
        if (quantity.per != Per::rod) {
            const std::size_t elements = shape[1] - (quantity.per == Per::node);
            if (elements_ > 0 && elements != elements_)
                refuse(
                    fmt::format("dataset '{}' has rods of {} elements, but others have {}", name, elements, elements_));
            elements_ = elements;
        }
        if (first_.empty()) first_ = name;
        count_ = rods;
        has_[q] = true;
    }

    void read_numbers(std::int64_t begin, std::int64_t end, Numbers& numbers) const override {
        for (std::size_t q = 0; q < all; ++q) {
            if (!has_[q]) continue;
            const H5Handle data = dataset(q), space(H5Dget_space(data), H5Sclose);
            std::vector<hsize_t> count(to_index(H5Sget_simple_extent_ndims(space)));
            H5Sget_simple_extent_dims(space, count.data(), nullptr);
            count[0] = static_cast<hsize_t>(end - begin);
            std::vector<hsize_t> start(count.size(), 0);
            start[0] = static_cast<hsize_t>(begin);
            const H5Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
            H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
            const herr_t status = quietly(
                [&] { return H5Dread(data, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, numbers[q].data()); });
            if (status < 0)
                refuse(fmt::format("dataset '{}', rows {} to {}: cannot be read", quantities[q].name, begin, end - 1));
        }
    }
    std::string place(std::size_t quantity, std::int64_t rod) const override {
        return fmt::format("{}: dataset '{}', row {}", path_, quantities[quantity].name, rod);
    }

    H5Handle file_;
    std::string first_; ///< first quantity in the file, which defines the number of rods
};

} // namespace

std::shared_ptr<const RodSource> open_hdf5_rods(const std::string& path) { return std::make_shared<Hdf5RodFile>(path); }

} // namespace skein
