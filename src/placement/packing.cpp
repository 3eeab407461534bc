#include "placement/packing.hpp"

#include "core/closest_points.hpp"
#include "core/hilbert.hpp"
#include "core/stop.hpp"
#include "placement/capsule_grid.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <utility>

namespace skein {

namespace {

using std::numbers::pi;

class Random {
public:
    explicit Random(long seed) : engine_(static_cast<std::uint64_t>(seed)) {}
    /// Even over [low, high); std::uniform_real_distribution may differ from library to library.
    double between(double low, double high) {
        return low + (high - low) * 0x1p-53 * static_cast<double>(engine_() >> 11);
    }

private:
    std::mt19937_64 engine_;
};

/// Draws d3. Isotropic directions are even over the sphere between two circles of latitude, so in the sine of the
/// elevation.
Vec3d draw_direction(const Packing& p, Random& random) {
    const double degree = pi / 180, low = degree * p.elevation[0], high = degree * p.elevation[1];
    const double even = random.between(0, 1);
    const double elevation = low + even * (high - low),
                 sine_between = std::sin(low) + even * (std::sin(high) - std::sin(low));
    const double sine = p.elevation_law == ElevationLaw::uniform ? std::sin(elevation) : sine_between,
                 cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
    const double azimuth = degree * random.between(p.azimuth[0], p.azimuth[1]);
    return {cosine * std::cos(azimuth), cosine * std::sin(azimuth), sine};
}

/// Frame with d3 along `direction` and d1 horizontal.
Quaterniond frame_along(const Vec3d& direction) {
    const double horizontal = std::hypot(direction.x, direction.y);
    const Vec3d d1 = horizontal > 0 ? Vec3d{-direction.y / horizontal, direction.x / horizontal, 0} : Vec3d{1, 0, 0};
    return quaternion({d1, cross(direction, d1), direction});
}

/// Region of the centres of capsules that lie wholly inside.
class Region {
public:
    Region(const Packing& p, double length, double radius)
        : kind_(p.region), lower_(p.lower), upper_(p.upper), radius_(radius) {
        const double steepest = pi / 180 * std::max(std::abs(p.elevation[0]), std::abs(p.elevation[1]));
        tallest_ = length * std::sin(steepest) + 2 * radius;
        if (kind_ == PackingRegion::cylinder) {
            lower_ = p.point - Vec3d{p.radius, p.radius, 0};
            upper_ = p.point + Vec3d{p.radius, p.radius, p.height};
            centre_ = p.point;
            spread_ = p.radius - radius;
        }
        if (kind_ == PackingRegion::slab) upper_.z = floor_ = lower_.z;
    }
    const Vec3d& lower() const { return lower_; }
    const Vec3d& upper() const { return upper_; }
    double volume() const {
        const Vec3d size = upper_ - lower_;
        return (kind_ == PackingRegion::cylinder ? 0.25 * pi : 1) * size.x * size.y * size.z;
    }
    bool grows() const { return kind_ == PackingRegion::slab; }
    /// Raises the top by a layer. Later rods keep to the upper part, which is not yet full.
    void grow(double layer) {
        upper_.z += layer;
        floor_ = std::max(lower_.z, upper_.z - tallest_ - 2 * layer);
    }
    /// True where a rod that ends `half` from its centre fits somewhere.
    bool holds(const Vec3d& half) const {
        const Vec3d room = room_for(half);
        if (kind_ == PackingRegion::cylinder) return room.z >= 0 && spread_ >= std::hypot(half.x, half.y);
        return room.x >= 0 && room.y >= 0 && (grows() || room.z >= 0);
    }
    /// Draws a centre evenly. Returns nothing where it lies outside.
    std::optional<Vec3d> draw(const Vec3d& half, Random& random) const {
        const Vec3d room = room_for(half), low = lower_ + margin(half);
        if (kind_ != PackingRegion::cylinder) {
            const double rise = std::min(floor_above(), room.z);
            if (room.z < 0) return std::nullopt;
            return low + Vec3d{random.between(0, room.x), random.between(0, room.y), random.between(rise, room.z)};
        }
        const double x = random.between(-spread_, spread_), y = random.between(-spread_, spread_),
                     z = random.between(0, room.z);
        const bool inside =
            std::hypot(x + half.x, y + half.y) <= spread_ && std::hypot(x - half.x, y - half.y) <= spread_;
        return inside ? std::optional(Vec3d{centre_.x + x, centre_.y + y, low.z + z}) : std::nullopt;
    }

private:
    Vec3d margin(const Vec3d& half) const {
        return {std::abs(half.x) + radius_, std::abs(half.y) + radius_, std::abs(half.z) + radius_};
    }
    Vec3d room_for(const Vec3d& half) const { return upper_ - lower_ - 2 * margin(half); }
    double floor_above() const { return grows() ? floor_ - lower_.z : 0; }

