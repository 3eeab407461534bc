#include "contact/static_contacts.hpp"

#include "contact/broad_phase.hpp"
#include "contact/contact_energy.hpp"
#include "skein/core/error.hpp"

#include <algorithm>

namespace skein {

namespace {

class StaticContactsAt final : public StaticContacts {
public:
    StaticContactsAt(ContactScene scene, std::span<const RodGroup> groups, std::span<const LocalRod> rods,
                     const Threads& threads)
        : scene_(std::move(scene)), threads_(threads), bodies_(groups, rods), search_(threads) {
        state_slot_.resize(bodies_.slots());
        for (std::size_t i = 0; i < rods.size(); ++i) {
            const RodGroup& group = nth(groups, rods[i].group);
            if (!group.strained())
                throw InputError("bodies of '" + group.name() +
                                 "' are rigid, and contacts at rest know rods alone; leave [contact] out, or replace "
                                 "the bodies by stiff rods");
            const Window& window = bodies_.window[bodies_.number_of_own(i)];
            for (std::uint32_t k = 0; k < window.slots; ++k) {
                const std::size_t node = group.closed() && k + 1 == window.slots ? 0 : k; // where a ring closes
                state_slot_[window.first_slot + k] = slots_ + node;
            }
            slots_ += to_index(group.slots());
        }
        set_time(0);
    }

    void set_time(double time) override { numbers_ = scene_.laws.numbers(time); }

    void evaluate(std::span<const Slot<1>> state, bool with_stiffness, StaticContactLoads& out) override {
        out.energy = out.largest_overlap = 0;
        out.contacts.clear();
        out.force.assign(slots_, Vec3d{0, 0, 0});
        out.force_size.assign(slots_, 0);
        out.couplings.clear();
        for (std::size_t s = 0; s < bodies_.slots(); ++s)
            bodies_.node[s].position = lane(state[state_slot_[s]].position, 0);
        find_pairs();
        // A few hundred pairs at a time, as each response has 5 kB.
        constexpr std::size_t at_once = 512, in_task = 16;
        std::vector<ContactResponse> response(std::min(at_once, pairs_.size()));
        std::vector<std::uint8_t> touches(response.size());
        for (std::size_t begin = 0; begin < pairs_.size(); begin += at_once) {
            const std::size_t count = std::min(at_once, pairs_.size() - begin);
            threads_.for_each((count + in_task - 1) / in_task, [&](std::size_t task, int) {
                for (std::size_t i = task * in_task; i < std::min(count, (task + 1) * in_task); ++i)
                    touches[i] = respond_at(pairs_[begin + i], response[i]);
            });
            for (std::size_t i = 0; i < count; ++i)
                if (touches[i]) add(pairs_[begin + i], response[i], with_stiffness, out);
        }
    }

private:
    /// Pairs that touch and may.
    void find_pairs() {
        Candidates found;
        search_.build(bodies_, scene_.rules, 0, found);
        pairs_.clear();
        for (std::uint32_t a = 0; a < bodies_.slots(); ++a)
            for (std::uint32_t i = found.first[a]; i < found.first[a + 1]; ++i) pairs_.push_back({a, found.partner[i]});
    }

    /// Slot of the exposure whose node stands at a place of ContactElement::node.
    std::uint32_t slot_at(std::uint32_t element, int place) const {
        switch (place) {
        case 0:
            return bodies_.neighbour(element, -1);
        case 3:
            return bodies_.neighbour(element, 1) + 1;
        default:
            return element + static_cast<std::uint32_t>(place - 1);
        }
    }
    ContactElement<double> element_at(std::uint32_t slot) const {
        const std::uint8_t vertices = bodies_.vertices[slot];
        const bool before = vertices & at_start, after = vertices & at_end;
        const auto place = [&](int at) { return bodies_.node[slot_at(slot, at)].position; };
        return {{place(before ? 0 : 1), place(1), place(2), place(after ? 3 : 2)},
                {before, after},
                bodies_.node[slot].radius};
    }
    bool respond_at(Pair pair, ContactResponse& response) const {
        const auto material = [&](std::uint32_t slot) { return to_index(bodies_.at(slot).group); };
        const std::size_t law =
            scene_.laws.materials() == 1 ? 0 : material(pair.a) * scene_.laws.materials() + material(pair.b);
        const ContactElement<double> element[2] = {element_at(pair.a), element_at(pair.b)};
        return respond({scene_.laws.normal(), numbers_[law].stiffness}, element, response);
    }

    void add(Pair pair, const ContactResponse& response, bool with_stiffness, StaticContactLoads& out) const {
        const std::uint32_t element[2] = {pair.a, pair.b};
        std::size_t slot[ContactResponse::most_nodes];
        Vec3d on_first{0, 0, 0};
        for (int n = 0; n < response.nodes; ++n) {
            const auto& [of, place, force] = response.node[n];
            slot[n] = state_slot_[slot_at(element[of], place)];
            out.force[slot[n]] += force;
            out.force_size[slot[n]] += norm(force);
            if (of == 0) on_first += force;
        }
        const double diameter = 2 * std::min(bodies_.node[pair.a].radius, bodies_.node[pair.b].radius);
        out.energy += response.energy;
        out.largest_overlap = std::max(out.largest_overlap, response.overlap / diameter);
        out.contacts.push_back({{state_slot_[pair.a], state_slot_[pair.b]},
                                {response.share[0], response.share[1]},
                                response.overlap,
                                diameter,
                                on_first});
        if (!with_stiffness) return;
        for (int n = 0; n < response.nodes; ++n)
            for (int m = 0; m < response.nodes; ++m) {
                SlotCoupling& coupling = out.couplings.emplace_back(SlotCoupling{slot[n], slot[m], {}});
                for (std::size_t i = 0; i < 3; ++i)
                    for (std::size_t j = 0; j < 3; ++j)
                        coupling.block[i][j] = response.stiffness[3 * to_index(n) + i][3 * to_index(m) + j];
            }
    }

    const ContactScene scene_;
    const Threads& threads_;
    std::vector<ContactNumbers<double>> numbers_; ///< now, as the laws are ordered
    Exposure bodies_;
    BroadPhase search_;
    std::vector<std::size_t> state_slot_; ///< by slot of the exposure; a ring's last node is its first one
    std::size_t slots_ = 0;               ///< of all rods
    std::vector<Pair> pairs_;             ///< rising
};

} // namespace

std::unique_ptr<StaticContacts> make_static_contacts(ContactScene scene, std::span<const RodGroup> groups,
                                                     std::span<const LocalRod> rods, const Threads& threads) {
    return std::make_unique<StaticContactsAt>(std::move(scene), groups, rods, threads);
}

} // namespace skein
