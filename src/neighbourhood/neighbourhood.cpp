#include "neighbourhood/neighbourhood.hpp"

#include "core/timer.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace skein {

/// Slots [first, first + count) of the scene.
struct SceneRun {
    std::int64_t first, count;
};

/// A node on its way to another rank.
struct VisitingNode {
    ExposedNode node;
    double pace;
};

/// Runs of elements on their way to another rank, and their nodes.
struct Visitors {
    std::vector<SceneRun> runs;
    std::vector<VisitingNode> nodes;
};

namespace {

/// The result of work whose time is added to a count of seconds.
template <class Work> auto timed(double& seconds, Work&& work) {
    const Timers::Guard timing(seconds);
    return work();
}

/// Sides along the axes; least > most where it holds nothing.
struct Box {
    double least[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, most[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    void add(const Vec3d& x, double radius) {
        const double c[3] = {x.x, x.y, x.z};
        for (int i = 0; i < 3; ++i) {
            least[i] = std::min(least[i], c[i] - radius);
            most[i] = std::max(most[i], c[i] + radius);
        }
    }
    void add(const Box& o) {
        for (int i = 0; i < 3; ++i) {
            least[i] = std::min(least[i], o.least[i]);
            most[i] = std::max(most[i], o.most[i]);
        }
    }
    bool meets(const Box& o, double margin) const {
        for (int i = 0; i < 3; ++i)
            if (!(least[i] - margin <= o.most[i] && o.least[i] - margin <= most[i])) return false;
        return true;
    }
};

Box box_of(const Exposure& bodies, std::size_t slot) {
    Box box;
    const ExposedNode& n = bodies.node[slot];
    box.add(n.position, n.radius);
    box.add(bodies.node[slot + 1].position, n.radius);
    return box;
}

constexpr std::size_t boxes_of_rank =
    16; // a power of two: enough that a rod that has gone astray makes one of them large, and not all

/// Calls f(first, count) for runs of elements of a window that are asked for, with the node behind the last.
template <class Asked, class F> void for_runs(const Exposure& bodies, const Window& window, Asked&& asked, F&& f) {
    const std::uint32_t end = window.first_slot + window.slots;
    for (std::uint32_t slot = window.first_slot; slot < end; ++slot) {
        if (!bodies.has_element(slot) || !asked(slot)) continue;
        const std::uint32_t first = slot;
        while (slot < end && bodies.has_element(slot) && asked(slot)) ++slot;
        f(first, slot + 1 - first);
    }
}

template <class T> std::vector<T> exchanged(const Communicator& comm, const std::vector<std::vector<T>>& by_rank,
                                            std::vector<std::int64_t>& received) {
    std::vector<T> sent;
    std::vector<std::int64_t> counts;
    for (const auto& to : by_rank) {
        counts.push_back(static_cast<std::int64_t>(to.size()));
        sent.insert(sent.end(), to.begin(), to.end());
    }
    return records_of<T>(comm.all_to_all(std::as_bytes(std::span(sent)), sizeof(T), counts, received));
}

/// Boxes of an exposure's own bodies, one by one.
struct OwnBody {
    const Window* window;
    Box box;
};
std::vector<OwnBody> own_bodies(const Exposure& bodies) {
    std::vector<OwnBody> own;
    for (const Window& w : bodies.window) {
        if (!w.own) continue;
        Box& box = own.emplace_back(&w, Box{}).box;
        for (std::uint32_t slot = w.first_slot; slot + 1 < w.first_slot + w.slots; ++slot)
            box.add(box_of(bodies, slot));
    }
    return own;
}

/// Boxes of parts of the bodies, as many in each: halves along the longest side, and halves of these. `order`: numbers
/// of the bodies.
void add_boxes_of_parts(std::span<const OwnBody> own, std::span<std::uint32_t> order, std::size_t parts,
                        std::vector<Box>& boxes) {
    Box box;
    for (const std::uint32_t i : order) box.add(own[i].box);
    if (parts == 1) {
        boxes.push_back(box);
        return;
    }
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (box.most[axis] - box.least[axis] > box.most[longest] - box.least[longest]) longest = axis;
    const auto middle = [&](std::uint32_t i) {
        const double twice = own[i].box.least[longest] + own[i].box.most[longest];
        return std::isnan(twice) ? 0 : twice; // a rod that is lost must not upset the order
    };
    const std::size_t half = order.size() / 2;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                     [&](std::uint32_t i, std::uint32_t k) { return middle(i) < middle(k); });
    add_boxes_of_parts(own, order.first(half), parts / 2, boxes);
    add_boxes_of_parts(own, order.subspan(half), parts / 2, boxes);
}

std::vector<Box> boxes_of_parts(std::span<const OwnBody> own) {
    std::vector<std::uint32_t> order(own.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Box> boxes;
    add_boxes_of_parts(own, order, boxes_of_rank, boxes);
    return boxes;
}

/// Boxes of all ranks, those of each one after another. Collective.
std::vector<Box> gathered(const Communicator& comm, std::span<const Box> mine) {
    std::vector<double> sides;
    for (const Box& box : mine) {
        sides.insert(sides.end(), box.least, box.least + 3);
        sides.insert(sides.end(), box.most, box.most + 3);
    }
    const std::vector<double> all_sides = comm.all_gather(sides);
    std::vector<Box> all(all_sides.size() / 6);
    for (std::size_t i = 0; i < all.size(); ++i) {
        std::copy_n(&all_sides[6 * i], 3, all[i].least);
        std::copy_n(&all_sides[6 * i + 3], 3, all[i].most);
    }
    return all;
}

/// Own elements that come within `margin` of any of these boxes, and their neighbours along the body, which contacts at
/// vertices ask for.
Visitors visitors_to(std::span<const Box> boxes, const Exposure& bodies, std::span<const OwnBody> own, double margin) {
    Visitors visitors;
    if (boxes.empty()) return visitors;
    std::vector<Box> near;
    std::vector<std::uint8_t> asked;
    for (const OwnBody& body : own) {
        near.clear();
        for (const Box& box : boxes)
            if (body.box.meets(box, margin)) near.push_back(box);
        if (near.empty()) continue;
        const Window& w = *body.window;
        asked.assign(w.slots, 0);
        for (std::uint32_t k = 0; k + 1 < w.slots; ++k) {
            const std::uint32_t slot = w.first_slot + k;
            if (!bodies.has_element(slot)) continue;
            const Box element = box_of(bodies, slot);
            if (std::any_of(near.begin(), near.end(), [&](const Box& box) { return element.meets(box, margin); }))
                bodies.with_neighbours(slot, [&](std::uint32_t one) { asked[one - w.first_slot] = 1; });
        }
        for_runs(
            bodies, w, [&](std::uint32_t slot) { return asked[slot - w.first_slot] != 0; },
            [&](std::uint32_t first, std::uint32_t count) {
                visitors.runs.push_back({w.first_in_scene + (first - w.first_slot), count});
                for (std::uint32_t slot = first; slot < first + count; ++slot)
                    visitors.nodes.push_back({bodies.node[slot], bodies.pace[slot]});
                visitors.nodes.back().node.radius = -1;
            });
    }
    return visitors;
}

} // namespace

void Neighbourhood::Route::begin() {
    runs.clear();
    parts.clear();
    lengths_.clear();
    size_ = begun_ = 0;
}

void Neighbourhood::Route::add(std::uint32_t first_slot, std::uint32_t slots) {
    runs.push_back({first_slot, slots, size_});
    size_ += Exposure::sent_numbers_per_slot * slots;
}

void Neighbourhood::Route::end_of_rank(int rank) {
    if (size_ > begun_) lengths_.push_back({rank, begun_, size_ - begun_});
    begun_ = size_;
}

void Neighbourhood::Route::settle() {
    numbers.assign(size_, 0);
    for (const Length& l : lengths_)
        parts.push_back({l.rank, std::as_writable_bytes(std::span(numbers).subspan(l.first, l.count))});
}

Neighbourhood::Neighbourhood(const Communicator& comm, const Threads& threads, std::shared_ptr<Exposure> exposure)
    : comm_(comm), channel_(comm.size() > 1 ? comm.duplicate() : comm), threads_(threads),
      exposure_(std::move(exposure)), rank_of_(exposure_->window.size(), comm.rank()), vote_(channel_) {}

Neighbourhood::~Neighbourhood() {
    threads_.set_poll({});
    messages_ = {};
    if (comm_.size() > 1) channel_.free();
}

void Neighbourhood::rebind(std::shared_ptr<Exposure> exposure) {
    exposure_ = std::move(exposure);
    rank_of_.assign(exposure_->window.size(), comm_.rank());
}

/// Calls copy(number of the message, number of the exposure) for all that travels along a route.
template <class Copy> void Neighbourhood::for_numbers(Route& route, Copy&& copy) {
    const auto tasks = (route.runs.size() + runs_of_task - 1) / runs_of_task;
    threads_.for_each(tasks, [&](std::size_t task, int) {
        for (std::size_t r = task * runs_of_task; r < std::min(route.runs.size(), (task + 1) * runs_of_task); ++r) {
            const Run& run = route.runs[r];
            double* number = route.numbers.data() + run.at;
            for (std::uint32_t slot = run.first_slot; slot < run.first_slot + run.slots; ++slot)
                for (Vec3d* v : {&exposure_->node[slot].position, &exposure_->motion[slot].velocity,
                                 &exposure_->motion[slot].spin})
                    for (double* component : {&v->x, &v->y, &v->z}) copy(*number++, *component);
        }
    });
}

void Neighbourhood::pack() {
    for_numbers(sent_, [](double& number, double component) { number = component; });
}

void Neighbourhood::unpack() {
    for_numbers(received_, [](double number, double& component) { component = number; });
}

void Neighbourhood::publish(bool holds) {
    holds_ = holds;
    if (comm_.size() == 1) return;
    pack();
    messages_.start();
    vote_.start(holds);
    threads_.set_poll([this] {
        vote_.poll();
        messages_.poll();
    });
}

bool Neighbourhood::arrive() {
    if (comm_.size() == 1) return holds_;
    threads_.set_poll({});
    const bool all = timed(waits_.vote, [&] { return vote_.finish(); });
    timed(waits_.ghosts, [&] { messages_.finish(); });
    unpack();
    return all;
}

const Exposure& Neighbourhood::widen(double reach) {
    exposure_->set_paces(threads_, comm_.max(exposure_->largest_speed(threads_)));
    if (comm_.size() == 1) return *exposure_;
    const std::vector<OwnBody> own = own_bodies(*exposure_);
    const std::vector<Box> mine = boxes_of_parts(own),
                           all_boxes = timed(waits_.rebuild, [&] { return gathered(comm_, mine); });
    Box whole;
    for (const Box& box : mine) whole.add(box);
    double furthest = 0;
    for (int i = 0; i < 3; ++i)
        for (const double side : {whole.least[i], whole.most[i]})
            if (std::isfinite(side)) furthest = std::max(furthest, std::abs(side));
    const double margin = reach * (1 + 1e-9) + 1e-12 * furthest; // a pair that rounding makes near is not to be missed
    std::vector<std::vector<SceneRun>> runs;
    std::vector<std::vector<VisitingNode>> nodes;
    for (std::size_t r = 0; r < to_index(comm_.size()); ++r) {
        std::vector<Box> others; // none, for most ranks
        for (std::size_t i = r * boxes_of_rank; i < (r + 1) * boxes_of_rank; ++i)
            if (static_cast<int>(r) != comm_.rank() && whole.meets(all_boxes[i], margin))
                others.push_back(all_boxes[i]);
        Visitors visitors = visitors_to(others, *exposure_, own, margin);
        runs.push_back(std::move(visitors.runs));
        nodes.push_back(std::move(visitors.nodes));
    }
    std::vector<std::int64_t> run_counts, node_counts;
    const Visitors visitors = timed(waits_.rebuild, [&] {
        return Visitors{exchanged(comm_, runs, run_counts), exchanged(comm_, nodes, node_counts)};
    });
    make_wide(visitors, run_counts);
    return *wide_;
}

/// The exposure of own bodies and of visitors, which stand rank by rank.
void Neighbourhood::make_wide(const Visitors& visitors, std::span<const std::int64_t> runs_of_rank) {
    struct Source {
        Window window;
        int rank;
        const VisitingNode* node; ///< null of own bodies
    };
    std::vector<Source> all;
    for (const Window& w : exposure_->window)
        if (w.own) all.push_back({w, comm_.rank(), nullptr});
    std::size_t at = 0;
    const VisitingNode* node = visitors.nodes.data();
    for (int r = 0; r < comm_.size(); ++r)
        for (std::int64_t i = 0; i < nth(runs_of_rank, r); ++i) {
            const auto [first, count] = visitors.runs[at++];
            const SceneSlots& scene = exposure_->scene();
            const std::int64_t gid = scene.gid_at(first);
            all.push_back({{gid, first, 0, static_cast<std::uint32_t>(count), scene.group_of(gid), false}, r, node});
            node += count;
        }
    std::sort(all.begin(), all.end(),
              [](const Source& x, const Source& y) { return x.window.first_in_scene < y.window.first_in_scene; });
    std::vector<Window> windows;
    wide_rank_.clear();
    for (const Source& s : all) {
        windows.push_back(s.window);
        wide_rank_.push_back(s.rank);
    }
    wide_ = std::make_unique<Exposure>(exposure_->scene(), std::move(windows), false);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::uint32_t first = wide_->window[i].first_slot, here = all[i].window.first_slot;
        for (std::uint32_t k = 0; k < all[i].window.slots; ++k) {
            wide_->node[first + k] = all[i].node ? all[i].node[k].node : exposure_->node[here + k];
            wide_->pace[first + k] = all[i].node ? static_cast<float>(all[i].node[k].pace) : exposure_->pace[here + k];
        }
    }
}

std::vector<std::uint32_t> Neighbourhood::narrow(std::span<const std::uint8_t> wanted) {
    if (comm_.size() == 1) {
        std::vector<std::uint32_t> same(wanted.size());
        std::iota(same.begin(), same.end(), 0u);
        return same;
    }
    std::vector<std::uint32_t> now(wide_->slots(), gone);
    std::vector<Window> windows;
    std::vector<int> ranks;
    std::vector<double> radius;
    std::vector<float> pace;
    const auto keep = [&](const Window& of, int rank, std::uint32_t first, std::uint32_t count) {
        windows.push_back({of.gid, of.first_in_scene + (first - of.first_slot), 0, count, of.group, of.own});
        ranks.push_back(rank);
        for (std::uint32_t slot = first; slot < first + count; ++slot) {
            now[slot] = static_cast<std::uint32_t>(radius.size());
            radius.push_back(slot + 1 < first + count ? wide_->node[slot].radius : -1);
            pace.push_back(wide_->pace[slot]);
        }
    };
    for (std::size_t w = 0; w < wide_->window.size(); ++w) {
        const Window& window = wide_->window[w];
        if (window.own) keep(window, wide_rank_[w], window.first_slot, window.slots);
        else
            for_runs(
                *wide_, window, [&](std::uint32_t slot) { return wanted[slot] != 0; },
                [&](std::uint32_t first, std::uint32_t count) { keep(window, wide_rank_[w], first, count); });
    }
    Exposure narrowed(exposure_->scene(), std::move(windows));
    for (std::size_t slot = 0; slot < radius.size(); ++slot) narrowed.node[slot].radius = radius[slot];
    narrowed.pace = std::move(pace);
    exposure_->become(std::move(narrowed));
    rank_of_ = std::move(ranks);
    wide_.reset();
    set_up_messages();
    pack();
    messages_.start();
    timed(waits_.rebuild, [&] { messages_.finish(); });
    unpack();
    return now;
}

void Neighbourhood::set_up_messages() {
    std::vector<std::vector<SceneRun>> asked(to_index(comm_.size()));
    std::set<std::int64_t> bodies;
    figures_ = {};
    std::vector<std::vector<const Window*>> ghosts(asked.size());
    for (std::size_t w = 0; w < rank_of_.size(); ++w)
        if (rank_of_[w] != comm_.rank()) nth(ghosts, rank_of_[w]).push_back(&exposure_->window[w]);
    received_.begin();
    for (int r = 0; r < comm_.size(); ++r) {
        for (const Window* ghost : nth(ghosts, r)) {
            const Window& window = *ghost;
            nth(asked, r).push_back({window.first_in_scene, window.slots});
            received_.add(window.first_slot, window.slots);
            bodies.insert(window.gid);
            figures_.elements += window.slots - 1;
        }
        received_.end_of_rank(r);
    }
    figures_.bodies = static_cast<std::int64_t>(bodies.size());
    std::vector<std::int64_t> counts;
    const std::vector<SceneRun> wanted = timed(waits_.rebuild, [&] { return exchanged(comm_, asked, counts); });
    std::size_t at = 0;
    sent_.begin();
    for (int r = 0; r < comm_.size(); ++r) {
        for (std::int64_t i = 0; i < nth(counts, r); ++i, ++at)
            sent_.add(exposure_->find(wanted[at].first).value(), static_cast<std::uint32_t>(wanted[at].count));
        sent_.end_of_rank(r);
    }
    messages_ = {}; // before the memory that it uses
    sent_.settle();
    received_.settle();
    messages_ = RepeatedMessages(channel_, sent_.parts, received_.parts);
    std::set<int> neighbours;
    for (const Route* route : {&sent_, &received_})
        for (const auto& part : route->parts) neighbours.insert(part.rank);
    figures_.neighbours = static_cast<std::int64_t>(neighbours.size());
    figures_.messages = static_cast<std::int64_t>(sent_.parts.size());
    for (const auto& part : sent_.parts) figures_.bytes += static_cast<std::int64_t>(part.bytes.size());
}

std::vector<GhostFigures> Neighbourhood::figures_of_ranks() const {
    std::vector<GhostFigures> all(to_index(comm_.size()));
    for (const auto of : {&GhostFigures::bodies, &GhostFigures::elements, &GhostFigures::neighbours,
                          &GhostFigures::messages, &GhostFigures::bytes}) {
        const std::vector<std::int64_t> values = comm_.all_gather(figures_.*of);
        for (std::size_t r = 0; r < all.size(); ++r) all[r].*of = values[r];
    }
    return all;
}

std::vector<WaitFigures> Neighbourhood::waits_of_ranks() const {
    std::vector<WaitFigures> all(to_index(comm_.size()));
    for (const auto of : {&WaitFigures::vote, &WaitFigures::ghosts, &WaitFigures::rebuild}) {
        const std::vector<double> values = comm_.all_gather(std::vector{waits_.*of});
        for (std::size_t r = 0; r < all.size(); ++r) all[r].*of = values[r];
    }
    return all;
}

} // namespace skein
