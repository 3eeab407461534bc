// Texts made from the commands and options of the program: a man page, and words for the completion of bash.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace skein {

/// Text for man(1), in roff.
std::string manual_page(const CLI::App& app, const std::string& version);
/// Script for bash, which completes commands, options and file names.
std::string completion_script(const CLI::App& app);

} // namespace skein
