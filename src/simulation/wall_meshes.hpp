// Walls as polygons for those who look: planes as quads about as large as the scene, tubes and balls in facets, cut off
// where planes that stand still, or move along, bound them. A box is its planes, each cut by its neighbours. Walls that
// do not stand in the present stage are not shown, and cut nothing.
#pragma once

#include "contact/wall.hpp"
#include "io/vtk_polydata.hpp"
#include "parallel/communicator.hpp"
#include "skein/rod/rod_group.hpp"
#include "tiles/rods.hpp"

#include <span>
#include <vector>

namespace skein {

class WallMeshes {
public:
    /// The scene reaches as far as rods do at the start, tubes and balls around them, and half as far again. `walls`
    /// must outlive it. `own`: the rods of this rank. Collective.
    WallMeshes(const Communicator& comm, const Walls& walls, std::span<const RodGroup> groups,
               std::span<const LocalRod> own);

    /// Numbers of polygons are those of the walls. `time`: s, for walls that move steadily.
    PolygonMesh at(double time) const;

private:
    using Polygon = std::vector<Vec3d>;
    std::vector<Polygon> facets(std::size_t wall) const;
    Polygon quad(const Vec3d& point, const Vec3d& normal) const;
    std::vector<Polygon> tube(const Wall& wall) const;
    std::vector<Polygon> ball(const Wall& wall) const;

    const Walls& walls_;
    Vec3d centre_{0, 0, 0}; ///< of the scene, m
    double reach_ = 0;      ///< from there, m
};

} // namespace skein
