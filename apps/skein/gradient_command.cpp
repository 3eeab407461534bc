#include "commands.hpp"
#include "document.hpp"

#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "simulation/signals.hpp"
#include "studies/gradient_study.hpp"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace skein {

namespace {

nlohmann::ordered_json gradient_document(const GradientReport& report) {
    nlohmann::ordered_json numbers = nlohmann::ordered_json::array();
    for (const NumberSlopes& number : report.numbers) {
        nlohmann::ordered_json slopes = nlohmann::ordered_json::object();
        for (std::size_t i = 0; i < number.slope.size(); ++i) slopes[report.observables[i]] = number.slope[i];
        numbers.push_back({{"key", number.key}, {"unit", number.unit}, {"value", number.value}, {"slopes", slopes}});
    }
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < report.value.size(); ++i) values[report.observables[i]] = report.value[i];
    return {{"values", values}, {"numbers", numbers}, {"seconds", report.seconds}};
}

} // namespace

int gradient_command(GradientArguments arguments, int& argc, char**& argv) {
    std::string out;
    look_into_directory(arguments.run.scene, out);
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    stop_on_signals();
    return guarded(comm, [&] {
        if (comm.size() > 1) throw InputError("skein gradient solves one scene on one rank: start it without mpirun");
        const SceneArguments& scene = arguments.run.scene;
        const SceneText text{scene.file, read_scene_text(scene.file), scene.overrides};
        const Machine machine = machine_of(comm, arguments.run.threads, arguments.run.lanes, arguments.run.mapping);
        const Threads threads(machine.threads);
        double time = arguments.time;
        if (time < 0) time = parse_scene(text.file, text.text, text.overrides).time.duration;
        const GradientReport report = gradients(comm, threads, machine, text, arguments.keys, time);
        std::printf("%s", to_text(report).c_str());
        if (arguments.run.json) print_document(gradient_document(report));
        return static_cast<int>(Exit::done);
    });
}

} // namespace skein
