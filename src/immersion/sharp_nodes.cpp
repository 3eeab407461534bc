#include "immersion/sharp_nodes.hpp"

#include "immersion/cut_weights.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

std::int64_t floor_of(double x) { return static_cast<std::int64_t>(std::floor(x)); }

/// floor(a/n)
std::int64_t whole_periods(std::int64_t a, std::int64_t n) { return (a >= 0 ? a : a - n + 1) / n; }

} // namespace

/// Nodes of one component in a row, and the images of bodies near it.
class SharpNodes::Row {
public:
    Row(const SharpNodes& all, int component, int j, int k, std::vector<SharpNode>& out)
        : all_(all), component_(component), j_(j), k_(k), h_(all.grid_.h), out_(out) {}

    void set(std::span<const Image> images) {
        near_.clear();
        for (const Image& image : images)
            if (j_ >= image.first[1] && j_ <= image.last[1]) near_.push_back(&image);
        known_.assign(near_.size(), {});
        for (std::size_t m = 0; m < near_.size(); ++m)
            for (int i = near_[m]->first[0]; i <= near_[m]->last[0]; ++i)
                if (!covered(m, i)) add(i);
    }

private:
    struct Cut {
        const Image* image;
        SweptSurface::Foot foot; ///< of the node on a rod
        double distance;         ///< cells
        Vec3d normal;
        CutWeights weights;
    };

    /// Nodes from..until of the row that lie as one of them does: outside, or within a body.
    struct Stretch {
        int from = 0, until = 0;
        bool within = false;

        bool has(int i) const { return i >= from && i < until; }
    };

    /// True if an image before this one has the node.
    bool covered(std::size_t image, int i) const {
        for (std::size_t m = 0; m < image; ++m)
            if (i >= near_[m]->first[0] && i <= near_[m]->last[0]) return true;
        return false;
    }
    /// Place of a node in coordinates of an image's body, or of its neighbour in a direction.
    Vec3d place(const Image& image, int i, int direction = 0, int step = 0) const {
        const std::array<std::int64_t, 3> cell{i + image.shift[0], j_ + image.shift[1], k_ + image.shift[2]};
        const auto along = [&](int d) {
            const double number = static_cast<double>(nth(cell, d) + (d == direction ? step : 0));
            return component_of(all_.grid_.lower, d) + h_ * (number + (d == component_ ? 1.0 : 0.5)) -
                   component_of(all_.now_[image.body].place, d);
        };
        return {along(0), along(1), along(2)};
    }
    /// Distance of a place from a body's surface, m, and the share of its action there.
    struct Seen {
        double distance, share = 1;
        SweptSurface::Foot foot = {}; ///< on a rod
    };
    Seen seen(const Image& image, const Vec3d& place) const {
        const SharpBody& body = all_.bodies_[image.body];
        if (!body.swept) return {body.surface->distance(all_.now_[image.body].axes * place)};
        const SweptSurface::Foot at = body.swept->nearest(place);
        return {at.distance, body.swept->share(at), at};
    }
    double distance(const Image& image, const Vec3d& place) const {
        const SharpBody& body = all_.bodies_[image.body];
        return body.swept ? body.swept->nearest(place).distance
                          : body.surface->distance(all_.now_[image.body].axes * place);
    }
    /// On a rod; of a rigid body nothing.
    SweptSurface::Foot foot(const Image& image, const Vec3d& place) const {
        const auto& rod = all_.bodies_[image.body].swept;
        return rod ? rod->nearest(place) : SweptSurface::Foot{};
    }
    /// Normal of a body's surface towards the fluid, by differences of the distance over a spacing.
    Vec3d normal(const Image& image, const Vec3d& place) const {
        const auto along = [&](const Vec3d& half) {
            return (distance(image, place + half) - distance(image, place - half)) / h_;
        };
        return {along({0.5 * h_, 0, 0}), along({0, 0.5 * h_, 0}), along({0, 0, 0.5 * h_})};
    }
    Vec3d velocity(const Image& image, const Vec3d& place) const {
        if (const auto& rod = all_.bodies_[image.body].swept) return rod->velocity(rod->nearest(place));
        const BodyMotion& motion = all_.now_[image.body];
        return motion.velocity + cross(motion.spin, place);
    }
    /// Velocity at the begin of the stage.
    Vec3d velocity_before(const Image& image, const Vec3d& place) const {
        const BodyMotion &before = all_.before_[image.body], &now = all_.now_[image.body];
        return before.velocity + cross(before.spin, place + (now.place - before.place));
    }
    SharpNode node(int i, const Image& image, const SweptSurface::Foot& foot) const {
        const int j = j_ - all_.pencils_.rows().first, k = k_ - all_.pencils_.planes().first;
        SharpNode one{.at = all_.layout_.at(i, j, k),
                      .velocity = 0,
                      .arm = place(image, i),
                      .body = image.body,
                      .piece = static_cast<std::uint32_t>(all_.first_piece_[image.body]),
                      .row = j,
                      .component = static_cast<std::uint8_t>(component_)};
        const auto take = [&](const Vec3d& now, const Vec3d& before) {
            one.velocity = component_of(now, component_);
            one.gain = component_of(now - before, component_);
        };
        const auto& rod = all_.bodies_[image.body].swept;
        if (!rod) {
            take(velocity(image, one.arm), velocity_before(image, one.arm));
            one.other = one.piece;
            return one;
        }
        const Vec3d velocity = rod->velocity(foot);
        take(velocity, rod->velocity_before(foot));
        one.arm = foot.off;
        one.along = foot.along;
        one.share = rod->share(foot);
        const SweptSurface::Turning turning = rod->turning(foot);
        one.of_other = turning.share;
        one.other = one.piece + static_cast<std::uint32_t>(turning.other);
        one.relative = component_of(velocity - rod->axis_velocity(foot), component_);
        one.piece += foot.element;
        return one;
    }
    void put_within(int i, const Image& image, const SweptSurface::Foot& foot) {
        const SharpNode one = node(i, image, foot);
        if (one.share > 0) out_.push_back(one);
    }
    void put(int i, const Cut& cut, bool again) {
        SharpNode one = node(i, *cut.image, cut.foot);
        one.excess = cut.weights.excess;
        one.pull = cut.weights.excess * one.velocity;
        one.closed = cut.weights.closed_share;
        one.relative *= cut.weights.closed_share;
        one.again = again;
        for (int d = 0; d < 3; ++d) {
            const double ahead = nth(cut.weights.ahead, d);
            const int step = component_of(cut.normal, d) > 0 ? 1 : -1;
            nth(one.ahead, d) = ahead;
            nth(one.side, d) = static_cast<std::int8_t>(step);
            // The change of weights is for velocities relative to the body's at both nodes.
            if (ahead != 0)
                one.pull -= ahead * component_of(velocity(*cut.image, place(*cut.image, i, d, step)), component_);
        }
        out_.push_back(one);
    }
    // Signed distances in cells between which a face or a line of its node may be cut: |n_a|/2 + |n_b|/2 and
    // 3/2 |n_a| + |n_b|/2 are at most 0.71 and 1.58.
    static constexpr double closed = -0.75, reach = 1.75;

