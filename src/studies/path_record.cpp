#include "studies/path_record.hpp"

#include "io/files.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>

namespace skein {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "skein-path-state";

/// Doubles of numbers side by side.
template <class T> Json listed(const std::vector<T>& values) {
    static_assert(sizeof(T) % sizeof(double) == 0);
    std::vector<double> numbers(values.size() * (sizeof(T) / sizeof(double)));
    if (!numbers.empty()) std::memcpy(numbers.data(), values.data(), numbers.size() * sizeof(double));
    return numbers;
}
template <class T> std::vector<T> values_of(const Json& json) {
    const auto numbers = json.get<std::vector<double>>();
    std::vector<T> values(numbers.size() / (sizeof(T) / sizeof(double)));
    if (!values.empty()) std::memcpy(values.data(), numbers.data(), values.size() * sizeof(T));
    return values;
}

static_assert(sizeof(ContactMemory<double>) == 8 * sizeof(double));

/// Springs of friction.
Json json_of(const FrictionMemory& friction) {
    if (friction.empty()) return {};
    Json contacts = Json::array();
    for (const SavedContact& c : friction.contacts)
        contacts.push_back({c.a, c.b, c.status, listed<ContactMemory<double>>({c.memory})});
    return {{"reference", listed(friction.reference)}, {"walls", friction.walls}, {"contacts", contacts}};
}
FrictionMemory friction_of(const Json& json) {
    FrictionMemory friction;
    if (json.is_null()) return friction;
    friction.reference = values_of<Slot<1>>(json.at("reference"));
    friction.walls = json.at("walls").get<std::vector<std::vector<double>>>();
    for (const Json& c : json.at("contacts"))
        friction.contacts.push_back({c.at(0), c.at(1), c.at(2), values_of<ContactMemory<double>>(c.at(3)).at(0)});
    return friction;
}

Json json_of(const PathState& s) {
    return {{"slots", listed(s.state.slot)},
            {"strains", listed(s.state.strain)},
            {"joint_memory", s.state.joint_memory},
            {"friction", json_of(s.friction)},
            {"value", s.value},
            {"tangent", std::vector<double>(s.tangent.u.begin(), s.tangent.u.end())},
            {"tangent_value", s.tangent.p},
            {"negative", s.negative},
            {"residual", s.residual},
            {"iterations", s.iterations}};
}

PathState state_of(const Json& json) {
    PathState s;
    s.state = {values_of<Slot<1>>(json.at("slots")), values_of<Vec3d>(json.at("strains")),
               json.value("joint_memory", std::vector<double>())};
    s.friction = friction_of(json.value("friction", Json()));
    s.value = json.at("value");
    const auto tangent = json.at("tangent").get<std::vector<double>>();
    s.tangent = {Eigen::Map<const Unknown>(tangent.data(), static_cast<Eigen::Index>(tangent.size())),
                 json.at("tangent_value")};
    s.negative = json.at("negative");
    s.residual = json.at("residual");
    s.iterations = json.at("iterations");
    return s;
}

PathMemory memory_of(const Json& json) {
    PathMemory memory;
    memory.now = state_of(json.at("now"));
    memory.length = json.at("length");
    memory.step = json.at("step");
    if (!json.at("beyond").is_null()) memory.beyond = state_of(json.at("beyond"));
    memory.beyond_length = json.at("beyond_length");
    memory.beyond_place = static_cast<PathPlace>(json.at("beyond_place").get<int>());
    memory.over = json.at("over");
    return memory;
}

} // namespace

std::string to_text(const PathRecord& record) {
    const PathMemory& m = record.memory;
    const Json memory = {{"now", json_of(m.now)},
                         {"length", m.length},
                         {"step", m.step},
                         {"beyond", m.beyond ? json_of(*m.beyond) : Json()},
                         {"beyond_length", m.beyond_length},
                         {"beyond_place", static_cast<int>(m.beyond_place)},
                         {"over", m.over}};
    const Json all = {{"format", format_name},       {"version", 1},
                      {"asked", record.asked},       {"branch", record.branch},
                      {"points", record.points},     {"limits", record.limits},
                      {"branches", record.branches}, {"critical_slopes", record.critical_slopes},
                      {"reason", record.reason},     {"memory", memory}};
    return all.dump() + "\n";
}

PathRecord read_path_record(const std::string& directory) {
    const std::string path = directory + "/" + std::string(path_record_name);
    if (!std::filesystem::is_regular_file(path))
        throw InputError(
            fmt::format("--restart: '{}' holds no path to continue; without --restart one begins", directory));
    try {
        const Json all = Json::parse(read_file(path));
        if (all.at("format") != format_name || all.at("version") != 1) throw IoError(path + ": is of another format");
        return {.asked = all.at("asked"),
                .branch = all.at("branch"),
                .points = all.at("points"),
                .limits = all.at("limits").get<std::vector<double>>(),
                .branches = all.at("branches").get<std::vector<double>>(),
                .critical_slopes = all.value("critical_slopes", Json::array()),
                .reason = all.at("reason"),
                .memory = memory_of(all.at("memory"))};
    } catch (const nlohmann::json::exception& error) {
        throw IoError(fmt::format("{}: is damaged, so that the path cannot be continued: {}", path, error.what()));
    }
}

void require_unfinished(const PathRecord& record, const nlohmann::ordered_json& asked, int points) {
    for (const auto& [name, value] : record.asked.items())
        if (asked.at(name) != value)
            throw InputError(fmt::format("--restart: the path has {} {}, not {}; a path continues as it began", name,
                                         value.dump(), asked.at(name).dump()));
    if (record.memory.over) throw InputError("--restart: the path is complete: nothing is left of it");
    if (!record.reason.empty()) throw InputError("--restart: the path cannot continue: " + record.reason);
    if (record.points.size() >= static_cast<std::size_t>(points))
        throw InputError(
            fmt::format("--restart: the path has its {} points; --points allows more", record.points.size()));
}

} // namespace skein
