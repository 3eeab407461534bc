// Twist, writhe and link against closed forms, topology, and the formulae as published.
#include "core/rotation.hpp"
#include "diagnostics/knots.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
using Line = std::vector<Vec3d>;

/// n points of a curve over one period of its parameter.
Line closed(int n, const std::function<Vec3d(double)>& at) {
    Line line;
    for (int i = 0; i < n; ++i) line.push_back(at(2 * pi * i / n));
    return line;
}

Line mirrored(Line line) {
    for (Vec3d& x : line) x.z = -x.z;
    return line;
}

/// Winds p times around the axis and q times around the tube.
Vec3d torus_knot(int p, int q, double t, double tube = 1) {
    const double r = 2 + tube * std::cos(q * t);
    return {r * std::cos(p * t), r * std::sin(p * t), -tube * std::sin(q * t)};
}

/// Total torsion over 2 pi of a closed curve, by the trapezoidal rule on fine central differences of eighth order: for
/// a smooth periodic integrand its error is that of the differences, below 1e-11 here.
double total_torsion(const std::function<Vec3d(double)>& at) {
    const int n = 4096;
    const double h = 0.01;
    const auto derivative = [h](const std::function<Vec3d(double)>& f) {
        return [f, h](double t) {
            constexpr double c[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
            Vec3d sum{0, 0, 0};
            for (int k = 1; k <= 4; ++k) sum += c[k - 1] * (f(t + k * h) - f(t - k * h));
            return (1 / h) * sum;
        };
    };
    const auto d1 = derivative(at), d2 = derivative(d1), d3 = derivative(d2);
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double t = 2 * pi * i / n;
        const Vec3d v = d1(t), b = cross(v, d2(t));
        sum += dot(b, d3(t)) / dot(b, b) * norm(v);
    }
    return sum / n; // 2 pi/n of the rule, over 2 pi
}

/// Frames across a closed curve that keep clear of `axis`, with k further turns.
Line ribbon(const Line& node, const Vec3d& axis, int k) {
    Line d1;
    for (std::size_t i = 0; i < node.size(); ++i) {
        const Vec3d t = unit(node[(i + 1) % node.size()] - node[i]);
        const Vec3d across = unit(axis - dot(axis, t) * t);
        const double angle = 2 * pi * k * (static_cast<double>(i) + 0.5) / static_cast<double>(node.size());
        d1.push_back(std::cos(angle) * across + std::sin(angle) * cross(t, across));
    }
    return d1;
}

double order(double coarse, double fine) { return std::log2(std::abs(coarse / fine)); }

TEST(Writhe, OfAPlanarCurveIsZero) {
    const Mat3d tilt = matrix(rotation(Vec3d{0.3, -1.1, 0.7}));
    for (const int n : {3, 4, 41}) {
        const Line line = closed(n, [&](double t) {
            return tilt * Vec3d{3 * std::cos(t), std::sin(t) * (1 + 0.4 * std::cos(t)), 0};
        });
        EXPECT_LT(std::abs(writhe(line, Curve::closed)), 1e-13) << n;
        EXPECT_LT(std::abs(writhe(line, Curve::open)), 1e-13) << n;
    }
}

// A simple closed curve on a sphere has total torsion 0 and self-linking 0, hence writhe 0, however crooked.
TEST(Writhe, OfACurveOnASphereVanishesAtSecondOrder) {
    const auto at = [](double t) {
        const double latitude = 0.6 * std::sin(2 * t) + 0.4 * std::sin(3 * t + 1) + 0.2;
        return Vec3d{std::cos(latitude) * std::cos(t), std::cos(latitude) * std::sin(t), std::sin(latitude)};
    };
    double before = 0;
    for (const int n : {50, 100, 200, 400}) {
        const double error = writhe(closed(n, at), Curve::closed);
        if (n > 50) {
            EXPECT_GT(order(before, error), 1.9) << n << ": " << error;
        }
        before = error;
    }
    EXPECT_LT(std::abs(before), 1e-5);
}

