#include "document.hpp"
#include "slope_tables.hpp"
#include "solving.hpp"

#include "core/timer.hpp"
#include "equilibrium/path.hpp"
#include "io/files.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "studies/path_record.hpp"
#include "studies/scene_family.hpp"
#include "studies/scene_number.hpp"
#include "studies/static_slopes.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace skein {

namespace {

/// Points of a path, as a table with the observables of each and as a document.
class PathTable {
public:
    PathTable(const std::string& key, const SceneNumber& number, const std::vector<std::string>& observables)
        : key_(key) {
        text_ = fmt::format("point,branch,{},length[-],place,negative,residual[-]", number.heading(key));
        for (const std::string& name : observables) text_ += "," + name;
        text_ += "\n";
    }
    /// Goes on below the rows of a path that was cut off.
    void go_on(std::string text, nlohmann::ordered_json points) {
        if (!text.starts_with(text_) ||
            std::count(text.begin(), text.end(), '\n') != static_cast<std::ptrdiff_t>(points.size()) + 1)
            throw IoError("path.csv: is not as the path left it, so that it cannot be continued");
        text_ = std::move(text);
        points_ = std::move(points);
    }
    void add(const PathPoint& point, int branch, std::span<const double> observables) {
        const std::string_view place = nth(path_place_names, point.place);
        text_ += fmt::format("{},{},{:.17g},{:.9g},{},{},{:.3g}", points_.size(), branch, point.value, point.length,
                             place, point.negative, point.residual);
        for (const double value : observables) text_ += fmt::format(",{:.17g}", value);
        text_ += "\n";
        points_.push_back({{"value", point.value}, {"place", place}, {"negative", point.negative}, {"branch", branch}});
    }
    const std::string& text() const { return text_; }
    const nlohmann::ordered_json& points() const { return points_; }
    nlohmann::ordered_json document(const FoundPath& found) const {
        return {{"key", key_},
                {"unit", found.unit},
                {"points", points_},
                {"limits", found.limits},
                {"branches", found.branches},
                {"complete", found.complete},
                {"reason", found.reason},
                {"results", found.out}};
    }

private:
    std::string text_, key_;
    nlohmann::ordered_json points_ = nlohmann::ordered_json::array();
};

std::string line_of(const PathPoint& point) {
    const std::string stability = point.negative < 0    ? "stability not known"
                                  : point.negative == 0 ? "stable"
                                                        : fmt::format("unstable, {} directions", point.negative);
    return fmt::format("  {:<8} {:>14.6g}   {}\n", nth(path_place_names, point.place), point.value, stability);
}

/// What is followed, from where to where.
struct Followed {
    SceneText text;
    SceneNumber number;
    PathOptions options;
    double time;
    std::string out; ///< directory of results

