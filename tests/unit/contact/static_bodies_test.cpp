// Rigid bodies in contact at rest: forces of the energy are those of a step, and the stiffness is that of the forces.
#include "contact/contact_spec.hpp"
#include "contact/static_contacts.hpp"
#include "skein/core/error.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace skein {
namespace {

constexpr double radius = 10e-3, stiffness = 1e5;

Quaterniond turn_of(const Vec3d& turn) {
    const double w = 1 / std::sqrt(1 + 0.25 * dot(turn, turn));
    return {w, 0.5 * w * turn};
}

enum class OnBox { rod, ball, capsule, box, tilted_box };

/// Bodies in random poses near contact.
class Heap {
public:
    /// A rod on a capsule, a ball on both.
    Heap(std::mt19937& random, ContactNormal normal, ContactFriction friction, bool with_rod = true) {
        std::uniform_real_distribution<double> some(-1, 1);
        if (with_rod) add_rod();
        add(test::rigid_body(0.06, radius));
        add(test::rigid_body(0, radius));
        const Vec3d along = unit(Vec3d{1, 0.3 * some(random), 0.1 * some(random)});
        for (int k = 0; with_rod && k < 6; ++k) {
            const Vec3d bend{0, 0, 2e-3 * k * (5 - k) / 6.0};
            put({0.02 * (k - 2.5 + 0.3 * some(random)) * along + bend}, {0, 0, 0});
        }
        const double across = (0.9 + 0.05 * some(random)) * 2 * radius;
        put({0.01 * some(random), 0.01 * some(random), -across + 0.004}, {1.5 + 0.3 * some(random), some(random), 0.2});
        const double above = with_rod ? 0.9 * 2 * radius : 0.004 - 0.02 * across / radius;
        put({0.02 * some(random), 0.005 * some(random), above}, {some(random), some(random), some(random)});
        make(normal, friction);
    }
    /// One on a box, over its face or its edge.
    Heap(std::mt19937& random, ContactNormal normal, ContactFriction friction, OnBox kind) {
        std::uniform_real_distribution<double> some(-1, 1);
        const auto any = [&](double size) { return size * Vec3d{some(random), some(random), some(random)}; };
        const double depth = 1e-3 * (1 + some(random));
        add(test::box_body({0.06, 0.05, 0.03}));
        put(any(1e-3) + Vec3d{0, 0, -0.015}, any(0.02));
        const Vec3d over{0.025 * some(random), 0.02 * some(random), -depth};
        switch (kind) {
        case OnBox::rod: {
            add_rod();
            const Vec3d along = unit(Vec3d{some(random), some(random), 0.05 * some(random)});
            for (int k = 0; k < 6; ++k) put(over + Vec3d{0, 0, radius} + 0.02 * (k - 2.4) * along, {0, 0, 0});
            break;
        }
        case OnBox::ball:
            add(test::rigid_body(0, radius));
            put(over + Vec3d{0, 0, radius}, any(1));
            break;
        case OnBox::capsule:
            add(test::rigid_body(0.06, radius));
            put(over + Vec3d{0, 0, radius}, Vec3d{2, 0, 0} + any(0.05));
            break;
        case OnBox::box:
            add(test::box_body({0.03, 0.04, 0.03}));
            put(over + Vec3d{0, 0, 0.015}, any(0.05));
            break;
        case OnBox::tilted_box:
            add(test::box_body({0.04, 0.04, 0.04}));
            put(over + Vec3d{0, 0, 0.025}, any(0.7));
        }
        make(normal, friction);
    }

    StaticContactLoads loads(bool with_stiffness = false) {
        StaticContactLoads out;
        contacts_->evaluate(state, with_stiffness, out);
        return out;
    }
    void set_reference() { contacts_->set_reference(state); }
    void make_convex(bool convex) { contacts_->make_convex(convex); }
    double clear_share(std::span<const Slot<1>> moved) { return contacts_->clear_share(state, moved); }
    /// Largest overlap on the way to another state.
    double overlap_at(std::span<const Slot<1>> moved, double share) {
        std::vector<Slot<1>> between = state;
        for (std::size_t s = 0; s < between.size(); ++s) {
            const Vec3d from = lane(state[s].position, 0), to = lane(moved[s].position, 0);
            set_lane(between[s].position, 0, from + share * (to - from));
        }
        StaticContactLoads out;
        contacts_->evaluate(between, false, out);
        return out.largest_overlap;
    }
    using Motion = std::vector<double>; ///< of all slots, six unknowns each, turns in radii
    void move(const Motion& motion, double share) {
        for (std::size_t s = 0; s < state.size(); ++s) {
            const double* m = &motion[6 * s];
            set_lane(state[s].position, 0, lane(state[s].position, 0) + share * Vec3d{m[0], m[1], m[2]});
            set_lane(state[s].director, 0,
                     turn_of((share / radius) * Vec3d{m[3], m[4], m[5]}) * lane(state[s].director, 0));
        }
    }
    /// Loads at all slots, couples over the radius; each in the axes that the motion has turned.
    static Motion all(const StaticContactLoads& loads) {
        Motion numbers;
        for (std::size_t s = 0; s < loads.force.size(); ++s)
            for (const Vec3d& v : {loads.force[s], (1 / radius) * loads.couple[s]})
                numbers.insert(numbers.end(), {v.x, v.y, v.z});
        return numbers;
    }

