// Text of shares of a limit and of amounts of bytes that never hides on which side of the limit they are.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace skein {

/// Share with three digits, or with more where these would read 1 and the number is not: 1.003, 0.99961.
std::string share_text(double share);

/// Bytes with three digits: "72.5 kB".
std::string bytes_text(double bytes);
/// Two amounts for comparison, with enough digits, or in bytes, to differ where the numbers do.
std::pair<std::string, std::string> bytes_texts(std::uint64_t a, std::uint64_t b);

} // namespace skein
