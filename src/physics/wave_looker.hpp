// The shortest period and wavelength that a table names: of drives that steps have to resolve.
#pragma once

#include "core/field_looker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein {

class WaveLooker final : public FieldLooker {
public:
    using FieldLooker::visit;
    void visit(const Field& f, double& x) override {
        if (f.name == "period" && x != 0) period = std::min(period, std::abs(x));
        if (f.name == "wavelength" && x != 0) wavelength = std::min(wavelength, std::abs(x));
        if (f.name == "frequency" && x > 0) period = std::min(period, 1 / x);
    }
    double period = std::numeric_limits<double>::infinity(), wavelength = period; ///< s, m
};

} // namespace skein
