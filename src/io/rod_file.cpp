#include "io/rod_file.hpp"

#include "core/error.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

namespace skein {

namespace {

/// What a file may say of a rod.
struct Quantity {
    std::string_view name;
    std::array<std::string_view, 3> columns; ///< of comma-separated values
};
constexpr Quantity quantities[] = {{"origin", {"x", "y", "z"}}, {"tangent", {"tx", "ty", "tz"}}, {"normal", {"nx", "ny", "nz"}}};
enum Which { origin, tangent, normal };

std::string quantity_names() {
    std::vector<std::string_view> names;
    for (const Quantity& q : quantities) names.push_back(q.name);
    return fmt::format("{}", fmt::join(names, ", "));
}

bool finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// What is common to both kinds of file: which quantities there are, and what their numbers must be.
class RodFile : public RodSource {
public:
    explicit RodFile(std::string path) : path_(std::move(path)) {}
    std::int64_t count() const override { return count_; }
    bool has_tangents() const override { return has_[tangent]; }

    RodRows read(std::int64_t begin, std::int64_t end) const override {
        RodRows rows;
        std::vector<Vec3d>* const into[] = {&rows.origins, &rows.tangents, &rows.normals};
        for (std::size_t q = 0; q < std::size(quantities); ++q)
            if (has_[q]) into[q]->resize(static_cast<std::size_t>(end - begin));
        read_vectors(begin, end, rows);
        for (std::size_t q = 0; q < std::size(quantities); ++q)
            for (std::size_t i = 0; i < into[q]->size(); ++i)
                if (!finite((*into[q])[i])) complain(q, begin + static_cast<std::int64_t>(i), "not a finite number");
        for (std::size_t i = 0; i < rows.tangents.size(); ++i) {
            const std::int64_t rod = begin + static_cast<std::int64_t>(i);
            if (norm(rows.tangents[i]) == 0) complain(tangent, rod, "has no direction");
            if (rows.normals.empty()) continue;
            const double lengths = norm(rows.tangents[i]) * norm(rows.normals[i]);
            if (norm(rows.normals[i]) == 0) complain(normal, rod, "has no direction");
            if (norm(cross(rows.tangents[i], rows.normals[i])) < 1e-6 * lengths)
                complain(normal, rod, "is parallel to the tangent");
        }
        return rows;
    }

protected:
    virtual void read_vectors(std::int64_t begin, std::int64_t end, RodRows& rows) const = 0;
    virtual std::string place(std::size_t quantity, std::int64_t rod) const = 0;
    [[noreturn]] void complain(std::size_t quantity, std::int64_t rod, const std::string& what) const {
        throw InputError(fmt::format("{}: {}", place(quantity, rod), what));
    }
    [[noreturn]] void complain(const std::string& what) const { throw InputError(fmt::format("{}: {}", path_, what)); }
    /// When it is known what the file holds.
    void check_quantities() const {
        if (count_ == 0) complain("there is no rod in it");
        if (!has_[origin]) complain("'origin' is missing: the start of every rod [m]");
        if (has_[normal] && !has_[tangent])
            complain("'normal' without 'tangent': a direction across the rod needs that of the rod");
    }

    std::string path_;
    std::int64_t count_ = 0;
    std::array<bool, std::size(quantities)> has_{};
};

/// An HDF5 object, closed with the function of its kind.
class Handle {
public:
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Handle() {
        if (id_ >= 0) close_(id_);
    }
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Handle& operator=(Handle&&) = delete;
    operator hid_t() const { return id_; }
    bool valid() const { return id_ >= 0; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

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
        if (!file_.valid()) complain("cannot be read as HDF5");
        for (std::size_t q = 0; q < std::size(quantities); ++q) look_at(q);
        const auto other = [](hid_t, const char* name, const H5L_info_t*, void* found) -> herr_t {
            const bool known =
                std::any_of(std::begin(quantities), std::end(quantities), [&](const Quantity& q) { return q.name == name; });
            if (!known) *static_cast<std::string*>(found) = name;
            return known ? 0 : 1;
        };
        std::string unknown;
        H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, other, &unknown);
        if (!unknown.empty()) complain(fmt::format("unknown dataset '{}'; a file of rods takes {}", unknown, quantity_names()));
        check_quantities();
    }

private:
    Handle dataset(std::size_t q) const {
        return {quietly([&] { return H5Dopen2(file_, std::string(quantities[q].name).c_str(), H5P_DEFAULT); }), H5Dclose};
    }

