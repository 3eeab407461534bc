#include "io/segments.hpp"

#include "io/own_files.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace skein {

namespace {

constexpr std::uint64_t slab_bytes = 16 << 20; ///< read at a time

template <class T> std::vector<T> read_all(const H5File& file, const std::string& path) {
    const std::uint64_t count = file.shape(path).at(0);
    std::vector<T> values(count);
    if (count > 0) file.read(path, h5_type<T>(), {{0}, {count}}, values.data());
    return values;
}

template <class Word> std::uint64_t digest_of_words(std::span<const std::byte> bytes, std::uint64_t first) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < bytes.size() / sizeof(Word); ++i) {
        Word word;
        std::memcpy(&word, &bytes[i * sizeof(Word)], sizeof(Word));
        sum += (2 * (first + i) + 1) * std::uint64_t{word};
    }
    return sum;
}

bool is_of_frame(const std::string& path) { return path.starts_with("/groups/"); }

} // namespace

Segment read_segment(const std::string& directory, const std::string& name) {
    const H5File file(Communicator::alone(), directory + "/" + name, H5File::Mode::read);
    const auto format = file.get<std::string>("/", "format");
    if (format != trajectory_format) throw IoError(name + ": is not a trajectory (format \"" + format + "\")");
    Segment segment{name, read_all<std::int64_t>(file, "/step"), read_all<double>(file, "/time"), {}};
    if (segment.steps.size() != segment.times.size() || segment.steps.empty() ||
        !std::is_sorted(segment.steps.begin(), segment.steps.end()))
        throw IoError(name + ": its steps are damaged");
    segment.after = file.find<std::int64_t>("/", "after");
    return segment;
}

std::vector<std::string> frame_datasets(const H5File& file, std::span<const std::string> groups) {
    std::vector<std::string> paths;
    const auto add = [&](const std::string& path) {
        if (file.has(path)) paths.push_back(path);
    };
    for (const char* own : {"/step", "/time", "/digest"}) add(own);
    for (const std::string& group : groups)
        for (const char* field : {"position", "start", "directors", "normal"}) add("/groups/" + group + "/" + field);
    return paths;
}

std::uint64_t word_digest(std::span<const std::byte> bytes, std::size_t word_bytes, std::uint64_t first) {
    return word_bytes == 4 ? digest_of_words<std::uint32_t>(bytes, first)
                           : digest_of_words<std::uint64_t>(bytes, first);
}

std::uint64_t dataset_digest(const H5File& file, const std::string& path, std::optional<std::uint64_t> k) {
    const auto shape = file.shape(path);
    const H5Type type = file.type(path);
    const std::size_t word = bytes_of(type), rows_along = k ? 1 : 0;
    H5Box box{std::vector<std::uint64_t>(shape.size(), 0), shape};
    if (k) {
        box.start[0] = *k;
        box.count[0] = 1;
    }
    std::uint64_t words = 1; // words of a row
    for (std::size_t d = rows_along + 1; d < shape.size(); ++d) words *= shape[d];
    const std::uint64_t rows = std::max<std::uint64_t>(slab_bytes / std::max<std::uint64_t>(words * word, 1), 1);
    std::vector<std::byte> bytes;
    std::uint64_t sum = 0;
    for (std::uint64_t begin = 0; begin < shape.at(rows_along); begin += rows) {
        box.start[rows_along] = begin;
        box.count[rows_along] = std::min(rows, shape[rows_along] - begin);
        bytes.resize(box.count[rows_along] * words * word);
        file.read(path, type, box, bytes.data());
        sum += word_digest(bytes, word, begin * words);
    }
    return sum;
}

std::uint64_t stamp_digest(std::int64_t step, double time) {
    return 1 + static_cast<std::uint64_t>(step) + 3 * std::bit_cast<std::uint64_t>(time);
}

std::size_t first_damaged(const std::string& path, std::span<const std::string> groups, std::size_t k,
                          std::size_t stride) {
    const H5File file(Communicator::alone(), path, H5File::Mode::read);
    const auto steps = read_all<std::int64_t>(file, "/step");
    if (!file.has("/digest")) return steps.size();
    const auto times = read_all<double>(file, "/time");
    const auto written = read_all<std::uint64_t>(file, "/digest");
    const auto datasets = frame_datasets(file, groups);
    for (; k < steps.size(); k += stride) {
        std::uint64_t found = stamp_digest(steps[k], times.at(k));
        try {
            for (const std::string& dataset : datasets)
                if (is_of_frame(dataset)) found += dataset_digest(file, dataset, k);
        } catch (const IoError&) {
            return k;
        }
        if (found != written.at(k)) return k;
    }
    return steps.size();
}

std::string salvage(const std::string& directory, const std::string& temporary, std::span<const std::string> groups) {
    const std::string path = directory + "/" + temporary,
                      name = temporary.substr(0, temporary.size() - std::strlen(".tmp"));
    if (!is_unfinished(path, trajectory_format)) return {};
    const std::string lost = directory + "/lost_" + name;
    std::size_t good = 0;
    try {
        good = first_damaged(path, groups, 0, 1);
    } catch (const IoError&) { // its tables are unreadable
    }
    const std::string now = set_aside(path, good > 0 ? lost : lost + ".unreadable");
    return good > 0 ? fmt::format("{}: {} good frame{} of a killed run, renamed to {}", temporary, good,
                                  good == 1 ? "" : "s", now)
                    : fmt::format("{}: file of a killed run without a whole frame, renamed to {}", temporary, now);
}

} // namespace skein
