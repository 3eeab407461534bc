// Common parts of the passes of implicit steps: the loads that they evaluate, the strains that they remember, and the
// loop of corrections. Each lane counts its own corrections and stays as it is once they end, so that no bit depends on
// its neighbours. What does not converge becomes NaN, which the run reports.
#pragma once

#include "immersion/fluid_drag_pass.hpp"
#include "implicit/block_rows.hpp"
#include "implicit/corrections.hpp"
#include "implicit/evaluated_passes.hpp"
#include "implicit/row_terms.hpp"
#include "implicit/step_audit.hpp"
#include "implicit/steps_together.hpp"
#include "implicit/wall_rows.hpp"
#include "mechanics/elastic.hpp"
#include "skein/core/aligned.hpp"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace skein {

/// Pass: a class with Work; begin(rod, work, step), add_rows_to(rows, rod, load, step, work, number),
/// move(rod, work, share) and go_on(rod, work, step, wrong).
template <class Pass, int W>
class CorrectedPass : public TilePass<W>, public EvaluatesPasses<W>, public StepsTogether<W> {
protected:
    using P = Pack<W>;
    using V = Vec3<P>;

public:
    using Room = typename StepsTogether<W>::Room;

    explicit CorrectedPass(const ImplicitParts<W>& parts)
        : terms_(parts.group, parts.rates, parts.shares), strained_(parts.group.strained()),
          closed_(parts.group.closed()),
          apart_(1e-7 * (strained_ ? parts.group.element.front().rest_length : terms_.length())),
          audit_(parts.audit, parts.walls->moving()) {}

    void take(std::vector<EvaluatedPass<W>> passes) override {
        passes_ = std::move(passes);
        std::stable_partition(passes_.begin(), passes_.end(), [](const auto& one) { return !one.has_slopes; });
        for (const EvaluatedPass<W>& one : passes_)
            if (auto* walls = dynamic_cast<ImplicitWalls<W>*>(one.pass.get())) touching_ = walls;
            else (one.has_slopes ? with_slopes_ : constant_).push_back(one.pass.get());
        for (const EvaluatedPass<W>& one : passes_)
            if (const auto* fluid = dynamic_cast<const FluidDragPass<W>*>(one.pass.get())) fluid_ = fluid;
        const auto adds = [](const TilePass<W>* pass) { return pass->adds_loads(); };
        sloped_ = std::any_of(with_slopes_.begin(), with_slopes_.end(), adds);
    }

    std::span<const EvaluatedPass<W>> evaluated() const override { return passes_; }
    void keep(std::size_t place) override {
        if (touching_) touching_->keep(place);
    }
    void go_back(std::size_t place) override {
        if (touching_) touching_->go_back(place);
    }
    void expect(std::size_t tiles) override {
        strains_.resize(tiles);
        put_off_.resize(tiles);
        for (const EvaluatedPass<W>& one : passes_) one.pass->expect(tiles);
    }
    void bind(const RodTile<W>& rod) override {
        if (rod.number >= put_off_.size()) put_off_.resize(rod.number + 1);
        if (strained_) {
            bind_walls(rod);
            if (rod.number >= strains_.size()) strains_.resize(rod.number + 1);
            strains_[rod.number].assign(to_index(rod.n), V{P(0.0), P(0.0), P(0.0)});
        }
        for (const EvaluatedPass<W>& one : passes_) one.pass->bind(rod);
        audit_.bind(rod);
    }
    void prepare(std::span<const Step> steps) override {
        for (const EvaluatedPass<W>& one : passes_) one.pass->prepare(steps);
    }
    void append_memory(const RodTile<W>& rod, int lane, std::vector<double>& numbers) const override {
        for (const EvaluatedPass<W>& one : passes_) one.pass->append_memory(rod, lane, numbers);
        if (!strained_) return;
        for (const V& s : strains_[rod.number]) {
            const Vec3d one = skein::lane(s, lane);
            numbers.insert(numbers.end(), {one.x, one.y, one.z});
        }
    }
    std::size_t restore(const RodTile<W>& rod, int lane, std::span<const double> numbers) override {
        std::size_t taken = 0;
        for (const EvaluatedPass<W>& one : passes_) taken += one.pass->restore(rod, lane, numbers.subspan(taken));
        if (!strained_) return taken;
        for (V& s : strains_[rod.number]) {
            set_lane(s, lane, {numbers[taken], numbers[taken + 1], numbers[taken + 2]});
            taken += 3;
        }
        return taken;
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        static thread_local typename Pass::Work work;
        const Pass& pass = own();
        if (audit_) audit_.begin(rod, terms_);
        pass.begin(rod, work, step);
        Corrections<W> corrections;
        while (corrections.goes_on()) {
            work.rows.begin(last(rod), closed_);
            pass.add_rows_to(work.rows, rod, load, step, work, corrections.number());
            work.rows.solve(work.correction.data());
            terms_.turn_back(rod, last(rod), work.correction.data());
            const P size = size_of(rod, work.correction.data());
            pass.move(rod, work, corrections.share(size));
            corrections.note(size);
        }
        put_off(rod, step, begins_to_touch(rod));
        finish(rod, load, work, step, corrections.wrong());
    }

