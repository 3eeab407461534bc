#include "core/two_digits.hpp"

#include <cmath>
#include <string>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr double same = 1e-12; ///< share of a number that counts as rounding

double in_units(double x, double (*whole)(double), double slack) {
    const double unit = std::pow(10, std::floor(std::log10(x)) - 1);
    return std::stod(fmt::format("{:.1e}", whole(x / unit * slack) * unit));
}

} // namespace

double rounded_down(double x) {
    return in_units(
        x, [](double digits) { return std::floor(digits); }, 1 + same);
}
double rounded_up(double x) {
    return in_units(
        x, [](double digits) { return std::ceil(digits); }, 1 - same);
}

} // namespace skein
