#include "document.hpp"

#include "skein/core/error.hpp"

#include <nlohmann/json.hpp>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

namespace skein {

namespace {

std::FILE* kept = nullptr; // standard output as it was
bool directed = false;     // the rest goes elsewhere

} // namespace

void keep_standard_output_for_document() {
    if (std::exchange(directed, true)) return;
    std::fflush(stdout);
    kept = fdopen(dup(STDOUT_FILENO), "w");
    dup2(STDERR_FILENO, STDOUT_FILENO);
}

void print_result(const std::string& text) {
    std::FILE* const to = directed ? kept : stdout;
    if (!to || std::fputs(text.c_str(), to) < 0 || std::fflush(to) != 0)
        throw IoError("standard output: " + std::string(std::strerror(errno)));
}

void print_document(const nlohmann::ordered_json& document) { print_result(document.dump(2) + "\n"); }

} // namespace skein
