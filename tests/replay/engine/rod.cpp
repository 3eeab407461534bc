#include "rod.hpp"

#include "dampers.hpp"
#include "drift.hpp"
#include "ring.hpp"

#include "mechanics/elastica.hpp"
#include "mechanics/kick.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

namespace skein::replay {

Rod read_rod(const Entry& e, int number) {
    const auto n = e["rest_lengths"].list().size();
    const bool ring = e.has("ring") && e["ring"].json() == true;
    if (n < (ring ? 3u : 1u)) e.fail("has too few elements");
    const std::size_t nodes = ring ? n : n + 1, cells = ring ? n : n - 1;
    const auto length = e["rest_lengths"].positives(n), volume = e["volume"].positives(n),
               mass = e["mass"].positives(nodes);
    const auto inertia = e["mass_second_moment_of_inertia"].vectors(n), shear = e["shear_matrix"].vectors(n),
               sigma = e["rest_sigma"].vectors(n);
    const auto cell = e["rest_voronoi_lengths"].positives(cells);
    const auto bend = e["bend_matrix"].vectors(cells), kappa = e["rest_kappa"].vectors(cells);

    // A straight rod of this size, and then every constant that the passes read as the file has it.
    RodSpec spec;
    spec.name = e.path();
    spec.source = e.path();
    spec.material = {.density = 1, .youngs_modulus = 1, .law = Law::elastica};
    spec.section = {.radius = 1};
    spec.shape = {
        .length = std::accumulate(length.begin(), length.end(), 0.0), .elements = static_cast<long>(n), .closed = ring};
    Rod rod{RodGroup(spec, number, number, ""), std::vector<Slot<1>>(n + 1), std::vector<SlotLoad<1>>(n + 1),
            std::vector<SlotLoad<1>>(n + 1)};
    for (std::size_t k = 0; k < n; ++k) {
        ElementConstants& c = rod.group.element[k];
        const Vec3d& j = inertia[k];
        if (!(j.x > 0 && j.y > 0 && j.z > 0)) e["mass_second_moment_of_inertia"].fail("is not positive");
        c = {.rest_length = length[k],
             .inv_rest_length = 1 / length[k],
             .volume = volume[k],
             .radius = std::sqrt(volume[k] / (std::numbers::pi * length[k])),
             .stiffness = shear[k],
             .rest_strain = sigma[k],
             .rest_stretch = 1 + sigma[k].z,
             .inertia = j,
             .inv_inertia = {1 / j.x, 1 / j.y, 1 / j.z},
             .inertia_ratio = j.z / j.x,
             .bending = c.bending};
    }
    for (std::size_t k = 0; k < cells; ++k) {
        const double before = length[k], after = length[(k + 1) % n];
        rod.group.voronoi[k] = {1 / cell[k], 0.5 * before / cell[k], 0.5 * after / cell[k], bend[k], kappa[k]};
    }
    rod.group.node_mass.assign(n + 1, 0.0);
    std::copy(mass.begin(), mass.end(), rod.group.node_mass.begin());

    const auto position = e["position"].vectors(nodes), velocity = e["velocity"].vectors(nodes),
               omega = e["omega"].vectors(n);
    const auto director = e["directors"].matrices(n);
    for (std::size_t k = 0; k <= n; ++k) {
        Slot<1>& s = rod.slot[k];
        s.position = broadcast<1>(position[k % nodes]);
        s.velocity = broadcast<1>(velocity[k % nodes]);
        if (k < n) {
            s.director = broadcast<1>(quaternion(director[k]));
            s.spin = broadcast<1>(omega[k]);
        } else {
            s.director = broadcast<1>(no_turn);
            s.spin = {};
        }
    }
    return rod;
}

RodProgram::RodProgram(Rod& rod, const Stepping& stepping, const std::vector<Entry>& constraints,
                       const std::vector<Entry>& dampers)
    : rod_(rod), load_(rod.slot.size()) {
    const RodGroup& group = rod.group;
    std::vector<KickConstants> kicks;
    for (const double share : stepping.scheme.kicks) kicks.emplace_back(group, DampingRates{}, share * stepping.dt);
    for (const Entry& e : constraints)
        constraints_.push_back(make_constraint(e, rod.slot, rod.nodes(), rod.elements()));

    move_.push_back(std::make_unique<PublishedDrift>(stepping.scheme.stages.size()));
    for (const auto& c : constraints_) move_.push_back(std::make_unique<ValuesPass>(c));
    if (group.closed()) move_.push_back(std::make_unique<ClosePositionPass>());
    move_.push_back(std::make_unique<ElasticaPass<1>>(ends_of(group)));

    if (group.closed()) kick_.push_back(std::make_unique<FoldRingPass<1>>());
    kick_.push_back(std::make_unique<KickPass<KickKind::elastica, 1>>(std::move(kicks)));
    for (const auto& c : constraints_) kick_.push_back(std::make_unique<RatesPass>(c));
    if (group.closed()) kick_.push_back(std::make_unique<CloseVelocityPass>());
    for (const Entry& e : dampers) kick_.push_back(make_damper(e, group));
    for (TilePasses<1>* program : {&move_, &kick_})
        for (const auto& pass : *program) pass->bind(rod.tile());
}

void RodProgram::prepare(std::span<const Step> steps) {
    for (TilePasses<1>* program : {&move_, &kick_})
        for (const auto& pass : *program) pass->prepare(steps);
}

void RodProgram::move(const Step& step) const {
    for (const auto& pass : move_) pass->run(rod_.tile(), rod_.internal.data(), step);
}

void RodProgram::kick(const Step& step) const {
    for (std::size_t k = 0; k < load_.size(); ++k) {
        const SlotLoad<1>&in = rod_.internal[k], &out = rod_.external[k];
        load_[k] = {in.force + out.force, in.couple + out.couple, in.dilatation};
    }
    for (const auto& pass : kick_) pass->run(rod_.tile(), load_.data(), step);
}

std::vector<Slot<1>> RodProgram::closed_state(double lag, double time) const {
    std::vector<Slot<1>> state = rod_.slot;
    drift<PublishedTop>(tile_of(rod_.group, state), lag);
    for (const auto& constraint : constraints_) constraint->values(state.data(), time);
    if (rod_.group.closed()) state.back().position = state.front().position;
    return state;
}

} // namespace skein::replay
