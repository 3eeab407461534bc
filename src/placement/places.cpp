#include "skein/placement/places.hpp"

#include "core/fused.hpp"
#include "core/hash.hpp"
#include "core/rotation.hpp"
#include "parallel/pieces.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>

#include <fmt/format.h>

namespace skein {

namespace {

struct Bitmap {
    long width;
    std::vector<std::uint32_t> pixels;
};

/// Pixels "1" of a P1 bitmap, numbered row by row from the last row, which is y = 0.
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
                                 ": expected 0 or 1 (the bitmap is " + std::to_string(width) + " x " +
                                 std::to_string(height) + ")");
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

/// First director of a frame, carried to another tangent with least twist.
Vec3d carried(const Quaterniond& frame, const Vec3d& d3) {
    const Vec3d before = third_director(frame), d1 = transpose_times(frame, Vec3d{1, 0, 0}), axis = cross(before, d3);
    return d1 + cross(axis, d1) + (1 / (1 + dot(before, d3))) * cross(axis, cross(axis, d1));
}

/// Turns the frames of a ring about its tangents, in proportion to the way along it, so that the last one carries over
/// to the first.
void spread_twist(std::vector<Quaterniond>& frames, std::span<const double> lengths) {
    const Vec3d d3 = third_director(frames.front()), d1 = transpose_times(frames.front(), Vec3d{1, 0, 0}),
                after = carried(frames.back(), d3);
    const double missing = std::atan2(dot(cross(after, d1), d3), dot(after, d1)),
                 length = std::accumulate(lengths.begin(), lengths.end(), 0.0);
    double way = 0;
    for (std::size_t k = 1; k < frames.size(); ++k) {
        way += 0.5 * (lengths[k - 1] + lengths[k]);
        const Mat3d axes = matrix(frames[k]);
        const double angle = missing * way / length;
        frames[k] = frame_of(axes.d3, std::cos(angle) * axes.d1 + std::sin(angle) * axes.d2);
    }
}

/// The last node of a ring is its first.
void require_ring(std::span<const Vec3d> nodes, std::int64_t rod) {
    double length = 0;
    for (std::size_t k = 0; k + 1 < nodes.size(); ++k) length += norm(nodes[k + 1] - nodes[k]);
    const double gap = norm(nodes.back() - nodes.front());
    if (gap > 1e-6 * length)
        throw InputError(fmt::format("rod {} of the file is to be a ring (shape.closed), whose last node is its first: "
                                     "they are {:.3g} m apart",
                                     rod, gap));
}

/// Permutation that sorts the indices.
std::vector<std::size_t> rising(std::span<const std::int64_t> indices) {
    std::vector<std::size_t> order(indices.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return indices[a] < indices[b]; });
    return order;
}

/// Consecutive rods, such as those of a single rank, need no list and no search in it.
void forget_consecutive(std::int64_t& begin, std::vector<std::int64_t>& held) {
    if (held.empty() || held.back() - held.front() + 1 != static_cast<std::int64_t>(held.size())) return;
    begin = held.front();
    held = {};
}

} // namespace

/// Elements of a rod through given nodes.
struct Places::Tracer {
    std::vector<Quaterniond> frames{};

    /// Puts the lengths of the elements, and the curvatures of the cells between them, 1/m, into `sizes`. Frames follow
    /// the edges. d1 is given for every element, or is transported from the first element with least twist. Returns the
    /// frame at s = 0, where the half cell of a clamped end begins.
    Quaterniond trace(std::span<const Vec3d> nodes, std::span<const Vec3d> element_normals,
                      const std::optional<Vec3d>& normal, bool closed, double* sizes);
};

SKEIN_FUSED Quaterniond Places::Tracer::trace(std::span<const Vec3d> nodes, std::span<const Vec3d> element_normals,
                                              const std::optional<Vec3d>& normal, bool closed, double* sizes) {
    const std::size_t n = nodes.size() - 1;
    double *const lengths = sizes, *const curvatures = sizes + n;
    frames.clear();
    for (std::size_t k = 0; k < n; ++k) {
        const Vec3d edge = nodes[k + 1] - nodes[k];
        lengths[k] = norm(edge);
        const Vec3d d3 = unit(edge);
        if (!element_normals.empty()) frames.push_back(frame_of(d3, element_normals[k]));
        else if (k == 0) frames.push_back(frame_of(d3, normal));
        else frames.push_back(frame_of(d3, carried(frames.back(), d3)));
    }
    if (closed && element_normals.empty()) spread_twist(frames, {lengths, n});
    for (std::size_t k = 0; k + (closed ? 0 : 1) < n; ++k) {
        const std::size_t next = (k + 1) % n;
        const Vec3d curvature = (2 / (lengths[k] + lengths[next])) * relative_rotation(frames[next], frames[k]);
        std::memcpy(curvatures + 3 * k, &curvature, sizeof curvature);
    }
    return rotation(-0.5 * lengths[0] * Vec3d{curvatures[0], curvatures[1], curvatures[2]}) * frames[0];
}

