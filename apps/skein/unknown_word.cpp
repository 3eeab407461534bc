#include "unknown_word.hpp"

#include "core/nearest.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace skein {

namespace {

std::vector<std::string> options_of(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options()) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
        for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    }
    return names;
}

std::string refused(std::string_view what, std::string_view word, const std::vector<std::string>& known,
                    const std::string& help) {
    const std::vector<std::string_view> names(known.begin(), known.end());
    std::string_view near = nearest_name(word, names);
    for (const std::string_view name : names) // two letters that change places are a slip before all others
        if (edit_distance(word, name) == 1 && std::ranges::is_permutation(word, name)) near = name;
    if (near.empty()) // one that the word goes on from: --output
        for (const std::string_view name : names)
            if (name.size() > 4 && name.size() > near.size() && word.starts_with(name)) near = name;
    return fmt::format("{} '{}'{}", what, word,
                       near.empty() ? fmt::format("; {} lists all", help) : fmt::format("; did you mean '{}'?", near));
}

} // namespace

std::string unknown_word(CLI::App& app, int argc, const char* const* argv) {
    if (argc < 2) return {};
    std::vector<std::string> commands;
    const CLI::App* command = nullptr;
    for (const CLI::App* one : app.get_subcommands([](const CLI::App*) { return true; })) {
        commands.push_back(one->get_name());
        if (one->get_name() == argv[1]) command = one;
    }
    if (!command && argv[1][0] != '-') return refused("there is no command", argv[1], commands, "skein --help");
    const std::vector<std::string> options = options_of(command ? *command : app);
    for (int i = command ? 2 : 1; i < argc; ++i) {
        const std::string_view word = argv[i], name = word.substr(0, word.find('='));
        if (name == "--") break; // positional words follow
        if (name.size() < 3 || !name.starts_with("--")) continue;
        if (std::find(options.begin(), options.end(), name) != options.end()) continue;
        const std::string whose = command ? "skein " + command->get_name() : "skein";
        return refused(whose + " has no option", name, options, whose + " --help");
    }
    return {};
}

} // namespace skein
