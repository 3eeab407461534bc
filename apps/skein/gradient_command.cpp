#include "commands.hpp"
#include "document.hpp"
#include "solving.hpp"

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
    return {{"values", values},
            {"numbers", numbers},
            {"contacts_stick", report.rubs},
            {"adjoint_solutions", report.adjoint},
            {"seconds", report.seconds}};
}

} // namespace

int gradient_command(GradientArguments arguments, int& argc, char**& argv) {
    return study_on_one_rank(
        "gradient", arguments.run, arguments.time, argc, argv, [&](const StudiedScene& scene, const Threads& threads) {
            const GradientReport report =
                gradients(scene.comm, threads, scene.machine, scene.text,
                          {arguments.keys, arguments.of, scene.time, scene.begun ? &*scene.begun : nullptr});
            std::printf("%s", to_text(report).c_str());
            if (arguments.run.json) print_document(gradient_document(report));
        });
}

} // namespace skein