    bool has(std::size_t m, int i) const { return i >= near_[m]->first[0] && i <= near_[m]->last[0]; }
    /// Stretch of nodes from i on that need no distance of their own.
    Stretch stretch_from(std::size_t m, int i, double d) const {
        const double more = d < 0 ? closed - d : d - reach;
        const SharpBody& body = all_.bodies_[near_[m]->body];
        if (!(more >= 0) || (!body.swept && !body.surface->steady())) return {};
        // Distances from a rod may change faster than places: sections shrink along it, and elements meet at angles.
        const double share = body.swept ? 0.5 : 1;
        return {i, i + 1 + static_cast<int>(share * more), d < 0};
    }
    /// The body of an image, if the node is known to lie within it and near no other one.
    const Image* inside_of(int i) const {
        const Image* found = nullptr;
        for (std::size_t m = 0; m < near_.size(); ++m) {
            if (!has(m, i)) continue;
            if (found || !known_[m].has(i) || !known_[m].within) return nullptr;
            found = near_[m];
        }
        return found;
    }
    void add(int i) {
        if (on_wall(i)) return;
        if (const Image* within = inside_of(i)) return put_within(i, *within, foot(*within, place(*within, i)));
        cuts_.clear();
        for (std::size_t m = 0; m < near_.size(); ++m) {
            if (!has(m, i) || (known_[m].has(i) && !known_[m].within)) continue;
            const Image* const image = near_[m];
            const Vec3d at = place(*image, i);
            const Seen from = seen(*image, at);
            const double d = from.distance / h_;
            known_[m] = stretch_from(m, i, d);
            if (d < reach && from.share > 0)
                cuts_.push_back({image, from.foot, d, d > closed ? normal(*image, at) : Vec3d{0, 0, 0}, {}});
        }
        for (Cut& cut : cuts_)
            if (cut.distance > closed)
                cut.weights = cut_weights(cut.distance, cut.normal, component_, lines(i, cut, cuts_.size() > 1));
        const auto nearest = std::min_element(cuts_.begin(), cuts_.end(),
                                              [](const Cut& a, const Cut& b) { return a.distance < b.distance; });
        if (nearest == cuts_.end()) return;
        if (std::any_of(cuts_.begin(), cuts_.end(), [](const Cut& c) { return c.weights.closed(); })) {
            put_within(i, *nearest->image, nearest->foot);
            return;
        }
        constexpr double nothing = 1e-12; // rounding of weights at nodes that no surface cuts
        std::erase_if(cuts_, [](const Cut& c) { return c.weights.excess < nothing; });
        for (std::size_t c = 0; c < cuts_.size(); ++c) put(i, cuts_[c], c + 1 < cuts_.size());
    }
    /// Treatment of lines: between two bodies, or a body and a wall, profiles are of first degree.
    std::array<CutLines, 3> lines(int i, const Cut& cut, bool shared) const {
        std::array<CutLines, 3> of{};
        for (int d = 0; d < 3; ++d) {
            const int ahead = component_of(cut.normal, d) > 0 ? 1 : -1;
            nth(of, d) = beyond_wall(i, d, -ahead)            ? CutLines::none
                         : shared || beyond_wall(i, d, ahead) ? CutLines::linear
                                                              : CutLines::quadratic;
        }
        return of;
    }
    int number(int i, int d) const { return d == 0 ? i : d == 1 ? j_ : k_; }
    /// True for nodes on a face of the box, which have its velocity.
    bool on_wall(int i) const {
        return !all_.grid_.periodic(component_) && number(i, component_) == nth(all_.grid_.cells, component_) - 1;
    }
    /// True if the neighbour is a ghost beyond a wall.
    bool beyond_wall(int i, int direction, int step) const {
        const int to = number(i, direction) + step;
        return !all_.grid_.periodic(direction) && direction != component_ &&
               (to < 0 || to >= nth(all_.grid_.cells, direction));
    }

