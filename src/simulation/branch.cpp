#include "simulation/branch.hpp"

#include "mechanics/rod_copies.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_stages.hpp"
#include "simulation/summary.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace skein {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Integrator integrator_of(const std::string& physics) {
    const Json name = Json::parse(physics, nullptr, false)["time"]["integrator"];
    for (std::size_t i = 0; i < std::size(integrator_names); ++i)
        if (name == integrator_names[i]) return static_cast<Integrator>(i);
    return Integrator::verlet;
}

/// Positions and directors of all rods moved by `h` at constant rates.
void drift_all(std::span<const RodGroup> groups, Rods& rods, double h) {
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < rods.local().size(); ++i) {
        const RodGroup& group = nth(groups, rods.local()[i].group);
        state.resize(static_cast<std::size_t>(group.slots()));
        rods.export_rod(i, state);
        synchronise(group, state, h);
        rods.import_rod(i, state);
    }
}

/// Keys of where a scene begins are no change of what it is.
std::vector<KeyChange> changes_of(const std::string& was, const std::string& now) {
    auto changes = key_changes(was, now);
    std::erase_if(changes, [](const KeyChange& c) { return c.key.starts_with("start."); });
    return changes;
}

/// Begins of the stages so far of a branch that has stages, s.
std::vector<double> stage_begins_of(const CheckpointInfo& parent, StartTime time, double now) {
    if (time == StartTime::zero) return {0.0};
    return parent.stage_begins.empty() ? std::vector<double>{now} : parent.stage_begins;
}

constexpr const char* caught_ends = "caught_ends"; ///< in the ancestry: by group, of the start and of the end

/// How a branch holds ends, and how its parent has held them.
struct EndsOfBranch {
    std::vector<RodSpec> before, after;
};

/// Throws InputError where stages that have begun hold ends in another way than those of the parent: a branch catches
/// ends as it begins, and not in the past.
EndsOfBranch ends_of_branch(const CheckpointInfo& parent, const BranchOf& branch) {
    const std::vector<double> begun = parent.stage_begins.empty() ? std::vector<double>{0.0} : parent.stage_begins;
    SceneSpec written = rebuilt_scene(parent.scene, parent.settings, parent.file);
    written.rods = with_caught_ends(std::move(written.rods), parent.ancestry);
    const SceneSpec was = stage_scene(written, begun);
    const bool same_stages =
        branch.stages > 0 && !parent.stage_begins.empty() && branch.scene.start.time == StartTime::goes_on;
    EndsOfBranch ends{same_stages ? written.rods : was.rods, branch.scene.rods};
    for (std::size_t i = 0; i < was.rods.size() && !same_stages; ++i)
        if (led_from_stage(was.rods[i]))
            throw InputError(fmt::format("{}: an end of '{}' is led from the begin of a stage there, which the branch "
                                         "lacks: give it the [[stage]]s of its parent, or begin before that stage",
                                         parent.file, was.rods[i].name));
    catch_ends_of_branch(ends.before, ends.after);
    if (!same_stages || begun.size() > branch.scene.stages.size()) return ends; // the latter is refused later
    SceneSpec as_before = branch.scene;
    hold_ends_like(written.rods, as_before.rods);
    if (!ends_alike(stage_scene(as_before, begun).rods, was.rods))
        throw InputError(fmt::format("{}: stages of the branch that have begun there hold ends of rods in another way "
                                     "than the parent's; change the keys of [[rods]], or later stages",
                                     parent.file));
    return ends;
}

bool stores_energy(const KeyChange& c) { return c.key.find(".material.") != std::string::npos; }

} // namespace

std::vector<RodSpec> with_caught_ends(std::vector<RodSpec> rods, const std::string& ancestry) {
    const Json json = Json::parse(ancestry, nullptr, false);
    if (!json.is_object() || !json.contains(caught_ends)) return rods;
    const Json& numbers = json[caught_ends];
    for (std::size_t i = 0; i < std::min(rods.size(), numbers.size()); ++i) {
        rods[i].start_caught = numbers[i][0].get<std::size_t>();
        rods[i].end_caught = numbers[i][1].get<std::size_t>();
    }
    return rods;
}

std::vector<std::string> checkpoints_of(const Communicator& comm, const std::string& name, const std::string& folder) {
    const CheckpointName wanted = checkpoint_name(name);
    const std::string directory = (fs::path(folder) / wanted.directory).lexically_normal().string();
    std::vector<std::string> files = checkpoint_files(comm, directory);
    std::reverse(files.begin(), files.end());
    std::vector<std::string> found;
    std::string steps;
    for (const std::string& file : files) {
        const std::int64_t step = std::stoll(file.substr(file.find('_') + 1));
        steps += fmt::format("{}{}", steps.empty() ? "" : ", ", step);
        if (!wanted.step || step == *wanted.step) found.push_back((fs::path(directory) / file).string());
    }
    if (!found.empty()) return found;
    throw InputError(files.empty()
                         ? fmt::format("{}: there is no checkpoint in '{}'", name, directory)
                         : fmt::format("{}: there is no checkpoint of that step in '{}'; those there are of {}", name,
                                       directory, steps));
}