// Calugareanu: writhe = self-linking of the Frenet frame - total torsion/(2 pi). The first is an integer that topology
// gives (the knot linked with its push-off along the principal normal), the second a plain integral: no writhe is
// needed to know the writhe.
TEST(Writhe, OfTorusKnotsFollowsFromTheirTorsion) {
    for (const auto& [p, q] : {std::pair{2, 3}, std::pair{3, 2}, std::pair{2, 5}}) {
        const auto at = [p = p, q = q](double t) { return torus_knot(p, q, t); };
        Line centre = closed(600, at), pushed = centre;
        const double h = 1e-3;
        for (std::size_t i = 0; i < centre.size(); ++i) {
            const double t = 2 * pi * static_cast<double>(i) / 600;
            const Vec3d v = at(t + h) - at(t - h), a = at(t + h) + at(t - h) - 2.0 * at(t), tangent = unit(v);
            pushed[i] += 0.1 * unit(a - dot(a, tangent) * tangent);
        }
        const double self_linking = linking(centre, Curve::closed, pushed, Curve::closed);
        EXPECT_NEAR(self_linking, std::round(self_linking), 1e-10);
        const double exact = std::round(self_linking) - total_torsion(at);
        double before = 0;
        for (const int n : {100, 200, 400, 800}) {
            const double error = writhe(closed(n, at), Curve::closed) - exact;
            if (n > 100) {
                EXPECT_NEAR(order(before, error), 2, 0.1) << p << " " << q << ", n " << n << ": " << error;
            }
            before = error;
        }
        EXPECT_LT(std::abs(before), 8e-4) << exact;
        const Line line = closed(200, at);
        EXPECT_NEAR(writhe(mirrored(line), Curve::closed), -writhe(line, Curve::closed), 1e-12);
        EXPECT_GT(writhe(line, Curve::closed), 1);
    }
}

// Fuller: a long helix of pitch angle alpha writhes by 1 - sin(alpha) per turn.
TEST(Writhe, PerTurnOfAHelixTendsToFullersValue) {
    const double rise = 0.7, sine = rise / std::sqrt(1 + rise * rise);
    const auto helix = [&](int turns, int per_turn) {
        Line line;
        for (int i = 0; i <= turns * per_turn; ++i) {
            const double t = 2 * pi * i / per_turn;
            line.push_back({std::cos(t), std::sin(t), rise * t});
        }
        return writhe(line, Curve::open);
    };
    const auto per_turn = [&](int turns) {
        // Richardson over the second-order polygons; ends cancel between two lengths.
        const auto fine = [&](int m) { return (4 * helix(m, 60) - helix(m, 30)) / 3; };
        return (fine(2 * turns) - fine(turns)) / turns;
    };
    const double four = per_turn(4) - (1 - sine), eight = per_turn(8) - (1 - sine);
    EXPECT_LT(std::abs(eight), 1e-3);
    EXPECT_GT(order(four, eight), 1.5) << four << " " << eight;
}

TEST(Link, OfARingWithTurnsIsTheirNumber) {
    const Line ring = closed(40, [](double t) { return Vec3d{std::cos(t), std::sin(t), 0}; });
    for (const int k : {-3, -1, 0, 1, 5}) {
        const Line d1 = ribbon(ring, {0, 0, 1}, k);
        EXPECT_NEAR(twist(ring, d1, Curve::closed), k, 1e-12);
        EXPECT_NEAR(twist(ring, d1, Curve::closed) + writhe(ring, Curve::closed), k, 1e-10);
        EXPECT_NEAR(twist(mirrored(ring), mirrored(d1), Curve::closed), -k, 1e-12);
        for (const double turn : local_twist(ring, d1, Curve::closed)) EXPECT_NEAR(turn, k / 40.0, 1e-13);
    }
}

// White: while a closed ribbon bends without crossing itself, twist and writhe change and their sum does not.
TEST(Link, IsInvariantWhileTheRibbonBends) {
    for (const int k : {-2, 0, 3})
        for (const double bend : {0.0, 0.3, 0.6, 0.9, 1.2}) {
            const Line node = closed(240, [bend](double t) {
                return Vec3d{std::cos(t) * (1 + 0.3 * bend * std::cos(3 * t)),
                             std::sin(t) + 0.3 * bend * std::sin(2 * t + 1),
                             bend * (0.5 * std::sin(2 * t) + 0.3 * std::cos(3 * t))};
            });
            const Line d1 = ribbon(node, {0, 0, 1}, k);
            const double tw = twist(node, d1, Curve::closed), wr = writhe(node, Curve::closed);
            EXPECT_NEAR(tw + wr, k, 1e-10) << bend;
            if (bend > 0) {
                EXPECT_GT(std::abs(wr), 1e-3);
            }
            // the same number from the two edges of the ribbon, without any twist
            Line edge = node;
            for (std::size_t i = 0; i < node.size(); ++i)
                edge[i] += 0.01 * unit(d1[i] + d1[(i + node.size() - 1) % node.size()]);
            EXPECT_NEAR(linking(node, Curve::closed, edge, Curve::closed), k, 1e-10) << bend;
        }
}

