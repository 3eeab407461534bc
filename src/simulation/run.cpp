#include "skein/run.hpp"

#include "mechanics/rod_copies.hpp"
#include "parallel/communicator.hpp"
#include "partition/partition.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "simulation/simulation.hpp"
#include "simulation/stages.hpp"
#include "simulation/summary.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace skein {

struct Session::Mpi {
    Mpi(int& argc, char**& argv) {
        if (!MpiSession::running()) own.emplace(argc, argv);
    }
    std::optional<MpiSession> own;
};

Session::Session(int& argc, char**& argv) : mpi_(std::make_unique<Mpi>(argc, argv)) {}
Session::~Session() = default;
int Session::rank() const { return Communicator::world().rank(); }
int Session::ranks() const { return Communicator::world().size(); }

Scene::Scene(SceneSpec spec) : spec_(std::make_shared<const SceneSpec>(std::move(spec))) {}
Scene::Scene(const std::string& file, const std::vector<std::string>& overrides) : Scene(read_scene(file, overrides)) {}
Scene Scene::from_text(const std::string& toml, const std::vector<std::string>& overrides, const std::string& name) {
    return Scene(parse_scene(name, toml, overrides));
}

namespace {
/// Number of a rod among all bodies.
std::int64_t body_of(const World& world, const LocalRod& rod) {
    return nth(world.groups, rod.group).first_gid() + rod.index;
}
} // namespace

struct Run::Parts {
    Parts(const SceneSpec& given, const RunSettings& settings)
        : comm(Communicator::world()), machine(machine_of(comm, settings.threads, settings.lanes)),
          threads(machine.threads), writes(!settings.out.empty()), scene(driven(given)),
          simulation(made(scene, settings, make_groups(scene))) {
        const Rods& rods = simulation.world().rods();
        for (std::size_t i = 0; i < rods.local().size(); ++i)
            if (std::vector<double> memory = rods.memory(i); !memory.empty())
                start_memory[body_of(simulation.world(), rods.local()[i])] = std::move(memory);
    }

    /// The scene with tables that this run alone may lengthen.
    static SceneSpec driven(SceneSpec scene) {
        for (FormulaTable& table : scene.tables) table.driven = std::make_shared<FormulaTable>(table);
        return scene;
    }

    FormulaTable& driven_table(const std::string& name);
    Simulation made(const SceneSpec& scene, const RunSettings& settings, std::vector<RodGroup> groups) const {
        read_rods(comm, groups, &threads);
        Plan plan = make_plan(scene, groups, machine);
        return {comm,
                threads,
                scene,
                std::move(groups),
                std::move(plan),
                {.out = settings.out, .overwrite = settings.overwrite, .quiet = true}};
    }

    Communicator comm;
    Machine machine;
    Threads threads;
    bool writes;
    SceneSpec scene;
    Simulation simulation;
    bool tables_are_new = false;                              ///< formulas of places have not followed yet
    std::map<std::int64_t, std::vector<double>> start_memory; ///< of the passes of rods owned at the start, by body
};

Run::Run(const Scene& scene, const RunSettings& settings) : parts_(std::make_unique<Parts>(*scene.spec_, settings)) {}
Run::~Run() = default;
Run::Run(Run&&) noexcept = default;
Run& Run::operator=(Run&&) noexcept = default;

std::string Run::plan() const { return to_text(parts_->simulation.plan()); }
double Run::dt() const { return parts_->simulation.plan().dt; }
std::int64_t Run::steps() const { return parts_->simulation.plan().steps; }
std::int64_t Run::step() const { return parts_->simulation.world().clock.done(); }
bool Run::finished() const { return parts_->simulation.finished(); }
double Run::time() const { return parts_->simulation.world().clock.time(); }

