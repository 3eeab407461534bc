#include "kernels/rod_tiles.hpp"

#include "core/rotation.hpp"
#include "implicit/evaluated_passes.hpp"
#include "mechanics/drift.hpp"
#include "mechanics/figures.hpp"
#include "mechanics/invalid_state.hpp"
#include "mechanics/present_eigenvalues.hpp"
#include "mechanics/rod_profile.hpp"
#include "mechanics/synchronise.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

namespace skein {

namespace {

template <int W> Pack<W> most_dilatation(const RodTile<W>& tile) {
    if (!tile.strands) return Pack<W>(most_dilatation(*tile.group));
    Pack<W> most(0.0);
    for (int i = 0; i < W; ++i) most.set(i, most_dilatation(tile.group_of(i)));
    return most;
}

/// True where the state of all lanes is valid: finite, dilatations and turns within bounds. It is the cheap test of all
/// rods.
template <class Map, int W> bool valid(const RodTile<W>& tile) {
    using P = Pack<W>;
    P zero(0.0), least(1.0), most(0.0), half_cosine(1.0);
    const bool strained = tile.last == tile.n;
    for (int k = 0; k < tile.n; ++k) {
        const Slot<W>& s = tile.slot[k];
        const Vec3<P> all = s.position + s.velocity + s.director.v + s.spin;
        zero = fma(all.x + all.y + all.z + s.director.w, P(0.0), zero);
        const P e = strained ? element_strain<Map>(tile, k).z : P(1.0);
        least = min(least, e);
        most = max(most, e);
        if constexpr (Map::along) {
            half_cosine = select(tile.strands->cell[k].inner,
                                 min(half_cosine, abs(dot(s.director, tile.slot[k + 1].director))), half_cosine);
        } else {
            if (k == tile.group->cells()) break;
            half_cosine = min(half_cosine, abs(dot(s.director, tile.slot[(k + 1) % tile.n].director)));
        }
    }
    const Vec3<P> end = tile.slot[tile.last].position + tile.slot[tile.last].velocity;
    zero = fma(end.x + end.y + end.z, P(0.0), zero);
    const auto good = (zero >= P(0.0)) & (least > P(least_dilatation)) & (most < most_dilatation(tile)) &
                      (half_cosine > P(least_half_cosine));
    return !any(!good);
}
template <int W> bool valid(const RodTile<W>& tile) {
    return with_mapping(tile, [&]<class Map> { return valid<Map>(tile); });
}

} // namespace

template <int W> RodTiles<W>::RodTiles(std::span<const RodGroup> groups, std::vector<LocalRod> rods,
                                       const Tiling& tiling, std::vector<TileProgram<W>> programs,
                                       const Threads& threads, std::vector<std::shared_ptr<EnergyBudget<W>>> audits,
                                       StepWatch watch, JointsOfAssemblies<W> joints)
    : groups_(groups), local_(std::move(rods)), programs_(std::move(programs)), audits_(std::move(audits)),
      threads_(threads), watch_(watch), joints_(std::move(joints)), reading_(to_index(threads.count())) {
    std::vector<AlongLayout> layouts = lay_out(tiling);
    take_start_states(std::move(layouts));

    int most_slots = 0;
    for (const RodTile<W>& tile : tiles_) most_slots = std::max(most_slots, tile.n + 1);
    scratch_.resize(to_index(threads_.count()));
    for (auto& scratch : scratch_) scratch.resize(to_index(most_slots));

    std::size_t most_joined = 0;
    std::size_t most_tiles = 0; // clusters with muscles
    muscles_.resize(programs_.size());
    for (std::size_t p = 0; p < programs_.size(); ++p)
        for (const auto& pass : programs_[p].passes) {
            const auto add = [&](const TilePass<W>* one) {
                if (const auto* muscles = dynamic_cast<const MakesEndMoments<W>*>(one)) muscles_[p].push_back(muscles);
            };
            add(pass.get());
            if (const auto* step = dynamic_cast<const EvaluatesPasses<W>*>(pass.get()))
                for (const EvaluatedPass<W>& one : step->evaluated()) add(one.pass.get());
        }
    for (Cluster& cluster : clusters_) {
        most_joined = std::max(most_joined, cluster.slots);
        cluster.memory.assign(cluster.joints->memory_packs(cluster.across), Pack<W>(0.0));
        set_rods(cluster);
        cluster.muscles = cluster.joints->wants_moments() &&
                          std::any_of(cluster.tiles.begin(), cluster.tiles.end(),
                                      [&](std::size_t t) { return !muscles_[tiles_[t].program].empty(); });
        if (cluster.muscles) most_tiles = std::max(most_tiles, cluster.tiles.size());
    }
    join_steps();
    joined_.resize(scratch_.size());
    moments_.resize(scratch_.size());
    for (auto& joined : joined_) joined.resize(most_joined);
    for (auto& moments : moments_) moments.resize(most_tiles);

    // Loop over tiles outside and passes inside: a tile stays in cache for all passes of all steps of the sweep.
    const auto advance_tile = [this](std::size_t t, int thread) {
        const RodTile<W>& tile = tiles_[t];
        SlotLoad<W>* load = nth(scratch_, thread).data();
        for (const StepPart& part : sweep_) {
            const auto [first, end] = passes(tile.program, part.which);
            for (const Step& step : part.steps) run_passes(tile, load, first, end, step);
        }
        if (check_ && !healthy(tile)) valid_.store(false, std::memory_order_relaxed);
    };
    advance_ = [this, advance_tile](std::size_t task, int thread) {
        if (task >= clusters_.size()) return advance_tile(alone_[task - clusters_.size()], thread);
        const Cluster& cluster = clusters_[task];
        for (const StepPart& part : sweep_) advance_cluster(cluster, part, thread);
        if (check_)
            for (const std::size_t t : cluster.tiles)
                if (!healthy(tiles_[t])) valid_.store(false, std::memory_order_relaxed);
    };
}

template <int W> void RodTiles<W>::run_passes(const RodTile<W>& tile, SlotLoad<W>* load, std::size_t first,
                                              std::size_t end, const Step& step) const {
    const TilePasses<W>& program = programs_[tile.program].passes;
    for (std::size_t pass = first; pass < end; ++pass) program[pass]->run(tile, load, step);
}

template <int W> void RodTiles<W>::advance_cluster(const Cluster& cluster, const StepPart& part, int thread) {
    SlotLoad<W>* load = nth(scratch_, thread).data();
    const auto with_passes = [&](Part which, auto&& f) {
        for (const std::size_t t : cluster.tiles) {
            const auto [first, end] = passes(tiles_[t].program, which);
            f(tiles_[t], first, end);
        }
    };
    for (const Step& step : part.steps) {
        if (part.which != Part::after)
            with_passes(Part::before, [&](const RodTile<W>& tile, std::size_t first, std::size_t end) {
                run_passes(tile, load, first, end, step);
            });
        if (part.which == Part::before) continue;
        if (cluster.step) {
            step_cluster(cluster, step, load, thread);
            continue;
        }
        const JoinedLoad<W>* joined = couple(cluster, step, thread);
        const bool shares_nodes = cluster.joints->shares_nodes();
        with_passes(Part::after, [&](RodTile<W> tile, std::size_t first, std::size_t end) {
            tile.joined = joined;
            joined += tile.last + 1;
            run_passes(tile, load, first, shares_nodes ? end - programs_[tile.program].last : end, step);
        });
        if (!shares_nodes) continue;
        cluster.joints->move_as_one(tiles_[cluster.tiles.front()].slot, cluster.memory.data(), step, cluster.across);
        with_passes(Part::after, [&](const RodTile<W>& tile, std::size_t, std::size_t end) {
            run_passes(tile, load, end - programs_[tile.program].last, end, step);
        });
    }
}

template <int W>
void RodTiles<W>::step_cluster(const Cluster& cluster, const Step& step, SlotLoad<W>* load, int thread) {
    cluster.step->run(
        cluster.stepped, step, cluster.memory.data(), thread,
        [&](const RodTile<W>& tile, SlotLoad<W>* of_tile) {
            const TileProgram<W>& program = programs_[tile.program];
            run_passes(tile, of_tile, program.before, program.joined, step);
        },
        [&] { return end_moments(cluster, step, thread); });
    for (const SteppedTile<W>& one : cluster.stepped) {
        const TileProgram<W>& program = programs_[one.rod.program];
        run_passes(one.rod, load, program.joined + 1, program.passes.size(), step);
    }
    cluster.step->gather(cluster.stepped, step, cluster.memory.data());
}

template <int W> JoinedLoad<W>* RodTiles<W>::couple(const Cluster& cluster, const Step& step, int thread) const {
    JoinedLoad<W>* joined = nth(joined_, thread).data();
    Slot<W>* slot = tiles_[cluster.tiles.front()].slot;
    if (cluster.joints->shares_nodes()) cluster.joints->gather(slot, cluster.memory.data(), cluster.across);
    cluster.joints->run(slot, end_moments(cluster, step, thread), step, cluster.memory.data(), joined, cluster.across);
    return joined;
}

template <int W>
const EndMoments<W>* RodTiles<W>::end_moments(const Cluster& cluster, const Step& step, int thread) const {
    if (!cluster.muscles) return nullptr;
    EndMoments<W>* moments = nth(moments_, thread).data();
    for (std::size_t i = 0; i < cluster.tiles.size(); ++i) {
        const RodTile<W>& tile = tiles_[cluster.tiles[i]];
        moments[i] = {};
        for (const MakesEndMoments<W>* muscles : muscles_[tile.program])
            muscles->add_end_moments(tile, step, moments[i]);
    }
    return moments;
}

template <int W> std::vector<std::string_view> RodTiles<W>::passes(std::size_t group) const {
    return programs_[group].names;
}

template <int W> bool RodTiles<W>::moves_as_resolved(const RodTile<W>& tile) const {
    if (tile.strands || !watch_.restrains(*tile.group)) return true; // bodies lie across
    const Slot<W>& s = tile.slot[0];
    const double speed = watch_.most_speed(*tile.group), spin = watch_.most_spin();
    return !any(dot(s.velocity, s.velocity) > Pack<W>(speed * speed)) &&
           !any(dot(s.spin, s.spin) > Pack<W>(spin * spin));
}

template <int W> bool RodTiles<W>::healthy(const RodTile<W>& tile) {
    if (!valid(tile)) return false;
    if (watch_.dt == 0) return true;
    if (!moves_as_resolved(tile)) return false;
    const Pack<W> share_squared = Pack<W>(watch_.share_squared()) * largest_eigenvalue(tile);
    if (!any(share_squared > Pack<W>(StepWatch::feeds * StepWatch::feeds))) return true;
    const std::size_t group = to_index(tile.group_of(0).id());
    if (group < watch_.undamped.size() && watch_.undamped[group]) {
        double most = 0, before = undamped_share_.load(std::memory_order_relaxed);
        for (int l = 0; l < W; ++l) most = std::max(most, std::sqrt(share_squared[l]));
        while (most > before && !undamped_share_.compare_exchange_weak(before, most, std::memory_order_relaxed)) {
        }
    }
    if (!any(share_squared > Pack<W>(StepWatch::near * StepWatch::near))) return true;
    near_.store(true, std::memory_order_relaxed);
    return !(watch_.stops && any(share_squared > Pack<W>(1.0)));
}

template <int W> template <class F> void RodTiles<W>::for_slots(std::size_t i, F&& f) const {
    const auto [t, first] = place_[i];
    const RodTile<W>& tile = tiles_[t];
    const int slots = nth(groups_, local_[i].group).slots();
    if (!tile.strands) {
        for (int k = 0; k < slots; ++k) f(k, tile.slot[k], first);
        return;
    }
    for (int k = 0; k < slots; ++k) {
        const auto [row, l] = tile.strands->place(first, k);
        f(k, tile.slot[row], l);
    }
}

template <int W> bool RodTiles<W>::advance(std::span<const Step> steps, bool check) {
    return run({Part::whole, steps}, {}, check);
}

template <int W> void RodTiles<W>::drift(const Step& step) { run({Part::before, {&step, 1}}, {}, false); }

template <int W> bool RodTiles<W>::kick(const Step& step, bool check) {
    return run({Part::after, {&step, 1}}, {}, check);
}

template <int W> void RodTiles<W>::kick_and_drift(const Step& step, const Step& next) {
    run({Part::after, {&step, 1}}, {Part::before, {&next, 1}}, false);
}

template <int W> std::pair<std::size_t, std::size_t> RodTiles<W>::passes(std::size_t program, Part part) const {
    const TileProgram<W>& all = programs_[program];
    return {part == Part::after ? all.before : 0, part == Part::before ? all.before : all.passes.size()};
}

template <int W> void RodTiles<W>::prepare(const StepPart& part) {
    for (std::size_t program = 0; program < programs_.size(); ++program) {
        const auto [first, end] = passes(program, part.which);
        for (std::size_t pass = first; pass < end; ++pass) programs_[program].passes[pass]->prepare(part.steps);
    }
    if (part.which == Part::before) return;
    for (const auto& joints : joints_)
        if (joints) joints->prepare(part.steps);
}

template <int W> bool RodTiles<W>::run(const StepPart& first, const StepPart& second, bool check) {
    sweep_ = {first, second};
    for (const StepPart& part : sweep_)
        if (!part.steps.empty()) prepare(part);
    check_ = check;
    valid_ = true;
    near_ = false;
    threads_.for_each(clusters_.size() + alone_.size(), advance_);
    return valid_;
}

template <int W> void RodTiles<W>::set_rods(const Cluster& cluster) const {
    const RodTile<W>& first = tiles_[cluster.tiles.front()];
    std::vector<std::int64_t> copies;
    for (int l = 0; l < (cluster.across ? first.lanes : 1); ++l)
        copies.push_back(first.index_of(l) / first.group->rods_per_copy());
    cluster.joints->set_rods(cluster.memory.data(), cluster.across, copies);
}

template <int W> void RodTiles<W>::renew_formulas() {
    const std::size_t across = first_rod_.size();
    threads_.for_each(tiles_.size(), [&](std::size_t t, int) {
        const RodTile<W>& tile = tiles_[t];
        const RodGroup* unlike = tile.strands && tile.group && tile.group->heterogeneous() ? tile.group : nullptr;
        Strands<W>* strands = unlike ? &*strands_[t - across] : nullptr;
        if (unlike) strands->settle_each([&](std::int64_t i) -> const RodGroup& { return unlike->kind(i); });
        for (const auto& pass : programs_[tile.program].passes) {
            pass->renew(tile);
            if (const auto* step = dynamic_cast<const EvaluatesPasses<W>*>(pass.get()))
                for (const EvaluatedPass<W>& one : step->evaluated()) one.pass->renew(tile);
        }
        if (unlike) strands->settle(*unlike);
    });
    threads_.for_each(clusters_.size(), [&](std::size_t c, int) { set_rods(clusters_[c]); });
}

template <int W> void RodTiles<W>::export_rod(std::size_t i, std::span<Slot<1>> out) const {
    for_slots(i, [&](int k, const Slot<W>& slot, int l) { nth(out, k) = lane(slot, l); });
    const RodTile<W>& tile = tiles_[place_[i].tile];
    if (tile.strands) out.back().director = broadcast<1>(no_turn); // not that of the wall
}

template <int W> void RodTiles<W>::import_rod(std::size_t i, std::span<const Slot<1>> in) {
    const auto [t, first] = place_[i];
    const RodTile<W>& tile = tiles_[t];
    if (tile.strands) {
        for_slots(i, [&](int k, Slot<W>& slot, int l) {
            const Quaterniond wall = lane(slot.director, l);
            set_lane(slot, l, nth(in, k));
            if (to_index(k) + 1 == in.size()) set_lane(slot.director, l, wall);
        });
        join(tile);
        return;
    }
    // The last rod of a tile also fills the spare lanes, so that they stay finite and need no special case.
    const int last = first == tile.lanes - 1 ? W - 1 : first;
    for (int l = first; l <= last; ++l)
        for (std::size_t k = 0; k < in.size(); ++k) set_lane(tile.slot[k], l, in[k]);
}

template <int W> RodTile<W> RodTiles<W>::moved(const RodTile<W>& tile, Copy copy, double lag, Reading& reading) const {
    RodTile<W> own = tile;
    if (copy == Copy::canonical) return own;
    reading.slot.resize(std::max(reading.slot.size(), to_index(tile.last) + 1));
    own.slot = reading.slot.data();
    std::copy_n(tile.slot, tile.last + 1, own.slot);
    if (copy == Copy::positions) synchronise_positions(own, lag);
    else synchronise(own, lag);
    return own;
}

namespace {

/// Numbers of packs as rows, one per lane.
template <int W> void to_rows(const Pack<W>* packs, std::size_t count, double* rows, std::size_t row_length) {
    const double* from = reinterpret_cast<const double*>(packs);
    for (std::size_t number = 0; number < count; ++number)
#pragma GCC unroll 8
        for (std::size_t i = 0; i < W; ++i) rows[i * row_length + number] = *from++;
}

/// Hashes of the canonical state of all lanes, with as many chains of multiplications in flight.
template <int W> std::array<std::uint64_t, W> hashes(const RodTile<W>& tile, const LocalRod* rods) {
    std::array<std::uint64_t, W> h;
    for (int i = 0; i < W; ++i) nth(h, i) = hash_begin(rods[std::min(i, tile.lanes - 1)].gid);
    const double* from = reinterpret_cast<const double*>(tile.slot);
    for (int number = 0; number < (tile.last + 1) * slot_doubles; ++number)
#pragma GCC unroll 8
        for (std::size_t i = 0; i < W; ++i) h[i] = hash_with(h[i], *from++);
    for (std::uint64_t& one : h) one = hash_end(one);
    return h;
}

template <class Row> void at_least(std::vector<Row>& rows, std::size_t count) {
    if (rows.size() < count) rows.resize(count);
}

} // namespace

template <int W> void RodTiles<W>::take_apart(const RodTile<W>& tile, Copy copy, double lag, double time,
                                              const LocalRod* rods, Reading& reading) const {
    const RodTile<W> own = moved(tile, copy, lag, reading);
    const std::size_t n = to_index(tile.n), slots = to_index(tile.last) + 1;
    at_least(reading.state, W * slots);
    to_rows(&own.slot->position.x, slots * slot_doubles, reinterpret_cast<double*>(reading.state.data()),
            slots * slot_doubles);
    if (copy == Copy::canonical) reading.hash = hashes(tile, rods);
    if (!has_frames(copy)) return;
    at_least(reading.frames, W * n);
    constexpr std::size_t numbers = sizeof(Mat3d) / sizeof(double);
    for (std::size_t k = 0; k < n; ++k) {
        const Mat3<Pack<W>> q = matrix(own.slot[k].director);
        to_rows(&q.d1.x, numbers, reinterpret_cast<double*>(reading.frames.data() + k), n * numbers);
    }
    if (copy != Copy::strained) return;
    if (reading.profile.size() < slots) reading.profile.resize(slots);
    at_least(reading.profiles, W * slots);
    rod_profile(own, time, reading.profile.data());
    constexpr std::size_t figures = sizeof(NodeProfile) / sizeof(double);
    to_rows(&reading.profile[0].strain, slots * figures, reinterpret_cast<double*>(reading.profiles.data()),
            slots * figures);
}

template <int W>
void RodTiles<W>::take_along(std::size_t i, Copy copy, double lag, double time, Reading& reading) const {
    const RodGroup& group = nth(groups_, local_[i].group);
    const std::size_t slots = to_index(group.slots());
    at_least(reading.state, slots);
    const std::span state = std::span(reading.state).first(slots);
    export_rod(i, state);
    if (copy == Copy::canonical) reading.hash[0] = hash_rod(local_[i].gid, state);
    else if (copy == Copy::positions) skein::synchronise_positions(tile_of(group, state), lag);
    else skein::synchronise(tile_of(group, state), lag);
    if (!has_frames(copy)) return;
    at_least(reading.frames, slots - 1);
    for (std::size_t k = 0; k + 1 < slots; ++k) reading.frames[k] = frame(state[k]);
    if (copy != Copy::strained) return;
    at_least(reading.profiles, slots);
    const RodGroup& own = group.heterogeneous() ? own_group(reading, 0, group, local_[i].index) : group;
    rod_profile(tile_of(own, state, local_[i].index), time,
                reinterpret_cast<NodeProfileOf<Pack<1>>*>(reading.profiles.data()));
}

template <int W> void RodTiles<W>::read(std::span<const std::size_t> rods, Copy copy, double lag,
                                        const RodReader& reader, double time) const {
    const auto place = [&](std::size_t i) { return place_[rods[i]]; };
    const auto same_tile = [&](std::size_t i) {
        return i > 0 && i < rods.size() && place(i).tile == place(i - 1).tile;
    };
    const auto whole_tiles = [&](std::size_t i) {
        while (same_tile(i)) ++i;
        return std::min(i, rods.size());
    };
    // A task has a batch of rods, extended to the end of their last tile. Few rods take readers longer than copies:
    // threads then share tiles, and each copies a tile for itself.
    const std::size_t batch = std::clamp<std::size_t>(rods.size() / reading_.size(), 1, 16);
    const auto begin_of = [&](std::size_t task) {
        return batch < W ? std::min(task * batch, rods.size()) : whole_tiles(task * batch);
    };
    threads_.for_each((rods.size() + batch - 1) / batch, [&](std::size_t task, int thread) {
        Reading& reading = nth(reading_, thread);
        const std::size_t begin = begin_of(task), end = begin_of(task + 1);
        for (std::size_t i = begin; i < end; ++i) {
            const RodTile<W>& tile = tiles_[place(i).tile];
            const RodGroup& group = nth(groups_, local_[rods[i]].group);
            const std::size_t slots = to_index(group.slots()), elements = to_index(group.elements());
            if (tile.strands) take_along(rods[i], copy, lag, time, reading);
            else if (i == begin || !same_tile(i))
                take_apart(tile, copy, lag, time, &local_[first_rod_[place(i).tile]], reading);
            const auto l = tile.strands ? 0 : to_index(place(i).lane);
            RodCopy one{.state = std::span(reading.state).subspan(l * slots, slots), .hash = reading.hash[l]};
            if (copy == Copy::strained) one.profile = std::span(reading.profiles).subspan(l * slots, slots);
            if (has_frames(copy)) one.frames = std::span(reading.frames).subspan(l * elements, elements);
            reader(thread, i, one);
        }
    });
}

template <int W> void RodTiles<W>::figures(double time, double lag, std::span<RodFigures> out) const {
    threads_.for_each(tiles_.size(), [&](std::size_t t, int thread) {
        if (tiles_[t].strands) return;
        const RodTile<W> own = moved(tiles_[t], Copy::synchronised, lag, nth(reading_, thread));
        put_figures(figures_of(own, time), out.subspan(first_rod_[t], to_index(own.lanes)));
    });
    threads_.for_each(along_.size(), [&](std::size_t a, int thread) {
        Reading& reading = nth(reading_, thread);
        const std::size_t i = along_[a];
        const RodGroup& group = nth(groups_, local_[i].group);
        take_along(i, Copy::synchronised, lag, 0, reading);
        const std::span state = std::span(reading.state).first(to_index(group.slots()));
        const RodGroup& own = group.heterogeneous() ? own_group(reading, 0, group, local_[i].index) : group;
        put_figures(figures_of(tile_of(own, state, local_[i].index), time), out.subspan(i, 1));
    });
}

template <int W> std::uint64_t RodTiles<W>::digest() const {
    struct alignas(cache_line) Sum {
        std::uint64_t sum = 0;
    };
    std::vector<Sum> sums(reading_.size());
    threads_.for_each(tiles_.size(), [&](std::size_t t, int thread) {
        if (tiles_[t].strands) return;
        const auto all = hashes(tiles_[t], &local_[first_rod_[t]]);
        for (int i = 0; i < tiles_[t].lanes; ++i) nth(sums, thread).sum += nth(all, i);
    });
    threads_.for_each(along_.size(), [&](std::size_t a, int thread) {
        Reading& reading = nth(reading_, thread);
        take_along(along_[a], Copy::canonical, 0, 0, reading);
        nth(sums, thread).sum += reading.hash[0];
    });
    std::uint64_t sum = 0;
    for (const Sum& one : sums) sum += one.sum;
    return sum;
}

template <int W> RodBudget RodTiles<W>::budget(std::size_t i) const {
    if (audits_.empty()) return {};
    const auto [t, l] = place_[i];
    return audits_[tiles_[t].program]->budget(tiles_[t].number, l);
}

template <int W> void RodTiles<W>::set_budget(std::size_t i, const RodBudget& budget) {
    if (audits_.empty()) return;
    const auto [t, l] = place_[i];
    audits_[tiles_[t].program]->set_budget(tiles_[t].number, l, budget);
}

template <int W> std::vector<double> RodTiles<W>::memory(std::size_t i) const {
    std::vector<double> numbers;
    const auto [t, l] = place_[i];
    for (const auto& pass : programs_[tiles_[t].program].passes) pass->append_memory(tiles_[t], l, numbers);
    if (cluster_of_[t] != SIZE_MAX) {
        const Cluster& cluster = clusters_[cluster_of_[t]];
        cluster.joints->append_memory(cluster.memory.data(), cluster.across, joined_rod(i, l), numbers);
    }
    return numbers;
}

template <int W> JoinedRod RodTiles<W>::joined_rod(std::size_t i, int lane) const {
    const LocalRod& rod = local_[i];
    return {rod.group, rod.index % nth(groups_, rod.group).rods_per_copy(), lane};
}

template <int W> void RodTiles<W>::set_memory(std::size_t i, std::span<const double> numbers) {
    const auto [t, first] = place_[i];
    const RodTile<W>& tile = tiles_[t];
    const int last = first == tile.lanes - 1 ? W - 1 : first; // spare lanes repeat the last rod
    for (const auto& pass : programs_[tile.program].passes) {
        std::size_t taken = 0;
        for (int l = first; l <= last; ++l) taken = pass->restore(tile, l, numbers);
        numbers = numbers.subspan(taken);
    }
    if (cluster_of_[t] == SIZE_MAX) return;
    const Cluster& cluster = clusters_[cluster_of_[t]];
    for (int l = first; l <= (cluster.across ? last : first); ++l)
        cluster.joints->restore(cluster.memory.data(), cluster.across, joined_rod(i, l), numbers);
}

template <int W> template <class F> void RodTiles<W>::for_implicit_steps(F&& f) {
    for (const TileProgram<W>& program : programs_)
        for (const auto& pass : program.passes)
            if (auto* step = dynamic_cast<EvaluatesPasses<W>*>(pass.get())) f(*step);
}

template <int W> void RodTiles<W>::keep(std::size_t place) {
    kept_[place].need(slots_.size());
    threads_.for_each(tiles_.size(), [&](std::size_t t, int) {
        const RodTile<W>& tile = tiles_[t];
        std::copy_n(tile.slot, tile.last + 1, kept_[place].data() + (tile.slot - slots_.data()));
        if (!audits_.empty() && audits_[tile.program]) audits_[tile.program]->keep(tile.number, place);
    });
    for (Cluster& cluster : clusters_) cluster.kept[place] = cluster.memory;
    for_implicit_steps([&](EvaluatesPasses<W>& step) { step.keep(place); });
}

template <int W> void RodTiles<W>::go_back(std::size_t place) {
    threads_.for_each(tiles_.size(), [&](std::size_t t, int) {
        const RodTile<W>& tile = tiles_[t];
        std::copy_n(kept_[place].data() + (tile.slot - slots_.data()), tile.last + 1, tile.slot);
        if (!audits_.empty() && audits_[tile.program]) audits_[tile.program]->go_back(tile.number, place);
    });
    for (Cluster& cluster : clusters_) cluster.memory = cluster.kept[place];
    for_implicit_steps([&](EvaluatesPasses<W>& step) { step.go_back(place); });
}

template <int W> double RodTiles<W>::farthest_from(std::size_t place) const {
    std::vector<double> most(tiles_.size());
    threads_.for_each(tiles_.size(), [&](std::size_t t, int) {
        const RodTile<W>& tile = tiles_[t];
        const Slot<W>* kept = kept_[place].data() + (tile.slot - slots_.data());
        Pack<W> squared(0.0);
        for (int k = 0; k <= tile.last; ++k) {
            const Vec3<Pack<W>> apart = tile.slot[k].position - kept[k].position;
            squared = max(squared, dot(apart, apart));
        }
        for (int l = 0; l < W; ++l) most[t] = std::max(most[t], squared[l]);
    });
    return std::sqrt(most.empty() ? 0.0 : *std::max_element(most.begin(), most.end()));
}

template <int W> std::size_t RodTiles<W>::bytes() const {
    std::size_t bytes = (slots_.size() + kept_[0].size() + kept_[1].size()) * sizeof(Slot<W>) +
                        tiles_.size() * sizeof(RodTile<W>) + local_.size() * (sizeof(LocalRod) + sizeof(Place));
    for (const auto& scratch : scratch_) bytes += scratch.size() * sizeof(SlotLoad<W>);
    for (const auto& joined : joined_) bytes += joined.size() * sizeof(JoinedLoad<W>);
    for (const auto& audit : audits_)
        if (audit) bytes += audit->bytes();
    for (const auto& strands : strands_) bytes += strands->bytes();
    return bytes;
}

template <int W> void RodTiles<W>::inspect(std::int64_t step, double dt) const {
    char where[160];
    std::snprintf(where, sizeof where, " at step %lld (t = %.6g s, dt = %.6g s)", static_cast<long long>(step),
                  static_cast<double>(step) * dt, dt);
    std::vector<Slot<1>> state;
    std::vector<bool> invalid(tiles_.size());
    for (std::size_t t = 0; t < tiles_.size(); ++t) invalid[t] = !valid(tiles_[t]) || !moves_as_resolved(tiles_[t]);
    for (std::size_t rod = 0; rod < local_.size(); ++rod) {
        if (!invalid[place_[rod].tile]) continue;
        const RodGroup& group = nth(groups_, local_[rod].group);
        state.resize(to_index(group.slots()));
        export_rod(rod, state);
        with_rod(group, local_[rod].index, [&](const RodGroup& own) {
            if (const auto invalid = find_invalid(own, state))
                throw NumericalError(name_of(rod) + invalid->reason + where + tension_hint(own, state));
            if (const std::string text = unresolved_motion(own, state, watch_); !text.empty())
                throw NumericalError(name_of(rod) + text + where);
        });
    }
    const NearLimit found = nearest_limit();
    if (watch_.stops && watch_.share(found.at.eigenvalue) > 1) throw NumericalError(text_of(found) + where);
}

template <int W> std::string RodTiles<W>::name_of(std::size_t i) const {
    const RodGroup& group = nth(groups_, local_[i].group);
    return (group.strained() ? "rod " : "body ") + std::to_string(local_[i].index) + " of '" + group.name() + "', ";
}

template <int W> typename RodTiles<W>::NearLimit RodTiles<W>::nearest_limit() const {
    NearLimit found;
    if (watch_.dt == 0) return found;
    std::vector<double> largest(tiles_.size());
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
        const Pack<W> of_tile = largest_eigenvalue(tiles_[t]);
        for (int i = 0; i < W; ++i) largest[t] = std::max(largest[t], of_tile[i]);
    }
    std::vector<Slot<1>> state;
    for (std::size_t rod = 0; rod < local_.size(); ++rod) {
        if (!(largest[place_[rod].tile] > found.at.eigenvalue)) continue;
        with_rod(nth(groups_, local_[rod].group), local_[rod].index, [&](const RodGroup& group) {
            state.resize(to_index(group.slots()));
            export_rod(rod, state);
            if (const Tightest at = tightest(group, state); at.eigenvalue > found.at.eigenvalue) found = {rod, at};
        });
    }
    return found;
}

