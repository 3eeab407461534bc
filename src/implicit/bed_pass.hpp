// A step of rods and bodies in contact: one linear solution for each, from where the drift has brought it. theory.md
// (123)-(125)
//   drift   x' = x + h v,  Q' and w' those of a free top;  all loads are evaluated there
//   row     (M/h^2 + C/h + K + T) s = F(x', v, Q', w')     K: of elasticity and loads,  T: of contacts and walls
//   then    x = x' + s,  v += s/h,  Q = R(t) Q',  w += t/h - (t x w)/2
// It is of first order. T has of each contact what one body feels alone; it stands for the reaction of the other one
// too. No correction is repeated, so that no bit depends on neighbours in lanes.
#pragma once

#include "core/rotation.hpp"
#include "immersion/fluid_drag_pass.hpp"
#include "implicit/bed_figures.hpp"
#include "implicit/contact_rows.hpp"
#include "implicit/evaluated_passes.hpp"
#include "implicit/load_slopes.hpp"
#include "implicit/row_terms.hpp"
#include "implicit/steps_together.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace skein {

template <class Law, int W>
class BedPass final : public TilePass<W>, public EvaluatesPasses<W>, public StepsTogether<W> {
    using P = Pack<W>;
    using V = Vec3<P>;
    using Room = typename StepsTogether<W>::Room;

public:
    explicit BedPass(const BedParts<W>& parts)
        : terms_(parts.rod.group, parts.rod.rates, parts.rod.shares), walls_(parts.rod.walls),
          elastic_(ends_of(parts.rod.group), *walls_), exposure_(parts.exposure), loads_(parts.loads),
          wall_tangents_(parts.tangents), figures_(parts.figures), audit_(parts.rod.audit),
          strained_(parts.rod.group.strained()), closed_(parts.rod.group.closed()) {
        apart_ = 1e-7 * (strained_ ? parts.rod.group.element.front().rest_length : terms_.length());
    }

    void take(std::vector<EvaluatedPass<W>> passes) override {
        passes_ = std::move(passes);
        for (const EvaluatedPass<W>& one : passes_)
            if (one.has_slopes) with_slopes_.push_back(one.pass.get());
            else fluid_ = dynamic_cast<const FluidDragPass<W>*>(one.pass.get());
    }
    std::span<const EvaluatedPass<W>> evaluated() const override { return passes_; }
    void expect(std::size_t tiles) override {
        for (const EvaluatedPass<W>& one : passes_) one.pass->expect(tiles);
    }
    void bind(const RodTile<W>& rod) override {
        if (strained_) walls_->bind(rod);
        figures_->add_tile(rod.number);
        for (const EvaluatedPass<W>& one : passes_) one.pass->bind(rod);
    }
    void prepare(std::span<const Step> steps) override {
        for (const EvaluatedPass<W>& one : passes_) one.pass->prepare(steps);
    }
    void append_memory(const RodTile<W>& rod, int lane, std::vector<double>& numbers) const override {
        for (const EvaluatedPass<W>& one : passes_) one.pass->append_memory(rod, lane, numbers);
        numbers.push_back((*figures_)[rod.number].loss[lane]);
    }
    std::size_t restore(const RodTile<W>& rod, int lane, std::span<const double> numbers) override {
        std::size_t taken = 0;
        for (const EvaluatedPass<W>& one : passes_) taken += one.pass->restore(rod, lane, numbers.subspan(taken));
        (*figures_)[rod.number].loss.set(lane, numbers[taken]);
        return taken + 1;
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        static thread_local Work work;
        begin(rod, work);
        work.rows.begin(last(rod), closed_);
        add_rows_to(work.rows, rod, load, step, work);
        work.rows.solve(work.correction.data());
        terms_.turn_back(rod, last(rod), work.correction.data());
        move(rod, work, step.kick);
        if (fluid_) book_fluid(rod, work, step);
    }

    // With others of a cluster
    bool corrects() const override { return false; }
    std::unique_ptr<Room> make_room() const override { return std::make_unique<RoomOf>(); }
    void begin_step(const RodTile<W>& rod, const Step&, Room& room) const override { begin(rod, work_in(room)); }
    void add_rows(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Room& room, int,
                  RowsOfTile<W>& rows) const override {
        add_rows_to(rows, rod, load, step, work_in(room));
    }
    const RowTerms<W>& terms() const override { return terms_; }
    bool turns_about_lab() const override { return false; }
    P take_correction(const RodTile<W>& rod, const ClusterRows<W>& rows, std::size_t first, Room& room) const override {
        Work& work = work_in(room);
        for (int k = 0; k <= last(rod); ++k) work.correction[to_index(k)] = rows.solution(first + to_index(k));
        terms_.turn_back(rod, last(rod), work.correction.data());
        return P(0.0);
    }
    void move_by(const RodTile<W>&, const Step&, const P&, Room&) const override {}
    void end_step(const RodTile<W>& rod, SlotLoad<W>*, const Step& step, const P&, Room& room) const override {
        move(rod, work_in(room), step.kick);
        if (fluid_) book_fluid(rod, work_in(room), step);
    }
    V arm(const RodTile<W>& body, const Vec3d& arm, const Room&) const override {
        return transpose_times(body.slot[0].director, broadcast<W>(arm));
    }
    void follow(const RodTile<W>&, int, const Vec3<P>&, const Vec3<P>&, const Mask<W>&, Room&) const override {}
    double apart() const override { return apart_; }
    int last_row(const RodTile<W>& rod) const override { return last(rod); }

private:
    struct Work {
        AlignedVector<V> strain;
        AlignedVector<RowVector<W>> correction;
        AlignedVector<SlotLoad<W>> before, moved;
        BlockRows<W> rows;
        LoadSlopes<W> slopes;
    };
    struct RoomOf final : Room {
        Work work;
    };
    static Work& work_in(Room& room) { return static_cast<RoomOf&>(room).work; }

