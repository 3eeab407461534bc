// Rods with and without end weights: their errors in space, beside each other. By Newton's method and inverse
// iteration, so that nothing else is in them.
#pragma once

#include "support/statics.hpp"
#include "validation/study.hpp"

#include <functional>
#include <string>
#include <vector>

namespace skein::test {

inline RodGroup group_of(RodSpec rod, EndWeights weights) {
    rod.shape.end_weights = weights;
    return RodGroup(rod, 0, 0, "");
}

struct WeightedCase {
    std::string name;
    std::function<double(EndWeights, long n)> error;
};

/// At n = 10, 20, 40; returns the largest of the errors with weights over those without.
inline double compare_weights(ErrorTable& table, const WeightedCase& c) {
    double most = 0;
    for (const long n : {10, 20, 40}) {
        const double plain = c.error(EndWeights::plain, n), gregory = c.error(EndWeights::gregory, n);
        table.add(c.name + ", plain", n, 0, plain);
        table.add(c.name + ", gregory", n, 0, gregory);
        most = std::max(most, gregory / plain);
    }
    std::printf("%s: gregory over plain at most %.2f\n", c.name.c_str(), most);
    return most;
}

} // namespace skein::test