void Run::advance(std::int64_t until) {
    if (std::exchange(parts_->tables_are_new, false)) parts_->simulation.world().rods().renew_formulas();
    parts_->simulation.advance(std::min(until, steps()));
    if (const std::string failure = parts_->simulation.failure(); !failure.empty()) throw NumericalError(failure);
}

int Run::run() {
    if (!parts_->writes)
        throw InputError("Run::run() writes results, and RunSettings::out names no directory for them");
    return static_cast<int>(parts_->simulation.run().code);
}

std::string Run::digest() const { return digest_text(parts_->simulation.world().digest()); }
std::vector<std::string> Run::observable_names() const { return parts_->simulation.observation().names(); }
std::vector<double> Run::observables() const { return parts_->simulation.observation().values(); }

std::string Run::contacts() const { return parts_->simulation.contacts(); }

FormulaTable& Run::Parts::driven_table(const std::string& name) {
    std::vector<std::string> names;
    for (const FormulaTable& table : scene.tables) {
        if (table.name == name) return *table.driven;
        names.push_back(table.name);
    }
    throw InputError(fmt::format("the scene has no table '{}'; there are: {}", name, fmt::join(names, ", ")));
}

Run::TablePoints Run::table(const std::string& name) const {
    const FormulaTable& table = parts_->driven_table(name);
    return {table.at, table.value};
}

void Run::drive(const std::string& name, double until, double value) {
    FormulaTable& table = parts_->driven_table(name);
    if (table.periodic) throw InputError(fmt::format("table '{}' is periodic: it has no end to continue from", name));
    if (table.at.back() > time())
        throw InputError(
            fmt::format("table '{}' is given up to {:.6g} s already; now is {:.6g} s", name, table.at.back(), time()));
    if (!(until > time()) || !std::isfinite(until) || !std::isfinite(value))
        throw InputError(
            fmt::format("table '{}' cannot go to {:.6g} until {:.6g} s; now is {:.6g} s", name, value, until, time()));
    const double last = table.value.back(); // where it has stayed meanwhile
    if (table.at.back() < time()) {
        table.at.push_back(time());
        table.value.push_back(last);
    }
    table.at.push_back(until);
    table.value.push_back(value);
}

void Run::set_table(const std::string& name, std::span<const double> at, std::span<const double> value) {
    FormulaTable& table = parts_->driven_table(name);
    const auto finite = [](std::span<const double> all) {
        return std::all_of(all.begin(), all.end(), [](double x) { return std::isfinite(x); });
    };
    const bool rises = std::adjacent_find(at.begin(), at.end(), std::greater_equal<>()) == at.end();
    if (at.empty() || at.size() != value.size() || !rises || !finite(at) || !finite(value))
        throw InputError(fmt::format("table '{}' takes points whose x are finite and rise, with a finite value each: "
                                     "here are {} and {}",
                                     name, at.size(), value.size()));
    table.at.assign(at.begin(), at.end());
    table.value.assign(value.begin(), value.end());
    parts_->tables_are_new = true;
}

