#include "contact/static_boxes.hpp"
// The above comes before all templates over packs.
#include "contact/static_contacts.hpp"

#include "contact/attached_slot.hpp"
#include "contact/broad_phase.hpp"
#include "contact/contact_energy.hpp"
#include "contact/static_friction.hpp"
#include "skein/core/error.hpp"

#include <algorithm>

namespace skein {

namespace {

class StaticContactsAt final : public StaticContacts {
public:
    StaticContactsAt(ContactScene scene, std::span<const RodGroup> groups, std::span<const LocalRod> rods,
                     const Threads& threads)
        : scene_(std::move(scene)), threads_(threads), bodies_(groups, rods), search_(threads),
          friction_(scene_, groups, rods, threads) {
        for (const LocalRod& rod : rods) {
            const RodGroup& group = nth(groups, rod.group);
            slots_ += to_index(group.slots());
        }
        attached_ = attached_slots(bodies_, groups, rods);
        set_time(0);
    }

    void set_time(double time) override {
        time_ = time;
        numbers_ = scene_.laws.numbers(time);
    }
    bool rubs() const override { return friction_.acts(); }
    void set_reference(std::span<const Slot<1>> state) override { friction_.set_reference(state); }
    void take_friction(bool acts) override { rubs_ = acts; }
    void make_convex(bool convex) override { convex_ = convex; }
    void keep_springs() override { friction_.keep_springs(); }
    const std::vector<SavedContact>& springs() const override { return friction_.springs(); }
    void set_springs(std::vector<SavedContact> springs) override { friction_.set_springs(std::move(springs)); }

    void evaluate(std::span<const Slot<1>> state, bool with_stiffness, StaticContactLoads& out) override {
        out.energy = out.largest_overlap = 0;
        out.contacts.clear();
        out.force.assign(slots_, Vec3d{0, 0, 0});
        out.couple.assign(slots_, Vec3d{0, 0, 0});
        out.force_size.assign(slots_, 0);
        out.couple_size.assign(slots_, 0);
        out.couplings.clear();
        out.turning.clear();
        put(state);
        find_pairs(out.share);
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
                if (touches[i]) add(pairs_[begin + i], response[i], state, with_stiffness, out);
        }
        for (const Pair pair : box_pairs_) add_box(pair, state, with_stiffness, out);
        if (!rubs_ || !friction_.acts()) return;
        out.force.assign(slots_, Vec3d{0, 0, 0}); // the normal ones are among those of a step
        out.couple.assign(slots_, Vec3d{0, 0, 0});
        friction_.add(bodies_, attached_, state, time_, with_stiffness, out);
    }

    double clear_share(std::span<const Slot<1>> state, std::span<const Slot<1>> moved) override {
        constexpr std::size_t many = 64; // pairs an element, beyond which no wider search is made
        std::vector<Vec3d> way(bodies_.slots());
        double farthest = 0, thinnest = HUGE_VAL;
        put(state);
        for (std::size_t s = 0; s < bodies_.slots(); ++s) {
            way[s] = attached_[s].place(moved[attached_[s].slot]) - bodies_.node[s].position;
            farthest = std::max(farthest, norm(way[s]));
            if (bodies_.has_element(s)) thinnest = std::min(thinnest, bodies_.node[s].radius);
        }
        if (farthest == 0) return 1;
        for (double reach = 2 * thinnest;; reach *= 4) {
            const double most = std::min(1.0, reach / farthest);
            Candidates near;
            search_.build(bodies_, scene_.rules, 2 * most * farthest, near);
            double share = most;
            for_each(near, [&](Pair pair) { share = clear_share(pair, state, moved, way, share); });
            if (share < most || most == 1 || near.count() > many * bodies_.slots()) return share;
        }
    }

