// Scenes to begin from: the shipped ones of apps/recipes, which are part of the program.
#include "commands.hpp"
#include "core/nearest.hpp"
#include "io/files.hpp"
#include "recipes.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <vector>

namespace skein {

namespace {

/// First line of a recipe, without its mark.
std::string_view purpose(const Recipe& recipe) { return recipe.text.substr(2, recipe.text.find('\n') - 2); }

std::string list_of_recipes() {
    std::string text;
    for (const Recipe& recipe : recipes) text += fmt::format("  {:<12}{}\n", recipe.kind, purpose(recipe));
    return text;
}

} // namespace

int new_command(const NewArguments& arguments) {
    return alone([&] {
        if (arguments.kind.empty()) {
            fmt::print("Kinds of scenes:\n{}\nskein new KIND writes KIND.toml; skein new KIND FILE another file.\n",
                       list_of_recipes());
            return;
        }
        const auto* const recipe =
            std::ranges::find_if(recipes, [&](const Recipe& one) { return one.kind == arguments.kind; });
        if (recipe == std::end(recipes)) {
            std::vector<std::string_view> kinds;
            for (const Recipe& one : recipes) kinds.push_back(one.kind);
            throw InputError(fmt::format("there is no kind '{}' of scenes{}", arguments.kind,
                                         suggestion(arguments.kind, kinds, "the kinds are")));
        }
        const std::string file = arguments.file.empty() ? arguments.kind + ".toml" : arguments.file;
        if (std::filesystem::exists(file)) throw InputError(fmt::format("{} exists; give another name", file));
        write_file(file, std::string(recipe->text));
        fmt::print("{}: {}\nskein run {}\n", file, purpose(*recipe), file);
    });
}

} // namespace skein