    std::vector<Slot<1>> state;

private:
    void make(ContactNormal normal, ContactFriction friction) {
        const ContactLaw law{.normal = normal, .stiffness = stiffness, .friction = friction, .static_friction = 0.4};
        contacts_ = make_static_contacts(contact_scene(groups_, {.law = law}, law), groups_, rods_, threads_);
    }
    void add_rod() {
        RodSpec rod = test::simple_rod(5);
        rod.section.radius = radius;
        rod.shape.length = 0.1;
        add(rod);
    }
    void add(const RodSpec& spec) {
        const int i = static_cast<int>(groups_.size());
        groups_.emplace_back(spec, i, i, "");
        rods_.push_back({i, i, 0});
    }
    void put(const Vec3d& at, const Vec3d& turn) {
        Slot<1>& slot = state.emplace_back();
        set_lane(slot.position, 0, at);
        set_lane(slot.director, 0, turn_of(turn));
    }
    inline static const Threads threads_{1};
    std::vector<RodGroup> groups_;
    std::vector<LocalRod> rods_;
    std::unique_ptr<StaticContacts> contacts_;
};

double largest(const Heap::Motion& x) {
    double most = 0;
    for (const double one : x) most = std::max(most, std::abs(one));
    return most;
}

/// Compares forces at rest with those of a step, in 60 heaps. Returns in how many bodies touch.
template <class Kind> int compare_with_steps(Kind kind) {
    std::mt19937 random(3);
    int touching = 0;
    for (int trial = 0; trial < 60; ++trial) {
        Heap heap(random, trial % 2 ? ContactNormal::hertz : ContactNormal::linear, ContactFriction::memory, kind);
        const Heap::Motion energy = Heap::all(heap.loads());
        heap.set_reference();
        const Heap::Motion step = Heap::all(heap.loads());
        const double size = largest(step);
        if (size == 0) continue;
        ++touching;
        for (std::size_t i = 0; i < step.size(); ++i)
            EXPECT_NEAR(energy[i], step[i], 1e-10 * size) << trial << " " << i;
    }
    return touching;
}

constexpr OnBox all_on_box[] = {OnBox::rod, OnBox::ball, OnBox::capsule, OnBox::box, OnBox::tilted_box};

TEST(StaticBodies, HaveTheForcesOfAStep) {
    EXPECT_GT(compare_with_steps(true), 40);
    for (const OnBox kind : all_on_box) EXPECT_GT(compare_with_steps(kind), 30) << static_cast<int>(kind);
}

/// Largest error of a stiffness along a random motion over its largest entry, from differences of fourth order; below
/// 0: the differences are not reliable there.
double error_of_stiffness(Heap& heap, std::mt19937& random) {
    std::uniform_real_distribution<double> some(-1, 1);
    const StaticContactLoads here = heap.loads(true);
    Heap::Motion motion(6 * heap.state.size()), expected(motion.size());
    for (double& m : motion) m = some(random);
    double size = 0;
    for (const auto* couplings : {&here.couplings, &here.turning})
        for (const SlotCoupling& c : *couplings)
            for (std::size_t i = 0; i < 6; ++i)
                for (std::size_t j = 0; j < 6; ++j) {
                    const double k = c.block[i][j] / ((i < 3 ? 1 : radius) * (j < 3 ? 1 : radius));
                    size = std::max(size, std::abs(k));
                    expected[6 * c.row + i] -= k * motion[6 * c.column + j];
                }
    for (std::size_t s = 0; s < heap.state.size(); ++s) { // the couple's axes turn by half of the motion: [c]/2
        const Vec3d c = (0.5 / radius) * here.couple[s], turn{motion[6 * s + 3], motion[6 * s + 4], motion[6 * s + 5]},
                    more = (1 / radius) * cross(c, turn);
        expected[6 * s + 3] += more.x;
        expected[6 * s + 4] += more.y;
        expected[6 * s + 5] += more.z;
    }
    const std::vector<Slot<1>> state = heap.state;
    const auto slopes = [&](double h) {
        const auto at = [&](double share) {
            heap.state = state;
            heap.move(motion, share);
            return Heap::all(heap.loads());
        };
        const Heap::Motion a = at(-h), b = at(h), aa = at(-2 * h), bb = at(2 * h);
        heap.state = state;
        Heap::Motion slope(a.size());
        for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = (8 * (b[i] - a[i]) - (bb[i] - aa[i])) / (12 * h);
        return slope;
    };
    const Heap::Motion coarse = slopes(2e-7), fine = slopes(1e-7);
    double change = 0, error = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
        change = std::max(change, std::abs(fine[i] - coarse[i]));
        error = std::max(error, std::abs(fine[i] - expected[i]));
    }
    return change > 1e-8 * size ? -1 : error / size;
}

