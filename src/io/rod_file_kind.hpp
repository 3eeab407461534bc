// Quantities of files with a row per rod, and checks of their numbers.
#pragma once

#include "io/array_file.hpp"
#include "io/csv_header.hpp"
#include "skein/placement/places.hpp"

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Quantity that a file may have for its rods.
struct RodQuantity {
    enum class Per { rod, node, element };
    std::string_view name;
    Per per;
    std::size_t components;
    std::array<std::string_view, 3> columns = {}; ///< names in comma-separated values; empty for quantities along a rod
};

class RodFile : public RodSource {
public:
    using Per = RodQuantity::Per;
    static constexpr RodQuantity quantities[] = {{"origin", Per::rod, 3, {"x", "y", "z"}},
                                                 {"tangent", Per::rod, 3, {"tx", "ty", "tz"}},
                                                 {"normal", Per::rod, 3, {"nx", "ny", "nz"}},
                                                 {"length", Per::rod, 1, {"length"}},
                                                 {"radius", Per::rod, 1, {"radius"}},
                                                 {"nodes", Per::node, 3},
                                                 {"directors", Per::element, 9},
                                                 {"radii", Per::node, 1}};
    enum Which : std::size_t { origin, tangent, normal, length, radius, nodes, directors, radii, all };
    static_assert(std::size(quantities) == all);
    /// Numbers of consecutive rods by quantity; empty for absent quantities.
    using Numbers = std::array<std::vector<double>, all>;

    RodFile(std::string path, double unit) : path_(std::move(path)), unit_(unit) {}
    std::int64_t count() const override { return count_; }
    std::int64_t elements() const override { return static_cast<std::int64_t>(elements_); }
    RodColumns columns() const override;
    RodRows read(std::int64_t begin, std::int64_t end, const Threads* threads) const override;

protected:
    virtual void read_numbers(std::int64_t begin, std::int64_t end, Numbers& numbers) const = 0;
    virtual std::string place(std::size_t quantity, std::int64_t rod) const = 0;
    std::size_t width(std::size_t q) const; ///< numbers for a rod
    [[noreturn]] void refuse(std::size_t quantity, std::int64_t rod, const std::string& what) const;
    [[noreturn]] void refuse(const std::string& what) const;
    void check_quantities() const; ///< checks which quantities there are together

    std::string path_;
    std::int64_t count_ = 0;
    std::size_t elements_ = 0; ///< elements of a rod, if quantities lie along it
    std::array<bool, all> has_{};

private:
    void check_frame(std::int64_t rod, std::size_t i, const RodRows& rows) const;
    void trace(std::int64_t rod, std::size_t i, const Numbers& numbers, RodRows& rows) const;

    double unit_; ///< m
};

/// Keys of a scene about a file of rods.
struct RodFileOptions {
    const Placement& placement;
    std::int64_t elements; ///< of a rod
    bool closed;           ///< rods are rings
};

/// A row per rod or, where the header has an id, per point.
std::shared_ptr<const RodSource> open_text_rods(const std::string& path, const RodFileOptions& options);
std::shared_ptr<const RodSource> open_csv_points(const CsvHeader& header, const RodFileOptions& options);
std::shared_ptr<const RodSource> open_array_rods(std::unique_ptr<ArrayFile> file, const RodFileOptions& options);
std::shared_ptr<const RodSource> open_swc_rods(const std::string& path, const RodFileOptions& options);
std::shared_ptr<const RodSource> open_bcc_rods(const std::string& path, const RodFileOptions& options);

} // namespace skein
