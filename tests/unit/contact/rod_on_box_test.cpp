// Rods on boxes: distances of their features, forces that are those of an energy and have no jump, and closed forms,
// which do not depend on how a rod is cut into elements.
#include "contact/segment_meeting.hpp"

#include "contact/contact_solver.hpp"
#include "support/exposed_bodies.hpp"
#include "support/turned_frame.hpp"

#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

constexpr double stiffness = 1e5, step = 1e-5, rod_radius = 0.2, box_radius = 0.3, reach = rod_radius + box_radius;
using test::turned_by, test::upright;

struct RodAndBox {
    std::vector<Vec3d> node;
    Vec3d half{1, 1, 1}, centre{0, 0, 0};
    Mat3d axes = upright;

    /// Of the axis from the box without its rounding; below 0 within.
    double distance() const {
        double least = HUGE_VAL;
        for (std::size_t k = 0; k + 1 < node.size(); ++k)
            for (int i = 0; i <= 2000; ++i) {
                const Vec3d x = node[k] + i / 2000.0 * (node[k + 1] - node[k]);
                least = std::min(least, nearest_on_box(axes * (x - centre), half).distance);
            }
        return least;
    }
};

/// A rod and a body of one part, as they are exposed.
class Stage {
public:
    Stage(const RodAndBox& scene, const ContactLaw& law) : slots_(scene.node.size()) {
        bodies_.add(scene.node, rod_radius);
        bodies_.add(std::vector<Vec3d>(2, scene.centre), norm(scene.half) + box_radius);
        ContactScene all = bodies_.scene(law);
        all.boxes = {{}, {{scene.half, box_radius}}};
        all.masses = {1, 2};
        solver = make_contacts(std::move(all), threads_);
        solver->evaluate(exposure(scene), 0, step, loads);
    }
    Exposure exposure(const RodAndBox& scene) const {
        Exposure all = bodies_.exposure();
        for (std::size_t i = 0; i < slots_; ++i) all.node[i].position = scene.node[i];
        for (const std::size_t i : {slots_, slots_ + 1}) all.node[i].position = scene.centre;
        all.motion[slots_ + 1] = {.velocity = scene.axes.d1, .spin = scene.axes.d2};
        return all;
    }
    double energy(const RodAndBox& scene) const {
        double sum = 0;
        for (const double e : solver->normal_energies(exposure(scene))) sum += e;
        return sum;
    }
    Vec3d force(std::size_t node) const { return loads.load[node].force; }
    Vec3d force_on_rod() const {
        Vec3d sum{0, 0, 0};
        for (std::size_t i = 0; i < slots_; ++i) sum += force(i);
        return sum;
    }
    Vec3d force_on_box() const { return force(slots_) + force(slots_ + 1); }
    Vec3d couple_on_box() const { return loads.load[slots_].couple; }

    SlotLoads loads;
    std::unique_ptr<ContactSolver> solver;

private:
    test::BodiesByHand bodies_;
    Threads threads_{1};
    std::size_t slots_;
};

ContactLaw elastic(ContactNormal normal) { return {.normal = normal, .stiffness = stiffness}; }

/// Rods of one to four elements that touch a box: lying on its faces, across its edges, beside its vertices.
class RandomRods {
public:
    Vec3d vector() { return {normal_(random_), normal_(random_), normal_(random_)}; }