Clock continued(const Clock& clock, double dt, Integrator integrator) {
    if (dt == clock.dt()) return Clock(dt, clock.done(), integrator, clock.shift());
    const auto step = static_cast<std::int64_t>(std::llround(clock.time() / dt));
    const double shift = clock.time() - static_cast<double>(step) * dt;
    return Clock(dt, step, integrator, std::abs(shift) < 1e-9 * dt ? 0 : shift); // below: round-off of a multiple
}

void refuse_other_rods(const CheckpointInfo& parent, const std::string& physics) {
    const auto forbidden = forbidden_changes(parent.scene, physics);
    if (!forbidden.empty())
        throw InputError(fmt::format(
            "{}: its state is one of other rods or walls; a branch may change times, loads, damping, contact "
            "laws, material, and how walls move, but not:{}",
            parent.file, text_of(forbidden)));
}

Branched begin_branch(const Communicator& comm, const BranchOf& branch, std::span<const RodGroup> groups, Rods& rods,
                      std::span<const std::string> kept, const std::function<void(const std::string&)>& warn) {
    const StartSpec& start = branch.scene.start;
    auto files = checkpoints_of(comm, start.from, fs::path(branch.scene.file).parent_path().string());
    if (const auto first = std::find(files.begin(), files.end(), branch.newest); first != files.end())
        files.erase(files.begin(), first);
    EndsOfBranch ends;
    const auto accept = [&](const CheckpointInfo& parent) {
        refuse_other_rods(parent, branch.physics);
        const std::size_t begun = std::max<std::size_t>(1, parent.stage_begins.size());
        if (branch.stages > 0 && start.time == StartTime::goes_on && begun != branch.stages)
            throw OtherStage{parent.stage_begins, parent.file};
        ends = ends_of_branch(parent, branch);
        if (!ends_alike(ends.before, branch.held)) throw OtherEnds{std::move(ends.before), parent.file};
    };
    CheckpointInfo info;
    for (const std::string& file : files) {
        try {
            info = load_checkpoint(comm, file, groups, rods, accept, kept, true);
            break;
        } catch (const IoError& error) {
            if (&file == &files.back()) throw;
            if (comm.root()) warn(error.what());
        }
    }

    const Clock before(info.dt, info.step, integrator_of(info.scene), info.shift);
    const Integrator integrator = branch.scene.time.integrator;
    const Clock after =
        start.time == StartTime::zero ? Clock(branch.dt, 0, integrator) : continued(before, branch.dt, integrator);
    if (after.done() >= after.step_at(branch.scene.time.duration))
        throw InputError(fmt::format("{}: time.duration of {:g} s is over at the {:g} s with which it begins",
                                     branch.scene.file, branch.scene.time.duration, after.time()));
    if (const double ahead = before.lag() - after.lag(); ahead != 0) drift_all(groups, rods, ahead);

    const auto changes = changes_of(info.scene, branch.physics);
    Json list = Json::array();
    for (const KeyChange& c : changes) list.push_back({{"key", c.key}, {"was", c.was}, {"now", c.now}});
    Json ancestry = {{"parent", fs::path(info.file).parent_path().string()},
                     {"step", info.step},
                     {"time_s", before.time()},
                     {"digest", digest_text(info.digest)},
                     {"changes", list}};
    if (!info.ancestry.empty()) ancestry["ancestry"] = Json::parse(info.ancestry, nullptr, false);
    if (std::any_of(ends.after.begin(), ends.after.end(), [](const RodSpec& rods) { return rods.ends_caught(); }))
        for (const RodSpec& group : ends.after) ancestry[caught_ends].push_back({group.start_caught, group.end_caught});
    info.ancestry = ancestry.dump();
    info.step = after.done();
    info.dt = branch.dt;
    info.shift = after.shift();
    info.stage_over = info.stage_over && branch.stages > 0 && start.time == StartTime::goes_on;
    info.stage_begins = branch.stages > 0 ? stage_begins_of(info, start.time, after.time()) : std::vector<double>();
    if (std::any_of(changes.begin(), changes.end(), stores_energy) || !ends_alike(ends.before, ends.after))
        info.audited_from.reset(); // the energy budget begins anew
    return {std::move(info), std::move(ends.after)};
}

std::string with_ancestry(const std::string& physics, const std::string& ancestry) {
    if (ancestry.empty()) return physics;
    Json json = Json::parse(physics);
    json["ancestry"] = Json::parse(ancestry);
    return json.dump(2) + "\n";
}

std::string branch_file(const SceneSpec& scene, const CheckpointInfo& parent, const std::vector<KeyChange>& changes) {
    std::string text =
        fmt::format("# Goes on from step {} of {}, t = {:g} s, digest {}.\n", parent.step,
                    fs::path(parent.file).parent_path().string(),
                    parent.shift + static_cast<double>(parent.step) * parent.dt, digest_text(parent.digest));
    for (const KeyChange& c : changes) text += fmt::format("# {}: was {}, now {}\n", c.key, c.was, c.now);
    return text + scene_toml(scene, Keys::given);
}

} // namespace skein
