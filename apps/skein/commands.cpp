#include "commands.hpp"

#include "document.hpp"

#include "core/level.hpp"
#include "core/stop.hpp"
#include "core/timer.hpp"
#include "core/troubleshooting.hpp"
#include "io/files.hpp"
#include "partition/partition.hpp"
#include "physics/loads/load_plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/memory_check.hpp"
#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "simulation/signals.hpp"
#include "simulation/start_check.hpp"
#include "simulation/summary.hpp"
#include "simulation/warnings.hpp"
#include "studies/cost_trial.hpp"
#include "studies/method_trial.hpp"
#include "studies/rank_forecast.hpp"
#include "studies/self_check.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <system_error>
#include <thread>

namespace skein {

namespace {

using Json = nlohmann::ordered_json;

void tell_error(const std::string& message) {
    std::fflush(stdout); // what led to it comes first
    std::fprintf(stderr, "error: %s\n", with_place_on_page(message).c_str());
}

} // namespace

int guarded(const Communicator& comm, const std::function<int()>& work) {
    int code = 0;
    std::string message;
    try {
        code = work();
    } catch (const Error& e) {
        code = static_cast<int>(e.code());
        message = e.what();
    } catch (const std::exception& e) {
        code = static_cast<int>(Exit::internal);
        message = e.what();
    }
    message = comm.first_text(message);
    if (comm.root() && !message.empty()) tell_error(message);
    return static_cast<int>(comm.max(static_cast<std::int64_t>(code)));
}

std::string text_for_all(const Communicator& comm, const std::string& file) {
    std::string text, error;
    if (comm.root()) {
        try {
            text = read_scene_text(file);
        } catch (const std::exception& e) {
            error = e.what();
        }
    }
    error = comm.broadcast(error);
    if (!error.empty()) throw InputError(error);
    return comm.broadcast(std::move(text));
}

int alone(const std::function<void()>& work) {
    try {
        work();
        return 0;
    } catch (const Error& e) {
        tell_error(e.what());
        return static_cast<int>(e.code());
    } catch (const std::exception& e) {
        tell_error(e.what());
        return static_cast<int>(Exit::internal);
    }
}

std::string default_out(const std::string& scene) { return "out/" + std::filesystem::path(scene).stem().string(); }

void look_into_directory(SceneArguments& scene, std::string& out) {
    const std::filesystem::path inside = std::filesystem::path(scene.file) / "scene.toml";
    std::error_code error; // what is wrong with it is told when it is read
    if (!std::filesystem::is_regular_file(inside, error)) return;
    if (out.empty()) out = scene.file;
    scene.file = inside.string();
}

namespace {

/// Warns where the launcher has tied ranks to fewer cores than they have threads, or left cores idle.
void advise_on_binding(const Machine& m) {
    const int online = static_cast<int>(std::thread::hardware_concurrency());
    if (m.threads > m.cores)
        print_warning(
            fmt::format("{} threads on the {} core{} this rank may use; start with mpirun -n {} --map-by slot:PE={} "
                        "--bind-to core, or --bind-to none",
                        m.threads, m.cores, m.cores == 1 ? "" : "s", m.ranks, m.threads));
    else if (m.ranks * m.threads < online && m.cores < online / std::max(1, m.ranks))
        std::fprintf(
            stderr,
            "note: %d of %d cores are used, because this rank is bound to %d; mpirun --bind-to none (or --map-by "
            "slot:PE=%d) frees the rest\n",
            m.ranks * m.threads, online, m.cores, online / std::max(1, m.ranks));
}

int environment_int(const char* name, int otherwise) {
    const char* text = std::getenv(name);
    return text ? std::max(1, std::atoi(text)) : otherwise;
}

std::string text_of(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& error) {
        return error.what();
    }
}

} // namespace

