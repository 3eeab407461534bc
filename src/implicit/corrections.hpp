// Corrections of an implicit step: which lanes take theirs, and when they end. Each lane counts its own and stays as it
// is once they end, so that no bit depends on its neighbours.
#pragma once

#include "skein/core/pack.hpp"

#include <cmath>

namespace skein {

template <int W> class Corrections {
    using P = Pack<W>;

public:
    static constexpr int most = 15;
    static constexpr double tolerance = 1e-9; ///< of a correction, over the length and in rad
    static constexpr double most_turn = 0.5;  ///< of a correction, rad; its displacement over the length

    bool goes_on() const { return made_ < most && any(active_); }
    int number() const { return made_; }
    /// Share to be taken of a correction of this size; 0 where a lane is done.
    P share(const P& size) const {
        return select(active_, select(size > P(most_turn), P(most_turn) / size, P(1.0)), P(0.0));
    }
    void note(const P& size) {
        const Mask<W> shrinks = size <= P(0.5) * before_, rounding = size <= P(1e-3 * tolerance);
        active_ = active_ & !((size <= P(tolerance)) & (shrinks | rounding)); // NaN goes on
        before_ = size;
        ++made_;
    }
    /// NaN where they have not converged.
    P wrong() const { return select(active_, P(NAN), P(0.0)); }

private:
    Mask<W> active_ = P(1.0) > P(0.0);
    P before_ = P(0.0); ///< corrections that are small at once may have too stiff a matrix
    int made_ = 0;
};

} // namespace skein
