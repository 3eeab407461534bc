// Exponential, logarithm and exponential function over packs against long double; every width gives the same bits.
#include "core/exponential.hpp"
#include "core/rotation.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

namespace skein {
namespace {

using Long = long double;

struct LongMatrix {
    Long m[3][3];
};

/// exp(-[v]x) in long double.
LongMatrix long_rotation(const Vec3d& v) {
    const Long t2 = Long(v.x) * v.x + Long(v.y) * v.y + Long(v.z) * v.z, t = std::sqrt(t2);
    const Long half = std::sin(t / 2);
    const Long a = t > 0 ? std::sin(t) / t : 1, b = t > 0 ? 2 * half * half / t2 : Long(0.5);
    const Long k[3][3] = {{0, -Long(v.z), v.y}, {v.z, 0, -Long(v.x)}, {-Long(v.y), v.x, 0}};
    LongMatrix r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            Long square = 0;
            for (int l = 0; l < 3; ++l) square += k[i][l] * k[l][j];
            r.m[i][j] = (i == j) - a * k[i][j] + b * square;
        }
    return r;
}

Mat3d rounded(const LongMatrix& r) {
    const auto row = [&](int i) { return Vec3d{double(r.m[i][0]), double(r.m[i][1]), double(r.m[i][2])}; };
    return {row(0), row(1), row(2)};
}

Vec3d random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const Vec3d v{normal(random), normal(random), normal(random)};
    return (1 / norm(v)) * v;
}

TEST(Rotation, MatchesLongDoubleAtAllAngles) {
    std::mt19937 random(1);
    for (const double angle : {0.0, 1e-9, 1e-4, 0.1, 0.49, 0.4999999, 0.5000001, 0.51, 1.0, 3.0, 6.0})
        for (int i = 0; i < 50; ++i) {
            const Vec3d v = angle * random_direction(random);
            const LongMatrix exact = long_rotation(v);
            const Mat3d r = matrix(rotation(v));
            const Vec3d rows[3] = {r.d1, r.d2, r.d3};
            const double bound = 4e-16 * (1 + 0.5 * angle); // |v| is rounded before its sine is taken
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(rows[k].x, double(exact.m[k][0]), bound);
                EXPECT_NEAR(rows[k].y, double(exact.m[k][1]), bound);
                EXPECT_NEAR(rows[k].z, double(exact.m[k][2]), bound);
            }
        }
}

TEST(Rotation, LogarithmInvertsTheExponential) {
    std::mt19937 random(2);
    for (const double angle : {1e-3, 0.01, 0.3, 0.5, 0.506, 0.7, 1.5, 2.5, 3.0, 3.1})
        for (int i = 0; i < 100; ++i) {
            const Vec3d v = angle * random_direction(random);
            const Quaterniond frame = quaternion(rounded(long_rotation(2.0 * random_direction(random))));
            const Quaterniond turned = rotation(v) * frame;
            const Vec3d back = relative_rotation(turned, frame),
                        same = relative_rotation({-turned.w, -turned.v}, frame);
            EXPECT_LT(norm(back - same), 1e-15) << "both signs are the same frame";
            // The frames are rounded to 2e-16; near pi the log magnifies that by about 1/(pi - angle).
            EXPECT_LT(norm(back - v), 2e-15 * (1 + 1 / (3.2 - angle))) << "angle " << angle;
        }
    EXPECT_EQ(norm(relative_rotation(no_turn, no_turn)), 0) << "exact at zero, without a regularising constant";
}

TEST(Rotation, AQuaternionIsTheFrameItStandsFor) {
    std::mt19937 random(5);
    for (const double angle : {0.0, 0.3, 2.0, 3.0, 3.1415})
        for (int i = 0; i < 50; ++i) {
            const Mat3d frame = rounded(long_rotation(angle * random_direction(random)));
            const Quaterniond q = quaternion(frame);
            const Vec3d a = 3 * random_direction(random);
            EXPECT_LT(norm(q * a - frame * a), 4e-15);
            EXPECT_LT(norm(transpose_times(q, a) - transpose_times(frame, a)), 4e-15);
            EXPECT_LT(norm(matrix(q) * a - frame * a), 4e-15);
            EXPECT_LT(norm(third_director(q) - frame.d3), 2e-15);
            EXPECT_NEAR(dot(q, q), 1, 5e-16);
            EXPECT_GE(q.w, 0);
            const Quaterniond r = rotation(random_direction(random));
            EXPECT_LT(norm((r * q) * a - r * (q * a)), 4e-15);
        }
}

TEST(Rotation, JacobianOfTheLogarithm) {
    for (const double angle : {1e-4, 0.1, 0.5, 0.509, 0.511, 1.0, 2.0, 3.1}) {
        const Long half = Long(angle) / 2;
        const Long exact = angle < 0.01 ? Long(1) / 12 + Long(angle) * angle / 720
                                        : (1 - half / std::tan(half)) / (Long(angle) * angle);
        const auto turned = broadcast<1>(rotation(Vec3d{angle, 0, 0}));
        EXPECT_NEAR(relative_rotation_and_jacobian(turned, broadcast<1>(no_turn)).jacobian[0] * angle * angle,
                    double(exact) * angle * angle, 2e-16)
            << angle;
    }
}

TEST(Exponential, MatchesLongDouble) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> spread(-40, 40);
    for (int i = 0; i < 10000; ++i) {
        const double x = spread(random);
        const double exact = double(std::exp(Long(x)));
        EXPECT_NEAR(exp(Pack<1>(x))[0], exact, 5e-16 * exact) << x;
    }
    EXPECT_EQ(exp(Pack<1>(0.0))[0], 1.0);
    EXPECT_GE(exp(Pack<1>(-1e6))[0], 0.0);
}

TEST(Exponential, MeanDecayMatchesLongDouble) {
    for (const double z : {0.0, 1e-12, 1e-3, 0.0199, 0.0201, 0.5, 3.0, 50.0, 800.0}) {
        const double exact = z > 0 ? double(-std::expm1(-Long(z)) / z) : 1.0;
        EXPECT_NEAR(decay(Pack<1>(z)).mean[0], exact, 2e-14 * exact) << z;
    }
}

template <int W> void expect_same_bits() {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> size(0, 1.2);
    for (int trial = 0; trial < 200; ++trial) {
        Vec3<Pack<W>> v;
        Vec3d single[W];
        for (int i = 0; i < W; ++i) {
            single[i] = size(random) * random_direction(random);
            set_lane(v, i, single[i]);
        }
        const auto r = rotation(v);
        const auto back = relative_rotation(r, broadcast<W>(no_turn));
        for (int i = 0; i < W; ++i) {
            const auto r1 = rotation(broadcast<1>(single[i]));
            const auto back1 = relative_rotation(r1, broadcast<1>(no_turn));
            EXPECT_EQ(std::bit_cast<std::uint64_t>(r.v.x[i]), std::bit_cast<std::uint64_t>(r1.v.x[0]));
            EXPECT_EQ(std::bit_cast<std::uint64_t>(back.y[i]), std::bit_cast<std::uint64_t>(back1.y[0]));
            EXPECT_EQ(exp(v.x)[i], exp(Pack<1>(single[i].x))[0]);
        }
    }
}

TEST(Width, EveryLaneHasTheBitsOfOneRodAlone) {
    expect_same_bits<2>();
    expect_same_bits<4>();
    expect_same_bits<8>();
}

} // namespace
} // namespace skein