TEST(Link, OfKnottedRibbonsIsAnInteger) {
    const Line node = closed(300, [](double t) { return torus_knot(2, 3, t, 0.7); });
    for (const int k : {-1, 0, 4}) {
        const Line d1 = ribbon(node, {0, 0, 1}, k);
        const double link = twist(node, d1, Curve::closed) + writhe(node, Curve::closed);
        EXPECT_NEAR(link, std::round(link), 1e-10);
        // Blackboard framing of the (2, 3) torus knot's projection along z: its three crossings, and k.
        EXPECT_NEAR(link, 3 + k, 1e-10);
    }
}

TEST(Linking, OfTwoCurves) {
    const Line a = closed(17, [](double t) { return Vec3d{std::cos(t), std::sin(t), 0}; });
    const Line b = closed(23, [](double t) { return Vec3d{1 + std::cos(t), 0, std::sin(t)}; });
    const Line far = closed(23, [](double t) { return Vec3d{3 + std::cos(t), 0.1, std::sin(t)}; });
    EXPECT_NEAR(std::abs(linking(a, Curve::closed, b, Curve::closed)), 1, 1e-13);
    EXPECT_NEAR(linking(a, Curve::closed, b, Curve::closed), linking(b, Curve::closed, a, Curve::closed), 1e-13);
    EXPECT_NEAR(linking(mirrored(a), Curve::closed, mirrored(b), Curve::closed),
                -linking(a, Curve::closed, b, Curve::closed), 1e-13);
    EXPECT_NEAR(linking(a, Curve::closed, far, Curve::closed), 0, 1e-13);
    // the two strands of the (2, 2k) torus link
    for (const int k : {1, 2, 3}) {
        const auto strand = [k](double shift) {
            return closed(90, [=](double t) {
                const double r = 2 + std::cos(k * t + shift);
                return Vec3d{r * std::cos(t), r * std::sin(t), -std::sin(k * t + shift)};
            });
        };
        EXPECT_NEAR(linking(strand(0), Curve::closed, strand(pi), Curve::closed), k, 1e-12);
    }
}

// The formulae as Klenin & Langowski print them: (15)-(16) for pairs of segments, (27) for the twist at a vertex.
double published_pair(const Vec3d& x1, const Vec3d& x2, const Vec3d& x3, const Vec3d& x4) {
    const Vec3d r13 = x3 - x1, r14 = x4 - x1, r23 = x3 - x2, r24 = x4 - x2;
    const Vec3d n1 = unit(cross(r13, r14)), n2 = unit(cross(r14, r24)), n3 = unit(cross(r24, r23)),
                n4 = unit(cross(r23, r13));
    const double angle =
        std::asin(dot(n1, n2)) + std::asin(dot(n2, n3)) + std::asin(dot(n3, n4)) + std::asin(dot(n4, n1));
    const double side = dot(cross(x4 - x3, x2 - x1), r13);
    if (std::isnan(angle)) return 0; // coplanar segments, as PyElastica reads it
    return angle * (side > 0 ? 1 : -1) / (4 * pi);
}

double published_twist(const Vec3d& s, const Vec3d& next, Vec3d a, Vec3d b) {
    const Vec3d t = unit(s), u = unit(next), p = unit(cross(s, next));
    a = unit(a - dot(a, t) * t);
    b = unit(b - dot(b, u) * u);
    const auto sign = [](double x) { return x > 0 ? 1.0 : -1.0; };
    const double turn =
        (sign(dot(cross(a, p), s)) * std::acos(dot(a, p)) + sign(dot(cross(p, b), next)) * std::acos(dot(b, p))) /
        (2 * pi);
    return turn - std::round(turn);
}

struct Random {
    std::mt19937 engine{7};
    std::normal_distribution<double> normal;
    Line line(int n) {
        Line out;
        for (int i = 0; i < n; ++i) {
            const double x = normal(engine), y = normal(engine), z = normal(engine);
            out.push_back({x, y, z});
        }
        return out;
    }
};

TEST(Published, FormulaeGiveTheSame) {
    Random random;
    const Line node = random.line(24), d1 = random.line(23);
    const auto local = local_twist(node, d1, Curve::open);
    ASSERT_EQ(local.size(), 22u);
    double sum = 0;
    for (std::size_t i = 0; i < 22; ++i)
        EXPECT_NEAR(local[i], published_twist(node[i + 1] - node[i], node[i + 2] - node[i + 1], d1[i], d1[i + 1]),
                    1e-11)
            << i;
    for (std::size_t i = 0; i < 23; ++i)
        for (std::size_t j = i + 2; j < 23; ++j) sum += 2 * published_pair(node[i], node[i + 1], node[j], node[j + 1]);
    EXPECT_NEAR(writhe(node, Curve::open), sum, 1e-11);

    const Line other = random.line(9);
    sum = 0;
    for (std::size_t i = 0; i < 23; ++i)
        for (std::size_t j = 0; j < 8; ++j) sum += published_pair(node[i], node[i + 1], other[j], other[j + 1]);
    EXPECT_NEAR(linking(node, Curve::open, other, Curve::open), sum, 1e-11);
}