template <int W> std::string RodTiles<W>::text_of(const NearLimit& found) const {
    return name_of(found.rod) + skein::text_of(found.at, watch_);
}

template <int W> std::string RodTiles<W>::near_limit() const {
    if (!near_) return {};
    const NearLimit found = nearest_limit();
    return watch_.share(found.at.eigenvalue) > StepWatch::near ? text_of(found) : std::string();
}

template <int W> std::vector<PassEffect> RodTiles<W>::dissect(std::size_t i, std::span<const Step> stages) {
    return with_rod(nth(groups_, local_[i].group), local_[i].index,
                    [&](const RodGroup& group) { return dissect(i, group, stages); });
}

template <int W>
std::vector<PassEffect> RodTiles<W>::dissect(std::size_t i, const RodGroup& group, std::span<const Step> stages) {
    const auto [t, first] = place_[i];
    const RodTile<W>& tile = tiles_[t];
    SlotLoad<W>* load = scratch_[0].data();
    std::vector<Slot<1>> state(to_index(group.slots()));
    prepare({Part::whole, stages});
    RodTile<W> own = tile;
    if (cluster_of_[t] != SIZE_MAX) {
        const Cluster& cluster = clusters_[cluster_of_[t]];
        const auto memory = cluster.memory;
        own.joined = couple(cluster, stages.front(), 0) + (tile.slot - tiles_[cluster.tiles.front()].slot);
        cluster.memory = memory;
    }
    std::vector<Vec3d> force(state.size()), couple(state.size());
    const TileProgram<W>& program = programs_[tile.program];
    std::vector<PassEffect> effects;
    for (const std::string_view name : program.names) effects.push_back({name});
    PassWatch watch(group);
    for (const Step& step : stages) {
        std::fill(load, load + tile.n + 1, SlotLoad<W>{});
        watch.begin();
        for (std::size_t p = 0; p < effects.size(); ++p) {
            program.passes[p]->run(own, load, step);
            for (int k = 0; k < group.slots(); ++k) {
                const auto [row, l] =
                    tile.strands ? tile.strands->place(first, k) : typename Strands<W>::Place{k, first};
                const std::size_t at = to_index(k);
                force[at] = lane(load[row].force, l);
                couple[at] = lane(load[row].couple, l);
            }
            export_rod(i, state);
            watch.compare(effects[p], state, force, couple, step.dt, program.passes[p]->adds_loads());
        }
    }
    return effects;
}

template class RodTiles<SKEIN_WIDTH>;

} // namespace skein
