// Files of rods as comma-separated values, whose first line names the columns.
#include "io/csv_table.hpp"
#include "io/rod_file_kind.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <utility>

namespace skein {

namespace {

class CsvRodFile final : public RodFile {
public:
    explicit CsvRodFile(const std::string& path) : RodFile(path) {
        std::ifstream file(path_, std::ios::binary);
        if (!file) refuse("cannot be opened for reading");
        std::string line;
        std::getline(file, line);
        read_header(line);
        std::int64_t at = static_cast<std::int64_t>(line.size()) + 1;
        // Finds the beginnings of blocks of lines, without empty lines.
        std::vector<char> buffer(1 << 20);
        bool begins = true;
        while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), file.gcount() > 0) {
            for (std::int64_t i = 0; i < file.gcount(); ++i) {
                if (begins && nth(buffer, i) != '\n' && nth(buffer, i) != '\r') {
                    if (count_ % block == 0) block_begin_.push_back(at + i);
                    ++count_;
                }
                begins = nth(buffer, i) == '\n';
            }
            at += file.gcount();
        }
        check_quantities();
    }

private:
    static constexpr std::int64_t block = 1 << 12;

    void read_header(const std::string& line) {
        for (const std::string_view name : csv_cells(line)) {
            bool known = false;
            for (std::size_t q = 0; q < std::size(quantities); ++q)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (!name.empty() && quantities[q].columns[axis] == name) {
                        if (std::find(named_.begin(), named_.end(), std::pair(q, axis)) != named_.end())
                            throw InputError(fmt::format("{}:1: two columns '{}'", path_, name));
                        named_.emplace_back(q, axis);
                        known = true;
                    }
            if (!known)
                throw InputError(
                    fmt::format("{}:1: unknown column '{}'; the first line names x, y, z and, if rods differ in them, "
                                "tx, ty, tz, nx, ny, nz, length, radius",
                                path_, name));
        }
        for (std::size_t q = 0; q < std::size(quantities); ++q) {
            const auto axes = std::count_if(named_.begin(), named_.end(), [q](const auto& c) { return c.first == q; });
            if (axes != 0 && axes != static_cast<std::ptrdiff_t>(quantities[q].components))
                throw InputError(fmt::format("{}:1: {} has only {} of three columns: {}", path_, quantities[q].name,
                                             axes, fmt::join(quantities[q].columns, ", ")));
            has_[q] = axes != 0;
        }
    }

    void read_numbers(std::int64_t begin, std::int64_t end, Numbers& numbers) const override {
        std::ifstream file(path_, std::ios::binary);
        file.seekg(nth(block_begin_, begin / block));
        std::string line;
        for (std::int64_t rod = begin / block * block; rod < end; ++rod) {
            do {
                if (!std::getline(file, line)) refuse(fmt::format("row {}: the file has been cut short", rod));
                if (line.ends_with('\r')) line.pop_back();
            } while (line.empty());
            if (rod < begin) continue;
            const auto cells = csv_cells(line);
            if (cells.size() != named_.size())
                refuse(named_.front().first, rod,
                       fmt::format("expected {} values by the first line, found {}", named_.size(), cells.size()));
            for (std::size_t c = 0; c < cells.size(); ++c) {
                const auto [q, axis] = named_[c];
                const std::optional<double> value = csv_number(cells[c]);
                if (!value) refuse(q, rod, fmt::format("'{}' is not a number", quantities[q].columns[axis]));
                numbers[q][to_index(rod - begin) * width(q) + axis] = *value;
            }
        }
    }
    std::string place(std::size_t quantity, std::int64_t rod) const override {
        return fmt::format("{}: row {} below the names: {}", path_, rod + 1, quantities[quantity].name);
    }

    std::vector<std::pair<std::size_t, std::size_t>> named_; ///< quantity and axis
    std::vector<std::int64_t> block_begin_;                  ///< offset of each block of lines
};

} // namespace

std::shared_ptr<const RodSource> open_csv_rods(const std::string& path) { return std::make_shared<CsvRodFile>(path); }

} // namespace skein