    const SharpNodes& all_;
    int component_, j_, k_;
    double h_;
    std::vector<SharpNode>& out_;
    std::vector<const Image*> near_;
    std::vector<Stretch> known_; ///< by image near the row
    std::vector<Cut> cuts_;
};

SharpNodes::SharpNodes(const Threads& threads, const FluidGrid& grid, const Pencils& pencils,
                       std::vector<SharpBody> bodies)
    : threads_(threads), grid_(grid), pencils_(pencils), layout_(pencils.layout()), bodies_(std::move(bodies)),
      first_piece_(1, 0), before_(bodies_.size()), now_(bodies_.size()), blocks_(bodies_.size()),
      some_move_(std::any_of(bodies_.begin(), bodies_.end(), [](const SharpBody& b) { return b.moves; })) {
    for (const SharpBody& body : bodies_) first_piece_.push_back(first_piece_.back() + body.pieces());
}

void SharpNodes::set_motion(std::size_t body, const Vec3d& begin_place, RodMotion begin, const Vec3d& end_place,
                            RodMotion end) {
    before_[body].place = begin_place;
    now_[body].place = end_place;
    bodies_[body].swept->put(std::move(begin), std::move(end));
}

bool SharpNodes::reaches(int plane) const {
    return std::any_of(clusters_.begin(), clusters_.end(),
                       [plane](const Cluster& cluster) { return !nth(cluster.planes, plane).empty(); });
}

SharpNodes::Block SharpNodes::block_of(std::uint32_t body) const {
    const SharpBody& of = bodies_[body];
    const Vec3d lower = of.swept ? of.swept->lower() : -of.surface->extent(),
                upper = of.swept ? of.swept->upper() : of.surface->extent();
    Block block{};
    for (int d = 0; d < 3; ++d) {
        const double from = component_of(lower, d), to = component_of(upper, d),
                     at = component_of(now_[body].place, d) - component_of(grid_.lower, d);
        const bool bounded = std::isfinite(to);
        nth(block.first, d) = bounded ? floor_of((at + from) / grid_.h) - 2 : 0;
        nth(block.last, d) = bounded ? floor_of((at + to) / grid_.h) + 2 : nth(grid_.cells, d) - 1;
    }
    return block;
}

bool SharpNodes::overlap(const Block& a, const Block& b) const {
    for (int d = 0; d < 3; ++d) {
        const std::int64_t n = nth(grid_.cells, d), lowest = nth(a.first, d) - nth(b.last, d),
                           highest = nth(a.last, d) - nth(b.first, d);
        // b, moved by some number within these bounds, meets a: 0, or a whole number of periods.
        const bool meet = grid_.periodic(d) ? whole_periods(highest, n) * n >= lowest : lowest <= 0 && highest >= 0;
        if (!meet) return false;
    }
    return true;
}

SharpNodes::Block SharpNodes::own_block() const {
    const Slab rows = pencils_.rows(), planes = pencils_.planes();
    return {{0, rows.first, planes.first},
            {grid_.cells[0] - 1, rows.first + layout_.ny - 1, planes.first + layout_.nz - 1}};
}

