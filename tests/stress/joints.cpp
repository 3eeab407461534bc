// Joined rods without damping in steps of the automatic length, with SKEIN_LONG=1 a million: energy stays where it was.
#include "mechanics/rod_copies.hpp"
#include "skein/core/index.hpp"
#include "stress/stress_support.hpp"
#include "support/joint_examples.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace skein {
namespace {

double energy(const test::Stage& stage) {
    double sum = 0;
    for (std::size_t i = 0; i < stage.rods->local().size(); ++i) {
        const RodGroup& group = nth(stage.groups, stage.rods->local()[i].group);
        std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
        stage.rods->export_rod(i, state);
        synchronise(group, state, stage.clock.lag());
        const RodEnergy e = rod_energy(group, state);
        sum += e.translation + e.rotation + e.elastic();
    }
    for (const double u :
         joints_now(*stage.plan.find<JointPlan>(), stage.groups, *stage.rods, {stage.clock.time(), stage.clock.lag()})
             .energies)
        sum += u;
    return sum;
}

TEST(Joints, KeepEnergyInLongRuns) {
    const std::int64_t steps = test::long_runs() ? 1000000 : 200000;
    for (const double stiffness : {1e3, 1e6})
        for (test::JointExample& e : test::joint_examples(stiffness)) {
            e.scene.time.duration = 1e3;
            // Of two lanes, the baseline has no fused multiply-add, and takes four times as long.
            test::Stage stage(e.scene, 4);
            const double start = energy(stage);
            double first = 0, last = 0, worst = 0;
            for (int look = 1; look <= 100; ++look) {
                test::advance_checked(stage, look * steps / 100);
                const double now = energy(stage) / start - 1;
                worst = std::max(worst, std::abs(now));
                (look <= 25 ? first : last) += look <= 25 || look > 75 ? now / 25 : 0;
            }
            std::printf("%s, k = %g N/m: energy off by %.1e at most, last quarter over first %+.1e\n", e.name.c_str(),
                        stiffness, worst, last - first);
            EXPECT_LT(worst, 0.1) << e.name;
            EXPECT_LT(last - first, 0.02) << e.name << ": energy rises";
        }
}

} // namespace
} // namespace skein
