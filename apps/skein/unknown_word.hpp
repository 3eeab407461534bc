// Commands and options that nobody knows, with those that were probably meant.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace skein {

/// "there is no command 'rum'; did you mean 'run'?", or the same of the first option that a command does not have.
/// Empty where all words that begin the line, or that begin with a dash, are known: then something else is wrong.
std::string unknown_word(CLI::App& app, int argc, const char* const* argv);

} // namespace skein
