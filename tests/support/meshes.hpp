// Closed meshes of triangles for tests.
#pragma once

#include "immersion/triangle_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace skein::test {

struct Mesh {
    std::vector<Vec3d> points;
    std::vector<TriangleMesh::Triangle> triangles;
};

inline void append(Mesh& mesh, const Mesh& other) {
    const auto before = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({before + a, before + b, before + c});
}

inline Mesh turned_round(Mesh mesh) {
    for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

inline Mesh box_mesh(const Vec3d& half) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.points.push_back({i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

/// Octahedron whose triangles are cut into four so many times, with points on a sphere.
inline Mesh ball_mesh(double radius, int times) {
    Mesh mesh;
    mesh.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int n = 0; n < times; ++n) {
        Mesh finer;
        for (const auto& [a, b, c] : mesh.triangles) {
            const Vec3d p = mesh.points[a], q = mesh.points[b], r = mesh.points[c];
            const auto first = static_cast<std::uint32_t>(finer.points.size());
            for (const Vec3d& at : {p, q, r, unit(p + q), unit(q + r), unit(r + p)}) finer.points.push_back(at);
            for (const TriangleMesh::Triangle& t : {TriangleMesh::Triangle{0, 3, 5}, TriangleMesh::Triangle{3, 1, 4},
                                                    TriangleMesh::Triangle{5, 4, 2}, TriangleMesh::Triangle{3, 4, 5}})
                finer.triangles.push_back({first + t[0], first + t[1], first + t[2]});
        }
        mesh = finer;
    }
    for (Vec3d& p : mesh.points) p = radius * p;
    return mesh;
}

/// Sphere with spikes and dents, which is concave.
inline Mesh star_mesh() {
    Mesh mesh = ball_mesh(1, 2);
    for (Vec3d& p : mesh.points) p = (0.7 + 0.3 * std::sin(5 * p.x) * std::cos(4 * p.y + p.z)) * p;
    return mesh;
}

} // namespace skein::test
