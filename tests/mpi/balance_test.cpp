// Rods that gather in a corner: whoever owns them there gives some away when that pays, and all that rods depend on
// goes along.
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "simulation/load_balance.hpp"

#include "simulation/migration.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

namespace skein {
namespace {

/// A heap of rods that touch, and as many that stand apart; rods with muscles at a floor whose friction has springs.
SceneSpec heap_and_field() {
    const ContactLaw law{.stiffness = 200, .damping = 0.1, .friction = ContactFriction::memory, .static_friction = 0.4};
    SceneSpec scene;
    scene.title = "heap and field";
    scene.time = {.duration = 1, .dt = 1e-5};
    scene.contact = ContactSpec{.law = law};
    Wall floor;
    floor.name = "floor";
    floor.law = law;
    scene.walls.push_back(floor);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform;
    for (const bool heap : {true, false}) {
        RodSpec rod = test::simple_rod(heap ? 6 : 10);
        rod.name = heap ? "heap" : "field";
        rod.placement = {.kind = PlacementKind::list, .tangent = {1, 0, 0}};
        for (int i = 0; i < 120; ++i)
            rod.placement.origins.push_back(
                heap ? Vec3d{0.2 * uniform(random), 0.4 * uniform(random), 0.02 + 0.3 * uniform(random)}
                     : Vec3d{2.0 + 1.5 * (i % 11), 0.5 * (i / 11), 0.019});
        scene.rods.push_back(rod);
    }
    return scene;
}

/// A scene on all ranks, stepped as a run does it.
struct Field {
    const Communicator comm = Communicator::world();
    const SceneSpec scene = heap_and_field();
    std::vector<RodGroup> groups = make_groups(scene);
    const Plan plan = make_plan(scene, groups, {comm.size(), 1, 1, 2, {}, Mapping::across});
    const Threads threads{1};
    Surroundings around;
    std::unique_ptr<Rods> rods;
    std::unique_ptr<Neighbourhood> neighbourhood;
    Interactions interactions;
    Clock clock{plan.dt, 0, plan.integrator};
    Timers timers;

