// Two boxes: distances of their features, forces that are those of an energy, without a jump and the same from either
// side, and closed forms of vertex, edges and faces.
#include "contact/box_pair.hpp"

#include "contact/contact_solver.hpp"
#include "support/exposed_bodies.hpp"
#include "support/turned_frame.hpp"

#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

constexpr double stiffness = 1e5, step = 1e-5;

using test::turned_by, test::upright;

struct TwoBoxes {
    PlacedBox box[2];
    double radius[2] = {0.2, 0.3};
    Vec3d velocity[2] = {{0, 0, 0}, {0, 0, 0}}, spin[2] = {{0, 0, 0}, {0, 0, 0}};

    double reach() const { return radius[0] + radius[1]; }
    double distance_by_axes() const { return separation(box[0], box[1], true); }
};

/// Bodies of a part each, as they are exposed.
class Boxes {
public:
    Boxes(const TwoBoxes& two, const ContactLaw& law) {
        for (const int i : {0, 1}) {
            const double cover = norm(two.box[i].half) + two.radius[i];
            bodies_.add(std::vector<Vec3d>(2, two.box[i].centre), cover);
        }
        ContactScene scene = bodies_.scene(law);
        for (const int i : {0, 1}) scene.boxes.push_back({{two.box[i].half, two.radius[i]}});
        scene.masses = {1, 2};
        solver = make_contacts(std::move(scene), threads_);
        const Exposure here = exposure(two);
        solver->evaluate(here, 0, step, loads);
    }
    Exposure exposure(const TwoBoxes& two) const {
        Exposure all = bodies_.exposure();
        for (const std::size_t i : {0u, 1u}) {
            all.node[2 * i].position = all.node[2 * i + 1].position = two.box[i].centre;
            all.motion[2 * i] = {.velocity = two.velocity[i], .spin = two.spin[i]};
            all.motion[2 * i + 1] = {.velocity = two.box[i].axes.d1, .spin = two.box[i].axes.d2};
        }
        return all;
    }
    double energy(const TwoBoxes& two) const {
        double sum = 0;
        for (const double e : solver->normal_energies(exposure(two))) sum += e;
        return sum;
    }
    Vec3d force(std::size_t box) const { return loads.load[2 * box].force + loads.load[2 * box + 1].force; }
    Vec3d couple(std::size_t box) const { return loads.load[2 * box].couple; }

    SlotLoads loads;
    std::unique_ptr<ContactSolver> solver;

private:
    test::BodiesByHand bodies_;
    Threads threads_{1};
};

ContactLaw elastic(ContactNormal normal) { return {.normal = normal, .stiffness = stiffness}; }

/// Boxes that touch, the second one turned against the first by about `angle`, or some flat.
class RandomBoxes {
public:
    TwoBoxes next(double angle, bool face) {
        TwoBoxes two;
        const auto side = [&] { return 0.5 + std::abs(normal_(random_)); };
        const Mat3d frame = turned_by(upright, vector());
        two.box[0] = {{0.1, -0.2, 0.3}, frame, {side(), side(), count_ % 7 == 0 ? 0 : side()}};
        two.box[1] = {{0, 0, 0}, turned_by(frame, angle * vector()), {side(), side(), side()}};
        if (count_ % 5 == 0) two.box[1].half = two.box[0].half;
        const Vec3d beside = count_ % 3 == 0 ? Vec3d{0, 0, 0} : 0.5 * vector(), way = face ? frame.d3 : unit(vector());
        double low = 0, high = 10;
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            two.box[1].centre = two.box[0].centre + beside + middle * way;
            (two.distance_by_axes() > 0.92 * two.reach() ? high : low) = middle;
        }
        ++count_;
        return two;
    }
    Vec3d vector() { return {normal_(random_), normal_(random_), normal_(random_)}; }

private:
    std::mt19937 random_{11};
    std::normal_distribution<double> normal_;
    int count_ = 0;
};

/// Nearest points by turns on either box, as of any convex bodies.
double distance_by_turns(const PlacedBox& one, const PlacedBox& two) {
    Vec3d x = one.centre;
    double distance = 0;
    for (int i = 0; i < 20000; ++i) {
        const auto foot = [&](const PlacedBox& box) {
            const Vec3d in = box.inwards(x);
            const auto within = [](double u, double h) { return std::clamp(u, -h, h); };
            return box.centre + transpose_times(box.axes, {within(in.x, box.half.x), within(in.y, box.half.y),
                                                           within(in.z, box.half.z)});
        };
        const Vec3d before = x;
        x = foot(i % 2 ? one : two);
        distance = norm(x - before);
    }
    return distance;
}

