#include "contact/contact_tangent.hpp"
#include "contact/work_area.hpp"

#include "core/timer.hpp"
#include "parallel/blocks.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

// Skin and margin minimise the cost of searches, prunings and pairs that do not touch. All ranks know the same figures
// and choose alike.
constexpr double search_cost = 25;                 // cost of searching an element, in pairs that do not touch
constexpr double least_skin = 0.01, most_skin = 4; // skin in diameters
constexpr double inactive_work = 1.0 / 8;          // cost of a pair that does not touch, in those that do

} // namespace

Contacts::Contacts(ContactScene scene, const Threads& threads)
    : scene_(std::move(scene)), kinds_{laws_.normal(), laws_.friction()}, remembers_(laws_.remember()),
      has_rings_(std::any_of(scene_.rules.of_group.begin(), scene_.rules.of_group.end(),
                             [](const SelfGap& gap) { return gap.ring > 0; })),
      threads_(threads), search_(threads), next_(to_index(threads.count())), area_(to_index(threads.count())) {
    figures_.skin = 0.25 * scene_.diameter;
    margin_ = 0.25 * figures_.skin;
}

Contacts::~Contacts() = default;

/// Places of a tile of nodes; the last node repeats.
SKEIN_INLINE Contacts::Places Contacts::places(const Exposure& bodies, std::size_t first) {
    const ExposedNode* const node = bodies.node.data();
    const std::size_t last = bodies.slots() - 1;
    if (first + places_at_once <= last + 1)
        return load_transposed<places_at_once>([&](int l) { return &node[first + to_index(l)].position.x; }).vector;
    return load_transposed<places_at_once>([&](int l) { return &node[std::min(first + to_index(l), last)].position.x; })
        .vector;
}

/// Squared distances, m^2, that a tile of nodes may go: half the skin by their paces.
Pack<Contacts::places_at_once> Contacts::farthest_squared(const Exposure& bodies, std::size_t first, double skin) {
    const double half_way = 0.5 * skin;
    alignas(64) double squared[places_at_once];
    for (int l = 0; l < places_at_once; ++l) {
        const double way = half_way * bodies.pace[std::min(first + to_index(l), bodies.slots() - 1)];
        nth(squared, l) = way * way;
    }
    return detail::pack_at<places_at_once>(squared);
}

/// Runs of tiles of places: all of them, and those in which ghosts are.
void Contacts::cut_tiles(const Exposure& bodies) {
    constexpr std::size_t most = 128;
    all_tiles_.clear();
    ghosts_tiles_.clear();
    auto block = deferred_.blocks().begin();
    for (std::size_t begin = 0; begin < place_.size(); begin += most) {
        TileRun run{begin, std::min(begin + most, place_.size()), false};
        while (block->last_slot <= begin * places_at_once) ++block;
        for (auto b = block; b != deferred_.blocks().end() && b->first_slot < run.end * places_at_once; ++b)
            run.paired |= b->paired;
        all_tiles_.push_back(run);
    }
    for (std::size_t w = 0; w < bodies.window.size(); ++w) {
        if (bodies.owns(w)) continue;
        const std::size_t first = bodies.window[w].first_slot / places_at_once,
                          last = (bodies.end_of(w) - 1) / places_at_once + 1;
        if (!ghosts_tiles_.empty() && first <= ghosts_tiles_.back().end)
            ghosts_tiles_.back().end = std::max(ghosts_tiles_.back().end, last);
        else ghosts_tiles_.push_back({first, last, true});
    }
}

