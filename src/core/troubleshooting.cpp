#include "core/troubleshooting.hpp"

#include <algorithm>
#include <iterator>

namespace skein {

namespace {

struct Explained {
    std::string_view part;   ///< of a message, the same in all runs
    std::string_view anchor; ///< on the page
};

/// Causes come before the messages that contain them.
constexpr Explained explained[] = {
    {"unknown key '", "unknown-key"},
    {"unknown table '", "unknown-key"},
    {"missing table [", "missing-key"},
    {"missing key '", "missing-key"},
    {" knows no \"", "unknown-choice"},
    {" is given twice", "given-twice"},
    {"' has no use", "no-use"},
    {": there is no such file", "no-such-file"},
    {", found ", "wrong-type"},
    {" s is beyond the stable limit ", "step-too-long"},
    {"time.dt: nothing limits the time step", "no-limit"},
    {" s is longer than 'duration'", "step-and-duration"},
    {"the scene needs ", "too-large"},
    {" overlap at the start by ", "overlap-at-start"},
    {" of its diameter deep in the wall '", "deep-in-wall"},
    {" m outside the box of the fluid along ", "outside-fluid"},
    {" rods could be packed, ", "packing"},
    {"' does not close: ", "open-ring"},
    {"stiffness = \"auto\" finds neither weight nor a lid's pressure", "no-weight"},
    {": belongs to another scene", "another-scene"},
    {"') but no checkpoint to resume from", "no-checkpoint"},
    {"this program was built without the solver", "no-fluid"},
    {" checkpoints; a segment to be computed again lies between two", "one-checkpoint"},
    {"stopped by a signal", "stopped"},
    {"went well: suspect this machine", "suspect-machine"},
    {"no equilibrium was found", "no-equilibrium"},
    {"likely cause: dt is ", "strained"},
    {" supports a pull of at most E A", "pull-too-strong"},
    {" pass through each other at ", "pass-through"},
    {" has left the fluid through its ", "left-fluid"},
    {"a shorter step does not help", "loads-too-strong"},
    {": in use by another run", "in-use"},
    {": cannot be made a directory", "no-directory"},
    {"disk full: ", "disk-full"},
    {" checkpoints can be read; start again with --overwrite", "checkpoints-damaged"},
    {" computed again lead to digest ", "other-bits"},
    {"not settled in the ", "not-settled"},
    {" of the diameter, since step ", "overlaps"},
    {"rods without damping may have gained energy", "gained-energy"},
    {" rad against each other, and 3 rad stops the run", "turns"},
    {"an axial strain of ", "axial-strain"},
    {" this rank may use", "bound-cores"},
};

} // namespace

std::string with_place_on_page(std::string message) {
    const auto* const found = std::ranges::find_if(
        explained, [&](const Explained& one) { return message.find(one.part) != std::string::npos; });
    if (found == std::end(explained)) return message;
    return message.append("\n  see docs/troubleshooting.md#").append(found->anchor);
}

} // namespace skein
