// Implicit steps as a pass: what makes it, and what it takes over from its program.
#pragma once

#include "mechanics/kick.hpp"
#include "mechanics/moving_ends.hpp"

#include <memory>
#include <vector>

namespace skein {

/// A pass of the step that adds loads, which implicit steps evaluate at each correction.
template <int W> struct EvaluatedPass {
    std::unique_ptr<TilePass<W>> pass;
    bool has_slopes; ///< false where its loads do not change with the motion
};

/// Pass that evaluates others of its program by itself.
template <int W> class EvaluatesPasses {
public:
    virtual ~EvaluatesPasses() = default;
    virtual void take(std::vector<EvaluatedPass<W>> passes) = 0;
};

/// Numbers of a group's implicit steps.
template <int W> struct ImplicitParts {
    const RodGroup& group;
    Law law;
    DampingRates rates;
    std::shared_ptr<EndWalls<W>> walls;
};

/// The pass of implicit_pass.hpp, which is compiled by itself.
template <int W> std::unique_ptr<TilePass<W>> make_implicit_pass(const ImplicitParts<W>& parts);

} // namespace skein
