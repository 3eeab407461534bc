#include "rod/places.hpp"

#include "core/error.hpp"
#include "rod/rods.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>

namespace skein {

namespace {

struct Bitmap {
    long width;
    std::vector<std::uint32_t> pixels;
};

/// The "1" pixels of a P1 bitmap, numbered row by row from the last row, which is y = 0.
Bitmap read_mask(const std::string& path, const std::string& source) {
    std::ifstream file(path);
    if (!file) throw InputError(source + ": mask file '" + path + "' cannot be opened");
    std::string magic;
    file >> magic;
    if (magic != "P1") throw InputError(path + ":1: expected a plain PBM bitmap (magic 'P1'), found '" + magic + "'");
    const auto number = [&] {
        while (file >> std::ws && file.peek() == '#') file.ignore(1 << 20, '\n');
        long value = 0;
        if (!(file >> value) || value < 1) throw InputError(path + ": expected width and height after 'P1'");
        return value;
    };
    const long width = number(), height = number();
    if (width > (1L << 32) / height) throw InputError(path + ": a bitmap has at most 2^32 pixels");
    Bitmap map{width, {}};
    for (long row = 0; row < height; ++row)
        for (long column = 0; column < width; ++column) {
            char pixel = 0;
            if (!(file >> pixel) || (pixel != '0' && pixel != '1'))
                throw InputError(path + ": row " + std::to_string(row + 1) + ", column " + std::to_string(column + 1) +
                                 ": expected 0 or 1 (the bitmap is " + std::to_string(width) + " x " + std::to_string(height) +
                                 ")");
            if (pixel == '1') map.pixels.push_back(static_cast<std::uint32_t>((height - 1 - row) * width + column));
        }
    if (map.pixels.empty()) throw InputError(path + ": the bitmap has no 1, so the group has no rod");
    return map;
}

template <class T> void keep_rows(std::vector<T>& all, std::span<const std::size_t> rows) {
    if (all.empty()) return;
    std::vector<T> kept;
    kept.reserve(rows.size());
    for (const std::size_t row : rows) kept.push_back(all[row]);
    all = std::move(kept);
}

/// The order that makes them rise.
std::vector<std::size_t> rising(std::span<const std::int64_t> indices) {
    std::vector<std::size_t> order(indices.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return indices[a] < indices[b]; });
    return order;
}

} // namespace

Quaterniond frame_of(const Vec3d& tangent, const std::optional<Vec3d>& normal) {
    const Vec3d d3 = (1 / norm(tangent)) * tangent;
    const bool along_x = std::abs(d3.x) > 0.99;
    const Vec3d given = normal.value_or(along_x ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0});
    const Vec3d across = given - dot(given, d3) * d3;
    const Vec3d d1 = (1 / norm(across)) * across;
    return quaternion({d1, cross(d3, d1), d3});
}

Places::Places(const RodSpec& spec, const std::string& directory) : first_(spec.placement.origin) {
    const Placement& p = spec.placement;
    for (std::size_t axis = 0; axis < std::min<std::size_t>(3, p.spacing.size()); ++axis) spacing_[axis] = p.spacing[axis];
    switch (p.kind) {
    case PlacementKind::line:
    case PlacementKind::lattice:
        for (std::size_t axis = 0; axis < p.counts.size(); ++axis) {
            if (axis < 2) counts_[axis] = p.counts[axis];
            count_ *= p.counts[axis];
        }
        break;
    case PlacementKind::mask: {
        Bitmap map = read_mask((std::filesystem::path(directory) / p.file).string(), spec.source);
        counts_[0] = map.width;
        pixels_ = std::move(map.pixels);
        count_ = static_cast<std::int64_t>(pixels_.size());
        break;
    }
    case PlacementKind::list: {
        std::vector<Quaterniond> turns;
        const auto normal = [&](std::size_t i) { return p.normals.empty() ? std::nullopt : std::optional(p.normals[i]); };
        for (std::size_t i = 0; i < p.tangents.size(); ++i) turns.push_back(frame_of(p.tangents[i], normal(i)));
        *this = Places(p.origins, std::move(turns));
        for (Vec3d& o : origins_) o += p.origin;
        break;
    }
    case PlacementKind::single:
    case PlacementKind::packing:
    case PlacementKind::file:
        break;
    }
}

Places::Places(std::vector<Vec3d> origins, std::vector<Quaterniond> turns)
    : count_(static_cast<std::int64_t>(origins.size())), listed_(true), turned_(!turns.empty()), origins_(std::move(origins)),
      turns_(std::move(turns)) {}

Places::Places(std::shared_ptr<const RodSource> source, const Vec3d& origin)
    : count_(source->count()), first_(origin), listed_(true), turned_(source->has_tangents()), source_(std::move(source)) {}