/// Checks that the lists still hold all pairs that may touch.
Contacts::Holding Contacts::check_lists(const Exposure& bodies, std::span<const TileRun> runs) {
    constexpr int W = places_at_once;
    using P = Pack<W>;
    const double share = margin_ / figures_.skin;
    const P pruned_share(share * share);
    std::atomic<bool> list = true, pruned = true;
    std::atomic<double> moved = 0; // squared
    threads_.for_each(runs.size(), [&](std::size_t run, int) {
        const auto [begin, end, paired] = runs[run];
        if (!paired) {
            P beyond(-HUGE_VAL);
            for (std::size_t tile = begin; tile < end; ++tile) {
                const Vec3<P> way = places(bodies, tile * W) - place_[tile];
                beyond = max(beyond, dot(way, way) - farthest_squared_[tile]);
            }
            if (any(!(beyond < P(0.0)))) list.store(false, std::memory_order_relaxed);
            return;
        }
        P beyond_list(-HUGE_VAL), beyond_pruned(-HUGE_VAL), farthest(0.0);
        for (std::size_t tile = begin; tile < end; ++tile) {
            const Vec3<P> here = places(bodies, tile * W), way = here - place_[tile],
                          last_way = here - pruned_at_[tile];
            const P squared = dot(last_way, last_way);
            beyond_list = max(beyond_list, dot(way, way) - farthest_squared_[tile]);
            beyond_pruned = max(beyond_pruned, squared - pruned_share * farthest_squared_[tile]);
            farthest = max(farthest, squared);
        }
        if (any(!(beyond_list < P(0.0)))) list.store(false, std::memory_order_relaxed);
        if (any(!(beyond_pruned < P(0.0)))) pruned.store(false, std::memory_order_relaxed);
        double most = 0;
        for (int l = 0; l < W; ++l) most = std::max(most, farthest[l]);
        for (double before = moved.load(); most > before && !moved.compare_exchange_weak(before, most);) {
        }
    });
    return {list, pruned, std::sqrt(moved)};
}

/// Requests that the next step checks all candidates.
void Contacts::request_pruning(const Exposure& bodies) {
    threads_.for_each(all_tiles_.size(), [&](std::size_t run, int) {
        const auto [begin, end, paired] = all_tiles_[run];
        if (!paired) return;
        for (std::size_t tile = begin; tile < end; ++tile) pruned_at_[tile] = places(bodies, tile * places_at_once);
    });
    prunes_[0] = prunes_[1] = true;
}

bool Contacts::holds(const Exposure& bodies) {
    if (!worth_keeping()) return false;
    const Holding holding = check_lists(bodies, all_tiles_);
    displacement_ = moved_ + holding.moved;
    moved_ = holding.pruned ? holding.moved : 0;
    if (holding.list && !holding.pruned) request_pruning(bodies);
    return holding.list;
}

/// Share of inactive candidates that a step checks. The pruned list has as many, and pruning adds as many where it is
/// due as often as the margin is smaller than the skin.
double Contacts::idle_share() const { return 2 * margin_ / figures_.skin; }

/// A list may last so long that its inactive pairs cost more than a new one with less skin.
bool Contacts::rebuild_pays() const {
    return figures_.skin > least_skin * scene_.diameter &&
           static_cast<double>(age_) * idle_share() * static_cast<double>(inactive_) >
               4 * search_cost * static_cast<double>(scene_.slots);
}

double Contacts::next_skin() {
    if (figures_.rebuilds > 0 && age_ > 0) {
        // Elements move by half the skin in `age` steps, by half the margin in a part of these. The pairs that a step
        // checks are fewest, 2 inactive / sqrt(age), with a margin of skin / sqrt(age). Age and inactive pairs grow
        // with the skin.
        const auto age = static_cast<double>(age_),
                   inactive = static_cast<double>(std::max<std::int64_t>(inactive_, 1));
        const double search = search_cost * static_cast<double>(scene_.slots) / age,
                     change = std::clamp(std::pow(search * std::sqrt(age) / inactive, 2.0 / 3), 0.5, 1.5);
        figures_.skin = std::clamp(figures_.skin * change, least_skin * scene_.diameter, most_skin * scene_.diameter);
        margin_ = figures_.skin * std::min(0.5, 1 / std::sqrt(change * age));
        age_ = 0;
    }
    return figures_.skin + scene_.meeting_zone / Exposure::least_pace; // the skin of slow pairs is a share of it
}

