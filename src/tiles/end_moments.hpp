// Moments that muscles make at the two ends of a rod. A free end has no cell for them to bend; where a joint goes on
// there is one (joints/star_law.hpp), and the joint asks for them.
#pragma once

#include "skein/tiles/tile.hpp"

namespace skein {

/// At an end: about the element's body axes, and about lab axes, N m. On the element after the place; on one before it
/// the opposite.
template <class P> struct EndMoment { Vec3<P> body{}, lab{}; };

template <int W> struct EndMoments { EndMoment<Pack<W>> start, end; };

/// A pass that makes such moments.
template <int W> class MakesEndMoments {
public:
    virtual ~MakesEndMoments() = default;
    virtual void add_end_moments(const RodTile<W>& rod, const Step& step, EndMoments<W>& moments) const = 0;
};

} // namespace skein
