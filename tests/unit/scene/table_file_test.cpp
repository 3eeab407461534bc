// Tables whose numbers lie in a file beside the scene.
#include "scene_fixture.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace skein {
namespace {

class TableFile : public testing::Test {
protected:
    TableFile() { std::filesystem::create_directories(directory_); }
    ~TableFile() override { std::filesystem::remove_all(directory_); }

    std::string scene(const std::string& table) const {
        const std::string file = (directory_ / "scene.toml").string();
        std::ofstream(file) << R"toml(
time.duration = 1.0
[[rods]]
name = "one"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 0.01
shape = {length = 1.0, elements = 4}
[[load]]
kind = "formula"
force = ["gust(t)", "0", "0"]
[[table]]
name = "gust"
unit = "N/m"
)toml" << table;
        return file;
    }
    std::string with_file(const std::string& content) const {
        std::ofstream(directory_ / "gust.csv", std::ios::binary) << content;
        return scene("file = \"gust.csv\"\n");
    }

private:
    std::filesystem::path directory_ = std::filesystem::path(testing::TempDir()) / "skein_table_file";
};

TEST_F(TableFile, IsTheTableThatStandsInTheScene) {
    const auto numbers = [](const std::string& file) { return scene_json(read_scene(file), false); };
    const std::string within = numbers(scene("at = [0, 0.25, 2]\nvalue = [1, -3.5e-1, 1e3]\n"));
    EXPECT_EQ(numbers(with_file("time,force\n0,1\n0.25,-3.5e-1\n2,1e3\n")), within);
    EXPECT_EQ(numbers(with_file("\xEF\xBB\xBF\"time [s]\" , force\r\n0, +1\r\n\r\n 0.25 ,-0.35\r\n2,1000")), within)
        << "as spreadsheets write it";
    EXPECT_NE(numbers(with_file("time,force\n0,1\n0.25,-3.5e-1\n2,1001\n")), within);
}

TEST_F(TableFile, IsRefusedByItsNameAndLine) {
    const auto said = [](const std::string& file) { return refusal(file); };
    const auto expect = [&](const std::string& content, const std::string& message) {
        const std::string text = said(with_file(content));
        EXPECT_NE(text.find("gust.csv" + message), std::string::npos) << content << text;
        EXPECT_NE(text.find("scene.toml:14:"), std::string::npos) << text;
    };
    expect("time,force\n0,1\n1,two\n", ":3: 'two' is not a number");
    expect("time,force\n0,1\n1\n", ":3: expected 2 numbers by the first line, found 1");
    expect("time,x,y\n0,1,2\n1,1,2\n", ": has 3 columns; a table has two, points and values");
    expect("time,force\n0,1\n0,2\n", ": points must rise, but 0 follows 0");
    expect("time,force\n0,1\n1,nan\n", ": nan is out of range");
    EXPECT_NE(said(with_file("time,force\n0,1\n")).find("a table needs two points at least"), std::string::npos);
    EXPECT_NE(said(scene("file = \"absent.csv\"\n")).find("absent.csv"), std::string::npos);
    EXPECT_NE(said(scene("file = \"gust.csv\"\nat = [0, 1]\n")).find("leave out 'at' and 'value'"), std::string::npos);
    EXPECT_NE(said(scene("")).find("a table needs two points at least"), std::string::npos);
}

} // namespace
} // namespace skein
