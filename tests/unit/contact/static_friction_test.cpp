// Friction at rest: two rods that cross, moved from where their spring is known.
#include "contact/contact_spec.hpp"
#include "contact/static_contacts.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double radius = 1e-3, length = 20e-3, overlap = 2e-6, stiffness = 1e5, friction = 0.4, share = 0.8;

/// Rods along x and y, one upon the other, that cross within elements. The one along x may be a ring, whose last
/// element is crossed.
class Crossing {
public:
    explicit Crossing(ContactFriction kind = ContactFriction::memory, bool ring = false) {
        const ContactLaw law{.normal = ContactNormal::linear,
                             .stiffness = stiffness,
                             .damping = 50,
                             .friction = kind,
                             .static_friction = friction,
                             .kinetic_friction = friction,
                             .tangential_share = share,
                             .tangential_damping = 30,
                             .slip_speed = 1e-3};
        for (const int i : {0, 1}) {
            RodSpec spec = test::simple_rod(5);
            spec.section.radius = radius;
            spec.shape.length = length;
            spec.shape.closed = ring && i == 0;
            groups_.emplace_back(spec, i, i, "");
            rods_.push_back({i, i, 0});
            for (int k = 0; k < 6; ++k) {
                const double along = (k - 2.4) * length / 5;
                Slot<1>& slot = state.emplace_back();
                Vec3d at = i == 0 ? Vec3d{along, 0, 0} : Vec3d{0, along, 2 * radius - overlap};
                if (spec.shape.closed) {
                    const double fifth = 0.4 * std::numbers::pi, size = 0.5 * length / 5 / std::sin(0.5 * fifth);
                    const double turn = 0.5 * std::numbers::pi - fifth * ((k % 5) + 0.5);
                    at = size * Vec3d{std::cos(turn), std::sin(turn) - std::cos(0.5 * fifth), 0};
                    if (k == 5) at = {9, 9, 9}; // a copy of node 0, which nobody keeps up to date
                }
                set_lane(slot.position, 0, at);
                set_lane(slot.director, 0, Quaterniond{1, {0, 0, 0}});
            }
        }
        contacts_ = make_static_contacts(contact_scene(groups_, {}, law), groups_, rods_, threads_);
    }
    void set_reference() { contacts_->set_reference(state); }
    void keep_springs() {
        loads();
        contacts_->keep_springs();
        set_reference();
    }
    StaticContactLoads loads(bool with_stiffness = false) {
        StaticContactLoads out;
        contacts_->evaluate(state, with_stiffness, out);
        return out;
    }
    /// Moves all of a rod along a vector and turns its elements, body.
    void move(std::size_t rod, const Vec3d& by, const Vec3d& turn = {0, 0, 0}) {
        const double w = 1 / std::sqrt(1 + 0.25 * dot(turn, turn));
        const Quaterniond small{w, 0.5 * w * turn};
        for (std::size_t k = 6 * rod; k < 6 * rod + 6; ++k) {
            set_lane(state[k].position, 0, lane(state[k].position, 0) + by);
            set_lane(state[k].director, 0, small * lane(state[k].director, 0));
        }
    }
    static Vec3d sum(const StaticContactLoads& loads, std::size_t rod) {
        Vec3d all{0, 0, 0};
        for (std::size_t k = 6 * rod; k < 6 * rod + 6; ++k) all += loads.force[k];
        return all;
    }
    const std::vector<SavedContact>& springs() const { return contacts_->springs(); }
    void set_springs(std::vector<SavedContact> springs) { contacts_->set_springs(std::move(springs)); }

    std::vector<Slot<1>> state;

private:
    inline static const Threads threads_{1};
    std::vector<RodGroup> groups_;
    std::vector<LocalRod> rods_;
    std::unique_ptr<StaticContacts> contacts_;
};

constexpr double normal_force = stiffness * overlap, spring = share * stiffness;

TEST(StaticFriction, SticksSlidesAndGoesOnFromItsSpring) {
    Crossing rods;
    rods.set_reference();
    EXPECT_NEAR(Crossing::sum(rods.loads(), 1).z, normal_force, 1e-9 * normal_force);
    EXPECT_NEAR(Crossing::sum(rods.loads(), 1).x, 0, 1e-12 * normal_force);
    const double way = 0.5 * friction * normal_force / spring;
    rods.move(1, {way, 0, 0});
    EXPECT_NEAR(Crossing::sum(rods.loads(), 1).x, -spring * way, 1e-9 * normal_force);
    rods.keep_springs(); // a second way from there adds to the first
    EXPECT_NEAR(Crossing::sum(rods.loads(), 1).x, -spring * way, 1e-9 * normal_force);
    rods.move(1, {0.5 * way, 0, 0});
    EXPECT_NEAR(Crossing::sum(rods.loads(), 1).x, -1.5 * spring * way, 1e-9 * normal_force);
    rods.move(1, {9 * way, 0, 0});
    EXPECT_NEAR(Crossing::sum(rods.loads(), 1).x, -friction * normal_force, 1e-9 * normal_force);
    rods.keep_springs(); // and what has slid springs back
    rods.move(1, {-way, 0, 0});
    EXPECT_NEAR(Crossing::sum(rods.loads(), 1).x, -friction * normal_force + spring * way, 1e-9 * normal_force);
    ASSERT_EQ(rods.springs().size(), 1u);
    Crossing other; // springs of a checkpoint
    other.state = rods.state;
    other.set_springs(rods.springs());
    other.set_reference();
    EXPECT_NEAR(Crossing::sum(other.loads(), 1).x, -friction * normal_force, 1e-9 * normal_force);
}

