// The outputs that a run may have: the order is that in which they are written. A checkpoint comes last, as it holds
// how far the others have come.
#include "simulation/output.hpp"

namespace skein {

using MakeOutput = std::unique_ptr<Output>(const OutputParts& parts); // null where the plan has no use for it

MakeOutput make_series, make_trajectory, make_poly_data, make_tips, make_fluid_frames, make_contact_tables,
    make_checkpoints, make_progress;

void make_outputs(const OutputParts& parts) {
    for (MakeOutput* make : {make_series, make_trajectory, make_poly_data, make_tips, make_fluid_frames,
                             make_contact_tables, make_checkpoints, make_progress})
        if (auto output = make(parts)) parts.outputs.push_back(std::move(output));
}

} // namespace skein
