// A crowd of moving rods that ranks share: loads with ghosts are those of a rank that sees everything, bit for bit;
// ghosts are the elements in some pair with an own one and no others; and no more is sent than that.
#include "neighbourhood/neighbourhood.hpp"

#include "contact/contacts.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"
#include "support/exposed_bodies.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <random>
#include <set>

namespace skein {
namespace {

constexpr int rods = 160, elements = 9;

struct Crowd {
    test::BodiesByHand bodies;
    std::vector<ExposedMotion> motion; ///< by slot of the scene

    explicit Crowd(unsigned seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> uniform;
        const auto point = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
        for (int r = 0; r < rods; ++r) {
            const Vec3d at = point(), along = point() - point();
            const double size = r % 12 == 0 ? 3 : 1;
            std::vector<Vec3d> nodes;
            for (int k = 0; k <= elements + r % 2; ++k) {
                nodes.push_back(at + (0.4 * size / elements * k / norm(along)) * along +
                                Vec3d{0, 0, 0.02 * size * std::cos(3.0 * k)});
                motion.push_back({.velocity = 0.5 * (point() - point()), .spin = point() - point()});
            }
            bodies.add(nodes, 0.012 * size, r % 5 ? -1 : 1);
        }
    }
};

ContactLaw law() {
    return {.stiffness = 1e5,
            .damping = 20,
            .friction = ContactFriction::memory,
            .static_friction = 0.5,
            .kinetic_friction = 0.4,
            .tangential_damping = 5};
}

/// One rank with its own bodies, and the ghosts that it needs.
struct Share {
    std::shared_ptr<Exposure> bodies;
    Neighbourhood neighbourhood;
    Contacts contacts;
    SlotLoads loads = {};
    bool rebuilt = false;

