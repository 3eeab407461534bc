// The energy audit in the plan of a run.
#pragma once

namespace skein {

struct AuditPlan {
    bool by_steps = false; ///< implicit steps book by themselves, and what they take
};

} // namespace skein