/// Pairs that touch, by slots of the scene, in order.
std::vector<SavedContact> Contacts::touching_pairs(const Exposure& bodies, bool of_own) const {
    if (list_.first.empty()) return {}; // nothing has been evaluated
    const std::size_t slots = list_.first.size() - 1;
    std::vector<std::vector<SavedContact>> parts(blocks_of(slots));
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t block) {
        for (std::uint32_t i = list_.first[begin]; i < list_.first[end]; ++i) {
            const auto [a, b] = list_.pair[i];
            if ((status_[i] & touching) && (!of_own || bodies.owns_slot(a)))
                parts[block].push_back({bodies.in_scene(a), bodies.in_scene(b), status_[i], memory_[i]});
        }
    });
    std::vector<SavedContact> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

void Contacts::prepare_rebuild(const Exposure& bodies) {
    if (std::exchange(may_repeat_, false))
        for (const std::uint32_t strip : now_)
            restore_memory(list_.first[deferred_.strips()[strip].first_slot],
                           list_.first[deferred_.strips()[strip].last_slot]);
    if (!list_.first.empty()) saved_ = touching_pairs(bodies, false);
}

std::int64_t Contacts::search(const Exposure& near, std::span<std::uint8_t> wanted) {
    const Timers::Guard timing(figures_.search_s);
    search_.build(near, scene_.rules, next_skin(), found_);
    if (!near.own.empty())
        for (std::size_t a = 0; a < near.slots(); ++a)
            for (std::uint32_t i = found_.first[a]; i < found_.first[a + 1]; ++i)
                for (const std::uint32_t slot : {static_cast<std::uint32_t>(a), found_.partner[i]})
                    if (!near.owns_slot(slot)) near.with_neighbours(slot, [&](std::uint32_t one) { wanted[one] = 1; });
    if (largest_displacement_ > 0) find_passed(near, wanted);
    return found_.inactive;
}

/// Places the memory of earlier steps into the list.
void Contacts::place_saved(const Exposure& bodies) {
    memory_.resize(list_.count());
    status_.assign(list_.count() + PairList::padding, 0);
    for_blocks(threads_, memory_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        std::fill(memory_.data() + begin, memory_.data() + end, ContactMemory<double>{});
    });
    std::vector<BinnedSum<double>> lost(blocks_of(saved_.size()));
    restore_overlapping(bodies);
    for_blocks(threads_, saved_.size(), [&](std::size_t begin, std::size_t end, std::size_t block) {
        for (std::size_t i = begin; i < end; ++i) {
            const SavedContact& kept = saved_[i];
            const auto a = bodies.find(kept.a), b = bodies.find(kept.b);
            if (!a && !b) continue; // a contact of other ranks
            if (a && b) {
                const auto first = list_.pair.begin() + list_.first[*a],
                           last = list_.pair.begin() + list_.first[*a + 1];
                const auto at = std::lower_bound(first, last, Pair{*a, *b});
                if (at != last && *at == Pair{*a, *b}) {
                    const auto pair = to_index(at - list_.pair.begin());
                    status_[pair] = static_cast<std::uint8_t>(kept.status & touching);
                    memory_[pair] = kept.memory;
                    continue;
                }
            }
            if (a && bodies.owns_slot(*a)) lost[block].add(kept.memory.energy(), bins_);
        }
    });
    for (const BinnedSum<double>& energy : lost) figures_.friction_work.add(energy);
    saved_.clear();
}