    /// `tilt`: against a face, and of elements against each other.
    RodAndBox next(double tilt) {
        RodAndBox all;
        const auto side = [&] { return 0.5 + std::abs(normal_(random_)); };
        all.half = {side(), side(), count_ % 7 == 0 ? 0 : side()};
        all.centre = {0.1, -0.2, 0.3};
        all.axes = turned_by(upright, vector());
        const auto to_lab = [&](const Vec3d& v) { return transpose_times(all.axes, v); };
        const int elements = 1 + count_ % 4;
        const Vec3d flat = {normal_(random_), count_ % 3 == 0 ? 0 : normal_(random_), 0}, // or along an edge
            along = unit(flat + tilt * vector());
        std::vector<Vec3d> chain{{0, 0, 0}};
        Vec3d middle{0, 0, 0};
        for (int k = 0; k < elements; ++k) {
            chain.push_back(chain.back() + (0.8 + 0.2 * std::abs(normal_(random_))) * unit(along + tilt * vector()));
            middle += (1.0 / elements) * 0.5 * (chain[chain.size() - 2] + chain.back());
        }
        // Over a face, an edge or a vertex.
        Vec3d below{0.5 * normal_(random_), 0.5 * normal_(random_), 0}, way{0, 0, 1};
        if (count_ % 5 == 1) below.x = all.half.x;
        if (count_ % 5 == 2)
            below = {all.half.x - 0.03, all.half.y + 0.02, 0}; // right over them second derivatives jump
        if (count_ % 5 == 3) way = unit({1, 0, 1});
        if (count_ % 5 == 4) way = unit(vector());
        double low = 0, high = 10;
        for (int i = 0; i < 40; ++i) {
            const double height = 0.5 * (low + high);
            all.node.clear();
            for (const Vec3d& x : chain) all.node.push_back(all.centre + to_lab(x - middle + below + height * way));
            (all.distance() > 0.9 * reach ? high : low) = height;
        }
        ++count_;
        return all;
    }

private:
    std::mt19937 random_{17};
    std::normal_distribution<double> normal_;
    int count_ = 0;
};

TEST(BoxDistance, OfAPointIsThatToItsFoot) {
    const Vec3d half{1, 2, 3};
    const BoxPoint face = nearest_on_box({0.5, 0.5, 5}, half), corner = nearest_on_box({2, 3, 4}, half),
                   inside = nearest_on_box({0.9, 0, 0}, half);
    EXPECT_EQ(face.distance, 2);
    EXPECT_EQ(face.outwards.z, 1);
    EXPECT_EQ(face.on_box.z, 3);
    EXPECT_NEAR(corner.distance, std::sqrt(3.0), 1e-15);
    EXPECT_NEAR(inside.distance, -0.1, 1e-15);
    EXPECT_EQ(inside.outwards.x, 1);
    EXPECT_EQ(inside.on_box.x, 1);
}

TEST(RodOnBox, TheDeepestFeatureHasTheDistanceOfTheElement) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto vector = [&] { return Vec3d{normal(random), normal(random), normal(random)}; };
    int touching = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        Vec3d p = 1.5 * vector(), d = vector();
        RodAndBox all;
        all.half = {std::abs(normal(random)), std::abs(normal(random)), trial % 5 == 3 ? 0 : std::abs(normal(random))};
        if (trial % 5 == 1) d.x = 0;
        if (trial % 5 == 2) d.x = d.z = 0;
        all.node = {p, p + d};
        const double distance = all.distance();
        if (distance < 0.01 * reach) continue;
        const SegmentMeeting meeting({p, d, {1, 1}}, all.half, reach, ContactNormal::linear);
        EXPECT_NEAR(meeting.deepest(), std::max(0.0, reach - distance), 1e-5 + 1e-6 / distance) << trial;
        if (distance > 0.99 * reach) continue;
        ++touching;
        const double one = SegmentMeeting::energy_of(ContactNormal::linear, meeting.deepest());
        EXPECT_GT(meeting.energy(), 0.9 * one) << trial;
    }
    EXPECT_GT(touching, 200);
}

