// A free, undamped rod in motion: energy bounded and of second order in the step, momenta kept, step reversible in
// time.
#include "support/energy.hpp"
#include "support/free_rods.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

struct Motion {
    double drift = 0;        ///< max |E - E0|/E0
    Vec3d momentum, angular; ///< change over the run
    double momentum_scale = 0, angular_scale = 0;
    Vec3d tip;
};

Motion run(double dt, bool elliptic, double time) {
    SceneSpec scene = test::flying_rod(elliptic, time);
    scene.time.dt = dt;
    test::Stage stage(scene);
    const RodGroup& group = stage.groups[0];
    const auto [p0, l0] = test::momenta(group, stage.state(0));
    Motion motion;
    test::Cost cost;
    motion.drift = test::energy_drift(stage, std::llround(time / dt), 200, cost);
    const auto [p1, l1] = test::momenta(group, stage.state(0));
    motion.momentum = p1 - p0;
    motion.angular = l1 - l0;
    motion.momentum_scale = norm(p0);
    motion.angular_scale = norm(l0);
    motion.tip = lane(stage.state(0).back().position, 0);
    return motion;
}

TEST(FreeRod, EnergyErrorIsSecondOrderAndMomentaAreKept) {
    test::ErrorTable table("free_rod");
    for (const bool elliptic : {false, true}) {
        const Motion coarse = run(2e-5, elliptic, 0.1), middle = run(1e-5, elliptic, 0.1),
                     fine = run(5e-6, elliptic, 0.1);
        const std::string name = elliptic ? "energy, elliptic" : "energy, circular";
        table.add(name, 20, 2e-5, coarse.drift);
        table.add(name, 20, 1e-5, middle.drift);
        table.add(name, 20, 5e-6, fine.drift);
        EXPECT_LT(middle.drift, 1e-4);
        EXPECT_NEAR(std::log2(norm(coarse.tip - middle.tip) / norm(middle.tip - fine.tip)), 2.0, 0.15)
            << (elliptic ? "elliptic" : "circular");
        EXPECT_NEAR(std::log2(middle.drift / fine.drift), 2.0, 0.4);
        for (const Motion& m : {coarse, middle, fine}) {
            EXPECT_LT(norm(m.momentum), 1e-12 * m.momentum_scale);
            EXPECT_LT(norm(m.angular), 1e-11 * m.angular_scale);
        }
    }
}

TEST(FreeRod, EnergyDoesNotDriftOver2e5Steps) {
    const Motion motion = run(4e-4, false, 80);
    EXPECT_LT(motion.drift, 5e-3);
    EXPECT_LT(norm(motion.momentum), 1e-11 * motion.momentum_scale);
    EXPECT_LT(norm(motion.angular), 1e-10 * motion.angular_scale);
}

} // namespace
} // namespace skein
