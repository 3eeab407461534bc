// Files with points along rods, as many as each rod has. Rods are resampled to the elements of the scene.
#pragma once

#include "placement/resampling.hpp"
#include "skein/placement/places.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Points of one rod, in units of the file.
struct RodPoints {
    std::vector<Vec3d> points;
    std::vector<double> radii;       ///< empty, or one per point
    std::vector<Vec3d> normals;      ///< empty, or d1 at each point
    std::vector<Vec3d> start_normal; ///< empty, or d1 at the start
    void clear();
};

class PointFile : public RodSource {
public:
    PointFile(std::string path, std::int64_t elements, double unit)
        : path_(std::move(path)), target_(static_cast<std::size_t>(elements)), unit_(unit) {}
    std::int64_t count() const override { return count_; }
    RodColumns columns() const override;
    RodRows read(std::int64_t begin, std::int64_t end) const override;

protected:
    using TakeRod = std::function<void(std::int64_t rod, RodPoints& points)>;
    /// Calls `take` for rods [begin, end) in order. It may change the points.
    virtual void read_points(std::int64_t begin, std::int64_t end, const TakeRod& take) const = 0;
    /// Place of a point of a rod in the file, for messages; of the rod alone where point < 0.
    virtual std::string place(std::int64_t rod, std::int64_t point) const = 0;
    /// Rod as the file names it.
    virtual std::string name(std::int64_t rod) const = 0;
    [[noreturn]] void refuse(std::int64_t rod, std::int64_t point, const std::string& what) const;
    [[noreturn]] void refuse(const std::string& what) const;

    std::string path_;
    std::int64_t count_ = 0;
    bool radii_ = false, normals_ = false, start_normals_ = false; ///< quantities that the file has

private:
    struct Resampler;
    void check(std::int64_t rod, RodPoints& rod_points) const;

    std::size_t target_; ///< elements of a rod
    double unit_;        ///< m
};

} // namespace skein
