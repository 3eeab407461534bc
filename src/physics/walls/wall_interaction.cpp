#include "physics/walls/wall_interaction.hpp"

#include "contact/contact_spec.hpp"
#include "parallel/exact_sum.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

WallInteraction::WallInteraction(const InteractionParts& parts)
    : comm_(parts.comm), rods_(&parts.rods), walls_(parts.around.walls), wall_contacts_(parts.around.wall_contacts),
      work_(walls_->count(), 0) {
    for (std::size_t w = 0; w < walls_->count(); ++w) {
        const Wall& wall = walls_->wall[w];
        overlaps_.push_back({.of = wall.name,
                             .allowed = ContactSpec{}.overlap,
                             .normal = wall.law.normal,
                             .stiffness = wall.law.restitution > 0 ? 0 : wall.law.stiffness});
        if (wall.servo.drives()) driven_.push_back({static_cast<int>(w), walls_->find(wall.servo.watch), Servo(wall)});
    }
    pressing_.resize(2 * driven_.size());
}

void WallInteraction::rebind(const InteractionParts& parts) {
    rods_ = &parts.rods;
    walls_ = parts.around.walls;
    wall_contacts_ = parts.around.wall_contacts;
}

void WallInteraction::end_step(const Step& step, Timers& timers) {
    if (driven_.empty()) return;
    const auto timing = timers.time(Phase::exchange);
    for (std::size_t i = 0; i < driven_.size(); ++i) {
        const DrivenWall& d = driven_[i];
        std::vector<double>&on_watched = pressing_[2 * i], &power = pressing_[2 * i + 1];
        on_watched.clear();
        power.clear();
        for (const auto& contacts : wall_contacts_) {
            if (!contacts) continue;
            contacts->append_normal(d.watched, on_watched);
            if (d.servo.direction() != 0) contacts->append_force(d.wall, nth(walls_->state, d.wall).velocity, power);
        }
    }
    const std::vector<double> sums = exact_sums(comm_, pressing_);
    for (std::size_t i = 0; i < driven_.size(); ++i) {
        DrivenWall& d = driven_[i];
        const auto w = static_cast<std::size_t>(d.wall);
        work_[w] -= step.kick * sums[2 * i + 1];
        d.servo.step(sums[2 * i], sums[2 * i + 1] != 0, step.kick);
        walls_->state[w] = d.servo.wall_state();
    }
}

void WallInteraction::watch(const Step& step) {
    for (std::size_t w = 0; w < overlaps_.size(); ++w) {
        if (step.time < walls_->wall[w].law.soft_until) continue;
        for (const auto& contacts : wall_contacts_)
            if (contacts) overlaps_[w].take(contacts->max_overlap(static_cast<int>(w)), step.index);
    }
}

Interaction::Ending WallInteraction::ending() const {
    Ending ending = Ending::never;
    for (const DrivenWall& d : driven_) {
        if (!wall(d).servo.ends_run || !wall(d).stands) continue;
        if (!d.servo.finished()) return Ending::not_yet;
        ending = Ending::now;
    }
    return ending;
}

std::string WallInteraction::invalid() const {
    constexpr double through = 10; // diameters
    for (std::size_t w = 0; w < walls_->count(); ++w) {
        if (walls_->wall[w].law.soft_until > 0) continue; // may begin behind it
        for (const auto& contacts : wall_contacts_) {
            const double overlap = contacts ? contacts->max_overlap(static_cast<int>(w)) : 0;
            if (overlap > through)
                return fmt::format("one of '{}' has gone through the wall '{}': it is {:.3g} of its diameter behind it",
                                   contacts->group(), walls_->wall[w].name, overlap);
        }
    }
    return {};
}

