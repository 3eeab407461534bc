// Contacts at rest: forces equal those of a step without rates, and are minus the gradient of the energy; the stiffness
// is that of the forces.
#include "contact/contact_spec.hpp"
#include "contact/static_contacts.hpp"
#include "core/second_order.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace skein {
namespace {

constexpr double length = 75.74e-3, radius = 1.2075e-3, diameter = 2 * radius; // of the nest's rods
constexpr double stiffness = 3.1623e6;
constexpr double pi = std::numbers::pi;
using Nodes = std::vector<Vec3d>;

struct Chain {
    Nodes nodes;
    double radius;
    bool closed = false; ///< the last node is not the first once more
};

RodGroup group_of(const Chain& chain, int id) {
    RodSpec spec = test::simple_rod(static_cast<long>(chain.nodes.size()) - !chain.closed);
    spec.section.radius = chain.radius;
    spec.shape.length = length;
    spec.shape.closed = chain.closed;
    return RodGroup(spec, id, id, "");
}

/// Chains at rest, and the same before a step.
class AtRest {
public:
    explicit AtRest(const std::vector<Chain>& chains, ContactNormal normal = ContactNormal::hertz, bool self = false,
                    bool reversed = false) {
        std::vector<ContactLaw> laws;
        for (std::size_t i = 0; i < chains.size(); ++i) {
            groups_.push_back(group_of(chains[i], static_cast<int>(i)));
            rods_.push_back({static_cast<std::int64_t>(i), static_cast<int>(i), 0});
            for (std::size_t j = 0; j < chains.size(); ++j)
                laws.push_back(
                    {.normal = normal, .stiffness = stiffness / static_cast<double>(1 + i + j), .damping = 20});
        }
        if (reversed) std::reverse(rods_.begin(), rods_.end());
        for (const LocalRod& rod : rods_)
            for (std::size_t k = 0; k < to_index(nth(groups_, rod.group).slots()); ++k) {
                const Nodes& nodes = nth(chains, rod.group).nodes;
                set_lane(state.emplace_back().position, 0, nodes[k % nodes.size()]);
            }
        scene_ = std::make_unique<ContactScene>(
            contact_scene(groups_, {.self = self}, ContactLaws(groups_.size(), std::move(laws))));
        contacts_ = make_static_contacts(*scene_, groups_, rods_, threads_);
    }

    StaticContactLoads loads(bool with_stiffness = false) {
        StaticContactLoads out;
        contacts_->evaluate(state, with_stiffness, out);
        return out;
    }
    StaticContactLoads loads_moved(const Nodes& by, double share) {
        const std::vector<Slot<1>> here = state;
        for (std::size_t s = 0; s < state.size(); ++s)
            set_lane(state[s].position, 0, lane(here[s].position, 0) + share * by[s]);
        const StaticContactLoads out = loads();
        state = here;
        return out;
    }
    Nodes random_motion(std::mt19937& random) const {
        std::uniform_real_distribution<double> uniform(-1, 1);
        Nodes all(state.size());
        for (Vec3d& u : all) u = {uniform(random), uniform(random), uniform(random)};
        return all;
    }

    struct Step {
        Nodes force;
        double energy;
        std::int64_t active;
    };
    /// The same of the solver of a step.
    Step step() const {
        Exposure bodies(groups_, rods_);
        const auto for_slots = [&](auto&& f) { // f(slot of the state, slot of the exposure, node)
            std::size_t first = 0;
            for (std::size_t i = 0; i < rods_.size(); ++i) {
                const Window& w = bodies.window[bodies.number_of_own(i)];
                const std::size_t nodes = to_index(nth(groups_, w.group).nodes());
                for (std::size_t k = 0; k < w.slots; ++k) f(first + k, w.first_slot + k, first + k % nodes);
                first += w.slots;
            }
        };
        for_slots(
            [&](std::size_t s, std::size_t at, std::size_t) { bodies.node[at].position = lane(state[s].position, 0); });
        const auto contacts = make_contacts(*scene_, threads_);
        SlotLoads loads;
        contacts->evaluate(bodies, 0, 1e-6, loads);
        Step out{Nodes(state.size(), {0, 0, 0}), 0, contacts->figures().active};
        for (const double energy : contacts->normal_energies(bodies)) out.energy += energy;
        for_slots([&](std::size_t, std::size_t at, std::size_t node) {
            if (nth(loads.touched, bodies.window_of[at])) out.force[node] += loads.load[at].force;
        });
        return out;
    }

