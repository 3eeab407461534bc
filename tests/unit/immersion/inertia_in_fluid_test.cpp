// Fluid within rods bears its own inertia, all of it and no more, where markers move it.
#include "immersion/immersed_kinds.hpp"
#include "immersion/inertia_in_fluid.hpp"
#include "immersion/rod_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace skein {
namespace {

constexpr double density = 1.2; // of the fluid, kg/m^3

struct Example {
    std::string name;
    SectionKind kind;
    double a, b, spacing;
    int elements;
    bool closed = false;
    double taper = 1;
};
const Example examples[] = {
    {"rings", SectionKind::circular, 0.5, 0, 0.1, 20},
    {"rings further apart than elements are long", SectionKind::circular, 0.5, 0, 0.3, 40},
    {"tapered", SectionKind::circular, 0.5, 0, 0.1, 20, false, 0.2},
    {"a sheet", SectionKind::elliptic, 0.5, 0.02, 0.1, 20},
    {"a plate", SectionKind::rectangular, 0.5, 0.3, 0.1, 20},
    {"a line of markers", SectionKind::circular, 0.06, 0, 0.1, 20},
    {"a line of markers further apart than elements are long", SectionKind::circular, 0.06, 0, 0.1, 90},
    {"a closed rod", SectionKind::circular, 0.2, 0, 0.08, 30, true},
};

RodGroup rod(const Example& e, double rod_density) {
    RodSpec spec;
    spec.material = {.density = rod_density, .youngs_modulus = 1};
    spec.section = {.kind = e.kind, .radius = e.a, .radius_2 = e.b, .taper = e.taper};
    spec.shape.length = 3;
    spec.shape.elements = e.elements;
    spec.shape.closed = e.closed;
    return {spec, 0, 0, "."};
}

std::vector<RodMarker> markers_of(const RodGroup& group, double spacing) {
    FluidGrid grid;
    grid.h = spacing;
    grid.cells = {40, 40, 40};
    return rod_markers(group, grid, 0.4 * spacing);
}

TEST(InertiaInFluid, SharesOfSlotsAddUpToTheDisplacedFluid) {
    for (const Example& e : examples) {
        const RodGroup group = rod(e, 0.9);
        const InertiaInFluid inertia(group, markers_of(group, e.spacing), density, true);
        double of_slots = 0, displaced = 0;
        for (std::size_t k = 0; k < group.node_mass.size(); ++k)
            of_slots += inertia.of_nodes[k].displaced * group.node_mass[k];
        for (const ElementConstants& c : group.element) displaced += density * c.volume;
        EXPECT_NEAR(of_slots, displaced, 1e-12 * displaced) << e.name;
        EXPECT_NEAR(inertia.density_ratio * std::accumulate(group.node_mass.begin(), group.node_mass.end(), 0.0),
                    displaced, 1e-12 * displaced)
            << e.name;
    }
}

/// Surfaces that are sharp along a part of a rod have its displaced fluid there, and markers the rest.
TEST(InertiaInFluid, SharesOfMarkersAndSharpSurfacesAddUp) {
    for (const Example& e : examples) {
        const RodGroup group = rod(e, 0.9);
        FluidGrid grid;
        grid.h = e.spacing;
        grid.cells = {40, 40, 40};
        const std::size_t nodes = group.node_mass.size();
        for (const double end : {0.0, 0.3, 1.0}) {
            std::vector<double> sharp(nodes);
            for (std::size_t i = 0; i < nodes; ++i)
                sharp[i] = std::clamp(1 - 3 * static_cast<double>(i) / static_cast<double>(nodes), end, 1.0);
            const std::vector<RodMarker> markers = rod_markers(group, grid, 0.4 * e.spacing, sharp);
            EXPECT_EQ(markers.empty(), end == 1) << e.name;
            const InertiaInFluid inertia(group, markers, density, true, sharp);
            double of_slots = 0, displaced = 0;
            for (std::size_t k = 0; k < nodes; ++k) of_slots += inertia.of_nodes[k].displaced * group.node_mass[k];
            for (const ElementConstants& c : group.element) displaced += density * c.volume;
            EXPECT_NEAR(of_slots, displaced, 1e-12 * displaced) << e.name << " " << end;
        }
    }
}

/// Displaced over own mass of a rod of a scene, over the same of its volume, and the same of turning about its axis.
struct Displacement {
    double mass, turning;
    bool sharp, markers;

