// Laws say what scenes ask of them; energy goes where it is said to go; one lane does as eight do.
#include "contact/contact_limits.hpp"

#include "skein/core/error.hpp"

#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

struct Bounce {
    double restitution, time;
};
/// Two bodies of effective mass m, head on at a speed, in small steps (symplectic, second order).
Bounce bounce(const ContactLaw& law, double m, double speed) {
    const ContactNumbers<double> n = law.numbers();
    const ContactNumbers<Pack<1>> numbers{
        n.stiffness,          n.damping,   n.static_friction, n.kinetic_friction, n.tangential_stiffness,
        n.tangential_damping, n.slip_speed};
    const Vec3d none{0, 0, 0};
    const auto force = [&](double overlap, double v) {
        ContactMemory<Pack<1>> memory{};
        return contact_force<1>({law.normal, ContactFriction::none}, numbers,
                                {broadcast<1>(Vec3d{1, 0, 0}), 2 - overlap, 1.0, 1.0, broadcast<1>(Vec3d{v, 0, 0}),
                                 broadcast<1>(none), broadcast<1>(none), broadcast<1>(none)},
                                0, memory)
            .normal[0];
    };
    double g = 0, v = speed, t = 0;
    const double h = 1e-5;
    while (t < 5 && (t == 0 || force(g, v) > 0 || v > 0)) {
        const double half = v - 0.5 * h * force(g, v) / m;
        g += h * half;
        v = half - 0.5 * h * force(g, half) / m;
        t += h;
    }
    return {-v / speed, t};
}

TEST(ContactLaw, BouncesAsItIsTold) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const double e : {0.05, 0.24, 0.5, 0.9, 1.0}) {
            const double mass = 0.3, time = 0.4, speed = 0.02;
            const ContactLaw law =
                ContactLaw{.normal = normal, .restitution = e, .collision_time = time, .collision_speed = speed}
                    .resolved(mass);
            const Bounce b = bounce(law, mass, speed);
            EXPECT_NEAR(b.restitution, e, 1e-3) << static_cast<int>(normal);
            EXPECT_NEAR(b.time, time, 5e-3 * time) << static_cast<int>(normal) << " " << e;
        }
    const ContactLaw as_it_is{.stiffness = 3, .damping = 2};
    EXPECT_EQ(as_it_is.resolved(1).stiffness, 3);
    EXPECT_THROW((ContactLaw{.restitution = 0.5}.resolved(1)), InputError);
}

/// A body held by nothing but the spring of a contact: swinging dissipates nothing, sliding all of its work.
TEST(ContactLaw, RubsOnlyWhereItSlides) {
    const double mass = 0.2, overlap = 0.01;
    const Vec3d none{0, 0, 0};
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        const ContactLaw law{.normal = normal,
                             .stiffness = 1e4,
                             .friction = ContactFriction::memory,
                             .static_friction = 0.5,
                             .kinetic_friction = 0.5};
        const auto numbers = law.numbers().as<Pack<1>>();
        const double stiffness =
                         numbers.tangential_stiffness[0] * (normal == ContactNormal::hertz ? std::sqrt(overlap) : 1),
                     h = 0.1 / std::sqrt(stiffness / mass);
        ContactMemory<Pack<1>> memory{};
        const auto step = [&](double v) {
            return contact_force<1>({normal, law.friction}, numbers,
                                    {broadcast<1>(Vec3d{1, 0, 0}), 2 - overlap, 1.0, 1.0, broadcast<1>(Vec3d{0, v, 0}),
                                     broadcast<1>(none), broadcast<1>(none), broadcast<1>(none)},
                                    h, memory);
        };
        double v = 0.01, friction_work = 0;
        const double energy = 0.5 * mass * v * v;
        for (int i = 0; i < 20000; ++i) {
            const auto f = step(v);
            friction_work += f.friction_work[0];
            v += h * f.on_1.y[0] / mass;
        }
        EXPECT_LT(std::abs(friction_work), 1e-6 * energy);
        EXPECT_NEAR(0.5 * mass * v * v + memory.spring.energy()[0], energy, 0.2 * energy) << "it swings on";

        const double before = memory.spring.energy()[0];
        double slid = 0, drag = 0;
        friction_work = 0;
        for (int i = 0; i < 20000; ++i) {
            const auto f = step(1.0);
            friction_work += f.friction_work[0];
            slid += h;
            drag = -f.on_1.y[0];
        }
        EXPECT_NEAR(friction_work + memory.spring.energy()[0] - before, drag * slid,
                    1e-2 * drag * slid); // the beginning sticks
    }
}