/// The largest such error over random heaps.
template <class Kind> double largest_error(ContactFriction friction, Kind kind, int at_least = 40) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> some(-1, 1);
    double most = 0;
    int compared = 0;
    for (int trial = 0; trial < 100; ++trial) {
        Heap heap(random, trial % 2 ? ContactNormal::hertz : ContactNormal::linear, friction, kind);
        heap.set_reference();
        Heap::Motion way(6 * heap.state.size());
        for (double& m : way) m = some(random);
        heap.move(way, 1e-5); // sticks or slides
        const double error = error_of_stiffness(heap, random);
        if (!(error >= 0)) continue; // nothing touches, or differences are not reliable
        ++compared;
        most = std::max(most, error);
    }
    EXPECT_GT(compared, at_least);
    return most;
}

TEST(StaticBodies, StiffnessIsThatOfTheForces) {
    EXPECT_LT(largest_error(ContactFriction::none, true), 1e-7);
    EXPECT_LT(largest_error(ContactFriction::memory, false), 1e-7);
    EXPECT_LT(largest_error(ContactFriction::memory, true), 1e-2); // shares of vertices stand still
}

TEST(StaticBodies, StiffnessOnABoxIsThatOfTheForces) {
    for (const OnBox kind : all_on_box) {
        EXPECT_LT(largest_error(ContactFriction::none, kind, 30), 1e-7) << static_cast<int>(kind);
        const double most = kind == OnBox::rod ? 1e-2 : 1e-7; // shares of an element beside others stand still
        EXPECT_LT(largest_error(ContactFriction::memory, kind, 30), most) << static_cast<int>(kind);
    }
}

/// Work -m K m of a motion of all slots, with turns in radii.
double resistance(const StaticContactLoads& loads, const Heap::Motion& motion) {
    double work = 0;
    const auto add = [&](const std::vector<SlotCoupling>& couplings) {
        for (const SlotCoupling& c : couplings)
            for (std::size_t i = 0; i < slot_unknowns; ++i)
                for (std::size_t j = 0; j < slot_unknowns; ++j)
                    work += motion[6 * c.row + i] * c.block[i][j] * motion[6 * c.column + j] /
                            ((i < 3 ? 1 : radius) * (j < 3 ? 1 : radius));
    };
    add(loads.couplings);
    add(loads.turning);
    return work;
}

// Without the turns of normals and of arms, stiffness is phi'' g g^T with the gradient g of the overlap.
TEST(StaticBodies, ConvexStiffnessIsNeverNegative) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> some(-1, 1);
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        int negative = 0;
        for (int trial = 0; trial < 20; ++trial) {
            Heap heap(random, normal, ContactFriction::none);
            const StaticContactLoads whole = heap.loads(true);
            ASSERT_FALSE(whole.contacts.empty());
            heap.make_convex(true);
            const StaticContactLoads convex = heap.loads(true);
            EXPECT_EQ(Heap::all(convex), Heap::all(whole)) << "loads are the same";
            for (int direction = 0; direction < 50; ++direction) {
                Heap::Motion motion(6 * heap.state.size());
                for (double& m : motion) m = some(random);
                const double of_whole = resistance(whole, motion), of_convex = resistance(convex, motion);
                EXPECT_GE(of_convex, -1e-9 * std::abs(of_whole));
                negative += of_convex > of_whole;
            }
        }
        EXPECT_GT(negative, 500) << "what is left out is negative in most directions";
    }
}

// A correction within the share leaves a pair on its side, overlapping by half a radius more at most.
TEST(StaticBodies, NothingPassesWithinTheClearShare) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> some(-1, 1);
    int cut = 0, whole = 0;
    for (int trial = 0; trial < 200; ++trial) {
        Heap heap(random, ContactNormal::linear, ContactFriction::none);
        std::vector<Slot<1>> moved = heap.state;
        const double most = std::pow(10, some(random)) * radius;
        for (Slot<1>& slot : moved)
            set_lane(slot.position, 0, lane(slot.position, 0) + most * Vec3d{some(random), some(random), some(random)});
        const double share = heap.clear_share(moved), deepest = heap.loads().largest_overlap;
        ASSERT_GT(share, 0);
        ASSERT_LE(share, 1);
        ++(share < 1 ? cut : whole);
        double largest = 0;
        for (int i = 1; i <= 50; ++i) largest = std::max(largest, heap.overlap_at(moved, i / 50.0 * share));
        EXPECT_LE(largest, deepest + 0.25 + 1e-9) << "half a radius further, over the diameter";
        if (share < 1) {
            EXPECT_GT(largest, 0.2) << "share " << share << " is cut without need";
        }
    }
    EXPECT_GT(cut, 20);
    EXPECT_GT(whole, 20);
}

} // namespace
} // namespace skein
