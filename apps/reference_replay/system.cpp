#include "system.hpp"

#include "dampers.hpp"
#include "drift.hpp"
#include "ring.hpp"

#include "rod/elastica.hpp"
#include "rod/kick.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

namespace skein::replay {

namespace {

/// Entries of a list that name `number` as their system.
std::vector<Entry> entries_of(const Entry& list, int number, int systems) {
    std::vector<Entry> found;
    for (const Entry& e : list.list()) {
        if (e.has("other")) throw NotBuilt("'" + e["kind"].text() + "' between systems (" + e.path() + ")");
        if (e["system"].index(systems) == number) found.push_back(e);
    }
    return found;
}

} // namespace

System read_system(const Entry& e, int number) {
    const std::string kind = e["kind"].text();
    if (kind != "rod") throw NotBuilt("system '" + kind + "' (" + e.path() + ")");
    const auto n = e["rest_lengths"].list().size();
    const bool ring = e.has("ring") && e["ring"].json() == true;
    if (n < (ring ? 3u : 1u)) e.fail("has too few elements");
    const std::size_t nodes = ring ? n : n + 1, cells = ring ? n : n - 1;
    const auto length = e["rest_lengths"].positives(n), volume = e["volume"].positives(n), mass = e["mass"].positives(nodes);
    const auto inertia = e["mass_second_moment_of_inertia"].vectors(n), shear = e["shear_matrix"].vectors(n), sigma = e["rest_sigma"].vectors(n);
    const auto cell = e["rest_voronoi_lengths"].positives(cells);
    const auto bend = e["bend_matrix"].vectors(cells), kappa = e["rest_kappa"].vectors(cells);

    // A straight rod of this size, and then every constant that the passes read as the file has it.
    RodSpec spec;
    spec.name = e.path();
    spec.source = e.path();
    spec.material = {.density = 1, .youngs_modulus = 1, .law = Law::elastica};
    spec.section = {.radius = 1};
    spec.shape = {.length = std::accumulate(length.begin(), length.end(), 0.0), .elements = static_cast<long>(n), .closed = ring};
    System system{RodGroup(spec, number, number, ""), std::vector<Slot<1>>(n + 1)};
    for (std::size_t k = 0; k < n; ++k) {
        ElementConstants& c = system.group.element[k];
        const Vec3d& j = inertia[k];
        if (!(j.x > 0 && j.y > 0 && j.z > 0)) e["mass_second_moment_of_inertia"].fail("is not positive");
        c = {.rest_length = length[k], .inv_rest_length = 1 / length[k], .volume = volume[k], .radius = std::sqrt(volume[k] / (std::numbers::pi * length[k])),
             .stiffness = shear[k], .rest_strain = sigma[k], .rest_stretch = 1 + sigma[k].z, .inertia = j, .inv_inertia = {1 / j.x, 1 / j.y, 1 / j.z}, .inertia_ratio = j.z / j.x, .bending = c.bending};
    }
    for (std::size_t k = 0; k < cells; ++k) {
        const double before = length[k], after = length[(k + 1) % n];
        system.group.voronoi[k] = {1 / cell[k], 0.5 * before / cell[k], 0.5 * after / cell[k], bend[k], kappa[k]};
    }
    system.group.node_mass.assign(n + 1, 0.0);
    std::copy(mass.begin(), mass.end(), system.group.node_mass.begin());

    const auto position = e["position"].vectors(nodes), velocity = e["velocity"].vectors(nodes), omega = e["omega"].vectors(n);
    const auto director = e["directors"].matrices(n);
    for (std::size_t k = 0; k <= n; ++k) {
        Slot<1>& s = system.start[k];
        s.position = broadcast<1>(position[k % nodes]);
        s.velocity = broadcast<1>(velocity[k % nodes]);
        if (k < n) s.director = broadcast<1>(quaternion(director[k])), s.spin = broadcast<1>(omega[k]);
        else s.director = broadcast<1>(no_turn), s.spin = {};
    }
    return system;
}

Program make_program(const Entry& file, const System& system, int number, const Stepping& stepping) {
    const RodGroup& group = system.group;
    const int systems = static_cast<int>(file["systems"].list().size());
    std::vector<std::unique_ptr<TilePass<1>>> loads;
    for (const Entry& e : entries_of(file["forces_in_order"], number, systems)) loads.push_back(make_load(e, group));
    auto external = std::make_unique<External>(std::move(loads), system.start.size());
    std::vector<KickConstants> kicks;
    for (const double share : stepping.scheme.kicks) kicks.emplace_back(group, DampingRates{}, share * stepping.dt);

    Program program{.loads = external.get()};
    for (const Entry& e : entries_of(file["constraints_in_order"], number, systems)) program.constraints.push_back(make_constraint(e, system.start, group.closed()));
    auto& passes = program.passes;
    passes.push_back(std::make_unique<PublishedDrift>(stepping.scheme.stages.size()));
    for (const auto& c : program.constraints) passes.push_back(std::make_unique<ValuesPass>(c));
    if (group.closed()) passes.push_back(std::make_unique<ClosePositionPass>());
    passes.push_back(std::make_unique<ElasticaPass<1>>(ends_of(group)));
    passes.push_back(std::move(external));
    if (group.closed()) passes.push_back(std::make_unique<FoldRingPass<1>>());
    passes.push_back(std::make_unique<KickPass<KickKind::elastica, 1>>(std::move(kicks)));
    for (const auto& c : program.constraints) passes.push_back(std::make_unique<RatesPass>(c));
    if (group.closed()) passes.push_back(std::make_unique<CloseVelocityPass>());
    for (const Entry& e : entries_of(file["dampers_in_order"], number, systems)) passes.push_back(make_damper(e, group));
    return program;
}

} // namespace skein::replay
