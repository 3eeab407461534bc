// Files with points along rods, as many as each rod has. Rods are resampled to the elements of the scene.
#pragma once

#include "placement/resampling.hpp"
#include "skein/placement/places.hpp"

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Points of consecutive rods one after another, in units of the file.
struct RodPoints {
    std::vector<std::size_t> first;   ///< [rods + 1]: point at which each rod begins, and the number of points
    std::vector<Vec3d> points;        ///< [points]
    std::vector<double> radii;        ///< empty, or [points]
    std::vector<Vec3d> normals;       ///< empty, or [points]: d1
    std::vector<Vec3d> start_normals; ///< empty, or [rods]: d1 at the start
    std::size_t rods() const { return first.size() - 1; }
};

class PointFile : public RodSource {
public:
    PointFile(std::string path, std::int64_t elements, double unit)
        : path_(std::move(path)), target_(static_cast<std::size_t>(elements)), unit_(unit) {}
    std::int64_t count() const override { return count_; }
    RodColumns columns() const override;
    RodRows read(std::int64_t begin, std::int64_t end, const Threads* threads) const override;

protected:
    static constexpr std::int64_t most_points = 1 << 20; ///< in memory at once, unless one rod has more
    /// Makes room for the points of rods that begin at these points of the file.
    void make_room(RodPoints& points, std::span<const std::int64_t> first) const;
    using TakeRods = std::function<void(std::int64_t first_rod, RodPoints& points)>;
    /// Calls `take` for rods [begin, end) in order, some of them at once. It may change the points.
    virtual void read_points(std::int64_t begin, std::int64_t end, const Threads* threads,
                             const TakeRods& take) const = 0;
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
    void check(std::int64_t rod, RodPoints& given, std::size_t begin, std::size_t end) const;

    std::size_t target_;          ///< elements of a rod
    double unit_;                 ///< m
    mutable std::mutex refusing_; ///< places are read from the file by one thread at a time
};

} // namespace skein