TEST(BoxPair, TheDeepestFeatureHasTheDistanceOfTheBoxes) {
    RandomBoxes random;
    int touching = 0;
    for (int trial = 0; trial < 200; ++trial) {
        const TwoBoxes two = random.next(trial % 2 ? 1 : 0.1, trial % 4 == 0);
        const BoxMeeting meeting(two.box[0], two.box[1], two.reach());
        const double overlap = two.reach() - distance_by_turns(two.box[0], two.box[1]);
        EXPECT_NEAR(meeting.deepest(), std::max(0.0, overlap), 1e-6) << trial;
        if (overlap <= 1e-3) continue;
        ++touching;
        EXPECT_GT(meeting.overlap(), 0.94 * overlap) << trial;
        EXPECT_LT(meeting.overlap(), 1.8 * overlap) << trial << ": less than the fourth root of ten features";
    }
    EXPECT_GT(touching, 100);
}

// Central differences of fourth order. Second derivatives jump, so a step that passes such a place is halved.
TEST(BoxPair, ForcesAreThoseOfTheEnergy) {
    RandomBoxes random;
    const Vec3d axis[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    int touching = 0;
    for (int trial = 0; trial < 300; ++trial) {
        const TwoBoxes two = random.next(trial % 3 == 0 ? 1 : trial % 3 == 1 ? 0.1 : 0.01, trial % 2 == 0);
        const Boxes boxes(two, elastic(trial % 4 < 2 ? ContactNormal::linear : ContactNormal::hertz));
        const double force = norm(boxes.force(0));
        if (force == 0) continue;
        ++touching;
        double least = HUGE_VAL;
        for (double h = 1e-4; h > 2e-6 && least > 1e-8; h *= 0.5) {
            double off = 0;
            for (const std::size_t i : {0u, 1u})
                for (int k = 0; k < 6; ++k) {
                    const auto moved = [&](double by) {
                        TwoBoxes other = two;
                        PlacedBox& box = other.box[i];
                        if (k < 3) box.centre += by * axis[k];
                        else box.axes = turned_by(box.axes, by * axis[k - 3]);
                        return boxes.energy(other);
                    };
                    const double near = (moved(h) - moved(-h)) / (2 * h),
                                 wide = (moved(2 * h) - moved(-2 * h)) / (4 * h),
                                 found = dot(k < 3 ? boxes.force(i) : boxes.couple(i), axis[k % 3]);
                    off = std::max(off, std::abs(found + (4 * near - wide) / 3));
                }
            least = std::min(least, off / force);
        }
        EXPECT_LT(least, 1e-8) << trial;
    }
    EXPECT_GT(touching, 200);
}

TEST(BoxPair, IsTheSameFromEitherSide) {
    RandomBoxes random;
    for (int trial = 0; trial < 100; ++trial) {
        TwoBoxes two = random.next(trial % 2 ? 1 : 0.1, false);
        for (const int i : {0, 1}) {
            two.velocity[i] = 0.1 * random.vector();
            two.spin[i] = 0.1 * random.vector();
        }
        TwoBoxes other = two;
        std::swap(other.box[0], other.box[1]);
        std::swap(other.radius[0], other.radius[1]);
        std::swap(other.velocity[0], other.velocity[1]);
        std::swap(other.spin[0], other.spin[1]);
        const ContactLaw law = test::some_law(ContactNormal::hertz, ContactFriction::memory);
        const Boxes here(two, law), there(other, law);
        const double scale = norm(here.force(0)) + 1e-6 * stiffness;
        EXPECT_LT(norm(here.force(0) - there.force(1)), 1e-10 * scale) << trial;
        EXPECT_LT(norm(here.couple(0) - there.couple(1)), 1e-10 * scale) << trial;
        EXPECT_LT(norm(here.couple(1) - there.couple(0)), 1e-10 * scale) << trial;
        EXPECT_LT(norm(here.force(0) + here.force(1)), 1e-14 * scale) << trial;
        EXPECT_LT(norm(here.couple(0) + here.couple(1) + cross(two.box[1].centre - two.box[0].centre, here.force(1))),
                  1e-12 * scale)
            << trial;
    }
}

// The second box tumbles past the first one. With steps a fourth as long forces change by a fourth as much from one to
// the next; a jump would stay.
TEST(BoxPair, ForcesHaveNoJump) {
    RandomBoxes random;
    const auto largest_change = [](const TwoBoxes& start, const Vec3d& way, const Vec3d& turn, int steps) {
        Vec3d before{0, 0, 0}, couple_before{0, 0, 0};
        double most = 0;
        for (int i = 0; i <= steps; ++i) {
            TwoBoxes two = start;
            const double share = 2.0 * i / steps - 1;
            two.box[1].centre += share * way;
            two.box[1].axes = turned_by(two.box[1].axes, share * turn);
            if (!(two.distance_by_axes() > 0.5 * two.reach())) break; // sharp boxes are not to meet
            const BoxMeeting meeting(two.box[0], two.box[1], two.reach());
            BoxMeeting::Wrench all = meeting.change();
            const double sum = meeting.overlap() * meeting.overlap();
            if (sum == 0) all = {};
            for (const BoxMeeting::Touch& touch : meeting.touches())
                all.add(touch.gap, two.box[0].centre, two.box[1].centre,
                        touch.share * touch.overlap * touch.overlap * touch.overlap);
            const double scale = sum > 0 ? 1 / sum : 0;
            const Vec3d force = scale * all.force, couple = scale * all.couple_1;
            if (i > 0) most = std::max({most, norm(force - before), norm(couple - couple_before)});
            before = force;
            couple_before = couple;
        }
        return most;
    };
    for (int trial = 0; trial < 30; ++trial) {
        const TwoBoxes two = random.next(trial % 3 == 0 ? 1 : trial % 3 == 1 ? 0.03 : 0, trial % 2 == 0);
        // Within the plane, so that it stays in touch on the whole way.
        const Vec3d away = two.box[1].centre - two.box[0].centre, along = 0.5 * cross(unit(away), random.vector()),
                    turn = 0.02 * random.vector();
        const double coarse = largest_change(two, along, turn, 5000), fine = largest_change(two, along, turn, 20000);
        EXPECT_LT(fine, 0.3 * coarse + 1e-9) << trial << ": " << coarse;
    }
}

/// The force on the upper box, and where it acts.
struct Push {
    Vec3d force, couple;
};
Push push_on_second(const TwoBoxes& two, ContactNormal normal = ContactNormal::linear) {
    const Boxes boxes(two, elastic(normal));
    return {boxes.force(1), boxes.couple(1)};
}

TEST(BoxPair, AVertexOnAFaceIsASpring) {
    const double g = 0.01;
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        TwoBoxes two;
        two.box[0] = {{0, 0, 0}, upright, {3, 3, 1}};
        two.box[1] = {{0, 0, 0}, turned_by(turned_by(upright, {M_PI / 4, 0, 0}), {0, 0.6, 0}), {1, 1, 1}};
        Vec3d lowest{0, 0, 9};
        for (unsigned bits = 0; bits < 8; ++bits)
            if (const Vec3d v = two.box[1].vertex(bits); v.z < lowest.z) lowest = v;
        two.box[1].centre = Vec3d{0.3, 0.2, 1 + two.reach() - g} - lowest;
        const Push push = push_on_second(two, normal);
        const double closed = normal == ContactNormal::linear ? stiffness * g : stiffness * g * std::sqrt(g);
        EXPECT_NEAR(push.force.z, closed, 1e-11 * closed);
        EXPECT_LT(norm(push.couple - cross(lowest, push.force)), 1e-11 * closed);
        EXPECT_LT(std::hypot(push.force.x, push.force.y), 1e-14 * closed);
    }
}

