// Numbers with their first and second derivatives by N unknowns (forward differentiation). An energy that is written
// over a number type gives its forces and its stiffness by the same source.
//   value v, gradient g, Hessian H:   f(a) has f(v), f' g and f' H + f'' g g^T
//   rows of H up to the diagonal, in packs:   0 | 1 1 | 2 2 2 | 3 3 3 3 | 4 4 4 4 4 ...   the last pack goes beyond it
// A choice takes the derivatives of what it chooses. Where a root is 0, its derivatives are taken as 0.
#pragma once

#include "core/value_of.hpp"

namespace skein {

template <int N> class SecondOrder {
public:
    SecondOrder() = default;
    /// A constant.
    SecondOrder(double value) : v_(value) {
        for (P& g : g_) g = P(0.0);
        for (P& h : h_) h = P(0.0);
    }
    /// Unknown i.
    static SecondOrder unknown(int i, double value) {
        SecondOrder x(value);
        x.g_[i / W].set(i % W, 1);
        return x;
    }

    double value() const { return v_; }
    double slope(int i) const { return g_[i / W][i % W]; }
    double curvature(int i, int j) const { return j > i ? curvature(j, i) : h_[first(i) + j / W][j % W]; }

    [[gnu::noinline]] friend SecondOrder operator+(const SecondOrder& a, const SecondOrder& b) {
        return SecondOrder(a.v_ + b.v_, a, b, [](P x, P y) { return x + y; });
    }
    [[gnu::noinline]] friend SecondOrder operator-(const SecondOrder& a, const SecondOrder& b) {
        return SecondOrder(a.v_ - b.v_, a, b, [](P x, P y) { return x - y; });
    }
    [[gnu::noinline]] friend SecondOrder operator*(double s, const SecondOrder& a) {
        return SecondOrder(s * a.v_, a, a, [s](P x, P) { return P(s) * x; });
    }
    friend SecondOrder operator-(const SecondOrder& a) { return -1.0 * a; }
    friend SecondOrder operator+(double s, SecondOrder a) {
        a.v_ += s;
        return a;
    }
    friend SecondOrder operator-(double s, const SecondOrder& a) { return s + -1.0 * a; }
    [[gnu::noinline]] friend SecondOrder operator*(const SecondOrder& a, const SecondOrder& b) {
        const P of_a(b.v_), of_b(a.v_);
        SecondOrder c(a.v_ * b.v_, a, b, [&](P x, P y) { return fma(of_a, x, of_b * y); });
        for (int i = 0; i < N; ++i) c.add_products(i, a, P(b.slope(i)), b, P(a.slope(i)));
        return c;
    }
    /// a b + c
    [[gnu::noinline]] friend SecondOrder fma(const SecondOrder& a, const SecondOrder& b, const SecondOrder& c) {
        const P of_a(b.v_), of_b(a.v_);
        SecondOrder d(fma(a.v_, b.v_, c.v_));
        for (int k = 0; k < blocks; ++k) d.g_[k] = fma(of_a, a.g_[k], fma(of_b, b.g_[k], c.g_[k]));
        for (int k = 0; k < packs; ++k) d.h_[k] = fma(of_a, a.h_[k], fma(of_b, b.h_[k], c.h_[k]));
        for (int i = 0; i < N; ++i) d.add_products(i, a, P(b.slope(i)), b, P(a.slope(i)));
        return d;
    }
    friend SecondOrder inverse(const SecondOrder& a) {
        const double one = 1 / a.v_, squared = one * one;
        return a.composed(one, -squared, 2 * one * squared);
    }
    friend SecondOrder operator/(const SecondOrder& a, const SecondOrder& b) {
        SecondOrder q = a * inverse(b);
        q.v_ = a.v_ / b.v_;
        return q;
    }
    friend SecondOrder sqrt(const SecondOrder& a) {
        const double root = __builtin_sqrt(a.v_), slope = a.v_ > 0 ? 0.5 / root : 0;
        return a.composed(root, slope, a.v_ > 0 ? -0.5 * slope / a.v_ : 0);
    }

private:
    static constexpr int W = 4; ///< so the bits are the same at every level
    using P = Pack<W>;
    static constexpr int blocks = (N + W - 1) / W;
    /// First pack of row i.
    static constexpr int first(int i) {
        const int b = i / W;
        return W * b * (b + 1) / 2 + (i - W * b) * (b + 1);
    }
    static constexpr int packs = first(N);

    /// Value, and derivatives as a linear function of those of a and b.
    template <class F> SKEIN_INLINE SecondOrder(double value, const SecondOrder& a, const SecondOrder& b, F&& f)
        : v_(value) {
        for (int k = 0; k < blocks; ++k) g_[k] = f(a.g_[k], b.g_[k]);
        for (int k = 0; k < packs; ++k) h_[k] = f(a.h_[k], b.h_[k]);
    }
    /// Adds x g_a + y g_b to row i of the Hessian.
    SKEIN_INLINE void add_products(int i, const SecondOrder& a, P x, const SecondOrder& b, P y) {
        P* const row = h_ + first(i);
        for (int c = 0; c <= i / W; ++c) row[c] = fma(x, a.g_[c], fma(y, b.g_[c], row[c]));
    }
    [[gnu::noinline]] SecondOrder composed(double value, double slope, double curvature) const {
        SecondOrder f(value, *this, *this, [slope](P x, P) { return P(slope) * x; });
        for (int i = 0; i < N; ++i) {
            const P of_row(curvature * this->slope(i));
            P* const row = f.h_ + first(i);
            for (int c = 0; c <= i / W; ++c) row[c] = fma(of_row, g_[c], row[c]);
        }
        return f;
    }

    double v_;
    P g_[blocks], h_[packs];
};

inline double inverse(double a) { return 1 / a; }
template <int N> double value_of(const SecondOrder<N>& a) { return a.value(); }

} // namespace skein
