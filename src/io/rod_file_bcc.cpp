// Binary curve collections (BCC) of yarns: open curves, and closed ones, which rings take.
//   header of 64 bytes   "BCC", 0x44 (bytes of integers and floats), "C" and its parameterisation, 3 dimensions, axis
//                        that points up, two uint64: curves and points in all, 40 bytes of text
//   each curve           int32: its points, below 0 if it is closed; float32 [points, 3]
// Numbers are little-endian (docs/references.md, cycodebase).
#include "io/point_file.hpp"
#include "io/rod_file_kind.hpp"
#include "io/text_rows.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>

namespace skein {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers of the file are read as they lie there");

class BccFile final : public PointFile {
public:
    BccFile(const std::string& path, const RodFileOptions& options)
        : PointFile(path, options.elements, options.placement.unit), closed_(options.closed),
          file_(path, std::ios::binary) {
        if (!file_) refuse("cannot be opened for reading");
        if (!options.placement.id.empty())
            refuse(fmt::format("has no columns: placement.id = \"{}\" is for text", shown(options.placement.id)));
        read_header();
        find_curves();
        choose(options.placement.ignore);
    }

private:
    static constexpr std::int64_t header_bytes = 64, count_bytes = 4, point_bytes = 12;
    struct Curve {
        std::int64_t offset; ///< byte of its first point
        std::int64_t points; ///< in the file: without the first one again, of closed curves
        std::int64_t number; ///< in the file
    };

    /// Bytes from `offset` on, which must be there.
    template <class T> void get(std::int64_t offset, T* into, std::size_t count, const std::string& what) const {
        const auto bytes = static_cast<std::streamsize>(count * sizeof(T));
        file_.clear();
        file_.seekg(offset);
        file_.read(reinterpret_cast<char*>(into), bytes);
        if (file_.gcount() != bytes) refuse(fmt::format("is cut short: {} ends behind the file", what));
    }

    void read_header() {
        std::array<char, header_bytes> header{};
        get(0, header.data(), header.size(), "the header of 64 bytes");
        if (std::string_view(header.data(), 3) != "BCC") refuse("does not begin with 'BCC'");
        if (const auto sizes = static_cast<unsigned char>(header[3]); sizes != 0x44)
            refuse(fmt::format("has integers and floats of {} and {} bytes; those of 4 bytes are read", sizes >> 4,
                               sizes & 0xf));
        if (header[4] != 'C')
            refuse(fmt::format("holds curves of type '{}'; those through their points, 'C', are read",
                               shown({&header[4], 1})));
        if (header[6] != 3) refuse(fmt::format("holds curves in {} dimensions; those in 3 are read", int{header[6]}));
        std::memcpy(&curves_, &header[8], sizeof curves_);
        std::memcpy(&points_, &header[16], sizeof points_);
    }

    /// Walks over all curves, whose points must fill the file.
    void find_curves() {
        file_.seekg(0, std::ios::end);
        const auto size = static_cast<std::int64_t>(file_.tellg());
        if (curves_ > static_cast<std::uint64_t>(size / count_bytes) ||
            points_ > static_cast<std::uint64_t>(size / point_bytes))
            refuse(fmt::format("is cut short: the header counts {} curves with {} points, and the file has {} bytes",
                               curves_, points_, size));
        std::int64_t at = header_bytes;
        std::uint64_t points = 0;
        for (std::int64_t number = 0; number < static_cast<std::int64_t>(curves_); ++number) {
            std::int32_t count = 0;
            get(at, &count, 1, fmt::format("curve {}", number));
            const Curve curve{at + count_bytes, std::abs(static_cast<std::int64_t>(count)), number};
            at = curve.offset + point_bytes * curve.points;
            if (at > size)
                refuse(fmt::format("is cut short: curve {} of {} points ends behind the file", number, count));
            (count < 0 ? of_rings_ : of_rods_).push_back(curve);
            points += static_cast<std::uint64_t>(curve.points);
        }
        if (points != points_)
            refuse(fmt::format("holds curves with {} points, and its header counts {}", points, points_));
        if (at != size) refuse(fmt::format("has {} bytes behind its last curve", size - at));
    }

    /// Takes the curves of the group's kind. Others must be ignored by name.
    void choose(const std::vector<std::string>& ignore) {
        const std::string_view others = closed_ ? "open" : "closed";
        for (const std::string& name : ignore)
            if (name != others)
                refuse(
                    fmt::format("placement.ignore = [\"{}\"]: here it takes \"{}\", the curves that this group leaves "
                                "out",
                                shown(name), others));
        const std::vector<Curve>& left = closed_ ? of_rods_ : of_rings_;
        if (!left.empty() && ignore.empty())
            refuse(fmt::format("curve {} is {}: a group with shape.closed = {} takes such curves; placement.ignore = "
                               "[\"{}\"] leaves them out of this one",
                               left.front().number, others, !closed_, others));
        if (closed_) of_rods_.swap(of_rings_);
        of_rings_ = {};
        count_ = static_cast<std::int64_t>(of_rods_.size());
        if (count_ == 0) refuse(fmt::format("it contains no {}", closed_ ? "closed curves" : "rods"));
    }

    void read_points(std::int64_t begin, std::int64_t end, const Threads*, const TakeRods& take) const override {
        RodPoints rods;
        for (std::int64_t first = begin; first < end;) {
            std::vector<std::int64_t> first_point = {0};
            std::int64_t past = first;
            while (past < end && (past == first || first_point.back() < most_points))
                first_point.push_back(first_point.back() + nth(of_rods_, past++).points + (closed_ ? 1 : 0));
            make_room(rods, first_point);
            for (std::int64_t rod = first; rod < past; ++rod) read_curve(rod, &rods.points[rods.first[rod - first]]);
            take(first, rods);
            first = past;
        }
    }

    void read_curve(std::int64_t rod, Vec3d* into) const {
        const Curve& curve = nth(of_rods_, rod);
        const std::size_t points = to_index(curve.points);
        numbers_.resize(3 * points);
        get(curve.offset, numbers_.data(), numbers_.size(), name(rod));
        for (std::size_t i = 0; i < points; ++i) into[i] = {numbers_[3 * i], numbers_[3 * i + 1], numbers_[3 * i + 2]};
        if (closed_ && points > 0) into[points] = into[0];
    }

    std::string place(std::int64_t rod, std::int64_t point) const override {
        return fmt::format("{}: {}, row {}", path_, name(rod), std::max<std::int64_t>(point, 0));
    }
    std::string name(std::int64_t rod) const override { return fmt::format("curve {}", nth(of_rods_, rod).number); }

    bool closed_;
    mutable std::ifstream file_;
    mutable std::vector<float> numbers_;
    std::uint64_t curves_ = 0, points_ = 0; ///< by the header
    std::vector<Curve> of_rods_, of_rings_; ///< those of this group, and others until they are left out
};

} // namespace

std::shared_ptr<const RodSource> open_bcc_rods(const std::string& path, const RodFileOptions& options) {
    return std::make_shared<BccFile>(path, options);
}

} // namespace skein