namespace {

/// Reason why single rods cannot return to their start; empty: they can.
std::string fault_of_restart(const Simulation& simulation) {
    const World& world = simulation.world();
    if (simulation.stages().any()) return "the scene has stages, which act on all rods at once";
    const ContactInteraction* contacts = contacts_of(world.interactions());
    for (const auto& one : world.interactions()) {
        if (one->companion()) return "time.tolerance compares two runs of all rods";
        if (one->couples() && one.get() != contacts) return "they feel a fluid, or walls that they move";
    }
    return {};
}

/// Bodies that some rank names, all of them on all ranks. Collective.
std::set<std::int64_t> of_all_ranks(const Communicator& comm, const std::set<std::int64_t>& bodies) {
    const std::vector<double> mine(bodies.begin(), bodies.end()); // whole numbers below 2^53
    std::set<std::int64_t> all;
    for (const double body : comm.all_gather(mine)) all.insert(static_cast<std::int64_t>(body));
    return all;
}

/// Memory at the start of these bodies, which may have had other owners then. Collective.
std::map<std::int64_t, std::vector<double>> memory_of(const Communicator& comm,
                                                      const std::map<std::int64_t, std::vector<double>>& at_start,
                                                      const std::set<std::int64_t>& bodies) {
    std::vector<double> mine; // body, number of its numbers, and these
    for (const auto& [body, numbers] : at_start) {
        if (!bodies.contains(body)) continue;
        mine.insert(mine.end(), {static_cast<double>(body), static_cast<double>(numbers.size())});
        mine.insert(mine.end(), numbers.begin(), numbers.end());
    }
    const std::vector<double> all = comm.all_gather(mine);
    std::map<std::int64_t, std::vector<double>> found;
    for (std::size_t at = 0; at < all.size();) {
        const auto first = all.begin() + static_cast<std::ptrdiff_t>(at + 2),
                   end = first + static_cast<std::ptrdiff_t>(all[at + 1]);
        found[static_cast<std::int64_t>(all[at])].assign(first, end);
        at = static_cast<std::size_t>(end - all.begin());
    }
    return found;
}

/// Forgets the contacts of these bodies, and the lists that know where they were.
void forget_contacts(World& world, const std::set<std::int64_t>& bodies) {
    const ContactInteraction* contacts = contacts_of(world.interactions());
    if (!contacts) return;
    std::vector<SavedNumbers> kept = saved(world.interactions());
    for (SavedNumbers& numbers : kept) {
        if (numbers.name != contacts->saved_name()) continue;
        std::vector<double> rows;
        for (auto row = numbers.rows.begin(); row != numbers.rows.end();
             row += static_cast<std::ptrdiff_t>(numbers.columns)) {
            const auto is_of = [&](double end) {
                return bodies.contains(world.exposure()->scene().gid_at(static_cast<std::int64_t>(end)));
            };
            if (!is_of(row[0]) && !is_of(row[1]))
                rows.insert(rows.end(), row, row + static_cast<std::ptrdiff_t>(numbers.columns));
        }
        numbers.rows = std::move(rows);
    }
    restore(world.interactions(), kept);
}

} // namespace

void Run::restart(std::size_t group, std::span<const std::int64_t> rods) {
    World& world = parts_->simulation.world();
    if (const std::string fault = fault_of_restart(parts_->simulation); !fault.empty())
        throw InputError(
            fmt::format("rods of '{}' cannot return to their start: {}", world.groups.at(group).name(), fault));
    std::set<std::int64_t> bodies;
    for (const std::int64_t rod : rods) bodies.insert(world.groups[group].first_gid() + rod);
    std::map<std::int64_t, std::vector<double>> moved;
    const auto* memory = &parts_->start_memory;
    if (contacts_of(world.interactions()) && world.comm.size() > 1) { // rods that touch may change their owners
        bodies = of_all_ranks(world.comm, bodies);
        moved = memory_of(world.comm, parts_->start_memory, bodies);
        memory = &moved;
    }
    if (bodies.empty()) return;
    forget_contacts(world, bodies);
    const auto local = world.rods().local();
    std::vector<Slot<1>> state(to_index(world.groups.at(group).slots()));
    for (std::size_t i = 0; i < local.size(); ++i) {
        const std::int64_t body = body_of(world, local[i]);
        if (to_index(local[i].group) != group || !bodies.contains(body)) continue;
        world.groups[group].start_state(local[i].index, state);
        world.rods().import_rod(i, state);
        world.rods().set_budget(i, {});
        if (const auto of_body = memory->find(body); of_body != memory->end())
            world.rods().set_memory(i, of_body->second);
    }
}

std::string Run::stage() const {
    const Stages& stages = parts_->simulation.stages();
    return stages.any() ? stages.spec().name : std::string();
}

void Run::next_stage() { parts_->simulation.next_stage(); }

