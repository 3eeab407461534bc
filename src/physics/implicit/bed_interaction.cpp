#include "physics/implicit/bed_interaction.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <numeric>

namespace skein {

BedInteraction::BedInteraction(const InteractionParts& parts, double allowed)
    : comm_(parts.comm), rods_(&parts.rods), beds_(parts.around.beds), control_(allowed) {
    for (const RodGroup& group : parts.groups)
        mass_ +=
            static_cast<double>(group.count()) * std::accumulate(group.node_mass.begin(), group.node_mass.end(), 0.0);
}

double BedInteraction::now() const {
    double most = 0;
    for (const auto& bed : beds_) most = std::max(most, bed->fastest());
    return most;
}

double BedInteraction::fastest() const {
    if (known_) return *known_;
    std::vector<RodFigures> figures(rods_->local().size());
    rods_->figures(0, 0, figures);
    double most = 0;
    for (const RodFigures& of_rod : figures) most = std::max(most, of_rod.extreme[RodFigures::speed]);
    return most;
}

std::vector<Figure> BedInteraction::figures(const Sample&) const {
    using Of = Figure::Of;
    Figure loss{"numerical_loss[J]", Of::sum, {}}, added{"added_mass[-]", Of::sum, {}};
    added.over = mass_;
    const auto local = rods_->local();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const BedFigures& bed = *nth(beds_, local[i].group);
        loss.terms.push_back(bed.loss(rods_->place(i)));
        added.terms.push_back(bed.added_mass(rods_->place(i)));
    }
    loss.of_steps = added.of_steps = true;
    return {std::move(loss), std::move(added)};
}

SavedNumbers BedInteraction::saved() const { return {.name = saved_name(), .numbers = {comm_.max(fastest())}}; }

/// Every rank goes on with the largest speed of all, which is what steps are cut by.
void BedInteraction::restore(const SavedNumbers& saved) { known_ = saved.numbers.at(0); }

} // namespace skein
