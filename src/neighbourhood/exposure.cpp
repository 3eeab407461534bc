#include "neighbourhood/exposure.hpp"

#include "neighbourhood/surface.hpp"
#include "parallel/blocks.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace skein {

Exposure::Exposure(std::span<const RodGroup> groups, std::span<const LocalRod> bodies)
    : scene_(groups), bodies_(bodies.begin(), bodies.end()) {
    first_of_group_.assign(groups.size(), bodies_.size());
    for (std::size_t i = bodies_.size(); i-- > 0;) nth(first_of_group_, bodies_[i].group) = i;
    for (const LocalRod& body : bodies_)
        window.push_back({body.gid, scene_.first_slot(body.gid), 0,
                          static_cast<std::uint32_t>(scene_.slots_of(body.gid)), body.group, true});
    std::sort(window.begin(), window.end(), [](const Window& x, const Window& y) { return x.gid < y.gid; });
    lay_out(true);
    find_own();
    for (const Window& w : window) {
        const RodGroup& all = nth(groups, w.group);
        const RodGroup& group = all.kind(w.gid - all.first_gid());
        for (std::uint32_t k = 0; k < w.slots; ++k)
            node[w.first_slot + k].radius = group.exposed_radius(static_cast<int>(k));
    }
}

Exposure::Exposure(const SceneSlots& scene, std::vector<Window> windows, bool rates)
    : window(std::move(windows)), scene_(scene) {
    lay_out(rates);
    if (!std::all_of(window.begin(), window.end(), [](const Window& w) { return w.own; }))
        for (const Window& w : window) own.push_back(w.own);
}

void Exposure::lay_out(bool rates) {
    for (std::size_t i = 0; i < window.size(); ++i) {
        window[i].first_slot = static_cast<std::uint32_t>(window_of.size());
        window_of.insert(window_of.end(), window[i].slots, static_cast<std::int32_t>(i));
        const Window& w = window[i];
        const Chain chain = scene_.chain_of(w.gid);
        const std::int64_t first = w.first_in_scene - scene_.first_slot(w.gid),
                           last_element = scene_.slots_of(w.gid) - 2;
        for (std::int64_t k = first; k < first + w.slots; ++k) {
            const bool before = chain == Chain::ring || (chain == Chain::open && k > 0),
                       after = chain == Chain::ring || (chain == Chain::open && k < last_element);
            vertices.push_back(static_cast<std::uint8_t>((before ? at_start : 0) | (after ? at_end : 0)));
        }
    }
    if (scene_.has_kin()) {
        std::unordered_map<std::int64_t, std::int32_t> first;
        for (std::size_t i = 0; i < window.size(); ++i)
            kin.push_back(first.emplace(scene_.kin_of(window[i].gid), static_cast<std::int32_t>(i)).first->second);
    }
    node.assign(window_of.size(), {{}, -1});
    pace.assign(window_of.size(), 1);
    if (rates) motion.assign(window_of.size(), {});
}

void Exposure::find_own() {
    own_window_.clear();
    for (const LocalRod& body : bodies_) {
        const auto at = std::lower_bound(window.begin(), window.end(), scene_.first_slot(body.gid),
                                         [](const Window& w, std::int64_t slot) { return w.first_in_scene < slot; });
        own_window_.push_back(static_cast<std::uint32_t>(at - window.begin()));
    }
}

std::uint32_t Exposure::neighbour(std::size_t slot, int step) const {
    const std::int64_t k = element(slot), last = scene_.slots_of(at(slot).gid) - 2;
    const bool seam = step < 0 ? k == 0 : k == last; // a ring closes there
    return seam ? find(in_scene(slot) - step * last).value()
                : static_cast<std::uint32_t>(static_cast<std::int64_t>(slot) + step);
}

std::optional<std::uint32_t> Exposure::find(std::int64_t in_scene) const {
    if (slots() == to_index(scene_.count())) return static_cast<std::uint32_t>(in_scene); // all of the scene is here
    const auto after = std::upper_bound(window.begin(), window.end(), in_scene,
                                        [](std::int64_t slot, const Window& w) { return slot < w.first_in_scene; });
    if (after == window.begin()) return {};
    const Window& w = *(after - 1);
    const std::int64_t k = in_scene - w.first_in_scene;
    if (k >= w.slots) return {};
    return w.first_slot + static_cast<std::uint32_t>(k);
}

