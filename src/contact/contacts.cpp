#include "contact/contacts.hpp"

#include "parallel/blocks.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

// The skin is such that searches cost as much as the pairs that do not touch, whoever owns them: all ranks choose the same.
constexpr double search_cost = 15;  // of an element, in such pairs
constexpr double least_skin = 0.01; // in diameters

double mean_diameter(const Capsules& c) {
    double sum = 0;
    std::size_t count = 0;
    for (const CapsuleNode& n : c.node)
        if (n.radius >= 0) sum += 2 * n.radius, ++count;
    return count > 0 ? sum / static_cast<double>(count) : 0;
}

} // namespace

Contacts::Contacts(const Capsules& capsules, ContactLaws laws, const Threads& threads, std::vector<std::uint8_t> owned_rods)
    : laws_(std::move(laws)), kinds_{laws_.normal(), laws_.friction()}, remembers_(laws_.remember()), threads_(threads),
      owned_(std::move(owned_rods)), search_(capsules, threads), diameter_(mean_diameter(capsules)),
      first_slot_(capsules.first_slot), mail_(capsules), finds_(mail_.blocks().size()),
      post_(static_cast<std::size_t>(threads.count())), touched_(capsules.first_slot.size() - 1, 0) {
    figures_.skin = 0.25 * diameter_;
}

/// The places of some nodes; behind the last one that one again.
Contacts::Places Contacts::places(const Capsules& capsules, std::size_t tile) {
    const std::size_t first = tile * places_at_once, last = capsules.slots() - 1;
    return load_transposed<places_at_once>(
               [&](int l) { return &capsules.node[std::min(first + static_cast<std::size_t>(l), last)].position.x; })
        .vector;
}

/// Whether some of these rods, or neighbours by number, have moved further than the list allows.
bool Contacts::far(const Capsules& capsules, const RodBlock& block) const {
    const double most = 0.25 * figures_.skin * figures_.skin; // each of two may go half the way
    Pack<places_at_once> furthest(0.0);
    for (std::size_t tile = block.first_slot / places_at_once; tile * places_at_once < block.last_slot; ++tile) {
        const Places moved = places(capsules, tile) - place_[tile];
        furthest = max(furthest, dot(moved, moved));
    }
    return any(!(furthest < Pack<places_at_once>(most)));
}

void Contacts::carry_over(const PairList& fresh, const Capsules& capsules) {
    AlignedVector<ContactMemory<double>> memory(fresh.count() + 1, ContactMemory<double>{});
    std::vector<std::uint8_t> what(fresh.count() + PairList::padding, 0);
    const std::size_t slots = list_.count() > 0 ? fresh.first.size() - 1 : 0;
    std::vector<double> lost(blocks_of(slots), 0.0);
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t block) {
        for (std::size_t a = begin; a < end; ++a) {
            std::uint32_t i = fresh.first[a];
            for (std::uint32_t old = list_.first[a]; old < list_.first[a + 1]; ++old) {
                while (i < fresh.first[a + 1] && fresh.pair[i].b < list_.pair[old].b) ++i;
                if (i < fresh.first[a + 1] && fresh.pair[i].b == list_.pair[old].b) what[i] = what_[old], memory[i] = memory_[old];
                else if (what_[old] & touching && owns(static_cast<std::size_t>(capsules.rod[a])))
                    lost[block] += memory_[old].energy();
            }
        }
    });
    for (const double energy : lost) figures_.rubbed += energy;
    memory_ = std::move(memory);
    what_ = std::move(what);
}

/// A list may last so long that its idle pairs cost more than a new one with less skin.
bool Contacts::is_wasteful() const {
    return figures_.skin > least_skin * diameter_ &&
           static_cast<double>(age_) * static_cast<double>(idle_) > 4 * search_cost * static_cast<double>(first_slot_.back());
}

void Contacts::renew_list(const Capsules& capsules) {
    const Timers::Guard timing(figures_.search_s);
    if (figures_.renewals > 0 && age_ > 0) {
        // Idle pairs grow with the skin, searches per step fall with it.
        const double search = search_cost * static_cast<double>(capsules.slots()) / static_cast<double>(age_);
        const double change = std::clamp(std::sqrt(search / static_cast<double>(std::max<std::int64_t>(idle_, 1))), 0.5, 1.5);
        figures_.skin = std::clamp(figures_.skin * change, least_skin * diameter_, diameter_);
    }
    age_ = 0;
    ++figures_.renewals;

    Candidates candidates;
    search_.build(capsules, figures_.skin, candidates, owned_);
    idle_ = candidates.idle;
    PairList fresh(std::move(candidates), threads_, kinds_.friction == ContactFriction::memory);
    carry_over(fresh, capsules);
    list_ = std::move(fresh);
    last_memory_.assign(list_.count() + 1, ContactMemory<double>{});
    was_.assign(list_.count() + PairList::padding, 0);
    mail_.make_room(list_, capsules, threads_);
    place_.resize((capsules.slots() + places_at_once - 1) / places_at_once);
    for (std::size_t tile = 0; tile < place_.size(); ++tile) place_[tile] = places(capsules, tile);
    figures_.listed = 0;
    for (std::size_t rod = 0; rod + 1 < first_slot_.size(); ++rod)
        if (owns(rod))
            figures_.listed += list_.first[static_cast<std::size_t>(first_slot_[rod + 1])] -
                               list_.first[static_cast<std::size_t>(first_slot_[rod])];
}