Touch WallInteraction::strongest_touch(std::int64_t gid) const {
    Touch most;
    const auto local = rods_->local();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const WallContacts* contacts = contacts_of(i);
        if (local[i].gid != gid || !contacts) continue;
        for (std::size_t w = 0; w < walls_->count(); ++w) {
            const WallFigures a = contacts->figures(rods_->place(i), static_cast<int>(w));
            if (a.touching == 0 || norm(a.force) < most.force) continue;
            most = {norm(a.force), fmt::format("it presses the wall '{}' with {:.3g} N, {:.3g} of the diameter deep",
                                               walls_->wall[w].name, norm(a.force), a.max_overlap)};
        }
    }
    return most;
}

std::vector<Figure> WallInteraction::figures(const Sample&) const {
    using Of = Figure::Of;
    const std::size_t count = walls_->count();
    std::vector<std::vector<double>> normal(count);
    Figure touching{"wall_contacts[-]", Of::sum, {}}, overlap{"wall_overlap[-]", Of::largest, {0}},
        elastic_energy{"wall_energy[J]", Of::sum, {}}, friction_work{"wall_friction_work[J]", Of::sum, {}},
        viscous_work{"wall_viscous_work[J]", Of::sum, {}};
    const auto local = rods_->local();
    for (std::size_t i = 0; i < local.size(); ++i)
        for (std::size_t w = 0; w < count; ++w) {
            const WallContacts* contacts = contacts_of(i);
            if (!contacts) continue;
            const WallFigures a = contacts->figures(rods_->place(i), static_cast<int>(w));
            normal[w].push_back(a.normal);
            touching.terms.push_back(a.touching);
            elastic_energy.terms.push_back(a.elastic_energy);
            friction_work.terms.push_back(a.friction_work);
            viscous_work.terms.push_back(a.viscous_work);
            overlap.terms.front() = std::max(overlap.terms.front(), a.max_overlap);
        }
    friction_work.of_steps = viscous_work.of_steps = true;
    std::vector<Figure> figures;
    for (std::size_t w = 0; w < count; ++w)
        figures.push_back({walls_->wall[w].name + "_force[N]", Of::sum, std::move(normal[w])});
    for (const DrivenWall& d : driven_) {
        const std::string& name = wall(d).name;
        figures.push_back({name + "_height[m]", Of::same, {d.servo.height()}});
        figures.push_back({name + "_work[J]", Of::same, {nth(work_, d.wall)}});
        figures.back().of_steps = true;
        figures.push_back({name + "_turns[-]", Of::same, {static_cast<double>(d.servo.turns())}});
    }
    for (Figure* figure : {&touching, &overlap, &elastic_energy, &friction_work, &viscous_work})
        figures.push_back(std::move(*figure));
    return figures;
}

SavedNumbers WallInteraction::saved() const {
    std::vector<double> numbers;
    for (const DrivenWall& d : driven_) {
        const std::vector<double> state = d.servo.state();
        numbers.push_back(nth(work_, d.wall));
        numbers.push_back(static_cast<double>(state.size()));
        numbers.insert(numbers.end(), state.begin(), state.end());
    }
    return {.name = saved_name(), .numbers = std::move(numbers)};
}

void WallInteraction::restore(const SavedNumbers& kept) {
    const std::span numbers(kept.numbers);
    std::size_t at = 0;
    for (DrivenWall& d : driven_) {
        nth(work_, d.wall) = numbers[at];
        const auto count = static_cast<std::size_t>(numbers[at + 1]);
        d.servo.restore(numbers.subspan(at + 2, count));
        at += 2 + count;
        nth(walls_->state, d.wall) = d.servo.wall_state();
    }
}

std::vector<double> WallInteraction::memory(std::size_t i) const {
    const WallContacts* contacts = contacts_of(i);
    return contacts ? contacts->memory(rods_->place(i)) : std::vector<double>{};
}

void WallInteraction::set_memory(std::size_t i, std::span<const double> numbers) {
    if (WallContacts* contacts = contacts_of(i)) contacts->set_memory(rods_->place(i), numbers);
}

WallInteraction* walls_of(const Interactions& all) {
    for (const auto& one : all)
        if (auto* walls = dynamic_cast<WallInteraction*>(one.get())) return walls;
    return nullptr;
}

} // namespace skein
