#include "rod/rod_tiles.hpp"

#include "core/error.hpp"
#include "core/rotation.hpp"
#include "rod/time_limits.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace skein {

namespace {

constexpr double least_half_cosine = 0.0707; // |cos(theta/2)| of 3 rad between neighbouring elements
constexpr double least_dilatation = 0.05;

/// Beyond the tension limit directors flip, so a run must not go on.
double most_dilatation(const RodGroup& group) { return std::min(20.0, tension_limit(group)); }
template <int W> Pack<W> most_dilatation(const RodTile<W>& tile) {
    if (!tile.strands) return Pack<W>(most_dilatation(*tile.group));
    Pack<W> most(0.0);
    for (int i = 0; i < W; ++i) most.set(i, most_dilatation(tile.group_of(i)));
    return most;
}

/// Beyond this cell none follows: the element at a free or held end has no neighbour, a ring's has its first.
int cell_count(const RodGroup& group) { return static_cast<int>(group.voronoi.size()); }

/// What is wrong with a rod, or an empty text.
std::string complaint(const RodGroup& group, std::span<const Slot<1>> state) {
    const auto finite = [](const Vec3d& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); };
    char text[160];
    for (int k = 0; k <= group.elements(); ++k) {
        const Slot<1>& s = state[static_cast<std::size_t>(k)];
        const char* quantity = !finite(lane(s.position, 0))                     ? "position"
                               : !finite(lane(s.velocity, 0))                   ? "velocity"
                               : !std::isfinite(dot(s.director, s.director)[0]) ? "director"
                               : !finite(lane(s.spin, 0))                       ? "angular velocity"
                                                                                : nullptr;
        if (quantity) {
            std::snprintf(text, sizeof text, "element %d: %s is not finite", k, quantity);
            return text;
        }
    }
    if (group.law() == Law::rigid) return {};
    for (int k = 0; k < group.elements(); ++k) {
        const Slot<1>&s = state[static_cast<std::size_t>(k)], &next = state[static_cast<std::size_t>(k) + 1];
        const double e = group.element[static_cast<std::size_t>(k)].inv_rest_length *
                         dot(lane(third_director(s.director), 0), lane(next.position, 0) - lane(s.position, 0));
        if (!(e > least_dilatation && e < most_dilatation(group))) {
            std::snprintf(text, sizeof text, "element %d: dilatation e = %.4g left [%g, %g]", k, e, least_dilatation,
                          most_dilatation(group));
            return text;
        }
        if (k == cell_count(group)) break;
        const int after = (k + 1) % group.elements();
        if (!(std::abs(dot(s.director, state[static_cast<std::size_t>(after)].director)[0]) > least_half_cosine)) {
            std::snprintf(text, sizeof text, "elements %d and %d: turned against each other by more than 3 rad", k, after);
            return text;
        }
    }
    return {};
}

/// The most stretched element, where it is beyond the group's tension limit: directors flip there, and all else follows from it.
std::string tension_hint(const RodGroup& group, std::span<const Slot<1>> state) {
    const double limit = tension_limit(group);
    double most = 0;
    int element = 0;
    for (int k = 0; k < group.elements(); ++k) {
        const auto at = static_cast<std::size_t>(k);
        const double e = group.element[at].inv_rest_length * norm(lane(state[at + 1].position, 0) - lane(state[at].position, 0));
        if (e > most) most = e, element = k;
    }
    char text[160] = "";
    if (most > limit)
        std::snprintf(text, sizeof text, "; tension instability of element %d: e = %.4g, limit e_c = %.4g", element, most, limit);
    return text;
}

