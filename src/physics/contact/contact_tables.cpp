#include "physics/contact/contact_tables.hpp"

#include "contact/law_echo.hpp"

#include <map>

namespace skein {

void tidy_echo(nlohmann::json& table, const ContactSpec& spec, const CoreTables&, bool) { tidy_law(table, spec.law); }
void tidy_echo(nlohmann::json& table, const ContactPair& pair, const CoreTables&, bool) { tidy_law(table, pair.law); }

std::string_view ContactTables::remark(std::string_view table) {
    static const std::map<std::string_view, std::string_view> remarks = {
        {"contact", "Without this table there are no contacts between rods, and no cost for them."},
        {"contact_pair", "A law between two groups that differs from `[contact]`."},
    };
    const auto at = remarks.find(table);
    return at == remarks.end() ? "" : at->second;
}

} // namespace skein
