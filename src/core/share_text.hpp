// Shares of a limit and amounts of bytes as text that does not hide what matters: on which side of the limit they are.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace skein {

/// Three digits; more where these would read 1 and the number is not: 1.003, 0.99961.
std::string share_text(double share);

/// "72.5 kB"; three digits.
std::string bytes_text(double bytes);
/// Two amounts that are compared: with so many digits, or in bytes, that they differ where the numbers do.
std::pair<std::string, std::string> bytes_texts(std::uint64_t a, std::uint64_t b);

} // namespace skein