/// Rates that change their sign from step to step: the energy budget closes all the same.
TEST(ContactLaw, DashpotsDampWhatIsThere) {
    const double mass = 0.2, overlap = 0.01, h = 1e-3;
    const Vec3d none{0, 0, 0};
    const double damping = 1.5 * mass / h; // v <- -v/2
    for (const bool along : {false, true})
        for (const double friction : {0.0, 1e9}) {
            ContactLaw law{.normal = ContactNormal::linear,
                           .stiffness = 1e3,
                           .friction = ContactFriction::memory,
                           .static_friction = friction};
            (along ? law.tangential_damping : law.damping) = damping;
            const auto numbers = law.numbers().as<Pack<1>>();
            ContactMemory<Pack<1>> memory{};
            double v = 0.01, viscous_work = 0, friction_work = 0, elastic_energy = 0;
            const double energy = 0.5 * mass * v * v;
            for (int i = 0; i < 60; ++i) {
                const auto f = contact_force<1>({law.normal, law.friction}, numbers,
                                                {broadcast<1>(Vec3d{1, 0, 0}), 2 - overlap, 1.0, 1.0,
                                                 broadcast<1>(along ? Vec3d{0, v, 0} : Vec3d{v, 0, 0}),
                                                 broadcast<1>(none), broadcast<1>(none), broadcast<1>(none)},
                                                h, memory);
                viscous_work += f.viscous_work[0];
                friction_work += f.friction_work[0];
                elastic_energy = memory.spring.energy()[0];
                v += h * (along ? f.on_1.y[0] : f.on_1.x[0] + law.stiffness * overlap) /
                     mass; // the spring holds what presses
            }
            if (along && friction == 0) {
                EXPECT_EQ(viscous_work, 0);
                EXPECT_EQ(friction_work, 0);
                EXPECT_EQ(elastic_energy, 0);
            } else {
                EXPECT_NEAR(viscous_work + friction_work + elastic_energy + 0.5 * mass * v * v, energy, 1e-6 * energy);
                EXPECT_NEAR(viscous_work, energy, 1e-2 * energy);
            }
        }
}

TEST(ContactLaw, BeginsSoftlyAndWithoutFriction) {
    const ContactLaw law{.stiffness = 1e6,
                         .damping = 1e3,
                         .friction = ContactFriction::memory,
                         .static_friction = 0.4,
                         .soft_until = 0.2,
                         .soft_stiffness = 1500,
                         .soft_damping = 100,
                         .friction_from = 0.5};
    EXPECT_EQ(law.at(0.1).stiffness, 1500);
    EXPECT_EQ(law.at(0.1).damping, 100);
    EXPECT_EQ(law.at(0.2).stiffness, 1e6);
    EXPECT_EQ(law.at(0.3).static_friction, 0);
    EXPECT_EQ(law.at(0.3).kinetic(), 0);
    EXPECT_EQ(law.at(0.6).kinetic(), 0.4) << "as the static one";
    EXPECT_EQ((ContactLaw{.static_friction = 0.4, .kinetic_friction = 0}.kinetic()), 0);
    EXPECT_THROW(ContactLaws(2, {law, law, law, ContactLaw{}}), InputError) << "kinds of friction differ";
}

template <int W> struct Drawn {
    ContactNumbers<Pack<W>> law;
    ContactState<Pack<W>> state;
    ContactMemory<Pack<W>> memory;
};
template <int W> Drawn<W> draw(unsigned seed, int first) {
    Drawn<W> d;
    for (int l = 0; l < W; ++l) {
        std::mt19937 random(seed * 8 + static_cast<unsigned>(first + l));
        std::uniform_real_distribution<double> uniform(0, 1);
        std::normal_distribution<double> normal;
        const auto vector = [&] { return Vec3d{normal(random), normal(random), normal(random)}; };
        const Vec3d n = vector();
        set_lane(d.state.normal, l, (1 / norm(n)) * n);
        d.state.radius_1.set(l, 0.5 + uniform(random));
        d.state.radius_2.set(l, 0.5 + uniform(random));
        d.state.distance.set(l, 2 * uniform(random));
        for (Vec3<Pack<W>>* v : {&d.state.velocity_1, &d.state.spin_1, &d.state.velocity_2, &d.state.spin_2,
                                 &d.memory.spring.x, &d.memory.viscous_part})
            set_lane(*v, l, vector());
        d.memory.spring.stiffness.set(l, uniform(random));
        d.memory.weight.set(l, uniform(random));
        for (Pack<W>* p : {&d.law.stiffness, &d.law.damping, &d.law.static_friction, &d.law.kinetic_friction,
                           &d.law.tangential_stiffness, &d.law.tangential_damping, &d.law.slip_speed})
            p->set(l, uniform(random));
    }
    return d;
}

