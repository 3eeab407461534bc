#include "coupling/interaction.hpp"

#include "parallel/exact_sum.hpp"

#include <algorithm>
#include <limits>

namespace skein {

Interactions make_interactions(const InteractionParts& parts) {
    Interactions all;
    for (const auto& physics : parts.plan.physics)
        if (const auto* one = dynamic_cast<const StartsInteraction*>(physics.get()))
            if (auto interaction = one->start(parts)) all.push_back(std::move(interaction));
    return all;
}

namespace {

/// Finds new partners, and with them the ghosts.
void rebuild(const Interactions& all, Neighbourhood& neighbourhood, const std::function<void()>& at_rebuild) {
    double reach = 0;
    for (const auto& one : all) reach = std::max(reach, one->begin_rebuild());
    if (at_rebuild) at_rebuild();
    const Exposure& near = neighbourhood.widen(reach);
    std::vector<std::uint8_t> wanted(near.slots(), 0);
    for (const auto& one : all) one->find_partners(near, wanted);
    const std::vector<std::uint32_t> slot = neighbourhood.narrow(wanted);
    for (const auto& one : all) one->settle(slot);
}

} // namespace

void add_loads(const Interactions& all, Neighbourhood& neighbourhood, const Step& step, Timers& timers,
               const std::function<void()>& at_rebuild) {
    const auto for_each = [&](auto&& work) {
        const auto timing = timers.time(Phase::contacts);
        for (const auto& one : all) work(*one);
    };
    bool hold = true;
    const auto add_own = [&](Interaction& one) { one.add_own(step); };
    for_each([&](Interaction& one) { hold = hold && one.holds(); });
    {
        const auto timing = timers.time(Phase::exchange);
        neighbourhood.publish(hold);
    }
    if (hold) for_each(add_own);
    {
        const auto timing = timers.time(Phase::exchange);
        hold = neighbourhood.arrive() && hold;
    }
    if (!hold) { // on some rank
        {
            const auto timing = timers.time(Phase::search);
            rebuild(all, neighbourhood, at_rebuild);
        }
        for_each(add_own);
    }
    for_each([&](Interaction& one) { one.add_shared(step); });
}

double way_in_a_part(const Interactions& all) {
    double least = HUGE_VAL;
    for (const auto& one : all) least = std::min(least, one->way_in_a_part());
    return least;
}

double longest_part(const Interactions& all) {
    double longest = HUGE_VAL;
    for (const auto& one : all) longest = std::min(longest, one->longest_part());
    return longest;
}

std::vector<double> work_of(const Interactions& all, std::span<const LocalRod> own) {
    std::vector<double> work(own.size(), 0.0);
    for (const auto& one : all) one->add_work(own, work);
    return work;
}

bool finished(const Interactions& all) {
    bool any = false;
    for (const auto& one : all) {
        const auto ending = one->ending();
        if (ending == Interaction::Ending::not_yet) return false;
        any |= ending == Interaction::Ending::now;
    }
    return any;
}

bool fulfilled(const Interactions& all) {
    return std::all_of(all.begin(), all.end(), [](const auto& one) { return one->fulfilled(); });
}

namespace {

/// The first answer that is not empty.
template <class Answer> Answer first_of(const Interactions& all, Answer (Interaction::*of)() const) {
    for (const auto& one : all)
        if (Answer answer = ((*one).*of)(); !answer.empty()) return answer;
    return {};
}

} // namespace

std::string invalid(const Interactions& all) { return first_of(all, &Interaction::invalid); }
std::string cause(const Interactions& all) { return first_of(all, &Interaction::cause); }
std::vector<std::string> remedies(const Interactions& all) { return first_of(all, &Interaction::remedies); }
std::string likely_cause(const Interactions& all) { return first_of(all, &Interaction::likely_cause); }
std::string tightest_pair(const Interactions& all) { return first_of(all, &Interaction::tightest_pair); }
std::string fastest_body(const Interactions& all) { return first_of(all, &Interaction::fastest_body); }
std::string advice(const Interactions& all) { return first_of(all, &Interaction::advice); }

double step_limit(const Interactions& all) {
    double least = HUGE_VAL;
    for (const auto& one : all) least = std::min(least, one->step_limit());
    return least;
}

namespace {

/// The first part of its kind that one of them has; null: none has.
template <class Part> Part* first_part(const Interactions& all, Part* (Interaction::*of)()) {
    for (const auto& one : all)
        if (Part* part = ((*one).*of)()) return part;
    return nullptr;
}

} // namespace

StepControl* step_control(const Interactions& all) { return first_part(all, &Interaction::step_control); }
PaceControl* pace_control(const Interactions& all) { return first_part(all, &Interaction::pace_control); }
Companion* companion(const Interactions& all) { return first_part(all, &Interaction::companion); }

double fastest(const Interactions& all) {
    double most = 0;
    for (const auto& one : all) most = std::max(most, one->fastest());
    return most;
}
bool couples(const Interactions& all) {
    return std::any_of(all.begin(), all.end(), [](const auto& one) { return one->couples(); });
}

bool ends_every_step(const Interactions& all) {
    return std::any_of(all.begin(), all.end(), [](const auto& one) { return one->ends_every_step(); });
}

std::int64_t next_coupling(const Interactions& all, std::int64_t done) {
    std::int64_t next = Every::never;
    for (const auto& one : all) next = std::min(next, one->next_coupling(done));
    return next;
}

std::int64_t meeting_after(const Interactions& all, std::int64_t done) {
    std::int64_t next = Every::never;
    for (const auto& one : all) next = std::min(next, one->meeting_after(done));
    return next == Every::never ? done + 1 : next;
}

Touch strongest_touch(const Communicator& comm, const Interactions& all, std::int64_t gid) {
    Touch most;
    for (const auto& one : all)
        if (const Touch touch = one->strongest_touch(gid); !touch.text.empty() && !(touch.force < most.force))
            most = touch;
    const double strongest = comm.max(std::isnan(most.force) ? HUGE_VAL : most.force);
    const bool here = !most.text.empty() && !(most.force < strongest);
    return {strongest, comm.first_text(here ? most.text : std::string())};
}

std::vector<std::string> names_of_figures(const Interactions& all) {
    std::vector<std::string> names;
    for (const auto& one : all)
        for (Figure& figure : one->figures({})) names.push_back(std::move(figure.name));
    return names;
}

std::vector<double> values_of_figures(const Communicator& comm, const Interactions& all, const Sample& sample) {
    std::vector<Figure> figures;
    std::vector<std::vector<double>> terms;
    std::vector<BinnedTotal> own_totals;
    for (const auto& one : all) one->sum_figures();
    for (const auto& one : all)
        for (Figure& figure : one->figures(sample)) {
            if (figure.of == Figure::Of::sum) terms.push_back(std::move(figure.terms));
            if (figure.of == Figure::Of::total) own_totals.push_back(*figure.total);
            figures.push_back(std::move(figure));
        }
    if (figures.empty()) return {};
    const std::vector<double> sums = exact_sums(comm, terms);
    const std::vector<BinnedTotal> all_totals = own_totals.empty() ? own_totals : totals(comm, own_totals);
    std::size_t next_sum = 0, next_total = 0;
    std::vector<double> values;
    for (const Figure& figure : figures) switch (figure.of) {
        case Figure::Of::sum:
            values.push_back(figure.times * sums[next_sum++] / figure.over);
            break;
        case Figure::Of::total:
            values.push_back(all_totals[next_total++].value());
            break;
        case Figure::Of::largest:
            values.push_back(comm.max(figure.terms.front()));
            break;
        case Figure::Of::same:
            values.push_back(figure.terms.front());
            break;
        }
    for (std::size_t i = 0; sample.solved && i < figures.size(); ++i)
        if (figures[i].of_steps) values[i] = std::numeric_limits<double>::quiet_NaN();
    return values;
}

bool has_new_overlaps(const Interactions& all) {
    for (const auto& one : all)
        for (const OverlapWatch& watch : one->overlaps())
            if (watch.is_new()) return true;
    return false;
}

std::string new_overlaps(const Communicator& comm, const Interactions& all) {
    std::string text;
    for (const auto& one : all)
        for (OverlapWatch& watch : one->overlaps()) {
            const std::string warning = watch.largest(comm).warning();
            if (watch.reported || warning.empty()) continue;
            watch.reported = true;
            text += (text.empty() ? "" : "\n  ") + warning;
        }
    return text;
}

std::vector<LargestOverlap> largest_overlaps(const Communicator& comm, const Interactions& all) {
    std::vector<LargestOverlap> largest;
    for (const auto& one : all)
        for (const OverlapWatch& watch : one->overlaps()) largest.push_back(watch.largest(comm));
    return largest;
}

std::uint64_t digest_of(const Interactions& all) {
    std::uint64_t sum = 0;
    for (const auto& one : all) sum += one->digest();
    return sum;
}

std::vector<std::string> saved_names(const Interactions& all) {
    std::vector<std::string> names;
    for (const auto& one : all) names.push_back(one->saved_name());
    return names;
}

std::vector<SavedNumbers> saved(const Interactions& all) {
    std::vector<SavedNumbers> numbers;
    for (const auto& one : all) numbers.push_back(one->saved());
    return numbers;
}

void restore(const Interactions& all, std::span<const SavedNumbers> kept) {
    for (const auto& one : all)
        for (const SavedNumbers& k : kept)
            if (k.name == one->saved_name()) one->restore(k);
}

} // namespace skein