    // With others of a cluster
    std::unique_ptr<Room> make_room() const override { return std::make_unique<RoomOf>(); }
    void begin_step(const RodTile<W>& rod, const Step& step, Room& room) const override {
        if (audit_) audit_.begin(rod, terms_);
        own().begin(rod, work_in(room), step);
    }
    void add_rows(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Room& room, int number,
                  RowsOfTile<W>& rows) const override {
        own().add_rows_to(rows, rod, load, step, work_in(room), number);
    }
    const RowTerms<W>& terms() const override { return terms_; }
    P take_correction(const RodTile<W>& rod, const ClusterRows<W>& rows, std::size_t first, Room& room) const override {
        auto& work = work_in(room);
        for (int k = 0; k <= last(rod); ++k) work.correction[to_index(k)] = rows.solution(first + to_index(k));
        terms_.turn_back(rod, last(rod), work.correction.data());
        return size_of(rod, work.correction.data());
    }
    void move_by(const RodTile<W>& rod, const Step&, const P& share, Room& room) const override {
        own().move(rod, work_in(room), share);
    }
    void end_step(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, const P& wrong,
                  Room& room) const override {
        finish(rod, load, work_in(room), step, wrong);
    }
    P begins_to_touch(const RodTile<W>& rod) const override {
        return touching_ ? touching_->slopes(rod.number).begins : P(0.0);
    }
    void put_off(const RodTile<W>& rod, const Step& step, const P& where) const override {
        if (!touching_ || step.last_stage) return;
        put_off_[rod.number] = where * P(step.drift);
    }
    bool books() const override { return static_cast<bool>(audit_); }
    V arm(const RodTile<W>& body, const Vec3d& arm, const Room& room) const override {
        return own().arm_in(static_cast<const RoomOf&>(room).work, body.slot[0], broadcast<W>(arm));
    }
    void follow(const RodTile<W>& rod, int k, const Vec3<P>& position, const Vec3<P>& velocity, const Mask<W>& lanes,
                Room& room) const override {
        auto& work = work_in(room);
        Slot<W>& s = rod.slot[k];
        V& way = work.displacement[to_index(k)];
        way = select(lanes, position - work.start[to_index(k)].position, way);
        s.position = select(lanes, position, s.position);
        s.velocity = select(lanes, velocity, s.velocity);
    }
    double apart() const override { return apart_; }
    int last_row(const RodTile<W>& rod) const override { return last(rod); }

protected:
    virtual void bind_walls(const RodTile<W>& rod) = 0;

    /// Books the energies of a stage, with the loads at its end: corrections may have left those of before.
    template <class Work> void book(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Work& work) const {
        const Pass& pass = static_cast<const Pass&>(*this);
        const std::size_t slots = to_index(rod.last) + 1;
        pass.evaluate_all(rod, load, step, work);
        pass.inner_loads(rod, work.moved.data(), step, work);
        if (closed_) work.moved[0].force += work.moved[slots - 1].force; // as of all loads
        for (std::size_t k = 0; k < slots; ++k) {
            load[k].force -= work.moved[k].force;
            load[k].couple -= work.moved[k].couple;
            load[k].dilatation -= work.moved[k].dilatation;
        }
        const SlotLoad<W>* medium = nullptr;
        if (fluid_) {
            std::fill_n(work.inner.begin(), slots, SlotLoad<W>{});
            fluid_->run(rod, work.inner.data(), step);
            medium = work.inner.data();
        }
        pass.add_inner_couples(rod, work.moved.data(), work);
        const StageSpan<W> span = span_of(rod, step);
        const P time = span.to + span.on, lost = time * (span.to - P(0.5) * time);
        P strained(0.0);
        if (strained_ && step.kick != step.drift)
            pass.stiffness(rod, step, work,
                           [&](int k, BlockRow<W>& row) { strained += by_rates(rod, k, last(rod), row); });
        audit_.book(rod, terms_, load, work.moved.data(), medium, time, pass.wall_power(rod, step), strained, lost);
    }

