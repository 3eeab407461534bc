// What pushes rods that relax besides their own loads: walls and other rods.                              theory.md
// section 21
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"

namespace skein {

namespace detail {
/// Forces of a tile before walls and contacts add theirs; of this thread.
template <int W> AlignedVector<Vec3<Pack<W>>>& untouched_forces() {
    static thread_local AlignedVector<Vec3<Pack<W>>> forces;
    return forces;
}
} // namespace detail

/// Before walls and contacts: what they add tells the relaxation where rods are touched.
template <int W> class NoteForcesPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        auto& forces = detail::untouched_forces<W>();
        if (forces.size() <= static_cast<std::size_t>(rod.n)) forces.resize(static_cast<std::size_t>(rod.n) + 1);
        for (int k = 0; k <= rod.n; ++k) nth(forces, k) = load[k].force;
        if (rod.group->closed()) forces[0] += load[rod.n].force; // as the load itself will
    }
    bool adds_loads() const override { return false; }
};

} // namespace skein
