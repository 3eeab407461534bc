#include "io/end_record.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/own_files.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string_view>

namespace skein {

namespace {

constexpr std::string_view format = "skein-end", series_name = "observables.csv";

std::string path_of(const std::string& directory) { return directory + "/end.json"; }

/// True for names of a run's records of this step, so that an edited list removes nothing else.
bool is_record_of(const std::string& name, std::int64_t step) {
    const std::string digits = fmt::format("_{:012d}.", step);
    return is_result_name(name) && !name.starts_with("checkpoint_") && name.find("..") == name.npos &&
           name.find(digits) != name.npos &&
           std::count(name.begin(), name.end(), '/') == (name.starts_with(frames_folder) ? 1 : 0);
}

std::optional<EndRecord> record_in(const std::string& text) {
    const auto json = nlohmann::json::parse(text, nullptr, false);
    try {
        if (json.at("format") != format) return std::nullopt;
        return EndRecord{json.at("step").get<std::int64_t>(), json.at("files").get<std::vector<std::string>>()};
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

void take_back_row(const std::string& path, std::int64_t step) {
    if (!std::filesystem::exists(path)) return;
    const std::string content = read_file(path);
    if (content.empty() || content.back() != '\n') return; // an unfinished row is the last one
    const auto before = content.rfind('\n', content.size() - 2);
    if (before == content.npos || !std::string_view(content).substr(before + 1).starts_with(fmt::format("{},", step)))
        return;
    write_file(path, std::string_view(content).substr(0, before + 1));
}

} // namespace

void write_end_record(const std::string& directory, const EndRecord& record) {
    const nlohmann::ordered_json json = {
        {"format", format}, {"version", 1}, {"step", record.step}, {"files", record.files}};
    write_file(path_of(directory), json.dump(1) + "\n");
}

void take_back_end(const std::string& directory) {
    const std::string path = path_of(directory);
    if (!std::filesystem::is_regular_file(path)) return;
    const auto record = record_in(read_file(path));
    if (!record) {
        set_aside(path, path + ".foreign");
        return;
    }
    for (const std::string& name : record->files) {
        if (name == series_name) take_back_row(directory + "/" + name, record->step);
        if (is_record_of(name, record->step)) remove_file(directory + "/" + name);
    }
    remove_file(path);
}

} // namespace skein
