// Skein's step against the same discrete model written as a textbook code: other loops, other operations, same
// trajectory.
#include "loads/magnetic_field.hpp"
#include "skein/core/error.hpp"
#include "support/scenes_for_tests.hpp"
#include "textbook/textbook_rods.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

using bench::TextbookBuild;
using bench::TextbookRods;

struct Size {
    double position = 0, velocity = 0, director = 0, spin = 0;
};

/// Largest magnitudes of a - b, or of a where b is absent.
Size size_of(std::span<const Slot<1>> a, std::span<const Slot<1>> b = {}) {
    Size size;
    for (std::size_t k = 0; k < a.size(); ++k) {
        const auto grow = [&](double& most, auto field) {
            const auto of_a = field(a[k]);
            most = std::max(most, b.empty() ? norm(of_a) : norm(of_a - field(b[k])));
        };
        grow(size.position, [](const Slot<1>& s) { return lane(s.position, 0); });
        grow(size.velocity, [](const Slot<1>& s) { return lane(s.velocity, 0); });
        grow(size.director, [](const Slot<1>& s) { return frame(s).d1; });
        grow(size.director, [](const Slot<1>& s) { return frame(s).d3; });
        grow(size.spin, [](const Slot<1>& s) { return lane(s.spin, 0); });
    }
    return size;
}

/// Steps a row of cilia both ways, from a bent and moving start, and compares rods at synchronised time.
void expect_same(long elements, std::int64_t steps, std::int64_t batch, double tolerance,
                 TextbookBuild build = TextbookBuild::plain) {
    SceneSpec scene = test::cilia_scene(11, elements);
    Shape& shape = scene.rods[0].shape;
    shape.start_curvature = Vec3d{0.4, -0.3, 0.5};
    shape.element_spin = {0.1, 0.2, 0.3};
    scene.loads[0].load.as<MagneticField>().ramp = {0};
    test::Stage stage(scene);
    TextbookRods textbook(stage.groups[0], stage.plan.groups[0], stage.plan.dt, 11, build);

    const std::vector<Slot<1>> start = stage.state(0);
    while (stage.clock.done() < steps) {
        const auto visit = stage.clock.next(std::min(steps, stage.clock.done() + batch));
        stage.rods->advance(visit, false);
        textbook.advance(visit);
        stage.clock.advance(visit);
    }
    std::vector<Slot<1>> state(start.size());
    for (std::size_t i = 0; i < textbook.count(); ++i) {
        textbook.state(i, state);
        const std::vector<Slot<1>> own = stage.state(i);
        const Size error = size_of(state, own), scale = size_of(own);
        EXPECT_LT(error.position, tolerance * shape.length) << "rod " << i;
        EXPECT_LT(error.velocity, tolerance * scale.velocity) << "rod " << i;
        EXPECT_LT(error.director, tolerance) << "rod " << i;
        EXPECT_LT(error.spin, tolerance * scale.spin) << "rod " << i;
    }
    textbook.state(0, state);
    EXPECT_GT(size_of(state, start).position, 1e-3 * shape.length) << "the rods must have moved";
}

TEST(Textbook, StepsLikeSkein) {
    expect_same(25, 100, 1, 1e-9);
    expect_same(6, 100, 1, 1e-9);
}

TEST(Textbook, VectorisedStepsLikeSkein) {
    expect_same(25, 100, 1, 1e-9, TextbookBuild::vectorised);
    expect_same(6, 100, 1, 1e-9, TextbookBuild::vectorised);
}

TEST(Textbook, BatchOfStepsIsTheSameSteps) { expect_same(10, 100, Clock::largest_batch, 1e-9); }

TEST(Textbook, RefusesAnotherModel) {
    test::Stage stage(test::cilia_scene(1, 5, EndKind::free));
    EXPECT_THROW(TextbookRods(stage.groups[0], stage.plan.groups[0], stage.plan.dt, 1), InputError);
}

} // namespace
} // namespace skein
