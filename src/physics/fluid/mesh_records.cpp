#include "physics/fluid/mesh_records.hpp"

#include "core/hash.hpp"
#include "immersion/triangle_mesh.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

namespace skein {

MeshRecords::Record MeshRecords::record_of(const Obstacle& obstacle) {
    const auto number = [](std::uint64_t digest) { return static_cast<double>(digest >> 12); }; // a double has it
    const std::vector<double> name(obstacle.file.begin(), obstacle.file.end());
    std::vector<double> surface;
    for (const Vec3d& at : obstacle.mesh->points()) surface.insert(surface.end(), {at.x, at.y, at.z});
    for (const TriangleMesh::Triangle& corners : obstacle.mesh->triangles())
        surface.insert(surface.end(), corners.begin(), corners.end());
    return {number(hash_numbers(0, name)), number(hash_numbers(1, surface))};
}

MeshRecords::MeshRecords(const std::vector<Obstacle>& obstacles) {
    for (const Obstacle& o : obstacles)
        if (o.mesh) meshes_.push_back({&o, record_of(o)});
}

std::vector<double> MeshRecords::saved() const {
    std::vector<double> all;
    for (const Mesh& mesh : meshes_) all.insert(all.end(), mesh.record.begin(), mesh.record.end());
    return all;
}

std::span<const double> MeshRecords::after(std::span<const double> numbers) const {
    for (const auto& [obstacle, own] : meshes_) {
        if (numbers.size() < own.size()) throw IoError("the fluid of a checkpoint differs from the fluid of the scene");
        if (numbers[0] == own[0] && numbers[1] != own[1])
            throw InputError(
                fmt::format("{}: obstacle '{}': its mesh '{}' has changed since the checkpoint: a run "
                            "continues with the mesh that it began with; put that file back, or begin again in "
                            "another directory",
                            obstacle->source, obstacle->name, obstacle->file));
        numbers = numbers.subspan(own.size());
    }
    return numbers;
}

} // namespace skein