    void look_at(std::size_t q) {
        const std::string name(quantities[q].name);
        if (H5Lexists(file_, name.c_str(), H5P_DEFAULT) <= 0) return;
        const Handle data = dataset(q);
        if (!data.valid()) complain(fmt::format("'{}' is not a dataset", name));
        const Handle type(H5Dget_type(data), H5Tclose), space(H5Dget_space(data), H5Sclose);
        const auto kind = H5Tget_class(type);
        if (kind != H5T_FLOAT && kind != H5T_INTEGER) complain(fmt::format("dataset '{}' does not hold numbers", name));
        std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
        if (!shape.empty()) H5Sget_simple_extent_dims(space, shape.data(), nullptr);
        const auto rods = shape.empty() ? 0 : static_cast<std::int64_t>(shape[0]);
        if (shape.size() != 2 || shape[1] != 3)
            complain(fmt::format("dataset '{}' has the shape [{}]; it must be [rods, 3]", name, fmt::join(shape, ", ")));
        if (has_[origin] && rods != count_)
            complain(fmt::format("dataset '{}' has {} rows, but 'origin' has {}: a row per rod", name, rods, count_));
        count_ = rods;
        has_[q] = true;
    }

    void read_vectors(std::int64_t begin, std::int64_t end, RodRows& rows) const override {
        std::vector<Vec3d>* const into[] = {&rows.origins, &rows.tangents, &rows.normals};
        static_assert(sizeof(Vec3d) == 3 * sizeof(double));
        for (std::size_t q = 0; q < std::size(quantities); ++q) {
            if (!has_[q]) continue;
            const Handle data = dataset(q), space(H5Dget_space(data), H5Sclose);
            const hsize_t start[] = {static_cast<hsize_t>(begin), 0}, count[] = {static_cast<hsize_t>(end - begin), 3};
            const Handle memory(H5Screate_simple(2, count, nullptr), H5Sclose);
            H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
            const herr_t status =
                quietly([&] { return H5Dread(data, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, into[q]->data()); });
            if (status < 0)
                complain(fmt::format("dataset '{}', rows {} to {}: cannot be read", quantities[q].name, begin, end - 1));
        }
    }
    std::string place(std::size_t quantity, std::int64_t rod) const override {
        return fmt::format("{}: dataset '{}', row {}", path_, quantities[quantity].name, rod);
    }

    Handle file_;
};

class CsvRodFile final : public RodFile {
public:
    explicit CsvRodFile(const std::string& path) : RodFile(path) {
        std::ifstream file(path_, std::ios::binary);
        if (!file) complain("cannot be opened for reading");
        std::string line;
        std::getline(file, line);
        read_header(line);
        std::int64_t at = static_cast<std::int64_t>(line.size()) + 1;
        // Where each block of lines begins; empty lines count for nothing.
        std::vector<char> buffer(1 << 20);
        bool begins = true;
        while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), file.gcount() > 0) {
            for (std::int64_t i = 0; i < file.gcount(); ++i) {
                if (begins && buffer[static_cast<std::size_t>(i)] != '\n' && buffer[static_cast<std::size_t>(i)] != '\r') {
                    if (count_ % block == 0) block_begin_.push_back(at + i);
                    ++count_;
                }
                begins = buffer[static_cast<std::size_t>(i)] == '\n';
            }
            at += file.gcount();
        }
        check_quantities();
    }