    Field() {
        std::vector<LocalRod> own = partition(comm, groups);
        keep_own_rods(comm, groups, own);
        make(own);
        neighbourhood = std::make_unique<Neighbourhood>(comm, threads, around.exposure);
        interactions = make_interactions(parts());
    }
    InteractionParts parts() const { return {comm, threads, plan, groups, *rods, around}; }
    void make(std::span<const LocalRod> own) {
        rods.reset();
        around = {};
        rods = make_rods(plan, groups, own, threads, around);
    }
    void step() {
        const Step s = clock.next(clock.done() + 1, 1).front();
        rods->drift(s);
        add_loads(interactions, *neighbourhood, s, timers);
        rods->kick(s, false);
        clock.advance(std::span(&s, 1));
    }
    std::vector<Slot<1>> state(std::size_t i) const {
        std::vector<Slot<1>> out(static_cast<std::size_t>(nth(groups, rods->local()[i].group).slots()));
        rods->export_rod(i, out);
        return out;
    }
    /// Sum over ranks of hashes of what passes remember of each rod, and of where it began.
    std::uint64_t digest_of_memory() const {
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < rods->local().size(); ++i) {
            const LocalRod& rod = rods->local()[i];
            const Vec3d at = nth(groups, rod.group).origin(rod.index);
            sum += hash_numbers(rod.gid, rods->memory(i)) + hash_numbers(rod.gid, std::array{at.x, at.y, at.z});
        }
        return comm.sum_wrapping(sum);
    }
    double passes(std::size_t group) const { return plan.groups[group].ns_per_element_step * groups[group].elements(); }
    double cost(std::size_t i, std::span<const double> pairs, double of_pair) const {
        return of_pair * pairs[i] + passes(static_cast<std::size_t>(rods->local()[i].group));
    }
};

/// Sums of a number on all ranks.
std::vector<double> of_ranks(const Communicator& comm, double mine) {
    return comm.all_gather(std::span<const double>(&mine, 1));
}

double most_over_mean(const std::vector<double>& x) {
    return *std::max_element(x.begin(), x.end()) * static_cast<double>(x.size()) /
           std::accumulate(x.begin(), x.end(), 0.0);
}

/// Looks are left out where they take long.
void look_until_done(LoadBalance& balance, Timers& timers, const Field& field, std::int64_t left) {
    for (int i = 0; i < 100 && balance.figures().imbalance == 0; ++i)
        balance.update(timers, *field.rods, field.interactions, 1000, left);
}

TEST(Assignment, gives_equal_weights_whoever_asks) {
    const auto comm = Communicator::world();
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform;
    std::vector<WeighedRod> all;
    std::int64_t whole = 0, heaviest = 0;
    for (std::int64_t gid = 0; gid < 500; ++gid) {
        const std::int64_t weight = 1 + static_cast<std::int64_t>(random() % 50) * (gid < 100 ? 20 : 1);
        all.push_back({gid, {uniform(random), uniform(random), 10 * uniform(random)}, weight});
        whole += weight;
        heaviest = std::max(heaviest, weight);
    }
    std::vector<std::int64_t> found[2];
    for (const int dealt : {0, 1}) { // by number; all to the last
        std::vector<WeighedRod> mine;
        for (const WeighedRod& rod : all)
            if ((dealt == 0 ? rod.gid % comm.size() : comm.size() - 1) == comm.rank()) mine.push_back(rod);
        found[dealt].assign(all.size(), 0);
        const std::vector<Assignment> assigned = assign(comm, mine);
        for (std::size_t i = 0; i < mine.size(); ++i) nth(found[dealt], mine[i].gid) = assigned[i].rank;
        comm.sum(found[dealt]);
    }
    EXPECT_EQ(found[0], found[1]);
    std::vector<std::int64_t> weight(static_cast<std::size_t>(comm.size()), 0);
    for (const WeighedRod& rod : all) nth(weight, nth(found[0], rod.gid)) += rod.weight;
    for (const std::int64_t w : weight) EXPECT_LE(std::abs(w * comm.size() - whole), heaviest * comm.size());
}

TEST(Assignment, takes_rods_that_are_lost) {
    const auto comm = Communicator::world();
    std::vector<WeighedRod> mine;
    if (comm.root())
        mine = {{0, {NAN, 0, 0}, 1}, {1, {0, 1, 0}, 1}, {2, {HUGE_VAL, 0, 0}, 1}, {3, {1, 0, -HUGE_VAL}, 1}};
    for (const Assignment& a : assign(comm, mine)) {
        EXPECT_GE(a.rank, 0);
        EXPECT_LT(a.rank, comm.size());
    }
}

TEST(Migration, takes_all_along_that_steps_depend_on) {
    Field field;
    for (int i = 0; i < 30; ++i) field.step();
    const std::uint64_t state = field.comm.sum_wrapping(field.rods->digest()), memory = field.digest_of_memory();
    for (std::size_t i = 0; i < field.rods->local().size(); ++i) ASSERT_FALSE(field.rods->memory(i).empty());
    const std::vector<SavedNumbers> kept_before = saved(field.interactions);
    const std::int64_t contacts = field.comm.sum(static_cast<std::int64_t>(kept_before.front().rows.size()));
    ASSERT_GT(contacts, 100) << "contacts with memory are there to be moved";
    for (int seed = 0; seed < 3; ++seed) {
        std::vector<Assignment> assigned;
        std::int64_t leave = 0;
        for (const LocalRod& rod : field.rods->local()) {
            const std::uint64_t h = hash_end(hash_begin(rod.gid + 1000 * seed));
            assigned.push_back({h, seed == 2 ? 0 : static_cast<int>(h % static_cast<unsigned>(field.comm.size()))});
            leave += assigned.back().rank != field.comm.rank();
        }
        const Migration migration(field.comm, field.groups, *field.rods, assigned, 1, 1);
        EXPECT_EQ(Migration::count(field.comm, assigned), field.comm.sum(leave));
        field.make(migration.owned());
        migration.put_into(*field.rods);
        for (std::size_t i = 0; i < migration.owned().size(); ++i) field.around.exposure->show(i, migration.state(i));
        field.neighbourhood->rebind(field.around.exposure);
        for (const auto& one : field.interactions) one->rebind(field.parts());
        restore(field.interactions, kept_before);
        EXPECT_EQ(field.comm.sum_wrapping(field.rods->digest()), state);
        EXPECT_EQ(field.digest_of_memory(), memory);
        const std::vector<SavedNumbers> now = saved(field.interactions);
        ASSERT_EQ(now.size(), kept_before.size());
        for (std::size_t i = 0; i < now.size(); ++i) {
            EXPECT_EQ(now[i].numbers, kept_before[i].numbers);
            EXPECT_EQ(now[i].rows, kept_before[i].rows) << now[i].name;
        }
        for (std::size_t i = 1; i < field.rods->local().size(); ++i)
            EXPECT_LE(field.rods->local()[i - 1].group, field.rods->local()[i].group);
    }
}

/// Bits of what passes show, worked out from the state without them.
TEST(Exposure, shows_what_its_pass_shows) {
    Field field;
    for (int i = 0; i < 20; ++i) field.step();
    const Step s = field.clock.next(field.clock.done() + 1, 1).front();
    field.rods->drift(s);
    const Exposure& shown = *field.around.exposure;
    Exposure again(field.groups, field.rods->local());
    for (std::size_t i = 0; i < field.rods->local().size(); ++i) again.show(i, field.state(i));
    for (const Window& w : again.window) {
        const std::uint32_t first = shown.find(w.first_in_scene).value();
        for (std::uint32_t k = 0; k < w.slots; ++k) {
            const ExposedNode &a = shown.node[first + k], &b = again.node[w.first_slot + k];
            const ExposedMotion &u = shown.motion[first + k], &v = again.motion[w.first_slot + k];
            const double mine[] = {a.position.x, a.position.y, a.position.z, a.radius, u.velocity.x,
                                   u.velocity.y, u.velocity.z, u.spin.x,     u.spin.y, u.spin.z};
            const double theirs[] = {b.position.x, b.position.y, b.position.z, b.radius, v.velocity.x,
                                     v.velocity.y, v.velocity.z, v.spin.x,     v.spin.y, v.spin.z};
            for (std::size_t i = 0; i < std::size(mine); ++i)
                EXPECT_EQ(std::bit_cast<std::uint64_t>(mine[i]), std::bit_cast<std::uint64_t>(theirs[i]))
                    << i << " of slot " << k;
        }
    }
}

TEST(LoadBalance, relieves_the_rank_that_has_the_heap) {
    Field field;
    if (field.comm.size() == 1) GTEST_SKIP() << "ranks share nothing";
    LoadBalance balance(field.comm, field.plan, Balance::automatic);
    balance.expect(0.1);
    field.step();
    balance.update(field.timers, *field.rods, field.interactions, 0, 1 << 20);
    EXPECT_FALSE(balance.due()) << "nothing has been measured yet";
    const std::vector<double> pairs = work_of(field.interactions, field.rods->local());
    const double all_pairs = std::accumulate(pairs.begin(), pairs.end(), 0.0);
    Timers timers; // pairs of the whole scene cost four times its passes
    timers.add(Phase::rods, field.timers.seconds(Phase::rods) + 1);
    const std::vector<double> share = of_ranks(field.comm, all_pairs);
    const double sum = std::accumulate(share.begin(), share.end(), 0.0);
    timers.add(Phase::contacts, field.timers.seconds(Phase::contacts) + 4.0 * field.comm.size() * all_pairs / sum);
    look_until_done(balance, timers, field, 1 << 20);
    EXPECT_GT(balance.figures().imbalance, 1.3);
    ASSERT_TRUE(balance.due());

    const std::vector<Assignment> assigned = balance.assign(field.groups, *field.rods, field.interactions);
    const double passes = 120 * (field.passes(0) + field.passes(1)), of_pair = 4 * passes / sum;
    std::vector<double> cost(static_cast<std::size_t>(field.comm.size()), 0.0), before;
    double mine = 0, heaviest = 0;
    for (std::size_t i = 0; i < assigned.size(); ++i) {
        heaviest = std::max(heaviest, field.cost(i, pairs, of_pair));
        nth(cost, assigned[i].rank) += field.cost(i, pairs, of_pair);
        mine += field.cost(i, pairs, of_pair);
    }
    before = of_ranks(field.comm, mine);
    for (double& c : cost) {
        const std::vector<double> parts = of_ranks(field.comm, c);
        c = std::accumulate(parts.begin(), parts.end(), 0.0);
    }
    EXPECT_GT(most_over_mean(before), 1.3);
    const double mean = std::accumulate(cost.begin(), cost.end(), 0.0) / field.comm.size();
    EXPECT_LE(*std::max_element(cost.begin(), cost.end()), mean + field.comm.max(heaviest) * (1 + 1e-9))
        << "within a rod's cost";
    EXPECT_LT(most_over_mean(cost), 0.75 * most_over_mean(before));
    EXPECT_NEAR(balance.figures().imbalance, most_over_mean(before), 1e-9) << "what it looked at is what it deals out";
}

TEST(LoadBalance, leaves_owners_alone_where_nothing_is_gained) {
    Field field;
    field.step();
    const auto looked = [&](Balance when, std::int64_t left, double seconds) {
        LoadBalance balance(field.comm, field.plan, when);
        balance.expect(0.1);
        Timers timers;
        balance.update(timers, *field.rods, field.interactions, 0, left);
        timers.add(Phase::rods, seconds);
        timers.add(Phase::contacts, 4 * seconds);
        look_until_done(balance, timers, field, left);
        return balance.due();
    };
    EXPECT_FALSE(looked(Balance::never, 1 << 20, 10));
    EXPECT_FALSE(looked(Balance::automatic, 0, 10)) << "the run is over";
    EXPECT_FALSE(looked(Balance::automatic, 1 << 20, 1e-3)) << "a migration would cost more than it saves";
    EXPECT_EQ(looked(Balance::automatic, 1 << 20, 10), field.comm.size() > 1);
    EXPECT_EQ(looked(Balance::always, 1 << 20, 10), field.comm.size() > 1);
}

} // namespace
} // namespace skein
