#include "physics/implicit/bed_interaction.hpp"

#include "rod/body_shape.hpp"
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

double BedInteraction::fastest() const { return std::max(known_ ? *known_ : of_states(), of_walls()); }

double BedInteraction::of_states() const {
    double most = 0;
    std::vector<Slot<1>> state;
    const auto local = rods_->local();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const RodGroup& group = nth(groups_, local[i].group);
        state.resize(to_index(group.slots()));
        rods_->export_rod(i, state);
        for (const Slot<1>& s : state) {
            const double turning = group.strained() ? 0 : group.body()->reach * norm(lane(s.spin, 0));
            most = std::max(most, norm(lane(s.velocity, 0)) + turning);
        }
    }
    return most;
}

double BedInteraction::of_walls() const {
    double most = 0;
    for (std::size_t w = 0; walls_ && w < walls_->count(); ++w) {
        const Wall& wall = walls_->wall[w];
        const Vec3d& now = wall.servo.drives() ? walls_->state[w].velocity : wall.velocity;
        if (wall.stands) most = std::max(most, norm(now));
    }
    return most;
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
