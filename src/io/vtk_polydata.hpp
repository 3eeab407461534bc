// VTK's poly data files (.vtp): a head of XML, then the raw numbers of each array ("appended"), each after the count of
// its bytes. Offsets of arrays are known before writing, so ranks write their parts in parallel.
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

/// Place of a file's frame in its series, as an XML comment after the last tag.
struct VtkStamp {
    std::int64_t step, after; ///< steps of this frame and of the one before, -1: none
    std::uint64_t digest;     ///< byte_digest of everything before the tail, plus place_digest

    static constexpr std::size_t bytes = 86;
    std::string text() const;
    static std::optional<VtkStamp> from(std::string_view text);
};

/// Layout of one file: its head, and the offsets of its arrays.
class VtkPolyData {
public:
    VtkPolyData(std::uint64_t points, std::uint64_t lines, std::uint64_t polygons, std::vector<VtkArray> arrays,
                double time);

    const std::vector<VtkArray>& arrays() const { return arrays_; }
    const std::string& head() const { return head_; }
    static const std::string tail;
    /// Offset in the file of the count of bytes before an array.
    std::uint64_t count_at(std::size_t array) const { return at_[array]; }
    /// Offset in the file of the numbers of an array.
    std::uint64_t numbers_at(std::size_t array) const { return at_[array] + sizeof(std::uint64_t); }
    std::uint64_t tail_at() const { return at_.back(); }
    std::uint64_t file_bytes() const;

private:
    std::vector<VtkArray> arrays_;
    std::string head_;
    std::vector<std::uint64_t> at_; ///< [arrays + 1]
};

/// True if a text, which may be cut short, begins like these files.
bool begins_vtk_polydata(std::string_view text);
struct VtkFound {
    double time;                   ///< s
    std::optional<VtkStamp> stamp; ///< absent in files of earlier programs
};
/// Time and stamp of a file that is complete from head to tail.
std::optional<VtkFound> find_vtk_polydata(const std::string& path);
/// True if a file is complete, and its stamp has the step and the right digest.
bool is_sound_vtk_polydata(const std::string& path, std::int64_t step);

/// Writes parts of a file and adds their digests.
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

/// Polygons in space, each with the number of its owner.
struct PolygonMesh {
    std::vector<Vec3d> points;                      ///< m
    std::vector<std::vector<std::int32_t>> polygon; ///< points in cyclic order
    std::vector<std::int32_t> number;               ///< number of the owner of each polygon
};

/// Layout and text of a whole file; the numbers of polygons are the cell array `name`.
std::pair<VtkPolyData, std::string> vtk_document(const PolygonMesh& mesh, const std::string& name, double time);

} // namespace skein