    void evaluate_damping(std::span<const Slot<1>> state, StaticContactLoads& out) override {
        out.couplings.clear();
        out.turning.clear();
        if (!friction_.damps(time_)) return;
        put(state);
        friction_.add_damping(bodies_, attached_, state, time_, out);
    }

private:
    /// Places the exposure as in a state.
    void put(std::span<const Slot<1>> state) {
        for (std::size_t s = 0; s < bodies_.slots(); ++s)
            bodies_.node[s].position = attached_[s].place(state[attached_[s].slot]);
    }
    template <class F> void for_each(const Candidates& pairs, F&& f) const {
        for (std::uint32_t a = 0; a < bodies_.slots(); ++a)
            for (std::uint32_t i = pairs.first[a]; i < pairs.first[a + 1]; ++i) f(Pair{a, pairs.partner[i]});
    }

    /// Pairs that may touch, with an element of these slots.
    void find_pairs(const SlotShare& share) {
        Candidates found;
        search_.build(bodies_, scene_.rules, 0, found);
        pairs_.clear();
        box_pairs_.clear();
        for_each(found, [&](Pair pair) {
            const AttachedSlot &a = attached_[pair.a], &b = attached_[pair.b];
            if (share.has(a.slot) || share.has(b.slot)) (a.box || b.box ? box_pairs_ : pairs_).push_back(pair);
        });
    }

