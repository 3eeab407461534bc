// VTK's poly data files (.vtp): a head of XML, then the numbers of each array as they are in memory ("appended",
// "raw"), each behind the count of its bytes. Where every array begins is known before any is written, so ranks may
// write their parts side by side.
#pragma once

#include "io/descriptor.hpp"
#include "io/frame_files.hpp"
#include "skein/core/vec3.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skein {

enum class VtkType { int32, int64, float32, float64 };
std::size_t bytes_of(VtkType type);

enum class VtkPart { point_data, cell_data, points, lines, polygons };

struct VtkArray {
    VtkPart part;
    std::string name;
    VtkType type;
    int components;
    std::uint64_t tuples;

    std::uint64_t bytes() const { return tuples * static_cast<std::uint64_t>(components) * bytes_of(type); }
};

/// Number of a file's frame in its series. It stands behind the last tag, as a comment of XML.
struct VtkStamp {
    std::int64_t step, after; ///< `after`: step of the frame before, -1 of none
    std::uint64_t digest;     ///< byte_digest of all that is before the tail, and place_digest

    static constexpr std::size_t bytes = 86;
    std::string text() const;
    static std::optional<VtkStamp> from(std::string_view text);
};

/// Layout of one file: head, and where its arrays are.
class VtkPolyData {
public:
    VtkPolyData(std::uint64_t points, std::uint64_t lines, std::uint64_t polygons, std::vector<VtkArray> arrays,
                double time);

    const std::vector<VtkArray>& arrays() const { return arrays_; }
    const std::string& head() const { return head_; }
    static const std::string tail;
    /// Offset of the count of bytes before an array, and of the array itself, from the beginning of the file.
    std::uint64_t count_at(std::size_t array) const { return at_[array]; }
    std::uint64_t numbers_at(std::size_t array) const { return at_[array] + sizeof(std::uint64_t); }
    std::uint64_t tail_at() const { return at_.back(); }
    std::uint64_t file_bytes() const;

private:
    std::vector<VtkArray> arrays_;
    std::string head_;
    std::vector<std::uint64_t> at_; ///< [arrays + 1]
};

/// Whether a text, or what there is of it, begins as these files do.
bool begins_vtk_polydata(std::string_view text);
/// Stamp of a file that is whole from head to tail; none of any other.
struct VtkFound {
    double time;                   ///< s
    std::optional<VtkStamp> stamp; ///< absent in files of earlier programs
};
std::optional<VtkFound> find_vtk_polydata(const std::string& path);
/// True where a file is the frame that was written at a step, as far as it has a stamp.
bool is_sound_vtk_polydata(const std::string& path, std::int64_t step);

/// Writes parts of a file, and adds up their digests.
class VtkParts {
public:
    VtkParts(const std::string& path, int flags) : file_(path, flags) {}
    void write_at(std::uint64_t at, std::string_view part) {
        digest_ += byte_digest(std::as_bytes(std::span(part)), at);
        file_.write_at(at, part);
    }
    std::uint64_t close() {
        file_.close();
        return digest_;
    }

private:
    Descriptor file_;
    std::uint64_t digest_ = 0;
};

/// Polygons in space, each with the number of what it belongs to.
struct PolygonMesh {
    std::vector<Vec3d> points;                      ///< m
    std::vector<std::vector<std::int32_t>> polygon; ///< points of each, in order round it
    std::vector<std::int32_t> number;               ///< of each
};

/// A whole file; the number of polygons is the cell array `name`.
std::pair<VtkPolyData, std::string> vtk_document(const PolygonMesh& mesh, const std::string& name, double time);

} // namespace skein
