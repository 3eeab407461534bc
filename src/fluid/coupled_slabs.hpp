// Coefficients whose columns couple the slabs of all ranks by a chain of two unknowns a slab. theory.md (79a), (79b)
#pragma once

#include "fluid/columns.hpp"
#include "fluid/slab_coupling.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <vector>

namespace skein {

/// Chains of a share of the modes along x, for equations with the same ends. Ranks of slabs with that share solve
/// different coefficients.
class CoupledSlabs {
public:
    using P = Columns::P;
    CoupledSlabs(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const Pencils& pencils,
                 const Helmholtz& equation)
        : threads_(threads), slabs_(pencils.slabs()), planes_(grid.cells[2]),
          first_mode_(pencils.modes(pencils.share()).first), work_(to_index(threads.count())) {
        const int least = equation.unknown(planes_ / slabs_),
                  end_mode = first_mode_ + pencils.modes(pencils.share()).count;
        std::vector<Coefficient> all;
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int m = first_mode_; m < end_mode; ++m)
                if (couples_slabs(equation.x.eigenvalue(m) + equation.y.eigenvalue(j), least)) all.push_back({m, j});
        const auto share = [&](int slab) { return slab_of(static_cast<int>(all.size()), slab, slabs_); };
        const auto room = [](int count) { return to_index((count + 7) / 8 * 8); };
        std::size_t begin = 0;
        std::vector<std::size_t> begins; // offsets in sent_ by slab
        for (int r = 0; r < slabs_; ++r) {
            const Slab of_rank = share(r);
            begins.push_back(begin);
            for (int c = 0; c < of_rank.count; ++c)
                places_.push_back(
                    {nth(all, of_rank.first + c), begin + to_index(c), begin + room(of_rank.count) + to_index(c)});
            begin += 2 * room(of_rank.count);
        }
        const Slab mine = share(pencils.slab());
        own_.assign(all.begin() + mine.first, all.begin() + mine.first + mine.count);
        room_ = room(mine.count);
        sent_.assign(begin, 0.0);
        chains_.assign(to_index(slabs_) * 2 * room_, 0.0);
        std::vector<RepeatedMessages::Part> of_slab, of_chains;
        for (int r = 0; r < slabs_; ++r) {
            const int rank = pencils.rank_of(r, pencils.share());
            const std::size_t at = to_index(r);
            const std::size_t count = 2 * room(share(r).count);
            if (count > 0) of_slab.push_back(message_part(rank, {sent_.data() + begins[at], count}));
            if (room_ > 0) of_chains.push_back(message_part(rank, {chain(r, 0), 2 * room_}));
        }
        to_chains_ = RepeatedMessages(comm, of_slab, of_chains);
        to_slabs_ = RepeatedMessages(comm, of_chains, of_slab);
        for (std::vector<Link>& links : work_) links.resize(to_index(slabs_));
    }

    /// Starts from the first and last numbers [j][m] of this slab alone. finish() gives the numbers just below and
    /// above it. Collective.
    void start(const Helmholtz& equation, const double* first, const double* last, int row) {
        for (const Place& place : places_) {
            const std::ptrdiff_t at = place.coefficient.at(row, first_mode_);
            sent_[place.lower] = first[at];
            sent_[place.upper] = last[at];
        }
        to_chains_.start();
        to_chains_.finish();
        threads_.for_each(room_ / 8, [&](std::size_t pack, int thread) {
            if (equation.z == LineEnds::periodic) solve_ring(equation, 8 * pack, nth(work_, thread));
            else solve_chain(equation, 8 * pack, nth(work_, thread));
        });
        to_slabs_.start();
    }
    void finish(double* below, double* above, int row) {
        to_slabs_.finish();
        for (const Place& place : places_) {
            const std::ptrdiff_t at = place.coefficient.at(row, first_mode_);
            below[at] = sent_[place.lower];
            above[at] = sent_[place.upper];
        }
    }

    std::size_t bytes() const {
        return (sent_.size() + chains_.size()) * sizeof(double) + places_.size() * sizeof(Place);
    }

private:
    struct Coefficient {
        int m, j;
        std::ptrdiff_t at(int row, int first) const { return static_cast<std::ptrdiff_t>(j) * row + m - first; }
    };
    struct Place {
        Coefficient coefficient;
        std::size_t lower, upper; ///< offsets in sent_
    };
    /// Response to 1 just beyond one end of a slab, at that end and at the other: alpha and beta of (79a).
    struct Reach {
        P near, far;
    };
    /// Link of a slab: last = p + q next + t end, first = a + b next + c end.
    /// Here `next` is the first number of the next slab, and `end` the last number of all.
    struct Link {
        P p, q, t, a, b, c;
    };

