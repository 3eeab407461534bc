// A crowd of moving rods: the same loads for any threads, for any share of owned rods, and after going on from what was
// kept.
#include "contact/contacts.hpp"
#include "skein/core/index.hpp"
#include "support/exposed_bodies.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <random>

namespace skein {
namespace {

/// Rods at random places, all on their ways, some of them large; some lie side by side.
struct Crowd {
    test::BodiesByHand bodies;
    std::vector<ExposedMotion> motion;
    std::vector<Exposure*> seen; ///< all move with the crowd

    Crowd(int rods, int elements) {
        std::mt19937 random(4);
        std::uniform_real_distribution<double> uniform;
        const auto point = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
        Vec3d at = point(), along = point();
        for (int r = 0; r < rods; ++r) {
            const double size = r % 10 == 0 ? 3 : 1;
            if (r % 5 != 0) {
                along = point() - point();
                at = point();
            } else at += Vec3d{0, 0.015, 0.001};
            std::vector<Vec3d> nodes;
            for (int k = 0; k <= elements; ++k) {
                nodes.push_back(at + (0.4 * size / elements * k / norm(along)) * along +
                                Vec3d{0, 0, 0.02 * size * std::cos(3.0 * k)});
                const Vec3d velocity = 0.3 * (point() - point());
                motion.push_back({.velocity = velocity, .spin = point() - point()});
            }
            bodies.add(nodes, 0.01 * size, r % 3 ? -1 : 1);
        }
    }
    Exposure exposure(std::span<const std::uint8_t> own = {}) const {
        Exposure all = bodies.exposure(own);
        std::copy(motion.begin(), motion.end(), all.motion.begin());
        return all;
    }
    void move(double h) {
        for (Exposure* all : seen)
            for (std::size_t i = 0; i < all->slots(); ++i) all->node[i].position += h * all->motion[i].velocity;
    }
};

constexpr int rods = 300;

ContactLaws laws() {
    ContactLaw law{.stiffness = 1e5,
                   .damping = 20,
                   .friction = ContactFriction::memory,
                   .static_friction = 0.5,
                   .kinetic_friction = 0.4,
                   .tangential_damping = 5},
        other = law;
    other.stiffness = 3e4;
    std::vector<ContactLaw> between;
    for (int i = 0; i < rods; ++i)
        for (int j = 0; j < rods; ++j) between.push_back((i + j) % 2 ? other : law);
    return ContactLaws(rods, std::move(between));
}

/// Rods whose loads differ in any bit; of the rods asked for.
int different(const Exposure& crowd, const SlotLoads& x, const SlotLoads& y, const std::vector<std::uint8_t>& asked) {
    int count = 0;
    for (std::size_t rod = 0; rod < crowd.window.size(); ++rod) {
        if (!asked[rod]) continue;
        bool same = x.touched[rod] == y.touched[rod];
        for (std::size_t s = crowd.window[rod].first_slot; x.touched[rod] && s < crowd.end_of(rod); ++s)
            same &= std::memcmp(&x.load[s].force, &y.load[s].force, sizeof(Vec3d)) == 0 &&
                    std::memcmp(&x.load[s].couple, &y.load[s].couple, sizeof(Vec3d)) == 0;
        count += !same;
    }
    return count;
}

/// A step of ranks that see each other's bodies as ghosts: partners anew on all of them as soon as one needs it. With
/// `again` they learn that only when they have begun.
struct Rank {
    Exposure bodies;
    Contacts contacts;
    SlotLoads loads = {};
};
void step_together(std::span<Rank* const> ranks, double h, bool again = false) {
    if (again)
        for (Rank* r : ranks)
            if (r->contacts.holds(r->bodies)) r->contacts.begin(r->bodies, 0, h, r->loads.load, true);
    if (again || !std::all_of(ranks.begin(), ranks.end(), [](Rank* r) { return r->contacts.holds(r->bodies); })) {
        std::int64_t inactive = 0;
        for (Rank* r : ranks) {
            r->contacts.prepare_rebuild(r->bodies);
            std::vector<std::uint8_t> wanted(r->bodies.slots());
            inactive += r->contacts.search(r->bodies, wanted);
        }
        for (Rank* r : ranks) {
            std::vector<std::uint32_t> same(r->bodies.slots());
            std::iota(same.begin(), same.end(), 0u);
            r->contacts.finish_rebuild(r->bodies, same, inactive);
            r->loads.load.resize(r->bodies.slots());
        }
    }
    for (Rank* r : ranks) {
        r->contacts.begin(r->bodies, 0, h, r->loads.load, true);
        r->contacts.finish(r->bodies, h, r->loads.load);
        r->loads.touched = r->contacts.touched();
    }
}

TEST(ManyContacts, AreTheSameForAnyThreadsAndOwners) {
    Crowd crowd(rods, 6);
    const Threads one(1), three(3), shuffled(2, 5);
    std::vector<std::uint8_t> all(rods, 1), mine(rods, 0), others(rods, 0);
    for (int r = 0; r < rods; ++r) nth((r % 7 < 3 ? mine : others), r) = 1;
    const ContactScene scene = crowd.bodies.scene(laws());
    Exposure bodies = crowd.exposure();
    Rank first_rank{crowd.exposure(mine), Contacts(scene, one)},
        second_rank{crowd.exposure(others), Contacts(scene, three)};
    Rank* const ranks[] = {&first_rank, &second_rank};
    const Contacts &first = first_rank.contacts, &second = second_rank.contacts;
    crowd.seen = {&bodies, &first_rank.bodies, &second_rank.bodies};
    Contacts whole(scene, one), threaded(scene, three), in_disorder(scene, shuffled);
    SlotLoads x, y, v;
    for (int step = 0; step < 200; ++step) {
        crowd.move(1e-4);
        whole.evaluate(bodies, 0, 1e-4, x);
        threaded.evaluate(bodies, 0, 1e-4, y);
        in_disorder.evaluate(bodies, 0, 1e-4, v);
        step_together(ranks, 1e-4);
        ASSERT_EQ(different(bodies, x, y, all), 0) << step;
        ASSERT_EQ(different(bodies, x, v, all), 0) << step;
        ASSERT_EQ(different(bodies, x, first_rank.loads, mine), 0) << step;
        ASSERT_EQ(different(bodies, x, second_rank.loads, others), 0) << step;
    }
    const ContactFigures f = whole.figures(), t = threaded.figures(), a = first.figures(), b = second.figures();
    EXPECT_GT(f.active, 100);
    EXPECT_GT(f.rebuilds, 2);
    EXPECT_EQ(f.active, a.active + b.active);
    EXPECT_GE(f.candidates, 1);
    EXPECT_EQ(f.candidates, a.candidates + b.candidates);
    for (const ContactFigures& other : {t, a, b}) {
        EXPECT_EQ(f.rebuilds, other.rebuilds);
        EXPECT_EQ(f.skin, other.skin);
    }
    EXPECT_EQ(f.max_overlap, std::max(a.max_overlap, b.max_overlap));
    EXPECT_EQ(f.max_stiffness, std::max(a.max_stiffness, b.max_stiffness));
    const auto of_both = [](BinnedTotal sum, const BinnedTotal& other) {
        sum.add(other);
        return sum;
    };
    EXPECT_EQ(f.elastic_energy, of_both(a.elastic_energy, b.elastic_energy));
    EXPECT_EQ(f.friction_work, of_both(a.friction_work, b.friction_work));
    EXPECT_EQ(f.viscous_work, of_both(a.viscous_work, b.viscous_work));
    EXPECT_GT(f.friction_work.value(), 0);
    EXPECT_GT(f.viscous_work.value(), 0);
    EXPECT_EQ(f.elastic_energy, t.elastic_energy);
    EXPECT_EQ(f.friction_work, t.friction_work);
    EXPECT_EQ(f.viscous_work, t.viscous_work);
}

TEST(ManyContacts, MayBeginAStepAnew) {
    Crowd crowd(rods, 6);
    const Threads one(1), three(3);
    std::vector<std::uint8_t> all(rods, 1), first(rods, 0),
        second(rods, 0); // each has blocks without ghosts of its own
    for (int r = 0; r < rods; ++r) nth((r < rods / 2 ? first : second), r) = 1;
    const ContactScene scene = crowd.bodies.scene(laws());
    Exposure bodies = crowd.exposure();
    Rank alone{crowd.exposure(), Contacts(scene, three)}, half{crowd.exposure(first), Contacts(scene, one)},
        other{crowd.exposure(second), Contacts(scene, one)};
    Rank *const by_itself[] = {&alone}, *const both[] = {&half, &other};
    crowd.seen = {&bodies, &alone.bodies, &half.bodies, &other.bodies};
    Contacts whole(scene, one);
    SlotLoads x;
    for (int step = 0; step < 100; ++step) {
        crowd.move(1e-4);
        whole.evaluate(bodies, 0, 1e-4, x);
        step_together(by_itself, 1e-4, step % 3 == 2);
        step_together(both, 1e-4, step % 5 == 4);
        ASSERT_EQ(different(bodies, x, alone.loads, all), 0) << step;
        ASSERT_EQ(different(bodies, x, half.loads, first), 0) << step;
        ASSERT_EQ(different(bodies, x, other.loads, second), 0) << step;
    }
    EXPECT_GT(whole.figures().friction_work.value(), 0);
    EXPECT_EQ(whole.figures().friction_work, alone.contacts.figures().friction_work);
}

TEST(ManyContacts, GoOnFromWhatWasKept) {
    Crowd crowd(rods, 6);
    const Threads one(1);
    const std::vector<std::uint8_t> all(rods, 1);
    const ContactScene scene = crowd.bodies.scene(laws());
    Exposure bodies = crowd.exposure();
    crowd.seen = {&bodies};
    Contacts whole(scene, one);
    SlotLoads x, y;
    for (int step = 0; step < 57; ++step) {
        crowd.move(1e-4);
        whole.evaluate(bodies, 0, 1e-4, x);
    }
    const std::vector<SavedContact> kept = whole.saved(bodies);
    EXPECT_EQ(static_cast<std::int64_t>(kept.size()), whole.figures().active);
    Contacts resumed(scene, one);
    resumed.restore(kept, whole.figures().friction_work, whole.figures().viscous_work);
    EXPECT_EQ(resumed.saved(bodies).size(), kept.size()) << "before its first step";
    bool one_rebuilds = false;
    for (int step = 0; step < 60; ++step) {
        const auto lists = [&] { return std::pair(whole.figures().rebuilds, resumed.figures().rebuilds); };
        const auto before = lists();
        crowd.move(1e-4);
        whole.evaluate(bodies, 0, 1e-4, x);
        resumed.evaluate(bodies, 0, 1e-4, y);
        ASSERT_EQ(different(bodies, x, y, all), 0) << step;
        const auto now = lists();
        if (step > 0) one_rebuilds |= (now.first > before.first) != (now.second > before.second);
    }
    EXPECT_TRUE(one_rebuilds) << "their lists are not of the same age";
    EXPECT_EQ(whole.figures().friction_work, resumed.figures().friction_work);
    EXPECT_EQ(whole.figures().viscous_work, resumed.figures().viscous_work);
    Contacts fresh(scene, one);
    fresh.evaluate(bodies, 0, 1e-4, y);
    EXPECT_GT(different(bodies, x, y, all), 10) << "springs matter here";
}

} // namespace
} // namespace skein