    Displacement(const Example& e, bool asks_sharp) {
        const RodGroup group = rod(e, 0.9);
        FluidGrid grid;
        grid.h = e.spacing;
        grid.cells = {40, 40, 40};
        const ImmersedKinds kinds(
            grid, {.retraction = 0.4 * e.spacing, .density = density, .feels_fluid = true, .sharp_rods = asks_sharp});
        const ImmersedKinds::Kind& kind = kinds.of(group, 0);
        double of_slots = 0, of_volume = 0, of_turns = 0, of_own_turns = 0;
        for (std::size_t k = 0; k < group.node_mass.size(); ++k)
            of_slots += kind.inertia->of_nodes[k].displaced * group.node_mass[k];
        for (std::size_t k = 0; k < group.element.size(); ++k) {
            of_volume += density * group.element[k].volume;
            of_turns += kind.inertia->of_elements[k].displaced.z * group.element[k].inertia.z;
            of_own_turns += density / 0.9 * group.element[k].inertia.z;
        }
        mass = of_slots / of_volume;
        turning = of_turns / of_own_turns;
        sharp = kind.sharp;
        markers = !kind.markers.empty();
    }
};

/// Also that of ends between the last ring of markers and the flat end, which lies further out by the retraction, and
/// of elements shorter than this.
TEST(InertiaInFluid, DisplacedFluidOfWholeRodsIsThatOfTheirVolume) {
    for (const double taper : {1.0, 0.8, 0.326, 0.3, 0.2, 0.05})
        for (const int elements : {3, 20, 300}) {
            const Example e{"", SectionKind::circular, 0.15, 0, 0.1, elements, false, taper};
            for (const bool asks_sharp : {false, true}) {
                const Displacement found(e, asks_sharp);
                EXPECT_EQ(found.sharp, asks_sharp) << taper << " " << elements;
                EXPECT_NEAR(found.mass, 1, 1e-12) << taper << " " << elements << " " << asks_sharp;
                // Lines of markers on the axis turn no fluid.
                if (!found.markers) {
                    EXPECT_NEAR(found.turning, 1, 1e-12) << taper << " " << elements;
                }
                EXPECT_LE(found.turning, 1 + 1e-12) << taper << " " << elements << " " << asks_sharp;
            }
        }
    for (const Example& e : examples)
        for (const bool asks_sharp : {false, true}) EXPECT_NEAR(Displacement(e, asks_sharp).mass, 1, 1e-12) << e.name;
}

/// Markers end at the retraction, so that a thin start that is shorter has none.
TEST(InertiaInFluid, ShortThinEndsHaveTheirFluidWhereAnotherThinEndHasMarkers) {
    constexpr std::size_t elements = 300;
    for (const bool at_start : {true, false}) {
        RodSpec spec;
        spec.material = {.density = 0.9, .youngs_modulus = 1};
        spec.section = {.kind = SectionKind::circular, .radius = 0.15};
        spec.section.profile.assign(elements, 1);
        std::fill_n(spec.section.profile.begin(), at_start ? 2 : 100, 0.1);
        std::fill_n(spec.section.profile.rbegin(), at_start ? 100 : 2, 0.1);
        spec.shape.length = 3;
        spec.shape.elements = elements;
        const RodGroup group(spec, 0, 0, ".");
        FluidGrid grid;
        grid.h = 0.1;
        grid.cells = {40, 40, 40};
        const ImmersedKinds kinds(grid,
                                  {.retraction = 0.04, .density = density, .feels_fluid = true, .sharp_rods = true});
        const ImmersedKinds::Kind& kind = kinds.of(group, 0);
        ASSERT_FALSE(kind.markers.empty());
        double all = 0, own = 0;
        for (std::size_t i = 0; i <= elements; ++i) {
            all += kind.inertia->of_nodes[i].displaced * group.node_mass[i];
            own += group.node_mass[i];
        }
        EXPECT_NEAR(all, density / 0.9 * own, 1e-12 * own);
        double near_end = 0, volume = 0; // of the first five elements, and of half of the next one
        for (std::size_t k = 0; k <= 5; ++k) {
            const std::size_t i = at_start ? k : elements - k;
            EXPECT_EQ(kind.sharp_shares[i], 1);
            near_end += kind.inertia->of_nodes[i].displaced * group.node_mass[i];
            volume += (k < 5 ? 1 : 0.5) * group.element[at_start ? k : elements - 1 - k].volume;
        }
        EXPECT_NEAR(near_end, density * volume, 1e-12 * near_end);
    }
}

TEST(InertiaInFluid, TurnsWithAnElementWhereMarkersLieOffItsAxis) {
    for (const Example& e : examples) {
        const RodGroup group = rod(e, 0.9);
        const std::vector<RodMarker> markers = markers_of(group, e.spacing);
        const InertiaInFluid inertia(group, markers, density, true);
        for (std::size_t k = 0; k < group.element.size(); ++k) {
            bool off_d1 = false, off_d2 = false;
            for (const RodMarker& m : markers)
                if (m.element == k) {
                    off_d1 |= m.off_d1 != 0;
                    off_d2 |= m.off_d2 != 0;
                }
            const Vec3d& displaced = inertia.of_elements[k].displaced;
            EXPECT_EQ(displaced.x > 0, off_d2) << e.name << ", element " << k;
            EXPECT_EQ(displaced.y > 0, off_d1) << e.name << ", element " << k;
            EXPECT_EQ(displaced.z > 0, off_d1 || off_d2) << e.name << ", element " << k;
        }
    }
    const RodGroup thick = rod(examples[0], 0.9);
    const InertiaInFluid inertia(thick, markers_of(thick, examples[0].spacing), density, true);
    Vec3d displaced{0, 0, 0}, own{0, 0, 0};
    for (std::size_t k = 0; k < thick.element.size(); ++k) {
        displaced += scale(inertia.of_elements[k].displaced, thick.element[k].inertia);
        own += thick.element[k].inertia;
    }
    EXPECT_NEAR(norm(displaced - inertia.density_ratio * own), 0, 1e-12 * norm(own));
}

TEST(InertiaInFluid, IsNoneWhereTurnsOfAPlateMoveNoFluid) {
    constexpr double a = 0.5, b = 0.3;
    const RodGroup plate = rod({"a plate", SectionKind::rectangular, a, b, 0.1, 20}, 0.9);
    const double ratio = density / 0.9;
    for (const bool spans : {false, true}) {
        const InertiaInFluid inertia(plate, {}, density, true, std::vector<double>(plate.node_mass.size(), 1), spans);
        for (const InertiaShares<Vec3d>& e : inertia.of_elements) {
            EXPECT_NEAR(e.displaced.x, spans ? 0 : ratio, 1e-12);
            EXPECT_NEAR(e.displaced.y, ratio, 1e-12);
            EXPECT_NEAR(e.displaced.z, spans ? ratio * a * a / (a * a + b * b) : ratio, 1e-12);
        }
    }
}

TEST(InertiaInFluid, IsNoneOfScaledRotaryInertia) {
    Example e = examples[0];
    const RodGroup plain = rod(e, 0.9);
    RodSpec spec = plain.spec();
    spec.material.rotary_inertia_scale = 25;
    const RodGroup scaled(spec, 0, 0, ".");
    const std::vector<RodMarker> markers = markers_of(plain, e.spacing);
    const InertiaInFluid of_plain(plain, markers, density, true), of_scaled(scaled, markers, density, true);
    for (std::size_t k = 0; k < plain.element.size(); ++k) {
        const Vec3d one = scale(of_plain.of_elements[k].displaced, plain.element[k].inertia),
                    other = scale(of_scaled.of_elements[k].displaced, scaled.element[k].inertia);
        EXPECT_NEAR(norm(one - other), 0, 1e-12 * norm(one)) << k;
    }
}

/// A step returns 3/2 of little added momentum where all of the surface is sharp, and elsewhere what markers return.
TEST(InertiaInFluid, SharpPartsReturnLittleAddedMomentumBeforeItIsDue) {
    for (const double rod_density : {0.5 * density, 0.94 * density, 0.95 * density, density, 1.2 * density}) {
        const RodGroup group = rod(examples[0], rod_density);
        const std::size_t nodes = group.node_mass.size();
        std::vector<double> sharp(nodes, 1);
        std::fill_n(sharp.begin(), nodes / 2, 0.5);
        const InertiaInFluid inertia(group, markers_of(group, 0.1), density, true, sharp);
        const bool early = rod_density > 0.949 * density;
        for (std::size_t i = 0; i < nodes; ++i) {
            if (i == nodes / 2) continue; // has fluid of both parts
            const auto& s = inertia.of_nodes[i];
            const double by_markers = s.added > 0 ? std::pow(std::min(1.0, 0.25 * s.displaced / s.added), 1.5) : 1;
            EXPECT_DOUBLE_EQ(s.relaxation, i >= nodes / 2 && early ? 1.5 : by_markers) << rod_density << " " << i;
            if (i + 1 < nodes) {
                EXPECT_EQ(inertia.of_elements[i].relaxation.z == 1.5, i >= nodes / 2 && early)
                    << rod_density << " " << i;
            }
        }
    }
}

TEST(InertiaInFluid, EffectiveInertiaIsTheOwnAndTheAdded) {
    for (const Example& e : examples)
        for (const double rod_density : {0.2, 0.9, density, 2.0, 1000.0}) {
            const RodGroup group = rod(e, rod_density);
            const std::vector<RodMarker> markers = markers_of(group, e.spacing);
            const auto check = [&](double displaced, double effective, double added, double relaxation) {
                EXPECT_NEAR(effective - added, 1 - displaced, 1e-12 * (1 + displaced)) << e.name;
                EXPECT_GE(effective, 0.25 * displaced) << e.name;
                EXPECT_GE(added, 0) << e.name;
                EXPECT_DOUBLE_EQ(relaxation, added > 0 ? std::pow(std::min(1.0, 0.25 * displaced / added), 1.5) : 1)
                    << e.name;
                if (displaced <= 1) {
                    EXPECT_EQ(relaxation, 1) << e.name << ", " << displaced << " of its inertia displaced";
                }
            };
            const InertiaInFluid inertia(group, markers, density, true), outside(group, markers, density, false);
            double least = 1;
            for (const auto& s : inertia.of_nodes) {
                check(s.displaced, s.effective, s.added, s.relaxation);
                least = std::min(least, s.effective);
            }
            for (const auto& s : inertia.of_elements)
                for (int c = 0; c < 3; ++c) {
                    const auto of = [&](const Vec3d& v) { return component_of(v, c); };
                    check(of(s.displaced), of(s.effective), of(s.added), of(s.relaxation));
                    least = std::min(least, of(s.effective));
                }
            EXPECT_EQ(inertia.least_effective(), least) << e.name;
            for (const auto& s : outside.of_nodes) EXPECT_EQ(s.displaced, 0) << e.name;
            EXPECT_EQ(outside.least_effective(), 1) << e.name;
        }
}

} // namespace
} // namespace skein