void Exposure::show(std::size_t i, std::span<const Slot<1>> state, const BodyShape* body) {
    const Window& w = window[own_window_[i]];
    if (body) {
        std::size_t slot = w.first_slot;
        for_surface_slots(*body, state[0], [&](const auto& position, double, const auto& velocity, const auto& spin) {
            node[slot].position = lane(position, 0);
            motion[slot].velocity = lane(velocity, 0);
            motion[slot].spin = lane(spin, 0);
            ++slot;
        });
        return;
    }
    for (std::size_t k = 0; k < state.size(); ++k) {
        const Slot<1>& s = state[k];
        node[w.first_slot + k].position = lane(s.position, 0);
        ExposedMotion& shown = motion[w.first_slot + k];
        shown.velocity = lane(s.velocity, 0);
        shown.spin = has_element(w.first_slot + k) ? lane(transpose_times(s.director, s.spin), 0) : Vec3d{0, 0, 0};
    }
}

void Exposure::become(Exposure&& other) {
    auto from = window.begin();
    for (const Window& w : other.window) {
        if (!w.own) continue;
        while (!from->own) ++from;
        std::copy_n(node.begin() + from->first_slot, w.slots, other.node.begin() + w.first_slot);
        std::copy_n(motion.begin() + from->first_slot, w.slots, other.motion.begin() + w.first_slot);
        std::copy_n(pace.begin() + from->first_slot, w.slots, other.pace.begin() + w.first_slot);
        ++from;
    }
    node.swap(other.node);
    motion.swap(other.motion);
    pace.swap(other.pace);
    window_of.swap(other.window_of);
    vertices.swap(other.vertices);
    window.swap(other.window);
    own.swap(other.own);
    kin.swap(other.kin);
    find_own();
}

/// Balls and boxes have one place in two slots, and a box its axes in the rates of the second.
double Exposure::speed(std::size_t slot) const {
    const bool same_place = !has_element(slot) && slot > 0 && norm(node[slot].position - node[slot - 1].position) == 0;
    return norm(motion[same_place ? slot - 1 : slot].velocity);
}

/// f(slot, block) for the slots of own bodies.
template <class F> void Exposure::for_own_slots(const Threads& threads, F&& f) const {
    for_blocks(threads, slots(), [&](std::size_t begin, std::size_t end, std::size_t block) {
        for (std::size_t slot = begin; slot < end; ++slot)
            if (owns_slot(slot)) f(slot, block);
    });
}

double Exposure::largest_speed(const Threads& threads) const {
    std::vector<double> largest(blocks_of(slots()));
    for_own_slots(threads,
                  [&](std::size_t slot, std::size_t block) { largest[block] = std::max(largest[block], speed(slot)); });
    return largest.empty() ? 0 : *std::max_element(largest.begin(), largest.end());
}

void Exposure::set_paces(const Threads& threads, double largest_speed) {
    for_own_slots(threads, [&](std::size_t slot, std::size_t) {
        const double share = speed(slot) / largest_speed; // of a rod that is lost no number
        pace[slot] =
            largest_speed > 0 ? static_cast<float>(share > least_pace ? std::min(share, 1.0) : least_pace) : 1.0f;
    });
}

void SlotLoads::begin(const Exposure& bodies) {
    load.resize(bodies.slots());
    marks_.assign(bodies.window.size(), 0);
    touched = marks_;
}

ExertedLoad& SlotLoads::at(const Exposure& bodies, std::size_t slot) {
    if (touched.data() != marks_.data()) {
        marks_.assign(touched.begin(), touched.end());
        touched = marks_;
    }
    const std::size_t window = to_index(bodies.window_of[slot]);
    if (marks_[window] == 0) {
        const Window& all = bodies.window[window];
        std::fill_n(load.begin() + all.first_slot, all.slots, ExertedLoad{});
        marks_[window] = 1;
    }
    return load[slot];
}

} // namespace skein
