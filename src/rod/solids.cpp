#include "rod/solids.hpp"

#include <numbers>

namespace skein {

namespace {

using std::numbers::pi;

/// J = j1 1 + (j3 - j1) e e^T, symmetric about the unit vector e.
SymmetricMatrix about(const Vec3d& e, double j1, double j3) {
    const double d = j3 - j1;
    return {j1 + d * e.x * e.x, j1 + d * e.y * e.y, j1 + d * e.z * e.z, d * e.x * e.y, d * e.x * e.z, d * e.y * e.z};
}

/// Integral of x^2 over the box of half sides a, b, c and over all points within r of it.
double second_moment(double a, double b, double c, double r) {
    const double inner = a * a / 3, disc = pi * r * r, ball = 4.0 / 3 * pi * r * r * r;
    const double out = (a + r) * (a + r) * (a + r) - a * a * a;
    // plates, with the box itself
    const double plates = 8 * b * c * (a * a * a + out) / 3 + 8 * (a * c + a * b) * r * inner;
    const double along = 2 * a * disc * inner;
    const double quarters = 2 * (b + c) * (disc * a * a + a * (8.0 / 3 * r * r * r) + 0.25 * disc * r * r);
    return plates + along + quarters + ball * a * a + pi * a * r * r * r * r + ball * r * r / 5;
}

} // namespace

Solid solid_sphere(const Vec3d& centre, double r) {
    return {4.0 / 3 * pi * r * r * r, centre, about({0, 0, 1}, 0.4 * r * r, 0.4 * r * r)};
}

Solid solid_capsule(const Vec3d& from, const Vec3d& to, double r) {
    const double l = norm(to - from);
    if (l == 0) return solid_sphere(from, r);
    const double cylinder = pi * r * r * l, balls = 4.0 / 3 * pi * r * r * r, volume = cylinder + balls;
    const double j3 = r * r * (0.5 * cylinder + 0.4 * balls);
    const double j1 = cylinder * (l * l / 12 + 0.25 * r * r) + balls * (0.4 * r * r + 0.25 * l * l + 0.375 * l * r);
    return {volume, 0.5 * (from + to), about((1 / l) * (to - from), j1 / volume, j3 / volume)};
}

Solid solid_box(const Vec3d& centre, const Vec3d& h, double r) {
    const double volume = 8 * h.x * h.y * h.z + 8 * r * (h.x * h.y + h.y * h.z + h.z * h.x) +
                          2 * pi * r * r * (h.x + h.y + h.z) + 4.0 / 3 * pi * r * r * r;
    const double x = second_moment(h.x, h.y, h.z, r) / volume, y = second_moment(h.y, h.z, h.x, r) / volume,
                 z = second_moment(h.z, h.x, h.y, r) / volume;
    return {volume, centre, {y + z, x + z, x + y}};
}

} // namespace skein
