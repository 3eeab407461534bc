// What rods show of themselves to each other, and what they feel of each other: shared by the passes of all groups and by whoever
// works contacts out. Rods stand in it by gid, so its order does not depend on who owns which.
#pragma once

#include "contact/contact_solver.hpp"
#include "contact/contact_spec.hpp"
#include "contact/transposed.hpp"
#include "skein/rod/mapping.hpp"

#include <memory>

namespace skein {

struct ContactView {
    Capsules capsules;                     ///< of all rods of the scene
    AlignedVector<ContactLoad> load;       ///< by slot; only where rods are touched
    std::span<const std::uint8_t> touched; ///< by rod

    /// `materials`: of the laws; 1: all alike.
    ContactView(std::span<const RodGroup> groups, const ContactSpec& spec, std::size_t materials);
    std::size_t first_slot(std::int64_t gid) const {
        return static_cast<std::size_t>(capsules.first_slot[static_cast<std::size_t>(gid)]);
    }
    static constexpr double bytes_per_slot =
        sizeof(CapsuleNode) + sizeof(CapsuleMotion) + sizeof(std::int32_t) + sizeof(ContactLoad);
};

/// Last before rods meet: nodes, radii, spins in the lab. Radii are those of rest: were they to follow the stretch, contact would
/// do work on it that no force takes.
template <int W> class ShowPass final : public TilePass<W> {
public:
    explicit ShowPass(std::shared_ptr<ContactView> view) : view_(std::move(view)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override {
        using P = Pack<W>;
        CapsuleNode* node[W];
        CapsuleMotion* motion[W];
        for (int l = 0; l < W; ++l) { // spare lanes say again what the last rod does
            const std::size_t first = view_->first_slot(rod.group->first_gid() + rod.index[l]);
            node[l] = &view_->capsules.node[first];
            motion[l] = &view_->capsules.motion[first];
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
    std::shared_ptr<ContactView> view_;
};

/// Before the kick: forces and couples of the others.
template <int W> class FeelPass final : public TilePass<W> {
public:
    explicit FeelPass(std::shared_ptr<const ContactView> view) : view_(std::move(view)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        static constexpr ContactLoad none{};
        const ContactLoad* felt[W];
        std::size_t step[W];
        bool any = false;
        for (int l = 0; l < W; ++l) {
            const std::int64_t gid = rod.group->first_gid() + rod.index[l];
            const bool touched = view_->touched[static_cast<std::size_t>(gid)];
            felt[l] = touched ? &view_->load[view_->first_slot(gid)] : &none;
            step[l] = touched;
            any |= touched;
        }
        if (!any) return;
        for (int k = 0; k <= rod.n; ++k) {
            const auto at = [&](int l) -> const ContactLoad& { return felt[l][step[l] * static_cast<std::size_t>(k)]; };
            load[k].force += load_transposed<W>([&](int l) { return &at(l).force.x; }).vector;
            if (k < rod.n)
                load[k].couple += rod.slot[k].director * load_transposed<W>([&](int l) { return &at(l).couple.x; }).vector;
        }
    }

private:
    std::shared_ptr<const ContactView> view_;
};

} // namespace skein