    int last(const RodTile<W>& rod) const { return closed_ ? rod.n - 1 : rod.last; }

    void begin(const RodTile<W>& rod, Work& work) const {
        const std::size_t slots = to_index(rod.last) + 1;
        if (work.correction.size() < slots) {
            work.correction.resize(slots);
            work.strain.resize(slots);
            work.before.resize(slots);
            work.moved.resize(slots);
        }
        for (int k = 0; strained_ && k < rod.n; ++k) work.strain[to_index(k)] = element_strain<Across<W>>(rod, k);
    }
    template <class Rows>
    void add_rows_to(Rows& rows, const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Work& work) const {
        if (fluid_) fluid_->run(rod, load, step);
        add_loads(rod, work, load, step);
        typename BedTiles<W>::Tile& figures = (*figures_)[rod.number];
        figures.added = P(0.0);
        if (strained_) add_rods(rows, rod, work, load, step, figures);
        else add_bodies(rows, rod, work, load, step, figures);
    }

    /// Adds loads that depend on the motion, and finds their slopes.
    void add_loads(const RodTile<W>& rod, Work& work, SlotLoad<W>* load, const Step& step) const {
        if (with_slopes_.empty()) return;
        std::copy_n(load, rod.last + 1, work.before.data());
        for (const TilePass<W>* pass : with_slopes_) pass->run(rod, load, step);
        if (audit_) book(rod, work, load);
        work.slopes.compute(rod, with_slopes_, work.before.data(), load, work.moved.data(), step, step.kick, apart_);
    }

    /// Adds these loads to all of an audit, which were noted before them.
    void book(const RodTile<W>& rod, const Work& work, const SlotLoad<W>* load) const {
        auto& all = audit_->tiles[rod.number].all;
        for (int k = 0; k <= rod.last; ++k) {
            const std::size_t at = to_index(k);
            all[at].force += load[k].force - work.before[at].force;
            all[at].couple += load[k].couple - work.before[at].couple;
        }
    }

    /// Books the impulses of the fluid at the rates of the end, and to an audit its loads.
    void book_fluid(const RodTile<W>& rod, Work& work, const Step& step) const {
        fluid_->book(rod, step.kick);
        if (!audit_) return;
        std::fill_n(work.moved.begin(), rod.last + 1, SlotLoad<W>{});
        fluid_->run(rod, work.moved.data(), step);
        auto& tile = audit_->tiles[rod.number];
        for (int k = 0; k <= rod.last; ++k) {
            const std::size_t at = to_index(k);
            tile.medium[at] = work.moved[at];
            for (auto* loads : {&tile.all, &tile.inner}) {
                (*loads)[at].force += work.moved[at].force;
                (*loads)[at].couple += work.moved[at].couple;
            }
        }
    }

    template <class Rows> void add_rods(Rows& rows, const RodTile<W>& rod, Work& work, const SlotLoad<W>* load,
                                        const Step& step, typename BedTiles<W>::Tile& figures) const {
        const TangentsOfLanes<W> contacts(exposure_.get(), loads_.get(), rod);
        auto* walls = wall_tangents_ ? &(*wall_tangents_)[rod.number] : nullptr;
        const bool touches = contacts.any() || (walls && walls->touches);
        const double h = step.kick;
        const auto tangent = [&](int k) {
            TangentLanes<W> sum;
            if (walls && walls->touches) sum = walls->element[to_index(k)];
            if (contacts.any()) contacts.add(to_index(k), sum);
            figures.added += P(h * h / 3) * mean_of(sum);
            return ElementTangent<W>(sum, rod.slot[k].director);
        };
        ElementTangent<W> before;
        if (touches && closed_) {
            const P counted = figures.added;
            before = tangent(rod.n - 1);
            figures.added = counted;
        }
        P strained(0.0);
        elastic_.stiffness(rod, work.strain.data(), step, last(rod), [&](int k, BlockRow<W>& row) {
            strained += by_rates(rod, k, last(rod), row);
            if (!with_slopes_.empty()) work.slopes.subtract_from(k, row);
            if (touches) {
                before.add_to_next(row);
                before = k < rod.n ? tangent(k) : ElementTangent<W>();
                before.add_to_own(row);
            }
            take(rows, rod, load[k], k, h, row);
        });
        figures.loss = fma(P(0.5 * h * h), strained, figures.loss);
    }

