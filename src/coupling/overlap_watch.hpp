// Overlaps of contacts against those that the time step allows for.
#pragma once

#include "contact/contact_law.hpp"
#include "parallel/communicator.hpp"

#include <cstdint>
#include <string>

namespace skein {

/// The largest overlap of contacts or with a wall so far.
struct LargestOverlap {
    std::string of;                  ///< "rods" or a wall's name
    double overlap = 0, allowed = 0; ///< over the diameter
    std::int64_t passed = -1;        ///< step that was the first beyond what the time step allows for; -1: none
    double times = 0;                ///< the stiffness, at which the allowed overlap would take up the same energy
    double stiffness = 0;            ///< of the law; 0: there are several, or it is said otherwise

    /// Text for the user where the allowed overlap has been passed; empty otherwise.
    std::string warning() const;
};

/// Looks at the overlaps of this rank.
struct OverlapWatch {
    std::string of;
    double allowed = 0;
    ContactNormal normal = ContactNormal::hertz;
    double stiffness = 0;
    double overlap = 0;
    std::int64_t passed = -1;
    double times = 0;      ///< the stiffness that it would take by energies of motion too, where these are known
    bool reported = false; ///< to the user: the allowed overlap has been passed

    void take(double now, std::int64_t step);
    bool is_new() const { return passed >= 0 && !reported; }
    /// Largest overlap on all ranks. Collective.
    LargestOverlap largest(const Communicator& comm) const;
};

} // namespace skein
