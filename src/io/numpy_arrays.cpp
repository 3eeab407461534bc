// Arrays of NumPy's files: `.npy`, and `.npz`, which is a ZIP archive of them. Compressed arrays are unpacked into
// memory. Pickled objects are refused, so that no file runs code.
#include "core/memory.hpp"
#include "core/share_text.hpp"
#include "io/array_file.hpp"
#include "io/text_rows.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>

namespace skein {

namespace {

/// Bytes of a file, each read within its size.
class ByteFile {
public:
    explicit ByteFile(const std::string& path) : file_(path, std::ios::binary | std::ios::ate), path_(path) {
        if (!file_) throw InputError(fmt::format("{}: cannot be opened for reading", path));
        size_ = static_cast<std::uint64_t>(file_.tellg());
    }
    std::uint64_t size() const { return size_; }
    /// Throws where the file ends before.
    void read(std::uint64_t offset, std::span<char> into) {
        if (offset > size_ || into.size() > size_ - offset)
            throw InputError(fmt::format("{}: has been cut short: it ends at byte {}", path_, size_));
        file_.clear();
        file_.seekg(static_cast<std::streamoff>(offset));
        file_.read(into.data(), static_cast<std::streamsize>(into.size()));
        if (!file_) throw InputError(fmt::format("{}: bytes behind {} cannot be read", path_, offset));
    }
    std::string text(std::uint64_t offset, std::uint64_t bytes) {
        if (bytes > size_) read(offset, std::span<char>(static_cast<char*>(nullptr), bytes)); // throws
        std::string found(bytes, '\0');
        read(offset, found);
        return found;
    }

private:
    std::ifstream file_;
    std::string path_;
    std::uint64_t size_ = 0;
};

/// Number of so many bytes, the lowest first.
std::uint64_t little(std::string_view bytes, std::size_t at, std::size_t count) {
    std::uint64_t value = 0;
    for (std::size_t i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
}

/// Layout of one array.
struct NumpyArray {
    ArrayFile::Shape shape;
    char kind = 'f';       ///< f, i or u
    std::size_t bytes = 8; ///< of a number
    bool swapped = false;  ///< the highest byte comes first
    std::uint64_t begin = 0;
    std::string fault; ///< why it cannot be read; empty: it can
    /// Bytes of a compressed array's file, in which it begins at `begin`; null: it lies in the archive.
    std::shared_ptr<const std::vector<char>> unpacked = {};
};

/// The value of a key in the header of an array, a Python dictionary of three entries; none where it is not there.
std::optional<std::string_view> header_value(std::string_view header, std::string_view key) {
    for (const char quote : {'\'', '"'}) {
        const std::string quoted = fmt::format("{}{}{}", quote, key, quote);
        const std::size_t at = header.find(quoted);
        if (at == std::string_view::npos) continue;
        std::string_view rest = header.substr(at + quoted.size());
        rest.remove_prefix(std::min(rest.find_first_not_of(" :"), rest.size()));
        return rest;
    }
    return std::nullopt;
}

/// The type of numbers from a text such as '<f8'.
void take_type(std::string_view text, NumpyArray& array) {
    if (text.starts_with('[')) {
        array.fault = "holds records; save each field as an array of its own";
        return;
    }
    if (text.size() < 2 || (text[0] != '\'' && text[0] != '"')) {
        array.fault = "has no type of numbers";
        return;
    }
    const std::size_t end = text.find(text[0], 1);
    const std::string_view type = text.substr(1, end == std::string_view::npos ? end : end - 1);
    if (type.find('O') != std::string_view::npos) {
        array.fault = "holds Python objects, which are not read; save an array of numbers (lists of unequal lengths: "
                      "points and offsets)";
        return;
    }
    constexpr std::string_view known[] = {"f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"};
    const std::string_view number = type.substr(std::min<std::size_t>(type.size(), 1));
    if (type.empty() || std::string_view("<>|=").find(type[0]) == std::string_view::npos ||
        std::find(std::begin(known), std::end(known), number) == std::end(known)) {
        array.fault =
            fmt::format("has the type '{}', which is neither a float of 32 or 64 bits nor an integer", shown(type));
        return;
    }
    array.kind = number[0];
    array.bytes = static_cast<std::size_t>(number[1] - '0');
    array.swapped = type[0] == '>' && array.bytes > 1;
    static_assert(std::endian::native == std::endian::little);
}

void take_shape(std::string_view text, NumpyArray& array) {
    const std::size_t end = text.find(')');
    if (!text.starts_with('(') || end == std::string_view::npos) {
        array.fault = "has no shape";
        return;
    }
    text = text.substr(1, end - 1);
    while (!text.empty()) {
        const std::size_t comma = std::min(text.find(','), text.size());
        std::string_view one = text.substr(0, comma);
        text.remove_prefix(std::min(comma + 1, text.size()));
        while (one.starts_with(' ')) one.remove_prefix(1);
        while (one.ends_with(' ') || one.ends_with('L')) one.remove_suffix(1);
        if (one.empty() && text.empty()) break;
        std::uint64_t size = 0;
        const auto [stop, error] = std::from_chars(one.data(), one.data() + one.size(), size);
        if (error != std::errc{} || stop != one.data() + one.size()) {
            array.fault = fmt::format("has a shape with '{}'", shown(one));
            return;
        }
        array.shape.push_back(size);
    }
}

/// Bytes of its numbers; none where they are more than any file has.
std::optional<std::uint64_t> bytes_of(const NumpyArray& array) {
    std::uint64_t bytes = array.bytes;
    for (const std::uint64_t size : array.shape)
        if (__builtin_mul_overflow(bytes, size, &bytes)) return std::nullopt;
    return bytes;
}

/// Bytes in memory, read like those of a file.
struct ByteList {
    std::span<const char> bytes;
    std::string text(std::uint64_t offset, std::uint64_t count) const {
        return {bytes.data() + offset, bytes.data() + offset + count};
    }
};

/// The array whose `.npy` lies at [begin, begin + length) of a file or of a list.
template <class Bytes> NumpyArray read_array(Bytes& file, std::uint64_t begin, std::uint64_t length) {
    NumpyArray array;
    if (length < 12 || file.text(begin, 6) != "\x93NUMPY") {
        array.fault = "is no array of NumPy";
        return array;
    }
    const std::string head = file.text(begin, 12);
    const bool long_header = head[6] > 1;
    const std::uint64_t header_bytes = little(head, 8, long_header ? 4 : 2), first = long_header ? 12 : 10;
    if (head[6] < 1 || head[6] > 3 || header_bytes > length - first || header_bytes > (1 << 20)) {
        array.fault = "has a damaged header";
        return array;
    }
    const std::string header = file.text(begin + first, header_bytes);
    array.begin = begin + first + header_bytes;
    const auto type = header_value(header, "descr"), order = header_value(header, "fortran_order"),
               shape = header_value(header, "shape");
    if (!type || !order || !shape) {
        array.fault = "has a damaged header";
        return array;
    }
    take_type(*type, array);
    if (!array.fault.empty()) return array;
    take_shape(*shape, array);
    if (!array.fault.empty()) return array;
    if (order->starts_with("True") && array.shape.size() > 1)
        array.fault = "is in Fortran's order; save numpy.ascontiguousarray of it";
    const auto bytes = bytes_of(array);
    if (!bytes || *bytes > length - first - header_bytes)
        array.fault = fmt::format("has been cut short: its shape [{}] needs more bytes than there are",
                                  fmt::join(array.shape, ", "));
    return array;
}

/// Entry of a ZIP archive.
struct ZipEntry {
    std::string name;
    std::uint64_t method; ///< 0: stored, 8: deflated
    bool encrypted;
    std::uint64_t local, packed, size; ///< place of its head, bytes in the archive, and of its content
    std::uint64_t check;               ///< CRC-32 of the content
    static constexpr std::uint64_t stored = 0, deflated = 8;
};

/// Content of a deflated entry; empty where its bytes are damaged.
std::vector<char> inflated(std::span<char> packed, const ZipEntry& entry) {
    std::vector<char> content(entry.size);
    z_stream stream{};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
    constexpr std::size_t most = std::numeric_limits<uInt>::max();
    std::size_t taken = 0, made = 0;
    int status = Z_OK;
    while (status == Z_OK) {
        const std::size_t in = std::min(most, packed.size() - taken), out = std::min(most, content.size() - made);
        stream.next_in = reinterpret_cast<Bytef*>(packed.data() + taken);
        stream.next_out = reinterpret_cast<Bytef*>(content.data() + made);
        stream.avail_in = static_cast<uInt>(in);
        stream.avail_out = static_cast<uInt>(out);
        status = inflate(&stream, Z_NO_FLUSH);
        taken += in - stream.avail_in;
        made += out - stream.avail_out;
    }
    inflateEnd(&stream);
    if (status != Z_STREAM_END || made != content.size()) return {};
    uLong check = crc32(0, nullptr, 0);
    for (std::size_t at = 0; at < content.size(); at += most)
        check = crc32(check, reinterpret_cast<const Bytef*>(content.data() + at),
                      static_cast<uInt>(std::min(most, content.size() - at)));
    return check == entry.check ? content : std::vector<char>();
}

/// Entries of a ZIP archive.
class ZipDirectory {
public:
    ZipDirectory(ByteFile& file, const std::string& path) : file_(file), path_(path) { find_directory(); }

    template <class F> void for_each(F&& f) {
        std::uint64_t at = begin_;
        for (std::uint64_t i = 0; i < entries_; ++i) {
            const std::string head = file_.text(at, 46);
            if (little(head, 0, 4) != 0x02014b50) refuse("is damaged: its list of arrays cannot be read");
            const std::uint64_t name = little(head, 28, 2), extra = little(head, 30, 2), comment = little(head, 32, 2);
            const std::string text = file_.text(at + 46, name + extra);
            std::uint64_t packed = little(head, 20, 4), size = little(head, 24, 4), local = little(head, 42, 4);
            take_long_sizes(std::string_view(text).substr(name), {&size, &packed, &local});
            f({.name = text.substr(0, name),
               .method = little(head, 10, 2),
               .encrypted = (little(head, 8, 2) & 1) != 0,
               .local = local,
               .packed = packed,
               .size = size,
               .check = little(head, 16, 4)});
            at += 46 + name + extra + comment;
        }
    }
    /// First byte of an entry's data.
    std::uint64_t data(std::uint64_t local) {
        const std::string head = file_.text(local, 30);
        if (little(head, 0, 4) != 0x04034b50) refuse("is damaged: an array is not where its list says");
        return local + 30 + little(head, 26, 2) + little(head, 28, 2);
    }

private:
    [[noreturn]] void refuse(const std::string& what) const { throw InputError(fmt::format("{}: {}", path_, what)); }

    void find_directory() {
        const std::uint64_t tail = std::min<std::uint64_t>(file_.size(), 65557);
        const std::string text = file_.text(file_.size() - tail, tail);
        const std::size_t end = text.rfind("PK\x05\x06");
        if (end == std::string::npos || end + 22 > text.size())
            refuse("is no .npz file, or has been cut short: its list of arrays is missing");
        entries_ = little(text, end + 10, 2);
        begin_ = little(text, end + 16, 4);
        if (begin_ != 0xffffffff && entries_ != 0xffff) return;
        if (end < 20 || little(text, end - 20, 4) != 0x07064b50) refuse("is damaged: its list of arrays is missing");
        const std::string record = file_.text(little(text, end - 12, 8), 56);
        if (little(record, 0, 4) != 0x06064b50) refuse("is damaged: its list of arrays is missing");
        entries_ = little(record, 32, 8);
        begin_ = little(record, 48, 8);
    }

    /// Numbers that do not fit 32 bits stand in an extra field, in this order.
    static void take_long_sizes(std::string_view extra, std::array<std::uint64_t*, 3> numbers) {
        while (extra.size() >= 4) {
            const std::uint64_t kind = little(extra, 0, 2), bytes = little(extra, 2, 2);
            if (bytes > extra.size() - 4) return;
            std::size_t at = 4;
            for (std::uint64_t* number : numbers)
                if (kind == 1 && *number == 0xffffffff && at + 8 <= 4 + bytes) {
                    *number = little(extra, at, 8);
                    at += 8;
                }
            extra.remove_prefix(4 + bytes);
        }
    }

    ByteFile& file_;
    std::string path_;
    std::uint64_t begin_ = 0, entries_ = 0;
};

template <class T> void as_numbers(std::span<const char> bytes, bool swapped, double* into) {
    for (std::size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T)) {
        std::array<char, sizeof(T)> one;
        std::memcpy(one.data(), &bytes[i], sizeof(T));
        if (swapped) std::reverse(one.begin(), one.end());
        *into++ = static_cast<double>(std::bit_cast<T>(one));
    }
}

void as_numbers(const NumpyArray& array, std::span<const char> bytes, double* into) {
    const auto as = [&]<class T>(T) { as_numbers<T>(bytes, array.swapped, into); };
    const bool is_signed = array.kind == 'i';
    if (array.kind == 'f') return array.bytes == 4 ? as(float{}) : as(double{});
    switch (array.bytes) {
    case 1:
        return is_signed ? as(std::int8_t{}) : as(std::uint8_t{});
    case 2:
        return is_signed ? as(std::int16_t{}) : as(std::uint16_t{});
    case 4:
        return is_signed ? as(std::int32_t{}) : as(std::uint32_t{});
    default:
        return is_signed ? as(std::int64_t{}) : as(std::uint64_t{});
    }
}

class NumpyArrays final : public ArrayFile {
public:
    explicit NumpyArrays(const std::string& path) : ArrayFile(path) {
        ByteFile file(path);
        if (path.ends_with(".npy")) arrays_["points"] = read_array(file, 0, file.size());
        else read_archive(file);
    }
    std::string_view word() const override { return "array"; }
    std::vector<std::string> names() const override {
        std::vector<std::string> all;
        for (const auto& [name, array] : arrays_) all.push_back(name);
        return all;
    }
    Shape shape(const std::string& name) const override { return sound(name).shape; }

