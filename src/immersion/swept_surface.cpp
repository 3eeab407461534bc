#include "immersion/swept_surface.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace skein {

namespace {

/// A vector turned about an axis by its length, rad.
Vec3d rotated(const Vec3d& v, const Vec3d& turn) {
    const double angle = norm(turn);
    if (!(angle > 0)) return v;
    const Vec3d about = (1 / angle) * turn;
    return std::cos(angle) * v + std::sin(angle) * cross(about, v) + ((1 - std::cos(angle)) * dot(about, v)) * about;
}

double& part_of(Vec3d& v, int d) { return d == 0 ? v.x : d == 1 ? v.y : v.z; }
double part_of(const Vec3d& v, int d) { return d == 0 ? v.x : d == 1 ? v.y : v.z; }

/// Without the care for extreme numbers that takes std::hypot most of its time.
double hypotenuse(double a, double b) { return std::sqrt(a * a + b * b); }

/// Takes a place by whole periods to between 0 and `way`, whose size is a period.
void put_within(double& place, double way) {
    const double period = std::abs(way), from = std::min(0.0, way);
    place -= std::floor((place - from) / period) * period;
}

/// Means of neighbours with the weights 1/4, 1/2, 1/4, several times. Ends of what is no ring are mirrors.
template <class T> void smooth(std::span<T> values, bool ring, int times) {
    const std::size_t n = values.size();
    for (; n > 1 && times > 0; --times) {
        const T first = values.front();
        T before = ring ? values.back() : first;
        for (std::size_t k = 0; k < n; ++k) {
            const T own = values[k], after = k + 1 < n ? values[k + 1] : ring ? first : own;
            values[k] = 0.25 * (before + after) + 0.5 * own;
            before = own;
        }
    }
}

} // namespace

RodMotion RodMotion::after(double time) const {
    RodMotion moved = *this;
    for (std::size_t i = 0; i < node.size(); ++i) moved.node[i] += time * (velocity[i] - velocity[0]);
    for (std::size_t k = 0; k < frame.size(); ++k) {
        const Vec3d turn = time * spin[k];
        moved.frame[k] = {rotated(frame[k].d1, turn), rotated(frame[k].d2, turn), rotated(frame[k].d3, turn)};
    }
    return moved;
}

void RodMotion::take_means(const RodMotion& begin, const Vec3d& way, double time) {
    for (std::size_t i = 0; i < node.size(); ++i) velocity[i] = (1 / time) * (node[i] - begin.node[i] + way);
    for (std::size_t k = 0; k < frame.size(); ++k) spin[k] = mean_spin(begin.frame[k], frame[k], time);
}

Vec3d mean_spin(const Mat3d& from, const Mat3d& to, double time) {
    const Vec3d sine = 0.5 * (cross(from.d1, to.d1) + cross(from.d2, to.d2) + cross(from.d3, to.d3));
    const double length = norm(sine);
    return (length > 0 ? std::asin(std::min(length, 1.0)) / (length * time) : 0) * sine;
}

SweptSurface::SweptSurface(Rod rod)
    : section_(rod.section), element_(std::move(rod.elements)), through_(rod.through), shares_(std::move(rod.shares)),
      near_(rod.near), closed_(rod.closed), all_(element_.size()) {
    std::iota(all_.begin(), all_.end(), 0u);
    if (std::all_of(shares_.begin(), shares_.end(), [](double share) { return share == 1; })) shares_.clear();
    const std::size_t last = element_.size() - 1;
    for (std::size_t i = 0; i <= last + 1; ++i) {
        const Element &a = element_[i > 0     ? i - 1
                                    : closed_ ? last
                                              : 0],
                      &b = element_[i <= last ? i
                                    : closed_ ? 0
                                              : last];
        of_node_.push_back({0.5 * (a.along_d1 + b.along_d1), 0.5 * (a.along_d2 + b.along_d2)});
    }
    double stoutness = 0; // most of the lesser half axis over the length of an element
    for (const Element& e : element_) {
        const double half = section_ == SweptSection::plate ? e.along_d1 : std::min(e.along_d1, e.along_d2);
        stoutness = std::max(stoutness, half / e.rest_length);
    }
    smoothings_ = static_cast<int>(stoutness * stoutness);
}