/// True in lanes whose state is fit: finite, dilatations and turns within bounds. The cheap test of all rods.
template <class Map, int W> bool fit(const RodTile<W>& tile) {
    using P = Pack<W>;
    P zero(0.0), least(1.0), most(0.0), half_cosine(1.0);
    const bool rigid = tile.group_of(0).law() == Law::rigid;
    for (int k = 0; k < tile.n; ++k) {
        const Slot<W>& s = tile.slot[k];
        const Vec3<P> all = s.position + s.velocity + s.director.v + s.spin;
        zero = fma(all.x + all.y + all.z + s.director.w, P(0.0), zero);
        const P e = rigid ? P(1.0) : element_strain<Map>(tile, k).z;
        least = min(least, e);
        most = max(most, e);
        if constexpr (Map::along) {
            half_cosine =
                select(tile.strands->cell[k].inner, min(half_cosine, abs(dot(s.director, tile.slot[k + 1].director))), half_cosine);
        } else {
            if (k == cell_count(*tile.group)) break;
            half_cosine = min(half_cosine, abs(dot(s.director, tile.slot[(k + 1) % tile.n].director)));
        }
    }
    const Vec3<P> end = tile.slot[tile.n].position + tile.slot[tile.n].velocity;
    zero = fma(end.x + end.y + end.z, P(0.0), zero);
    const auto good =
        (zero >= P(0.0)) & (least > P(least_dilatation)) & (most < most_dilatation(tile)) & (half_cosine > P(least_half_cosine));
    return !any(!good);
}
template <int W> bool fit(const RodTile<W>& tile) {
    return with_mapping(tile, [&]<class Map> { return fit<Map>(tile); });
}

} // namespace

template <int W> RodTiles<W>::RodTiles(std::span<const RodGroup> groups, std::vector<LocalRod> rods, const Tiling& tiling,
                                       std::vector<TileProgram<W>> programs, const Threads& threads,
                                       std::vector<std::shared_ptr<AuditBook<W>>> audits, StepWatch watch)
    : groups_(groups), local_(std::move(rods)), programs_(std::move(programs)), audits_(std::move(audits)), threads_(threads),
      watch_(watch) {
    std::vector<Boarding> boardings = lay_out(tiling);
    for (const TileProgram<W>& program : programs_) {
        const auto meet = std::find_if(program.begin(), program.end(), [](const auto& pass) { return pass->rods_meet(); });
        meeting_.push_back(meet == program.end() ? 0 : static_cast<std::size_t>(meet - program.begin()) + 1);
    }
    take_start_states(std::move(boardings));

    int most_slots = 0;
    for (const RodTile<W>& tile : tiles_) most_slots = std::max(most_slots, tile.n + 1);
    scratch_.resize(static_cast<std::size_t>(threads_.count()));
    for (auto& scratch : scratch_) scratch.resize(static_cast<std::size_t>(most_slots));

    // Tiles outside, passes inside: a tile stays in cache for all passes of all steps of the visit.
    advance_tile_ = [this](std::size_t t, int thread) {
        const RodTile<W>& tile = tiles_[t];
        SlotLoad<W>* load = scratch_[static_cast<std::size_t>(thread)].data();
        const TileProgram<W>& program = programs_[tile.program];
        for (const Stretch& stretch : visit_) {
            const auto [first, behind] = passes(tile.program, stretch.part);
            for (const Step& step : stretch.steps)
                for (std::size_t pass = first; pass < behind; ++pass) program[pass]->run(tile, load, step);
        }
        if (check_ && !healthy(tile)) fit_.store(false, std::memory_order_relaxed);
    };
}

template <int W> bool RodTiles<W>::healthy(const RodTile<W>& tile) {
    if (!fit(tile)) return false;
    if (watch_.dt == 0) return true;
    const Pack<W> share_squared = Pack<W>(watch_.share_squared()) * largest_eigenvalue(tile);
    if (!any(share_squared > Pack<W>(StepWatch::near * StepWatch::near))) return true;
    near_.store(true, std::memory_order_relaxed);
    return !(watch_.stops && any(share_squared > Pack<W>(1.0)));
}