    Share(const Communicator& comm, const Threads& threads, const Crowd& crowd, const std::vector<int>& owner)
        : bodies(std::make_shared<Exposure>(own(comm, crowd, owner))), neighbourhood(comm, threads, bodies),
          contacts(crowd.bodies.scene(law()), threads) {}
    static Exposure own(const Communicator& comm, const Crowd& crowd, const std::vector<int>& owner) {
        const Exposure whole = crowd.bodies.exposure();
        std::vector<Window> mine;
        for (const Window& w : whole.window)
            if (nth(owner, w.gid) == comm.rank()) mine.push_back(w);
        Exposure bodies(whole.scene(), std::move(mine));
        for (std::size_t slot = 0; slot < bodies.slots(); ++slot)
            bodies.node[slot] = nth(whole.node, bodies.in_scene(slot));
        return bodies;
    }
    void step(const Communicator& comm, double h) {
        const bool hold = contacts.holds(*bodies);
        neighbourhood.publish(hold);
        if (hold) contacts.begin(*bodies, 0, h, loads.load, true);
        rebuilt = !neighbourhood.arrive();
        if (rebuilt) {
            contacts.prepare_rebuild(*bodies);
            const Exposure& near = neighbourhood.widen(contacts.next_skin());
            std::vector<std::uint8_t> wanted(near.slots());
            const std::int64_t inactive = contacts.search(near, wanted);
            const auto slot = neighbourhood.narrow(wanted);
            loads.load.resize(bodies->slots());
            contacts.finish_rebuild(*bodies, slot, comm.sum(inactive));
            contacts.begin(*bodies, 0, h, loads.load, true);
        }
        contacts.finish(*bodies, h, loads.load);
        loads.touched = contacts.touched();
    }
    /// Own bodies move on and show where they are; ghosts are told.
    void move(const Exposure& whole, const Crowd& crowd) {
        for (std::size_t slot = 0; slot < bodies->slots(); ++slot) {
            const auto in_scene = static_cast<std::size_t>(bodies->in_scene(slot));
            if (!bodies->owns_slot(slot)) continue;
            bodies->node[slot].position = whole.node[in_scene].position;
            bodies->motion[slot] = crowd.motion[in_scene];
        }
    }
};

/// Rods by piles along x, by number, all on one rank, or at random; with many ranks some have none.
std::vector<int> owners(const Crowd& crowd, int kind, int ranks) {
    std::vector<int> owner;
    std::mt19937 random(7);
    const Exposure whole = crowd.bodies.exposure();
    for (int r = 0; r < rods; ++r) {
        const double x = whole.node[nth(whole.window, r).first_slot].position.x;
        const int by_place = std::clamp(static_cast<int>(x * ranks), 0, ranks - 1);
        owner.push_back(kind == 0   ? by_place
                        : kind == 1 ? r % ranks
                        : kind == 2 ? ranks - 1
                                    : static_cast<int>(random() % static_cast<unsigned>(ranks)));
    }
    return owner;
}

class Neighbourhoods : public testing::TestWithParam<int> {};

TEST_P(Neighbourhoods, GiveTheLoadsOfOneRank) {
    const auto comm = Communicator::world();
    const Threads one(1), two(2);
    const Crowd crowd(3);
    Exposure whole = crowd.bodies.exposure();
    std::copy(crowd.motion.begin(), crowd.motion.end(), whole.motion.begin());
    whole.set_paces(one, whole.largest_speed(one));
    Contacts of_whole(crowd.bodies.scene(law()), one);
    SlotLoads expected;
    Share share(comm, comm.rank() % 2 ? two : one, crowd, owners(crowd, GetParam(), comm.size()));
    std::int64_t rebuilds = 0, touched = 0;
    const double h = 1e-4;
    for (int step = 0; step < 150; ++step) {
        for (std::size_t i = 0; i < whole.slots(); ++i) whole.node[i].position += h * whole.motion[i].velocity;
        of_whole.evaluate(whole, 0, h, expected);
        share.move(whole, crowd);
        const auto before = Communicator::traffic();
        share.step(comm, h);
        const auto after = Communicator::traffic();
        rebuilds += share.rebuilt;
        if (!share.rebuilt) { // nothing but ghosts is sent, and a vote
            EXPECT_EQ(after.bytes - before.bytes, share.neighbourhood.figures().bytes);
            EXPECT_EQ(after.messages - before.messages, share.neighbourhood.figures().messages);
            EXPECT_EQ(after.calls - before.calls, comm.size() > 1 ? 1 : 0);
        }
        std::set<std::int64_t> needed, here; // slots of ghosts' elements
        if (share.rebuilt) {
            Candidates pairs;
            BroadPhase::build_exhaustively(whole, crowd.bodies.rules, of_whole.figures().skin, pairs);
            const auto mine = [&](std::size_t slot) {
                return share.bodies->find(static_cast<std::int64_t>(slot)).has_value() &&
                       share.bodies->owns_slot(*share.bodies->find(static_cast<std::int64_t>(slot)));
            };
            for (std::size_t a = 0; a < whole.slots(); ++a)
                for (std::uint32_t i = pairs.first[a]; i < pairs.first[a + 1]; ++i) {
                    const std::size_t b = pairs.partner[i];
                    if (mine(a) != mine(b)) // and its neighbours, whose vertices it shares
                        whole.with_neighbours(mine(a) ? static_cast<std::uint32_t>(b) : static_cast<std::uint32_t>(a),
                                              [&](std::uint32_t slot) { needed.insert(slot); });
                }
            for (std::size_t slot = 0; slot < share.bodies->slots(); ++slot)
                if (!share.bodies->owns_slot(slot) && share.bodies->has_element(slot))
                    here.insert(share.bodies->in_scene(slot));
            EXPECT_EQ(needed, here) << step;
            EXPECT_EQ(share.neighbourhood.figures().elements, static_cast<std::int64_t>(here.size()));
            EXPECT_EQ(share.neighbourhood.figures().bytes % 72, 0);
        }
        for (std::size_t w = 0; w < share.bodies->window.size(); ++w) {
            const Window& window = share.bodies->window[w];
            const auto body = static_cast<std::size_t>(window.gid);
            for (std::uint32_t k = 0; k < window.slots; ++k) {
                const std::size_t slot = window.first_slot + k,
                                  in_scene = static_cast<std::size_t>(window.first_in_scene) + k;
                ASSERT_EQ(norm(share.bodies->node[slot].position - whole.node[in_scene].position), 0)
                    << "step " << step;
                ASSERT_EQ(share.bodies->pace[slot], whole.pace[in_scene]) << "step " << step;
                if (!window.own) continue;
                ASSERT_EQ(share.loads.touched[w], expected.touched[body]) << "step " << step << " body " << body;
                if (!expected.touched[body]) continue;
                ++touched;
                ASSERT_EQ(std::memcmp(&share.loads.load[slot].force, &expected.load[in_scene].force, sizeof(Vec3d)), 0)
                    << step;
                ASSERT_EQ(std::memcmp(&share.loads.load[slot].couple, &expected.load[in_scene].couple, sizeof(Vec3d)),
                          0)
                    << step;
            }
        }
    }
    EXPECT_EQ(rebuilds, of_whole.figures().rebuilds);
    EXPECT_EQ(share.contacts.figures().skin, of_whole.figures().skin);
    EXPECT_GT(rebuilds, 2);
    EXPECT_GT(comm.sum(touched), 1000);
    for (const auto of : {&ContactFigures::candidates, &ContactFigures::active})
        EXPECT_EQ(comm.sum(share.contacts.figures().*of), of_whole.figures().*of);
    for (const auto of : {&ContactFigures::friction_work, &ContactFigures::viscous_work,
                          &ContactFigures::elastic_energy}) { // none twice, none lost
        EXPECT_GT((of_whole.figures().*of).value(), 0);
        EXPECT_EQ(totals(comm, std::array{share.contacts.figures().*of}).front(), of_whole.figures().*of);
    }
}

INSTANTIATE_TEST_SUITE_P(Owners, Neighbourhoods, testing::Values(0, 1, 2, 3));

} // namespace
} // namespace skein
