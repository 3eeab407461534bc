// Errors that end a run, each with the exit code of the program.
#pragma once

#include <stdexcept>
#include <string>

namespace skein {

enum class Exit {
    done = 0,
    input = 2,
    limit = 3,
    numerical = 4,
    io = 5,
    internal = 6,
    differs = 7,
    unsettled = 8,
    unexpected = 9,
    unstable = 10
};

/// Base of every error that Skein raises on purpose. The message states what happened, where, why, and a remedy.
class Error : public std::runtime_error {
public:
    Error(Exit code, const std::string& message) : std::runtime_error(message), code_(code) {}
    Exit code() const { return code_; }

private:
    Exit code_;
};

struct InputError : Error {
    explicit InputError(const std::string& m) : Error(Exit::input, m) {}
};
struct NumericalError : Error {
    explicit NumericalError(const std::string& m) : Error(Exit::numerical, m) {}
};
struct DifferenceError : Error {
    explicit DifferenceError(const std::string& m) : Error(Exit::differs, m) {}
};
struct IoError : Error {
    explicit IoError(const std::string& m) : Error(Exit::io, m) {}
};

} // namespace skein