template <int W> std::vector<typename RodTiles<W>::Boarding> RodTiles<W>::lay_out(const Tiling& tiling) {
    std::vector<std::size_t> tiles_of_program(programs_.size(), 0), first_slot;
    std::size_t slots = 0;
    const auto open = [&](RodTile<W> tile, std::size_t program) -> RodTile<W>& {
        tile.program = program;
        tile.number = tiles_of_program[program]++;
        first_slot.push_back(slots);
        slots += static_cast<std::size_t>(tile.n) + 1;
        return tiles_.emplace_back(tile);
    };

    place_.resize(local_.size());
    std::vector<std::vector<std::size_t>> pool(groups_.size()); // rods that lie along, by group
    std::vector<std::int64_t> across = tiling.across;
    for (std::size_t i = 0; i < local_.size(); ++i) {
        const auto g = static_cast<std::size_t>(local_[i].group);
        if (across[g]-- <= 0) {
            pool[g].push_back(i);
            continue;
        }
        const RodGroup& group = groups_[g];
        const bool opens = tiles_.empty() || tiles_.back().group != &group || tiles_.back().lanes == W;
        RodTile<W>& tile =
            opens ? open({nullptr, group.element.data(), group.voronoi.data(), &group, group.elements()}, g) : tiles_.back();
        place_[i] = {tiles_.size() - 1, tile.lanes};
        std::fill(tile.index + tile.lanes, tile.index + W, local_[i].index); // spare lanes repeat the last rod
        ++tile.lanes;
    }
    std::vector<std::size_t> next(groups_.size(), 0);
    std::vector<Boarding> boardings;
    for (const AlongTile& along : tiling.along) {
        auto& [seats, rods] = boardings.emplace_back();
        int lane_ = 0;
        for (const auto& [g, stretches] : along.parts) {
            const auto group = static_cast<std::size_t>(g);
            const std::size_t i = pool[group][next[group]++];
            seats.push_back({&groups_[group], local_[i].index, lane_, stretches});
            rods.push_back(i);
            place_[i] = {tiles_.size(), lane_};
            lane_ += stretches;
        }
        open({.n = along.rows, .lanes = static_cast<int>(seats.size())}, groups_.size() + static_cast<std::size_t>(along.family));
    }
    for (std::size_t p = 0; p < programs_.size(); ++p) // of groups that all lie along, or that have no rod here
        if (tiles_of_program[p] == 0) programs_[p].clear();
    slots_.resize(slots);
    for (std::size_t t = 0; t < tiles_.size(); ++t) tiles_[t].slot = slots_.data() + first_slot[t];
    return boardings;
}

template <int W> void RodTiles<W>::take_start_state(std::size_t i, const RodGroup& group, std::vector<Slot<1>>& state) {
    state.resize(static_cast<std::size_t>(group.slots()));
    group.start_state(local_[i].index, state);
    import_rod(i, state);
}

template <int W> void RodTiles<W>::take_start_states(std::vector<Boarding> boardings) {
    const Slot<1> still{{0, 0, 0}, {0, 0, 0}, broadcast<1>(no_turn), {0, 0, 0}};
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < local_.size(); ++i)
        if (tiles_[place_[i].tile].group) take_start_state(i, groups_[static_cast<std::size_t>(local_[i].group)], state);
    auto boarding = boardings.begin();
    for (RodTile<W>& tile : tiles_) {
        std::vector<RodGroup> own; // of rods with sizes of their own, while they board
        if (!tile.group) {
            auto& [seats, rods] = *boarding++;
            own.reserve(rods.size());
            for (std::size_t s = 0; s < rods.size(); ++s)
                if (seats[s].group->sized()) seats[s].group = &own.emplace_back(seats[s].group->single(seats[s].index));
            tile.strands = &strands_.emplace_back(seats, tile.n);
            for (int row = 0; row <= tile.n; ++row)
                for (int i = 0; i < W; ++i) {
                    set_lane(tile.slot[row], i, still);
                    const int slot = tile.strands->slot(i, row);
                    if (slot == tile.group_of(i).elements())
                        set_lane(tile.slot[row].director, i, tile.group_of(i).end_frame(tile.index_of(i)));
                }
            for (std::size_t s = 0; s < rods.size(); ++s) take_start_state(rods[s], *seats[s].group, state);
        }
        for (auto& pass : programs_[tile.program]) pass->bind(tile);
        if (!own.empty()) strands_.back().settle(groups_[static_cast<std::size_t>(own.front().id())]);
    }
}

template <int W> template <class F> void RodTiles<W>::for_slots(std::size_t i, F&& f) const {
    const auto [t, first] = place_[i];
    const RodTile<W>& tile = tiles_[t];
    const int slots = groups_[static_cast<std::size_t>(local_[i].group)].slots();
    if (!tile.strands) {
        for (int k = 0; k < slots; ++k) f(k, tile.slot[k], first);
        return;
    }
    for (int k = 0; k < slots; ++k) {
        const auto [row, lane_] = tile.strands->place(first, k);
        f(k, tile.slot[row], lane_);
    }
}

template <int W> bool RodTiles<W>::visit(std::span<const Step> steps, bool check) {
    const Stretch all{Part::whole, steps};
    prepare(all);
    return run(all, {}, check);
}

template <int W> void RodTiles<W>::move(const Step& step) {
    const Stretch there{Part::until_they_meet, {&step, 1}};
    prepare(there);
    run(there, {}, false);
}

