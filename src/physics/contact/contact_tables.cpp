#include "physics/contact/contact_tables.hpp"

#include "contact/law_echo.hpp"

#include <map>

namespace skein {

void tidy_echo(nlohmann::json& table, const ContactSpec& spec, const CoreTables&, bool) { tidy_law(table, spec.law); }
void tidy_echo(nlohmann::json& table, const ContactPair& pair, const CoreTables&, bool) { tidy_law(table, pair.law); }

std::string_view ContactTables::remark(std::string_view table) {
    static const std::map<std::string_view, std::string_view> remarks = {
        {"contact", "Without this table rods do not feel each other, and nothing is searched, kept or sent."},
        {"contact_pair", "Another law between two groups than `[contact]` says."},
    };
    const auto at = remarks.find(table);
    return at == remarks.end() ? "" : at->second;
}

} // namespace skein
