#include "simulation/results_directory.hpp"

#include "io/own_files.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

namespace fs = std::filesystem;

namespace skein {

namespace {

constexpr const char* record_name = "physics.json"; ///< written as a run begins

const std::string& made(const std::string& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error) throw IoError(path + ": cannot be made a directory (" + error.message() + ")");
    return path;
}

/// Names of results, and of what only looks like them, in the directory and in the folder of it that is a run's own.
std::vector<std::string> results_in(const std::string& directory) {
    std::vector<std::string> names;
    const auto add = [&](const std::string& folder) {
        for (const auto& entry : fs::directory_iterator(directory + "/" + folder))
            if (const std::string name = folder + entry.path().filename().string(); is_result_name(name))
                names.push_back(name);
    };
    add("");
    if (fs::is_directory(directory + "/" + frames_folder)) add(frames_folder);
    return names;
}

void move_to_previous(const std::string& directory) {
    const auto names = results_in(directory);
    if (names.empty()) return;
    int n = 1;
    const auto previous = [&] { return directory + "/previous_" + std::to_string(n); };
    while (fs::symlink_status(previous()).type() != fs::file_type::not_found) ++n;
    fs::create_directory(previous());
    for (const auto& name : names) {
        fs::create_directories(fs::path(previous() + "/" + name).parent_path());
        set_aside(directory + "/" + name, previous() + "/" + name);
    }
    std::error_code others_are_there;
    fs::remove(directory + "/" + frames_folder, others_are_there);
    std::fprintf(stderr, "Earlier results are now in %s\n", previous().c_str());
}

} // namespace

std::string result_in(const std::string& directory) {
    std::error_code error; // opening the directory reports what is wrong with it
    if (!fs::is_directory(directory, error)) return {};
    const auto names = results_in(directory);
    const auto found = std::find_if(names.begin(), names.end(), [](const std::string& n) { return n != record_name; });
    return found == names.end() ? std::string() : *found;
}

ResultsDirectory::ResultsDirectory(const std::string& path, bool anew) : path_(made(path)), lock_(path_) {
    if (anew) move_to_previous(path_);
}

void ResultsDirectory::begin(const std::string& physics) const {
    const std::string record = path_ + "/" + record_name;
    if (const auto names = results_in(path_); !names.empty()) {
        const bool unfinished =
            !fs::exists(path_ + "/summary.json") && fs::is_regular_file(record) && read_file(record) == physics;
        if (!unfinished)
            throw IoError("'" + path_ + "' holds results ('" + names.front() +
                          "') but no checkpoint to resume from; use another --out, or --overwrite, which moves them to "
                          "a folder of their own and starts again");
        std::printf("No checkpoint in %s yet: starting again from the beginning\n", path_.c_str());
    }
    write_file(record, physics);
}

} // namespace skein