TEST(ContactForce, IsTheSameInOneLaneAndInEight) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const ContactFriction friction :
             {ContactFriction::none, ContactFriction::memory, ContactFriction::regularised, ContactFriction::published})
            for (unsigned seed = 0; seed < 100; ++seed) {
                auto eight = draw<8>(seed, 0);
                const auto all = contact_force<8>({normal, friction}, eight.law, eight.state, 0.1, eight.memory);
                for (int l = 0; l < 8; ++l) {
                    auto one = draw<1>(seed, l);
                    const auto f = contact_force<1>({normal, friction}, one.law, one.state, 0.1, one.memory);
                    ASSERT_EQ(norm(lane(all.on_1, l) - lane(f.on_1, 0)), 0);
                    ASSERT_EQ(norm(lane(all.moment, l) - lane(f.moment, 0)), 0);
                    ASSERT_EQ(norm(lane(eight.memory.spring.x, l) - lane(one.memory.spring.x, 0)), 0);
                    ASSERT_EQ(all.elastic_energy[l], f.elastic_energy[0]);
                    ASSERT_EQ(all.friction_work[l], f.friction_work[0]);
                    ASSERT_EQ(all.viscous_work[l], f.viscous_work[0]);
                }
            }
}

TEST(ContactForce, OfPublishedFriction) {
    const ContactNumbers<Pack<1>> law{100.0, 0.0, 0.0, 0.4, 0.0, 0.0, 1e-3};
    const auto drag = [&](double speed) {
        const Vec3d none{0, 0, 0};
        ContactMemory<Pack<1>> memory{};
        const ContactState<Pack<1>> state{broadcast<1>(Vec3d{0, 0, 1}),
                                          1.9,
                                          1.0,
                                          1.0,
                                          broadcast<1>(Vec3d{speed, 0, 0}),
                                          broadcast<1>(none),
                                          broadcast<1>(none),
                                          broadcast<1>(none)};
        return -contact_force<1>({ContactNormal::linear, ContactFriction::published}, law, state, 1e-3, memory)
                    .on_1.x[0];
    };
    EXPECT_EQ(drag(0), 0);
    EXPECT_EQ(drag(0.9e-3), 0);
    EXPECT_NEAR(drag(1.25e-3), 0.5 * 0.4 * 10, 1e-9);
    EXPECT_NEAR(drag(2e-3), 0.4 * 10, 1e-9);
    EXPECT_NEAR(drag(-1), -0.4 * 10, 1e-9);
}

/// A mass on another, pushed to and fro and pressed more and less: the work on the contact becomes energy of springs,
/// or friction or viscous work.
TEST(ContactForce, AccountsForItsEnergy) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        const ContactNumbers<Pack<1>> law{1e4, 5.0, 0.5, 0.4, 8e3, 3.0, 0.0};
        ContactMemory<Pack<1>> memory{};
        double done = 0, lost = 0, elastic_energy = 0, friction_work = 0;
        const double h = 2e-6, radius = 0.1;
        Vec3d force_before{0, 0, 0};
        for (int step = 0; step <= 500000; ++step) {
            const double t = h * step,
                         overlap = 0.02 * std::sin(M_PI * t) + 0.004 * std::sin(20 * t) * std::sin(M_PI * t), dt = 1e-7;
            const double rate = (0.02 * std::sin(M_PI * (t + dt)) +
                                 0.004 * std::sin(20 * (t + dt)) * std::sin(M_PI * (t + dt)) - overlap) /
                                dt;
            const Vec3d v{0.05 * std::sin(15 * t), 0.03 * std::cos(40 * t), rate}, none{0, 0, 0};
            const ContactState<Pack<1>> state{
                broadcast<1>(Vec3d{0, 0, 1}), 2 * radius - overlap, radius, radius, broadcast<1>(v), broadcast<1>(none),
                broadcast<1>(none),           broadcast<1>(none)};
            const auto f = contact_force<1>({normal, ContactFriction::memory}, law, state, h, memory);
            const Vec3d force = lane(f.on_1, 0);
            done -= h * dot(0.5 * (force + force_before), v);
            force_before = force;
            lost += f.friction_work[0] + f.viscous_work[0];
            friction_work += f.friction_work[0];
            elastic_energy = f.elastic_energy[0];
        }
        EXPECT_GT(friction_work, 0.1 * done);
        EXPECT_NEAR(done, elastic_energy + lost, 2e-3 * done) << static_cast<int>(normal);
    }
}

