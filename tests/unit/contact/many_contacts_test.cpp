// A crowd of moving rods: the same loads for any threads, for any share of owned rods, and after going on from what was kept.
#include "contact/contacts.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace skein {
namespace {

/// Rods at random places, all on their ways, some of them large; some lie side by side.
struct Crowd {
    Capsules capsules;
    Crowd(int rods, int elements) {
        std::mt19937 random(4);
        std::uniform_real_distribution<double> uniform;
        const auto point = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
        Vec3d at = point(), along = point();
        for (int r = 0; r < rods; ++r) {
            const double size = r % 10 == 0 ? 3 : 1;
            if (r % 5 != 0) along = point() - point(), at = point();
            else at += Vec3d{0, 0.015, 0.001};
            capsules.first_slot.push_back(static_cast<std::int32_t>(capsules.node.size()));
            capsules.skip.push_back(r % 3 ? -1 : 1);
            capsules.material.push_back(r % 2);
            for (int k = 0; k <= elements; ++k) {
                const Vec3d bent =
                    at + (0.4 * size / elements * k / norm(along)) * along + Vec3d{0, 0, 0.02 * size * std::cos(3.0 * k)};
                capsules.node.push_back({bent, k < elements ? 0.01 * size : -1});
                const Vec3d velocity = 0.3 * (point() - point());
                capsules.motion.push_back({.velocity = velocity, .spin = point() - point()});
                capsules.rod.push_back(r);
            }
        }
        capsules.first_slot.push_back(static_cast<std::int32_t>(capsules.node.size()));
    }
    void move(double h) {
        for (std::size_t i = 0; i < capsules.slots(); ++i) capsules.node[i].position += h * capsules.motion[i].velocity;
    }
};

ContactLaws laws() {
    ContactLaw law{.stiffness = 1e5,
                   .damping = 20,
                   .friction = ContactFriction::memory,
                   .static_friction = 0.5,
                   .kinetic_friction = 0.4,
                   .tangential_damping = 5},
        other = law;
    other.stiffness = 3e4;
    return ContactLaws(2, {law, other, other, law});
}

using Loads = AlignedVector<ContactLoad>;

/// Rods whose loads differ in any bit; of the rods asked for.
int different(const Crowd& crowd, const Loads& x, const Contacts& of_x, const Loads& y, const Contacts& of_y,
              const std::vector<std::uint8_t>& asked) {
    int count = 0;
    for (std::size_t rod = 0; rod + 1 < crowd.capsules.first_slot.size(); ++rod) {
        if (!asked[rod]) continue;
        bool same = of_x.touched_rods()[rod] == of_y.touched_rods()[rod];
        for (auto s = static_cast<std::size_t>(crowd.capsules.first_slot[rod]);
             of_x.touched_rods()[rod] && s < static_cast<std::size_t>(crowd.capsules.first_slot[rod + 1]); ++s)
            same &= std::memcmp(&x[s].force, &y[s].force, sizeof(Vec3d)) == 0 &&
                    std::memcmp(&x[s].couple, &y[s].couple, sizeof(Vec3d)) == 0;
        count += !same;
    }
    return count;
}

TEST(ManyContacts, AreTheSameForAnyThreadsAndOwners) {
    constexpr int rods = 300;
    Crowd crowd(rods, 6);
    const Threads one(1), three(3), shuffled(2, 5);
    std::vector<std::uint8_t> all(rods, 1), mine(rods, 0), others(rods, 0);
    for (int r = 0; r < rods; ++r) (r % 7 < 3 ? mine : others)[static_cast<std::size_t>(r)] = 1;
    Contacts whole(crowd.capsules, laws(), one), threaded(crowd.capsules, laws(), three), first(crowd.capsules, laws(), one, mine),
        second(crowd.capsules, laws(), three, others);
    Contacts in_disorder(crowd.capsules, laws(), shuffled);
    Loads x, y, z, w, v;
    for (int step = 0; step < 200; ++step) {
        crowd.move(1e-4);
        whole.evaluate(crowd.capsules, 0, 1e-4, x);
        threaded.evaluate(crowd.capsules, 0, 1e-4, y);
        in_disorder.evaluate(crowd.capsules, 0, 1e-4, v);
        first.evaluate(crowd.capsules, 0, 1e-4, z);
        second.evaluate(crowd.capsules, 0, 1e-4, w);
        ASSERT_EQ(different(crowd, x, whole, y, threaded, all), 0) << step;
        ASSERT_EQ(different(crowd, x, whole, v, in_disorder, all), 0) << step;
        ASSERT_EQ(different(crowd, x, whole, z, first, mine), 0) << step;
        ASSERT_EQ(different(crowd, x, whole, w, second, others), 0) << step;
    }
    const ContactFigures f = whole.figures(), t = threaded.figures(), a = first.figures(), b = second.figures();
    EXPECT_GT(f.active, 100);
    EXPECT_GT(f.renewals, 2);
    EXPECT_EQ(f.active, a.active + b.active);
    EXPECT_GE(f.listed, 1);
    EXPECT_EQ(f.listed, a.listed + b.listed);
    for (const ContactFigures& other : {t, a, b}) {
        EXPECT_EQ(f.renewals, other.renewals);
        EXPECT_EQ(f.skin, other.skin);
    }
    EXPECT_EQ(f.deepest, std::max(a.deepest, b.deepest));
    EXPECT_EQ(f.stiffest, std::max(a.stiffest, b.stiffest));
    EXPECT_NEAR(f.stored, a.stored + b.stored, 1e-12 * f.stored);
    EXPECT_NEAR(f.rubbed, a.rubbed + b.rubbed, 1e-12 * f.rubbed);
    EXPECT_NEAR(f.damped, a.damped + b.damped, 1e-12 * f.damped);
    EXPECT_GT(f.rubbed, 0);
    EXPECT_GT(f.damped, 0);
    EXPECT_EQ(f.stored, t.stored);
    EXPECT_EQ(f.rubbed, t.rubbed);
    EXPECT_EQ(f.damped, t.damped);
}

TEST(ManyContacts, GoOnFromWhatWasKept) {
    constexpr int rods = 200;
    Crowd crowd(rods, 6);
    const Threads one(1);
    const std::vector<std::uint8_t> all(rods, 1);
    Contacts whole(crowd.capsules, laws(), one);
    Loads x, y;
    for (int step = 0; step < 57; ++step) crowd.move(1e-4), whole.evaluate(crowd.capsules, 0, 1e-4, x);
    const std::vector<KeptContact> kept = whole.kept();
    EXPECT_EQ(static_cast<std::int64_t>(kept.size()), whole.figures().active);
    Contacts resumed(crowd.capsules, laws(), one);
    resumed.restore(kept);
    const double rubbed = whole.figures().rubbed;
    for (int step = 0; step < 60; ++step) {
        crowd.move(1e-4);
        whole.evaluate(crowd.capsules, 0, 1e-4, x);
        resumed.evaluate(crowd.capsules, 0, 1e-4, y);
        ASSERT_EQ(different(crowd, x, whole, y, resumed, all), 0) << step;
    }
    EXPECT_NE(whole.figures().renewals, resumed.figures().renewals);
    EXPECT_NEAR(whole.figures().rubbed - rubbed, resumed.figures().rubbed, 1e-9 * rubbed);
    Contacts fresh(crowd.capsules, laws(), one);
    fresh.evaluate(crowd.capsules, 0, 1e-4, y);
    EXPECT_GT(different(crowd, x, whole, y, fresh, all), 10) << "springs matter here";
}

} // namespace
} // namespace skein
