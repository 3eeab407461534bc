#include "commands.hpp"

#include "core/timer.hpp"
#include "partition/partition.hpp"
#include "scene/scene_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <thread>

namespace skein {

namespace {

/// Work done by every rank alike; what it throws on any rank ends all of them with that error's code, told once by root.
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
    if (comm.root() && !message.empty()) std::fprintf(stderr, "error: %s\n", message.c_str());
    return static_cast<int>(comm.max(static_cast<std::int64_t>(code)));
}

/// Read by root alone: a thousand ranks that open one file bring a shared disk to its knees.
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
        std::fprintf(stderr, "error: %s\n", e.what());
        return static_cast<int>(e.code());
    } catch (const std::exception& e) {
        std::fprintf(stderr, "error: %s\n", e.what());
        return static_cast<int>(Exit::internal);
    }
}

std::string default_out(const std::string& scene) { return "out/" + std::filesystem::path(scene).stem().string(); }

void stop_on_signals() {
    struct sigaction action {};
    action.sa_handler = [](int) { request_stop(); };
    for (const int signal : {SIGUSR1, SIGTERM, SIGINT}) sigaction(signal, &action, nullptr);
}

/// Ranks, threads and cores of this run. Ranks that the launcher left on the same cores share them evenly.
Machine machine_of(const Communicator& comm, const RunArguments& arguments) {
    char host[256] = "";
    ::gethostname(host, sizeof host - 1);
    const std::string cores = Threads::available_core_list();
    const auto seats = comm.all_gather(std::string(host) + ':' + cores);
    const int sharing = static_cast<int>(std::count(seats.begin(), seats.end(), seats[static_cast<std::size_t>(comm.rank())]));
    const int own = std::max(1, Threads::available_cores() / sharing);
    std::string which = cores;
    if (sharing > 1) {
        which += " shared by " + std::to_string(sharing);
    } else {
        constexpr std::size_t shown = 8;
        for (std::size_t r = 1; r < std::min(shown, seats.size()); ++r) which += " | " + seats[r].substr(seats[r].rfind(':') + 1);
        if (seats.size() > shown) which += " | ...";
    }
    return {comm.size(), arguments.threads > 0 ? arguments.threads : own, own, arguments.lanes, which, arguments.mapping};
}

/// Warns where the launcher has tied ranks to fewer cores than they have threads, or left cores idle.
void advise_on_binding(const Machine& m) {
    const int online = static_cast<int>(std::thread::hardware_concurrency());
    if (m.threads > m.cores)
        std::fprintf(stderr,
                     "warning: %d threads on the %d core%s this rank may use; start with mpirun -n %d --map-by slot:PE=%d "
                     "--bind-to core, or --bind-to none\n",
                     m.threads, m.cores, m.cores == 1 ? "" : "s", m.ranks, m.threads);
    else if (m.ranks * m.threads < online && m.cores < online / std::max(1, m.ranks))
        std::fprintf(stderr,
                     "note: %d of %d cores are used, because this rank is bound to %d; mpirun --bind-to none (or --map-by "
                     "slot:PE=%d) frees the rest\n",
                     m.ranks * m.threads, online, m.cores, online / std::max(1, m.ranks));
}

int environment_int(const char* name, int otherwise) {
    const char* text = std::getenv(name);
    return text ? std::max(1, std::atoi(text)) : otherwise;
}

} // namespace

int run_command(const RunArguments& arguments, int& argc, char**& argv) {
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        const double began = wall_seconds();
        const SceneSpec scene =
            parse_scene(arguments.scene.file, text_for_all(comm, arguments.scene.file), arguments.scene.overrides);
        std::vector<RodGroup> groups = make_groups(scene);
        read_rods(comm, groups);
        const Machine machine = machine_of(comm, arguments);
        const Threads threads(machine.threads, arguments.shuffle);
        Plan plan = make_plan(scene, groups, machine);
        RunOptions options = arguments.options;
        options.began = began;
        if (options.out.empty()) options.out = default_out(arguments.scene.file);
        if (comm.root() && !options.quiet) {
            std::printf("%s", to_text(plan).c_str());
            std::fflush(stdout);
            advise_on_binding(machine);
        }
        Simulation simulation(comm, threads, scene, std::move(groups), std::move(plan), options);
        const RunResult result = simulation.run();
        if (comm.root() && result.code == Exit::limit)
            std::printf(options.checkpoint ? "Stopped at a limit, with a checkpoint of step %lld; the same command resumes.\n"
                                           : "Stopped at a limit at step %lld.\n",
                        static_cast<long long>(result.step));
        return static_cast<int>(result.code);
    });
}