    int last(const RodTile<W>& rod) const { return closed_ ? rod.n - 1 : rod.last; }

    /// Strain of element k that a step begins with: that of the step before, or `own` where there was none.
    V remembered(const RodTile<W>& rod, int k, const V& own) const {
        const V& known = strains_[rod.number][to_index(k)];
        const Mask<W> is_known = fma(known.x + known.y, P(0.0), known.z) > P(0.0); // and not NaN
        return select(is_known, known, own);
    }

    /// Times of the stage. Lanes that have put off what they would have gone on by have a longer last stage.
    StageSpan<W> span_of(const RodTile<W>& rod, const Step& step) const {
        StageSpan<W> span{P(step.kick), P(step.drift), step.kick == step.drift};
        if (!touching_ || span.between) return span;
        const P& off = put_off_[rod.number];
        if (step.first_stage) span.on -= off;
        else span.to += off;
        return span;
    }

    /// Adds the slopes of the fluid's loads over the time h to row k.
    void add_drags(const RodTile<W>& rod, int k, const P& h, bool in_lab, BlockRow<W>& row) const {
        if (!fluid_) return;
        const auto drags = fluid_->drags(rod, k);
        RowTerms<W>::add_drags(rod, k, h, drags.node, drags.element, in_lab, row);
    }

    /// Takes the slopes of the loads of walls from row k.
    void take_walls(const RodTile<W>& rod, int k, bool in_lab, BlockRow<W>& row) const {
        if (touching_) WallRows<W>(touching_->slopes(rod.number), rod, in_lab).subtract_from(k, row);
    }

    /// Adds the loads of other passes. `start`: slots where the stage begins; `inner`: internal loads, and then those
    /// whose slopes differences do not find.
    void evaluate(const RodTile<W>& rod, const Slot<W>* start, SlotLoad<W>* inner, SlotLoad<W>* load,
                  const Step& step) const {
        for (const TilePass<W>* pass : constant_) pass->run(rod, inner, step);
        if (touching_) touching_->try_state(rod, start, inner, step, span_of(rod, step));
        std::copy_n(inner, rod.last + 1, load);
        for (const TilePass<W>* pass : with_slopes_) pass->run(rod, load, step);
    }

    RowTerms<W> terms_;
    bool strained_, closed_;
    double apart_; ///< m, for slopes
    StepAudit<W> audit_;
    std::vector<const TilePass<W>*> constant_, with_slopes_; ///< in the order of passes_
    bool sloped_ = false;                                    ///< false where with_slopes_ only moves loads

private:
    struct RoomOf final : Room {
        typename Pass::Work work;
    };
    static auto& work_in(Room& room) { return static_cast<RoomOf&>(room).work; }
    const Pass& own() const { return static_cast<const Pass&>(*this); }
    template <class Work>
    void finish(const RodTile<W>& rod, SlotLoad<W>* load, Work& work, const Step& step, const P& wrong) const {
        if (strained_) std::copy_n(work.carried.data(), rod.n, strains_[rod.number].data());
        const StageSpan<W> span = span_of(rod, step);
        if (fluid_) fluid_->book(rod, span.to + span.on);
        if (audit_) book(rod, load, step, work);
        if (touching_) touching_->end_stage(rod, work.start.data(), step, span);
        own().go_on(rod, work, step, wrong);
        if (audit_) audit_.end(rod, terms_);
    }

    /// Largest displacement over the length, or turn, of a correction.
    P size_of(const RodTile<W>& rod, const RowVector<W>* correction) const {
        P most(0.0), zero(0.0);
        for (int k = 0; k <= last(rod); ++k) {
            const P* u = correction[k].u;
            most = max(most, P(1 / terms_.length()) * max(abs(u[0]), max(abs(u[1]), abs(u[2]))));
            most = max(most, max(abs(u[3]), max(abs(u[4]), abs(u[5]))));
            zero = fma(u[0] + u[1] + u[2] + u[3] + u[4] + u[5], P(0.0), zero);
        }
        return most + zero;
    }

    std::vector<EvaluatedPass<W>> passes_;
    ImplicitWalls<W>* touching_ = nullptr;          ///< one of passes_; null where no wall acts
    const FluidDragPass<W>* fluid_ = nullptr;       ///< one of passes_; null without a fluid that rods feel
    mutable AlignedVector<P> put_off_;              ///< by tile: time by which the first stage has not gone on, s
    mutable std::vector<AlignedVector<V>> strains_; ///< by tile: of the last step; 0 where there was none
};

} // namespace skein