TEST(BoxPair, EdgesThatCrossAreASpring) {
    const double g = 0.01;
    TwoBoxes two;
    two.box[0] = {{0, 0, 0}, turned_by(upright, {M_PI / 4, 0, 0}), {3, 1, 1}};
    two.box[1] = {{0.1, 0.2, 2 * std::sqrt(2.0) + two.reach() - g},
                  turned_by(turned_by(upright, {0, M_PI / 4, 0}), {0, 0, 0.3}),
                  {1, 3, 1}};
    const Push push = push_on_second(two);
    EXPECT_NEAR(push.force.z, stiffness * g, 1e-10 * stiffness * g);
    EXPECT_LT(std::hypot(push.force.x, push.force.y), 1e-12 * stiffness * g);
}

// Four vertices over a face, four crossings of edges, or eight of them: the root of their number.
TEST(BoxPair, FacesPushByTheRootOfTheNumberOfTheirPoints) {
    const double g = 0.01;
    struct Case {
        Vec3d half;
        double turn, points;
    };
    for (const auto& [half, turn, points] :
         {Case{{1, 1, 1}, 0.4, 4}, {{1, 5, 1}, 0.2, 4}, {{2.2, 2.2, 1}, M_PI / 4, 8}}) {
        TwoBoxes two;
        two.box[0] = {{0, 0, 0}, upright, {2.2, 2.2, 1}};
        two.box[1] = {{0, 0, 2 + two.reach() - g}, turned_by(upright, {0, 0, turn}), half};
        const Push push = push_on_second(two);
        EXPECT_NEAR(push.force.z, std::sqrt(points) * stiffness * g, 1e-10 * stiffness * g) << points;
        EXPECT_LT(norm(push.couple), 1e-10 * stiffness * g) << points;
    }
}

