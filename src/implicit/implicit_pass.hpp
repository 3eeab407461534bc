// An implicit step of rods and bodies by Newton corrections: each by itself, or with those that joints couple.
// theory.md (113)-(115)
//   stage     from (x, v, Q, w) over a time h:   x' = x + h v',  Q' = R(h w') Q
//             m (v' - v) = h f',   Q'^T J w' - Q^T J w = h Q'^T c'        loads at the stage's end and time
//   goes on   by a time b at the same rates: x' + b v',  R(b w') Q',  and momenta by b/h of their change
// Two stages of g = 1 - 1/sqrt 2, of which the first goes on by 1 - 2 g, are a diagonally implicit Runge-Kutta step of
// second order that damps what it does not resolve. (A stage of half a dt which goes on by the other half would be the
// midpoint rule, which does not keep the energy of large motion; conserving_pass.hpp does.)
#pragma once

#include "implicit/corrected_pass.hpp"
#include "implicit/elastic_rows.hpp"
#include "implicit/load_slopes.hpp"
#include "mechanics/drift.hpp"

#include <memory>

namespace skein {

template <class Law, int W> class ImplicitPass final : public CorrectedPass<ImplicitPass<Law, W>, W> {
public:
    explicit ImplicitPass(const ImplicitParts<W>& parts)
        : Base(parts), walls_(parts.walls), elastic_(ends_of(parts.group), *walls_),
          by_walls_(ends_of(parts.group), walls_) {}

private:
    using Base = CorrectedPass<ImplicitPass, W>;
    friend Base;
    using Base::apart_, Base::closed_, Base::last, Base::sloped_, Base::strained_, Base::terms_, Base::with_slopes_;

    using P = Pack<W>;
    using V = Vec3<P>;
    using Q = Quaternion<P>;

    /// Numbers of a stage, by slot.
    struct Work {
        P h; ///< time of the stage, s
        AlignedVector<Slot<W>> start;
        AlignedVector<V> displacement, carried;
        AlignedVector<Q> turn;
        AlignedVector<RowVector<W>> correction;
        AlignedVector<SlotLoad<W>> inner, moved;
        BlockRows<W> rows;
        LoadSlopes<W> slopes;
    };

    void bind_walls(const RodTile<W>& rod) override {
        walls_->bind(rod);
        by_walls_.bind(rod);
    }
    bool turns_about_lab() const override { return false; }
    static V arm_in(const Work&, const Slot<W>& body, const V& arm) { return transpose_times(body.director, arm); }

    /// First guess: the stage's end at the present rates, with the strains of the stage before. Those of its end would
    /// not do: the rates stretch what turns.
    void begin(const RodTile<W>& rod, Work& work, const Step& step) const {
        if (step.first_stage) this->put_off(rod, step, P(0.0));
        const P h = this->span_of(rod, step).to;
        work.h = h;
        const std::size_t slots = to_index(rod.last) + 1;
        work.start.assign(rod.slot, rod.slot + slots);
        for (auto* vectors : {&work.displacement, &work.carried})
            if (vectors->size() < slots) vectors->resize(slots);
        if (work.turn.size() < slots) {
            work.turn.resize(slots);
            work.correction.resize(slots);
            work.inner.resize(slots);
            work.moved.resize(slots);
        }
        if (strained_)
            for (int k = 0; k < rod.n; ++k)
                work.carried[to_index(k)] = this->remembered(rod, k, element_strain<Across<W>>(rod, k));
        for (int k = 0; k <= last(rod); ++k) {
            Slot<W>& s = rod.slot[k];
            V& d = work.displacement[to_index(k)];
            d = scale(terms_.free_node(k), h * s.velocity);
            s.position = work.start[to_index(k)].position + d;
            if (k >= rod.n) continue;
            Q& r = work.turn[to_index(k)];
            r = terms_.turns(k) ? rotation(as_held(k, work.start[to_index(k)].director, h * s.spin))
                                : broadcast<W>(no_turn);
            s.director = r * work.start[to_index(k)].director;
        }
        close_ring(rod);
    }

    void evaluate_all(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Work& work) const {
        inner_loads(rod, work.inner.data(), step, work);
        this->evaluate(rod, work.start.data(), work.inner.data(), load, step);
    }
    void inner_loads(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Work& work) const {
        if (strained_) elastic_.loads(rod, work.carried.data(), step, load);
        else load[0] = {{}, {}, P(1.0)};
    }
    void add_inner_couples(const RodTile<W>&, SlotLoad<W>*, const Work&) const {} // they are there
    template <class Take> void stiffness(const RodTile<W>& rod, const Step& step, Work& work, Take&& take) const {
        elastic_.stiffness(rod, work.carried.data(), step, last(rod), take);
    }
    /// Power of the couples of walls that turn, W.
    P wall_power(const RodTile<W>& rod, const Step& step) const {
        return strained_ && walls_->moving() ? power_of_walls(by_walls_, *walls_, rod, step) : P(0.0);
    }

    /// Loads at the present state of the stage, and the rows of the correction that would balance them.
    template <class Rows> void add_rows_to(Rows& rows, const RodTile<W>& rod, SlotLoad<W>* load, const Step& step,
                                           Work& work, int number) const {
        evaluate_all(rod, load, step, work);
        if (sloped_ && number % 3 == 0)
            work.slopes.compute(rod, with_slopes_, work.inner.data(), load, work.moved.data(), step, work.h, apart_);
        const auto take = [&](int k, BlockRow<W>& row) {
            if (sloped_) work.slopes.subtract_from(k, row);
            this->add_drags(rod, k, work.h, false, row);
            this->take_walls(rod, k, false, row);
            add_inertia(rod, work, load[k], k, work.h, row);
            terms_.hold(rod, k, last(rod), row);
            hold_turn(rod, k, work.h, row);
            rows.add(k, row);
        };
        if (strained_) {
            stiffness(rod, step, work, take);
        } else {
            BlockRow<W> row;
            row.clear();
            take(0, row);
        }
    }

    /// Part of a turn of a stage, from the frame q on, that its bearing leaves.
    V as_held(int k, const Q& q, const V& turn) const {
        if (!terms_[k].turns_in_lab) return turn;
        const auto& free = terms_[k].free;
        return q * scale(V{P(free[3]), P(free[4]), P(free[5])}, transpose_times(q, turn));
    }

    /// A turn u about directions across a held axis e has u.Q e = 0, so corrections t have t.R(u/2) Q e = 0 at its end,
    /// up to u^2 t.
    void hold_turn(const RodTile<W>& rod, int k, const P& h, BlockRow<W>& row) const {
        const int axis = terms_[k].only_held_axis();
        if (axis < 0) return;
        const Slot<W>& s = rod.slot[k];
        const V e{P(axis == 3 ? 1.0 : 0.0), P(axis == 4 ? 1.0 : 0.0), P(axis == 5 ? 1.0 : 0.0)};
        const V middle = transpose_times(s.director, rotation((P(-0.5) * h) * s.spin) * (s.director * e));
        row.diagonal[axis][3] = middle.x;
        row.diagonal[axis][4] = middle.y;
        row.diagonal[axis][5] = middle.z;
    }

    /// Adds inertia and damping over h, and all loads on the right.
    void add_inertia(const RodTile<W>& rod, const Work& work, const SlotLoad<W>& load, int k, const P& h,
                     BlockRow<W>& row) const {
        const Slot<W>&s = rod.slot[k], &start = work.start[to_index(k)];
        terms_.add_node(k, h, load.force, s.velocity, s.velocity - start.velocity, row);
        if (k >= rod.n) {
            for (int i = 3; i < row_size; ++i) row.right[i] = P(0.0);
            return;
        }
        const V before = work.turn[to_index(k)] * scale(broadcast<W>(terms_[k].inertia), start.spin);
        terms_.add_element(k, h, load, s.spin, before, row);
    }

    /// Takes a share of the correction.
    void move(const RodTile<W>& rod, Work& work, const P& share) const {
        const auto of = [&](int k) {
            const P* u = work.correction[to_index(k)].u;
            return V{share * u[0], share * u[1], share * u[2]};
        };
        const auto turn_of = [&](int k) {
            const P* u = work.correction[to_index(k)].u;
            return V{share * u[3], share * u[4], share * u[5]};
        };
        const Mask<W> moves = share > P(0.0);
        const P over = P(1.0) / work.h;
        if (strained_)
            for (int k = 0; k < rod.n; ++k) {
                const int next = closed_ && k == rod.n - 1 ? 0 : k + 1;
                V& s = work.carried[to_index(k)];
                const V nu = element_strain<Across<W>>(rod, k);
                // s + share (nu - s) + share (d nu)
                const V followed =
                    ElasticRows<Law, W>::followed(rod, k, fma(share, nu - s, s), of(next) - of(k), turn_of(k));
                s = select(moves, followed, s);
            }
        for (int k = 0; k <= last(rod); ++k) {
            Slot<W>& s = rod.slot[k];
            const Slot<W>& start = work.start[to_index(k)];
            V& d = work.displacement[to_index(k)];
            d += of(k);
            s.position = start.position + d;
            const V free = terms_.free_node(k);
            s.velocity = fma(over, d, scale(V{P(1.0) - free.x, P(1.0) - free.y, P(1.0) - free.z}, start.velocity));
            if (k >= rod.n || !terms_.turns(k)) continue;
            Q& r = work.turn[to_index(k)];
            r = rotation(turn_of(k)) * r;
            const auto turned = [&] { return as_held(k, start.director, relative_rotation(r, broadcast<W>(no_turn))); };
            if (terms_[k].turns_in_lab) r = select(moves, rotation(turned()), r);
            s.director = r * start.director;
            s.spin = over * turned();
        }
        close_ring(rod);
    }

    /// Goes on at the stage's rates. `wrong`: NaN where it has not converged.
    void go_on(const RodTile<W>& rod, Work& work, const Step& step, const P& wrong) const {
        const StageSpan<W> span = this->span_of(rod, step);
        const P b = span.on, ratio = span.on / span.to, more = P(1.0) + ratio;
        for (int k = 0; k <= last(rod); ++k) {
            Slot<W>& s = rod.slot[k];
            const Slot<W>& start = work.start[to_index(k)];
            s.position = fma(b, s.velocity, s.position);
            s.position.x += wrong;
            s.velocity = fma(ratio, s.velocity - start.velocity, s.velocity);
            if (k >= rod.n) continue;
            if (!terms_.turns(k)) { // with its wall
                s.director = rotation(b * s.spin) * s.director;
                continue;
            }
            const V j = broadcast<W>(terms_[k].inertia),
                    inv{P(1 / terms_[k].inertia.x), P(1 / terms_[k].inertia.y), P(1 / terms_[k].inertia.z)};
            const V now = scale(j, s.spin), before = work.turn[to_index(k)] * scale(j, start.spin);
            const Q r = rotation(b * s.spin);
            s.director = r * s.director;
            s.spin = scale(inv, r * (more * now - ratio * before));
        }
        close_ring(rod);
    }

    std::shared_ptr<EndWalls<W>> walls_;
    ElasticRows<Law, W> elastic_;
    ElasticPass<Law, W> by_walls_; ///< for the power of walls
};

} // namespace skein