    double range() const { return options.to - options.from; }
    /// Options with an effect on points.
    nlohmann::ordered_json asked(const PathArguments& arguments) const {
        return {{"--along", arguments.key},       {"--from", options.from}, {"--to", options.to},
                {"--step", options.largest_step}, {"--time", time},         {"--branch", arguments.branch},
                {"--by", arguments.by},           {"--of", arguments.of}};
    }
};

/// All that can be refused before results are touched.
Followed followed(const Communicator& comm, const PathArguments& arguments) {
    const SceneArguments& file = arguments.run.scene;
    Followed what{
        {file.file, text_for_all(comm, file.file), file.overrides}, {}, {.to = arguments.to}, arguments.time, {}};
    what.out = arguments.run.options.out.empty() ? default_out(file.file) + "_path" : arguments.run.options.out;
    const SceneSpec scene = parse_scene(file.file, what.text.text, file.overrides);
    what.number = number_at(scene, arguments.key);
    refuse_whole(what.number, arguments.key);
    PathOptions& options = what.options;
    options.from = std::isnan(arguments.from) ? what.number.value : arguments.from;
    for (const double end : {options.from, options.to}) with_number(scene, arguments.key, end); // which refuses it
    if (options.from == options.to) throw InputError("--to is where the path begins; give another value");
    options.step = std::min(arguments.step, options.largest_step);
    options.largest_step = arguments.step;
    if (what.time < 0) what.time = scene.time.duration;
    const bool in_joints = std::any_of(scene.joints.begin(), scene.joints.end(),
                                       [](const JointSpec& joint) { return joint.has_friction(); });
    if (arguments.branch != 0 && (in_joints || has_friction(scene, has_memory)))
        throw InputError(
            "--branch: with friction that has memory no branch points are located, as its forces depend on "
            "the way there; leave --branch out, or give contacts friction = \"none\" and joints no friction");
    if (!arguments.of.empty() && arguments.by.empty())
        throw InputError("--of names observables whose slopes are asked for: give --by with a number of the scene");
    what.text.overrides.push_back(fmt::format("{}={:.17g}", arguments.key, options.from));
    return what;
}

/// Refuses values at either end that no scene has, or that change what is unknown.
void refuse_ends(SceneFamily& family, const PathOptions& options, const std::string& key) {
    const int from = family.at(options.from).unknowns(), to = family.at(options.to).unknowns();
    if (from != to)
        throw InputError(fmt::format("'{}' changes what is unknown: {} unknowns at {:g}, {} at {:g}", key, from,
                                     options.from, to, options.to));
}

/// A body of the pieces of a scene, and its places in a case of all of its bodies and in local().
struct BodyPlace {
    StaticPiece* piece;
    std::size_t in_piece, in_case, local;

