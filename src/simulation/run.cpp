#include "skein/run.hpp"

#include "parallel/communicator.hpp"
#include "partition/partition.hpp"
#include "scene/scene_file.hpp"
#include "simulation/machine.hpp"
#include "simulation/simulation.hpp"
#include "simulation/summary.hpp"

#include <algorithm>
#include <optional>
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

struct Run::Parts {
    Parts(const SceneSpec& scene, const RunSettings& settings)
        : comm(Communicator::world()), machine(machine_of(comm, settings.threads, settings.lanes)), threads(machine.threads),
          writes(!settings.out.empty()), simulation(made(scene, settings, make_groups(scene))) {}

    Simulation made(const SceneSpec& scene, const RunSettings& settings, std::vector<RodGroup> groups) const {
        read_rods(comm, groups);
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
    Simulation simulation;
};

Run::Run(const Scene& scene, const RunSettings& settings) : parts_(std::make_unique<Parts>(*scene.spec_, settings)) {}
Run::~Run() = default;
Run::Run(Run&&) noexcept = default;
Run& Run::operator=(Run&&) noexcept = default;

std::string Run::plan() const { return to_text(parts_->simulation.plan()); }
double Run::dt() const { return parts_->simulation.plan().dt; }
std::int64_t Run::steps() const { return parts_->simulation.plan().steps; }
std::int64_t Run::step() const { return parts_->simulation.step(); }
double Run::time() const { return parts_->simulation.time(); }

void Run::advance(std::int64_t until) {
    parts_->simulation.advance(std::min(until, steps()));
    if (const std::string failure = parts_->simulation.failure(); !failure.empty()) throw NumericalError(failure);
}

int Run::run() {
    if (!parts_->writes) throw InputError("Run::run() writes results, and RunSettings::out names no directory for them");
    return static_cast<int>(parts_->simulation.run().code);
}

std::string Run::digest() const { return digest_text(parts_->simulation.digest()); }
std::vector<std::string> Run::observable_names() const { return parts_->simulation.names(); }
std::vector<double> Run::observables() const { return parts_->simulation.observables(); }

std::size_t Run::rods() const { return parts_->simulation.rods().local().size(); }

RodState Run::rod(std::size_t i) const {
    const LocalRod& local = parts_->simulation.rods().local()[i];
    const RodGroup& group = parts_->simulation.group(local.group);
    RodState out{.group = group.name(), .number = local.index, .position = {}, .velocity = {}, .director = {}, .spin = {}};
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    parts_->simulation.rods().export_rod(i, state);
    synchronise(group, state, parts_->simulation.lag());
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