std::size_t Places::row(std::int64_t i) const {
    if (held_.empty()) return static_cast<std::size_t>(i - begin_);
    return static_cast<std::size_t>(std::lower_bound(held_.begin(), held_.end(), i) - held_.begin());
}

Vec3d Places::origin(std::int64_t i) const {
    if (listed_) return origins_[row(i)];
    const std::int64_t point = pixels_.empty() ? i : pixels_[static_cast<std::size_t>(i)];
    const std::int64_t x = point % counts_[0], rows = point / counts_[0];
    const std::int64_t y = pixels_.empty() ? rows % counts_[1] : rows, z = pixels_.empty() ? rows / counts_[1] : 0;
    return Vec3d{static_cast<double>(x) * spacing_[0], static_cast<double>(y) * spacing_[1], static_cast<double>(z) * spacing_[2]} +
           first_;
}

Vec3d Places::corner() const {
    if (!listed_ && pixels_.empty()) return origin(0);
    const std::int64_t held = listed_ ? static_cast<std::int64_t>(origins_.size()) : count_;
    Vec3d corner{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    for (std::int64_t i = 0; i < held; ++i) {
        const Vec3d o = listed_ ? origins_[static_cast<std::size_t>(i)] : origin(i);
        corner = {std::min(corner.x, o.x), std::min(corner.y, o.y), std::min(corner.z, o.z)};
    }
    return corner;
}

void Places::read(std::int64_t begin, std::int64_t end) {
    constexpr std::int64_t block = 1 << 16;
    origins_.clear(), turns_.clear(), held_.clear();
    origins_.reserve(static_cast<std::size_t>(end - begin));
    if (turned_) turns_.reserve(static_cast<std::size_t>(end - begin));
    begin_ = begin;
    read_ = true;
    for (std::int64_t at = begin; at < end; at += block) {
        const RodRows rows = source_->read(at, std::min(end, at + block));
        for (std::size_t i = 0; i < rows.origins.size(); ++i) {
            origins_.push_back(rows.origins[i] + first_);
            if (turned_)
                turns_.push_back(frame_of(rows.tangents[i], rows.normals.empty() ? std::nullopt : std::optional(rows.normals[i])));
        }
    }
}

std::uint64_t Places::digest() const {
    std::uint64_t sum = 0;
    for (std::size_t row = 0; row < origins_.size(); ++row) {
        const Quaterniond q = turned_ ? turns_[row] : no_turn;
        const double numbers[] = {origins_[row].x, origins_[row].y, origins_[row].z, q.w, q.v.x, q.v.y, q.v.z};
        sum += hash_numbers(held_.empty() ? begin_ + static_cast<std::int64_t>(row) : held_[row], numbers);
    }
    return sum;
}

void Places::keep(std::span<const std::int64_t> indices) {
    if (!listed_) return;
    const auto order = rising(indices);
    std::vector<std::size_t> rows;
    std::vector<std::int64_t> held;
    for (const std::size_t i : order) rows.push_back(row(indices[i])), held.push_back(indices[i]);
    keep_rows(origins_, rows);
    keep_rows(turns_, rows);
    held_ = std::move(held);
}

std::vector<std::byte> Places::records() const {
    std::vector<std::byte> bytes(origins_.size() * record_bytes);
    for (std::size_t row = 0; row < origins_.size(); ++row) {
        std::memcpy(&bytes[row * record_bytes], &origins_[row], sizeof(Vec3d));
        if (turned_) std::memcpy(&bytes[row * record_bytes + sizeof(Vec3d)], &turns_[row], sizeof(Quaterniond));
    }
    return bytes;
}

void Places::keep(std::span<const std::int64_t> indices, std::span<const std::byte> records) {
    const auto order = rising(indices);
    origins_.resize(order.size());
    turns_.resize(turned_ ? order.size() : 0);
    held_.resize(order.size());
    for (std::size_t row = 0; row < order.size(); ++row) {
        const std::byte* record = &records[order[row] * record_bytes];
        std::memcpy(&origins_[row], record, sizeof(Vec3d));
        if (turned_) std::memcpy(&turns_[row], record + sizeof(Vec3d), sizeof(Quaterniond));
        held_[row] = indices[order[row]];
    }
    origins_.shrink_to_fit(), turns_.shrink_to_fit();
}

std::size_t Places::bytes() const {
    return pixels_.size() * sizeof(std::uint32_t) + origins_.size() * sizeof(Vec3d) + turns_.size() * sizeof(Quaterniond) +
           held_.size() * sizeof(std::int64_t);
}

} // namespace skein
