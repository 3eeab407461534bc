// Places of docs/troubleshooting.md that explain a message.
#pragma once

#include <string>
#include <string_view>

namespace skein {

/// The message, and, if the page explains it, a last line with the place. Messages are found by a part that has no
/// names and numbers of the run.
std::string with_place_on_page(std::string message);

} // namespace skein