std::vector<std::vector<std::uint32_t>> SharpNodes::overlapping() const {
    std::vector<std::uint32_t> with(bodies_.size()); // the first body of the cluster
    std::iota(with.begin(), with.end(), 0u);
    for (std::uint32_t a = 0; a < with.size(); ++a)
        for (std::uint32_t b = a + 1; b < with.size(); ++b)
            if (with[a] != with[b] && overlap(blocks_[a], blocks_[b])) {
                const std::uint32_t from = std::max(with[a], with[b]), to = std::min(with[a], with[b]);
                std::replace(with.begin(), with.end(), from, to);
            }
    std::vector<std::vector<std::uint32_t>> clusters;
    for (std::uint32_t a = 0; a < with.size(); ++a) {
        if (with[a] != a) continue;
        clusters.emplace_back();
        for (std::uint32_t b = a; b < with.size(); ++b)
            if (with[b] == a) clusters.back().push_back(b);
    }
    return clusters;
}

std::vector<SharpNodes::Image> SharpNodes::images_of(const Cluster& cluster) const {
    std::vector<Image> images;
    for (const std::uint32_t body : cluster.bodies) {
        const Block& block = blocks_[body];
        std::array<std::int64_t, 3> from{}, to{};
        for (int d = 0; d < 3; ++d) {
            const std::int64_t n = nth(grid_.cells, d);
            if (!grid_.periodic(d)) continue;
            nth(from, d) = whole_periods(nth(block.first, d), n);
            nth(to, d) = whole_periods(nth(block.last, d), n);
        }
        for (std::int64_t z = from[2]; z <= to[2]; ++z)
            for (std::int64_t y = from[1]; y <= to[1]; ++y)
                for (std::int64_t x = from[0]; x <= to[0]; ++x) {
                    Image image{.body = body, .shift = {x, y, z}, .first = {}, .last = {}};
                    bool some = true;
                    for (int d = 0; d < 3; ++d) {
                        const std::int64_t n = nth(grid_.cells, d);
                        std::int64_t& shift = nth(image.shift, d);
                        shift *= n;
                        nth(image.first, d) =
                            static_cast<int>(std::clamp<std::int64_t>(nth(block.first, d) - shift, 0, n));
                        nth(image.last, d) =
                            static_cast<int>(std::clamp<std::int64_t>(nth(block.last, d) - shift, -1, n - 1));
                        some = some && nth(image.first, d) <= nth(image.last, d);
                    }
                    if (some) images.push_back(image);
                }
    }
    return images;
}

void SharpNodes::fill(Cluster& cluster) const {
    const std::vector<Image> images = images_of(cluster);
    cluster.planes.resize(to_index(layout_.nz));
    threads_.for_each(cluster.planes.size(), [&](std::size_t plane, int) {
        std::vector<SharpNode>& nodes = cluster.planes[plane];
        nodes.clear();
        const int k = pencils_.planes().first + static_cast<int>(plane);
        std::vector<Image> here;
        int first = layout_.ny, last = -1;
        for (const Image& image : images) {
            if (k < image.first[2] || k > image.last[2]) continue;
            here.push_back(image);
            first = std::min(first, image.first[1] - pencils_.rows().first);
            last = std::max(last, image.last[1] - pencils_.rows().first);
        }
        for (int j = std::max(first, 0); j <= std::min(last, layout_.ny - 1); ++j)
            for (int c = 0; c < 3; ++c) Row(*this, c, pencils_.rows().first + j, k, nodes).set(here);
    });
}

bool SharpNodes::rests(const Cluster& cluster) const {
    return std::none_of(cluster.bodies.begin(), cluster.bodies.end(),
                        [this](std::uint32_t b) { return bodies_[b].moves; });
}

void SharpNodes::settle(double time, double length) {
    if (settled_ && !some_move_) return;
    for (std::uint32_t b = 0; b < bodies_.size(); ++b) {
        if (settled_ && !bodies_[b].moves) continue;
        if (bodies_[b].motion) {
            before_[b] = bodies_[b].motion(time - length);
            now_[b] = bodies_[b].motion(time);
        }
        blocks_[b] = block_of(b);
        if (bodies_[b].swept && overlap(blocks_[b], own_block())) bodies_[b].swept->sort();
    }
    std::vector<Cluster> before = std::move(clusters_);
    clusters_.clear();
    for (std::vector<std::uint32_t>& bodies : overlapping()) {
        const auto same =
            std::find_if(before.begin(), before.end(), [&](const Cluster& c) { return c.bodies == bodies; });
        const bool known = same != before.end();
        clusters_.push_back(known ? std::move(*same) : Cluster{std::move(bodies), {}});
        if (known) before.erase(same);
        if (!known || !rests(clusters_.back())) fill(clusters_.back());
    }
    settled_ = true;
}

} // namespace skein
