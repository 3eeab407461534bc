// Bodies as interactions see them, made by hand: each a group of its own.
#pragma once

#include "contact/contact_solver.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace skein::test {

/// With damping, and friction of any kind.
inline ContactLaw some_law(ContactNormal normal, ContactFriction friction) {
    return {.normal = normal,
            .stiffness = 1e5,
            .damping = 20,
            .friction = friction,
            .static_friction = 0.5,
            .kinetic_friction = 0.4,
            .tangential_damping = 5,
            .slip_speed = 1e-3};
}

class BodiesByHand {
public:
    /// Nodes, in order, of a ring with the first once more at the end, and for all elements a radius; `gap`: see
    /// SelfGap.
    void add(std::span<const Vec3d> nodes, double radius, std::int32_t gap = -1, bool closed = false) {
        const std::int64_t first = groups_.empty() ? 0 : windows_.back().first_in_scene + windows_.back().slots;
        windows_.push_back({static_cast<std::int64_t>(groups_.size()), first, 0,
                            static_cast<std::uint32_t>(nodes.size()), static_cast<int>(groups_.size()), true});
        groups_.push_back({1, static_cast<std::int64_t>(nodes.size()), closed ? Chain::ring : Chain::open});
        for (std::size_t k = 0; k < nodes.size(); ++k) nodes_.push_back({nodes[k], k + 1 < nodes.size() ? radius : -1});
        rules.of_group.push_back({.elements = gap, .ring = closed ? static_cast<std::int32_t>(nodes.size()) - 1 : 0});
    }
    /// `own`: by body; the others are ghosts that are here as a whole. None: all.
    Exposure exposure(std::span<const std::uint8_t> own = {}) const {
        std::vector<Window> windows(windows_);
        for (std::size_t b = 0; b < own.size(); ++b) windows[b].own = own[b] != 0;
        Exposure bodies(SceneSlots(groups_), std::move(windows));
        std::copy(nodes_.begin(), nodes_.end(), bodies.node.begin());
        return bodies;
    }
    /// One law for all, or laws of as many materials as there are bodies.
    ContactScene scene(ContactLaws laws) const {
        ContactScene all{std::move(laws), rules, 0, static_cast<std::int64_t>(nodes_.size())};
        double sum = 0, elements = 0;
        for (const ExposedNode& n : nodes_)
            if (n.radius >= 0) {
                sum += 2 * n.radius;
                ++elements;
            }
        all.diameter = sum / elements;
        return all;
    }

    TouchRules rules;

private:
    std::vector<SceneSlots::Alike> groups_;
    std::vector<Window> windows_;
    std::vector<ExposedNode> nodes_;
};

} // namespace skein::test
