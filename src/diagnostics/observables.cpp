#include "diagnostics/observables.hpp"

#include "mechanics/rod_copies.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <numeric>

namespace skein {

namespace {

/// Computes optional figures from copies of rods.
void add_extra(std::vector<ExtraFigures>& extra, std::span<const RodGroup> groups, const Rods& rods, double lag,
               const ObservableSets& sets) {
    const auto local = rods.local();
    extra.resize(local.size());
    std::vector<std::size_t> all(local.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    rods.read(all, Copy::synchronised, lag, [&](int, std::size_t i, const RodCopy& copy) {
        with_rod(nth(groups, local[i].group), local[i].index,
                 [&](const RodGroup& own) { extra[i] = extra_figures(own, copy.state, sets); });
    });
}

} // namespace

RodEnergy rod_energy(const RodGroup& group, std::span<const Slot<1>> state, double time, std::int64_t index) {
    using F = RodFigures;
    const F f = figures_of(group, state, time, index);
    return {f.sum[F::translation], f.sum[F::rotation], f.sum[F::stretch],
            f.sum[F::shear],       f.sum[F::bend],     f.sum[F::twist]};
}

std::vector<std::string> observable_names(const ObservableSets& sets) {
    std::vector<std::string> names = {"kinetic_translation[J]",
                                      "kinetic_rotation[J]",
                                      "elastic_stretch[J]",
                                      "elastic_shear[J]",
                                      "elastic_bend[J]",
                                      "elastic_twist[J]",
                                      "momentum_x[kg m/s]",
                                      "momentum_y[kg m/s]",
                                      "momentum_z[kg m/s]",
                                      "centre_x[m]",
                                      "centre_y[m]",
                                      "centre_z[m]",
                                      "max_speed[m/s]",
                                      "max_axial_strain[-]",
                                      "max_turn_per_cell[rad]",
                                      "max_director_defect[-]"};
    for (std::string& name : extra_names(sets)) names.push_back(std::move(name));
    return names;
}

double observed_energy(std::span<const double> observed) {
    const auto energies = observed.first(observed_energies);
    return std::accumulate(energies.begin(), energies.end(), 0.0);
}

std::vector<double> observe(const Communicator& comm, const Threads& threads, std::span<const RodGroup> groups,
                            const Rods& rods, double time, double lag, const ObservableSets& sets) {
    using F = RodFigures;
    UnsetArray<RodFigures> all(rods.local().size());
    rods.figures(time, lag, {all.data(), all.size()});
    std::vector<ExtraFigures> extra;
    if (sets.any()) add_extra(extra, groups, rods, lag, sets);

    std::vector<double> values = exact_sums(
        comm, threads, {all.size() > 0 ? all[0].sum : nullptr, all.size(), F::sums, sizeof(F) / sizeof(double)});
    std::array<double, F::extremes> extreme{};
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t x = 0; x < F::extremes; ++x) extreme[x] = std::max(extreme[x], all[i].extreme[x]);
    comm.max(extreme);
    for (int axis = 0; axis < 3; ++axis) values[F::mass_x + axis] /= values[F::mass];
    values.resize(F::mass);
    values.insert(values.end(), extreme.begin(), extreme.end());
    if (sets.any())
        for (const double value : extra_values(comm, threads, extra, sets)) values.push_back(value);
    return values;
}

} // namespace skein
