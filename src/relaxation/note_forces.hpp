// Record of the forces on relaxing rods before walls and other rods act. theory.md section 21
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"

namespace skein {

namespace detail {
/// Forces of a tile before walls and contacts act, by thread.
template <int W> AlignedVector<Vec3<Pack<W>>>& untouched_forces() {
    static thread_local AlignedVector<Vec3<Pack<W>>> forces;
    return forces;
}
} // namespace detail

/// Pass before walls and contacts: the forces that they add show the relaxation where rods are touched.
template <int W> class NoteForcesPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        auto& forces = detail::untouched_forces<W>();
        if (forces.size() <= to_index(rod.n)) forces.resize(to_index(rod.n) + 1);
        for (int k = 0; k <= rod.n; ++k) nth(forces, k) = load[k].force;
        if (rod.group->closed()) forces[0] += load[rod.n].force; // as the load itself will
    }
    bool adds_loads() const override { return false; }
};

} // namespace skein
