#include "io/mesh_file.hpp"

#include "io/csv_table.hpp"
#include "io/files.hpp"
#include "io/text_rows.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

namespace skein {

namespace {

/// Triangles as a file has them.
struct Triangles {
    std::vector<Vec3d> points;
    std::vector<TriangleMesh::Triangle> corners;
    std::vector<std::int64_t> line; ///< by triangle; empty in binary files
};

/// Words of the lines of a text.
class Words {
public:
    Words(const std::string& path, std::string_view text) : path_(path), rest_(text) {}

    bool next_line() {
        while (!rest_.empty()) {
            std::string_view line = rest_.substr(0, rest_.find('\n'));
            rest_.remove_prefix(std::min(rest_.size(), line.size() + 1));
            ++number_;
            line = line.substr(0, line.find('#'));
            words_.clear();
            for (std::size_t begin = 0; (begin = line.find_first_not_of(blank, begin)) != std::string_view::npos;) {
                const std::size_t end = std::min(line.find_first_of(blank, begin), line.size());
                words_.push_back(line.substr(begin, end - begin));
                begin = end;
            }
            if (!words_.empty()) return true;
        }
        return false;
    }
    std::int64_t number() const { return number_; }
    std::size_t count() const { return words_.size(); }
    bool is(std::size_t i, std::string_view word) const {
        return i < words_.size() && words_[i].size() == word.size() &&
               std::equal(word.begin(), word.end(), words_[i].begin(),
                          [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
    }
    std::string_view operator[](std::size_t i) const { return words_[i]; }
    /// Three numbers from word i on.
    Vec3d vector(std::size_t i) const {
        if (words_.size() < i + 3)
            refuse(fmt::format("expected three coordinates, found {}", words_.size() - std::min(i, words_.size())));
        return {number(i), number(i + 1), number(i + 2)};
    }
    [[noreturn]] void refuse(const std::string& fault) const {
        throw InputError(fmt::format("{}:{}: {}", path_, number_, fault));
    }

private:
    static constexpr std::string_view blank = " \t\r\f\v";

    double number(std::size_t i) const {
        const std::optional<double> value = csv_number(words_[i]);
        if (!value) refuse(not_a_number(words_[i]));
        return *value;
    }

    std::string path_;
    std::string_view rest_;
    std::int64_t number_ = 0;
    std::vector<std::string_view> words_;
};

constexpr std::size_t stl_head = 80, stl_record = 50;

/// Number of triangles that a binary STL file announces; none: the file is shorter than its head.
std::optional<std::uint32_t> announced(std::string_view bytes) {
    std::uint32_t count = 0;
    if (bytes.size() < stl_head + sizeof count) return std::nullopt;
    std::memcpy(&count, bytes.data() + stl_head, sizeof count);
    return count;
}
std::size_t size_of_stl(std::size_t triangles) { return stl_head + sizeof(std::uint32_t) + stl_record * triangles; }

Triangles read_binary_stl(const std::string& path, std::string_view bytes) {
    const std::optional<std::uint32_t> count = announced(bytes);
    if (!count)
        throw InputError(fmt::format("{}: no STL file: neither the word 'solid' at its start nor the {} bytes of a "
                                     "binary head",
                                     path, stl_head + sizeof(std::uint32_t)));
    if (bytes.size() != size_of_stl(*count))
        throw InputError(fmt::format("{}: a binary STL file of {} triangles has {} bytes, this one {}: it is cut short "
                                     "or of another kind",
                                     path, *count, size_of_stl(*count), bytes.size()));
    Triangles all;
    for (std::uint32_t t = 0; t < *count; ++t) {
        const char* const record = bytes.data() + size_of_stl(t);
        float numbers[12]; // the normal, then three corners
        std::memcpy(numbers, record, sizeof numbers);
        for (int i = 0; i < 3; ++i) all.points.push_back({numbers[3 + 3 * i], numbers[4 + 3 * i], numbers[5 + 3 * i]});
        all.corners.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return all;
}

Triangles read_text_stl(const std::string& path, std::string_view text) {
    Triangles all;
    Words words(path, text);
    std::int64_t begun = 0; // line of the facet, 0 outside of one
    std::uint32_t corners = 0;
    while (words.next_line()) {
        if (words.is(0, "facet")) {
            if (begun > 0) words.refuse(fmt::format("the facet of line {} has no 'endfacet'", begun));
            begun = words.number();
            corners = 0;
        } else if (words.is(0, "vertex")) {
            if (begun == 0) words.refuse("a 'vertex' outside of a facet");
            all.points.push_back(words.vector(1));
            ++corners;
        } else if (words.is(0, "endfacet")) {
            if (begun == 0 || corners != 3)
                words.refuse(fmt::format("a facet has three corners, this one {}", corners));
            const auto end = static_cast<std::uint32_t>(all.points.size());
            all.corners.push_back({end - 3, end - 2, end - 1});
            all.line.push_back(begun);
            begun = 0;
        } else if (!words.is(0, "solid") && !words.is(0, "endsolid") && !words.is(0, "outer") &&
                   !words.is(0, "endloop"))
            words.refuse(fmt::format("'{}' is no line of an STL file", shown(words[0])));
    }
    if (begun > 0) words.refuse(fmt::format("the file ends within the facet of line {}", begun));
    return all;
}

/// Number of the point that a corner "4", "4/1", "4//2" or "-1" of an OBJ file names.
std::uint32_t point_of(const Words& words, std::size_t i, std::size_t points) {
    const std::string_view word = words[i].substr(0, words[i].find('/'));
    std::int64_t number = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || stop != word.data() + word.size() || number == 0)
        words.refuse(fmt::format("'{}' names no point: expected its number, from 1 on", shown(words[i])));
    const auto count = static_cast<std::int64_t>(points), at = number > 0 ? number - 1 : count + number;
    if (at < 0 || at >= count) words.refuse(fmt::format("point {} of {} points before this line", number, points));
    return static_cast<std::uint32_t>(at);
}

Triangles read_obj(const std::string& path, std::string_view text) {
    Triangles all;
    Words words(path, text);
    while (words.next_line()) {
        if (words.is(0, "v")) all.points.push_back(words.vector(1));
        if (!words.is(0, "f")) continue; // names, materials and normals have no part in the surface
        if (words.count() < 4)
            words.refuse(fmt::format("a face has three corners at least, this one {}", words.count() - 1));
        const std::uint32_t first = point_of(words, 1, all.points.size());
        for (std::size_t i = 2; i + 1 < words.count(); ++i) {
            all.corners.push_back(
                {first, point_of(words, i, all.points.size()), point_of(words, i + 1, all.points.size())});
            all.line.push_back(words.number());
        }
    }
    return all;
}

bool ends_with(std::string_view path, std::string_view ending) {
    if (path.size() < ending.size()) return false;
    path.remove_prefix(path.size() - ending.size());
    return std::equal(ending.begin(), ending.end(), path.begin(),
                      [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

Triangles read_triangles(const std::string& path, std::string_view bytes) {
    if (ends_with(path, ".obj")) return read_obj(path, bytes);
    if (!ends_with(path, ".stl")) throw InputError(fmt::format("{}: files of triangles end in .stl or .obj", path));
    const auto count = announced(bytes); // binary files may begin with "solid" too
    const bool binary = count && bytes.size() == size_of_stl(*count);
    return binary || !bytes.starts_with("solid") ? read_binary_stl(path, bytes) : read_text_stl(path, bytes);
}

} // namespace

std::shared_ptr<const TriangleMesh> read_mesh(const std::string& path, double unit) {
    const std::string bytes = read_file(path);
    Triangles all = read_triangles(path, bytes);
    if (all.corners.empty()) throw InputError(fmt::format("{}: no triangles in it", path));
    for (Vec3d& point : all.points) point = unit * point;
    const auto where = [&](std::size_t t) {
        return all.line.empty() ? fmt::format("{}: triangle {}", path, t + 1) : fmt::format("{}:{}", path, all.line[t]);
    };
    try {
        return std::make_shared<const TriangleMesh>(std::move(all.points), std::move(all.corners), where);
    } catch (const InputError& error) {
        const std::string_view fault = error.what();
        throw InputError(fault.starts_with(path) ? std::string(fault) : fmt::format("{}: {}", path, fault));
    }
}

} // namespace skein