TEST(StaticFriction, ActsWhereARingCloses) {
    Crossing rods(ContactFriction::memory, true);
    rods.set_reference();
    const double way = 0.5 * friction * normal_force / spring;
    rods.move(1, {way, 0, 0});
    const StaticContactLoads loads = rods.loads(true);
    ASSERT_EQ(loads.contacts.size(), 3u); // where it closes, and of both elements at the vertex across, which share one
    const auto at_seam = [](const StaticContact& contact) { return contact.slot[0] == 4; };
    EXPECT_EQ(std::count_if(loads.contacts.begin(), loads.contacts.end(), at_seam), 1);
    EXPECT_NEAR(Crossing::sum(loads, 1).x, -2 * spring * way, 1e-9 * normal_force);
    EXPECT_NEAR(Crossing::sum(loads, 0).x, 2 * spring * way, 1e-9 * normal_force);
    EXPECT_EQ(norm(loads.force[5]), 0);
}

TEST(StaticFriction, ActsFromAReferenceOnAndWithMemoryAlone) {
    Crossing without;
    without.move(1, {1e-7, 0, 0});
    EXPECT_EQ(norm(without.loads().couple[2]), 0);
    EXPECT_NEAR(Crossing::sum(without.loads(), 1).x, 0, 1e-12 * normal_force);
    for (const ContactFriction kind :
         {ContactFriction::none, ContactFriction::regularised, ContactFriction::published}) {
        Crossing rods(kind);
        rods.set_reference();
        rods.move(1, {1e-7, 0, 0});
        EXPECT_NEAR(Crossing::sum(rods.loads(), 1).x, 0, 1e-12 * normal_force);
        EXPECT_TRUE(rods.loads(true).turning.empty());
    }
}

/// Largest difference between the loads after a motion and what the stiffness says, over the pull of a spring of its
/// way.
double error_of_stiffness(Crossing& rods, std::size_t rod, const Vec3d& by, const Vec3d& turn) {
    const StaticContactLoads here = rods.loads(true);
    std::vector<Vec3d> force(12, Vec3d{0, 0, 0}), couple = force;
    for (const auto* couplings : {&here.couplings, &here.turning})
        for (const SlotCoupling& c : *couplings) {
            if (c.column / 6 != rod) continue;
            const bool element = c.column % 6 != 5;
            const double u[6] = {by.x, by.y, by.z, element * turn.x, element * turn.y, element * turn.z};
            double f[6] = {};
            for (std::size_t i = 0; i < 6; ++i)
                for (std::size_t j = 0; j < 6; ++j) f[i] -= c.block[i][j] * u[j];
            force[c.row] += Vec3d{f[0], f[1], f[2]};
            couple[c.row] += Vec3d{f[3], f[4], f[5]};
        }
    rods.move(rod, by, turn);
    const StaticContactLoads there = rods.loads();
    double most = 0;
    for (std::size_t s = 0; s < 12; ++s)
        most = std::max({most, norm(there.force[s] - here.force[s] - force[s]),
                         norm(there.couple[s] - here.couple[s] - couple[s]) / radius});
    return most / (spring * norm(by)); // some motions roll, without a change of friction
}

TEST(StaticFriction, StiffnessIsThatOfTheForces) {
    const double way = 1e-3 * friction * normal_force / spring;
    for (const bool slides : {false, true})
        for (const Vec3d& by : {Vec3d{1, 0, 0}, {0, 1, 0}, {0.3, -0.8, 0}, {0.4, 0.2, -1}, {0.4, 0.2, 0.5}})
            for (const Vec3d& turn : {Vec3d{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.4, 0.3}})
                for (const std::size_t rod : {0u, 1u}) {
                    Crossing rods;
                    rods.set_reference();
                    rods.move(1, {(slides ? 2000 : 200) * way, (slides ? 1000 : 100) * way, 0});
                    // The direction of slip turns by up to a thousandth.
                    EXPECT_LT(error_of_stiffness(rods, rod, way * by, (way / radius) * turn), slides ? 0.01 : 2e-4)
                        << slides << rod << by.x << by.y << by.z << turn.x << turn.y;
                }
}

TEST(StaticFriction, StickingIsSymmetricButForTheFriction) {
    Crossing rods;
    rods.set_reference();
    rods.move(1, {1e-7, 2e-7, 0});
    const StaticContactLoads loads = rods.loads(true);
    double largest = 0, difference = 0;
    double sum[12][12][6][6] = {};
    for (const SlotCoupling& one : loads.turning)
        for (std::size_t i = 0; i < 6; ++i)
            for (std::size_t j = 0; j < 6; ++j) sum[one.row][one.column][i][j] += one.block[i][j];
    const auto lever = [](std::size_t i) { return i < 3 ? 1 : radius; };
    for (std::size_t r = 0; r < 12; ++r)
        for (std::size_t c = 0; c < 12; ++c)
            for (std::size_t i = 0; i < 6; ++i)
                for (std::size_t j = 0; j < 6; ++j) {
                    const double size = lever(i) * lever(j);
                    largest = std::max(largest, std::abs(sum[r][c][i][j]) / size);
                    difference = std::max(difference, std::abs(sum[r][c][i][j] - sum[c][r][j][i]) / size);
                }
    EXPECT_NEAR(largest, spring, 0.5 * spring);
    EXPECT_LT(difference, 10 * spring * norm(Vec3d{1e-7, 2e-7, 0}) / radius);
}

} // namespace
} // namespace skein
