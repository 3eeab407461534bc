// What validation cases share: coming to rest as an expectation, and the table of errors with observed orders.
#pragma once

#include "support/relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace skein::test {

/// Runs to the end of a scene of `coming_to_rest` and expects every node at rest: no faster than 1e-10 lengths in
/// 1/omega.
inline void come_to_rest(Stage& stage, Cost& cost) {
    advance(stage, stage.plan.steps, cost);
    const double omega = 40 / stage.scene.time.duration;
    for (std::size_t i = 0; i < stage.rods->local().size(); ++i) {
        double speed = 0;
        for (const Slot<1>& s : stage.state(i)) speed = std::max(speed, norm(lane(s.velocity, 0)));
        EXPECT_LT(speed, 1e-10 * omega * stage.scene.rods[0].shape.length) << "rod " << i << " still moves";
    }
}

/// Errors of one case. Prints each row; keeps all as CASE.csv in the folder that SKEIN_VALIDATION_OUT names, if it does
/// (drawn by bench/plots/validation.py). Cost is left empty where none is given.
class ErrorTable {
public:
    explicit ErrorTable(std::string name) : name_(std::move(name)) {
        if (const char* folder = std::getenv("SKEIN_VALIDATION_OUT")) {
            std::filesystem::create_directories(folder);
            file_.open(std::filesystem::path(folder) / (name_ + ".csv"));
            file_.precision(9);
            file_ << "case,quantity,n,dt,error,order,element_steps,seconds\n";
        }
    }

    /// Returns the observed order against the previous row of this quantity, log(error ratio)/log(refinement): in n
    /// where n differs, in dt otherwise; NaN for the first row.
    double add(const std::string& quantity, long n, double dt, double error, const Cost& cost = {}) {
        double order = std::nan("");
        if (const auto last = last_.find(quantity); last != last_.end()) {
            const Row& before = last->second;
            const double refinement =
                before.n != n ? static_cast<double>(n) / static_cast<double>(before.n) : before.dt / dt;
            order = std::log(before.error / error) / std::log(refinement);
        }
        last_[quantity] = {n, dt, error};
        std::printf("%s, %s: n %ld, dt %.3e s, error %.3e, order %.3f\n", name_.c_str(), quantity.c_str(), n, dt, error,
                    order);
        if (file_.is_open()) {
            char row[256];
            std::snprintf(row, sizeof row, "%s,\"%s\",%ld,%.9g,%.9g,%.6g,", name_.c_str(), quantity.c_str(), n, dt,
                          error, order);
            file_ << row;
            if (cost.element_steps > 0) file_ << cost.element_steps << ',' << cost.seconds << '\n';
            else file_ << ",\n";
        }
        return order;
    }

private:
    struct Row {
        long n;
        double dt, error;
    };
    std::string name_;
    std::map<std::string, Row> last_;
    std::ofstream file_;
};

} // namespace skein::test