    template <class Rows> void add_bodies(Rows& rows, const RodTile<W>& rod, Work& work, const SlotLoad<W>* load,
                                          const Step& step, typename BedTiles<W>::Tile& figures) const {
        const TangentsOfLanes<W> contacts(exposure_.get(), loads_.get(), rod);
        BlockRow<W> row;
        RowBlock<W> lab;
        row.clear();
        clear<W>(lab);
        if (!with_slopes_.empty()) work.slopes.subtract_from(0, row);
        if (contacts.any()) add_surface_tangents<W>(contacts, *rod.group->body(), rod.slot[0].director, lab);
        if (wall_tangents_)
            if (const auto& walls = (*wall_tangents_)[rod.number]; walls.touches)
                for (int i = 0; i < row_size; ++i)
                    for (int j = 0; j < row_size; ++j) lab[i][j] += walls.body[i][j];
        figures.added = P(step.kick * step.kick / 3) * (lab[0][0] + lab[1][1] + lab[2][2]);
        add_lab_tangent<W>(lab, rod.slot[0].director, row.diagonal);
        take(rows, rod, load[0], 0, step.kick, row);
    }

    /// Trace of an element's slopes by displacement.
    static P mean_of(const TangentLanes<W>& t) {
        const auto trace = [](const P(&m)[6]) { return m[0] + m[3] + m[5]; };
        return trace(t.first) + P(2.0) * trace(t.across) + trace(t.second);
    }

    /// Takes a row with inertia, damping and loads, and what is held.
    template <class Rows>
    void take(Rows& rows, const RodTile<W>& rod, const SlotLoad<W>& load, int k, double h, BlockRow<W>& row) const {
        const Slot<W>& s = rod.slot[k];
        if (fluid_) {
            const auto drags = fluid_->drags(rod, k);
            RowTerms<W>::add_drags(rod, k, h, drags.node, drags.element, false, row);
        }
        terms_.add_node(k, h, load.force, s.velocity, V{P(0.0), P(0.0), P(0.0)}, row);
        if (k < rod.n) terms_.add_element(k, h, load, s.spin, scale(broadcast<W>(terms_[k].inertia), s.spin), row);
        else
            for (int i = 3; i < row_size; ++i) row.right[i] = P(0.0);
        terms_.hold(rod, k, last(rod), row);
        rows.add(k, row);
    }

    /// Moves on by the correction. The energy that a step takes from the motion is that of the change of rates.
    void move(const RodTile<W>& rod, const Work& work, double h) const {
        typename BedTiles<W>::Tile& figures = (*figures_)[rod.number];
        const P rate(1 / h), half(0.5);
        P lost(0.0), fastest(0.0);
        for (int k = 0; k <= last(rod); ++k) {
            const P* u = work.correction[to_index(k)].u;
            Slot<W>& s = rod.slot[k];
            const V shift{u[0], u[1], u[2]}, gained = rate * shift;
            s.position += shift;
            s.velocity += gained;
            lost = fma(P(terms_[k].mass), dot(gained, gained), lost);
            if (strained_) fastest = max(fastest, norm(s.velocity));
            if (k >= rod.n || !terms_.turns(k)) continue;
            const V turn{u[3], u[4], u[5]}, spun = fma(rate, turn, -(half * cross(turn, s.spin)));
            s.director = rotation(turn) * s.director;
            s.spin += spun;
            lost += dot(scale(broadcast<W>(terms_[k].inertia), spun), spun);
            if (!strained_) fastest = norm(s.velocity) + P(terms_.length()) * norm(s.spin); // of its surface
        }
        close_ring(rod);
        figures.loss = fma(half, lost, figures.loss);
        figures.fastest = 0;
        for (int l = 0; l < rod.lanes; ++l) figures.fastest = std::max(figures.fastest, fastest[l]);
    }

    RowTerms<W> terms_;
    std::shared_ptr<EndWalls<W>> walls_;
    ElasticRows<Law, W> elastic_;
    std::shared_ptr<const Exposure> exposure_; ///< null where rods do not feel each other
    std::shared_ptr<const SlotLoads> loads_;
    std::shared_ptr<WallTangents<W>> wall_tangents_; ///< null where no wall acts
    std::shared_ptr<BedTiles<W>> figures_;
    std::shared_ptr<EnergyBudget<W>> audit_; ///< null where there is none
    bool strained_, closed_;
    double apart_; ///< m, for slopes
    std::vector<EvaluatedPass<W>> passes_;
    std::vector<const TilePass<W>*> with_slopes_; ///< of passes_
    const FluidDragPass<W>* fluid_ = nullptr;     ///< one of passes_; null without a fluid that rods feel
};

} // namespace skein