void Contacts::finish_rebuild(const Exposure& bodies, std::span<const std::uint32_t> slot, std::int64_t inactive) {
    const Timers::Guard timing(figures_.search_s);
    ++figures_.rebuilds;
    age_ = 0;
    inactive_ = inactive;
    if (slot.size() != bodies.slots()) { // slots of ghosts that are in no pair are gone
        Candidates left;
        left.first.assign(bodies.slots() + 1, 0);
        for (std::size_t a = 0; a < slot.size(); ++a)
            if (found_.first[a + 1] > found_.first[a]) left.first[slot[a] + 1] = found_.first[a + 1] - found_.first[a];
        std::partial_sum(left.first.begin(), left.first.end(), left.first.begin());
        for (const std::uint32_t b : found_.partner) left.partner.push_back(slot[b]);
        found_ = std::move(left);
    }
    list_ = PairList(std::exchange(found_, {}), bodies, threads_, has_spring(kinds_.friction));
    find_boxes(bodies);
    place_saved(bodies);
    deferred_.make_room(list_, bodies, threads_, scene_.has_tangents);
    block_figures_.resize(deferred_.blocks().size());
    touched_.assign(bodies.window.size(), 0);
    now_.clear();
    later_.clear();
    for (std::uint32_t i = 0; i < deferred_.strips().size(); ++i)
        (deferred_.strips()[i].needs_ghosts ? later_ : now_).push_back(i);
    place_.resize((bodies.slots() + places_at_once - 1) / places_at_once);
    pruned_at_.resize(place_.size());
    farthest_squared_.resize(place_.size());
    cut_tiles(bodies);
    for_blocks(threads_, place_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t tile = begin; tile < end; ++tile) {
            place_[tile] = places(bodies, tile * places_at_once);
            farthest_squared_[tile] = farthest_squared(bodies, tile * places_at_once, figures_.skin);
        }
    });
    request_pruning(bodies);
    moved_ = 0;
    displacement_ = HUGE_VAL;
    pruned_.make_room(list_, deferred_.blocks().size());
    edge_.assign(place_.size() * places_at_once, 0);
    for (std::size_t w = 0; w < bodies.window.size(); ++w)
        edge_[bodies.window[w].first_slot] = edge_[bodies.end_of(w) - 1] = 1;
    figures_.candidates = 0;
    for (std::size_t w = 0; w < bodies.window.size(); ++w)
        if (bodies.owns(w))
            figures_.candidates += list_.first[bodies.end_of(w)] - list_.first[bodies.window[w].first_slot];
}

void Contacts::restore(std::span<const SavedContact> kept, const BinnedTotal& friction_work,
                       const BinnedTotal& viscous_work) {
    figures_.friction_work = friction_work;
    figures_.viscous_work = viscous_work;
    saved_.assign(kept.begin(), kept.end());
    std::sort(saved_.begin(), saved_.end(),
              [](const SavedContact& x, const SavedContact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    list_ = {};
    status_.clear();
    memory_.clear();
    may_repeat_ = false;
    search_.forget_sizes();
    begins_ = saved_.empty(); // bodies in each other touch from their first step on
    overlapping_.clear();
}

void Contacts::keep(std::size_t place, const Exposure& bodies) {
    Kept& kept = nth(kept_, place);
    kept.contacts = list_.first.empty() ? saved_ : touching_pairs(bodies, false);
    kept.rebuilds = list_.first.empty() ? -1 : figures_.rebuilds;
    kept.works = {figures_.friction_work, figures_.viscous_work};
}

void Contacts::go_back(std::size_t place, const Exposure& bodies) {
    const Kept& kept = nth(kept_, place);
    if (kept.rebuilds != figures_.rebuilds || list_.first.empty())
        return restore(kept.contacts, kept.works.at(0), kept.works.at(1));
    saved_ = kept.contacts;
    place_saved(bodies);
    figures_.friction_work = kept.works.at(0);
    figures_.viscous_work = kept.works.at(1);
}

std::vector<SavedContact> Contacts::saved(const Exposure& bodies) const {
    std::vector<SavedContact> mine;
    if (!list_.first.empty()) mine = touching_pairs(bodies, true);
    else // not yet gone on from
        for (const SavedContact& kept : saved_)
            if (const auto a = bodies.find(kept.a); a && bodies.owns_slot(*a)) mine.push_back(kept);
    for (SavedContact& contact : mine)
        if (is_overlapping(bodies_of(bodies.scene(), contact.a, contact.b))) contact.status |= began_deep;
    return mine;
}

std::vector<double> Contacts::work(const Exposure& bodies) const {
    std::vector<double> work(bodies.window.size(), 0.0);
    if (list_.first.empty()) return work;
    for_blocks(threads_, bodies.window.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t w = begin; w < end; ++w)
            for (std::uint32_t i = list_.first[bodies.window[w].first_slot]; i < list_.first[bodies.end_of(w)]; ++i)
                work[w] += status_[i] & touching ? 1 : inactive_work;
    });
    return work;
}

