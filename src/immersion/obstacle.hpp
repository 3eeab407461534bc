// Bodies in a fluid whose motion is given.
#pragma once

#include "immersion/direct_forcing.hpp"
#include "skein/core/fields.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class ObstacleKind { sphere, cylinder };
inline constexpr std::string_view obstacle_names[] = {"sphere", "cylinder"};

/// [[obstacle]]: rests, moves or swings, and is not moved by the fluid.
struct Obstacle {
    std::string name = "obstacle";
    ObstacleKind kind = ObstacleKind::sphere;
    Vec3d centre{0, 0, 0};    ///< m, at the start
    double radius = 0;        ///< m
    double second_radius = 0; ///< m, of a cylinder of elliptic section, along y; 0: as the first
    Vec3d velocity{0, 0, 0};  ///< m/s
    Vec3d amplitude{0, 0, 0}; ///< m, of a sine
    double frequency = 0;     ///< Hz
    double retraction = 0.4;  ///< of markers into the body, over the spacing of the grid
    std::string source;       ///< file:line of the table, for messages

    void fields(FieldVisitor& f);

    /// Of its centre.
    Vec3d place_at(double time) const;
    Vec3d velocity_at(double time) const;
    bool moves() const;
    /// Within the box; of a cylinder, its length along z is that of the box.
    double volume(const FluidGrid& grid) const;
    /// About its centre.
    std::vector<Vec3d> markers(const FluidGrid& grid) const;
};

/// Forcing by obstacles.
class ObstacleForcing {
public:
    ObstacleForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const ForcingNumbers& numbers,
                    std::vector<Obstacle> obstacles);

    DirectForcing& forcing() { return forcing_; }
    const DirectForcing& forcing() const { return forcing_; }
    const std::vector<Obstacle>& obstacles() const { return obstacles_; }
    /// Mean force on an obstacle since the last call of begin_interval(), by a fluid of this density, N.
    Vec3d force(std::size_t obstacle, double density, double time) const;
    void begin_interval(double time) { forcing_.forget(), from_ = time; }

private:
    void place(double time, Markers& markers) const;

    FluidGrid grid_;
    int rank_, ranks_;
    std::vector<Obstacle> obstacles_;
    std::vector<std::vector<Vec3d>> about_centre_;
    DirectForcing forcing_;
    double from_ = 0;
};

} // namespace skein
