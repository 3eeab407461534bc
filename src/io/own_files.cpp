#include "io/own_files.hpp"

#include "io/disk.hpp"
#include "io/h5_file.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace fs = std::filesystem;

namespace skein {

namespace {

constexpr std::array whole_names = {"summary.json",    "physics.json", "observables.csv",    "observables.lost.csv",
                                    "trajectory.xdmf", "failure.h5",   "failure.xdmf",       "rods.pvd",
                                    "walls.pvd",       "fields.xdmf",  "end.json",           "path.csv",
                                    "modes.csv",       "slopes.csv",   "critical_slopes.csv"};

struct Numbered {
    std::string_view prefix, suffix;
};
constexpr std::array numbered_names = {
    Numbered{"checkpoint_", ".h5"}, Numbered{"trajectory_", ".h5"},      Numbered{"tips_", ".h5"},
    Numbered{"fields_", ".h5"},     Numbered{"lost_trajectory_", ".h5"}, Numbered{"lost_tips_", ".h5"},
    Numbered{"contacts_", ".csv"},  Numbered{"vtp/rods_", ".vtp"},       Numbered{"vtp/walls_", ".vtp"}};

/// True for fluid_<name>.xdmf, fluid_<name>_<step>.h5 and fluid_<name>_<step>.xdmf.
bool is_of_fluid(std::string_view name) {
    constexpr std::string_view prefix = "fluid_";
    if (!name.starts_with(prefix)) return false;
    if (name.ends_with(".xdmf")) return true;
    const auto step = name.substr(name.rfind('_') + 1);
    return step.size() < name.size() - prefix.size() && number_in(step, "", ".h5");
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Name without the endings that set_aside() and unfinished writing add.
std::string_view without_endings(std::string_view name) {
    const auto count = name.substr(name.rfind('.') + 1);
    if (!count.empty() && std::all_of(count.begin(), count.end(), is_digit)) name.remove_suffix(count.size() + 1);
    for (const std::string_view ending : {".damaged", ".unreadable", ".foreign", ".tmp"})
        if (name.ends_with(ending)) name.remove_suffix(ending.size());
    return name;
}

} // namespace

bool is_result_name(std::string_view name) {
    name = without_endings(name);
    if (std::find(whole_names.begin(), whole_names.end(), name) != whole_names.end()) return true;
    if (is_of_fluid(name)) return true;
    return std::any_of(numbered_names.begin(), numbered_names.end(), [name](const Numbered& known) {
        return number_in(name, known.prefix, known.suffix).has_value();
    });
}

std::string h5_format(const std::string& path) {
    try {
        return H5File(Communicator::alone(), path, H5File::Mode::read).find<std::string>("/", "format").value_or("");
    } catch (const IoError&) {
        return {};
    }
}

std::optional<std::string> beginning_of(const std::string& path, std::size_t most) {
    if (!fs::is_regular_file(path)) return std::nullopt;
    std::string text(most, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(text.data(), static_cast<std::streamsize>(most));
    text.resize(to_index(file.gcount()));
    return text;
}

bool is_hole(std::string_view text) { return text.find_first_not_of('\0') == text.npos; }

bool is_unfinished(const std::string& path, const std::string& format) {
    const std::optional<std::string> begin = beginning_of(path, 8);
    if (!begin) return false;
    if (is_hole(*begin)) return true;
    if (*begin != "\x89HDF\r\n\x1a\n") return false;
    const std::string found = h5_format(path);
    return found.empty() || found == format;
}

std::string set_aside(const std::string& path, const std::string& new_path) {
    std::string free = new_path;
    for (int n = 2; fs::symlink_status(free).type() != fs::file_type::not_found; ++n)
        free = new_path + "." + std::to_string(n);
    if (std::rename(path.c_str(), free.c_str()) != 0) throw_system_error(path, "cannot be renamed", errno);
    return free;
}

void make_way(const std::string& path, const std::string& format) {
    if (fs::symlink_status(path).type() == fs::file_type::not_found) return;
    const bool own = path.ends_with(".tmp") ? is_unfinished(path, format) : h5_format(path) == format;
    if (!own) set_aside(path, path + ".foreign");
}

} // namespace skein