    std::vector<Slot<1>> state;

private:
    inline static const Threads threads_{1};
    std::vector<RodGroup> groups_;
    std::vector<LocalRod> rods_;
    std::unique_ptr<ContactScene> scene_;
    std::unique_ptr<StaticContacts> contacts_;
};

double size_of(const Nodes& x) {
    double most = 0;
    for (const Vec3d& one : x) most = std::max(most, norm(one));
    return most;
}
double distance(const Nodes& x, const Nodes& y) {
    double most = 0;
    for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, norm(x[i] - y[i]));
    return most;
}
double product(const Nodes& x, const Nodes& y) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += dot(x[i], y[i]);
    return sum;
}
Nodes times(const StaticContactLoads& loads, const Nodes& u) {
    Nodes sum(u.size(), {0, 0, 0});
    for (const SlotCoupling& c : loads.couplings) {
        const Vec3d& x = u[c.column];
        const auto row = [&](std::size_t i) { return c.block[i][0] * x.x + c.block[i][1] * x.y + c.block[i][2] * x.z; };
        sum[c.row] += Vec3d{row(0), row(1), row(2)};
    }
    return sum;
}

/// Largest errors over many states.
struct Errors {
    double force = 0, energy = 0, gradient = 0, stiffness = 0, symmetry = 0, motion = 0;
    int compared = 0, reliable = 0;

    void take_all(AtRest& rods, std::mt19937& random) {
        const StaticContactLoads here = rods.loads(true);
        const AtRest::Step step = rods.step();
        const double size = size_of(step.force);
        if (size == 0) {
            EXPECT_EQ(size_of(here.force), 0);
            return;
        }
        ++compared;
        EXPECT_GE(static_cast<std::int64_t>(here.contacts.size()), step.active);
        take(force, distance(here.force, step.force) / size);
        take(energy, std::abs(here.energy - step.energy) / step.energy);
        take_motions(rods, here, random);
        take_differences(rods, here, random);
    }

private:
    static void take(double& most, double error) { most = std::max(most, error); }
    static double largest(const StaticContactLoads& loads) {
        double most = 0;
        for (const SlotCoupling& c : loads.couplings)
            for (const auto& row : c.block)
                for (const double k : row) most = std::max(most, std::abs(k));
        return most;
    }
    /// Motions as a whole turn the forces with them.
    void take_motions(const AtRest& rods, const StaticContactLoads& here, std::mt19937& random) {
        const Nodes some = rods.random_motion(random), other = rods.random_motion(random);
        const double size = largest(here);
        take(symmetry, std::abs(product(other, times(here, some)) - product(some, times(here, other))) / size);
        take(motion, size_of(times(here, Nodes(some.size(), some[0]))) / size);
        Nodes turn(some.size()), expected(some.size());
        for (std::size_t s = 0; s < turn.size(); ++s) {
            turn[s] = cross(some[0], lane(rods.state[s].position, 0));
            expected[s] = -cross(some[0], here.force[s]);
        }
        take(motion, distance(times(here, turn), expected) / (size * length));
    }
    /// Differences of fourth order at two steps, which agree where they are reliable.
    void take_differences(AtRest& rods, const StaticContactLoads& here, std::mt19937& random) {
        const Nodes u = rods.random_motion(random);
        const double size = largest(here);
        const auto slopes = [&](double h) {
            const StaticContactLoads at[4] = {rods.loads_moved(u, -h), rods.loads_moved(u, h),
                                              rods.loads_moved(u, -2 * h), rods.loads_moved(u, 2 * h)};
            const auto slope = [&](auto&& of) {
                return (1 / (12 * h)) * (8.0 * (of(at[1]) - of(at[0])) - (of(at[3]) - of(at[2])));
            };
            Nodes by_force(u.size());
            for (std::size_t s = 0; s < u.size(); ++s)
                by_force[s] = slope([&](const StaticContactLoads& loads) { return loads.force[s]; });
            return std::pair(by_force, slope([](const StaticContactLoads& loads) { return loads.energy; }));
        };
        for (const double h : {4e-4 * diameter, 1e-4 * diameter, 2e-5 * diameter, 4e-6 * diameter}) {
            const auto [coarse, coarse_energy] = slopes(2 * h);
            const auto [fine, fine_energy] = slopes(h);
            if (distance(coarse, fine) > 3e-9 * size) continue;
            ++reliable;
            Nodes change = times(here, u);
            for (Vec3d& f : change) f = -f;
            take(stiffness, distance(change, fine) / size);
            take(gradient, std::abs(product(here.force, u) + fine_energy) / size_of(here.force));
            return;
        }
    }
};

