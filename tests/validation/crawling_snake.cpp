// The snake of Gazzola et al. 2018 as PyElastica's example has it: a wave of muscle couple runs from its end to its
// start, and it crawls by friction that holds more across than along. Eleven periods of that example gave 0.1589
// lengths per period ahead.
#include "loads/damping.hpp"
#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "loads/plane_friction.hpp"
#include "mechanics/elastica.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/rod_copies.hpp"
#include "tiles/rods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace skein {
namespace {

constexpr double length = 0.35, period = 2, gravity = 9.80665, radius = 0.011 * length;

RodSpec snake(Law law) {
    RodSpec rod;
    rod.name = "snake";
    rod.material = {.density = 1000, .youngs_modulus = 1e6, .shear_modulus = 1e6 / 1.5, .law = law};
    rod.section = {.radius = radius};
    rod.shape = {.length = length, .elements = 50};
    rod.placement = {.origin = {0, 0, radius}, .tangent = {1, 0, 0}, .normal = Vec3d{0, 0, 1}};
    return rod;
}

/// One snake and its step.
class Snake {
public:
    Snake(const RodGroup& group, double dt)
        : group_(group), state_(static_cast<std::size_t>(group.slots())), load_(state_.size()),
          tile_(tile_of(group, state_)), clock_(dt, 0) {
        group.start_state(0, state_);
        const std::vector<Damping> damping{{.kind = DampingKind::legacy, .rate = 2e-3}};
        const bool published = group.law() == Law::elastica;
        with_gyration(gyration_of(group),
                      [&]<class Top>(Top) { program_.push_back(std::make_unique<DriftPass<Top, 1>>()); });
        program_.push_back(std::make_unique<OrthonormalisePass<1>>());
        if (published) program_.push_back(std::make_unique<ElasticaPass<1>>(Ends{}));
        else program_.push_back(std::make_unique<ElasticPass<IncompressibleLaw, 1>>(Ends{}));
        const double mu = length / (period * period * gravity * 0.1);
        program_.push_back(std::make_unique<LoadPass<Gravity, 1>>(Gravity{{0, 0, -gravity}}, group));
        const MuscleTorques muscles{.coefficients = {3.4e-3, 3.3e-3, 4.2e-3, 2.6e-3, 3.6e-3, 3.5e-3},
                                    .period = period,
                                    .wave_number = 2 * std::numbers::pi,
                                    .ramp = {period}};
        program_.push_back(std::make_unique<LoadPass<MuscleTorques, 1>>(muscles, group));
        const PlaneFriction floor{.stiffness = 1,
                                  .damping = 1e-6,
                                  .tolerance = 1e-4,
                                  .kinetic_forward = mu,
                                  .kinetic_backward = 1.5 * mu,
                                  .kinetic_sideways = 2 * mu,
                                  .slip_speed = 1e-8};
        program_.push_back(std::make_unique<LoadPass<PlaneFriction, 1>>(floor, group));
        KicksOfGroup kicks{KickConstants(group, damping_rates(group, damping), dt,
                                         published ? DampingScheme::after : DampingScheme::midpoint)};
        if (published) program_.push_back(std::make_unique<KickPass<KickKind::elastica, 1>>(std::move(kicks)));
        else program_.push_back(std::make_unique<KickPass<KickKind::stretched_rates, 1>>(std::move(kicks)));
        for (const auto& pass : program_) pass->bind(tile_);
    }
    void advance(std::int64_t until) {
        while (clock_.done() < until) {
            const auto batch = clock_.next(until);
            for (const auto& pass : program_) pass->prepare(batch);
            for (const Step& step : batch)
                for (const auto& pass : program_) pass->run(tile_, load_.data(), step);
            clock_.advance(batch);
        }
    }
    std::vector<Slot<1>> state() const {
        std::vector<Slot<1>> out = state_;
        synchronise_positions(group_, out, clock_.lag());
        return out;
    }

private:
    const RodGroup& group_;
    std::vector<Slot<1>> state_;
    std::vector<SlotLoad<1>> load_;
    RodTile<1> tile_;
    Clock clock_;
    TilePasses<1> program_;
};

struct Crawl {
    double ahead, sideways; ///< lengths per period
};

/// Mean over whole periods after the first: the way of the middle along and across the mean direction of each period.
Crawl crawl(Law law, double dt) {
    const RodGroup group(snake(law), 0, 0, "");
    Snake one(group, dt);
    const std::int64_t steps = std::llround(period / dt), looks = 100;
    Crawl sum{0, 0};
    Vec3d before{0, 0, 0};
    for (int p = 0; p < 11; ++p) {
        Vec3d middle{0, 0, 0}, along{0, 0, 0};
        for (std::int64_t look = 1; look <= looks; ++look) {
            one.advance(p * steps + steps * look / looks);
            const auto state = one.state();
            middle = {0, 0, 0};
            for (std::size_t i = 0; i < state.size(); ++i)
                middle += (i == 0 || i == 50 ? 0.01 : 0.02) * lane(state[i].position, 0);
            along += lane(state.back().position, 0) - lane(state.front().position, 0);
        }
        along = (1 / norm(along)) * along;
        const Vec3d way = (1 / length) * (middle - before), up{0, 0, 1};
        before = middle;
        if (p == 0) continue;
        sum.ahead += dot(way, along) / 10;
        sum.sideways += dot(way, cross(up, along)) / 10;
        EXPECT_NEAR(middle.z, radius, 0.1 * radius);
    }
    return sum;
}

TEST(CrawlingSnake, IsAsFastAsThePublishedOne) {
    const struct {
        const char* name;
        Law law;
        double dt;
    } cases[] = {{"elastica", Law::elastica, 1e-4},
                 {"incompressible", Law::incompressible, 1e-4},
                 {"incompressible, half the step", Law::incompressible, 5e-5}};
    for (const auto& c : cases) {
        const Crawl found = crawl(c.law, c.dt);
        std::printf("%s: %.4f lengths per period ahead, %.4f sideways\n", c.name, found.ahead, found.sideways);
        EXPECT_NEAR(std::abs(found.ahead), 0.1589, 0.03 * 0.1589) << c.name;
    }
}

} // namespace
} // namespace skein
