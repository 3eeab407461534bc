#include "io/array_file.hpp"

#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

bool ArrayFile::has(const std::string& name) const {
    const std::vector<std::string> all = names();
    return std::find(all.begin(), all.end(), name) != all.end();
}

void ArrayFile::refuse(const std::string& what) const { throw InputError(fmt::format("{}: {}", path_, what)); }

} // namespace skein
