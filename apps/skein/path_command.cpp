#include "document.hpp"
#include "solving.hpp"

#include "equilibrium/path.hpp"
#include "io/files.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "studies/scene_family.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace skein {

namespace {

/// Points of a path as a table with the observables of each.
class PathTable {
public:
    PathTable(const std::string& key, const std::vector<std::string>& observables) {
        text_ = fmt::format("point,branch,{},length[-],place,negative,residual[-]", key);
        for (const std::string& name : observables) text_ += "," + name;
        text_ += "\n";
    }
    void add(const PathPoint& point, int branch, std::span<const double> observables) {
        text_ += fmt::format("{},{},{:.17g},{:.9g},{},{},{:.3g}", count_++, branch, point.value, point.length,
                             nth(path_place_names, point.place), point.negative, point.residual);
        for (const double value : observables) text_ += fmt::format(",{:.17g}", value);
        text_ += "\n";
    }
    const std::string& text() const { return text_; }

private:
    std::string text_;
    int count_ = 0;
};

/// A path is not gone on with.
void refuse_results(const RunArguments& run) {
    const std::string out = run.options.out.empty() ? default_out(run.scene.file) + "_path" : run.options.out;
    if (!run.options.overwrite && std::filesystem::exists(out + "/path.csv"))
        throw InputError(fmt::format("{} has the results of a path: --overwrite follows it again and keeps them in a "
                                     "folder, --out names another directory",
                                     out));
}

void print(const PathPoint& point) {
    std::printf("  %-8s %14.6g   %s%s\n", std::string(nth(path_place_names, point.place)).c_str(), point.value,
                point.negative > 0 ? "unstable" : "stable",
                point.negative > 0 ? fmt::format(", {} directions", point.negative).c_str() : "");
}

/// Slots of the pieces of a scene, and their places in a case of all of its bodies.
std::vector<std::pair<Slot<1>*, std::size_t>> slots_in(const StaticCase& all, StaticScene& at_rest) {
    std::map<std::int64_t, std::size_t> first; // by rod
    for (std::size_t i = 0; i < all.rods.size(); ++i) first[all.rods[i].gid] = all.system->first_slot(i);
    std::vector<std::pair<Slot<1>*, std::size_t>> slots;
    for (StaticPiece& piece : at_rest.pieces())
        for (std::size_t i = 0; i < piece.rods.size(); ++i) {
            const std::size_t begin = piece.system->first_slot(i);
            const std::size_t there = first.at(at_rest.world().rods().local()[piece.rods[i]].gid);
            for (std::size_t k = begin; k < piece.system->first_slot(i + 1); ++k)
                slots.emplace_back(&piece.state.slot[k], there + k - begin);
        }
    return slots;
}

} // namespace

int follow_and_write_path(const Communicator& comm, const PathArguments& arguments) {
    if (comm.size() > 1) throw InputError("skein path follows one scene on one rank: start it without mpirun");
    refuse_results(arguments.run);
    const bool quiet = arguments.run.options.quiet;
    SceneText text{arguments.run.scene.file, text_for_all(comm, arguments.run.scene.file),
                   arguments.run.scene.overrides};
    PathOptions options{.to = arguments.to};
    double time = arguments.time;
    SolvedScene solved = solved_scene(comm, arguments.run, "_path", [&](SceneSpec& scene) {
        options.from = std::isnan(arguments.from) ? number_at(scene, arguments.key) : arguments.from;
        if (options.from == options.to) throw InputError("--to is where the path begins; give another value");
        if (time < 0) time = scene.time.duration;
        scene.time.dt = 0;
        const double dt = make_plan(scene, make_groups(scene), {}).dt; // a frame for each point
        scene.time.dt = dt;
        scene.time.duration = arguments.points * dt;
        scene.output.trajectory = scene.output.series = dt;
    });
    options.step = std::min(arguments.step, options.largest_step);
    options.largest_step = arguments.step;
    text.overrides.push_back(fmt::format("{}={:.17g}", arguments.key, options.from));
    SceneFamily family(text, solved.machine, time, arguments.key);

    StaticScene at_rest(solved.simulation->world());
    const auto slots = slots_in(family.case_at(options.from), at_rest);
    StaticState state{std::vector<Slot<1>>(slots.size()), {}};
    for (const auto& [slot, place] : slots) state.slot[place] = *slot;
    StaticSystem& first = family.at(options.from);
    first.refresh(state);
    NewtonSolver newton(first, {});
    const Equilibrium start = newton.find(state, time);
    if (!start.found)
        throw NumericalError(fmt::format("no equilibrium was found where the path begins: {}", start.reason));

    PathFollower path(family, state, options);
    PathTable table(arguments.key, solved.simulation->observation().names());
    int branch = 0;
    bool switched = false;
    const RunResult result = solved.simulation->go_through([&](World& world) {
        std::optional<PathPoint> point = path.next();
        if (!point) return false;
        StaticCase& now = family.case_at(point->value);
        Plan plan = world.plan;
        world.change(make_groups(now.scene), std::move(plan));
        for (const auto& [slot, place] : slots) *slot = path.state().slot[place];
        at_rest.put_back();
        table.add(*point, branch, solved.simulation->observation().values());
        if (!quiet) print(*point);
        if (point->place == PathPlace::branch && arguments.branch != 0 && !switched) {
            switched = true;
            if (path.switch_branch(arguments.branch)) ++branch;
        }
        return true;
    });
    write_file(solved.out + "/path.csv", table.text());
    if (!quiet && !path.reason().empty()) std::printf("The path ends: %s\n", path.reason().c_str());
    if (!quiet) std::printf("Written: %s\n", solved.out.c_str());
    return static_cast<int>(result.code);
}

} // namespace skein