// Central differences of fourth order. Second derivatives jump, so a step that passes such a place is halved.
TEST(RodOnBox, ForcesAreThoseOfTheEnergy) {
    RandomRods random;
    const Vec3d axis[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    int touching = 0;
    for (int trial = 0; trial < 360; ++trial) {
        const double tilt[] = {0.5, 0.1, 0.01, 0};
        const RodAndBox here = random.next(tilt[trial / 5 % 4]);
        if (here.distance() < 0.3 * reach) continue;
        const Stage stage(here, elastic(trial % 4 < 2 ? ContactNormal::linear : ContactNormal::hertz));
        const double force = norm(stage.force_on_rod());
        if (force == 0) continue;
        ++touching;
        double least = HUGE_VAL;
        for (double h = 1e-4; h > 2e-6 && least > 1e-8; h *= 0.5) {
            double off = 0;
            const auto compare = [&](auto&& moved, double found) {
                const auto energy = [&](double by) {
                    RodAndBox other = here;
                    moved(other, by);
                    return stage.energy(other);
                };
                const double near = (energy(h) - energy(-h)) / (2 * h),
                             wide = (energy(2 * h) - energy(-2 * h)) / (4 * h);
                off = std::max(off, std::abs(found + (4 * near - wide) / 3));
            };
            for (const Vec3d& e : axis) {
                for (std::size_t k = 0; k < here.node.size(); ++k)
                    compare([&](RodAndBox& other, double by) { other.node[k] += by * e; }, dot(stage.force(k), e));
                compare([&](RodAndBox& other, double by) { other.centre += by * e; }, dot(stage.force_on_box(), e));
                compare([&](RodAndBox& other, double by) { other.axes = turned_by(other.axes, by * e); },
                        dot(stage.couple_on_box(), e));
            }
            least = std::min(least, off / force);
        }
        EXPECT_LT(least, 1e-8) << trial;
    }
    EXPECT_GT(touching, 250);
}

TEST(RodOnBox, KeepsMomenta) {
    RandomRods random;
    const ContactLaw law = test::some_law(ContactNormal::hertz, ContactFriction::memory);
    for (int trial = 0; trial < 100; ++trial) {
        const RodAndBox here = random.next(trial % 2 ? 0.3 : 0);
        Stage stage(here, law);
        Exposure moving = stage.exposure(here);
        for (std::size_t k = 0; k < here.node.size(); ++k)
            moving.motion[k] = {.velocity = random.vector(), .spin = random.vector()};
        moving.motion[here.node.size()] = {.velocity = random.vector(), .spin = random.vector()};
        stage.solver->evaluate(moving, 0, step, stage.loads);
        Vec3d couple = stage.couple_on_box() + cross(here.centre, stage.force_on_box());
        for (std::size_t k = 0; k < here.node.size(); ++k)
            couple += cross(here.node[k], stage.force(k)) + stage.loads.load[k].couple;
        const double scale = norm(stage.force_on_rod()) + 1e-3 * stiffness;
        EXPECT_LT(norm(stage.force_on_rod() + stage.force_on_box()), 1e-14 * scale) << trial;
        EXPECT_LT(norm(couple), 1e-13 * scale) << trial;
    }
}

// A rod moves past the box. With steps a fourth as long forces change by a fourth as much from one to the next; a jump
// would stay.
TEST(RodOnBox, ForcesHaveNoJump) {
    RandomRods random;
    const auto largest_change = [](const RodAndBox& start, const Vec3d& way, const Vec3d& turn, int steps) {
        Vec3d before{0, 0, 0};
        double most = 0;
        const Stage stage(start, elastic(ContactNormal::linear));
        SlotLoads loads;
        for (int i = 0; i <= steps; ++i) {
            RodAndBox here = start;
            const double share = 2.0 * i / steps - 1;
            for (Vec3d& x : here.node) x = here.centre + turned_by(x - here.centre, share * turn) + share * way;
            stage.solver->evaluate(stage.exposure(here), 0, step, loads);
            Vec3d force{0, 0, 0};
            for (std::size_t k = 0; k < here.node.size(); ++k)
                force += (1.0 + static_cast<double>(k)) * loads.load[k].force;
            if (i > 0) most = std::max(most, norm(force - before));
            before = force;
        }
        return most / stiffness;
    };
    for (int trial = 0; trial < 24; ++trial) {
        const double tilt[] = {0.5, 0.03, 0};
        const RodAndBox here = random.next(tilt[trial % 3]);
        if (here.distance() < 0.3 * reach) continue;
        const Vec3d away = transpose_times(here.axes, {0, 0, 1}), along = 0.3 * cross(away, random.vector()),
                    turn = 0.02 * random.vector();
        const double coarse = largest_change(here, along, turn, 2000), fine = largest_change(here, along, turn, 8000);
        EXPECT_LT(fine, 0.3 * coarse + 1e-9) << trial << ": " << coarse;
    }
}

/// A straight rod through a place in a direction, the first node `before` it, of elements of length 1.
std::vector<Vec3d> straight(const Vec3d& through, const Vec3d& direction, double before, int elements) {
    std::vector<Vec3d> nodes;
    for (int k = 0; k <= elements; ++k) nodes.push_back(through + (k - before) * unit(direction));
    return nodes;
}

// It slides along itself over an edge or a vertex: nothing changes as one element after another is there.
TEST(RodOnBox, AContactIsASpringWhereverItIsAlongTheRod) {
    const double g = 0.02;
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const bool vertex : {false, true})
            for (int i = 0; i <= 40; ++i) {
                RodAndBox all;
                all.half = {1, 5, 1};
                const Vec3d out = vertex ? unit({1, 1, 1}) : unit({1, 0, 1}),
                            at = Vec3d{1, vertex ? 5.0 : 0.3, 1} + (reach - g) * out;
                all.node = straight(at, vertex ? Vec3d{1, 0, -1} : Vec3d{1, 0.9, -1}, 1.6 + 0.05 * i, 5);
                const Stage stage(all, elastic(normal));
                const double closed = normal == ContactNormal::linear ? stiffness * g : stiffness * g * std::sqrt(g);
                EXPECT_LT(norm(stage.force_on_rod() - closed * out), 1e-11 * closed) << i;
                EXPECT_NEAR(stage.solver->figures().weight, 1, 1e-5) << i;
            }
}

