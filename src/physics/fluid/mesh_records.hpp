// Meshes of obstacles in checkpoints: a run continues with the meshes that it began with.
#pragma once

#include "immersion/obstacle.hpp"

#include <array>
#include <span>
#include <vector>

namespace skein {

class MeshRecords {
public:
    explicit MeshRecords(const std::vector<Obstacle>& obstacles);

    /// Numbers of all meshes in a checkpoint.
    std::vector<double> saved() const;
    /// Numbers of a checkpoint behind those of meshes. Throws InputError for a mesh that has changed although its file
    /// has the same name. A fluid has no branches, so obstacles are those of the checkpoint.
    std::span<const double> after(std::span<const double> numbers) const;

private:
    /// Digests of the name of the file and of the surface.
    using Record = std::array<double, 2>;
    static Record record_of(const Obstacle& obstacle);

    struct Mesh {
        const Obstacle* obstacle;
        Record record;
    };
    std::vector<Mesh> meshes_;
};

} // namespace skein