    double* chain(int slab, std::size_t end) { return chains_.data() + (to_index(slab) * 2 + end) * room_; }
    /// Reach through n planes, with `end` added to the diagonal at the other end.
    static Reach reach(const P& diagonal, int n, const P& end) {
        P pivot(0.0), far(1.0);
        for (int k = 0; k < n; ++k) {
            pivot = Columns::inverse_of(diagonal + (k == 0 ? end : P(0.0)) - pivot);
            far = far * -pivot;
        }
        return {-pivot, far};
    }
    P diagonal_of(const Helmholtz& equation, std::size_t first) const {
        P diagonal(-3.0);
        for (std::size_t l = 0; l < 8 && first + l < own_.size(); ++l)
            diagonal.set(static_cast<int>(l), equation.diagonal(own_[first + l].m, own_[first + l].j));
        return diagonal;
    }
    int planes(int slab) const { return slab_of(planes_, slab, slabs_).count; }
    /// Links slabs from `begin` to `end`; `p`, `q` and `t` belong to the slab before.
    void link(const P& diagonal, int begin, int end, std::size_t at, std::vector<Link>& links, P p, P q, P t) {
        const int least = planes_ / slabs_;
        const Reach thin = reach(diagonal, least, P(0.0)), thick = reach(diagonal, least + 1, P(0.0));
        for (int r = begin; r < end; ++r) {
            const auto& [near, far] = planes(r) == least ? thin : thick;
            const P inverse = P(1.0) / (P(1.0) - near * q), a = (load<8>(chain(r, 0) + at) + near * p) * inverse,
                    b = far * inverse, c = near * t * inverse;
            p = load<8>(chain(r, 1) + at) + far * (p + q * a);
            t = far * (t + q * c);
            q = near + far * (q * b);
            nth(links, r) = {p, q, t, a, b, c};
        }
    }
    /// Solves eight columns between two ends, from slab to slab and back, for the numbers beyond each slab.
    void solve_chain(const Helmholtz& equation, std::size_t at, std::vector<Link>& links) {
        const P diagonal = diagonal_of(equation, at), end(equation.end());
        const int last = slabs_ - 1;
        const P p = load<8>(chain(0, 1) + at), q = reach(diagonal, planes(0), end).near;
        links[0] = {p, q, P(0.0), P(0.0), P(0.0), P(0.0)};
        link(diagonal, 1, last, at, links, p, q, P(0.0));
        const Link& before = nth(links, last - 1);
        const P near = reach(diagonal, equation.unknown(planes(last)), end).near;
        // The constant is free: the last number of all is 0, as in whole columns.
        const P first =
            select(constants(equation, diagonal), -load<8>(chain(last, 1) + at) - before.p,
                   (load<8>(chain(last, 0) + at) + near * before.p) * Columns::inverse_of(P(1.0) - near * before.q));
        P above = P(0.0), here = first;
        for (int r = last; r >= 0; --r) {
            const Link& below = nth(links, std::max(r - 1, 0));
            store(chain(r, 0) + at, fma(below.q, here, below.p));
            store(chain(r, 1) + at, above);
            above = here;
            here = fma(below.b, here, below.a);
        }
    }
    /// Solves eight periodic columns by the first and last number of all.
    void solve_ring(const Helmholtz& equation, std::size_t at, std::vector<Link>& links) {
        const P diagonal = diagonal_of(equation, at);
        link(diagonal, 0, slabs_, at, links, P(0.0), P(0.0), P(1.0));
        // First numbers of slabs by these two, from above.
        P a(0.0), b(1.0), c(0.0);
        for (int r = slabs_ - 1; r >= 0; --r) {
            Link& of = nth(links, r);
            a = fma(of.b, a, of.a);
            c = fma(of.b, c, of.c);
            b = of.b * b;
            of.a = a;
            of.b = b;
            of.c = c;
        }
        const Link& all = nth(links, slabs_ - 1);
        const P inverse = P(1.0) / (P(1.0) - b), free = P(1.0) - all.t - all.q * c * inverse,
                last = select(constants(equation, diagonal), P(0.0),
                              (all.p + all.q * a * inverse) * Columns::inverse_of(free)),
                first = (a + c * last) * inverse;
        P below = last;
        for (int r = 0; r < slabs_; ++r) {
            const Link& of = nth(links, r);
            const bool top = r + 1 == slabs_;
            const Link& next = nth(links, top ? 0 : r + 1);
            const P above = top ? first : fma(next.b, first, fma(next.c, last, next.a));
            store(chain(r, 0) + at, below);
            store(chain(r, 1) + at, above);
            below = fma(of.q, above, fma(of.t, last, of.p));
        }
    }
    static Mask<8> constants(const Helmholtz& equation, const P& diagonal) {
        return abs(diagonal + P(2.0)) < P(equation.singular() ? 1e-11 : -1.0);
    }

    const Threads& threads_;
    int slabs_, planes_, first_mode_;
    std::vector<Place> places_;    ///< places of all coefficients
    std::vector<Coefficient> own_; ///< coefficients whose chains this rank solves
    std::size_t room_;             ///< their number in whole packs
    /// [slab whose rank solves][first, last][coefficient] of this slab; [below, above] on the way back.
    AlignedVector<double> sent_;
    AlignedVector<double> chains_; ///< [slab][first, last][own coefficient]; [below, above] on the way back
    RepeatedMessages to_chains_, to_slabs_;
    std::vector<std::vector<Link>> work_; ///< by thread and slab
};

} // namespace skein