/// Sets the spring of friction without memory for bodies of this mobility, and limits one with memory in beds.
void Contacts::set_spring(ContactNumbers<double>& numbers, double mobility) const {
    if (slips_always(kinds_.friction)) numbers.set_spring(spring_step_, mobility);
    if (scene_.has_tangents) numbers.limit_springs(spring_step_, mobility, most_added_by_friction);
}

/// Sets the springs between bodies of groups for a step h.
void Contacts::set_springs(double h) {
    const std::vector<double>& mobility = scene_.slip_mobility;
    spring_step_ = h;
    const auto set = [&](ContactNumbers<double>& numbers, double of_both) { set_spring(numbers, of_both); };
    if (mobility.empty() || laws_.materials() == 1)
        return set(numbers_[0], mobility.empty() ? 0 : 2 * *std::max_element(mobility.begin(), mobility.end()));
    for (std::size_t i = 0; i < laws_.materials(); ++i)
        for (std::size_t j = 0; j < laws_.materials(); ++j)
            set(numbers_[i * laws_.materials() + j], mobility[i] + mobility[j]);
}

ContactNumbers<double> Contacts::own_numbers(ContactNumbers<double> of_groups, const Window& a, const Window& b) const {
    ContactNumbers<double> numbers = scene_.for_bodies(of_groups, a, b);
    set_spring(numbers, scene_.slip_mobility_of(a) + scene_.slip_mobility_of(b));
    return numbers;
}

void Contacts::begin(const Exposure& bodies, double time, double h, std::span<ExertedLoad> loads, bool may_repeat) {
    numbers_ = laws_.numbers(time);
    const bool springs = slips_always(kinds_.friction) || scene_.has_tangents;
    if (springs) set_springs(h);
    own_numbers_ = !scene_.own.empty() && (springs || std::any_of(numbers_.begin(), numbers_.end(),
                                                                  [](const auto& law) { return law.by_mass; }));
    time_ = time;
    side_changes_.clear();
    overlap_now_.clear();
    mark_far_moves(bodies);
    may_repeat_ = may_repeat;
    if (may_repeat_ && !now_.empty()) { // on the way, while all is in cache
        status_before_.resize(status_.size());
        memory_before_.resize(memory_.size());
    }
    run_strips(bodies, h, now_, std::exchange(prunes_[0], false), loads);
}

void Contacts::finish(const Exposure& bodies, double h, std::span<ExertedLoad> loads) {
    may_repeat_ = false;
    if (!later_.empty() && !check_lists(bodies, ghosts_tiles_).pruned)
        request_pruning(bodies); // their owners vouch for the list
    run_strips(bodies, h, later_, std::exchange(prunes_[1], false), loads);
    add_deferred(bodies, loads);
    if (!far_.empty() || !passed_.empty()) check_far_moves(bodies);
    update_overlapping();
    if (side_changes_.size() > 1)
        std::sort(side_changes_.begin(), side_changes_.end(),
                  [](const SideChange& x, const SideChange& y) { return x.pair < y.pair; });
    ++age_;
    ContactFigures& f = figures_;
    f.active = f.near = 0;
    f.weight = 0;
    f.max_overlap = f.max_stiffness = 0;
    f.elastic_energy = BinnedTotal(bins_);
    for (const BlockFigures& found : block_figures_) {
        f.active += found.active;
        f.near += found.near;
        f.weight += found.weight;
        f.max_overlap = std::max(f.max_overlap, found.max_overlap);
        f.max_stiffness = std::max(f.max_stiffness, found.max_stiffness);
        f.elastic_energy.add(found.elastic_energy);
        f.friction_work.add(found.friction_work);
        f.viscous_work.add(found.viscous_work);
    }
}

std::unique_ptr<ContactSolver> make_contacts(ContactScene scene, const Threads& threads) {
    return std::make_unique<Contacts>(std::move(scene), threads);
}

} // namespace skein
