// Files of rods in HDF5. Read by each rank for itself, without MPI: what it reads is its own part.
#include "io/h5_handle.hpp"
#include "io/rod_file_kind.hpp"
#include "skein/core/error.hpp"

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

/// HDF5 prints what fails unless it is told not to; here the caller says it.
template <class F> auto quietly(F&& call) {
    H5E_auto2_t print = nullptr;
    void* data = nullptr;
    H5Eget_auto2(H5E_DEFAULT, &print, &data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    auto result = call();
    H5Eset_auto2(H5E_DEFAULT, print, data);
    return result;
}

class Hdf5RodFile final : public RodFile {
public:
    explicit Hdf5RodFile(const std::string& path)
        : RodFile(path), file_(quietly([&] { return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT); }), H5Fclose) {
        if (!file_.valid()) refuse("cannot be read as HDF5");
        for (std::size_t q = 0; q < std::size(quantities); ++q) look_at(q);
        const auto other = [](hid_t, const char* name, const H5L_info_t*, void* found) -> herr_t {
            const bool known =
                std::any_of(std::begin(quantities), std::end(quantities), [&](const RodQuantity& q) { return q.name == name; });
            if (!known) *static_cast<std::string*>(found) = name;
            return known ? 0 : 1;
        };
        std::string unknown;
        H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, other, &unknown);
        if (!unknown.empty()) refuse(fmt::format("unknown dataset '{}'; a file of rods takes {}", unknown, quantity_names()));
        check_quantities();
    }

private:
    H5Handle dataset(std::size_t q) const {
        return {quietly([&] { return H5Dopen2(file_, std::string(quantities[q].name).c_str(), H5P_DEFAULT); }), H5Dclose};
    }

    void look_at(std::size_t q) {
        const std::string name(quantities[q].name);
        if (H5Lexists(file_, name.c_str(), H5P_DEFAULT) <= 0) return;
        const H5Handle data = dataset(q);
        if (!data.valid()) refuse(fmt::format("'{}' is not a dataset", name));
        const H5Handle type(H5Dget_type(data), H5Tclose), space(H5Dget_space(data), H5Sclose);
        const auto kind = H5Tget_class(type);
        if (kind != H5T_FLOAT && kind != H5T_INTEGER) refuse(fmt::format("dataset '{}' does not hold numbers", name));
        std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
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
        const auto rods = static_cast<std::int64_t>(shape[0]);
        if (!first_.empty() && rods != count_)
            refuse(fmt::format("dataset '{}' has {} rows, but '{}' has {}: a row per rod", name, rods, first_, count_));
        if (quantity.per != Per::rod) {
            const std::size_t elements = shape[1] - (quantity.per == Per::node);
            if (elements_ > 0 && elements != elements_)
                refuse(fmt::format("dataset '{}' is of rods of {} elements, others of {}", name, elements, elements_));
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
            std::vector<hsize_t> count(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
            H5Sget_simple_extent_dims(space, count.data(), nullptr);
            count[0] = static_cast<hsize_t>(end - begin);
            std::vector<hsize_t> start(count.size(), 0);
            start[0] = static_cast<hsize_t>(begin);
            const H5Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
            H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
            const herr_t status =
                quietly([&] { return H5Dread(data, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, numbers[q].data()); });
            if (status < 0) refuse(fmt::format("dataset '{}', rows {} to {}: cannot be read", quantities[q].name, begin, end - 1));
        }
    }
    std::string place(std::size_t quantity, std::int64_t rod) const override {
        return fmt::format("{}: dataset '{}', row {}", path_, quantities[quantity].name, rod);
    }

    H5Handle file_;
    std::string first_; ///< the first quantity found, which says how many rods there are
};

} // namespace

std::shared_ptr<const RodSource> open_hdf5_rods(const std::string& path) { return std::make_shared<Hdf5RodFile>(path); }

} // namespace skein
