#include "commands.hpp"
#include "document.hpp"

#include "partition/partition.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_rebuild.hpp"
#include "simulation/machine.hpp"
#include "simulation/summary.hpp"
#include "skein/core/index.hpp"
#include "studies/verify.hpp"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cstdio>
#include <random>

namespace skein {

namespace {

/// Which of `count` segments between checkpoints, from 0.
std::int64_t chosen(const Communicator& comm, const std::string& text, std::int64_t count) {
    if (text.empty()) return count - 1;
    if (text == "random") {
        std::random_device device;
        return comm.broadcast(std::uniform_int_distribution<std::int64_t>(0, count - 1)(device));
    }
    std::int64_t number = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size() || number < 0 || number >= count)
        throw InputError("--segment " + text + ": expected random, or a number from 0 to " + std::to_string(count - 1));
    return number;
}

/// The result as JSON: a segment, the digest that was written at its end, the computed one, and what differs.
nlohmann::ordered_json result_json(const std::string& directory, std::int64_t segment, const CheckpointInfo& from,
                                   const CheckpointInfo& to, std::uint64_t digest, const std::string& difference) {
    return {{"directory", directory},
            {"segment", segment},
            {"from_step", from.step},
            {"to_step", to.step},
            {"written", digest_text(to.digest)},
            {"computed", digest_text(digest)},
            {"same", difference.empty()},
            {"difference", difference}};
}

} // namespace

int verify_command(const VerifyArguments& arguments, int& argc, char**& argv) {
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    return guarded(comm, [&] {
        const auto files = checkpoint_files(comm, arguments.directory);
        if (files.size() < 2)
            throw InputError("'" + arguments.directory + "' holds " + std::to_string(files.size()) +
                             " checkpoints; a segment to be computed again lies between two");
        const auto count = static_cast<std::int64_t>(files.size()) - 1,
                   segment = chosen(comm, arguments.segment, count);
        const auto path = [&](std::int64_t i) { return arguments.directory + "/" + nth(files, i); };
        const CheckpointInfo from = read_checkpoint_info(comm, path(segment)),
                             to = read_checkpoint_info(comm, path(segment + 1));

        SceneSpec scene = rebuilt_scene(from.scene, from.settings, from.file);
        std::vector<RodGroup> groups = make_groups(scene);
        read_rods(comm, groups);
        const Machine machine =
            machine_of(comm, arguments.layout.threads, arguments.layout.lanes, arguments.layout.mapping);
        const Threads threads(machine.threads, arguments.layout.shuffle);
        const double dt = scene.time.dt;
        if (has_automatic_step(from.settings)) scene.time.dt = 0;
        Plan plan = make_plan(scene, groups, machine);
        if (plan.dt != dt) { // of another program
            scene.time.dt = dt;
            plan = make_plan(scene, groups, machine);
        }
        if (physics_json(scene, groups, plan.dt) != from.scene)
            throw InputError(from.file + ": the scene that it keeps is not quite one of this program's:" +
                             text_of(key_changes(from.scene, physics_json(scene, groups, plan.dt))));
        if (comm.root())
            std::printf("%s: steps %lld to %lld, segment %lld of 0 to %lld\n", arguments.directory.c_str(),
                        static_cast<long long>(from.step), static_cast<long long>(to.step),
                        static_cast<long long>(segment), static_cast<long long>(count - 1));
        RunOptions options;
        options.from = from.file;
        options.checkpoint = false;
        options.quiet = true;
        Simulation simulation(comm, threads, scene, std::move(groups), std::move(plan), options);
        simulation.advance(to.step);
        const std::uint64_t digest = simulation.world().digest();
        std::string difference = skein::difference_to(simulation, to.file);
        if (difference.empty() && digest != to.digest) difference = "the digest of the state is another one";
        if (arguments.json && comm.root())
            print_document(result_json(arguments.directory, segment, from, to, digest, difference));
        if (!difference.empty())
            throw DifferenceError(arguments.directory + ": steps " + std::to_string(from.step) + " to " +
                                  std::to_string(to.step) + " computed again lead to digest " + digest_text(digest) +
                                  ", where " + digest_text(to.digest) + " was written: " + difference);
        if (comm.root()) std::printf("the same bits; digest %s\n", digest_text(digest).c_str());
        return static_cast<int>(Exit::done);
    });
}

} // namespace skein
