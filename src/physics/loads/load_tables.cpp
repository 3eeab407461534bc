#include "physics/loads/load_tables.hpp"

#include "core/field_looker.hpp"

#include <nlohmann/json.hpp>

namespace skein {

namespace {

/// Writes the word for each number that stands for it.
class AutoWords final : public FieldLooker {
public:
    using FieldLooker::visit;
    explicit AutoWords(nlohmann::json& table) : table_(table) {}
    void visit(const Field& f, double& x) override {
        if (f.automatic == x) table_[std::string(f.name)] = "auto";
    }

private:
    nlohmann::json& table_;
};

} // namespace

void tidy_echo(nlohmann::json& table, const LoadSpec& spec, const CoreTables&, bool) {
    LoadSpec copy = spec; // fields() takes what it may change
    AutoWords words(table);
    copy.fields(words);
}

} // namespace skein
