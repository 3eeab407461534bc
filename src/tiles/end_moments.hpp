// Moments of muscles at the two ends of a rod. A free end has no cell that they could bend. A joint makes such a cell
// (joints/star_law.hpp) and asks for them.
#pragma once

#include "skein/tiles/tile.hpp"

namespace skein {

/// Moment at an end, about the element's body axes and about lab axes, N m. It acts on the element after the place; an
/// element before the place takes the opposite.
template <class P> struct EndMoment { Vec3<P> body{}, lab{}; };

template <int W> struct EndMoments { EndMoment<Pack<W>> start, end; };

/// A pass with such moments.
template <int W> class MakesEndMoments {
public:
    virtual ~MakesEndMoments() = default;
    virtual void add_end_moments(const RodTile<W>& rod, const Step& step, EndMoments<W>& moments) const = 0;
};

} // namespace skein
