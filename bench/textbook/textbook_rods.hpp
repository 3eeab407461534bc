// The yardstick: Skein's discrete model of clamped, magnetised, damped rods, written the way a textbook code writes it.
// One object per rod; one array per component along the rod; one loop per term, intermediates stored; sines from the
// C++ library; every step begins and ends with half a drift. No step allocates, and no loop is slower than it need be.
//   theory.md (5)-(24), (34)-(35), without merged drifts, packs, tiles, shared constants and polynomials
//
// Circular sections, half-cell clamp at the start, free end, incompressible law, legacy damping, uniform magnetic
// field: anything else is refused. The steps are compiled twice, as users compile such a code and as one who tunes
// flags does.
#pragma once

#include "loads/magnetic_field.hpp"
#include "plan/plan.hpp"

#include <vector>

namespace skein::bench {

/// How the loops of the steps are compiled: by the program's flags, or told that no arrays overlap, by -Ofast and with
/// the vector functions of the C library.
enum class TextbookBuild { plain, vectorised };

/// Three components, each along the rod.
struct Vectors {
    explicit Vectors(std::size_t size) : x(size), y(size), z(size) {}
    std::vector<double> x, y, z;
};

class TextbookRod {
public:
    TextbookRod(const RodGroup& group, std::int64_t index, const std::vector<Damping>& damping, double dt);

    /// One step of the length given at construction under the field b [T, lab] at its middle.
    template <TextbookBuild B> void step(const Vec3d& field);
    /// State at the present time; one slot per node.
    void state(std::span<Slot<1>> out) const;
    std::size_t bytes() const;

private:
    template <TextbookBuild B> void drift(double h);
    template <TextbookBuild B> void strains();
    template <TextbookBuild B> void stresses();
    template <TextbookBuild B> void turns();
    template <TextbookBuild B> void moments();
    template <TextbookBuild B> void forces();
    template <TextbookBuild B> void couples();
    template <TextbookBuild B> void magnetic_couples(const Vec3d& field);
    template <TextbookBuild B> void kick();

    std::size_t n_; ///< elements
    double dt_;

    // Nodes, [n + 1]. Lab.
    Vectors position_, velocity_, force_;
    std::vector<double> decay_, gain_; ///< exp(-z), (h/m) phi1(z)

    // Frames, [n + 1]: the wall's, then one per element.
    Vectors d1_, d2_, d3_;

    // Elements, [n]. Body, but for edge and internal force.
    Vectors spin_, couple_, turn_, edge_, strain_, stress_, internal_force_;
    std::vector<double> angle_, sine_over_angle_, versine_over_square_;
    std::vector<double> length_, axial_ratio_;               ///< rest length, J3/J1
    std::vector<double> shear_stiffness_, axial_stiffness_;  ///< N
    std::vector<double> rate_transverse_, rate_axial_;       ///< z per dilatation
    std::vector<double> impulse_transverse_, impulse_axial_; ///< h/J_i
    Vectors moment_;                                         ///< V m, A m^2

    // Cells, [n + 1]: cell k lies between elements k-1 and k; the wall's half cell first, the empty one of the free end
    // last.
    Vectors skew_, phi_, tau_, first_, second_; ///< twice the sine, log, moment, a = phi x tau, b = g phi x a
    std::vector<double> trace_, cell_angle_, cell_dilatation_, energy_, tension_;
    std::vector<double> cell_length_, share_before_, share_after_, bending_, torsion_;
};

/// The first rods of a scene's group, stepped one after the other.
class TextbookRods {
public:
    /// Throws InputError where the group or its plan needs what the textbook has not.
    TextbookRods(const RodGroup& group, const GroupPlan& plan, double dt, std::int64_t count,
                 TextbookBuild build = TextbookBuild::plain);

    void advance(std::span<const Step> steps);
    std::size_t count() const { return rods_.size(); }
    TextbookBuild build() const { return build_; }
    void state(std::size_t i, std::span<Slot<1>> out) const { rods_[i].state(out); }
    std::size_t bytes() const;

private:
    TextbookBuild build_;
    MagneticField field_;
    std::vector<TextbookRod> rods_;
};

} // namespace skein::bench