void SweptSurface::put(RodMotion begin, RodMotion end) {
    before_ = std::move(begin);
    now_ = std::move(end);
    const std::size_t n = element_.size();
    length_.resize(n);
    cover_.resize(n);
    to_end_.assign(n + 1, 0);
    for (std::size_t k = 0; k < n; ++k) {
        length_[k] = norm(now_.node[k + 1] - now_.node[k]);
        to_end_[k + 1] = to_end_[k] + length_[k];
    }
    const double all = to_end_[n];
    for (double& way : to_end_) way = closed_ ? HUGE_VAL : std::min(way, all - way); // a ring has no end
    lower_ = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    upper_ = -lower_;
    for (std::size_t k = 0; k < n; ++k) {
        const Half from = half_at(k, 0), to = half_at(k, 1);
        const auto reach = [&](const Half& half) { // of a plate within its plane
            return section_ == SweptSection::plate ? half.along_d1 : std::hypot(half.along_d1, half.along_d2);
        };
        const double most = std::max(reach(from), reach(to));
        cover_[k] = 0.5 * length_[k] + most;
        if (has_part() && shares_[k] == 0 && shares_[k + 1] == 0) continue;
        for (const Vec3d& p : {now_.node[k], now_.node[k + 1]}) {
            lower_ = {std::min(lower_.x, p.x - most), std::min(lower_.y, p.y - most), std::min(lower_.z, p.z - most)};
            upper_ = {std::max(upper_.x, p.x + most), std::max(upper_.y, p.y + most), std::max(upper_.z, p.z + most)};
        }
    }
    if (through_ >= 0) {
        part_of(lower_, through_) = -HUGE_VAL;
        part_of(upper_, through_) = HUGE_VAL;
    }
    middle_.resize(n);
    per_share_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        middle_[k] = in_cubes(0.5 * (now_.node[k] + now_.node[k + 1]));
        Vec3d axis = now_.node[k + 1] - now_.node[k];
        if (section_ == SweptSection::plate) axis -= dot(axis, now_.frame[0].d2) * now_.frame[0].d2;
        per_share_[k] = (1 / dot(axis, axis)) * axis;
    }
    sorted_ = false;
    find_rates(before_, of_sections_before_);
    find_rates(now_, of_sections_);
}

void SweptSurface::find_rates(const RodMotion& motion, SectionRates& rates) const {
    const std::size_t n = element_.size();
    const bool ring = closed_ || endless();
    rates.stretch.resize(n);
    rates.bend.assign(n + 1, Vec3d{0, 0, 0});
    for (std::size_t k = 0; k < n; ++k) {
        rates.stretch[k] = dot(motion.velocity[k + 1] - motion.velocity[k], tangent(k)) / length_[k];
        const std::size_t before = k > 0 ? k - 1 : n - 1;
        if (k > 0 || ring)
            rates.bend[k] = (2 / (length_[before] + length_[k])) * (motion.spin[k] - motion.spin[before]);
    }
    smooth(std::span(rates.stretch), ring, smoothings_);
    smooth(std::span(rates.bend).subspan(ring ? 0 : 1, ring ? n : n - 1), ring, smoothings_);
    if (ring) rates.bend[n] = rates.bend[0];
}

void SweptSurface::sort() {
    if (near_ > 0) cubes_.fill(middle_, cover_, near_);
    sorted_ = near_ > 0;
}

Vec3d SweptSurface::in_cubes(const Vec3d& place) const {
    if (section_ != SweptSection::plate) return place;
    const Mat3d& frame = now_.frame[0]; // all places along d2 are one
    return {dot(place, frame.d1), dot(place, frame.d3), 0};
}

SweptSurface::Half SweptSurface::half_at(std::size_t k, double along) const {
    const Half &from = of_node_[k], &to = of_node_[k + 1];
    const double stretch = length_[k] / element_[k].rest_length;
    if (section_ == SweptSection::plate)
        return {((1 - along) * from.along_d1 + along * to.along_d1) / stretch, from.along_d2};
    const double scale = 1 / std::sqrt(stretch); // its volume stays
    return {scale * ((1 - along) * from.along_d1 + along * to.along_d1),
            scale * ((1 - along) * from.along_d2 + along * to.along_d2)};
}

double SweptSurface::from_section(const Half& half, double y1, double y2, double beyond) const {
    const double across = hypotenuse(y1, beyond), a = half.along_d1, b = half.along_d2;
    if (section_ == SweptSection::plate) return across - a;
    if (section_ == SweptSection::rectangle) {
        const double out = across - a, side = std::abs(y2) - b;
        return hypotenuse(std::max(out, 0.0), std::max(side, 0.0)) + std::min(std::max(out, side), 0.0);
    }
    if (a == b) return hypotenuse(across, y2) - a;
    const double x = across / a, y = y2 / b, q = hypotenuse(x, y);
    return q > 0 ? (q - 1) * q / hypotenuse(x / a, y / b) : -std::min(a, b); // of second order in the distance
}