Quaterniond frame_of(const Vec3d& tangent, const std::optional<Vec3d>& normal) {
    const Vec3d d3 = unit(tangent);
    const bool along_x = std::abs(d3.x) > 0.99;
    const Vec3d given = normal.value_or(along_x ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0});
    const Vec3d normal_part = given - dot(given, d3) * d3;
    const Vec3d d1 = unit(normal_part);
    return quaternion({d1, cross(d3, d1), d3});
}

void Deviation::include(const Deviation& other) {
    if (!other.resampled()) return;
    fewest = resampled() ? std::min(fewest, other.fewest) : other.fewest;
    most = std::max(most, other.most);
    if (other.distance <= distance) return;
    distance = other.distance;
    rod = other.rod;
}

Places::Places(const Placement& p, const std::string& source, const std::string& directory) : first_(p.origin) {
    for (std::size_t axis = 0; axis < std::min<std::size_t>(3, p.spacing.size()); ++axis)
        spacing_[axis] = p.spacing[axis];
    switch (p.kind) {
    case PlacementKind::line:
    case PlacementKind::lattice:
        for (std::size_t axis = 0; axis < p.counts.size(); ++axis) {
            if (axis < 2) counts_[axis] = p.counts[axis];
            count_ *= p.counts[axis];
        }
        stagger_ = p.stagger;
        break;
    case PlacementKind::mask: {
        Bitmap map = read_mask((std::filesystem::path(directory) / p.file).string(), source);
        counts_[0] = map.width;
        pixels_ = std::move(map.pixels);
        count_ = static_cast<std::int64_t>(pixels_.size());
        break;
    }
    case PlacementKind::list: {
        std::vector<Quaterniond> turns;
        const auto normal = [&](std::size_t i) {
            return p.normals.empty() ? std::nullopt : std::optional(p.normals[i]);
        };
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
    : count_(static_cast<std::int64_t>(origins.size())), listed_(true), turned_(!turns.empty()),
      origins_(std::move(origins)), turns_(std::move(turns)) {}

Places::Places(std::shared_ptr<const RodSource> source, const Vec3d& origin, std::int64_t elements, bool closed)
    : count_(source->count()), first_(origin), listed_(true), turned_(source->columns().turned()),
      source_(std::move(source)), columns_(source_->columns()), elements_(to_index(elements)), closed_(closed) {
    width_ = columns_.length + columns_.radius + (columns_.nodes ? elements_ + 3 * cells() : 0) +
             (columns_.radii ? elements_ : 0);
}

double Places::length(std::int64_t i, double given) const {
    if (columns_.length) return sizes_[row(i) * width_];
    const std::span lengths = element_lengths(i);
    return columns_.nodes ? std::accumulate(lengths.begin(), lengths.end(), 0.0) : given;
}

double Places::radius(std::int64_t i, double given) const {
    return columns_.radius ? sizes_[row(i) * width_ + columns_.length] : given;
}

std::span<const double> Places::element_lengths(std::int64_t i) const {
    if (!columns_.nodes) return {};
    return std::span(sizes_).subspan(row(i) * width_ + columns_.length + columns_.radius, elements_);
}

void Places::put_curvatures(std::int64_t i, std::vector<Vec3d>& curvatures) const {
    const double* at = element_lengths(i).data() + elements_;
    curvatures.resize(cells());
    for (std::size_t k = 0; k < curvatures.size(); ++k) curvatures[k] = {at[3 * k], at[3 * k + 1], at[3 * k + 2]};
}

std::span<const double> Places::element_radii(std::int64_t i) const {
    if (!columns_.radii) return {};
    return std::span(sizes_).subspan((row(i) + 1) * width_ - elements_, elements_);
}

std::vector<std::int64_t> Places::held() const {
    if (!held_.empty()) return held_;
    std::vector<std::int64_t> all(origins_.size());
    std::iota(all.begin(), all.end(), begin_);
    return all;
}

void Places::take_sizes(const Places& of_copy, std::int64_t copies) {
    columns_ = of_copy.columns_;
    elements_ = of_copy.elements_;
    closed_ = of_copy.closed_;
    width_ = of_copy.width_;
    sizes_.clear();
    sizes_.reserve(of_copy.sizes_.size() * to_index(copies));
    for (std::int64_t copy = 0; copy < copies; ++copy)
        sizes_.insert(sizes_.end(), of_copy.sizes_.begin(), of_copy.sizes_.end());
}

void Places::become(const Places& all, std::int64_t i) {
    count_ = all.count_;
    begin_ = i;
    listed_ = true;
    turned_ = all.turned_;
    origins_.assign(1, all.origin(i));
    if (turned_) turns_.assign(1, all.turn(i));
    else turns_.clear();
}

std::size_t Places::row(std::int64_t i) const {
    if (held_.empty()) return to_index(i - begin_);
    return to_index(std::lower_bound(held_.begin(), held_.end(), i) - held_.begin());
}

Vec3d Places::origin(std::int64_t i) const {
    if (listed_) return origins_[row(i)];
    const std::int64_t point = pixels_.empty() ? i : nth(pixels_, i);
    const std::int64_t x = point % counts_[0], rows = point / counts_[0];
    const std::int64_t y = pixels_.empty() ? rows % counts_[1] : rows, z = pixels_.empty() ? rows / counts_[1] : 0;
    return Vec3d{static_cast<double>(x) * spacing_[0] + ((y + z) % 2 == 1 ? stagger_ : 0),
                 static_cast<double>(y) * spacing_[1], static_cast<double>(z) * spacing_[2]} +
           first_;
}

Vec3d Places::corner() const {
    if (!listed_ && pixels_.empty()) return origin(0);
    const std::int64_t held = listed_ ? static_cast<std::int64_t>(origins_.size()) : count_;
    Vec3d corner{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    for (std::int64_t i = 0; i < held; ++i) {
        const Vec3d o = listed_ ? nth(origins_, i) : origin(i);
        corner = {std::min(corner.x, o.x), std::min(corner.y, o.y), std::min(corner.z, o.z)};
    }
    return corner;
}

void Places::read(std::int64_t begin, std::int64_t end, const Threads* threads) {
    constexpr std::int64_t most_nodes = 1 << 20; // in memory at once
    constexpr std::size_t piece = 1 << 9;
    const std::int64_t block = std::max<std::int64_t>(most_nodes / static_cast<std::int64_t>(elements_ + 1), 1 << 10);
    const std::size_t rods = to_index(end - begin);
    held_.clear();
    origins_.resize(rods);
    turns_.resize(turned_ ? rods : 0);
    sizes_.resize(rods * width_);
    begin_ = begin;
    read_ = true;
    deviation_ = {};
    std::vector<Tracer> tracers(threads_in(threads));
    for (std::int64_t at = begin; at < end; at += block) {
        const RodRows rows = source_->read(at, std::min(end, at + block), threads);
        deviation_.include(rows.deviation);
        const std::size_t row = to_index(at - begin);
        in_pieces(threads, rows.origins.size(), piece,
                  [&](std::size_t first, std::size_t past, std::size_t thread, std::size_t) {
                      for (std::size_t i = first; i < past; ++i) take(rows, at, row + i, i, tracers[thread]);
                  });
    }
}

/// Takes rod i of rows that begin with rod `first` as a row of this list.
void Places::take(const RodRows& rows, std::int64_t first, std::size_t row, std::size_t i, Tracer& tracer) {
    const auto normal = rows.normals.empty() ? std::nullopt : std::optional(rows.normals[i]);
    origins_[row] = rows.origins[i] + first_;
    double* sizes = sizes_.data() + row * width_;
    if (columns_.length) *sizes++ = rows.lengths[i];
    if (columns_.radius) *sizes++ = rows.radii[i];
    if (columns_.nodes) {
        const std::span nodes = std::span(rows.nodes).subspan(i * (elements_ + 1), elements_ + 1);
        if (closed_) require_ring(nodes, first + static_cast<std::int64_t>(i));
        const std::span normals = columns_.directors ? std::span(rows.element_normals).subspan(i * elements_, elements_)
                                                     : std::span<const Vec3d>();
        turns_[row] = tracer.trace(nodes, normals, normal, closed_, sizes);
        sizes += elements_ + 3 * cells();
    } else if (turned_) turns_[row] = frame_of(rows.tangents[i], normal);
    if (columns_.radii) std::copy_n(&rows.element_radii[i * elements_], elements_, sizes);
}

std::uint64_t Places::digest(const Threads* threads) const {
    constexpr std::size_t piece = 1 << 12;
    std::vector<std::uint64_t> sums((origins_.size() + piece - 1) / piece, 0);
    const auto hash = [&](std::size_t row) {
        const Vec3d& o = origins_[row];
        const Quaterniond q = turned_ ? turns_[row] : no_turn;
        std::uint64_t h = hash_begin(held_.empty() ? begin_ + static_cast<std::int64_t>(row) : held_[row]);
        for (const double x : {o.x, o.y, o.z, q.w, q.v.x, q.v.y, q.v.z}) h = hash_with(h, x);
        for (std::size_t w = 0; w < width_; ++w) h = hash_with(h, sizes_[row * width_ + w]);
        return hash_end(h);
    };
    in_pieces(threads, origins_.size(), piece,
              [&](std::size_t first, std::size_t past, std::size_t, std::size_t number) {
                  for (std::size_t row = first; row < past; ++row) sums[number] += hash(row);
              });
    return std::accumulate(sums.begin(), sums.end(), std::uint64_t{0});
}

void Places::keep(std::span<const std::int64_t> indices) {
    if (!listed_) return;
    if (static_cast<std::int64_t>(indices.size()) == count_ && held_.empty()) return; // all of them
    const auto order = rising(indices);
    std::vector<std::size_t> rows;
    std::vector<std::int64_t> held;
    for (const std::size_t i : order) {
        rows.push_back(row(indices[i]));
        held.push_back(indices[i]);
    }
    keep_rows(origins_, rows);
    keep_rows(turns_, rows);
    if (width_ > 0) {
        std::vector<double> sizes;
        sizes.reserve(rows.size() * width_);
        for (const std::size_t row : rows)
            sizes.insert(sizes.end(), &sizes_[row * width_], &sizes_[row * width_] + width_);
        sizes_ = std::move(sizes);
    }
    held_ = std::move(held);
    forget_consecutive(begin_, held_);
}

std::vector<std::byte> Places::records() const {
    std::vector<std::byte> bytes(origins_.size() * record_bytes());
    for (std::size_t row = 0; row < origins_.size(); ++row) {
        std::byte* record = &bytes[row * record_bytes()];
        std::memcpy(record, &origins_[row], sizeof(Vec3d));
        if (turned_) std::memcpy(record + sizeof(Vec3d), &turns_[row], sizeof(Quaterniond));
        if (width_ > 0)
            std::memcpy(record + sizeof(Vec3d) + sizeof(Quaterniond), &sizes_[row * width_], width_ * sizeof(double));
    }
    return bytes;
}

void Places::keep(std::span<const std::int64_t> indices, std::span<const std::byte> records) {
    const auto order = rising(indices);
    origins_.resize(order.size());
    turns_.resize(turned_ ? order.size() : 0);
    held_.resize(order.size());
    sizes_.resize(order.size() * width_);
    for (std::size_t row = 0; row < order.size(); ++row) {
        const std::byte* record = &records[order[row] * record_bytes()];
        std::memcpy(&origins_[row], record, sizeof(Vec3d));
        if (turned_) std::memcpy(&turns_[row], record + sizeof(Vec3d), sizeof(Quaterniond));
        if (width_ > 0)
            std::memcpy(&sizes_[row * width_], record + sizeof(Vec3d) + sizeof(Quaterniond), width_ * sizeof(double));
        held_[row] = indices[order[row]];
    }
    forget_consecutive(begin_, held_);
    origins_.shrink_to_fit();
    turns_.shrink_to_fit();
    sizes_.shrink_to_fit();
}

std::size_t Places::bytes() const {
    return pixels_.size() * sizeof(std::uint32_t) + origins_.size() * sizeof(Vec3d) +
           turns_.size() * sizeof(Quaterniond) + held_.size() * sizeof(std::int64_t) + sizes_.size() * sizeof(double);
}

} // namespace skein