// Each node over the face is a spring, and so is each edge that the rod passes.
TEST(RodOnBox, LiesOnNodesAndEdges) {
    const double g = 0.01;
    for (int elements = 1; elements < 6; ++elements) {
        RodAndBox all;
        all.half = {2, 2, 1};
        all.node = straight({0, 0.3, 1 + reach - g}, {1, 0, 0}, 0.5 * elements, elements);
        const int over = elements < 4 ? elements + 1 : elements == 4 ? 5 : 6;
        const Stage stage(all, elastic(ContactNormal::linear));
        EXPECT_NEAR(stage.force_on_rod().z, over * stiffness * g, 1e-10 * stiffness * g) << elements;
        EXPECT_LT(std::hypot(stage.force_on_rod().x, stage.force_on_rod().y), 1e-10 * stiffness * g);
        EXPECT_LT(norm(stage.couple_on_box() + cross({0, 0.3, 1}, stage.force_on_rod())), 1e-9 * stiffness * g);
    }
}

TEST(RodOnBox, WithoutLengthIsABall) {
    RodAndBox all;
    const double g = 0.02;
    const Vec3d out = unit({1, 2, 2});
    all.node = {Vec3d{1, 1, 1} + (reach - g) * out, Vec3d{1, 1, 1} + (reach - g) * out};
    const Stage stage(all, elastic(ContactNormal::linear));
    EXPECT_LT(norm(stage.force_on_rod() - stiffness * g * out), 1e-12 * stiffness * g);
}

// An axis that has come into the box without its rounding is pushed out by the shortest way.
TEST(RodOnBox, IsPushedOutOfTheInside) {
    RodAndBox all;
    all.half = {1, 1, 1};
    all.node = straight({0.9, 0, 1}, {1, 0, -1}, 1.5, 3);
    const Stage stage(all, elastic(ContactNormal::linear));
    const Vec3d force = stage.force_on_rod();
    EXPECT_GT(std::max(force.x, force.z), stiffness * reach);
    EXPECT_GE(std::min(force.x, force.z), 0);
}

} // namespace
} // namespace skein
