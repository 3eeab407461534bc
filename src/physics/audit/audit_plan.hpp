// The energy audit in the plan of a run.
#pragma once

namespace skein {

/// Mark of the plan of an audit, which has nothing to tell besides.
struct AuditPlan {};

} // namespace skein