    PackingRegion kind_;
    Vec3d lower_, upper_, centre_{0, 0, 0};
    double radius_, tallest_ = 0;
    double spread_ = 0; ///< cylinder: largest distance of an axis from the cylinder's axis
    double floor_ = 0;  ///< slab: lower bound of the centres that are tried
};

double volume_of(double length, double radius) { return pi * radius * radius * (length + 4.0 / 3 * radius); }

/// Order of the rods on a curve through their centres, so that rods of near numbers are near each other.
std::vector<std::size_t> along_curve(const std::vector<Vec3d>& centres, const Region& region) {
    const Vec3d size = region.upper() - region.lower();
    const double side = std::max({size.x, size.y, size.z});
    std::vector<std::pair<std::uint64_t, std::size_t>> keys;
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const Vec3d from = centres[i] - region.lower();
        keys.emplace_back(hilbert_key({from.x / side, from.y / side, from.z / side}), i);
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::size_t> order;
    for (const auto& key : keys) order.push_back(key.second);
    return order;
}

} // namespace

bool closer(const Capsule& a, const Capsule& b, double distance) {
    const auto apart = closest_points(broadcast<1>(a.start), broadcast<1>(a.end - a.start), broadcast<1>(b.start),
                                      broadcast<1>(b.end - b.start))
                           .apart;
    return dot(apart, apart)[0] < distance * distance;
}

namespace {

class Packer {
public:
    Packer(const Packing& p, double length, double radius, std::vector<Capsule>& occupied, const std::string& where)
        : p_(p), length_(length), radius_(radius), gap_(p.gap > 0 ? p.gap : 0.05 * radius), reach_(2 * radius + gap_),
          count_(to_index(p.count)), occupied_(occupied), where_(where),
          region_(first_layer(p, length, radius, reach_)),
          patience_(region_.grows() ? std::max(1L, p.attempts / 100) : p.attempts),
          grid_(region_.lower(), region_.upper(),
                std::max(2 * reach_, std::cbrt(region_.volume() / (1000.0 * static_cast<double>(count_))))),
          random_(p.seed) {
        for (const Capsule& c : occupied) grid_.add(c, c.radius + radius + gap_);
    }

    PackedRods pack() {
        while (centres_.size() < count_) {
            const Capsule placed = place_next();
            grid_.add(placed, reach_);
            occupied_.push_back(placed);
        }
        PackedRods packed;
        for (const std::size_t i : along_curve(centres_, region_)) {
            packed.origins.push_back(centres_[i] - 0.5 * length_ * directions_[i]);
            packed.frames.push_back(frame_along(directions_[i]));
        }
        packed.top = region_.upper().z;
        packed.fill = filled();
        return packed;
    }

private:
    static Region first_layer(const Packing& p, double length, double radius, double layer) {
        Region region(p, length, radius);
        if (region.grows()) region.grow(layer);
        return region;
    }

    /// Share of the region's volume that the placed rods fill.
    double filled() const {
        return static_cast<double>(centres_.size()) * volume_of(length_, radius_) / region_.volume();
    }

    Vec3d draw_direction_that_fits() {
        for (long attempt = 0; attempt < p_.attempts; ++attempt)
            if (const Vec3d direction = draw_direction(p_, random_); region_.holds(0.5 * length_ * direction))
                return direction;
        throw InputError(
            fmt::format("{}: in none of {} random directions does a rod of length {:g} m fit into the empty region: "
                        "enlarge it, or change 'elevation' or 'azimuth'",
                        where_, p_.attempts, length_));
    }

    /// Draws centres until the rod is clear of all others. After `patience_` centres a slab grows by a layer. In other
    /// regions each further centre has a direction of its own.
    Capsule place_next() {
        Vec3d direction = draw_direction_that_fits(), half = 0.5 * length_ * direction;
        for (long attempt = 0;; ++attempt) {
            stop_where_asked("rods were packed");
            if (attempt >= patience_ && region_.grows()) {
                region_.grow(reach_);
                grid_.raise(region_.upper().z);
                attempt = -1;
                continue;
            }
            if (attempt - patience_ >= patience_) refuse();
            if (attempt >= patience_) {
                direction = draw_direction_that_fits();
                half = 0.5 * length_ * direction;
            }
            const auto centre = region_.draw(half, random_);
            if (!centre) {
                if (region_.grows()) attempt = patience_; // the layer is too low for this direction
                continue;
            }
            const Capsule tried{*centre - half, *centre + half, radius_};
            if (!grid_.is_clear(tried)) continue;
            centres_.push_back(*centre);
            directions_.push_back(direction);
            return tried;
        }
    }

    [[noreturn]] void refuse() const {
        throw InputError(fmt::format(
            "{}: {} of {} rods could be packed, {:.1f} % of the region's volume; the next one found no place in {} "
            "attempts in one direction and in as many in others: enlarge the region, lower 'count' or 'gap', narrow "
            "'elevation', or raise 'attempts'",
            where_, centres_.size(), count_, 100 * filled(), p_.attempts));
    }

    const Packing& p_;
    double length_, radius_; ///< length and radius of a rod, m
    double gap_;             ///< least gap between surfaces, m
    double reach_;           ///< least distance of two axes, m
    std::size_t count_;
    std::vector<Capsule>& occupied_;
    const std::string& where_;
    Region region_;
    long patience_;    ///< centres per direction; a slab is never full, and another layer is cheaper after a hundredth
    CapsuleGrid grid_; ///< cells of two diameters, or larger where these would be many more than capsules fill
    Random random_;
    std::vector<Vec3d> centres_, directions_;
};

} // namespace

PackedRods pack(const Packing& p, double length, double radius, std::vector<Capsule>& occupied,
                const std::string& where) {
    return Packer(p, length, radius, occupied, where).pack();
}

} // namespace skein
