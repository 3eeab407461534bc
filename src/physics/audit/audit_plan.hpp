// The energy audit in the plan of a run.
#pragma once

namespace skein {

struct AuditPlan {};

} // namespace skein
