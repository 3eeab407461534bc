// Every scene in malformed/ is wrong in one way and says on its first line, "# expect: LINE:COLUMN: message", what it
// should be told.
#include "scene_fixture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace skein {
namespace {

std::vector<std::string> malformed_scenes() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(test_data + "/malformed"))
        names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

class Malformed : public testing::TestWithParam<std::string> {};

TEST_P(Malformed, IsToldWhereAndWhat) {
    const std::string file = test_data + "/malformed/" + GetParam() + ".toml";
    std::ifstream in(file);
    std::string head, source;
    std::getline(in, head);
    const std::string mark = "# expect: ";
    ASSERT_TRUE(head.starts_with(mark)) << head;

    const auto said = lines_of(refusal(file));
    ASSERT_GE(said.size(), 3u);
    EXPECT_EQ(said[0], file + ":" + head.substr(mark.size()));

    // Below: the line of the file, and carets under what is meant.
    const int line = std::stoi(head.substr(mark.size()));
    in.seekg(0);
    for (int i = 0; i < line; ++i) std::getline(in, source);
    const std::size_t carets = said[2].find('^');
    ASSERT_NE(carets, std::string::npos);
    EXPECT_EQ(said[1].substr(0, 8), std::string(5 - std::to_string(line).size(), ' ') + std::to_string(line) + " | ");
    if (source.size() > 120) return; // shown in part
    EXPECT_EQ(said[1].substr(8), source);
    const int column = std::stoi(head.substr(head.find(':', mark.size()) + 1));
    EXPECT_EQ(static_cast<int>(carets) - 8 + 1, column);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Malformed, testing::ValuesIn(malformed_scenes()),
                         [](const auto& name) { return name.param; });

TEST(MalformedScenes, AreAllFound) { EXPECT_GE(malformed_scenes().size(), 160u); }

} // namespace
} // namespace skein
