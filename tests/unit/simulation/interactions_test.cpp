// What must hold of everything that touches, under every law: no place and no direction is special, momentum stays with
// what is free, elastic contacts keep energy and all others take some, stiffer ones ask for shorter steps.
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "skein/core/index.hpp"
#include "support/interaction_examples.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

using test::InteractionExample;
using test::Meeting;
using test::Turn;

constexpr std::int64_t meeting_steps = 8000;

static_assert(std::size(contact_normal_names) == 2,
              "a new law of the normal force needs numbers in law_of, and is elastic or not");
static_assert(std::size(contact_friction_names) == 5, "a new law of friction needs numbers in law_of");

ContactLaw law_of(ContactNormal normal, ContactFriction friction) {
    const bool hertz = normal == ContactNormal::hertz;
    ContactLaw law{
        .normal = normal, .stiffness = hertz ? 1e6 : 1e5, .damping = hertz ? 300.0 : 30.0, .friction = friction};
    if (friction == ContactFriction::none) return law;
    law.static_friction = 0.5;
    law.kinetic_friction = 0.4;
    if (friction == ContactFriction::memory) law.tangential_damping = 2;
    else law.slip_speed = 0.05;
    if (friction == ContactFriction::anisotropic) { // of walls
        law.kinetic_backward = 0.6;
        law.kinetic_sideways = 0.2;
    }
    return law;
}
std::vector<ContactLaw> all_laws() {
    std::vector<ContactLaw> laws;
    for (std::size_t normal = 0; normal < std::size(contact_normal_names); ++normal)
        for (std::size_t friction = 0; friction < std::size(contact_friction_names); ++friction)
            laws.push_back(law_of(static_cast<ContactNormal>(normal), static_cast<ContactFriction>(friction)));
    return laws;
}
std::string text(const InteractionExample& e, const ContactLaw& law) {
    return e.name + ", " + std::string(nth(contact_normal_names, law.normal)) + ", friction " +
           std::string(nth(contact_friction_names, law.friction));
}

/// Energy in the springs of contacts and walls, J, and whether anything touches.
struct Springs {
    double energy = 0;
    bool touch = false;
};
Springs springs(const Meeting& stage) {
    Springs all;
    if (stage.contacts) {
        const ContactFigures f = stage.contacts->figures();
        all = {f.elastic_energy.value(), f.active > 0};
    }
    for (std::size_t g = 0; g < stage.around.wall_contacts.size(); ++g)
        for (std::size_t w = 0; stage.around.wall_contacts[g] && w < stage.around.walls->count(); ++w) {
            const WallFigures f = stage.around.wall_contacts[g]->figures({0, 0}, static_cast<int>(w));
            all.energy += f.elastic_energy;
            all.touch |= f.touching > 0;
        }
    return all;
}

/// A scene after what is in it has met and parted again.
struct Met : Meeting {
    Met(const SceneSpec& scene, const std::string& what, std::int64_t times = 1) : Meeting(scene) {
        advance(1);
        EXPECT_FALSE(springs(*this).touch) << what << ", at the start";
        const std::int64_t part = times * 40, most = 250;
        bool touch = false;
        while (!(touch && !springs(*this).touch) && clock.done() < most * part) {
            advance(part);
            touch |= springs(*this).touch;
        }
        EXPECT_TRUE(touch) << what;
        EXPECT_LT(clock.done(), most * part) << what << ", not parted";
    }
};

TEST(Interactions, AreTheSameForASceneThatIsTurnedAndShifted) {
    for (const InteractionExample& e : test::interaction_examples())
        for (const ContactLaw& law : all_laws()) {
            const Turn turn{e.can_turn ? rotation(Vec3d{0.7, -1.3, 2.1}) : no_turn, {0.3, -0.8, 1.1}};
            const Met here(e.scene(law, Turn{}), text(e, law)), there(e.scene(law, turn), text(e, law));
            double most = 0;
            for (std::size_t i = 0; i < here.rods->local().size(); ++i) {
                const auto expected = turn.state(here.state(i)), found = there.state(i);
                for (std::size_t k = 0; k < expected.size(); ++k)
                    most = std::max({most, norm(lane(expected[k].position, 0) - lane(found[k].position, 0)),
                                     0.01 * norm(lane(expected[k].velocity, 0) - lane(found[k].velocity, 0))});
            }
            EXPECT_LT(most, 1e-9) << text(e, law);
        }
}

TEST(Interactions, KeepTheMomentaOfWhatIsFree) {
    for (const InteractionExample& e : test::interaction_examples()) {
        if (e.has_walls) continue;
        for (const ContactLaw& law : all_laws()) {
            const SceneSpec scene = e.scene(law, Turn{});
            const test::Momenta before = Meeting(scene).momenta(), after = Met(scene, text(e, law)).momenta();
            EXPECT_LT(norm(after.linear - before.linear), 1e-12 * norm(before.linear)) << text(e, law);
            EXPECT_LT(norm(after.angular - before.angular), 1e-12 * (norm(before.angular) + 0.5 * norm(before.linear)))
                << text(e, law);
        }
    }
}

// What an elastic meeting changes of the energy is the error of the step, of second order.
TEST(Interactions, KeepTheEnergyWhereNothingTakesAny) {
    for (const InteractionExample& e : test::interaction_examples()) {
        for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
            ContactLaw law = law_of(normal, ContactFriction::none);
            law.damping = 0;
            const auto changed = [&](int times) {
                SceneSpec scene = e.scene(law, Turn{});
                scene.time.dt /= times;
                const double before = Meeting(scene).energy();
                return std::abs(Met(scene, text(e, law), times).energy() - before) / before;
            };
            const double coarse = changed(1), fine = changed(4);
            EXPECT_LT(fine, e.lost) << text(e, law) << ": " << coarse;
        }
    }
}

// With friction or dashpots there is less energy after a meeting, and at no time more than at the start.
TEST(Interactions, TakeEnergyWhereTheyDissipate) {
    for (const InteractionExample& e : test::interaction_examples())
        for (const ContactLaw& law : all_laws()) {
            Meeting stage(e.scene(law, Turn{}));
            const double start = stage.energy();
            double most = start;
            for (int part = 0; part < 400; ++part) {
                stage.advance(meeting_steps / 400);
                most = std::max(most, stage.energy() + springs(stage).energy);
            }
            EXPECT_LT(most, start * (1 + 2e-4)) << text(e, law);
            EXPECT_LT(stage.energy(), start * (1 - 1e-3)) << text(e, law);
        }
}

TEST(Interactions, AskForShorterStepsTheStifferTheyAre) {
    for (const InteractionExample& e : test::interaction_examples())
        for (ContactLaw law : all_laws()) {
            const auto limit = [&](double stiffness, double damping) {
                law.stiffness = stiffness;
                law.damping = damping;
                law.tangential_damping = 0;
                SceneSpec scene = e.scene(law, Turn{});
                scene.time.force_dt = true;
                const auto groups = make_groups(scene);
                const Plan plan = make_plan(scene, groups, {});
                for (const TimeLimit& l : plan.groups[0].limits)
                    if (l.mode == "contact") return l.dt;
                return HUGE_VAL;
            };
            const double soft = limit(1e5, 0);
            EXPECT_NEAR(limit(1e7, 0), 0.1 * soft, 1e-3 * soft) << text(e, law);
            EXPECT_LT(limit(1e5, 1e5), soft) << text(e, law);
        }
}

} // namespace
} // namespace skein
