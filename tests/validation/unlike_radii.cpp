// Elastic contacts keep the energy of all bodies together, whatever their radii, places and angles: their forces are
// those of an energy, and an audit that closes on it shows one that is not.
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "support/meeting.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace skein {
namespace {

using test::Meeting;

constexpr double thick = 0.1; ///< m, the radius of the rod that is hit

/// A free thin rod flies down upon a free thick one that lies along x; both have vertices. In turn it meets the other
/// with a vertex, near an end of either, or anywhere.
SceneSpec meeting(double ratio, int place, ContactNormal normal) {
    std::mt19937 random(static_cast<unsigned>(place) + 1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const double radius = thick / ratio, length = 0.5,
                 angle = 1.5707963267948966 + (place == 0 ? 0 : 0.9 * uniform(random)), l = length / 50;
    double along = 0.22 * uniform(random),
           at = 0.4 * uniform(random); // of its own middle, and of that of the thick rod
    if (place % 3 == 0) along = l * std::floor(20 * uniform(random));
    if (place % 4 == 1) at = 0.1 * std::floor(4 * uniform(random));
    if (place % 4 == 2) at = uniform(random) > 0 ? 0.495 : -0.495;
    if (place % 5 == 4) along = 0.245;
    const auto rod = [&](double r, double modulus, double long_, long elements) {
        RodSpec one = test::simple_rod(elements);
        one.material = {.density = 1000, .youngs_modulus = modulus};
        one.section.radius = r;
        one.shape.length = long_;
        one.start = one.end = EndKind::free;
        return one;
    };
    RodSpec big = rod(thick, 1e6, 1, 10), thin = rod(radius, 1e8, length, 50);
    big.name = "big";
    thin.name = "thin";
    big.placement.origin = {-0.5, 0, 0};
    big.placement.tangent = {1, 0, 0};
    big.placement.normal = Vec3d{0, 0, 1};
    const Vec3d tangent{std::cos(angle), std::sin(angle), 0};
    thin.placement.tangent = tangent;
    thin.placement.normal = Vec3d{0, 0, 1};
    thin.placement.origin = Vec3d{at, 0, thick + 1.3 * radius} - (0.5 * length + along) * tangent;
    thin.shape.velocity = {0, 0, -0.5};
    SceneSpec scene;
    scene.rods = {big, thin};
    scene.contact = ContactSpec{.law = {.normal = normal, .stiffness = normal == ContactNormal::hertz ? 1e6 : 1e3}};
    scene.time = {.duration = 0.05};
    scene.output.audit = true;
    return scene;
}

/// Of contacts, by where bodies are at the time of their rates.
double potential(const Meeting& m) {
    Exposure moved = *m.around.exposure;
    for (std::size_t i = 0; i < moved.slots(); ++i) moved.node[i].position += m.clock.lag() * moved.motion[i].velocity;
    const std::vector<double> all = m.contacts->normal_energies(moved);
    return std::accumulate(all.begin(), all.end(), 0.0);
}
/// Kinetic and elastic energy and that of contacts, less what loads have done.
double balance(const Meeting& m) {
    double sum = m.energy() + potential(m);
    for (std::size_t i = 0; i < m.rods->local().size(); ++i) {
        const RodBudget budget = m.rods->budget(i);
        sum += budget.dissipated - budget.loads - budget.walls;
    }
    return sum;
}

/// With steps that are so many times shorter than the automatic one.
SceneSpec meeting_in_parts(SceneSpec scene, int refinement) {
    if (refinement > 1) scene.time.dt = make_plan(scene, make_groups(scene), {}).dt / refinement;
    return scene;
}

/// Change of the energy over a whole meeting, and the largest one of the audit's balance on the way; over the energy at
/// the start.
struct Changes {
    double energy, balance;
};
Changes changes(const SceneSpec& scene, int refinement) {
    Meeting m(meeting_in_parts(scene, refinement));
    const double before = m.energy();
    Changes found{0, 0};
    bool touching = true;
    for (int part = 0; part < 400 && (touching || !m.touched); ++part) {
        m.advance(8 * refinement);
        found.balance = std::max(found.balance, std::abs(balance(m) - before) / before);
        touching = potential(m) > 0;
    }
    EXPECT_TRUE(m.touched);
    found.energy = std::abs(m.energy() + potential(m) - before) / before;
    return found;
}

void expect_kept(double ratio, double bar, std::initializer_list<int> refinements) {
    for (int place = 0; place < 30; ++place) {
        const ContactNormal normal = place % 2 ? ContactNormal::hertz : ContactNormal::linear;
        for (const int refinement : refinements) {
            const Changes found = changes(meeting(ratio, place, normal), refinement);
            EXPECT_LT(found.energy, bar) << "place " << place << ", step over " << refinement;
            EXPECT_LT(found.balance, bar) << "place " << place << ", step over " << refinement;
        }
    }
}

TEST(UnlikeRadii, KeepTheEnergyAtOneHundredToOne) { expect_kept(100, 1e-3, {1, 2, 4}); }
TEST(UnlikeRadii, KeepTheEnergyAtTenToOne) { expect_kept(10, 1e-4, {1, 2, 4}); }
TEST(UnlikeRadii, KeepTheEnergyOfLikeOnes) { expect_kept(1, 3.3e-5, {1}); }

/// Largest balance of the audit over the energy at the start, with a force across contacts of this share of theirs; and
/// what that has done. It is the force of no energy.
struct Audited {
    double balance, done;
};
Audited audited(double share, int refinement) {
    const SceneSpec scene = meeting_in_parts(meeting(10, 3, ContactNormal::hertz), refinement);
    Meeting m(scene);
    const double before = m.energy();
    Audited found{0, 0};
    for (int step = 0; step < 2000 * refinement; ++step) {
        const auto batch = m.clock.next(m.clock.done() + 1, 1);
        m.rods->drift(batch.front());
        m.contacts->evaluate(*m.around.exposure, batch.front().time, batch.front().kick, *m.around.loads);
        if (m.contacts->figures().active > 0)
            for (std::size_t i = 0; i < m.around.loads->load.size(); ++i) {
                Vec3d& force = m.around.loads->load[i].force;
                const Vec3d velocity = m.around.exposure->motion[i].velocity,
                            across{0, 0, share * norm(force) * (velocity.z > 0)};
                force += across;
                found.done += batch.front().kick * dot(across, velocity) / before;
            }
        m.rods->kick(batch.front(), false);
        m.clock.advance(batch);
        found.balance = std::max(found.balance, std::abs(balance(m) - before) / before);
    }
    return found;
}

// The defect of the scheme is of the second order in the step, that of a force of no energy is what it has done.
TEST(UnlikeRadii, AuditShowsAForceThatIsNoGradient) {
    const double whole = audited(0, 1).balance, half = audited(0, 2).balance, quarter = audited(0, 4).balance;
    EXPECT_LT(whole, 1e-4);
    EXPECT_GT(whole / half, 3.5) << whole;
    EXPECT_GT(half / quarter, 3.5) << half;
    for (const int refinement : {1, 4}) {
        const Audited wrong = audited(0.01, refinement);
        EXPECT_GT(wrong.done, 1e-3);
        EXPECT_NEAR(wrong.balance, wrong.done, whole + 0.02 * wrong.done) << refinement;
    }
}

} // namespace
} // namespace skein