template <int W> bool RodTiles<W>::act(const Step& step, bool check) {
    const Stretch back{Part::from_there, {&step, 1}};
    prepare(back);
    return run(back, {}, check);
}

template <int W> void RodTiles<W>::act_and_move(const Step& step, const Step& next) {
    const Stretch back{Part::from_there, {&step, 1}}, there{Part::until_they_meet, {&next, 1}};
    prepare(back);
    prepare(there);
    run(back, there, false);
}

template <int W> std::pair<std::size_t, std::size_t> RodTiles<W>::passes(std::size_t program, Part part) const {
    return {part == Part::from_there ? meeting_[program] : 0,
            part == Part::until_they_meet ? meeting_[program] : programs_[program].size()};
}

template <int W> void RodTiles<W>::prepare(const Stretch& stretch) {
    for (std::size_t program = 0; program < programs_.size(); ++program) {
        const auto [first, behind] = passes(program, stretch.part);
        for (std::size_t pass = first; pass < behind; ++pass) programs_[program][pass]->prepare(stretch.steps);
    }
}

template <int W> bool RodTiles<W>::run(const Stretch& first, const Stretch& then, bool check) {
    visit_ = {first, then};
    check_ = check;
    fit_ = true;
    near_ = false;
    threads_.for_each(tiles_.size(), advance_tile_);
    return fit_;
}

template <int W> void RodTiles<W>::export_rod(std::size_t i, std::span<Slot<1>> out) const {
    for_slots(i, [&](int k, const Slot<W>& slot, int lane_) { out[static_cast<std::size_t>(k)] = lane(slot, lane_); });
    const RodTile<W>& tile = tiles_[place_[i].tile];
    if (tile.strands) out.back().director = broadcast<1>(no_turn); // not the wall's
}

template <int W> void RodTiles<W>::import_rod(std::size_t i, std::span<const Slot<1>> in) {
    const auto [t, first] = place_[i];
    const RodTile<W>& tile = tiles_[t];
    if (tile.strands) {
        for_slots(i, [&](int k, Slot<W>& slot, int lane_) {
            const Quaterniond wall = lane(slot.director, lane_);
            set_lane(slot, lane_, in[static_cast<std::size_t>(k)]);
            if (static_cast<std::size_t>(k) + 1 == in.size()) set_lane(slot.director, lane_, wall);
        });
        join(tile);
        return;
    }
    // The last rod of a tile also fills the spare lanes, so that they stay finite and cost no thought.
    const int last = first == tile.lanes - 1 ? W - 1 : first;
    for (int l = first; l <= last; ++l)
        for (std::size_t k = 0; k < in.size(); ++k) set_lane(tile.slot[k], l, in[k]);
}

template <int W> std::uint64_t RodTiles<W>::digest() const {
    std::uint64_t sum = 0;
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < local_.size(); ++i) {
        state.resize(static_cast<std::size_t>(groups_[static_cast<std::size_t>(local_[i].group)].slots()));
        export_rod(i, state);
        sum += hash_rod(local_[i].gid, state);
    }
    return sum;
}

template <int W> RodWorks RodTiles<W>::works(std::size_t i) const {
    if (audits_.empty()) return {};
    const auto [t, l] = place_[i];
    return audits_[static_cast<std::size_t>(local_[i].group)]->works(tiles_[t].number, l);
}

template <int W> void RodTiles<W>::set_works(std::size_t i, const RodWorks& works) {
    if (audits_.empty()) return;
    const auto [t, l] = place_[i];
    audits_[static_cast<std::size_t>(local_[i].group)]->set_works(tiles_[t].number, l, works);
}

template <int W> std::vector<double> RodTiles<W>::memory(std::size_t i) const {
    std::vector<double> numbers;
    const auto [t, l] = place_[i];
    for (const auto& pass : programs_[tiles_[t].program])
        for (const Pack<W>& p : pass->memory(tiles_[t])) numbers.push_back(p[l]);
    return numbers;
}

template <int W> void RodTiles<W>::set_memory(std::size_t i, std::span<const double> numbers) {
    const auto [t, first] = place_[i];
    const RodTile<W>& tile = tiles_[t];
    const int last = first == tile.lanes - 1 ? W - 1 : first; // spare lanes do what the last rod does
    std::size_t at = 0;
    for (const auto& pass : programs_[tile.program]) {
        for (Pack<W>& p : pass->memory(tile)) {
            for (int l = first; l <= last; ++l) p.set(l, numbers[at]);
            ++at;
        }
        pass->recall(tile);
    }
}

