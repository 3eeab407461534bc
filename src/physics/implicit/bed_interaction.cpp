#include "physics/implicit/bed_interaction.hpp"

#include "physics/implicit/body_speeds.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <numeric>

namespace skein {

BedInteraction::BedInteraction(const InteractionParts& parts, double allowed)
    : comm_(parts.comm), groups_(parts.groups), rods_(&parts.rods), beds_(parts.around.beds),
      walls_(parts.around.walls), control_(allowed) {
    for (const RodGroup& group : parts.groups)
        for_each_kind(group, [&](const RodGroup& rod, double count) {
            mass_ += count * std::accumulate(rod.node_mass.begin(), rod.node_mass.end(), 0.0);
        });
}

double BedInteraction::now() const {
    double most = 0;
    for (const auto& bed : beds_)
        if (bed) most = std::max(most, bed->fastest());
    return most;
}

double BedInteraction::fastest() const {
    return std::max(known_ ? *known_ : fastest_node(*rods_, groups_).speed, fastest_wall(walls_.get()));
}

std::vector<Figure> BedInteraction::figures(const Sample&) const {
    using Of = Figure::Of;
    Figure loss{"numerical_loss[J]", Of::sum, {}}, added{"added_mass[-]", Of::sum, {}};
    added.over = mass_;
    const auto local = rods_->local();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const RodPlace place = rods_->place(i);
        const BedFigures& bed = *beds_[place.program];
        loss.terms.push_back(bed.loss(place));
        added.terms.push_back(bed.added_mass(place));
    }
    loss.of_steps = added.of_steps = true;
    return {std::move(loss), std::move(added)};
}

SavedNumbers BedInteraction::saved() const { return {.name = saved_name(), .numbers = {comm_.max(fastest())}}; }

/// Every rank goes on with the largest speed of all, which is what steps are cut by.
void BedInteraction::restore(const SavedNumbers& saved) { known_ = saved.numbers.at(0); }

} // namespace skein