Prepared prepare(const Communicator& comm, const SceneArguments& arguments, const Threads* threads) {
    Prepared prepared;
    const std::string text = text_for_all(comm, arguments.file);
    std::exception_ptr failure;
    bool stopped = false;
    try {
        prepared.scene = parse_scene(arguments.file, text, arguments.overrides);
        stop_where_asked("the scene was read");
        prepared.groups = make_groups(prepared.scene);
    } catch (const Stopped&) {
        stopped = true;
        failure = std::current_exception();
    } catch (...) {
        failure = std::current_exception();
    }
    const bool any = comm.max(static_cast<std::int64_t>(stopped)) > 0;
    // A rank whose machine has less memory may fail alone, and the others must not wait for it.
    const std::string said = comm.first_text(failure && !stopped ? text_of(failure) : std::string());
    if (failure) std::rethrow_exception(failure);
    if (!said.empty()) throw InputError(said);
    if (any) throw Stopped("stopped by a signal; nothing was written");
    read_rods(comm, prepared.groups, threads);
    return prepared;
}

namespace {

/// Of rods of files, all of which this process holds.
void refuse_faults(const SceneSpec& scene, const Plan& plan, std::span<const RodGroup> groups) {
    if (const std::string fault = fault_of_read_rods(plan, groups); !fault.empty()) throw InputError(fault);
    refuse_start(scene, plan, groups);
}

} // namespace

int run_command(RunArguments arguments, int& argc, char**& argv, const BesideRun& beside) {
    const double began = wall_seconds();
    look_into_directory(arguments.scene, arguments.options.out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        const Machine machine = machine_of(comm, arguments.threads, arguments.lanes, arguments.mapping);
        const Threads threads(machine.threads, arguments.shuffle);
        auto [scene, groups] = prepare(comm, arguments.scene, &threads);
        if (beside.before) beside.before(scene);
        Plan plan = make_plan(scene, groups, machine);
        RunOptions options = arguments.options;
        options.began = began;
        if (options.out.empty()) options.out = default_out(arguments.scene.file);
        if (comm.root() && !options.quiet) {
            Plan shown = plan;
            if (methods_are_compared(plan, scene, groups)) compare_methods(shown, scene, groups);
            std::printf("%s", to_text(shown, arguments.verbose).c_str());
            std::fflush(stdout);
            advise_on_binding(machine);
        }
        Simulation simulation(comm, threads, scene, std::move(groups), std::move(plan), options);
        const RunResult result = simulation.run();
        if (comm.root() && result.code == Exit::limit && !simulation.idle())
            std::printf(options.checkpoint
                            ? "Stopped at a limit, with a checkpoint of step %lld; the same command resumes.\n"
                            : "Stopped at a limit at step %lld.\n",
                        static_cast<long long>(result.step));
        if (arguments.json && comm.root()) print_result(read_file(options.out + "/summary.json"));
        if (beside.after && comm.root() && result.code == Exit::done) return beside.after(scene, options.out);
        return static_cast<int>(result.code);
    });
}

