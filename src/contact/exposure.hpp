// Exposure: places and rates of bodies, by slot, for interactions to read; and the loads that interactions give back. Bodies stand
// in it by gid, so its order does not depend on who owns which.
#pragma once

#include "contact/contact_solver.hpp"
#include "contact/contact_spec.hpp"
#include "contact/transposed.hpp"
#include "skein/rod/mapping.hpp"

#include <memory>

namespace skein {

/// Written by one pass, read by all interactions.
struct Exposure {
    Capsules capsules; ///< of all rods of the scene

    /// `materials`: of the laws; 1: all alike.
    Exposure(std::span<const RodGroup> groups, const ContactSpec& spec, std::size_t materials);
    std::size_t first_slot(std::int64_t gid) const {
        return static_cast<std::size_t>(capsules.first_slot[static_cast<std::size_t>(gid)]);
    }
    static constexpr double bytes_per_slot = sizeof(CapsuleNode) + sizeof(CapsuleMotion) + sizeof(std::int32_t);
};

/// Sums of all interactions, by slot of the exposure.
struct SlotLoads {
    AlignedVector<ContactLoad> load;       ///< only of bodies that are touched
    std::span<const std::uint8_t> touched; ///< by gid; not 0 where there is a load

    explicit SlotLoads(std::size_t slots) : load(slots) {}
    static constexpr double bytes_per_slot = sizeof(ContactLoad);
};

/// Last before rods feel each other: nodes, radii, spins in the lab. Radii are those of rest: were they to follow the stretch,
/// contact would do work on it that no force takes.
template <int W> class ExposePass final : public TilePass<W> {
public:
    explicit ExposePass(std::shared_ptr<Exposure> exposure) : exposure_(std::move(exposure)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override {
        using P = Pack<W>;
        CapsuleNode* node[W];
        CapsuleMotion* motion[W];
        for (int l = 0; l < W; ++l) { // spare lanes say again what the last rod does
            const std::size_t first = exposure_->first_slot(rod.group->first_gid() + rod.index[l]);
            node[l] = &exposure_->capsules.node[first];
            motion[l] = &exposure_->capsules.motion[first];
        }
        for (int k = 0; k <= rod.n; ++k) {
            const Slot<W>& s = rod.slot[k];
            P radius(-1.0);
            Vec3<P> turning{};
            if (k < rod.n) {
                const ElementConstants& c = rod.element[k];
                radius = P(c.radius);
                turning = transpose_times(s.director, s.spin);
            }
            store_transposed<W>(s.position, radius, [&](int l) { return &node[l][k].position.x; });
            store_transposed<W>(s.velocity, P(0.0), [&](int l) { return &motion[l][k].velocity.x; });
            store_transposed<W>(turning, P(0.0), [&](int l) { return &motion[l][k].spin.x; });
        }
    }

private:
    std::shared_ptr<Exposure> exposure_;
};

/// Before the kick: forces and couples that interactions have found.
template <int W> class TakeLoadsPass final : public TilePass<W> {
public:
    TakeLoadsPass(std::shared_ptr<const Exposure> exposure, std::shared_ptr<const SlotLoads> loads)
        : exposure_(std::move(exposure)), loads_(std::move(loads)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        static constexpr ContactLoad none{};
        const ContactLoad* taken[W];
        std::size_t step[W];
        bool any = false;
        for (int l = 0; l < W; ++l) {
            const std::int64_t gid = rod.group->first_gid() + rod.index[l];
            const bool touched = loads_->touched[static_cast<std::size_t>(gid)];
            taken[l] = touched ? &loads_->load[exposure_->first_slot(gid)] : &none;
            step[l] = touched;
            any |= touched;
        }
        if (!any) return;
        for (int k = 0; k <= rod.n; ++k) {
            const auto at = [&](int l) -> const ContactLoad& { return taken[l][step[l] * static_cast<std::size_t>(k)]; };
            load[k].force += load_transposed<W>([&](int l) { return &at(l).force.x; }).vector;
            if (k < rod.n)
                load[k].couple += rod.slot[k].director * load_transposed<W>([&](int l) { return &at(l).couple.x; }).vector;
        }
    }

private:
    std::shared_ptr<const Exposure> exposure_;
    std::shared_ptr<const SlotLoads> loads_;
};

} // namespace skein
