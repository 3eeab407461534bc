// TOML 1.0 text to a tree, in one pass and in time proportional to the text, with the place of every key and value.
#pragma once

#include "scene/scene_toml.hpp"

#include <memory>
#include <string>
#include <string_view>

namespace skein {

class TomlParser {
public:
    /// Arrays, inline tables and dotted keys within each other; deeper ones are refused, since the tree is walked by recursion.
    static constexpr int deepest = 100;

    TomlParser(std::string_view text, std::shared_ptr<const SourceText> source);
    TomlValue parse();

private:
    struct Key {
        std::string name;
        Place place;
    };
    using Path = std::vector<Key>;
    class Nested;

    bool ended() const { return at_ == text_.size(); }
    char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
    bool starts(std::string_view word) const { return text_.substr(at_).starts_with(word); }
    bool accept(char c);
    void new_line();
    void skip_spaces();
    void skip_comment();
    void skip_lines(); ///< spaces, comments, line ends
    void expect_line_end();
    std::string next() const; ///< "'x'", "the end of the line"

    Place place(std::size_t length = 1) const; ///< of what stands here
    Place since(Place begin) const;            ///< a place that ends here, or with its line
    [[noreturn]] void fail(const Place& place, const std::string& message) const;
    [[noreturn]] void twice(const TomlEntry& first, const Key& again) const;

    void header();
    TomlTable& parent_of(const Path& path);
    Path path();
    Key key();
    void assignment(TomlTable& table);
    TomlValue value();
    std::string string();
    std::string line_string(char quote);
    std::string block_string(char quote);
    void escape(std::string& out);
    TomlArray array();
    TomlTable inline_table();
    TomlValue word();

    std::string_view text_;
    std::shared_ptr<const SourceText> source_;
    std::size_t at_ = 0, line_start_ = 0;
    int line_ = 1, depth_ = 0;
    TomlTable root_;
    TomlTable* open_ = &root_; ///< the table of the last header
};

} // namespace skein
