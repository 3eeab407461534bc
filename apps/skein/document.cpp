#include "document.hpp"

#include <unistd.h>

#include <cstdio>

namespace skein {

namespace {

std::FILE* kept = nullptr; // standard output as it was; null: nothing is directed elsewhere

} // namespace

void keep_standard_output_for_document() {
    if (kept) return;
    std::fflush(stdout);
    kept = fdopen(dup(STDOUT_FILENO), "w");
    dup2(STDERR_FILENO, STDOUT_FILENO);
}

void print_result(const std::string& text) {
    std::FILE* const to = kept ? kept : stdout;
    std::fputs(text.c_str(), to);
    std::fflush(to);
}

} // namespace skein
