// Transforms of real lines that diagonalise second differences, for each kind of LineEnds: Fourier transforms of
// periodic lines, cosines for gradient_zero, sines for value_zero and faces_zero. Two real lines make a complex one. A
// complex transform and a pass over pairs of coefficients serve all kinds; that of faces_zero is twice as long.
// theory.md (78), (79)
#pragma once

#include "fluid/fft.hpp"
#include "fluid/lanes.hpp"
#include "fluid/line_ends.hpp"
#include "skein/core/index.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace skein {

/// Transform of lanes() adjacent lines: number i of line l is in row place(i), column l of a block.
class LineTransform {
public:
    LineTransform(int n, LineEnds ends)
        : n_(n), length_(ends == LineEnds::faces_zero ? 2 * n : n), lanes_(n <= 192 ? 16 : 8), ends_(ends),
          forward_(length_, lanes_ / 2, Fft::Way::forward), inverse_(length_, lanes_ / 2, Fft::Way::inverse) {
        const double pi = std::numbers::pi;
        for (int k = 0; k <= n / 2; ++k) {
            const double angle = ends == LineEnds::periodic ? 0 : pi * k / (2.0 * n);
            twiddle_.push_back({std::cos(angle), std::sin(angle)});
        }
        for (int k = 0; k < n; ++k) eigenvalue_.push_back(second_difference(n, ends, k));
    }

    int size() const { return n_; }
    LineEnds ends() const { return ends_; }
    int lanes() const { return lanes_; }
    std::size_t block() const { return to_index(length_ * lanes_); }
    int place(int i) const {
        if (ends_ == LineEnds::faces_zero) return i + 1;
        return ends_ == LineEnds::periodic ? i : i % 2 == 0 ? i / 2 : n_ - 1 - i / 2;
    }
    /// Factor of number i before and after transforms.
    double sign(int i) const { return ends_ == LineEnds::value_zero && i % 2 == 1 ? -1 : 1; }
    /// Eigenvalue of the second difference for coefficient k.
    double eigenvalue(int k) const { return nth(eigenvalue_, k); }
    /// Factor of a transform and its inverse together.
    double gain() const { return length_; }

    /// Transforms numbers to coefficients in order, and overwrites `numbers`. The last of `faces_zero` counts as 0.
    void forward(double* numbers, double* coefficients) const {
        if (ends_ == LineEnds::faces_zero) return sines(forward_, -1, numbers, coefficients);
        forward_.run(numbers, coefficients);
        for_pairs(
            [&](std::size_t low, std::size_t high, double c, double s) {
                double *const at_low = coefficients + low, *const at_high = coefficients + high;
                const P z = load<8>(at_low), y = load<8>(at_high), even = z + y, odd = turned(z - y);
                store(at_low, P(0.5) * fma(P(c), even, P(s) * odd));
                store(at_high, P(0.5) * fms(P(s), even, P(c) * odd));
            },
            [&](std::size_t middle, double c) { store(coefficients + middle, P(c) * load<8>(coefficients + middle)); });
    }
    /// Transforms coefficients to numbers, and overwrites `coefficients`.
    void inverse(double* coefficients, double* numbers) const {
        if (ends_ == LineEnds::faces_zero) return sines(inverse_, 1, coefficients, numbers);
        for_pairs(
            [&](std::size_t low, std::size_t high, double c, double s) {
                double *const at_low = coefficients + low, *const at_high = coefficients + high;
                const P a = load<8>(at_low), b = load<8>(at_high), even = fma(P(c), a, P(s) * b),
                        odd = swapped(sign_of_second() * fms(P(s), a, P(c) * b));
                store(at_low, even + odd);
                store(at_high, even - odd);
            },
            [&](std::size_t middle, double c) {
                store(coefficients + middle, P(1 / c) * load<8>(coefficients + middle));
            });
        inverse_.run(coefficients, numbers);
    }

private:
    using P = Pack<8>;
    struct Twiddle {
        double c, s;
    };
    static P sign_of_second() {
        static constexpr double signs[8] = {1, -1, 1, -1, 1, -1, 1, -1};
        return load<8>(signs);
    }
    static P turned(const P& difference) { return sign_of_second() * swapped(difference); }

    /// Twice the sums of sines, by a transform of rows that are odd about rows 0 and n. `sign` is that of the exponent.
    void sines(const Fft& fft, double sign, double* from, double* to) const {
        const std::size_t row = to_index(lanes_), n = to_index(n_);
        const P turn = P(sign) * sign_of_second();
        for (std::size_t l = 0; l < row; l += 8) {
            store(from + l, P(0.0));
            store(from + n * row + l, P(0.0));
            for (std::size_t i = 1; i < n; ++i) store(from + (2 * n - i) * row + l, -load<8>(from + i * row + l));
        }
        fft.run(from, to);
        for (std::size_t l = 0; l < row; l += 8) {
            store(to + l, P(0.0));
            store(to + n * row + l, P(0.0));
            for (std::size_t k = 1; k < n; ++k) store(to + k * row + l, turn * swapped(load<8>(to + k * row + l)));
        }
    }

    /// Calls two(k, n - k) with offsets of packs of both coefficients, and one() for the middle of an even number.
    template <class Two, class One> void for_pairs(Two&& two, One&& one) const {
        const std::size_t row = to_index(lanes_), n = to_index(n_);
        for (std::size_t k = 1; 2 * k <= n; ++k) {
            const auto [c, s] = twiddle_[k];
            for (std::size_t l = 0; l < row; l += 8) {
                if (2 * k == n) one(k * row + l, c);
                else two(k * row + l, (n - k) * row + l, c, s);
            }
        }
    }

    int n_, length_, lanes_; ///< `length_` is that of the complex transform
    LineEnds ends_;
    Fft forward_, inverse_;
    std::vector<Twiddle> twiddle_;
    std::vector<double> eigenvalue_;
};

} // namespace skein