// A face that leaves another one over its edge pushes as before and not aside.
TEST(BoxPair, FacesDoNotFeelEdgesThatTheyPass) {
    const double g = 0.01;
    for (int i = 0; i <= 40; ++i) {
        TwoBoxes two;
        two.box[0] = {{0, 0, 0}, upright, {1, 1, 1}};
        two.box[1] = {{0.005 * i, 0, 2 + two.reach() - g}, upright, {1, 1, 1}};
        const Push push = push_on_second(two);
        EXPECT_NEAR(push.force.z, 2 * stiffness * g, 1e-10 * stiffness * g) << i;
        EXPECT_LT(std::abs(push.force.x), 1e-10 * stiffness * g) << i;
    }
}

TEST(BoxPair, WithoutSidesAreBalls) {
    TwoBoxes two;
    const Vec3d n = unit({1, 2, 2});
    const double g = 0.02;
    two.box[0] = {{0, 0, 0}, upright, {0, 0, 0}};
    two.box[1] = {(two.reach() - g) * n, turned_by(upright, {1, 2, 3}), {0, 0, 0}};
    const Push push = push_on_second(two);
    EXPECT_LT(norm(push.force - stiffness * g * n), 1e-12 * stiffness * g);
    EXPECT_LT(norm(push.couple), 1e-12 * stiffness * g);
}

// Faces that slip and turn against each other: friction takes its direction and its couple from both, over the radius
// of what pushes, and holds no more than mu N.
TEST(BoxPair, FrictionOpposesSlipAndTwistAlike) {
    const double g = 0.01, radius = std::sqrt(2.0); // of the smaller one's vertices
    for (const double twist : {0.0, 0.5, 1.0}) {
        TwoBoxes two;
        two.box[0] = {{0, 0, 0}, upright, {3, 3, 1}};
        two.box[1] = {{0, 0, 2 + two.reach() - g}, upright, {1, 1, 1}};
        two.spin[1] = {0, 0, 1e4 * twist / radius};
        const double arm = 1 + two.radius[1] - 0.5 * g;
        two.velocity[1] = {1e4 * (1 - twist), 0, 0};
        const ContactLaw law{.normal = ContactNormal::linear,
                             .stiffness = stiffness,
                             .friction = ContactFriction::memory,
                             .static_friction = 0.5,
                             .kinetic_friction = 0.4};
        const Boxes boxes(two, law);
        const double most = 0.4 * 2 * stiffness * g, length = std::hypot(1 - twist, twist);
        EXPECT_NEAR(boxes.force(1).x, -most * (1 - twist) / length, 1e-9 * most);
        EXPECT_NEAR(boxes.couple(1).z, -most * radius * twist / length, 1e-9 * most);
        EXPECT_NEAR(boxes.couple(1).y, arm * most * (1 - twist) / length, 1e-9 * most) << "it acts between the faces";
    }
}

// Planks that cross: no vertex of one comes into the other, so nothing pushes them back.
TEST(BoxPair, ThatIntersectHaveChangedSides) {
    TwoBoxes two;
    two.box[0] = {{0, 0, 0}, upright, {5, 0.5, 0.5}};
    two.box[1] = {{0.3, 0.2, 2}, upright, {0.5, 5, 0.5}};
    two.velocity[1] = {0, 0, -100};
    Boxes boxes(two, elastic(ContactNormal::linear));
    const auto changes_at = [&](double height) {
        two.box[1].centre.z = height;
        boxes.solver->arrived_in(0.01);
        boxes.solver->evaluate(boxes.exposure(two), 0.01, step, boxes.loads);
        return boxes.solver->side_changes();
    };
    for (const double height : {2.0, 1.3, 1.01}) EXPECT_TRUE(changes_at(height).empty()) << height;
    const auto changes = changes_at(0.9);
    ASSERT_EQ(changes.size(), 1u);
    EXPECT_EQ(changes[0].nearest, 0);
    EXPECT_NEAR(changes[0].speed, 100, 1e-9);
    EXPECT_NEAR(changes[0].energy, 0.5 * 2 / 3.0 * 1e4 + 0.5 * stiffness * two.reach() * two.reach(), 1e-6);
    EXPECT_NEAR(changes[0].diameter, 2 * 0.2, 1e-12);
}

} // namespace
} // namespace skein
