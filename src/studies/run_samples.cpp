#include "studies/run_samples.hpp"

#include "io/csv_table.hpp"
#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/h5_file.hpp"
#include "io/segments.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>

namespace skein {

namespace {

/// Columns of the search, of round-off, and of the elements themselves.
constexpr std::array<std::string_view, 6> bookkeeping = {
    "max_director_defect", "energy_defect", "candidates", "rebuilds", "skin", "max_turn_per_cell"};

/// "centre_x[m]" and the next two are one quantity; so is any other by itself. `solved`: sums over steps have no value,
/// and are left out.
std::vector<Quantity> quantities_of(const CsvTable& table, std::span<const std::size_t> rows, bool solved) {
    std::vector<Quantity> out;
    const auto is = [&](std::size_t c, const std::string& stem, char axis, const std::string& unit) {
        return c < table.names.size() && table.names[c] == stem + "_" + axis + unit;
    };
    for (std::size_t c = 2; c < table.names.size(); ++c) {
        const std::size_t bracket = std::min(table.names[c].find('['), table.names[c].size());
        const std::string name = table.names[c].substr(0, bracket), unit = table.names[c].substr(bracket);
        const std::string stem = name.ends_with("_x") ? name.substr(0, name.size() - 2) : "";
        Quantity q{name, unit.empty() ? "" : unit.substr(1, unit.size() - 2), 1, {}};
        if (!stem.empty() && is(c + 1, stem, 'y', unit) && is(c + 2, stem, 'z', unit)) {
            q.name = stem;
            q.components = 3;
        }
        for (const std::size_t row : rows)
            for (std::size_t k = 0; k < q.components; ++k) q.values.push_back(table.columns[c + k][row]);
        c += q.components - 1;
        const bool known =
            !solved || std::all_of(q.values.begin(), q.values.end(), [](double x) { return std::isfinite(x); });
        if (known && std::find(bookkeeping.begin(), bookkeeping.end(), q.name) == bookkeeping.end())
            out.push_back(std::move(q));
    }
    return out;
}

void append_tips(const std::string& directory, const RodGroup& group, std::span<const double> steps,
                 std::vector<Quantity>& out) {
    const std::string path = "/groups/" + group.name() + "/position";
    std::vector<std::int64_t> rods = {0};
    if (group.count() > 1) rods.push_back(group.count() - 1);
    for (const std::int64_t rod : rods) {
        Quantity q{fmt::format("{} of {} {}", group.body() ? "centre" : "tip", group.name(), rod), "m", 3, {}};
        std::size_t next = 0;
        for (const auto& [file, first] : numbered_files(directory, "tips_", ".h5")) {
            const Segment segment = read_segment(directory, file);
            const H5File h5(Communicator::alone(), directory + "/" + file, H5File::Mode::read);
            for (std::size_t k = 0; k < segment.steps.size() && next < steps.size(); ++k) {
                if (segment.steps[k] != static_cast<std::int64_t>(steps[next])) continue;
                std::array<double, 3> position{};
                h5.read(path, H5Type::float64, {{k, static_cast<std::uint64_t>(rod), 0}, {1, 1, 3}}, position.data());
                q.values.insert(q.values.end(), position.begin(), position.end());
                ++next;
            }
        }
        if (next < steps.size())
            throw IoError(fmt::format("{}: frames of tips are missing, the first at step {}", directory, steps[next]));
        out.push_back(std::move(q));
    }
}

} // namespace

RunSamples read_samples(const std::string& directory, std::span<const RodGroup> groups, bool at_end) {
    const std::string path = directory + "/observables.csv";
    const CsvTable table = read_csv(path);
    if (table.names.size() < 2 || table.columns[0].empty()) throw IoError(path + ": has no rows");
    std::size_t count = table.columns[0].size();
    const std::vector<double>& step = table.columns[0];
    // A row of the last step that is off the interval has its like in no other run.
    if (!at_end && count > 2 && step[count - 1] - step[count - 2] != step[1] - step[0]) --count;
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < count; ++i)
        if (!at_end || i == 0 || i + 1 == count) rows.push_back(i);
    RunSamples samples;
    std::vector<double> steps;
    for (const std::size_t row : rows) {
        steps.push_back(table.columns[0][row]);
        samples.times.push_back(table.columns[1][row]);
    }
    for (const RodGroup& group : groups) append_tips(directory, group, steps, samples.quantities);
    auto columns = quantities_of(table, rows, at_end);
    std::move(columns.begin(), columns.end(), std::back_inserter(samples.quantities));
    return samples;
}

double core_seconds_of(const std::string& directory, double predicted) {
    using nlohmann::json;
    const json summary = json::parse(read_file(directory + "/summary.json"), nullptr, false);
    if (!summary.is_object() || !summary.contains("wall_s")) return predicted;
    const double steps = summary.value("steps", 0.0), made = steps - summary.value("first_step", 0.0);
    if (!(made > 0)) return predicted;
    double setup = 0;
    if (const auto phases = summary.find("phases"); phases != summary.end() && phases->contains("setup"))
        setup = (*phases)["setup"].value("max_s", 0.0);
    const int cores =
        summary.value("ranks", 1) * std::min(summary.value("threads", 1), summary.value("cores_per_rank", 1));
    return std::max(0.0, summary.value("wall_s", 0.0) - setup) * cores * steps / made;
}

} // namespace skein
