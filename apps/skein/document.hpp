// Standard output of a command with --json: one document, and nothing else.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace skein {

/// Directs all that is printed from then on to standard error, except documents.
void keep_standard_output_for_document();
/// Print the result of a command: as it is, and as JSON.
void print_result(const std::string& text);
void print_document(const nlohmann::ordered_json& document);

} // namespace skein
