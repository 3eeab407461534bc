#include "io/vtk_polydata.hpp"

#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <system_error>

namespace skein {

namespace {

constexpr std::string_view byte_order = std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
constexpr std::string_view type_names[] = {"Int32", "Int64", "Float32", "Float64"};

constexpr std::string_view opening = "<?xml version=\"1.0\"?>\n<!-- skein -->\n<VTKFile type=\"PolyData\" "
                                     "version=\"1.0\" header_type=\"UInt64\" byte_order=";
constexpr std::string_view before_time = "Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">";

/// XML elements around the arrays of each VtkPart.
constexpr std::string_view part_names[] = {"PointData", "CellData", "Points", "Lines", "Polys"};

} // namespace

std::size_t bytes_of(VtkType type) { return type == VtkType::int32 || type == VtkType::float32 ? 4 : 8; }

const std::string VtkPolyData::tail = "\n</AppendedData>\n</VTKFile>\n";

VtkPolyData::VtkPolyData(std::uint64_t points, std::uint64_t lines, std::uint64_t polygons,
                         std::vector<VtkArray> arrays, double time)
    : arrays_(std::move(arrays)) {
    head_ = fmt::format(
        "{}\"{}\">\n<PolyData>\n<FieldData>\n<DataArray type=\"Float64\" {}{:.17g}</DataArray>\n</FieldData>\n"
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" "
        "NumberOfPolys=\"{}\">\n",
        opening, byte_order, before_time, time, points, lines, polygons);
    for (std::size_t part = 0; part < std::size(part_names); ++part) {
        std::string inside;
        std::uint64_t offset = 0;
        for (const VtkArray& array : arrays_) {
            if (to_index(array.part) == part)
                inside +=
                    fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
                                "offset=\"{}\"/>\n",
                                nth(type_names, array.type), array.name, array.components, offset);
            offset += sizeof(std::uint64_t) + array.bytes();
        }
        if (!inside.empty()) head_ += fmt::format("<{0}>\n{1}</{0}>\n", part_names[part], inside);
    }
    head_ += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    at_.push_back(head_.size());
    for (const VtkArray& array : arrays_) at_.push_back(at_.back() + sizeof(std::uint64_t) + array.bytes());
}

std::pair<VtkPolyData, std::string> vtk_document(const PolygonMesh& mesh, const std::string& name, double time) {
    std::vector<std::int32_t> corners, ends;
    for (const auto& polygon : mesh.polygon) {
        corners.insert(corners.end(), polygon.begin(), polygon.end());
        ends.push_back(static_cast<std::int32_t>(corners.size()));
    }
    const VtkPolyData file(mesh.points.size(), 0, mesh.polygon.size(),
                           {{VtkPart::points, "Points", VtkType::float64, 3, mesh.points.size()},
                            {VtkPart::polygons, "connectivity", VtkType::int32, 1, corners.size()},
                            {VtkPart::polygons, "offsets", VtkType::int32, 1, ends.size()},
                            {VtkPart::cell_data, name, VtkType::int32, 1, mesh.number.size()}},
                           time);
    std::vector<double> points;
    for (const Vec3d& p : mesh.points) points.insert(points.end(), {p.x, p.y, p.z});
    std::string text(file.tail_at(), ' ');
    std::memcpy(text.data(), file.head().data(), file.head().size());
    const void* numbers[] = {points.data(), corners.data(), ends.data(), mesh.number.data()};
    for (std::size_t i = 0; i < file.arrays().size(); ++i) {
        const std::uint64_t bytes = file.arrays()[i].bytes();
        std::memcpy(&text[file.count_at(i)], &bytes, sizeof bytes);
        if (bytes > 0) std::memcpy(&text[file.numbers_at(i)], numbers[i], bytes);
    }
    return {file, text};
}

bool begins_vtk_polydata(std::string_view text) { return text.starts_with(opening.substr(0, text.size())); }

std::string VtkStamp::text() const {
    return fmt::format("<!-- step {:020d} after {:020d} digest {:016x} -->\n", step, after, digest);
}

std::optional<VtkStamp> VtkStamp::from(std::string_view text) {
    VtkStamp stamp{};
    const auto number = [text](std::string_view name, auto& value, int base) {
        const std::size_t at = text.find(name);
        if (at == text.npos) return false;
        std::string_view digits = text.substr(at + name.size());
        return std::from_chars(digits.data(), digits.data() + digits.size(), value, base).ec == std::errc();
    };
    if (!number("step ", stamp.step, 10) || !number("after ", stamp.after, 10) || !number("digest ", stamp.digest, 16))
        return {};
    return stamp.text() == text ? std::optional(stamp) : std::nullopt;
}

std::uint64_t VtkPolyData::file_bytes() const { return tail_at() + tail.size() + VtkStamp::bytes; }

std::optional<VtkFound> find_vtk_polydata(const std::string& path) {
    std::array<char, 1024> begin{};
    std::ifstream file(path, std::ios::binary);
    file.read(begin.data(), begin.size());
    const std::string_view text(begin.data(), to_index(file.gcount()));
    const std::size_t at = text.find(before_time);
    if (!text.starts_with(opening) || at == std::string_view::npos) return {};
    VtkFound found{};
    const char* number = text.data() + at + before_time.size();
    if (std::from_chars(number, text.data() + text.size(), found.time).ec != std::errc()) return {};
    std::string end(VtkPolyData::tail.size() + VtkStamp::bytes, ' ');
    file.clear();
    file.seekg(-static_cast<std::streamoff>(end.size()), std::ios::end);
    if (!file.read(end.data(), static_cast<std::streamsize>(end.size()))) return {};
    if (end.ends_with(VtkPolyData::tail)) return found;
    if (end.starts_with(VtkPolyData::tail))
        found.stamp = VtkStamp::from(std::string_view(end).substr(VtkPolyData::tail.size()));
    return found.stamp ? std::optional(found) : std::nullopt;
}

bool is_sound_vtk_polydata(const std::string& path, std::int64_t step) {
    const auto found = find_vtk_polydata(path);
    if (!found) return false;
    if (!found->stamp) return true;
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    auto left = static_cast<std::uint64_t>(file.tellg()) - VtkPolyData::tail.size() - VtkStamp::bytes;
    file.seekg(0);
    std::vector<char> part(std::min<std::uint64_t>(left, 1 << 20));
    std::uint64_t digest = place_digest(found->stamp->step, found->stamp->after);
    for (std::uint64_t at = 0; left > 0;) {
        const std::uint64_t bytes = std::min<std::uint64_t>(left, part.size());
        if (!file.read(part.data(), static_cast<std::streamsize>(bytes))) return false;
        digest += byte_digest(std::as_bytes(std::span(part)).first(bytes), at);
        at += bytes;
        left -= bytes;
    }
    return found->stamp->step == step && found->stamp->digest == digest;
}

} // namespace skein