    std::span<Slot<1>> slots() const {
        const std::size_t first = piece->system->first_slot(in_piece);
        return std::span(piece->state.slot).subspan(first, piece->system->first_slot(in_piece + 1) - first);
    }
};
using BodyPlaces = std::vector<BodyPlace>;

/// In the order of the case.
BodyPlaces bodies_in(const StaticCase& all, StaticScene& at_rest) {
    std::map<std::int64_t, std::size_t> place; // by rod
    for (std::size_t i = 0; i < all.rods.size(); ++i) place[all.rods[i].gid] = i;
    BodyPlaces bodies(all.rods.size());
    for (StaticPiece& piece : at_rest.pieces())
        for (std::size_t i = 0; i < piece.rods.size(); ++i) {
            const std::size_t there = place.at(at_rest.world().rods().local()[piece.rods[i]].gid);
            bodies[there] = {&piece, i, there, piece.rods[i]};
        }
    return bodies;
}

/// Springs of friction that the scene starts with.
void take_springs(const BodyPlaces& bodies, StaticSystem& first) {
    for (const auto& [piece, in_piece, in_case, local] : bodies) {
        const std::vector<double> wall = piece->system->at_rest().wall_memory(in_piece);
        if (!wall.empty()) first.at_rest().set_wall_memory(in_case, wall);
        if (first.contacts()) first.contacts()->set_springs(piece->system->contacts()->springs());
    }
}
/// Leaves the springs of a point to the pieces.
void put_springs(const FrictionMemory& friction, const BodyPlaces& bodies) {
    if (friction.empty()) return;
    for (const auto& [piece, in_piece, in_case, local] : bodies) {
        if (!friction.walls[in_case].empty())
            piece->system->at_rest().set_wall_memory(in_piece, friction.walls[in_case]);
        if (!piece->system->contacts()) continue;
        piece->system->contacts()->set_springs(friction.contacts);
        piece->system->contacts()->set_reference(piece->state.slot);
    }
}

StaticState state_at_start(const BodyPlaces& bodies, const Rods& rods, SceneFamily& family, const Followed& what) {
    StaticState state;
    std::vector<std::vector<double>> kept;
    for (const BodyPlace& body : bodies) {
        const std::span<const Slot<1>> slots = body.slots();
        state.slot.insert(state.slot.end(), slots.begin(), slots.end());
        kept.push_back(rods.memory(body.local));
    }
    StaticSystem& first = family.at(what.options.from);
    take_springs(bodies, first);
    state.joint_memory = joint_memory_of(first.at_rest(), kept);
    first.refresh(state);
    const Equilibrium start = find_or_stop(first, state, what.time);
    if (!start.found)
        throw NumericalError(
            fmt::format("no equilibrium was found where the path begins: {}", without_repetition(start.reason)));
    return state;
}

/// Leaves a point of a path to the world.
void show(const StaticCase& now, const PathFollower& path, const BodyPlaces& bodies, StaticScene& at_rest,
          double time) {
    const StaticState& state = path.state();
    World& world = at_rest.world();
    Plan plan = world.plan;
    plan.physics = now.plan.physics; // laws of joints, contacts and walls, of which the number may be one
    world.change(make_groups(now.scene), std::move(plan));
    for (const BodyPlace& body : bodies)
        std::ranges::copy_n(state.slot.begin() + static_cast<std::ptrdiff_t>(now.system->first_slot(body.in_case)),
                            std::ssize(body.slots()), body.slots().begin());
    put_springs(path.friction(), bodies);
    at_rest.put_back();
    StaticRods& joints = now.system->at_rest();
    joints.set_joint_memory(state.joint_memory);
    for (const BodyPlace& body : bodies) put_joints(joints, body.in_case, world.rods(), body.local);
    world.show_solution(time);
}

/// The next point, with its place and the time it takes told.
std::optional<PathPoint> next_point(PathFollower& path, FoundPath& found) {
    const double began = wall_seconds();
    std::optional<PathPoint> point;
    try {
        point = path.next();
    } catch (const InputError& error) { // no scene has a value beyond
        found.reason = error.what();
    }
    found.seconds += wall_seconds() - began;
    if (!point) return point;
    if (point->place == PathPlace::limit) found.limits.push_back(point->value);
    if (point->place == PathPlace::branch) found.branches.push_back(point->value);
    found.complete = point->place == PathPlace::end;
    return point;
}

/// The scene with a frame for each point, in a directory that has `points` of them.
SolvedScene scene_with_frames(const Communicator& comm, const PathArguments& arguments, const Followed& what,
                              std::size_t points) {
    RunArguments run = arguments.run;
    run.scene.overrides = what.text.overrides;
    run.options.out = what.out;
    const auto change = [&](SceneSpec& scene) {
        scene.time.dt = 0;
        const double dt = make_plan(scene, make_groups(scene), {}).dt;
        scene.time.dt = dt;
        scene.time.duration = arguments.points * dt;
        scene.output.trajectory = scene.output.series = dt;
        if (scene.output.tips > 0) scene.output.tips = dt;
    };
    SolvedScene solved =
        solved_scene(comm, run, {}, Friction::with_memory, change, points > 0 ? Directory::goes_on : Directory::begins);
    const std::int64_t frames = solved.simulation->world().clock.done();
    if (frames != static_cast<std::int64_t>(points))
        throw InputError(fmt::format("--restart: '{}' has {} frames of {} points of the path: begin again with "
                                     "--overwrite",
                                     what.out, frames, points));
    return solved;
}

/// Names of slopes; none where none are asked for.
std::optional<GradientReport> names_asked_for(const Communicator& comm, const StaticCase& first,
                                              const GradientOptions& asked) {
    if (asked.keys.empty()) return {};
    const Threads one(1);
    ObservedCase observed(comm, one, first, asked.time);
    return names_of(observed, {}, asked);
}

/// Adds the slopes of a path to what is written and told.
void add_slopes(const SlopeTables& slopes, FoundPath& found) {
    slopes.write(found.out);
    found.document["critical_slopes"] = slopes.critical();
    found.slopes = slopes.to_text();
}

/// Tells why a path ends that could go on.
void tell_cut(FoundPath& found, std::size_t points) {
    found.goes_on = found.reason.empty() && !found.complete;
    if (found.goes_on)
        found.reason = found.code != Exit::done
                           ? "it was stopped"
                           : fmt::format("its {} points are used up; --points allows more", points);
}

} // namespace