void expect_exact(const Errors& errors, int compared, double reliable = 0.8) {
    EXPECT_LT(errors.force, 1e-10);
    EXPECT_LT(errors.energy, 1e-10);
    EXPECT_LT(errors.gradient, 1e-8);
    EXPECT_LT(errors.stiffness, 1e-8);
    EXPECT_LT(errors.symmetry, 1e-13);
    EXPECT_LT(errors.motion, 1e-12);
    EXPECT_GE(errors.compared, compared);
    EXPECT_GE(errors.reliable, reliable * errors.compared);
}

Nodes moved(Nodes nodes, const Vec3d& by) {
    for (Vec3d& x : nodes) x += by;
    return nodes;
}
Nodes turned_about_z(Nodes nodes, double angle) {
    for (Vec3d& x : nodes)
        x = {std::cos(angle) * x.x - std::sin(angle) * x.y, std::sin(angle) * x.x + std::cos(angle) * x.y, x.z};
    return nodes;
}
/// A crooked rod about its middle, with a turn of up to `bend` at each vertex.
Nodes crooked(int elements, double bend, double turn, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    Vec3d way{std::cos(turn), std::sin(turn), 0};
    Nodes nodes{{0, 0, 0}};
    for (int k = 0; k < elements; ++k) {
        nodes.push_back(nodes.back() + (length / elements) * way);
        way = unit(way + bend * Vec3d{uniform(random), uniform(random), uniform(random)});
    }
    return moved(nodes, -nodes[nodes.size() / 2]);
}
Nodes straight(int elements, double l) {
    Nodes nodes;
    for (int k = 0; k <= elements; ++k) nodes.push_back({l * k, 0, 0});
    return nodes;
}
ContactNormal kind(int trial) { return trial % 2 ? ContactNormal::hertz : ContactNormal::linear; }

// Crossing, at shallow angles and side by side, straight and crooked, of like radii and of unlike ones.
TEST(ContactEnergy, IsThatOfStepsOfCrookedRods) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Errors errors;
    for (int trial = 0; trial < 600; ++trial) {
        const double ratios[] = {1, 3, 10, 33}, ratio = ratios[trial % 4], thick = ratio * radius, l = length / 5,
                     angles[] = {1.4, 0.3, 0, pi},
                     angle = (trial / 4 % 4 >= 2 ? 0.06 : 0.15) * uniform(random) + angles[trial / 4 % 4],
                     bend = trial % 5 == 0  ? 0
                            : trial % 5 < 3 ? 0.03
                                            : 0.3;
        Nodes a = crooked(5, bend, 0, random), b = crooked(4, 0.2 * bend, angle, random);
        for (Vec3d& x : b) x = std::sqrt(ratio) * x;
        a = moved(a, {l * uniform(random), l * uniform(random), (0.95 + 0.03 * uniform(random)) * (radius + thick)});
        AtRest rods({{a, radius}, {b, thick}}, kind(trial));
        errors.take_all(rods, random);
    }
    expect_exact(errors, 350);
}

