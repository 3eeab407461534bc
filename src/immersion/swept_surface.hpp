// Surface of a rod in its present shape: sections of its elements with flat ends, and the velocities of points within.
// theory.md (152), (153)
#pragma once

#include "immersion/element_cubes.hpp"
#include "skein/core/vec3.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

enum class SweptSection {
    ellipse,
    rectangle,
    plate ///< rectangle that spans the box along d2, so that it has two sides alone
};

/// Shape and rates of a rod, lab. Places are from its first node.
struct RodMotion {
    std::vector<Vec3d> node, velocity; ///< [elements + 1], m, m/s
    std::vector<Mat3d> frame;          ///< [elements], rows d1, d2, d3
    std::vector<Vec3d> spin;           ///< [elements], rad/s

    /// The motion after a time at the present rates, with the way of the first node, m, taken off.
    RodMotion after(double time) const;
    /// Sets rates to their means over a time, s, that began with another motion, whose first node has gone a way since.
    void take_means(const RodMotion& begin, const Vec3d& way, double time);
};

/// Mean spin that turns one frame into another one in a time, s: rad/s, lab.
Vec3d mean_spin(const Mat3d& from, const Mat3d& to, double time);

/// Share of a rod's action on the fluid within an element, by those of nodes.
inline double share_at(std::span<const double> of_nodes, std::size_t element, double along) {
    return (1 - along) * of_nodes[element] + along * of_nodes[element + 1];
}

class SweptSurface {
public:
    /// Sizes of an element at rest, m.
    struct Element {
        double along_d1, along_d2, rest_length;
    };
    struct Rod {
        SweptSection section;
        std::vector<Element> elements;
        int through = -1; ///< direction along which it spans a periodic box, as a plate along d2 or a cylinder along
                          ///< its axis; -1: none
        std::vector<double> shares = {}; ///< of its action on the fluid, by node; empty: all of it
        double near = 0;                 ///< m, distance within which most feet are asked for; 0: none
        bool closed = false;
    };
    explicit SweptSurface(Rod rod);

    std::size_t elements() const { return element_.size(); }
    void put(RodMotion begin, RodMotion end);
    /// Makes searches for feet fast after put().
    void sort();

    /// Point of the axis that is nearest to a place.
    struct Foot {
        std::uint32_t element = 0;
        double along = 0;    ///< share of the way between the nodes of the element
        Vec3d off{0, 0, 0};  ///< from the axis to the place, m
        double distance = 0; ///< of the place from the surface, m, above 0 in the fluid
    };
    Foot nearest(const Vec3d& place) const;
    /// True if markers have a part of its action.
    bool has_part() const { return !shares_.empty(); }
    /// Share of its action on the fluid there.
    double share(const Foot& foot) const { return has_part() ? share_at(shares_, foot.element, foot.along) : 1; }
    /// Velocity of the point of the rod there, m/s, at the end and the begin of the stage.
    Vec3d velocity(const Foot& foot) const { return velocity_of(now_, of_sections_, foot); }
    Vec3d velocity_before(const Foot& foot) const { return velocity_of(before_, of_sections_before_, foot); }
    /// Velocity of the axis at the foot, m/s, at the end of the stage.
    Vec3d axis_velocity(const Foot& foot) const {
        const Vec3d* const of = &now_.velocity[foot.element];
        return (1 - foot.along) * of[0] + foot.along * of[1];
    }
    /// Spin at a foot: linear between the middles of its element and another one.
    struct Turning {
        std::size_t other, node; ///< the node between both; SIZE_MAX: there is none
        double share;            ///< of the other's spin
    };
    Turning turning(const Foot& foot) const;
    /// Part of velocity() across the axis by which sections take the volume of bending back, 0 at the surface.
    Vec3d shift(const Foot& foot) const { return shift_of(of_sections_, foot, turning(foot)); }
    /// Direction of an element's axis.
    Vec3d tangent(std::size_t k) const { return (1 / length_[k]) * (now_.node[k + 1] - now_.node[k]); }
    const Mat3d& frame(std::size_t element) const { return now_.frame[element]; }
    /// Place of a node from the first one, m.
    const Vec3d& node(std::size_t number) const { return now_.node[number]; }
    /// Corners of a box that holds what acts, m, from the first node; infinite where it spans the box.
    const Vec3d& lower() const { return lower_; }
    const Vec3d& upper() const { return upper_; }

private:
    /// Half axes at a share of an element in its present stretch, m.
    struct Half {
        double along_d1, along_d2;
    };
    Half half_at(std::size_t element, double along) const;
    /// Distance from the surface of a section, m, `beyond` its plane at a joint.
    double from_section(const Half& half, double y1, double y2, double beyond) const;
    /// Rates that sections follow to keep their volume: of stretch, 1/s by element, and of bending, spin gained along
    /// the rod, 1/(m s) by node. Waves that are short beside the radius are left out. theory.md (153b)
    struct SectionRates {
        std::vector<double> stretch;
        std::vector<Vec3d> bend;
    };
    void find_rates(const RodMotion& motion, SectionRates& rates) const;
    Vec3d velocity_of(const RodMotion& motion, const SectionRates& rates, const Foot& foot) const;
    Vec3d shift_of(const SectionRates& rates, const Foot& foot, const Turning& turning) const;
    /// Place from the first node in coordinates of cubes; plates have two.
    Vec3d in_cubes(const Vec3d& place) const;
    Foot nearest_of(std::span<const std::uint32_t> elements, const Vec3d& place) const;
    /// Share of the foot on an element's line, which may lie beyond its nodes.
    double share_on(std::size_t k, const Vec3d& place) const { return dot(place - now_.node[k], per_share_[k]); }
    /// True if an element has a foot: between its nodes, at an end of the rod, or at a node that no other one has.
    bool has_foot(std::size_t k, const Vec3d& place) const {
        const double share = share_on(k, place);
        if (share > 1) return !closed_ && k + 1 == element_.size(); // a later one has it
        if (share >= 0 || (!closed_ && k == 0)) return true;
        return share_on(k > 0 ? k - 1 : element_.size() - 1, place) > 1; // else the element before has it
    }
    /// Takes the foot on an element that has one, if it is nearer than `best`.
    void take_nearer(std::size_t k, const Vec3d& place, Foot& best) const;

    bool endless() const { return through_ >= 0 && section_ != SweptSection::plate; }

    SweptSection section_;
    std::vector<Element> element_;
    int through_;
    std::vector<double> shares_; ///< by node; empty: all are 1
    double near_;
    bool closed_;
    std::vector<Half> of_node_; ///< at rest
    int smoothings_ = 0;        ///< of section rates
    RodMotion before_, now_;
    SectionRates of_sections_before_, of_sections_;
    std::vector<double> length_, to_end_; ///< by element and node: length and way along the rod to its nearer end, m
    std::vector<double> cover_;           ///< by element: radius of a ball about its middle that holds it, m
    std::vector<Vec3d> middle_;           ///< by element, in coordinates of cubes, m
    std::vector<Vec3d> per_share_;        ///< by element, 1/m: times the way from its first node, the share of the foot
    std::vector<std::uint32_t> all_;      ///< numbers of all elements
    ElementCubes cubes_;
    bool sorted_ = false;
    Vec3d lower_{0, 0, 0}, upper_{0, 0, 0};
};

} // namespace skein
