// Ten beds of rods, for the search of candidates: shapes, packings, sizes and speeds at which it may go wrong or slow.
#pragma once

#include "skein/core/index.hpp"
#include "support/exposed_bodies.hpp"

#include <array>
#include <cmath>
#include <random>
#include <string_view>

namespace skein::test {

inline constexpr std::array<std::string_view, 10> bed_names{"layer",  "column", "cubic", "dilute", "brush",
                                                            "bundle", "nest",   "mixed", "pushed", "settling"};

/// A bed as a whole. Rods have eight elements, 4.5 times as long as thick, of radius 1; of `mixed` 0.1 to 10.
class Bed {
public:
    Bed(std::string_view name, int rods, unsigned seed = 1) : random_(seed) {
        const double side = std::cbrt(rods * room), across = std::sqrt(static_cast<double>(rods));
        for (int r = 0; r < rods; ++r) {
            const double x = uniform_(random_), y = uniform_(random_), z = uniform_(random_);
            const auto column = static_cast<int>(std::ceil(across)), i = r % column, k = r / column;
            if (name == "layer") add(across * 10 * Vec3d{x, y, 0.01 * z}, {normal(), normal(), 0});
            else if (name == "column") add({10 * x, 10 * y, 4.0 * rods * z}, direction());
            else if (name == "cubic") add({2.02 * i, 0, 2.02 * k}, {0, 1, 0});
            else if (name == "dilute") add(4 * side * Vec3d{x, y, z}, direction());
            else if (name == "brush") add({3.0 * i, 3.0 * k, 0}, Vec3d{0.05 * normal(), 0.05 * normal(), 1});
            else if (name == "bundle") add({2.0 * i + k % 2, std::sqrt(3.0) * k, 10 * z}, {0, 0, 1});
            else if (name == "mixed") add(side * Vec3d{x, y, z}, direction(), 0.1 * std::pow(100.0, uniform_(random_)));
            else add(side * Vec3d{x, y, z}, direction());
            const double fast = name == "pushed" ? (r % 50 == 0 ? 30 : 1) : name == "settling" ? 1 + z : 1;
            speed_.insert(speed_.end(), elements + 1, fast);
        }
    }
    /// With speeds, and paces that follow from them.
    Exposure exposure() const {
        Exposure bodies = bodies_.exposure();
        for (std::size_t s = 0; s < bodies.slots(); ++s) bodies.motion[s].velocity = {0, 0, -speed_[s]};
        const Threads one(1);
        bodies.set_paces(one, bodies.largest_speed(one));
        return bodies;
    }
    const TouchRules& rules() const { return bodies_.rules; }
    ContactScene scene(ContactLaws laws) const { return bodies_.scene(std::move(laws)); }

    static constexpr int elements = 8;

private:
    static constexpr double length = 9 * elements,
                            room = 16 * length; ///< volume of a rod's share in a nest, a fifth of it filled

    double normal() { return std::normal_distribution<double>()(random_); }
    Vec3d direction() { return {normal(), normal(), normal()}; }
    void add(const Vec3d& start, const Vec3d& along, double radius = 1) {
        std::vector<Vec3d> nodes;
        for (int k = 0; k <= elements; ++k) nodes.push_back(start + (9.0 * radius * k / norm(along)) * along);
        bodies_.add(nodes, radius);
    }

    std::mt19937 random_;
    std::uniform_real_distribution<double> uniform_;
    BodiesByHand bodies_;
    std::vector<double> speed_;
};

} // namespace skein::test
