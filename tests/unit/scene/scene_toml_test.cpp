// TOML beyond what the library promises: places, keys given twice, depth, bytes that are no text.
#include "scene/scene_toml.hpp"
#include "skein/core/error.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

TomlValue parsed(const std::string& text) { return parse_toml(text, source_text("t.toml", text)); }

/// "line:column: message" without the line below; empty where the text is good.
std::string refusal(const std::string& text) {
    try {
        parsed(text);
    } catch (const InputError& e) {
        const std::string said = e.what();
        return said.substr(7, said.find('\n') - 7);
    }
    return "";
}

TEST(SceneToml, NumbersToTheLastBit) {
    const TomlValue root =
        parsed("a = [-0, 0xDEAD_beef, -9223372036854775808]\nb = [5e+22, 6.626e-34, 224_617.445_991_228]\n");
    const auto& integers = *root.find("a")->value.as<TomlArray>();
    EXPECT_EQ(*integers[0].as<std::int64_t>(), 0);
    EXPECT_EQ(*integers[1].as<std::int64_t>(), 0xdeadbeef);
    EXPECT_EQ(*integers[2].as<std::int64_t>(), std::numeric_limits<std::int64_t>::min());
    const auto& reals = *root.find("b")->value.as<TomlArray>();
    EXPECT_EQ(*reals[0].as<double>(), 5e22);
    EXPECT_EQ(*reals[1].as<double>(), 6.626e-34);
    EXPECT_EQ(*reals[2].as<double>(), 224617.445991228);
}

TEST(SceneToml, PlacesOfKeysAndValues) {
    const TomlValue root = parsed("# head\r\n[one.two]\r\n  key = [1,\r\n  \"x\"]\r\n");
    const TomlEntry& two = *root.find("one")->value.find("two");
    EXPECT_EQ(two.place.line, 2);
    EXPECT_EQ(two.place.column, 6);
    EXPECT_EQ(two.place.length, 3);
    const TomlEntry& key = *two.value.find("key");
    EXPECT_EQ(key.place.column, 3);
    EXPECT_EQ(key.value.place.column, 9);
    const TomlValue& x = (*key.value.as<TomlArray>())[1];
    EXPECT_EQ(x.place.line, 4);
    EXPECT_EQ(x.place.column, 3);
    EXPECT_EQ(x.place.length, 3);
}

/// Places count bytes; the parser counts characters.
TEST(SceneToml, PlacesBehindWideCharacters) {
    const TomlValue root = parsed("a = [\"\xc3\xa4\xe2\x82\xac\", 7]\nb = 1\n");
    const auto& list = *root.find("a")->value.as<TomlArray>();
    EXPECT_EQ(list[0].place.length, 7);
    EXPECT_EQ(list[1].place.column, 15);
    EXPECT_EQ(root.find("b")->value.place.column, 5);
}

TEST(SceneToml, NothingIsOpenedTwice) {
    for (const char* text :
         {"a = 1\na = 2", "[a]\n[a]", "a = 1\n[a]", "a = 1\na.b = 2", "[a]\nb = 1\n[a.b]", "[[a]]\n[a]", "[a]\n[[a]]",
          "a = []\n[[a]]", "a = {b = 1}\na.c = 2", "[[a]]\nb = 1\nb = 2", "[a.b]\nc = 1\n[d]\n[a.b]"})
        EXPECT_NE(refusal(text).find("is given twice; the first is on line"), std::string::npos)
            << text << ": " << refusal(text);
    for (const char* text : {"v = {a = 1, a = 2}", "v = {a.b = 1, a = 2}", "v = [{a = 1},\n{a = 2, a = 3}]"})
        EXPECT_NE(refusal(text).find("is given twice"), std::string::npos) << text << ": " << refusal(text);
    EXPECT_EQ(refusal("[x]\n[[a]]\nb = 1\n[[a]]\nb = 2\n  b = 3\n"), "6:3: 'b' is given twice; the first is on line 5");
    EXPECT_EQ(refusal("[x]\n[a.\"b c\"]\n[y]\n[ a.\"b c\" ]\n"), "4:6: 'b c' is given twice; the first is on line 2");
}

/// The tree is walked by recursion: any depth that the text can have must be refused and not end the program.
TEST(SceneToml, RefusesWhatIsNestedTooDeep) {
    const auto nested = [](std::size_t depth) { return "a = " + std::string(depth, '[') + std::string(depth, ']'); };
    EXPECT_EQ(refusal(nested(200)), "");
    const std::string expected = ": arrays or tables within each other, more than 256 deep";
    EXPECT_EQ(refusal(nested(10000)), "1:261" + expected);
    EXPECT_EQ(refusal("\ntitle = " + std::string(1000000, '[')), "2:265" + expected);
    std::string tables = "a = ", dotted = "a", quoted = "a", blank = "a";
    for (int i = 0; i < 100000; ++i) {
        tables += "{a = ";
        dotted += ".a";
        quoted += ".\"#,\"";
        blank += " . a";
    }
    EXPECT_NE(refusal(tables).find(expected), std::string::npos) << refusal(tables);
    for (const std::string& key : {dotted, quoted, blank})
        for (const std::string& text :
             {key + " = 1", "[" + key + "]", "[[" + key + "]]", "b = 1\nv = {c = 0.5, " + key + " = 1}"})
            EXPECT_NE(refusal(text).find(": a key of more than 16 names"), std::string::npos) << refusal(text);
}

TEST(SceneToml, LongKeysAreNotSeenWhereThereAreNone) {
    std::string numbers, words, dots;
    for (int i = 0; i < 1000; ++i) {
        numbers += "0.5, ";
        words += "0.5 1.5 ";
        dots += ".";
    }
    EXPECT_EQ(refusal("a = [" + numbers + "]"), "");
    EXPECT_EQ(refusal("# " + dots + "\n# " + words + "\na = \"" + words + dots + "\"\nb = '''" + words + "\n" + words +
                      "'''\n"),
              "");
}

TEST(SceneToml, TellsOfBytesThatAreNoText) {
    for (const char* text : {"a = 1\n# a bell: \a\n", "# latin: \xe4\n", "a = 1\rb = 2\n", "# \xc0\xaf", "# \x80"})
        EXPECT_NE(refusal(text), "") << text;
    EXPECT_EQ(refusal("\xef\xbb\xbf# \xc3\xa4 \xf0\x9f\x98\x80\na = 1\n"), "");
}

/// Places counted from the start of the text for each value would take hours.
TEST(SceneToml, LongListsOnOneLineAndOnMany) {
    for (const char* separator : {", ", ",\n# comment\n"}) {
        std::string text = "# \xc3\xa4\na = [\"\xc3\xa4\", ";
        for (int i = 0; i < 300000; ++i) text += std::to_string(i) + separator;
        const TomlValue root = parsed(text + "]");
        const auto& list = *root.find("a")->value.as<TomlArray>();
        ASSERT_EQ(list.size(), 300001u);
        EXPECT_EQ(*list.back().as<std::int64_t>(), 299999);
    }
}

} // namespace
} // namespace skein
