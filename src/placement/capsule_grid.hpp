// Grid of the capsules that may be near an axis: cells above a floor, open at the top. Axes are sampled in points at
// most a cell apart. Two axes closer than `reach` have points closer than reach + cell. A capsule is therefore listed
// in all cells that the cube of this size around its points touches. One point of the other axis lies in such a cell.
#pragma once

#include "placement/packing.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace skein {

class CapsuleGrid {
public:
    /// Grid for axes above `lower` and below `upper` in x and y, and below `top`.
    CapsuleGrid(const Vec3d& lower, const Vec3d& upper, double cell)
        : lower_(lower), cell_(cell), nx_(cells(upper.x - lower.x)), ny_(cells(upper.y - lower.y)) {
        raise(upper.z);
    }

    /// Extends the cells to z = `top` at least.
    void raise(double top) {
        const long before = nz_, needed = cells(top - lower_.z);
        if (needed <= before) return;
        nz_ = std::max(needed, before + before / 4); // all capsules are listed anew, which is seldom
        newest_.resize(to_index(nx_ * ny_ * nz_), -1);
        for (std::size_t i = 0; i < capsules_.size(); ++i) list(static_cast<std::int32_t>(i), before);
    }

    /// Adds a capsule; axes closer than `reach` to its axis are blocked.
    void add(const Capsule& capsule, double reach) {
        capsules_.push_back({capsule, reach, 0});
        list(static_cast<std::int32_t>(capsules_.size()) - 1, 0);
    }

    /// True where no capsule blocks the axis.
    bool is_clear(const Capsule& asked) {
        ++question_;
        const long points = points_of(asked);
        for (long i = 0; i <= points; ++i) {
            const Vec3d p = point(asked, i, points);
            const std::size_t at = index(std::clamp(cell_of(p.x - lower_.x), 0L, nx_ - 1),
                                         std::clamp(cell_of(p.y - lower_.y), 0L, ny_ - 1),
                                         std::clamp(cell_of(p.z - lower_.z), 0L, nz_ - 1));
            for (std::int32_t entry = newest_[at]; entry >= 0; entry = nth(entries_, entry).older) {
                Listed& other = nth(capsules_, nth(entries_, entry).capsule);
                if (other.question == question_) continue;
                other.question = question_;
                if (closer(asked, other.capsule, other.reach)) return false;
            }
        }
        return true;
    }

private:
    struct Listed {
        Capsule capsule;
        double reach;
        std::int64_t question; ///< last question that read this entry
    };
    struct Entry {
        std::int32_t capsule, older;
    };

    long cells(double extent) const { return std::max(1L, static_cast<long>(std::ceil(extent / cell_))); }
    long cell_of(double x) const { return static_cast<long>(std::floor(x / cell_)); }
    std::size_t index(long x, long y, long z) const { return to_index((z * ny_ + y) * nx_ + x); }
    long points_of(const Capsule& c) const {
        return std::max(1L, static_cast<long>(std::ceil(norm(c.end - c.start) / cell_)));
    }
    static Vec3d point(const Capsule& c, long i, long points) {
        return c.start + (static_cast<double>(i) / static_cast<double>(points)) * (c.end - c.start);
    }

    /// Lists a capsule in the cells of the layers from `from` up.
    void list(std::int32_t number, long from) {
        const Listed& listed = nth(capsules_, number);
        const double half = listed.reach + cell_;
        const long points = points_of(listed.capsule);
        for (long i = 0; i <= points; ++i) {
            const Vec3d p = point(listed.capsule, i, points) - lower_;
            const long x0 = std::max(0L, cell_of(p.x - half)), x1 = std::min(nx_ - 1, cell_of(p.x + half));
            const long y0 = std::max(0L, cell_of(p.y - half)), y1 = std::min(ny_ - 1, cell_of(p.y + half));
            const long z0 = std::max(from, cell_of(p.z - half)), z1 = std::min(nz_ - 1, cell_of(p.z + half));
            for (long z = z0; z <= z1; ++z)
                for (long y = y0; y <= y1; ++y)
                    for (long x = x0; x <= x1; ++x) {
                        std::int32_t& newest = newest_[index(x, y, z)];
                        if (newest >= 0 && nth(entries_, newest).capsule == number) continue;
                        entries_.push_back({number, newest});
                        newest = static_cast<std::int32_t>(entries_.size()) - 1;
                    }
        }
    }

    Vec3d lower_;
    double cell_;
    long nx_, ny_, nz_ = 0;
    std::vector<std::int32_t> newest_; ///< newest entry of each cell, or -1
    std::vector<Entry> entries_;
    std::vector<Listed> capsules_;
    std::int64_t question_ = 0;
};

} // namespace skein