int plan_command(const PlanArguments& arguments) {
    return alone([&] {
        const SceneSpec scene = read_scene(arguments.scene.file, arguments.scene.overrides);
        const int ranks = arguments.ranks > 0 ? arguments.ranks : environment_int("OMPI_COMM_WORLD_SIZE", 1);
        const int cores = Threads::available_cores();
        const int threads = arguments.threads > 0 ? arguments.threads : std::max(1, cores / ranks);
        std::vector<RodGroup> groups = make_groups(scene);
        for (RodGroup& group : groups) group.read_all();
        const Plan plan =
            make_plan(scene, groups, {ranks, threads, std::max(threads, cores / ranks), arguments.lanes, {}, arguments.mapping});
        std::printf("%s", (arguments.json ? to_json(plan) : to_text(plan)).c_str());
    });
}

int check_command(const SceneArguments& arguments) {
    return alone([&] {
        const SceneSpec scene = read_scene(arguments.file, arguments.overrides);
        std::vector<RodGroup> groups = make_groups(scene);
        for (RodGroup& group : groups) group.read_all();
        const Plan plan = make_plan(scene, groups, {});
        std::printf("%s: good; %lld rods, %lld elements, %lld steps of %.6g s\n", arguments.file.c_str(),
                    static_cast<long long>(plan.rods), static_cast<long long>(plan.elements), static_cast<long long>(plan.steps),
                    plan.dt);
    });
}

int describe_command(const DescribeArguments& arguments) {
    return alone([&] {
        if (arguments.what.empty()) {
            std::printf("%s", scene_reference().c_str());
        } else if (arguments.what.ends_with(".toml")) {
            std::printf("%s", scene_text(read_scene(arguments.what)).c_str());
        } else {
            const std::string text = describe_key(arguments.what);
            if (text.empty()) throw InputError("there is no key or table '" + arguments.what + "'; skein describe lists all");
            std::printf("%s", text.c_str());
        }
    });
}

int info_command(const std::string& scene) {
    return alone([&] {
        std::printf("skein %s, built with %s for %s\n", SKEIN_VERSION, SKEIN_COMPILER, SKEIN_TARGET);
        std::printf("this process may use %d of %u cores\n", Threads::available_cores(), std::thread::hardware_concurrency());
        if (scene.empty()) return;
        const SceneSpec spec = read_scene(scene);
        std::vector<RodGroup> groups = make_groups(spec);
        for (RodGroup& group : groups) group.read_all();
        const Plan plan = make_plan(spec, groups, {});
        const std::string out = default_out(scene);
        std::int64_t newest = -1;
        if (std::filesystem::exists(out))
            for (const auto& entry : std::filesystem::directory_iterator(out)) {
                long long step = -1;
                if (entry.path().extension() == ".h5" &&
                    std::sscanf(entry.path().filename().string().c_str(), "checkpoint_%lld", &step) == 1)
                    newest = std::max<std::int64_t>(newest, step);
            }
        if (newest < 0) std::printf("%s: no checkpoint in %s\n", scene.c_str(), out.c_str());
        else
            std::printf("%s: checkpoint of step %lld of %lld (%.1f %%) in %s\n", scene.c_str(), static_cast<long long>(newest),
                        static_cast<long long>(plan.steps), 100.0 * static_cast<double>(newest) / static_cast<double>(plan.steps),
                        out.c_str());
    });
}

} // namespace skein