FoundPath follow_path(const Communicator& comm, const PathArguments& arguments) {
    if (comm.size() > 1) throw InputError("skein path follows one scene on one rank: start it without mpirun");
    const bool quiet = arguments.run.options.quiet;
    const Followed what = followed(comm, arguments);
    std::optional<PathRecord> before;
    if (arguments.restart) {
        before = read_path_record(what.out);
        require_unfinished(*before, what.asked(arguments), arguments.points);
    }
    SceneFamily family(what.text, machine_of(comm, arguments.run.threads, arguments.run.lanes, arguments.run.mapping),
                       what.time, arguments.key);
    refuse_ends(family, what.options, arguments.key);
    const GradientOptions asked{arguments.by, arguments.of, what.time};
    const std::optional<GradientReport> names = names_asked_for(comm, family.case_at(what.options.from), asked);
    SolvedScene solved = scene_with_frames(comm, arguments, what, before ? before->points.size() : 0);
    StaticScene at_rest(solved.simulation->world());
    const BodyPlaces bodies = bodies_in(family.case_at(what.options.from), at_rest);
    PathFollower path =
        before ? PathFollower(family, std::move(before->memory), what.options)
               : PathFollower(family, state_at_start(bodies, at_rest.world().rods(), family, what), what.options);
    PathTable table(arguments.key, what.number, solved.simulation->observation().names());
    std::optional<SlopeTables> slopes;
    if (names)
        slopes.emplace(PathSlopes(comm, *solved.threads, solved.machine, family, arguments.key, what.range(), asked),
                       *names, arguments.key, what.number.unit);
    FoundPath found{.unit = what.number.unit, .out = what.out};
    int branch = 0;
    if (before) {
        table.go_on(read_file(what.out + "/path.csv"), before->points);
        found.limits = before->limits;
        found.branches = before->branches;
        branch = before->branch;
        if (slopes) slopes->go_on(what.out, before->points.size(), before->critical_slopes);
    }
    const RunResult result = solved.simulation->go_through([&](World&) {
        const std::optional<PathPoint> point = next_point(path, found);
        if (!point) return false;
        show(family.case_at(point->value), path, bodies, at_rest, what.time);
        table.add(*point, branch, solved.simulation->observation().values());
        if (slopes) slopes->add(path, *point, table.points().size() - 1, branch);
        if (!quiet) std::printf("%s", line_of(*point).c_str());
        if (point->place == PathPlace::branch && arguments.branch != 0 && branch == 0)
            branch += path.switch_branch(arguments.branch);
        return true;
    });
    found.code = result.code;
    if (found.reason.empty()) found.reason = path.reason();
    write_file(what.out + "/path.csv", table.text());
    const nlohmann::ordered_json critical = slopes ? slopes->critical() : nlohmann::ordered_json::array();
    write_file(what.out + "/" + std::string(path_record_name),
               to_text({what.asked(arguments), branch, table.points(), found.limits, found.branches, critical,
                        found.reason, path.memory()}));
    tell_cut(found, table.points().size());
    found.document = table.document(found);
    if (slopes) add_slopes(*slopes, found);
    return found;
}

int follow_and_write_path(const Communicator& comm, const PathArguments& arguments) {
    const bool quiet = arguments.run.options.quiet;
    const FoundPath found = follow_path(comm, arguments);
    if (!quiet) std::printf("%s", found.slopes.c_str());
    if (!quiet && !found.reason.empty()) std::printf("The path ends: %s\n", found.reason.c_str());
    if (!quiet && found.goes_on) std::printf("The same command with --restart continues from there.\n");
    if (!quiet) std::printf("Written: %s\n", found.out.c_str());
    if (arguments.run.json) print_document(found.document);
    return static_cast<int>(found.code);
}

} // namespace skein
