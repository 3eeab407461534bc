// XDMF side-car: shows ParaView and VTK the polylines of rods and their attributes in HDF5 segments.
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

/// Frames of one file.
struct XdmfSegment {
    std::string file; ///< name relative to the side-car
    std::vector<double> times;
};

/// `number_bytes` is the size of floating-point numbers in frames.
std::string xdmf_document(const std::string& title, std::span<const XdmfGroup> groups,
                          std::span<const XdmfSegment> segments, int number_bytes);

/// True if a document of the first `listed` segments lags by a sixteenth. All documents of a run together are then in
/// proportion to the last one.
inline bool document_lags(std::size_t segments, std::size_t listed) { return segments > listed + listed / 16; }

/// True if the text is such a document.
bool is_xdmf_document(std::string_view text);

} // namespace skein