SweptSurface::Foot SweptSurface::nearest(const Vec3d& given) const {
    Vec3d place = given;
    if (endless()) put_within(part_of(place, through_), part_of(now_.node[element_.size()], through_));
    if (sorted_)
        if (const auto some = cubes_.at(in_cubes(place)); !some.empty())
            if (const Foot found = nearest_of(some, place); found.distance <= near_) return found;
    return nearest_of(all_, place);
}

SweptSurface::Foot SweptSurface::nearest_of(std::span<const std::uint32_t> elements, const Vec3d& place) const {
    Foot best{.distance = HUGE_VAL};
    for (const std::uint32_t k : elements)
        if (has_foot(k, place)) take_nearer(k, place, best);
    return best;
}

void SweptSurface::take_nearer(std::size_t k, const Vec3d& place, Foot& best) const {
    const std::size_t n = element_.size();
    const bool ends = !closed_ && !endless(), first = !closed_ && k == 0, last = !closed_ && k + 1 == n;
    const Vec3d axis = now_.node[k + 1] - now_.node[k];
    const double share = share_on(k, place), along = std::clamp(share, 0.0, 1.0);
    Vec3d off = (place - now_.node[k]) - along * axis;
    if (section_ == SweptSection::plate) { // all places along d2 are one
        const Vec3d& d2 = now_.frame[0].d2;
        off -= dot(off, d2) * d2;
    }
    const Vec3d t = (1 / length_[k]) * axis;
    const Mat3d& frame = now_.frame[k];
    const double beyond = dot(off, t), end = !ends ? -HUGE_VAL
                                             : (first && share < 0) || (last && share > 1)
                                                 ? std::abs(beyond)
                                                 : -((1 - along) * to_end_[k] + along * to_end_[k + 1]);
    const Vec3d across = off - beyond * t;
    const double of_section = from_section(half_at(k, along), dot(across, frame.d1), dot(across, frame.d2),
                                           end > 0 || endless() ? 0 : beyond),
                 distance = hypotenuse(std::max(of_section, 0.0), std::max(end, 0.0)) +
                            std::min(std::max(of_section, end), 0.0);
    if (distance < best.distance || (distance == best.distance && k < best.element))
        best = {static_cast<std::uint32_t>(k), along, off, distance};
}

SweptSurface::Turning SweptSurface::turning(const Foot& foot) const {
    const std::size_t k = foot.element, n = element_.size();
    const bool later = foot.along >= 0.5, alone = !closed_ && !endless() && (later ? k + 1 == n : k == 0);
    if (alone || n == 1) return {k, SIZE_MAX, 0};
    const std::size_t other = later ? (k + 1) % n : (k + n - 1) % n;
    const double way = 0.5 * (length_[k] + length_[other]);
    return {other, later ? k + 1 : k, std::abs(foot.along - 0.5) * length_[k] / way};
}

Vec3d SweptSurface::shift_of(const SectionRates& rates, const Foot& foot, const Turning& turning) const {
    if (turning.node == SIZE_MAX) return {0, 0, 0};
    const Vec3d apart = cross(tangent(foot.element), rates.bend[turning.node]);
    const Mat3d& frame = now_.frame[foot.element];
    const Half half = half_at(foot.element, foot.along);
    const double a = half.along_d1, b = section_ == SweptSection::plate ? 0 : half.along_d2,
                 x = dot(foot.off, frame.d1) / a, y = b > 0 ? dot(foot.off, frame.d2) / b : 0;
    const bool round = section_ == SweptSection::ellipse; // the other sections have flat sides
    const double by_d1 = a * a * std::max(0.0, 1 - x * x - (round ? y * y : 0)),
                 by_d2 = b * b * std::max(0.0, 1 - y * y - (round ? x * x : 0));
    return (0.5 * by_d1 * dot(apart, frame.d1)) * frame.d1 + (0.5 * by_d2 * dot(apart, frame.d2)) * frame.d2;
}

Vec3d SweptSurface::velocity_of(const RodMotion& motion, const SectionRates& rates, const Foot& foot) const {
    const std::size_t k = foot.element;
    const Vec3d t = tangent(k), gain = motion.velocity[k + 1] - motion.velocity[k];
    const Vec3d& d1 = now_.frame[k].d1;
    const Vec3d narrows =
        section_ == SweptSection::plate ? dot(foot.off, d1) * d1 : 0.5 * (foot.off - dot(foot.off, t) * t);
    const Turning at = turning(foot);
    const Vec3d spin = (1 - at.share) * motion.spin[k] + at.share * motion.spin[at.other];
    return motion.velocity[k] + foot.along * gain + cross(spin, foot.off) - rates.stretch[k] * narrows +
           shift_of(rates, foot, at); // (153)
}

} // namespace skein
