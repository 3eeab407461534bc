// The XDMF side-car: tells ParaView and VTK where in the HDF5 segments the rods' polylines and their attributes are.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct XdmfGroup {
    std::string name;
    std::int64_t rods, nodes;
    bool normals, magnetised;
};

/// Frames of one file, by the file's name relative to the side-car.
struct XdmfSegment {
    std::string file;
    std::vector<double> times;
};

/// `number_bytes`: of the frames' floating-point numbers.
std::string xdmf_document(const std::string& title, std::span<const XdmfGroup> groups, std::span<const XdmfSegment> segments,
                          int number_bytes);

} // namespace skein
