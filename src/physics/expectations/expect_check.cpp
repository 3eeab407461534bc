#include "physics/expectations/expect_tables.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"

#include <fmt/format.h>

namespace skein {

void ExpectTables::check(const SceneSpec& scene, Objections& objections) {
    for (std::size_t i = 0; i < scene.expected.size(); ++i) {
        const ExpectSpec& spec = scene.expected[i];
        TableObjections mine(objections, fmt::format("expect.{}", i));
        if (spec.take == ExpectTake::end) mine.unused({"from", "until"}, "with 'take' = \"end\"");
        if (spec.until > 0 && spec.until < spec.from)
            mine.add("until", fmt::format("'until' is {}, before 'from' = {}", spec.until, spec.from));
        if (!(spec.allowed() > 0)) mine.add("scale", "'scale' is needed beside 'value' = 0: 'tolerance' is over it");
        if (spec.reference.empty()) mine.add("reference", "'reference' is empty; name the origin of the value");
        if (!(scene.output.series > 0) && !scene.time.relax)
            mine.add("column", "the scene has no time series: set 'series' in [output]");
    }
}

} // namespace skein