/// Two spheres that rub against each other, `pulled` with a share of what friction can hold: the slip after so many
/// steps.
struct Rubbing {
    double mass = 0.01, h = 1e-4, overlap = 0.01;
    ContactLaw law{.normal = ContactNormal::linear,
                   .stiffness = 1e3,
                   .friction = ContactFriction::regularised,
                   .static_friction = 0.5,
                   .kinetic_friction = 0.4};
    double most() const { return law.kinetic_friction * law.stiffness * overlap; } ///< N

    double slip_after(double slip, double pulled, int steps, int contacts = 1) const {
        auto of_law = law.numbers();
        of_law.set_spring(h, 2 * 4 / mass);
        const auto numbers = of_law.as<Pack<1>>();
        const Vec3d none{0, 0, 0};
        ContactMemory<Pack<1>> memory{};
        for (int n = 0; n < steps; ++n) {
            const ContactState<Pack<1>> state{broadcast<1>(Vec3d{0, 0, 1}),
                                              0.2 - overlap,
                                              0.1,
                                              0.1,
                                              broadcast<1>(Vec3d{slip, 0, 0}),
                                              broadcast<1>(none),
                                              broadcast<1>(none),
                                              broadcast<1>(none)};
            const double friction = contact_force<1>({law.normal, law.friction}, numbers, state, h, memory).on_1.x[0];
            slip += 2 * h / mass * contacts * (friction + pulled * most());
        }
        return slip;
    }
};

/// At any slip speed, with as many contacts at once as the spring of the step allows for: what is pulled by half of
/// what friction holds creeps at half of the slip speed, what is let go comes to rest, and what is pulled by more
/// slides against all of it.
TEST(ContactForce, OfRegularisedFrictionIsSteadyAtAnySlipSpeed) {
    for (const double slip_speed : {1e-12, 1e-9, 1e-6, 1e-3, 1.0})
        for (const int contacts : {1, 2, 4}) {
            Rubbing spheres;
            spheres.law.slip_speed = slip_speed;
            const int steps = slip_speed < 1 ? 3000 : 30000; // a dashpot that is soft for its step takes its time
            EXPECT_NEAR(spheres.slip_after(0.01, 0.5, steps, contacts), 0.5 * slip_speed, 1e-9 * slip_speed + 1e-15)
                << slip_speed << " " << contacts;
            EXPECT_NEAR(spheres.slip_after(0.01, 0, steps, contacts), 0, 1e-9 * slip_speed + 1e-15) << slip_speed;
            const double from = 10 * slip_speed + 0.1,
                         gained = 2 * spheres.h / spheres.mass * contacts * spheres.most();
            EXPECT_NEAR(spheres.slip_after(from, 2, 3000, contacts), from + 3000 * gained, 20 * gained) << slip_speed;
        }
}

TEST(ContactForce, OfPublishedFrictionTurnsSlipRoundBelowTheLeastSlipSpeed) {
    Rubbing spheres;
    spheres.law.friction = ContactFriction::published;
    const ContactMobility sphere{.normal = 1 / spheres.mass, .tangential = 1 / spheres.mass};
    const double force = spheres.law.stiffness * spheres.overlap,
                 least = least_slip_speed(sphere, spheres.law, force, 2, spheres.h);
    EXPECT_GT(least, 0);
    // Slip falls to where friction begins; a rise that is too steep turns what is left of it round, which ends below.
    const auto end = [&](double slip_speed) {
        spheres.law.slip_speed = slip_speed;
        return spheres.slip_after(1.2 * slip_speed, 0, 1000) / slip_speed;
    };
    EXPECT_NEAR(end(2.1 * least), 1, 1e-6);
    EXPECT_LT(end(0.9 * least), 0.8);
    for (const ContactFriction friction : {ContactFriction::memory, ContactFriction::regularised}) {
        spheres.law.friction = friction;
        EXPECT_EQ(least_slip_speed(sphere, spheres.law, force, 2, spheres.h), 0);
    }
}

/// Two spheres in contact that stick, with nothing but the spring of friction.
struct Sticking {
    ContactNumbers<Pack<1>> law{1e4, 0.0, 1e6, 1e6, 8e3, 0.0, 0.0};
    ContactNormal normal = ContactNormal::hertz;
    double h = 1e-3;
    ContactMemory<Pack<1>> memory{};
    Vec3d axis{0, 0, 1}; ///< from 1 to 2