private:
    static constexpr std::int64_t block = 1 << 12;

    void read_header(std::string line) {
        std::erase_if(line, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; });
        std::size_t from = 0;
        do {
            const std::size_t comma = std::min(line.find(',', from), line.size());
            const std::string name = line.substr(from, comma - from);
            from = comma + 1;
            bool known = false;
            for (std::size_t q = 0; q < std::size(quantities); ++q)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (quantities[q].columns[axis] == name) {
                        if (std::find(columns_.begin(), columns_.end(), std::pair(q, axis)) != columns_.end())
                            throw InputError(fmt::format("{}:1: two columns '{}'", path_, name));
                        columns_.emplace_back(q, axis);
                        known = true;
                    }
            if (!known)
                throw InputError(
                    fmt::format("{}:1: unknown column '{}'; the first line names x, y, z and, where rods differ in direction, "
                                "tx, ty, tz, nx, ny, nz",
                                path_, name));
        } while (from <= line.size());
        for (std::size_t q = 0; q < std::size(quantities); ++q) {
            const auto axes = std::count_if(columns_.begin(), columns_.end(), [q](const auto& c) { return c.first == q; });
            if (axes != 0 && axes != 3)
                throw InputError(fmt::format("{}:1: of {} only {} of three columns: {}", path_, quantities[q].name, axes,
                                             fmt::join(quantities[q].columns, ", ")));
            has_[q] = axes == 3;
        }
    }

    void read_vectors(std::int64_t begin, std::int64_t end, RodRows& rows) const override {
        std::vector<Vec3d>* const into[] = {&rows.origins, &rows.tangents, &rows.normals};
        std::ifstream file(path_, std::ios::binary);
        file.seekg(block_begin_[static_cast<std::size_t>(begin / block)]);
        std::string line;
        for (std::int64_t rod = begin / block * block; rod < end; ++rod) {
            do {
                if (!std::getline(file, line)) complain(fmt::format("row {}: the file has been cut short", rod));
                if (line.ends_with('\r')) line.pop_back();
            } while (line.empty());
            if (rod < begin) continue;
            const char *at = line.data(), *const last = line.data() + line.size();
            for (std::size_t c = 0; c < columns_.size(); ++c) {
                const auto [q, axis] = columns_[c];
                while (at < last && (*at == ' ' || *at == '\t')) ++at;
                if (at < last && *at == '+') ++at;
                double value = 0;
                const auto [behind, error] = std::from_chars(at, last, value);
                at = behind;
                while (at < last && (*at == ' ' || *at == '\t')) ++at;
                const bool more = c + 1 < columns_.size();
                if (error != std::errc{}) complain(q, rod, fmt::format("'{}' is not a number", quantities[q].columns[axis]));
                if (more ? at == last || *at != ',' : at != last)
                    complain(q, rod, fmt::format("expected {} values, as the first line names them", columns_.size()));
                at += more;
                Vec3d& v = (*into[q])[static_cast<std::size_t>(rod - begin)];
                (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
            }
        }
    }
    std::string place(std::size_t quantity, std::int64_t rod) const override {
        return fmt::format("{}: row {} below the names: {}", path_, rod + 1, quantities[quantity].name);
    }

    std::vector<std::pair<std::size_t, std::size_t>> columns_; ///< quantity and axis
    std::vector<std::int64_t> block_begin_;                    ///< bytes before each block of lines
};

} // namespace

std::shared_ptr<const RodSource> open_rod_file(const std::string& path, const std::string& source) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        throw InputError(fmt::format("{}: there is no file of rods '{}'", source, path));
    if (path.ends_with(".h5") || path.ends_with(".hdf5")) return std::make_shared<Hdf5RodFile>(path);
    if (path.ends_with(".csv")) return std::make_shared<CsvRodFile>(path);
    throw InputError(fmt::format("{}: '{}' is no file of rods: its name must end in .h5, .hdf5 or .csv", source, path));
}

} // namespace skein
