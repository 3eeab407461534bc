// Objections within a table, passed on to the table around it.
#pragma once

#include "skein/core/objections.hpp"

#include <string>
#include <utility>

namespace skein {

class TableObjections final : public Objections {
public:
    /// `table`: its path from the table around it, e.g. "section", or "rods.0" from the scene.
    TableObjections(Objections& around, std::string table) : around_(around), table_(std::move(table)) {}

    void add(std::string_view key, const std::string& message) override { around_.add(path(key), message); }
    void add_within(std::string_view key, std::size_t begin, std::size_t length, const std::string& message) override {
        around_.add_within(path(key), begin, length, message);
    }
    bool given(std::string_view key) const override { return around_.given(path(key)); }

private:
    std::string path(std::string_view key) const { return key.empty() ? table_ : table_ + "." + std::string(key); }

    Objections& around_;
    std::string table_;
};

} // namespace skein
