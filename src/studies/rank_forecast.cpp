#include "studies/rank_forecast.hpp"

#include "core/memory.hpp"
#include "coupling/interaction.hpp"
#include "partition/partition.hpp"
#include "physics/contact/contact_plan.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/time/clock.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>

namespace skein {

namespace {

constexpr double candidate_bytes = 8 + 8 + 2 + 2 * sizeof(ContactMemory<double>) +
                                   50; // of a pair, its neighbours, status, memory, and half a deferred load
constexpr int most_listed = 16;        // ranks of which each has a line

std::vector<LocalRod> all_rods(std::span<const RodGroup> groups) {
    std::vector<LocalRod> rods;
    for (const RodGroup& group : groups)
        for (std::int64_t i = 0; i < group.count(); ++i) rods.push_back({group.first_gid() + i, group.id(), i});
    return rods;
}

/// A scene on this core alone: first its candidates as a run finds them in its first step, then steps that are timed.
class ShareTrial {
public:
    ShareTrial(const Plan& plan, std::span<const RodGroup> groups)
        : plan_(plan), comm_(Communicator::alone()), threads_(1), clock_(plan.dt, 0, plan.integrator) {
        rods_ = make_rods(plan, groups, all_rods(groups), threads_, around_);
        if (around_.exposure) neighbourhood_ = std::make_unique<Neighbourhood>(comm_, threads_, around_.exposure);
        interactions_ = make_interactions({comm_, threads_, plan, groups, *rods_, around_});
    }

    const Exposure& exposure() const { return *around_.exposure; }

    /// Pairs near enough for the first list, by slots of the scene; none where rods do not feel each other.
    Candidates first_candidates(std::span<const RodGroup> groups) {
        if (!around_.exposure) return {};
        rods_->drift(clock_.next(1, 1).front());
        exposed_ = true;
        const ContactPlan& contact = *plan_.find<ContactPlan>();
        const auto contacts = kernels(plan_.machine.lanes).make_contacts(contact.scene(groups), threads_);
        around_.exposure->set_paces(threads_, around_.exposure->largest_speed(threads_));
        std::vector<std::uint8_t> wanted(around_.exposure->slots());
        contacts->search(*around_.exposure, wanted);
        return contacts->found();
    }

    /// Goes on from first_candidates(). Seconds of a step in passes and in interactions; the first step, which builds
    /// the first list and meets memory that no one has touched, is left out.
    std::pair<double, double> time(double seconds) {
        Timers timers;
        advance(timers, std::exchange(exposed_, false));
        timers = {};
        std::int64_t steps = 0;
        const double began = wall_seconds();
        while (clock_.done() < plan_.steps && (steps < 4 || wall_seconds() < began + seconds))
            steps += advance(timers, false);
        const double each = 1 / static_cast<double>(std::max<std::int64_t>(1, steps));
        return {
            each * timers.seconds(Phase::rods),
            each * (timers.seconds(Phase::contacts) + timers.seconds(Phase::search) + timers.seconds(Phase::exchange))};
    }

private:
    /// Steps that it makes: one of bodies that feel each other, else many. `exposed`: the first half of it is done.
    std::int64_t advance(Timers& timers, bool exposed) {
        const bool coupled = plan_.coupling() != PhysicsPlan::Coupling::none;
        const auto batch = clock_.next(plan_.steps, coupled ? 1 : Clock::largest_batch);
        const Step& step = batch.front();
        const auto timed = [&](auto&& work) {
            const auto timing = timers.time(Phase::rods);
            work();
        };
        if (!coupled) {
            timed([&] { rods_->advance(batch, false); });
        } else {
            if (!exposed) timed([&] { rods_->drift(step); });
            if (neighbourhood_) add_loads(interactions_, *neighbourhood_, step, timers);
            timed([&] { rods_->kick(step, false); });
            for (const auto& one : interactions_) one->end_step(step, timers);
        }
        clock_.advance(batch);
        return static_cast<std::int64_t>(batch.size());
    }