template <int W> std::size_t RodTiles<W>::bytes() const {
    std::size_t bytes =
        slots_.size() * sizeof(Slot<W>) + tiles_.size() * sizeof(RodTile<W>) + local_.size() * (sizeof(LocalRod) + sizeof(Place));
    for (const auto& scratch : scratch_) bytes += scratch.size() * sizeof(SlotLoad<W>);
    for (const auto& audit : audits_) bytes += audit->bytes();
    for (const auto& strands : strands_) bytes += strands.bytes();
    return bytes;
}

template <int W> void RodTiles<W>::inspect(std::int64_t step, double dt) const {
    char where[160];
    std::snprintf(where, sizeof where, " at step %lld (t = %.6g s, dt = %.6g s)", static_cast<long long>(step),
                  static_cast<double>(step) * dt, dt);
    std::vector<Slot<1>> state;
    std::vector<bool> unfit(tiles_.size());
    for (std::size_t t = 0; t < tiles_.size(); ++t) unfit[t] = !fit(tiles_[t]);
    for (std::size_t rod = 0; rod < local_.size(); ++rod) {
        if (!unfit[place_[rod].tile]) continue;
        const RodGroup& group = groups_[static_cast<std::size_t>(local_[rod].group)];
        state.resize(static_cast<std::size_t>(group.slots()));
        export_rod(rod, state);
        with_rod(group, local_[rod].index, [&](const RodGroup& own) {
            const std::string what = complaint(own, state);
            if (!what.empty()) throw NumericalError(name_of(rod) + what + where + tension_hint(own, state));
        });
    }
    const Tightest worst = tightest();
    if (watch_.stops && worst.share > 1) throw NumericalError(text_of(worst) + where);
}

template <int W> std::string RodTiles<W>::name_of(std::size_t i) const {
    return "rod " + std::to_string(local_[i].index) + " of '" + groups_[static_cast<std::size_t>(local_[i].group)].name() + "', ";
}

template <int W> typename RodTiles<W>::Tightest RodTiles<W>::tightest() const {
    Tightest worst;
    if (watch_.dt == 0) return worst;
    std::vector<double> share(tiles_.size()); // squared, largest of each tile
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
        const Pack<W> largest = Pack<W>(watch_.share_squared()) * largest_eigenvalue(tiles_[t]);
        for (int i = 0; i < W; ++i) share[t] = std::max(share[t], largest[i]);
    }
    std::vector<Slot<1>> state;
    for (std::size_t rod = 0; rod < local_.size(); ++rod) {
        if (!(share[place_[rod].tile] > worst.share * worst.share)) continue;
        with_rod(groups_[static_cast<std::size_t>(local_[rod].group)], local_[rod].index, [&](const RodGroup& group) {
            state.resize(static_cast<std::size_t>(group.slots()));
            export_rod(rod, state);
            present_eigenvalues(tile_of(group, state), [&](int k, const PresentEigenvalues<Pack<1>>& l) {
                const double all[] = {l.axial[0], l.about_d1[0], l.about_d2[0], l.twist[0]};
                for (std::size_t mode = 0; mode < std::size(all); ++mode) {
                    const double here = std::sqrt(watch_.share_squared() * all[mode]);
                    if (!(here > worst.share)) continue;
                    const auto at = static_cast<std::size_t>(k);
                    const Slot<1>&s = state[at], &next = state[at + 1];
                    const double e =
                        group.element[at].inv_rest_length * dot(frame(s).d3, lane(next.position, 0) - lane(s.position, 0));
                    worst = {here, rod, k, present_modes[mode], e};
                }
            });
        });
    }
    return worst;
}

template <int W> std::string RodTiles<W>::text_of(const Tightest& t) const {
    char text[240];
    std::snprintf(
        text, sizeof text,
        "element %d: dt = %.4g s is %.3g of the limit %.4g s that its present strains leave (%s mode, dilatation e = %.4g)",
        t.element, watch_.dt, t.share, watch_.dt / t.share, t.mode, t.e);
    return name_of(t.rod) + text;
}

template <int W> std::string RodTiles<W>::near_limit() const {
    if (!near_) return {};
    const Tightest worst = tightest();
    return worst.share > StepWatch::near ? text_of(worst) : std::string();
}

template class RodTiles<1>;
template class RodTiles<2>;
template class RodTiles<4>;
template class RodTiles<8>;

} // namespace skein
