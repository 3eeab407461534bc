// Units of measurement as powers of the base units m, kg, s, A and K. Scenes are in SI. Units are checked and never
// converted: there are no prefixes.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

namespace skein {

struct Unit {
    std::array<double, 5> power{}; ///< powers of m, kg, s, A, K

    bool pure() const { return *this == Unit{}; }
    bool operator==(const Unit& other) const {
        for (std::size_t i = 0; i < power.size(); ++i)
            if (std::abs(power[i] - other.power[i]) > 1e-9) return false;
        return true;
    }
    Unit operator*(const Unit& b) const { return combined(b, 1); }
    Unit operator/(const Unit& b) const { return combined(b, -1); }
    Unit raised(double exponent) const { return Unit{}.combined(*this, exponent); }

private:
    Unit combined(const Unit& b, double exponent) const {
        Unit r = *this;
        for (std::size_t i = 0; i < power.size(); ++i) r.power[i] += exponent * b.power[i];
        return r;
    }
};

/// Reads a unit such as "N/m^2", "kg m/s", "1/s" or "-". Names have powers and stand side by side, or with "*" between
/// them; "/" begins the denominator. Returns nothing where the text cannot be read.
std::optional<Unit> parse_unit(std::string_view text);
/// "N/m" where the unit has a common name, otherwise powers of base units.
std::string unit_text(const Unit& unit);

} // namespace skein