// One element each, then two, at all places, ends and angles.
TEST(ContactEnergy, IsThatOfStepsOfShortChains) {
    std::mt19937 random(8);
    std::normal_distribution<double> normal;
    const auto vector = [&] { return Vec3d{normal(random), normal(random), normal(random)}; };
    Errors errors;
    for (int trial = 0; trial < 1000; ++trial) {
        const double l = (trial % 3 ? 3 : 1) * diameter, thick = (trial % 5 ? 1 : 2.5) * radius;
        const auto chain = [&](int elements) {
            Nodes nodes{{0, 0, 0}};
            for (int k = 0; k < elements; ++k) nodes.push_back(nodes.back() + l * unit(vector()));
            return moved(nodes, -nodes[nodes.size() / 2]);
        };
        const Nodes a = chain(1 + trial % 3), b = moved(chain(1 + trial / 3 % 2), 0.5 * diameter * vector());
        AtRest rods({{a, radius}, {b, thick}}, kind(trial));
        errors.take_all(rods, random);
    }
    expect_exact(errors, 600);
}

TEST(ContactEnergy, IsThatOfStepsOfStraightRods) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Errors errors;
    const double l = length / 8;
    for (int trial = 0; trial < 200; ++trial) { // crossing within elements and at vertices
        const double at = trial % 3 ? uniform(random) : 1e-3 * uniform(random);
        AtRest rods({{moved(straight(8, l), {(at - 4) * l, 0, 0}), radius},
                     {turned_about_z(moved(straight(8, l), {(0.5 * uniform(random) - 4) * l, 0, 0.9 * diameter}),
                                     1.2 + uniform(random)),
                      radius}},
                    kind(trial));
        errors.take_all(rods, random);
    }
    for (int trial = 0; trial < 100; ++trial) { // side by side, parallel and nearly so, either way round
        Nodes b = turned_about_z(straight(5, l), trial % 4 ? 0.05 * uniform(random) : 0);
        if (trial % 3 == 0) std::reverse(b.begin(), b.end());
        AtRest rods({{straight(5, l), radius}, {moved(b, {3 * l * uniform(random), 0, 0.9 * diameter}), radius}},
                    kind(trial));
        errors.take_all(rods, random);
    }
    for (int trial = 0; trial < 100; ++trial) { // end to end
        const Nodes b = turned_about_z(straight(3, l), trial % 4 ? 0.3 * uniform(random) : 1e-3 * uniform(random));
        const Vec3d gap{3 * l + 0.9 * diameter, 0.2 * diameter * uniform(random), 0.2 * diameter * uniform(random)};
        AtRest rods({{straight(3, l), radius}, {moved(b, gap), radius}}, kind(trial));
        errors.take_all(rods, random);
    }
    expect_exact(errors, 350);
}

// Forces of parallel elements are those of one of two points that are equally far, as a step chooses it.
TEST(ContactEnergy, IsThatOfStepsAtTinyAngles) {
    std::mt19937 random(10);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Errors errors;
    for (int digits = 3; digits <= 12; ++digits)
        for (int trial = 0; trial < 20; ++trial) {
            const Nodes b =
                turned_about_z(straight(5, length / 8), std::pow(10, -digits) * (1.5 + 0.5 * uniform(random)));
            const Vec3d by{0.3 * length * uniform(random), 1e-3 * diameter * uniform(random), 0.9 * diameter};
            AtRest rods({{straight(5, length / 8), radius}, {moved(b, by), radius}}, kind(trial));
            errors.take_all(rods, random);
        }
    EXPECT_LT(errors.force, 1e-10);
    EXPECT_LT(errors.energy, 1e-10);
    EXPECT_LT(errors.symmetry, 1e-13);
    EXPECT_LT(errors.motion, 1e-6); // the normal of both has lost 1/sine of its digits
    EXPECT_GT(errors.compared, 150);
}

