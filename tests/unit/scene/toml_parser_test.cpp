// TOML 1.0 as its specification has it, and what is refused.
#include "core/error.hpp"
#include "scene/toml_parser.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

TomlValue parsed(const std::string& text) { return parse_toml(text, source_text("t.toml", text)); }

/// "line:column: message" without the line below; empty where the text is good.
std::string complaint(const std::string& text) {
    try {
        parsed(text);
    } catch (const InputError& e) {
        const std::string said = e.what();
        return said.substr(7, said.find('\n') - 7);
    }
    return "";
}

/// What `value = <text>` reads as.
template <class T> T value_of(const std::string& text) {
    const TomlValue root = parsed("value = " + text);
    const T* value = root.find("value")->value.as<T>();
    if (!value) throw std::runtime_error(text + " is " + found(root.find("value")->value));
    return *value;
}

TEST(TomlParser, Integers) {
    EXPECT_EQ(value_of<std::int64_t>("+99"), 99);
    EXPECT_EQ(value_of<std::int64_t>("-0"), 0);
    EXPECT_EQ(value_of<std::int64_t>("5_349_221"), 5349221);
    EXPECT_EQ(value_of<std::int64_t>("0xDEAD_beef"), 0xdeadbeef);
    EXPECT_EQ(value_of<std::int64_t>("0o755"), 0755);
    EXPECT_EQ(value_of<std::int64_t>("0b11010110"), 0xd6);
    EXPECT_EQ(value_of<std::int64_t>("-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
    EXPECT_EQ(value_of<double>("9223372036854775808"), INFINITY); // fits no machine number, and no key
}

TEST(TomlParser, NumbersToTheLastBit) {
    EXPECT_EQ(value_of<double>("+1.0"), 1.0);
    EXPECT_EQ(value_of<double>("-0.0"), 0.0);
    EXPECT_TRUE(std::signbit(value_of<double>("-0.0")));
    EXPECT_EQ(value_of<double>("5e+22"), 5e22);
    EXPECT_EQ(value_of<double>("6.626e-34"), 6.626e-34);
    EXPECT_EQ(value_of<double>("224_617.445_991_228"), 224617.445991228);
    EXPECT_EQ(value_of<double>("0.1e06"), 1e5);
    EXPECT_EQ(value_of<double>("5e-324"), 5e-324);
    EXPECT_EQ(value_of<double>("1e309"), INFINITY);
    EXPECT_EQ(value_of<double>("-inf"), -INFINITY);
    EXPECT_TRUE(std::isnan(value_of<double>("nan")));
}

TEST(TomlParser, NoNumbers) {
    for (const char* text : {".5",    "5.",   "1__0", "_1",  "1_",   "01",  "0x",  "0xg",  "-0x1", "1e",
                             "1e1.0", "1.e5", "+",    "--1", "1.0m", "1,5", "0b2", "1e_5", "INF",  "True"})
        EXPECT_NE(complaint("value = " + std::string(text) + "\n"), "") << text;
}

TEST(TomlParser, Strings) {
    EXPECT_EQ(value_of<std::string>(R"("tab\t quote\" \u00e4 \U0001F600 \\")"), "tab\t quote\" \u00e4 \U0001F600 \\");
    EXPECT_EQ(value_of<std::string>(R"('C:\no\escape')"), R"(C:\no\escape)");
    EXPECT_EQ(value_of<std::string>("\"\"\"\nfirst\n  second\\\n     joined\"\"\""), "first\n  secondjoined");
    EXPECT_EQ(value_of<std::string>("'''a\n'b' ''c'''"), "a\n'b' ''c");
    EXPECT_EQ(value_of<std::string>("\"\"\"four\"\"\"\""), "four\"");
    EXPECT_EQ(value_of<std::string>("\"\""), "");
    for (const char* text : {"\"open", "'open", "\"\\q\"", "\"\\u12\"", "\"\\ud800\"", "\"\"\"open\"\"", "\"two\nlines\""})
        EXPECT_NE(complaint("value = " + std::string(text) + "\n"), "") << text;
}

TEST(TomlParser, DatesAndBooleans) {
    for (const char* text : {"1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", "1979-05-27 00:32:00.999-07:00"})
        value_of<TomlDate>(text);
    EXPECT_TRUE(value_of<bool>("true"));
    EXPECT_FALSE(value_of<bool>("false"));
}

TEST(TomlParser, ArraysOverLines) {
    EXPECT_EQ(value_of<TomlArray>("[]").size(), 0u);
    const auto list = value_of<TomlArray>("[ # one\n 1, # two\n\n [2.0, \"]\"],\n]");
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(*list[0].as<std::int64_t>(), 1);
    EXPECT_EQ(*(*list[1].as<TomlArray>())[1].as<std::string>(), "]");
    for (const char* text : {"[1 2]", "[1,,2]", "[,1]", "[1", "[1}"})
        EXPECT_NE(complaint("value = " + std::string(text)), "") << text;
}

TEST(TomlParser, Tables) {
    const TomlValue root =
        parsed("a.b = 1\na . 'c d' = 2\n[x]\ny = {p.q = 3, r = []}\n[x.z.w]\n[x.z]\nv = 4\n[[l]]\nn = 5\n[l.m]\n[[l]]\n");
    EXPECT_EQ(*root.find("a")->value.find("c d")->value.as<std::int64_t>(), 2);
    const TomlValue& x = root.find("x")->value;
    EXPECT_EQ(*x.find("y")->value.find("p")->value.find("q")->value.as<std::int64_t>(), 3);
    EXPECT_EQ(*x.find("z")->value.find("v")->value.as<std::int64_t>(), 4);
    EXPECT_TRUE(x.find("z")->value.find("w"));
    const auto& list = *root.find("l")->value.as<TomlArray>();
    ASSERT_EQ(list.size(), 2u);
    EXPECT_TRUE(list[0].find("m"));
    EXPECT_FALSE(list[1].find("m"));
}

TEST(TomlParser, NothingIsOpenedTwice) {
    for (const char* text : {"a = 1\na = 2", "[a]\n[a]", "a = 1\n[a]", "a = 1\na.b = 2", "[a]\nb = 1\n[a.b]", "a.b = 1\n[a]",
                             "[[a]]\n[a]", "[a]\n[[a]]", "a = []\n[[a]]", "a = {b = 1}\na.c = 2", "a = {b = 1}\n[a.c]",
                             "v = {a = 1, a = 2}", "v = {a.b = 1, a = 2}", "[a]\nb.c = 1\n[a.b]", "[a.b]\n[a]\nb.c = 1\nb.c = 2"})
        EXPECT_NE(complaint(text).find("is given twice; the first is on line"), std::string::npos)
            << text << ": " << complaint(text);
}

TEST(TomlParser, NoTables) {
    for (const char* text : {"[a", "[[a]", "[]", "[a]]", "[a] b = 1", "= 1", "a", "a = 1 b = 2", "a. = 1", "a..b = 1",
                             "v = {a = 1,}", "v = {a = 1\n}", "v = {", "v = {,}", "v = {a}", "\"a\nb\" = 1"})
        EXPECT_NE(complaint(text), "") << text;
}

TEST(TomlParser, PlacesOfKeysAndValues) {
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

TEST(TomlParser, RefusesWhatIsNestedTooDeep) {
    const auto nested = [](std::size_t depth) { return "a = " + std::string(depth, '[') + std::string(depth, ']'); };
    EXPECT_EQ(complaint(nested(TomlParser::deepest)), "");
    EXPECT_EQ(complaint(nested(TomlParser::deepest + 1)), "1:105: nested deeper than 100 levels");
    EXPECT_EQ(complaint("\ntitle = " + std::string(1000000, '[')), "2:109: nested deeper than 100 levels");
    std::string tables = "a = ", dotted = "a";
    for (int i = 0; i < 20000; ++i) tables += "{a = ", dotted += ".a";
    EXPECT_EQ(complaint(tables), "1:505: nested deeper than 100 levels");
    EXPECT_EQ(complaint(dotted + " = 1"), "1:1: nested deeper than 100 levels");
}

TEST(TomlParser, TellsTheCauseOfBytesThatAreNoText) {
    EXPECT_EQ(complaint("a = 1\n# a bell: \a\n"), "2:11: the control character 0x07; a scene is plain text");
    EXPECT_EQ(complaint("# latin: \xe4\n"), "1:10: the byte 0xe4 is no text in UTF-8");
    EXPECT_EQ(complaint("a = 1\rb = 2\n"), "1:6: the control character 0x0d; a scene is plain text");
    EXPECT_EQ(complaint(std::string("a = [1,\n2\0, 3]", 14)), "2:2: the control character 0x00; a scene is plain text");
    for (const char* bytes : {"\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\x80"})
        EXPECT_NE(complaint("# " + std::string(bytes)), "") << "not shortest, half a pair, beyond the last, cut off, in the middle";
    EXPECT_EQ(complaint("\xef\xbb\xbf# \xc3\xa4 \xf0\x9f\x98\x80\na = 1\n"), "");
}

/// By places counted from the start of the text this takes hours.
TEST(TomlParser, LongListsOnOneLineAndOnMany) {
    for (const char* separator : {", ", ",\n# comment\n"}) {
        std::string text = "a = [";
        for (int i = 0; i < 300000; ++i) text += std::to_string(i) + separator;
        const TomlValue root = parsed(text + "]");
        const auto& list = *root.find("a")->value.as<TomlArray>();
        ASSERT_EQ(list.size(), 300000u);
        EXPECT_EQ(*list.back().as<std::int64_t>(), 299999);
    }
}

} // namespace
} // namespace skein
