// reference_replay FILE.json: runs a reference file and says how far the library is from it. README.md has the format's
// source.
#include "replay.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <fstream>
#include <string_view>

namespace {

using namespace skein;
using namespace skein::replay;

constexpr const char* usage =
    "usage: reference_replay FILE.json\n"
    "replays rods, rigid bodies and planes with their loads, contacts, constraints and dampers, or framed curves\n"
    "exit codes: 0 every field agrees, 1 a field differs, 2 the file is malformed, 7 the file needs physics that is "
    "not built\n";

void print(const std::vector<Deviation>& deviations) {
    fmt::print("{:>6}  {:<22}{:>12}{:>12}\n", "step", "field", "deviation", "tolerance");
    for (const Deviation& d : deviations)
        fmt::print("{:>6}  {:<22}{:>12.1e}{:>12.1e}{}\n", d.step, d.field, d.value, d.tolerance,
                   d.agrees() ? "" : "  DIFFERS");
}

int replay_file(const std::string& path) {
    std::ifstream stream(path);
    if (!stream) throw InputError(path + ": cannot be opened");
    const auto json = nlohmann::json::parse(stream);
    const Entry file(json, path);
    if (!json.is_object()) file.fail("is not an object");
    if (file.has("case"))
        fmt::print("{}: {}\n", file["case"].text(), file.has("description") ? file["description"].text() : "");
    const auto deviations = file.has("systems") ? replay_systems(file) : replay_curves(file);
    print(deviations);
    std::size_t beyond = 0;
    for (const Deviation& d : deviations) beyond += !d.agrees();
    fmt::print("{} of {} comparisons agree\n", deviations.size() - beyond, deviations.size());
    return beyond > 0 ? exit_differs : 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc == 2 && std::string_view(argv[1]) == "--help") {
        std::fputs(usage, stdout);
        return 0;
    }
    if (argc != 2) {
        std::fputs(usage, stderr);
        return static_cast<int>(Exit::input);
    }
    try {
        return replay_file(argv[1]);
    } catch (const NotBuilt& e) {
        std::fprintf(stderr, "not built: %s\n", e.what());
        return exit_not_built;
    } catch (const nlohmann::json::exception& e) {
        std::fprintf(stderr, "error: %s: %s\n", argv[1], e.what());
        return static_cast<int>(Exit::input);
    } catch (const Error& e) {
        std::fprintf(stderr, "error: %s\n", e.what());
        return static_cast<int>(e.code());
    }
}