int plan_command(PlanArguments arguments, int& argc, char**& argv) {
    look_into_directory(arguments.scene, arguments.out);
    return alone([&] {
        const SceneSpec scene = read_scene(arguments.scene.file, arguments.scene.overrides);
        const int ranks = arguments.ranks > 0 ? arguments.ranks : environment_int("OMPI_COMM_WORLD_SIZE", 1);
        const int cores = Threads::available_cores();
        const int threads = arguments.threads > 0 ? arguments.threads : std::max(1, cores / ranks);
        const std::vector<RodGroup> groups = make_whole_groups(scene);
        const MachineFile machine = arguments.machine.empty() ? MachineFile{} : read_machine_file(arguments.machine);
        const int per_node = arguments.machine.empty() ? cores : static_cast<int>(machine.machine.cores_per_node);
        Plan plan = make_plan(scene, groups,
                              {.ranks = ranks,
                               .threads = threads,
                               .cores = std::max(threads, cores / ranks),
                               .lanes = lanes_for(arguments.lanes),
                               .mapping = arguments.mapping,
                               .cores_per_node = per_node,
                               .most_lanes = lanes_to_choose_from(arguments.lanes, lanes_for(0))});
        refuse_faults(scene, plan, groups);
        const bool all = arguments.verbose || arguments.ranks > 0 || !arguments.machine.empty();
        // Shares of a fluid are alike, and its plan holds all of them.
        if ((arguments.ranks == 0 && arguments.machine.empty()) || groups.empty()) {
            const bool compares = methods_are_compared(plan, scene, groups);
            if (compares || cost_is_measured(plan)) {
                const MpiSession session(argc, argv); // of this process alone, as steps are made
                if (cost_is_measured(plan)) measure_cost(plan, scene, groups, arguments.out);
                if (compares) compare_methods(plan, scene, groups);
            }
            print_result(arguments.json ? to_json(plan) : to_text(plan, all));
            return;
        }
        if (!arguments.json) std::printf("%s", to_text(plan, all).c_str());
        std::fflush(stdout);
        if (environment_int("OMPI_COMM_WORLD_SIZE", 1) > 1)
            throw InputError("skein plan --ranks works shares out in one process: start it without mpirun");
        const MpiSession session(argc, argv); // of this process alone, as steps are made
        const RankForecast forecast = forecast_ranks(plan, groups, ranks, machine);
        print_result(arguments.json ? to_json(plan, forecast) : to_text(forecast));
    });
}

int check_command(SceneArguments arguments, bool json) {
    std::string out;
    look_into_directory(arguments, out);
    return alone([&] {
        const SceneSpec scene = read_scene(arguments.file, arguments.overrides);
        const std::vector<RodGroup> groups = make_whole_groups(scene);
        const Plan plan = make_plan(scene, groups, {});
        refuse_faults(scene, plan, groups);
        refuse_run_beyond_memory(scene, plan);
        if (json)
            return print_document(Json{{"scene", arguments.file},
                                       {"rods", plan.rods},
                                       {"elements", plan.elements},
                                       {"steps", plan.steps},
                                       {"dt_s", plan.dt},
                                       {"notes", plan.notes}});
        std::printf("%s: good; %lld rods, %lld elements, %lld steps of %.6g s\n", arguments.file.c_str(),
                    static_cast<long long>(plan.rods), static_cast<long long>(plan.elements),
                    static_cast<long long>(plan.steps), plan.dt);
        for (const std::string& note : plan.notes) std::printf("  note: %s\n", note.c_str());
    });
}

int self_check_command(int threads_wanted, int lanes_wanted, bool json, int& argc, char**& argv) {
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    return guarded(comm, [&] {
        const Machine machine = machine_of(comm, threads_wanted, lanes_wanted);
        const double started = wall_seconds();
        const std::uint64_t digest = self_check(comm, Threads(machine.threads), machine.lanes);
        if (digest != self_check_digest)
            throw NumericalError("self-check: the digest is " + digest_text(digest) + " and not " +
                                 digest_text(self_check_digest) + ": this build computes wrong on this machine (" +
                                 std::to_string(machine.lanes) + " lanes, " + SKEIN_COMPILER +
                                 "); trust no result of it");
        if (json && comm.root())
            print_document(Json{{"ranks", machine.ranks},
                                {"threads", machine.threads},
                                {"lanes", machine.lanes},
                                {"level", level_name(machine.lanes)},
                                {"seconds", wall_seconds() - started},
                                {"digest", digest_text(digest)}});
        else if (comm.root())
            std::printf("self-check: good on %d x %d, %d lanes (%s), in %.2f s; digest %s\n", machine.ranks,
                        machine.threads, machine.lanes, std::string(level_name(machine.lanes)).c_str(),
                        wall_seconds() - started, digest_text(digest).c_str());
        return 0;
    });
}

} // namespace skein
