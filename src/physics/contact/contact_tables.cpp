#include "physics/contact/contact_tables.hpp"

#include "contact/law_echo.hpp"

namespace skein {

void tidy_echo(nlohmann::json& table, const ContactSpec& spec, const CoreTables&, bool) { tidy_law(table, spec.law); }
void tidy_echo(nlohmann::json& table, const ContactPair& pair, const CoreTables&, bool) { tidy_law(table, pair.law); }

} // namespace skein