// A corner that the other rod touches from outside, and coils that lie on each other.
TEST(ContactEnergy, IsThatOfStepsOfBentRods) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Errors errors;
    for (int trial = 0; trial < 100; ++trial) {
        const double bend = 0.6 + 0.5 * uniform(random), l = 0.5 * length;
        const Nodes corner{{-l * std::cos(0.5 * bend), 0, -l * std::sin(0.5 * bend)},
                           {0, 0, 0},
                           {l * std::cos(0.5 * bend), 0, -l * std::sin(0.5 * bend)}};
        const Nodes other = turned_about_z(moved(straight(8, length / 8), {-0.5 * length, 0, 0}), uniform(random));
        AtRest rods({{corner, radius}, {moved(other, {3e-4, 0, 0.9 * diameter}), radius}}, kind(trial));
        errors.take_all(rods, random);
    }
    for (const double angle : {0.1, 0.2, 0.35, 0.5, 0.8})
        for (int trial = 0; trial < 20; ++trial) {
            const double l = (trial % 2 ? 0.5 : 2) * diameter, coil_radius = 0.5 * l / std::sin(0.5 * angle);
            const auto coil = [&](double start) {
                Nodes nodes;
                for (double turn = start; turn < start + 5; turn += angle)
                    nodes.push_back(coil_radius * Vec3d{std::cos(turn), std::sin(turn), 0});
                return nodes;
            };
            const Nodes above = moved(coil(angle * uniform(random)), {0, 0.02 * l * uniform(random), 0.92 * diameter});
            AtRest rods({{coil(0), radius}, {above, radius}}, kind(trial));
            errors.take_all(rods, random);
        }
    expect_exact(errors, 200, 0.6);
}

// Rings that touch themselves and others, also where they close; rods in either order.
TEST(ContactEnergy, IsThatOfStepsOfRings) {
    std::mt19937 random(12);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Errors errors;
    for (int trial = 0; trial < 60; ++trial) {
        const auto eight = [&](int count) { // its halves cross in the middle
            Nodes nodes;
            const double start = 2 * pi * uniform(random);
            for (int k = 0; k < count; ++k) {
                const double t = start + 2 * pi * k / count;
                nodes.push_back(0.2 * length * Vec3d{std::sin(t), std::sin(2 * t), 0} +
                                Vec3d{0, 0, 0.46 * diameter * std::cos(t)});
            }
            return nodes;
        };
        const Nodes other =
            moved(straight(6, length / 6), {-0.5 * length, 0.02 * length * uniform(random), 1.25 * diameter});
        AtRest rods({{eight(24 + trial % 7), radius, true}, {turned_about_z(other, uniform(random)), radius}},
                    kind(trial), true, trial % 3 == 0);
        errors.take_all(rods, random);
    }
    expect_exact(errors, 50);
}

// Of x^2 y/(1 + sqrt(z)) by hand.
TEST(SecondOrder, DifferentiatesExactly) {
    using T = SecondOrder<3>;
    const double x = 1.5, y = -0.7, z = 2.25; // whose root is 1.5
    const T a = T::unknown(0, x), b = T::unknown(1, y), c = T::unknown(2, z),
            f = fma(a * a, b, T(0.0)) / (1.0 + sqrt(c));
    const double d = 2.5, slope = -1 / (d * d) / 3, curvature = 2 / (d * d * d) / 9 + 1 / (d * d) / (4 * z * 1.5);
    EXPECT_DOUBLE_EQ(f.value(), x * x * y / d);
    const double first[3] = {2 * x * y / d, x * x / d, x * x * y * slope};
    const double second[3][3] = {{2 * y / d, 2 * x / d, 2 * x * y * slope},
                                 {2 * x / d, 0, x * x * slope},
                                 {2 * x * y * slope, x * x * slope, x * x * y * curvature}};
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(f.slope(i), nth(first, i), 1e-15);
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(f.curvature(i, j), nth(nth(second, i), j), 1e-15);
    }
}

} // namespace
} // namespace skein
