// A scene as a family of static systems, one for each value of a number in it.
#pragma once

#include "equilibrium/path.hpp"
#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"

#include <memory>
#include <string>
#include <vector>

namespace skein {

/// A scene file that was read, with overrides of it.
struct SceneText {
    std::string file, text;
    std::vector<std::string> overrides;
};

/// All bodies of a scene as one static system.
struct StaticCase {
    SceneSpec scene;
    std::vector<RodGroup> groups;
    Plan plan;
    std::vector<LocalRod> rods;
    std::unique_ptr<Threads> threads; ///< of contacts
    std::unique_ptr<StaticSystem> system;
};
/// Equations of these bodies, with the joints, walls and contacts of their plan; `threads` and
/// `ranks` must outlive them.
std::unique_ptr<StaticSystem> make_static_system(const Plan& plan, std::span<const RodGroup> groups,
                                                 std::span<const LocalRod> rods, std::shared_ptr<Walls> walls,
                                                 const Threads& threads, const Communicator* ranks = nullptr);

/// Loads and ends are those at `time`, s.
std::unique_ptr<StaticCase> static_case(SceneSpec scene, const Machine& machine, double time);
std::unique_ptr<StaticCase> static_case(const SceneText& text, const Machine& machine, double time);

/// Throws InputError for scenes that no equilibrium is asked of, or whose forces at rest are not known.
void refuse_unsolvable(const SceneSpec& scene);
/// True where rods rub on walls or on each other, by a friction that this holds for.
bool has_friction(const SceneSpec& scene, bool (*holds)(ContactFriction));
inline bool has_memory(ContactFriction friction) { return friction == ContactFriction::memory; }

class SceneFamily final : public PathFamily {
public:
    /// `key`: path of the number.
    SceneFamily(SceneText text, const Machine& machine, double time, std::string key)
        : text_(std::move(text)), machine_(machine), time_(time), key_(std::move(key)) {}

    StaticSystem& at(double value) override { return *case_at(value).system; }
    StaticCase& case_at(double value);

private:
    SceneText text_;
    Machine machine_;
    double time_;
    std::string key_;
    double value_ = 0;
    std::unique_ptr<StaticCase> now_;
};

} // namespace skein
