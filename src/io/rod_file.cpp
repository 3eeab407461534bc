#include "io/rod_file.hpp"

#include "io/rod_file_kind.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

namespace skein {

namespace {

Vec3d vector_at(const std::vector<double>& numbers, std::size_t i) {
    return {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
}

bool along(const Vec3d& a, const Vec3d& b) { return norm(cross(a, b)) < 1e-6 * norm(a) * norm(b); }

} // namespace

RodColumns RodFile::columns() const {
    return {has_[tangent], has_[normal], has_[length], has_[radius], has_[nodes], has_[directors], has_[radii]};
}

std::size_t RodFile::width(std::size_t q) const {
    const Per per = quantities[q].per;
    return quantities[q].components * (per == Per::rod ? 1 : per == Per::node ? elements_ + 1 : elements_);
}

void RodFile::refuse(std::size_t quantity, std::int64_t rod, const std::string& what) const {
    throw InputError(fmt::format("{}: {}", place(quantity, rod), what));
}
void RodFile::refuse(const std::string& what) const { throw InputError(fmt::format("{}: {}", path_, what)); }

void RodFile::check_quantities() const {
    if (count_ == 0) refuse("it contains no rods");
    const auto beside = [&](Which q, Which other, const char* why) {
        if (has_[q] && has_[other])
            refuse(fmt::format("'{}' conflicts with '{}': {}", quantities[q].name, quantities[other].name, why));
    };
    const auto without = [&](Which q, Which other, const char* why) {
        if (has_[q] && !has_[other])
            refuse(fmt::format("'{}' without '{}': {}", quantities[q].name, quantities[other].name, why));
    };
    for (const Which q : {origin, tangent, length}) beside(q, nodes, "the nodes define it already");
    beside(normal, directors, "the first director defines it already");
    beside(radius, radii, "one of the two is enough");
    without(directors, nodes, "directors belong to the elements between nodes");
    if (has_[nodes]) return;
    if (!has_[origin]) refuse("'origin' is missing: the start of every rod [m]");
    without(normal, tangent, "a direction across the rod needs the direction of the rod");
}

RodRows RodFile::read(std::int64_t begin, std::int64_t end, const Threads*) const {
    Numbers numbers;
    const std::size_t rods = to_index(end - begin);
    for (std::size_t q = 0; q < all; ++q)
        if (has_[q]) numbers[q].resize(rods * width(q));
    read_numbers(begin, end, numbers);
    for (std::size_t q = 0; q < all; ++q)
        for (std::size_t i = 0; i < numbers[q].size(); ++i) {
            const std::int64_t rod = begin + static_cast<std::int64_t>(i / width(q));
            if (!std::isfinite(numbers[q][i])) refuse(q, rod, "not a finite number");
            if (quantities[q].components == 1 && !(numbers[q][i] > 0)) refuse(q, rod, "must be above 0 [m]");
            if (q != tangent && q != normal && q != directors) numbers[q][i] *= unit_;
        }
    RodRows rows;
    const auto vectors = [&](std::size_t q, std::vector<Vec3d>& into) {
        into.reserve(numbers[q].size() / 3);
        for (std::size_t i = 0; 3 * i < numbers[q].size(); ++i) into.push_back(vector_at(numbers[q], i));
    };
    vectors(origin, rows.origins);
    vectors(tangent, rows.tangents);
    vectors(normal, rows.normals);
    vectors(nodes, rows.nodes);
    rows.lengths = std::move(numbers[length]);
    rows.radii = std::move(numbers[radius]);
    for (std::size_t i = 0; i < rods; ++i) {
        const std::int64_t rod = begin + static_cast<std::int64_t>(i);
        if (has_[nodes]) trace(rod, i, numbers, rows);
        else if (has_[tangent]) check_frame(rod, i, rows);
        for (std::size_t k = 0; has_[radii] && k < elements_; ++k) {
            const double* r = &numbers[radii][i * (elements_ + 1) + k];
            rows.element_radii.push_back(0.5 * (r[0] + r[1]));
        }
    }
    return rows;
}

void RodFile::check_frame(std::int64_t rod, std::size_t i, const RodRows& rows) const {
    if (norm(rows.tangents[i]) == 0) refuse(tangent, rod, "has no direction");
    if (rows.normals.empty()) return;
    if (norm(rows.normals[i]) == 0) refuse(normal, rod, "has no direction");
    if (along(rows.tangents[i], rows.normals[i])) refuse(normal, rod, "is parallel to the tangent");
}

/// Takes the nodes of a rod, whose edges must have lengths and not turn back, and the normals of its elements.
void RodFile::trace(std::int64_t rod, std::size_t i, const Numbers& numbers, RodRows& rows) const {
    const std::size_t first = i * (elements_ + 1);
    rows.origins.push_back(rows.nodes[first]);
    Vec3d before{0, 0, 0};
    for (std::size_t k = 0; k < elements_; ++k) {
        const Vec3d edge = rows.nodes[first + k + 1] - rows.nodes[first + k];
        if (norm(edge) == 0) refuse(nodes, rod, fmt::format("nodes {} and {} are one point", k, k + 1));
        if (k > 0 && dot(before, edge) < -0.99 * norm(before) * norm(edge))
            refuse(nodes, rod, fmt::format("turns back at node {}", k));
        before = edge;
        if (has_[directors]) {
            const Vec3d d1 = vector_at(numbers[directors], 3 * (i * elements_ + k));
            if (norm(d1) == 0 || along(edge, d1))
                refuse(directors, rod, fmt::format("d1 of element {} is not across the rod", k));
            rows.element_normals.push_back(d1);
        } else if (k == 0 && has_[normal] && (norm(rows.normals[i]) == 0 || along(edge, rows.normals[i]))) {
            refuse(normal, rod, "is not across the first element");
        }
    }
}

std::shared_ptr<const RodSource> open_rod_file(const std::string& directory, const RodSpec& rods) {
    const std::string path = (std::filesystem::path(directory) / rods.placement.file).string();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        throw InputError(fmt::format("{}: there is no rod file '{}'", rods.source, path));
    const RodFileOptions options{rods.placement, rods.shape.elements, rods.shape.closed};
    const auto ends = [&](auto... endings) { return (path.ends_with(endings) || ...); };
    if (ends(".h5", ".hdf5")) return open_array_rods(open_hdf5_arrays(path), options);
    if (ends(".npz", ".npy")) return open_array_rods(open_numpy_arrays(path), options);
    if (ends(".swc")) return open_swc_rods(path, options);
    if (ends(".bcc")) return open_bcc_rods(path, options);
    if (ends(".csv", ".tsv", ".txt")) return open_text_rods(path, options);
    throw InputError(fmt::format("{}: '{}' is not a rod file: its name must end in .h5, .hdf5, .npz, .npy, .csv, .tsv, "
                                 ".txt, .swc or .bcc",
                                 rods.source, path));
}

} // namespace skein
