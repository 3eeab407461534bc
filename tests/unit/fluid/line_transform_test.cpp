// Transforms of lines: there and back, and what they are for.
#include "fluid/line_transform.hpp"

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace skein {
namespace {

constexpr LineEnds all_ends[] = {LineEnds::periodic, LineEnds::gradient_zero, LineEnds::value_zero,
                                 LineEnds::faces_zero};
constexpr int sizes[] = {2, 3, 4, 5, 6, 7, 9, 14, 16, 20, 25, 64, 105, 128, 200};

using Lines = std::vector<std::vector<double>>; ///< [line][number]

Lines random_lines(int lines, int n, LineEnds ends) {
    std::mt19937 random(static_cast<unsigned>(n));
    std::normal_distribution<double> normal;
    Lines all(static_cast<std::size_t>(lines), std::vector<double>(static_cast<std::size_t>(n)));
    for (auto& line : all)
        for (double& x : line) x = normal(random);
    if (ends == LineEnds::faces_zero)
        for (auto& line : all) line.back() = 0;
    return all;
}

/// Coefficients [line][k].
Lines transformed(const LineTransform& transform, const Lines& lines) {
    AlignedVector<double> in(transform.block()), out(transform.block());
    Lines all = lines;
    for (int i = 0; i < transform.size(); ++i)
        for (int l = 0; l < transform.lanes(); ++l)
            nth(in, transform.place(i) * transform.lanes() + l) = transform.sign(i) * nth(nth(lines, l), i);
    transform.forward(in.data(), out.data());
    for (int k = 0; k < transform.size(); ++k)
        for (int l = 0; l < transform.lanes(); ++l) nth(nth(all, l), k) = nth(out, k * transform.lanes() + l);
    return all;
}

std::vector<double> second_difference(const std::vector<double>& line, LineEnds ends) {
    const auto n = static_cast<int>(line.size());
    const auto at = [&](int i) {
        if (i >= 0 && i < n) return nth(line, i);
        if (ends == LineEnds::periodic) return nth(line, (i + n) % n);
        if (ends == LineEnds::faces_zero) return 0.0;
        const double inner = nth(line, std::clamp(i, 0, n - 1));
        return ends == LineEnds::gradient_zero ? inner : -inner;
    };
    std::vector<double> out;
    for (int i = 0; i < n; ++i) out.push_back(at(i - 1) - 2 * at(i) + at(i + 1));
    if (ends == LineEnds::faces_zero) out.back() = 0;
    return out;
}

TEST(LineTransform, ThereAndBack) {
    for (const LineEnds ends : all_ends)
        for (const int n : sizes) {
            const LineTransform transform(n, ends);
            const Lines lines = random_lines(transform.lanes(), n, ends), coefficients = transformed(transform, lines);
            AlignedVector<double> in(transform.block()), out(transform.block());
            for (int k = 0; k < n; ++k)
                for (int l = 0; l < transform.lanes(); ++l)
                    nth(in, k * transform.lanes() + l) = nth(nth(coefficients, l), k);
            transform.inverse(in.data(), out.data());
            for (int i = 0; i < n; ++i)
                for (int l = 0; l < transform.lanes(); ++l)
                    EXPECT_NEAR(transform.sign(i) * nth(out, transform.place(i) * transform.lanes() + l) /
                                    transform.gain(),
                                nth(nth(lines, l), i), 1e-14)
                        << "n " << n << " ends " << static_cast<int>(ends);
        }
}

TEST(LineTransform, DiagonalisesSecondDifferences) {
    for (const LineEnds ends : all_ends)
        for (const int n : sizes) {
            const LineTransform transform(n, ends);
            const Lines lines = random_lines(transform.lanes(), n, ends);
            Lines differences = lines;
            for (auto& line : differences) line = second_difference(line, ends);
            const Lines of_lines = transformed(transform, lines), of_differences = transformed(transform, differences);
            for (std::size_t l = 0; l < lines.size(); ++l)
                for (int k = 0; k < n; ++k)
                    EXPECT_NEAR(nth(of_differences[l], k), transform.eigenvalue(k) * nth(of_lines[l], k), 1e-13 * n)
                        << "n " << n << " ends " << static_cast<int>(ends) << " k " << k;
        }
}

/// Coefficients of cosines, by their sum.
TEST(LineTransform, IsThatOfCosines) {
    constexpr int n = 12;
    const LineTransform transform(n, LineEnds::gradient_zero);
    const Lines lines = random_lines(transform.lanes(), n, LineEnds::gradient_zero),
                coefficients = transformed(transform, lines);
    for (std::size_t l = 0; l < lines.size(); ++l)
        for (int k = 0; k < n; ++k) {
            double sum = 0;
            for (int i = 0; i < n; ++i)
                sum += nth(lines[l], i) * std::cos(std::numbers::pi * k * (2 * i + 1) / (2.0 * n));
            EXPECT_NEAR(nth(coefficients[l], k), sum, 1e-14 * n);
        }
}

} // namespace
} // namespace skein