    ContactForce<Pack<1>> step(double overlap, const Vec3d& slip, const Vec3d& spin_1 = {0, 0, 0},
                               const Vec3d& spin_2 = {0, 0, 0}) {
        const double radius = 0.1;
        const ContactState<Pack<1>> state{
            broadcast<1>(axis),    2 * radius - overlap, radius, radius, broadcast<1>(slip), broadcast<1>(spin_1),
            broadcast<1>(Vec3d{}), broadcast<1>(spin_2)};
        return contact_force<1>({normal, ContactFriction::memory}, law, state, h, memory);
    }
    Vec3d spring() const { return lane(memory.spring.x, 0); }
    double energy() const { return memory.spring.energy()[0]; }
};

TEST(ContactForce, OfASpringOfFrictionGainsNoEnergyAsTheContactStiffens) {
    Sticking contact;
    contact.step(0.01, {2.0, 1.0, 0.0});
    const double before = contact.energy();
    const Vec3d pull = lane(contact.step(0.01, {}).on_1, 0);
    const auto pressed = contact.step(0.04, {});
    EXPECT_NEAR(pressed.on_1.x[0], pull.x, 1e-12 * std::abs(pull.x)) << "it pulls as before";
    EXPECT_NEAR(pressed.on_1.y[0], pull.y, 1e-12 * std::abs(pull.y));
    EXPECT_NEAR(contact.energy(), before / 2, 1e-12 * before) << "at twice the stiffness half of the length";
    EXPECT_NEAR(pressed.friction_work[0], before / 2, 1e-12 * before);
    const auto released = contact.step(0.01, {});
    EXPECT_NEAR(released.on_1.x[0], pull.x / 2, 1e-12 * std::abs(pull.x)) << "as it softens its length stays";
    EXPECT_NEAR(contact.energy(), before / 4, 1e-12 * before);
}

/// Whatever the way through overlap and slip, one that ends where it began takes energy: Hertz by ways pressed and
/// released, a linear contact none while it sticks.
TEST(ContactForce, OfASpringOfFrictionTakesEnergyOnEveryClosedWay) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (int trial = 0; trial < 50; ++trial) {
            std::mt19937 random(static_cast<unsigned>(trial));
            std::uniform_real_distribution<double> uniform(-1, 1);
            const double depth = 0.5 * uniform(random), phase = M_PI * uniform(random), across = uniform(random);
            Sticking contact{.normal = normal};
            contact.law.static_friction = contact.law.kinetic_friction = 1e9;
            const int steps = 2000;
            double done = 0, scale = 0;
            Vec3d force_before{};
            for (int n = 0; n < 3 * steps; ++n) {
                const double angle = 2 * M_PI * n / steps, rate = 2 * M_PI / (steps * contact.h);
                const Vec3d slip{0.01 * rate * std::cos(angle), 0.01 * across * rate * std::sin(angle), 0};
                const auto f = contact.step(0.02 * (1 + depth * std::sin(angle + phase)), slip);
                const Vec3d force{f.on_1.x[0], f.on_1.y[0], 0};
                const double work = -0.5 * contact.h * dot(force + force_before, slip);
                force_before = force;
                if (n < steps) continue; // from the second turn on it is periodic in a linear contact
                done += work;
                scale += std::abs(work);
            }
            if (normal == ContactNormal::linear) EXPECT_NEAR(done, 0, 2e-3 * scale) << trial;
            else EXPECT_GT(done, -2e-3 * scale) << trial;
        }
}

/// Two bodies that turn as one about their normal take the spring with them; of two that roll on each other none is
/// turned.
TEST(ContactForce, OfASpringOfFrictionTurnsWithItsBodies) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        Sticking contact{.normal = normal};
        contact.step(0.01, {2.0, 0.0, 0.0});
        const double length = norm(contact.spring()), energy = contact.energy();
        const double turn = 1.25; // in all, about the normal
        const int steps = 500;
        for (int n = 0; n < steps; ++n)
            contact.step(0.01, {}, {0, 0, turn / (steps * contact.h)}, {0, 0, turn / (steps * contact.h)});
        EXPECT_NEAR(contact.spring().x, length * std::cos(turn), 1e-6 * length);
        EXPECT_NEAR(contact.spring().y, length * std::sin(turn), 1e-6 * length);
        EXPECT_NEAR(contact.energy(), energy, 1e-12 * energy);
        for (int n = 0; n < steps; ++n)
            contact.step(0.01, {}, {0, 0, turn / (steps * contact.h)}, {0, 0, -turn / (steps * contact.h)});
        EXPECT_NEAR(contact.spring().x, length * std::cos(turn), 1e-6 * length) << "one against the other";
    }
}

} // namespace
} // namespace skein
