// What validation cases share: running with the cost measured, coming to rest, and the table of errors with observed orders.
#pragma once

#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace skein::test {

struct Cost {
    double element_steps = 0, seconds = 0;
};

/// Advances all rods of a stage to step `until`, adding to `cost`.
inline void advance(Stage& stage, std::int64_t until, Cost& cost) {
    double elements = 0;
    for (const LocalRod& rod : stage.rods->local()) elements += stage.groups[static_cast<std::size_t>(rod.group)].elements();
    const auto steps = static_cast<double>(until - stage.clock.done());
    const auto begin = std::chrono::steady_clock::now();
    stage.advance(until);
    cost.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    cost.element_steps += steps * elements;
}

/// One rod on its way to rest: damped at twice its lowest frequency `omega` (rad/s) for 40/omega, so that the slowest motion
/// shrinks by 41 e^-40 = 2e-16. Statics do not depend on density or damping.
inline SceneSpec coming_to_rest(const RodSpec& rod, double omega, std::vector<LoadSpec> loads) {
    SceneSpec scene;
    scene.time = {.duration = 40 / omega};
    scene.rods = {rod};
    scene.loads = std::move(loads);
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 2 * omega}}};
    return scene;
}

/// First frequency of a clamped slender rod of circular section, rad/s: 3.516 sqrt(EI/(rho A))/L^2.
inline double cantilever_frequency(const RodSpec& rod) {
    return 3.516 * 0.5 * rod.section.radius * std::sqrt(rod.material.youngs_modulus / rod.material.density) /
           (rod.shape.length * rod.shape.length);
}

/// Runs to the end of the scene and expects every node at rest: no faster than 1e-10 lengths in 1/omega.
inline void come_to_rest(Stage& stage, double omega, Cost& cost) {
    advance(stage, stage.plan.steps, cost);
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

    /// Returns the observed order against the previous row of this quantity, log(error ratio)/log(refinement): in n where n
    /// differs, in dt otherwise; NaN for the first row.
    double add(const std::string& quantity, long n, double dt, double error, const Cost& cost = {}) {
        double order = std::nan("");
        if (const auto last = last_.find(quantity); last != last_.end()) {
            const Row& before = last->second;
            const double refinement = before.n != n ? static_cast<double>(n) / static_cast<double>(before.n) : before.dt / dt;
            order = std::log(before.error / error) / std::log(refinement);
        }
        last_[quantity] = {n, dt, error};
        std::printf("%s, %s: n %ld, dt %.3e s, error %.3e, order %.3f\n", name_.c_str(), quantity.c_str(), n, dt, error, order);
        if (file_.is_open()) {
            char row[256];
            std::snprintf(row, sizeof row, "%s,\"%s\",%ld,%.9g,%.9g,%.6g,", name_.c_str(), quantity.c_str(), n, dt, error, order);
            file_ << row;
            if (cost.element_steps > 0)
                file_ << cost.element_steps << ',' << cost.seconds << '\n';
            else
                file_ << ",\n";
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