TEST(Published, EndSegments) {
    const Line node = {{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {2, 3, 0}, {2, 4, 1}};
    const auto ends = [&](EndSegments kind) {
        const Line line = with_end_segments(node, 3, kind);
        EXPECT_EQ(line.size(), node.size() + 2);
        return std::pair{(1.0 / 3) * (line.front() - node.front()), (1.0 / 3) * (line.back() - node.back())};
    };
    const auto expect = [](const Vec3d& a, const Vec3d& b) { EXPECT_LT(norm(a - unit(b)), 1e-15); };
    EXPECT_EQ(with_end_segments(node, 3, EndSegments::none).size(), node.size());
    const auto [first, last] = ends(EndSegments::next_tangent);
    expect(first, {-1, 0, 0});
    expect(last, {0, 1, 1});
    const auto [from, to] = ends(EndSegments::end_to_end);
    expect(from, {-2, -4, -1});
    expect(to, {2, 4, 1});
    // first half: nodes 0, 1; second half: nodes 3, 4, whose sum the published mean divides by 3
    const auto [head, tail] = ends(EndSegments::net_tangent);
    expect(head, {0.5 - 4.0 / 3, -7.0 / 3, -1.0 / 3});
    expect(tail, {4.0 / 3 - 0.5, 7.0 / 3, 1.0 / 3});
}

// PyElastica's compute_link: the auxiliary line takes the frame of the element before each node, and the centre line's
// end segments. Some of its pairs are coplanar by construction; there each arcsin of 1 - 1e-16 is 1.5e-8 off, hence the
// tolerance.
TEST(Published, AuxiliaryLinkGivesTheSame) {
    Random random;
    const Line node = random.line(12), d1 = random.line(11);
    const std::vector<double> radius{.1, .2, .3, .1, .2, .3, .1, .2, .3, .1, .2};
    for (const EndSegments kind : {EndSegments::next_tangent, EndSegments::end_to_end, EndSegments::net_tangent}) {
        const Line centre = with_end_segments(node, 7, kind);
        Line auxiliary;
        for (std::size_t i = 0; i < 12; ++i) {
            const std::size_t k = std::max<std::size_t>(i, 1) - 1;
            const Vec3d t = unit(node[k + 1] - node[k]);
            auxiliary.push_back(node[i] + radius[k] * unit(d1[k] - dot(d1[k], t) * t));
        }
        auxiliary.insert(auxiliary.begin(), auxiliary.front() + (centre.front() - node.front()));
        auxiliary.push_back(auxiliary.back() + (centre.back() - node.back()));
        double sum = 0;
        for (std::size_t i = 0; i < 13; ++i)
            for (std::size_t j = 0; j < 13; ++j)
                sum += published_pair(centre[i], centre[i + 1], auxiliary[j], auxiliary[j + 1]);
        EXPECT_NEAR(auxiliary_link(node, d1, radius, 7, kind), sum, 1e-8);
    }
}

// An open helical ribbon: link by the auxiliary line tends to twist + writhe as the ribbon gets finer and thinner.
TEST(Published, AuxiliaryLinkTendsToTwistPlusWrithe) {
    double before = 0;
    for (const int n : {50, 100, 200, 400}) {
        Line node, d1;
        for (int i = 0; i <= n; ++i) {
            const double t = 4 * pi * i / n;
            node.push_back({std::cos(t), std::sin(t), 0.3 * t});
        }
        for (int k = 0; k < n; ++k) {
            const double t = 4 * pi * (k + 0.5) / n, angle = 1.5 * t;
            const Vec3d tangent = unit(node[static_cast<std::size_t>(k) + 1] - nth(node, k)),
                        inward = Vec3d{-std::cos(t), -std::sin(t), 0};
            d1.push_back(std::cos(angle) * inward + std::sin(angle) * cross(tangent, inward));
        }
        const std::vector<double> radius(static_cast<std::size_t>(n), 1.0 / n);
        const double length = 4 * pi * std::sqrt(1 + 0.09);
        const double sum = twist(node, d1, Curve::open) +
                           writhe(with_end_segments(node, length, EndSegments::next_tangent), Curve::open);
        const double error = auxiliary_link(node, d1, radius, length, EndSegments::next_tangent) - sum;
        if (n > 50) {
            EXPECT_GT(order(before, error), 0.9) << n << ": " << error << " of " << sum;
        }
        before = error;
    }
}

} // namespace
} // namespace skein
