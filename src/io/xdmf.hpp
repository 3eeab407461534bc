// The XDMF side-car: tells ParaView and VTK where in the HDF5 segments the rods' polylines and their attributes are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
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
std::string xdmf_document(const std::string& title, std::span<const XdmfGroup> groups,
                          std::span<const XdmfSegment> segments, int number_bytes);

/// Whether a document of the first `listed` of so many segments is to be written anew: when it lags by a sixteenth, so
/// that all that are written are together in proportion to the last one.
inline bool document_lags(std::size_t segments, std::size_t listed) { return segments > listed + listed / 16; }

/// Whether a text is such a document.
bool is_xdmf_document(std::string_view text);

} // namespace skein
