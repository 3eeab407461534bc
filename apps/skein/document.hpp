// Standard output of a command with --json: one document, and nothing else.
#pragma once

#include <string>

namespace skein {

/// Directs all that is printed from then on to standard error, except documents.
void keep_standard_output_for_document();
/// Prints the result of a command.
void print_result(const std::string& text);

} // namespace skein
