// An implicit step of rods and bodies that keeps their energy and momenta, by Newton corrections. theory.md (119)-(122)
//   step      from (x0, v0, Q0, w0) over 2 h to (x1, v1, Q1, w1)
//             x1 - x0 = h (v0 + v1),   Q1 = C(a) Q0,   a = h (w0 + w1)
//             m (v1 - v0) = 2 h f,     Q1^T J w1 - Q0^T J w0 = 2 h C          in the lab
// Internal loads f, C do the work by which the energy changes (conserving_rows.hpp). Other loads are those of the mean
// place, the frame between both, the mean rates and the middle time. The step is symmetric and of second order.
#pragma once

#include "implicit/conserving_rows.hpp"
#include "implicit/corrected_pass.hpp"
#include "implicit/load_slopes.hpp"
#include "mechanics/drift.hpp"

#include <memory>

namespace skein {

template <class Law, int W> class ConservingPass final : public CorrectedPass<ConservingPass<Law, W>, W> {
public:
    explicit ConservingPass(const ImplicitParts<W>& parts)
        : Base(parts), walls_(parts.group, parts.walls), elastic_(ends_of(parts.group), walls_), at_mean_(parts.walls),
          by_walls_(ends_of(parts.group), parts.walls) {}

    void prepare(std::span<const Step> steps) override {
        walls_.prepare(steps);
        Base::prepare(steps);
    }

private:
    using Base = CorrectedPass<ConservingPass, W>;
    friend Base;
    using Base::apart_, Base::closed_, Base::last, Base::sloped_, Base::strained_, Base::terms_, Base::with_slopes_;

    using P = Pack<W>;
    using V = Vec3<P>;
    using Q = Quaternion<P>;
    using Rows = ConservingRows<Law, W>;

    /// Numbers of a step, by slot.
    struct Work {
        double h; ///< half of the step, s
        AlignedVector<Slot<W>> start;
        AlignedVector<V> displacement;     ///< from the start to the mean
        AlignedVector<V> carried;          ///< mean strains
        AlignedVector<V> momentum, couple; ///< angular momentum at the start; internal couple; lab
        AlignedVector<Q> turn, director;   ///< from the start to the end; at the end
        AlignedVector<RowVector<W>> correction;
        AlignedVector<SlotLoad<W>> inner, moved;
        typename Rows::Work elastic;
        BlockRows<W> rows;
        LoadSlopes<W> slopes{true};

        void make_room(std::size_t slots) {
            if (turn.size() >= slots) return;
            for (auto* vectors : {&displacement, &carried, &momentum, &couple}) vectors->resize(slots);
            for (auto* turns : {&turn, &director}) turns->resize(slots);
            correction.resize(slots);
            inner.resize(slots);
            moved.resize(slots);
        }
    };

    void bind_walls(const RodTile<W>& rod) override {
        walls_.bind(rod);
        by_walls_.bind(rod);
    }
    bool turns_about_lab() const override { return true; }
    /// Mean of both ends, whose change is that of the place.
    static V arm_in(const Work& work, const Slot<W>&, const V& arm) {
        return P(0.5) * (transpose_times(work.start[0].director, arm) + transpose_times(work.director[0], arm));
    }

    /// First guess: the step at the present rates, with the mean strains of the step before.
    void begin(const RodTile<W>& rod, Work& work, const Step& step) const {
        const double h = step.kick;
        const std::size_t slots = to_index(rod.last) + 1;
        work.start.assign(rod.slot, rod.slot + slots);
        work.make_room(slots);
        work.h = h;
        for (int k = 0; k <= last(rod); ++k) {
            Slot<W>&s = rod.slot[k], &start = work.start[to_index(k)];
            const V free = terms_.free_node(k), moved = P(h) * s.velocity;
            // Held nodes are at the middle of the step, and move with their wall.
            start.position = s.position - scale(V{P(1.0) - free.x, P(1.0) - free.y, P(1.0) - free.z}, moved);
            work.displacement[to_index(k)] = moved;
            s.position = start.position + moved;
            if (k < rod.n) begin_turn(s, start, k, h, work);
        }
        close_ring(rod);
        if (!strained_) return;
        elastic_.begin(rod, work.start.data(), step, work.elastic);
        for (int k = 0; k < rod.n; ++k)
            work.carried[to_index(k)] = this->remembered(rod, k, work.elastic.element[to_index(k)].start_strain);
    }
    void begin_turn(Slot<W>& s, Slot<W>& start, int k, double h, Work& work) const {
        Q &turn = work.turn[to_index(k)], &end = work.director[to_index(k)];
        const V half = P(h) * s.spin;
        if (terms_.turns(k)) {
            const P w = P(1.0) / sqrt(fma(half.x, half.x, fma(half.y, half.y, fma(half.z, half.z, P(1.0)))));
            turn = {w, w * half};
            turn_to_mean(s, start, turn, h, end);
        } else { // with its wall
            const Q forth = rotation(half);
            start.director = rotation(-half) * s.director;
            turn = forth * forth;
            end = forth * s.director;
        }
        work.momentum[to_index(k)] =
            transpose_times(start.director, scale(broadcast<W>(terms_[k].inertia), start.spin));
    }
    /// Sets the frame at the end and that of the mean, with the mean spin a/(2 h).
    static void turn_to_mean(Slot<W>& s, const Slot<W>& start, const Q& turn, double h, Q& end) {
        end = turn * start.director;
        const P inverse = P(1.0) / sqrt(fma(P(2.0), turn.w, P(2.0)));
        s.director = {inverse * (start.director.w + end.w), inverse * (start.director.v + end.v)};
        s.spin = (P(1 / h) / turn.w) * turn.v;
    }

    void evaluate_all(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step, Work& work) const {
        inner_loads(rod, work.inner.data(), step, work);
        this->evaluate(rod, work.start.data(), work.inner.data(), load, step);
    }
    /// Without internal couples, which work.couple has.
    void inner_loads(const RodTile<W>& rod, SlotLoad<W>* load, const Step&, Work& work) const {
        if (strained_)
            elastic_.loads(rod, work.displacement.data(), work.director.data(), work.carried.data(), load,
                           work.couple.data(), work.elastic);
        else load[0] = {{}, {}, P(1.0)};
    }
    void add_inner_couples(const RodTile<W>& rod, SlotLoad<W>* load, const Work& work) const {
        for (int k = 0; strained_ && k < rod.n; ++k) load[k].couple += rod.slot[k].director * work.couple[to_index(k)];
    }
    template <class Take> void stiffness(const RodTile<W>& rod, const Step&, Work& work, Take&& take) const {
        elastic_.stiffness(rod, work.carried.data(), last(rod), work.elastic, take);
    }
    /// Power of the couples of walls that turn, W, at the mean state.
    P wall_power(const RodTile<W>& rod, const Step& step) const {
        return strained_ && at_mean_->moving() ? power_of_walls(by_walls_, *at_mean_, rod, step) : P(0.0);
    }

    /// Loads of the present guess, and the rows of the correction that would balance them.
    template <class To> void add_rows_to(To& rows, const RodTile<W>& rod, SlotLoad<W>* load, const Step& step,
                                         Work& work, int number) const {
        evaluate_all(rod, load, step, work);
        if (sloped_ && number % 3 == 0)
            work.slopes.compute(rod, with_slopes_, work.inner.data(), load, work.moved.data(), step, step.kick, apart_);
        const auto take = [&](int k, BlockRow<W>& row) {
            if (sloped_) work.slopes.subtract_from(k, row);
            this->add_drags(rod, k, step.kick, true, row);
            this->take_walls(rod, k, true, row);
            const V& mean = rod.slot[k].velocity;
            terms_.add_node(k, step.kick, load[k].force, mean, mean - work.start[to_index(k)].velocity, row);
            add_turn(rod, work, load, k, step.kick, row);
            for (int i = 0; i < row_size; ++i)
                if (terms_[k].free[to_index(i)] == 0) row.hold(i);
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

    /// Adds inertia and damping of an element, in the lab, by half its turn p at the end:
    ///   da = 2 (1 + [a]/2 + a a^T/4) p,   d(Q1^T J w1) = 2 (J da/(2 h) - [Q1^T J w1] p)
    void add_turn(const RodTile<W>& rod, const Work& work, const SlotLoad<W>* load, int k, double h,
                  BlockRow<W>& row) const {
        if (k >= rod.n) {
            for (int i = 3; i < row_size; ++i) row.right[i] = P(0.0);
            return;
        }
        const ImplicitRod::Row& c = terms_[k];
        const Slot<W>& s = rod.slot[k];
        const P inv(1 / h), half(0.5);
        const V j = broadcast<W>(c.inertia), start = work.start[to_index(k)].spin;
        const V rate = fma(load[k].dilatation, broadcast<W>(c.rate_by_stretch), broadcast<W>(c.rate));
        const Mat3<P> end = strained_ ? work.elastic.element[to_index(k)].end : matrix(work.director[to_index(k)]);
        const V momentum = transpose_times(end, scale(j, s.spin + (s.spin - start)));
        V all = transpose_times(s.director, load[k].couple - scale(rate, scale(j, s.spin)));
        if (strained_) all += work.couple[to_index(k)];
        all -= (half * inv) * (momentum - work.momentum[to_index(k)]);
        row.right[3] = all.x;
        row.right[4] = all.y;
        row.right[5] = all.z;
        const V by{fma(rate.x, inv, inv * inv), fma(rate.y, inv, inv * inv), fma(rate.z, inv, inv * inv)};
        const Mat3<P> stiff = transpose_product(end, scale(j, by), end);
        const V a = P(2 * h) * transpose_times(end, s.spin), gyration = inv * momentum;
        const auto put = [&](int i, const V& line, const V& turned) {
            const V of = fma(P(0.25) * dot(line, a), a, fma(half, cross(line, a), line)) - turned;
            row.diagonal[i][3] += of.x;
            row.diagonal[i][4] += of.y;
            row.diagonal[i][5] += of.z;
        };
        const P zero(0.0);
        put(3, stiff.d1, {zero, -gyration.z, gyration.y});
        put(4, stiff.d2, {gyration.z, zero, -gyration.x});
        put(5, stiff.d3, {-gyration.y, gyration.x, zero});
    }

    /// Takes a share of the correction.
    void move(const RodTile<W>& rod, Work& work, const P& share) const {
        const auto of = [&](int k, int i) {
            const P* u = work.correction[to_index(k)].u + i;
            return V{share * u[0], share * u[1], share * u[2]};
        };
        const Mask<W> moves = share > P(0.0);
        const double h = work.h;
        if (strained_)
            for (int k = 0; k < rod.n; ++k) {
                const int next = closed_ && k == rod.n - 1 ? 0 : k + 1;
                V& s = work.carried[to_index(k)];
                const V& nu = work.elastic.element[to_index(k)].strain;
                const V followed =
                    Rows::followed(rod, k, fma(share, nu - s, s), of(next, 0) - of(k, 0), of(k, 3), work.elastic);
                s = select(moves, followed, s);
            }
        for (int k = 0; k <= last(rod); ++k) {
            Slot<W>& s = rod.slot[k];
            const Slot<W>& start = work.start[to_index(k)];
            V& d = work.displacement[to_index(k)];
            d += of(k, 0);
            s.position = start.position + d;
            s.velocity = held_and_free(Vec3d{terms_[k].free[0], terms_[k].free[1], terms_[k].free[2]}, start.velocity,
                                       P(1 / h) * d);
            if (k >= rod.n || !terms_.turns(k)) continue;
            Q &turn = work.turn[to_index(k)], &end = work.director[to_index(k)];
            turn = rotation(end * (P(2.0) * of(k, 3))) * turn;
            turn_to_mean(s, start, turn, h, end);
        }
        close_ring(rod);
    }

    /// Goes on to the end. `wrong`: NaN where it has not converged.
    void go_on(const RodTile<W>& rod, Work& work, const Step& step, const P& wrong) const {
        for (int k = 0; k <= last(rod); ++k) {
            Slot<W>& s = rod.slot[k];
            const Slot<W>& start = work.start[to_index(k)];
            s.position = fma(P(step.drift), s.velocity, s.position);
            s.position.x += wrong;
            s.velocity += s.velocity - start.velocity;
            if (k >= rod.n) continue;
            s.director = work.director[to_index(k)];
            if (terms_.turns(k)) s.spin += s.spin - start.spin;
        }
        close_ring(rod);
    }

    StepWalls<W> walls_;
    Rows elastic_;
    std::shared_ptr<EndWalls<W>> at_mean_;
    ElasticPass<Law, W> by_walls_; ///< for the power of walls
};

} // namespace skein
