#include "manual.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <vector>

namespace skein {

namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App*) { return true; });
}

/// Text that roff prints as it is: no hyphen is broken, no line is a request.
std::string plain(const std::string& text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '\\') out += "\\e";
        else if (c == '-') out += "\\-";
        else if ((c == '.' || c == '\'') && (i == 0 || text[i - 1] == '\n')) out += std::string("\\&") + c;
        else out += c;
    }
    return out;
}

/// Values of an option; of named ones the names: "ENUM:value in {a->0,b->1} OR {0,1}" becomes "a|b".
std::string value_text(const std::string& type) {
    const std::size_t from = type.find('{'), to = type.find('}');
    if (type.find("->") == std::string::npos) return type;
    std::string names;
    bool in_name = true;
    for (const char c : type.substr(from + 1, to - from - 1)) {
        if (c == ',') names += '|';
        in_name = c == ',' || (in_name && c != '-');
        if (in_name && c != ',') names += c;
    }
    return names;
}

std::string options_text(const CLI::App& command) {
    std::string text;
    for (const CLI::Option* option : command.get_options()) {
        const std::string value = option->get_expected_max() > 0 ? " " + value_text(option->get_type_name()) : "";
        text += fmt::format(".TP\n.B {}\n{}\n", plain(option->get_name(option->get_positional(), true) + value),
                            plain(option->get_description()));
    }
    return text;
}

} // namespace

std::string manual_page(const CLI::App& app, const std::string& version) {
    std::string text =
        fmt::format(".TH SKEIN 1 \"\" \"skein {}\"\n.SH NAME\nskein \\- large assemblies of soft slender rods\n"
                    ".SH SYNOPSIS\n.B skein\nCOMMAND [OPTIONS]\n.SH COMMANDS\n",
                    version);
    for (const CLI::App* command : commands_of(app)) {
        const std::string options = options_text(*command);
        text += fmt::format(".SS skein {}\n{}\n{}", command->get_name(), plain(command->get_description()), options);
    }
    return text + fmt::format(".SH EXAMPLES\n.nf\n{}.fi\n", plain(app.get_footer()));
}

std::string completion_script(const CLI::App& app) {
    std::string names, cases;
    for (const CLI::App* command : commands_of(app)) {
        std::string words;
        for (const CLI::Option* option : command->get_options())
            for (const std::string& name : option->get_lnames()) words += (words.empty() ? "--" : " --") + name;
        names += (names.empty() ? "" : " ") + command->get_name();
        cases += fmt::format("        {}) words=\"{}\" ;;\n", command->get_name(), words);
    }
    return fmt::format(R"(_skein() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} words=""
    if ((COMP_CWORD == 1)); then
        mapfile -t COMPREPLY < <(compgen -W "{} --help --version" -- "$word")
        return
    fi
    [[ $word == -* ]] || return 0
    case ${{COMP_WORDS[1]}} in
{}    esac
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}}
complete -o default -F _skein skein
)",
                       names, cases);
}

} // namespace skein