    const Plan& plan_;
    const Communicator comm_;
    const Threads threads_;
    Surroundings around_;
    std::unique_ptr<Rods> rods_;
    Clock clock_;
    std::unique_ptr<Neighbourhood> neighbourhood_;
    Interactions interactions_;
    bool exposed_ = false; ///< the first half of the next step is done
};

/// Ghosts of every rank, counted as Neighbourhood::narrow and set_up_messages make them.
void count_ghosts(const Exposure& bodies, const Candidates& pairs, std::span<const int> owner,
                  std::vector<RankShare>& share) {
    const auto owner_of = [&](std::uint32_t slot) { return nth(owner, bodies.at(slot).gid); };
    std::vector<std::vector<std::uint32_t>> needs(share.size()); // slots
    for (std::uint32_t a = 0; a + 1 < pairs.first.size(); ++a)
        for (std::uint32_t i = pairs.first[a]; i < pairs.first[a + 1]; ++i) {
            const std::uint32_t b = pairs.partner[i];
            const auto of_a = static_cast<std::size_t>(owner_of(a)), of_b = static_cast<std::size_t>(owner_of(b));
            ++share[of_a].pairs;
            if (of_a == of_b) continue;
            ++share[of_b].pairs;
            bodies.with_neighbours(b, [&](std::uint32_t slot) { needs[of_a].push_back(slot); });
            bodies.with_neighbours(a, [&](std::uint32_t slot) { needs[of_b].push_back(slot); });
        }
    std::vector<std::set<int>> neighbours(share.size()), receivers(share.size());
    for (std::size_t r = 0; r < share.size(); ++r) {
        std::sort(needs[r].begin(), needs[r].end());
        needs[r].erase(std::unique(needs[r].begin(), needs[r].end()), needs[r].end());
        std::int64_t last_body = -1;
        for (std::size_t i = 0; i < needs[r].size(); ++i) {
            const std::uint32_t slot = needs[r][i];
            const std::int64_t body = bodies.at(slot).gid;
            const auto from = static_cast<std::size_t>(owner_of(slot));
            const bool goes_on =
                i + 1 < needs[r].size() && needs[r][i + 1] == slot + 1 && bodies.at(slot + 1).gid == body;
            const std::int64_t slots = goes_on ? 1 : 2; // the last one with the node behind it
            share[r].ghost_rods += body != last_body;
            ++share[r].ghost_elements;
            share[r].ghost_slots += slots;
            share[from].bytes += slots * static_cast<std::int64_t>(Exposure::sent_numbers_per_slot * sizeof(double));
            receivers[from].insert(static_cast<int>(r));
            neighbours[r].insert(static_cast<int>(from));
            neighbours[from].insert(static_cast<int>(r));
            last_body = body;
        }
    }
    for (std::size_t r = 0; r < share.size(); ++r) {
        share[r].neighbours = static_cast<std::int64_t>(neighbours[r].size());
        share[r].messages = static_cast<std::int64_t>(receivers[r].size());
    }
}

/// Time of messages of ghosts in a step, s.
double exchange_time(const RankShare& share, const MachineFile& machine, int threads) {
    if (share.neighbours == 0) return 0;
    const MachineFile::Network& network = machine.network;
    const auto received =
        static_cast<double>(share.ghost_slots * static_cast<std::int64_t>(Exposure::sent_numbers_per_slot) * 8);
    const auto sent = static_cast<double>(share.bytes);
    const double copiers = std::clamp(static_cast<double>(share.ghost_rods) / Neighbourhood::runs_of_task, 1.0,
                                      static_cast<double>(threads));
    return network.latency + network.overhead * static_cast<double>(std::max<std::int64_t>(0, share.neighbours - 1)) +
           std::max(sent, received) / network.bandwidth_all + (sent + received) / (copiers * machine.machine.copy);
}

} // namespace

RankForecast forecast_ranks(const Plan& plan, std::span<const RodGroup> groups, int ranks, const MachineFile& machine,
                            double seconds) {
    if (plan.state_bytes > free_memory())
        throw InputError(fmt::format(
            "shares of ranks are worked out with all rods at hand: {:.3g} GB, of which {:.3g} GB are free; the "
            "same scene with fewer rods tells as much of a rank's share",
            1e-9 * plan.state_bytes, 1e-9 * free_memory()));
    RankForecast forecast;
    const MachineFile::Network& network = machine.network;
    forecast.threads = std::min(plan.machine.threads, plan.machine.cores);
    forecast.rank.resize(static_cast<std::size_t>(ranks));
    std::vector<RankShare>& share = forecast.rank;
    const std::vector<int> owner = owners(groups, ranks);
    const SceneSlots scene(groups);
    for (std::int64_t gid = 0; gid < scene.bodies(); ++gid) {
        RankShare& own = nth(share, nth(owner, gid));
        ++own.rods;
        own.elements += nth(groups, scene.group_of(gid)).elements();
    }
    ShareTrial trial(plan, groups);
    std::int64_t pairs = 0;
    if (plan.has<ContactPlan>()) {
        const Candidates candidates = trial.first_candidates(groups);
        pairs = static_cast<std::int64_t>(candidates.count());
        count_ghosts(trial.exposure(), candidates, owner, share);
    }
    std::tie(forecast.rods_s, forecast.pairs_s) = trial.time(seconds);
    const auto all = static_cast<double>(plan.elements);
    const double alone = (forecast.rods_s + forecast.pairs_s) / forecast.threads;
    const double measured_rounds = std::max(1.0, std::log2(static_cast<double>(machine.machine.ranks)));
    const double vote =
        ranks > 1 && plan.has<ContactPlan>()
            ? std::log2(ranks) * (network.allreduce > 0 ? network.allreduce / measured_rounds : 2 * network.latency)
            : 0;
    for (RankShare& s : share) {
        const double slots = static_cast<double>(s.elements + s.rods + s.ghost_slots);
        s.memory_bytes = static_cast<double>(s.elements) / all * plan.state_bytes;
        if (plan.has<ContactPlan>())
            s.memory_bytes +=
                static_cast<double>(s.ghost_slots) * (Exposure::bytes_per_slot + SlotLoads::bytes_per_slot) +
                static_cast<double>(s.pairs) * candidate_bytes + 3 * sizeof(double) * slots;
        const double own = static_cast<double>(s.elements) / all;
        const double work =
            (own * forecast.rods_s +
             (pairs > 0 ? static_cast<double>(s.pairs) / static_cast<double>(pairs) : own) * forecast.pairs_s) /
            forecast.threads;
        s.exchange_s = exchange_time(s, machine, forecast.threads) + vote;
        s.step_s = work + s.exchange_s; // messages may hide behind contacts of own rods; here none does
        forecast.step_s = std::max(forecast.step_s, s.step_s);
    }
    forecast.efficiency = alone / (static_cast<double>(ranks) * forecast.step_s);
    return forecast;
}

namespace {

template <class Of> std::string spread(const std::vector<RankShare>& share, Of&& of) {
    double least = HUGE_VAL, sum = 0, most = 0;
    for (const RankShare& s : share) {
        const auto x = static_cast<double>(of(s));
        least = std::min(least, x);
        sum += x;
        most = std::max(most, x);
    }
    return fmt::format("{:>12.6g}{:>12.6g}{:>12.6g}", least, sum / static_cast<double>(share.size()), most);
}

} // namespace

std::string to_text(const RankForecast& f) {
    std::string text = fmt::format("Ranks: {} of {} thread{} each; predicted step {:.4g} s, efficiency {:.3g}\n",
                                   f.rank.size(), f.threads, f.threads == 1 ? "" : "s", f.step_s, f.efficiency);
    fmt::format_to(std::back_inserter(text),
                   "  one step on one thread here: {:.4g} s in passes, {:.4g} s in contacts (measured)\n", f.rods_s,
                   f.pairs_s);
    fmt::format_to(std::back_inserter(text), "  {:<22}{:>12}{:>12}{:>12}\n", "a rank", "least", "mean", "most");
    const auto line = [&](const char* label, auto of) {
        fmt::format_to(std::back_inserter(text), "  {:<22}{}\n", label, spread(f.rank, of));
    };
    line("rods", [](const RankShare& s) { return s.rods; });
    line("elements", [](const RankShare& s) { return s.elements; });
    line("candidates", [](const RankShare& s) { return s.pairs; });
    line("ghost rods", [](const RankShare& s) { return s.ghost_rods; });
    line("ghost elements", [](const RankShare& s) { return s.ghost_elements; });
    line("neighbours", [](const RankShare& s) { return s.neighbours; });
    line("messages a step", [](const RankShare& s) { return s.messages; });
    line("bytes a step", [](const RankShare& s) { return s.bytes; });
    line("memory [MB]", [](const RankShare& s) { return 1e-6 * s.memory_bytes; });
    line("step [us]", [](const RankShare& s) { return 1e6 * s.step_s; });
    line("  exchange [us]", [](const RankShare& s) { return 1e6 * s.exchange_s; });
    if (f.rank.size() > most_listed) return text;
    fmt::format_to(std::back_inserter(text), "  {:>5}{:>10}{:>12}{:>10}{:>10}{:>12}{:>10}{:>10}{:>12}\n", "rank",
                   "rods", "elements", "ghosts", "elements", "neighbours", "messages", "bytes", "step [us]");
    for (std::size_t r = 0; r < f.rank.size(); ++r) {
        const RankShare& s = f.rank[r];
        fmt::format_to(std::back_inserter(text), "  {:>5}{:>10}{:>12}{:>10}{:>10}{:>12}{:>10}{:>10}{:>12.4g}\n", r,
                       s.rods, s.elements, s.ghost_rods, s.ghost_elements, s.neighbours, s.messages, s.bytes,
                       1e6 * s.step_s);
    }
    return text;
}

std::string to_json(const Plan& plan, const RankForecast& f) {
    nlohmann::ordered_json ranks = nlohmann::ordered_json::array();
    for (const RankShare& s : f.rank)
        ranks.push_back({{"rods", s.rods},
                         {"elements", s.elements},
                         {"candidates", s.pairs},
                         {"ghost_rods", s.ghost_rods},
                         {"ghost_elements", s.ghost_elements},
                         {"neighbours", s.neighbours},
                         {"messages", s.messages},
                         {"bytes", s.bytes},
                         {"memory_bytes", s.memory_bytes},
                         {"step_s", s.step_s},
                         {"exchange_s", s.exchange_s}});
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(to_json(plan));
    json["forecast"] = {{"threads", f.threads}, {"rods_s", f.rods_s},         {"pairs_s", f.pairs_s},
                        {"step_s", f.step_s},   {"efficiency", f.efficiency}, {"ranks", ranks}};
    return json.dump(2) + "\n";
}

} // namespace skein