    void read(const std::string& name, std::int64_t begin, std::int64_t rows, double* into) const override {
        const NumpyArray& array = sound(name);
        std::uint64_t row = array.bytes;
        for (std::size_t d = 1; d < array.shape.size(); ++d) row *= array.shape[d];
        if (row == 0) return;
        const std::uint64_t at_once = std::max<std::uint64_t>(1, (1 << 22) / row);
        ByteFile file(path());
        std::vector<char> bytes;
        for (std::uint64_t done = 0; done < static_cast<std::uint64_t>(rows);) {
            const std::uint64_t some = std::min(at_once, static_cast<std::uint64_t>(rows) - done);
            const std::uint64_t first = array.begin + (static_cast<std::uint64_t>(begin) + done) * row;
            double* to = into + done * (row / array.bytes);
            if (array.unpacked) {
                as_numbers(array, std::span(*array.unpacked).subspan(first, some * row), to);
            } else {
                bytes.resize(some * row);
                file.read(first, bytes);
                as_numbers(array, bytes, to);
            }
            done += some;
        }
    }

private:
    void read_archive(ByteFile& file) {
        ZipDirectory archive(file, path());
        archive.for_each([&](const ZipEntry& one) {
            std::string name = one.name;
            if (name.ends_with(".npy")) name.resize(name.size() - 4);
            if (arrays_.contains(name)) refuse(fmt::format("has two arrays '{}'", shown(name)));
            NumpyArray& array = arrays_[name];
            if (one.encrypted) array.fault = "is encrypted";
            else if (one.method != ZipEntry::stored && one.method != ZipEntry::deflated)
                array.fault = "is compressed by a method that is not read: save it by numpy.savez_compressed";
            else array = entry(file, archive.data(one.local), one);
        });
    }
    NumpyArray entry(ByteFile& file, std::uint64_t begin, const ZipEntry& one) const {
        constexpr std::uint64_t most_times = 1032; // which deflation makes of a byte
        if (begin > file.size() || one.packed > file.size() - begin)
            refuse("has been cut short: an array lies beyond its end");
        if (one.method == ZipEntry::stored) return read_array(file, begin, one.packed);
        NumpyArray array;
        array.fault = "is damaged: it cannot be unpacked";
        if (one.size / most_times > one.packed) return array;
        if (const double free = free_memory(); static_cast<double>(one.size) > free) {
            array.fault = fmt::format("is compressed and needs {} of memory, but {} are free",
                                      bytes_text(static_cast<double>(one.size)), bytes_text(free));
            return array;
        }
        std::vector<char> packed(one.packed);
        file.read(begin, packed);
        auto content = std::make_shared<const std::vector<char>>(inflated(packed, one));
        if (content->empty()) return array;
        const ByteList list{*content};
        array = read_array(list, 0, content->size());
        array.unpacked = std::move(content);
        return array;
    }

    const NumpyArray& sound(const std::string& name) const {
        const NumpyArray& array = arrays_.at(name);
        if (!array.fault.empty()) refuse(fmt::format("array '{}' {}", shown(name), array.fault));
        return array;
    }

    std::map<std::string, NumpyArray> arrays_;
};

} // namespace

std::unique_ptr<ArrayFile> open_numpy_arrays(const std::string& path) { return std::make_unique<NumpyArrays>(path); }

} // namespace skein
