// Slopes of contacts by the motion of one body against differences of their loads.
#include "contact/contact_tangent.hpp"
#include "contact/contacts.hpp"
#include "support/exposed_bodies.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace skein {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

Matrix symmetric(const double* m) { return {{{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}}}; }
Vec3d operator*(const Matrix& m, const Vec3d& x) {
    return {m[0][0] * x.x + m[0][1] * x.y + m[0][2] * x.z, m[1][0] * x.x + m[1][1] * x.y + m[1][2] * x.z,
            m[2][0] * x.x + m[2][1] * x.y + m[2][2] * x.z};
}

/// Motion of an element: its nodes, and its turn; or the loads on them.
struct ElementMotion {
    Vec3d first, second, turn;
};

ElementMotion resist(const SlotTangent& t, const ElementMotion& u) {
    const Vec3d b_1{t.first[6], t.first[7], t.across[6]}, b_2{t.second[6], t.second[7], t.turn[6]};
    return {symmetric(t.first) * u.first + symmetric(t.across) * u.second - cross(b_1, u.turn),
            symmetric(t.across) * u.first + symmetric(t.second) * u.second - cross(b_2, u.turn),
            cross(b_1, u.first) + cross(b_2, u.second) + symmetric(t.turn) * u.turn};
}

double size(const ElementMotion& m) { return norm(m.first) + norm(m.second) + norm(m.turn); }
ElementMotion minus(const ElementMotion& a, const ElementMotion& b) {
    return {a.first - b.first, a.second - b.second, a.turn - b.turn};
}

/// Two elements, of which the second moves at rates u/h.
class TwoElements {
public:
    TwoElements(const std::vector<Vec3d>& nodes, double radius, const ContactLaw& law, double h, bool moving_first)
        : nodes_(nodes), radius_(radius), law_(law), h_(h), moved_(moving_first ? 0 : 2) {}

    struct Found {
        ElementMotion loads;
        SlotTangent tangent;
    };
    Found evaluate(const ElementMotion& u) const {
        static const Threads one(1);
        std::vector<Vec3d> x = nodes_;
        x[moved_] += u.first;
        x[moved_ + 1] += u.second;
        test::BodiesByHand rods;
        rods.add(std::span(x).first(2), radius_);
        rods.add(std::span(x).last(2), radius_);
        Exposure bodies = rods.exposure();
        bodies.motion[moved_] = {.velocity = (1 / h_) * u.first, .spin = (1 / h_) * u.turn};
        bodies.motion[moved_ + 1].velocity = (1 / h_) * u.second;
        ContactScene scene = rods.scene(law_);
        scene.has_tangents = true;
        Contacts contacts(std::move(scene), one);
        SlotLoads out;
        out.has_tangents = true;
        contacts.evaluate(bodies, 0, h_, out);
        return {{out.load[moved_].force, out.load[moved_ + 1].force, out.load[moved_].couple}, out.tangent[moved_]};
    }

private:
    std::vector<Vec3d> nodes_;
    double radius_;
    ContactLaw law_;
    double h_;
    std::size_t moved_;
};

/// Contacts whose overlap is small over the radius: left out are the changes of their normals.
TEST(ContactTangents, AreThoseOfOneBodyAlone) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto vector = [&](double size) {
        return Vec3d{size * uniform(random), size * uniform(random), size * uniform(random)};
    };
    constexpr double radius = 0.05, overlap = 1e-5, h = 1e-3;
    int touching = 0;
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const ContactFriction friction : {ContactFriction::none, ContactFriction::memory})
            for (int trial = 0; trial < 100; ++trial) {
                const double angle = trial % 4 == 0 ? 0.01 * uniform(random) : 1.5 + 0.5 * uniform(random);
                const Vec3d at{0.3 * uniform(random), 0, 2 * radius - overlap},
                    along{0.7 * std::cos(angle), 0.7 * std::sin(angle), 0};
                const ContactLaw law{.normal = normal,
                                     .stiffness = 1e5,
                                     .damping = 10,
                                     .friction = friction,
                                     .static_friction = 1e9,
                                     .kinetic_friction = 1e9,
                                     .tangential_damping = 3};
                const TwoElements pair({{-0.5, 0, 0}, {0.5, 0, 0}, at - along, at + along}, radius, law, h, trial % 2);
                const auto still = pair.evaluate({});
                if (size(still.loads) == 0) continue;
                ++touching;
                const ElementMotion u{vector(1e-9), vector(1e-9), vector(1e-8)},
                    change = minus(pair.evaluate(u).loads, still.loads), expected = resist(still.tangent, u);
                const double share = -1 / own_share_of_tangents;
                const ElementMotion by_tangent{share * expected.first, share * expected.second, share * expected.turn};
                const double whole = 1.5e5 * (normal == ContactNormal::hertz ? std::sqrt(overlap) : 1) * size(u);
                EXPECT_LT(size(minus(change, by_tangent)), 2e-2 * size(by_tangent) + 1e-4 * whole) << trial;
            }
    EXPECT_GT(touching, 300);
}

/// As steps of second order have them: pairs in the zone are counted, and loads are those without a zone.
TEST(ContactTangents, AZoneAloneCountsPairs) {
    static const Threads one(1);
    constexpr double radius = 0.05;
    for (const double gap : {-1e-5, 1e-3, 1e-2}) {
        test::BodiesByHand rods;
        const Vec3d nodes[] = {{-0.5, 0, 0}, {0.5, 0, 0}, {0, -0.5, 2 * radius + gap}, {0, 0.5, 2 * radius + gap}};
        rods.add(std::span(nodes).first(2), radius);
        rods.add(std::span(nodes).last(2), radius);
        const Exposure bodies = rods.exposure();
        Vec3d force[2];
        for (const double zone : {0.0, 5e-3}) {
            ContactScene scene = rods.scene(ContactLaw{.stiffness = 1e5});
            scene.meeting_zone = zone;
            Contacts contacts(std::move(scene), one);
            SlotLoads out;
            contacts.evaluate(bodies, 0, 1e-3, out);
            EXPECT_TRUE(out.tangent.empty());
            EXPECT_EQ(contacts.figures().near, zone > gap && zone > 0);
            force[zone > 0] = gap < 0 ? Vec3d(out.load[0].force) : Vec3d{0, 0, 0};
        }
        EXPECT_EQ(norm(force[0] - force[1]), 0);
        EXPECT_EQ(norm(force[0]) > 0, gap < 0);
    }
}

} // namespace
} // namespace skein
