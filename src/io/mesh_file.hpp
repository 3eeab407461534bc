// Files of triangles: STL as text or binary, and OBJ.
#pragma once

#include "immersion/triangle_mesh.hpp"

#include <memory>
#include <string>

namespace skein {

/// Closed surface of a file, whose coordinates are in units of `unit`, m. Throws InputError with the file, and the line
/// or the number of a triangle, where it cannot be read or encloses no body.
std::shared_ptr<const TriangleMesh> read_mesh(const std::string& path, double unit);

} // namespace skein