    /// The same of one pair, up to `most`: steps that the distance allows at the largest speed of approach.
    double clear_share(Pair pair, std::span<const Slot<1>> state, std::span<const Slot<1>> moved,
                       std::span<const Vec3d> way, double most) const {
        const std::uint32_t node[4] = {pair.a, pair.a + 1, pair.b, pair.b + 1};
        const Vec3d mean = 0.25 * (way[node[0]] + way[node[1]] + way[node[2]] + way[node[3]]);
        const auto speed_of = [&](int n) { return norm(way[node[n]] - mean); };
        double speed = std::max(speed_of(0), speed_of(1)) + std::max(speed_of(2), speed_of(3));
        const double radius[2] = {bodies_.node[pair.a].radius, bodies_.node[pair.b].radius},
                     both = radius[0] + radius[1], least_radius = std::min(radius[0], radius[1]);
        if (attached_[pair.a].box || attached_[pair.b].box) {
            for (const std::uint32_t slot : {pair.a, pair.b}) speed += corner_way(slot, state, moved);
            return std::min(most, 0.5 * least_radius / speed);
        }
        const auto distance_at = [&](double share) {
            Vec3<Pack<1>> place[4];
            for (int n = 0; n < 4; ++n)
                place[n] = broadcast<1>(bodies_.node[node[n]].position + share * (way[node[n]] - mean));
            const auto apart = closest_points(place[0], place[1] - place[0], place[2], place[3] - place[2]).apart;
            return std::sqrt(dot(apart, apart)[0]);
        };
        const double start = distance_at(0);
        if (start >= both + most * speed) return most;
        const double near = std::min(start, both), least = std::max(near - 0.5 * least_radius, 0.5 * near);
        constexpr int most_steps = 1000; // of pairs that graze
        const double close = std::min(0.1 * (start - least), 0.05 * least_radius);
        double share = 0, distance = start;
        for (int i = 0; i < most_steps && distance - least > close; ++i) {
            share += (distance - least) / speed;
            if (share >= most) return most;
            distance = distance_at(share);
        }
        return share;
    }
    /// Farthest way of a box's corners by its turn, m; 0 of others.
    double corner_way(std::uint32_t slot, std::span<const Slot<1>> state, std::span<const Slot<1>> moved) const {
        const AttachedSlot& one = attached_[slot];
        if (!one.box) return 0;
        const Quaterniond a = lane(state[one.slot].director, 0), b = lane(moved[one.slot].director, 0);
        const double cosine = std::min(1.0, std::abs(dot(a, b)));
        return 2 * std::sqrt(1 - cosine * cosine) * one.box->cover(); // |2 sin(turn / 2)|
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
    ContactNumbers<double> numbers_of(Pair pair) const {
        const auto material = [&](std::uint32_t slot) { return to_index(bodies_.at(slot).group); };
        const std::size_t law =
            scene_.laws.materials() == 1 ? 0 : material(pair.a) * scene_.laws.materials() + material(pair.b);
        return scene_.for_bodies(numbers_[law], bodies_.at(pair.a), bodies_.at(pair.b));
    }
    bool respond_at(Pair pair, ContactResponse& response) const {
        const ContactElement<double> element[2] = {element_at(pair.a), element_at(pair.b)};
        return respond({scene_.laws.normal(), numbers_of(pair).stiffness}, element, response);
    }

    void add_box(Pair pair, std::span<const Slot<1>> state, bool with_stiffness, StaticContactLoads& out) const {
        ContactNumbers<double> springs = numbers_of(pair);
        springs.damping = 0;
        const auto [contact, element] = box_contact_at(bodies_, attached_, pair, state, state,
                                                       {scene_.laws.normal(), ContactFriction::none}, springs);
        const auto load = [&, &contact = contact](const MovedElement& a, const MovedElement& b) {
            return contact.load(a, b, 0, BoxContactAtRest::Parts::springs);
        };
        const int still[2] = {-1, -1};
        const BoxLoads loads = load(MovedElement(element[0], still, false), MovedElement(element[1], still, false));
        if (!(loads.overlap > 0)) return;
        for (std::size_t row = 0; row < 4; ++row) {
            const std::size_t slot = element[row / 2].slot[row % 2]->slot;
            const Vec3d force = values_of(loads.force[row]), couple = values_of(loads.couple[row]);
            out.force[slot] += force;
            out.force_size[slot] += norm(force);
            out.couple[slot] += couple;
            out.couple_size[slot] += norm(couple);
        }
        const double diameter = 2 * std::min(contact.radius[0], contact.radius[1]);
        out.energy += loads.energy;
        out.largest_overlap = std::max(out.largest_overlap, loads.overlap / diameter);
        out.contacts.push_back({{attached_[pair.a].slot, attached_[pair.b].slot},
                                {loads.share[0], loads.share[1]},
                                loads.overlap,
                                diameter,
                                values_of(loads.force[0] + loads.force[1])});
        if (with_stiffness) add_slopes_of_loads(Slopes::by_places, element, load, out.turning);
    }

    /// The energy goes with the power p of the overlap d, so that phi'' grad d grad d^T is f f^T (p - 1)/(p phi), with
    /// forces f.
    void leave_turns_of_normals(ContactResponse& response) const {
        const double power = scene_.laws.normal() == ContactNormal::hertz ? 2.5 : 2;
        const double factor = response.energy > 0 ? (power - 1) / (power * response.energy) : 0;
        const auto component = [](const Vec3d& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; };
        for (int i = 0; i < 3 * response.nodes; ++i)
            for (int j = 0; j < 3 * response.nodes; ++j)
                response.stiffness[i][j] = factor * component(response.node[i / 3].force, i % 3) *
                                           component(response.node[j / 3].force, j % 3);
    }

    void add(Pair pair, ContactResponse& response, std::span<const Slot<1>> state, bool with_stiffness,
             StaticContactLoads& out) const {
        const std::uint32_t element[2] = {pair.a, pair.b};
        const AttachedSlot* at[ContactResponse::most_nodes];
        bool turns = false;
        Vec3d on_first{0, 0, 0};
        for (int n = 0; n < response.nodes; ++n) {
            const auto& [of, place, force] = response.node[n];
            const AttachedSlot& one = *(at[n] = &attached_[slot_at(element[of], place)]);
            out.force[one.slot] += force;
            out.force_size[one.slot] += norm(force);
            if (one.on_body) {
                const Vec3d couple = cross(one.arm, lane(state[one.slot].director, 0) * force);
                out.couple[one.slot] += couple;
                out.couple_size[one.slot] += norm(couple);
                turns = true;
            }
            if (of == 0) on_first += force;
        }
        const double diameter = 2 * std::min(bodies_.node[pair.a].radius, bodies_.node[pair.b].radius);
        out.energy += response.energy;
        out.largest_overlap = std::max(out.largest_overlap, response.overlap / diameter);
        out.contacts.push_back({{attached_[pair.a].slot, attached_[pair.b].slot},
                                {response.share[0], response.share[1]},
                                response.overlap,
                                diameter,
                                on_first});
        if (!with_stiffness) return;
        if (convex_) leave_turns_of_normals(response);
        if (turns) return add_turning(response, at, state, out);
        for (int n = 0; n < response.nodes; ++n)
            for (int m = 0; m < response.nodes; ++m) {
                if (!out.share.has(at[m]->slot)) continue;
                SlotCoupling& coupling = out.couplings.emplace_back(SlotCoupling{at[n]->slot, at[m]->slot, {}});
                for (std::size_t i = 0; i < 3; ++i)
                    for (std::size_t j = 0; j < 3; ++j)
                        coupling.block[i][j] = response.stiffness[3 * to_index(n) + i][3 * to_index(m) + j];
            }
    }

    /// Stiffness of places on bodies: J^T K J with J = [1, -Q^T [a]], and what a force adds as its arm turns.
    ///                                                                                            theory.md (97)
    void add_turning(const ContactResponse& response, const AttachedSlot* const (&at)[ContactResponse::most_nodes],
                     std::span<const Slot<1>> state, StaticContactLoads& out) const {
        Vec3d by[ContactResponse::most_nodes][slot_unknowns]; // motion of a node by the unknowns of its slot
        for (int n = 0; n < response.nodes; ++n) {
            auto& own = by[n];
            own[0] = {1, 0, 0};
            own[1] = {0, 1, 0};
            own[2] = {0, 0, 1};
            own[3] = own[4] = own[5] = {0, 0, 0};
            if (!at[n]->on_body) continue;
            const Quaterniond frame = lane(state[at[n]->slot].director, 0);
            const Vec3d turn[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
            for (const int i : {0, 1, 2}) own[3 + i] = transpose_times(frame, cross(turn[i], at[n]->arm));
        }
        for (int n = 0; n < response.nodes; ++n)
            for (int m = 0; m < response.nodes; ++m) {
                SlotCoupling& coupling = out.turning.emplace_back(SlotCoupling{at[n]->slot, at[m]->slot, {}});
                for (int j = 0; j < slot_unknowns; ++j) {
                    const double x[3] = {by[m][j].x, by[m][j].y, by[m][j].z};
                    double f[3] = {0, 0, 0};
                    for (std::size_t r = 0; r < 3; ++r)
                        for (std::size_t c = 0; c < 3; ++c)
                            f[r] += response.stiffness[3 * to_index(n) + r][3 * to_index(m) + c] * x[c];
                    for (int i = 0; i < slot_unknowns; ++i)
                        coupling.block[to_index(i)][to_index(j)] = dot(by[n][i], Vec3d{f[0], f[1], f[2]});
                }
                if (n == m && at[n]->on_body && !convex_)
                    add_turn_of_arm(at[n]->arm, lane(state[at[n]->slot].director, 0) * response.node[n].force,
                                    coupling.block);
            }
    }

    const ContactScene scene_;
    const Threads& threads_;
    std::vector<ContactNumbers<double>> numbers_; ///< now, as the laws are ordered
    Exposure bodies_;
    BroadPhase search_;
    std::vector<AttachedSlot> attached_;  ///< by slot of the exposure
    std::size_t slots_ = 0;               ///< of all rods
    std::vector<Pair> pairs_, box_pairs_; ///< rising; the latter have a box
    double time_ = 0;                     ///< s
    StaticFriction friction_;
    bool rubs_ = true, convex_ = false;
};

} // namespace

std::unique_ptr<StaticContacts> make_static_contacts(ContactScene scene, std::span<const RodGroup> groups,
                                                     std::span<const LocalRod> rods, const Threads& threads) {
    return std::make_unique<StaticContactsAt>(std::move(scene), groups, rods, threads);
}

} // namespace skein
