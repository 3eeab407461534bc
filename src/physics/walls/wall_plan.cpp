#include "physics/walls/wall_plan.hpp"

#include "coupling/interaction.hpp"
#include "kernels/physics_passes.hpp"
#include "kernels/surroundings.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/plan_input.hpp"
#include "physics/walls/wall_interaction.hpp"
#include "plan/doubts.hpp"
#include "plan/plan.hpp"
#include "plan/plan_line.hpp"
#include "plan/plan_words.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

std::string wall_text(const Wall& wall, double overlap) {
    std::string text = fmt::format("'{}', {}, {}", wall.name, nth(wall_names, wall.kind), law_text(wall.law));
    if (wall.servo.drives())
        text += fmt::format("; driven at {:g} m/s by the stress on '{}'", wall.servo.speed, wall.servo.watch);
    else if (wall.moves_steadily()) text += "; moves";
    if (overlap > 0) text += fmt::format("; overlap of {:.2g} expected", overlap);
    return text;
}

class PlannedWalls final : public PhysicsPlan, public WallPlan, public StartsInteraction, public SharesWithPasses {
public:
    explicit PlannedWalls(const PlanInput& input) : WallPlan{expanded(input.scene.walls)} {
        ScaleDoubts scales(input.scene.time.duration, input.groups);
        for (Wall wall : input.scene.walls) // copies: fields() hands out references to change
            scales.look_at("wall." + wall.name, [&](FieldVisitor& f) { wall.fields(f); });
        doubts_ = scales.take();
    }

    std::string summary(const Plan&) const override { return counted(static_cast<std::int64_t>(walls.size()), "wall"); }
    std::vector<PlanLine> describe(const Plan& p) const override {
        const std::vector<double>& overlaps = p.find<TouchPlan>()->estimate.wall_overlaps;
        std::vector<PlanLine> lines;
        nlohmann::ordered_json json = nlohmann::ordered_json::array();
        for (std::size_t w = 0; w < walls.size(); ++w) {
            const Wall& wall = walls[w];
            lines.push_back({"wall", wall_text(wall, overlaps[w]), "", {}});
            json.push_back({{"name", wall.name},
                            {"kind", nth(wall_names, wall.kind)},
                            {"law", law_text(wall.law)},
                            {"driven", wall.servo.drives()},
                            {"moves", wall.moves_steadily()},
                            {"expected_overlap", overlaps[w]}});
        }
        lines.push_back({"", "", "walls", json});
        return lines;
    }
    std::vector<std::string> notes(const Plan&, std::span<const RodGroup>) const override { return doubts_; }
    void add_passes(GroupPlan& p, const RodGroup& group) const override {
        if (!act_on_group(group)) return;
        const bool by_mass = std::any_of(walls.begin(), walls.end(), [&](const Wall& w) {
            return w.acts_on(group.name()) && w.law.restitution > 0;
        });
        if (group.strained()) p.program.add(PassPlace::boundaries, pass::Walls{by_mass});
        else p.program.add(PassPlace::boundaries, pass::SurfaceWalls{});
    }
    Coupling coupling() const override {
        const bool servos = std::any_of(walls.begin(), walls.end(), [](const Wall& w) { return w.servo.drives(); });
        return servos ? Coupling::every_step : Coupling::none;
    }
    void add_bytes(Plan& plan, std::span<const RodGroup> groups) override {
        for (const RodGroup& group : groups)
            if (act_on_group(group))
                plan.state_bytes += static_cast<double>(group.count()) * static_cast<double>(wall_points(group)) *
                                    static_cast<double>(walls.size() * sizeof(ContactMemory<double>));
    }

    /// Walls that are there go on: their servos have a state.
    void share(Surroundings& around, std::span<const RodGroup>, std::span<const LocalRod>) const override {
        if (!around.walls) around.walls = std::make_shared<Walls>(walls);
    }
    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return std::make_unique<WallInteraction>(parts);
    }

private:
    bool act_on_group(const RodGroup& group) const {
        return std::any_of(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.acts_on(group.name()); });
    }

    std::vector<std::string> doubts_;
};

} // namespace

void WallTables::plan(const PlanInput& input, PlannedPhysics& out) {
    if (!input.scene.walls.empty()) out.add<PlannedWalls>(input);
}

} // namespace skein