void Contacts::restore(std::span<const KeptContact> kept, double rubbed, double damped) {
    figures_.rubbed = rubbed;
    figures_.damped = damped;
    // As if it were the list of the step before; as nobody knows how far things have moved since, it is renewed at once.
    std::vector<KeptContact> sorted(kept.begin(), kept.end());
    std::sort(sorted.begin(), sorted.end(),
              [](const KeptContact& x, const KeptContact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    list_ = {};
    list_.first.assign(static_cast<std::size_t>(first_slot_.back()) + 1, 0);
    what_.clear();
    memory_.clear();
    for (const KeptContact& c : sorted) {
        ++list_.first[c.a + 1];
        list_.pair.push_back({c.a, c.b});
        what_.push_back(static_cast<std::uint8_t>(c.what));
        memory_.push_back(c.memory);
    }
    std::partial_sum(list_.first.begin(), list_.first.end(), list_.first.begin());
    place_.clear();
}

std::vector<KeptContact> Contacts::kept() const {
    std::vector<KeptContact> all;
    if (list_.first.empty()) return all; // nothing has been evaluated
    for (std::size_t rod = 0; rod + 1 < first_slot_.size(); ++rod) {
        if (!owns(rod)) continue;
        for (std::uint32_t i = list_.first[static_cast<std::size_t>(first_slot_[rod])];
             i < list_.first[static_cast<std::size_t>(first_slot_[rod + 1])]; ++i)
            if (what_[i] & touching) all.push_back({list_.pair[i].a, list_.pair[i].b, what_[i], memory_[i]});
    }
    return all;
}

/// Loads of all contacts, unless some rod turns out to have moved too far for the list.
bool Contacts::evaluate_listed(const Capsules& capsules, double h, AlignedVector<ContactLoad>& loads) {
    const std::size_t blocks = mail_.blocks().size();
    const std::size_t strips =
        threads_.count() == 1 ? 1 : std::min<std::size_t>(blocks, 2 * static_cast<std::size_t>(threads_.count()));
    const auto begin_of = [&](std::size_t strip) { return strip * blocks / strips; };
    std::atomic<bool> too_far = false;
    std::vector<std::uint8_t> received(blocks, 0);
    threads_.for_each(strips, [&](std::size_t strip, int thread) {
        for (std::size_t block = begin_of(strip); block < begin_of(strip + 1); ++block) {
            if (too_far.load(std::memory_order_relaxed)) return;
            if (far(capsules, mail_.blocks()[block])) too_far.store(true, std::memory_order_relaxed);
            push(capsules, h, block, post_[static_cast<std::size_t>(thread)], loads);
            if (mail_.first_sender(block) < begin_of(strip)) continue;
            receive(capsules, block, loads);
            received[block] = 1;
        }
    });
    if (too_far) return false;
    if (strips > 1)
        threads_.for_each(blocks, [&](std::size_t block, int) {
            if (!received[block]) receive(capsules, block, loads);
        });
    return true;
}

void Contacts::evaluate(const Capsules& capsules, double time, double h, AlignedVector<ContactLoad>& loads) {
    numbers_ = laws_.numbers(time);
    loads.resize(capsules.slots());
    if (place_.empty() || is_wasteful()) renew_list(capsules);
    const auto turn = [&] { // what was new is what was before
        std::swap(memory_, last_memory_);
        std::swap(what_, was_);
    };
    turn();
    if (!evaluate_listed(capsules, h, loads)) {
        turn(); // as if this step had not begun
        renew_list(capsules);
        turn();
        evaluate_listed(capsules, h, loads);
    }
    ++age_;
    ContactFigures& f = figures_;
    f.active = 0;
    f.deepest = f.stiffest = f.stored = 0;
    for (const Finds& found : finds_) {
        f.active += found.active;
        f.deepest = std::max(f.deepest, found.deepest), f.stiffest = std::max(f.stiffest, found.stiffest);
        f.stored += found.stored, f.rubbed += found.rubbed, f.damped += found.damped;
    }
}

std::unique_ptr<ContactSolver> make_contacts(const Capsules& capsules, ContactLaws laws, const Threads& threads,
                                             std::vector<std::uint8_t> owned_rods) {
    return std::make_unique<Contacts>(capsules, std::move(laws), threads, std::move(owned_rods));
}

} // namespace skein
