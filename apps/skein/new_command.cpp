// Scenes to begin from: the shipped ones of apps/recipes, which are part of the program.
#include "commands.hpp"
#include "document.hpp"

#include "core/nearest.hpp"
#include "io/files.hpp"
#include "recipes.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <vector>

namespace skein {

namespace {

/// First line of a recipe, without its mark.
std::string_view purpose(const Recipe& recipe) { return recipe.text.substr(2, recipe.text.find('\n') - 2); }

nlohmann::ordered_json json_of_recipe(const Recipe& recipe) {
    return {{"kind", recipe.kind}, {"purpose", purpose(recipe)}};
}

nlohmann::ordered_json json_of_recipes() {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const Recipe& recipe : recipes) all.push_back(json_of_recipe(recipe));
    return all;
}

std::string list_of_recipes() {
    std::string text;
    for (const Recipe& recipe : recipes) text += fmt::format("  {:<12}{}\n", recipe.kind, purpose(recipe));
    return text;
}

} // namespace

int new_command(const NewArguments& arguments) {
    return alone([&] {
        if (arguments.kind.empty()) {
            if (arguments.json) return print_document(json_of_recipes());
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
        if (arguments.json) {
            nlohmann::ordered_json json = json_of_recipe(*recipe);
            json["file"] = file;
            return print_document(json);
        }
        fmt::print("{}: {}\nskein run {}\n", file, purpose(*recipe), file);
    });
}

} // namespace skein
