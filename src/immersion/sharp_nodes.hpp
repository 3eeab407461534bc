// Velocity nodes within bodies and next to their surfaces, with what the surfaces change in the Laplacian.
#pragma once

#include "fluid/pencils.hpp"
#include "immersion/surface.hpp"
#include "immersion/swept_surface.hpp"
#include "parallel/threads.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace skein {

/// Place of a body and its rigid motion.
struct BodyMotion {
    Vec3d place{0, 0, 0};                        ///< origin of the surface's coordinates, m
    Vec3d velocity{0, 0, 0};                     ///< of this origin, m/s
    Vec3d spin{0, 0, 0};                         ///< angular velocity, rad/s
    Mat3d axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; ///< rows: axes of the surface's coordinates
};

/// Body with a sharp surface, rigid or a rod.
struct SharpBody {
    std::unique_ptr<Surface> surface;                   ///< of a rigid body
    std::unique_ptr<SweptSurface> swept = {};           ///< of a rod
    std::function<BodyMotion(double time)> motion = {}; ///< empty: SharpNodes::set_motion()
    bool moves = false;                                 ///< its places change with time

    /// Elements of a rod; 1 of a rigid body.
    std::size_t pieces() const { return swept ? swept->elements() : 1; }
};

/// Node that one body acts on: within it the velocity is the body's, and next to it the Laplacian changes by
/// pull + sum of ahead (velocity of the neighbour on that side) - excess (velocity of the node).
struct SharpNode {
    static constexpr double inside = std::numeric_limits<double>::infinity();

    std::ptrdiff_t at;      ///< offset in a field of this rank
    double velocity;        ///< of the body, m/s
    double excess = inside; ///< `inside`: within the body
    double pull = 0;        ///< m/s
    double closed = 0;      ///< share of the node's face within the body
    double gain = 0;        ///< of the body's velocity here in the stage, m/s
    Vec3d arm;              ///< from the body's origin, or from the axis of a rod, m
    double along = 0;       ///< share of the element of a rod
    double of_other = 0;    ///< share of another element in the spin
    double relative = 0;    ///< `velocity` relative to the axis of a rod at its foot, m/s
    double share = 1;       ///< of its action, whose rest markers have
    std::array<double, 3> ahead{};
    std::uint32_t body;
    std::uint32_t piece; ///< number among the pieces of all bodies
    std::uint32_t other; ///< number of the piece of that element
    std::int32_t row;
    std::uint8_t component;
    std::array<std::int8_t, 3> side{};
    bool again = false; ///< the next node is the same one, cut by another body
};

/// All results have the same bits on any ranks and threads.
class SharpNodes {
public:
    SharpNodes(const Threads& threads, const FluidGrid& grid, const Pencils& pencils, std::vector<SharpBody> bodies);

    std::size_t bodies() const { return bodies_.size(); }
    bool some_move() const { return some_move_; }
    /// Sets the motion of a body that has none of its own, at the begin and the end of a stage.
    void set_motion(std::size_t body, const BodyMotion& begin, const BodyMotion& end) {
        before_[body] = begin;
        now_[body] = end;
    }
    /// The same of a rod, whose first node is at these places, m.
    void set_motion(std::size_t body, const Vec3d& begin_place, RodMotion begin, const Vec3d& end_place, RodMotion end);
    /// Pieces of all bodies, and the first one of each.
    std::size_t pieces() const { return first_piece_.back(); }
    std::size_t first_piece(std::size_t body) const { return first_piece_[body]; }
    /// Surface of the rod of a node; null: it belongs to a rigid body.
    const SweptSurface* swept(const SharpNode& node) const { return swept(node.body); }
    const SweptSurface* swept(std::size_t body) const { return bodies_[body].swept.get(); }
    /// Puts bodies to their places at the end of a stage of this length, s. Not collective.
    void settle(double time, double length);
    /// Calls body(nodes) for the lists of nodes of a plane of this rank.
    template <class Body> void for_lists(int plane, Body&& body) const {
        for (const Cluster& cluster : clusters_) body(std::span<const SharpNode>(nth(cluster.planes, plane)));
    }
    bool reaches(int plane) const;

private:
    /// Bodies whose surroundings overlap.
    struct Cluster {
        std::vector<std::uint32_t> bodies;
        std::vector<std::vector<SharpNode>> planes; ///< by plane of this rank
    };
    /// Cells about a body from first to last, which may lie beyond periodic faces.
    struct Block {
        std::array<std::int64_t, 3> first, last;
    };
    /// Body or its periodic image, with the part of its block in the box.
    struct Image {
        std::uint32_t body;
        std::array<std::int64_t, 3> shift; ///< cells from the node's number to the number in coordinates of the body
        std::array<int, 3> first, last;
    };
    class Row;

    Block block_of(std::uint32_t body) const;
    bool overlap(const Block& a, const Block& b) const;
    /// Cells of this rank.
    Block own_block() const;
    std::vector<std::vector<std::uint32_t>> overlapping() const;
    std::vector<Image> images_of(const Cluster& cluster) const;
    void fill(Cluster& cluster) const;
    bool rests(const Cluster& cluster) const;

    const Threads& threads_;
    FluidGrid grid_;
    Pencils pencils_;
    FieldLayout layout_;
    std::vector<SharpBody> bodies_;
    std::vector<std::size_t> first_piece_; ///< by body, and the number of all
    std::vector<BodyMotion> before_, now_; ///< at the begin and the end of the stage; of rods the place alone
    std::vector<Block> blocks_;
    bool settled_ = false, some_move_ = false;
    std::vector<Cluster> clusters_;
};

} // namespace skein