std::vector<GroupInfo> Run::groups() const {
    std::vector<GroupInfo> found;
    for (int i = 0; i < static_cast<int>(parts_->scene.rods.size()); ++i) {
        const RodGroup& group = nth(parts_->simulation.world().groups, i);
        found.push_back({group.name(), group.count(), group.slots(), group.body() ? 1 : group.elements()});
    }
    return found;
}

std::vector<std::int64_t> Run::numbers(std::size_t group) const {
    std::vector<std::int64_t> found;
    for (const LocalRod& rod : parts_->simulation.world().rods().local())
        if (rod.group == static_cast<int>(group)) found.push_back(rod.index);
    std::sort(found.begin(), found.end());
    return found;
}

void Run::read(std::size_t number, Quantity quantity, std::span<double> out) const {
    const std::vector<std::int64_t> order = numbers(number);
    const RodGroup& group = nth(parts_->simulation.world().groups, static_cast<int>(number));
    const auto nodes = static_cast<std::size_t>(group.slots());
    const bool at_nodes = quantity == Quantity::position || quantity == Quantity::velocity;
    const std::size_t places = at_nodes || group.body() ? nodes : static_cast<std::size_t>(group.elements());
    const std::size_t each = places * (quantity == Quantity::director ? 9 : 3);
    if (out.size() != order.size() * each)
        throw InputError(fmt::format("room for {} numbers of group '{}', which has {} here", out.size(), group.name(),
                                     order.size() * each));
    const World& world = parts_->simulation.world();
    const auto local = world.rods().local();
    std::vector<std::size_t> own;
    for (std::size_t i = 0; i < local.size(); ++i)
        if (local[i].group == static_cast<int>(number)) own.push_back(i);
    const Copy copy = at_nodes ? Copy::positions : quantity == Quantity::director ? Copy::frames : Copy::synchronised;
    world.rods().read(own, copy, world.clock.lag(), [&](int, std::size_t i, const RodCopy& rod) {
        const auto place = std::lower_bound(order.begin(), order.end(), local[own[i]].index) - order.begin();
        double* to = out.data() + static_cast<std::size_t>(place) * each;
        const auto put = [&to](const Vec3d& v) {
            *to++ = v.x;
            *to++ = v.y;
            *to++ = v.z;
        };
        for (std::size_t k = 0; k < places; ++k) {
            if (quantity == Quantity::position) put(lane(rod.state[k].position, 0));
            else if (quantity == Quantity::velocity) put(lane(rod.state[k].velocity, 0));
            else if (quantity == Quantity::spin) put(lane(rod.state[k].spin, 0));
            else
                for (const Vec3d& axis : {rod.frames[k].d1, rod.frames[k].d2, rod.frames[k].d3}) put(axis);
        }
    });
}

std::size_t Run::rods() const { return parts_->simulation.world().rods().local().size(); }

RodState Run::rod(std::size_t i) const {
    const LocalRod& local = parts_->simulation.world().rods().local()[i];
    const RodGroup& group = nth(parts_->simulation.world().groups, local.group);
    RodState out{
        .group = group.name(), .number = local.index, .position = {}, .velocity = {}, .director = {}, .spin = {}};
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    parts_->simulation.world().rods().export_rod(i, state);
    synchronise(group, state, parts_->simulation.world().clock.lag());
    const auto numbers = [](const Vec3d& v) { return std::array{v.x, v.y, v.z}; };
    for (const Slot<1>& slot : state) {
        out.position.push_back(numbers(lane(slot.position, 0)));
        out.velocity.push_back(numbers(lane(slot.velocity, 0)));
        if (&slot == &state.back()) break; // a node without an element
        const Mat3d frame = skein::frame(slot);
        out.director.push_back({numbers(frame.d1), numbers(frame.d2), numbers(frame.d3)});
        out.spin.push_back(numbers(lane(slot.spin, 0)));
    }
    return out;
}

} // namespace skein
