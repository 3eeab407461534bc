// A clamped rod magnetised along its axis in a transverse field, relaxed to rest, against its boundary-value problem
// (support/magnetised_elastica.hpp): with the bending's share of the stretch the continuum of the discrete rod, so the
// error against it falls with dl^2; without, the published yardstick.
#include "loads/magnetic_field.hpp"
#include "support/magnetised_elastica.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

constexpr double bonds[] = {0.1, 1, 3, 10};
constexpr long resolutions[] = {10, 20, 40, 50};

/// One group per bond and resolution, damped until it rests.
SceneSpec scene() {
    SceneSpec scene;
    for (const double bond : bonds)
        for (const long n : resolutions) {
            scene.rods.push_back(test::magnetised_rod(bond, n));
            scene.rods.back().name = "rod" + std::to_string(scene.rods.size());
        }
    const double first_frequency = test::cantilever_frequency(scene.rods[0]);
    scene.time = {.duration = 20 / first_frequency};
    scene.loads.push_back({.load = MagneticField{.constant = test::magnetising_field, .ramp = {1 / first_frequency}}});
    scene.damping.push_back({.damping = {.kind = DampingKind::uniform, .rate = 2 * first_frequency}});
    return scene;
}

TEST(MagnetisedCantilever, MeetsItsBoundaryValueProblemAtSecondOrder) {
    test::Stage stage(scene(), 1, 2);
    stage.advance(stage.plan.steps);
    test::ErrorTable table("magnetised_cantilever");
    std::size_t i = 0;
    for (const double bond : bonds) {
        const test::MagnetisedTip own = test::magnetised_tip(bond, test::magnetised_slenderness),
                                  published = test::magnetised_tip(bond, 0);
        const double deflection = std::hypot(published.x, 1 - published.z);
        double error[std::size(resolutions)], published_error = 0;
        for (std::size_t r = 0; r < std::size(resolutions); ++r, ++i) {
            const Vec3d tip = lane(stage.state(i).back().position, 0);
            error[r] = std::hypot(tip.x - own.x, tip.z - own.z) / deflection;
            published_error = std::hypot(tip.x - published.x, tip.z - published.z) / deflection;
            EXPECT_LT(std::abs(tip.y), 1e-12);
            table.add("bond " + std::to_string(bond).substr(0, 4), resolutions[r], stage.plan.dt, error[r]);
        }
        const double order = std::log2(error[1] / error[2]);
        std::printf("bond %4.1f: tip (%.6f, %.6f), error at n = 10, 20, 40, 50: %.2e %.2e %.2e %.2e, order %.3f; n = "
                    "50 against "
                    "the inextensible elastica %.2e\n",
                    bond, own.x, own.z, error[0], error[1], error[2], error[3], order, published_error);
        EXPECT_GE(order, 1.9) << "bond " << bond;
        EXPECT_LE(error[3], 1e-3) << "bond " << bond;
        EXPECT_LE(published_error, 1e-3) << "bond " << bond;
    }
}

TEST(MagnetisedCantilever, FrozenClampIsFirstOrder) {
    SceneSpec frozen = scene();
    const auto bond_1 = frozen.rods.begin() + std::size(resolutions);
    frozen.rods = std::vector<RodSpec>(bond_1, bond_1 + std::size(resolutions));
    for (RodSpec& rod : frozen.rods) rod.start = EndKind::clamped_frozen;
    test::Stage stage(frozen, 1, 2);
    stage.advance(stage.plan.steps);
    const test::MagnetisedTip own = test::magnetised_tip(1, test::magnetised_slenderness);
    const auto error = [&](std::size_t r) {
        const Vec3d tip = lane(stage.state(r).back().position, 0);
        return std::hypot(tip.x - own.x, tip.z - own.z);
    };
    EXPECT_NEAR(std::log2(error(1) / error(2)), 1.0, 0.15);
    EXPECT_GT(error(3), 1e-2 * std::hypot(own.x, 1 - own.z)) << "the published clamp is coarse at n = 50";
}

} // namespace
} // namespace skein
