#include "commands.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace skein {

int python_command(int argc, char** argv) {
    std::error_code none;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", none);
    const auto package = program.parent_path().parent_path() / "share/skein/python";
    if (none || !std::filesystem::is_directory(package / "skein")) {
        fmt::print(stderr, "error: '{}' is a command of Skein's Python package, which is not in {}\n", argv[1],
                   package.string());
        return static_cast<int>(Exit::input);
    }
    const char* const before = std::getenv("PYTHONPATH");
    const std::string path = package.string() + (before && *before ? fmt::format(":{}", before) : "");
    setenv("PYTHONPATH", path.c_str(), 1);
    setenv("SKEIN", program.c_str(), 1);

    const char* const chosen = std::getenv("PYTHON");
    std::string python = chosen && *chosen ? chosen : "python3", module = "skein", dash = "-m";
    std::vector<char*> words{python.data(), dash.data(), module.data()};
    words.insert(words.end(), argv + 1, argv + argc);
    words.push_back(nullptr);
    execvp(words[0], words.data());
    fmt::print(stderr, "error: cannot start {}: {}; set PYTHON to an interpreter with numpy, h5py and matplotlib\n",
               python, std::strerror(errno));
    return static_cast<int>(Exit::input);
}

} // namespace skein
