// Keys of a scene for rods that touch each other.
#pragma once

#include "contact/contact_law.hpp"

#include <string>
#include <vector>

namespace skein {

/// [contact]: every rod against every other, and against itself where `self` says so.
struct ContactSpec {
    ContactLaw law;
    bool self = false;
    double self_gap = 0; ///< m along the rod; nearer elements of one rod never touch; 0: half the way round its section
    bool joined = false; ///< rods of one copy of an assembly too, but for elements near a joint
    double overlap = 0.1;       ///< over the diameter: the largest that the time step allows for
    bool allow_overlap = false; ///< at the start, by more than that

    void fields(FieldVisitor& f);
};

/// [[contact_pair]]: another law between two groups.
struct ContactPair {
    std::vector<std::string> between;
    ContactLaw law;
    std::string source; ///< file:line of the table, for messages

    void fields(FieldVisitor& f);
};

} // namespace skein
