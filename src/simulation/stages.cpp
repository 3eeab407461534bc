#include "simulation/stages.hpp"

#include "physics/loads/load_plan.hpp"
#include "plan/plan_steps.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_stages.hpp"
#include "simulation/progress.hpp"
#include "simulation/start_check.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace skein {

Stages::Stages(const SceneSpec& scene, std::span<const RodGroup> groups)
    : scene_(resolved(scene, groups)), begins_(scene.stages.empty() ? 0 : 1, 0.0) {}

void Stages::find_columns(const std::vector<std::string>& names) {
    conditions_.clear();
    for (const StageSpec& stage : scene_.stages) {
        std::optional<Condition>& condition = conditions_.emplace_back();
        if (stage.until.empty()) continue;
        condition = Condition{*stage_end(stage.until)};
        const std::vector<std::string> wanted{condition->end.column};
        condition->column = columns_of("stage.until", wanted, names).front();
    }
}

void Stages::go_on(std::vector<double> begins, const World& world) {
    begins_ = std::move(begins);
    over_.clear();
    const StageSpec& stage = spec();
    const auto whole = [&](double interval) { return whole_steps(interval, world.plan); };
    const double check = stage.check_every > 0 ? stage.check_every : 1e-3 * scene_.time.duration;
    begin_ = Every{world.plan.events_every}.from(world.clock.step_at(begins_.back()));
    end_ = stage.duration > 0 ? begin_ + whole(stage.duration) : Every::never;
    check_ = stage.until.empty() ? 0 : whole(check);
}

void Stages::hold_ends(const std::vector<RodSpec>& like, World& world) {
    hold_ends_like(like, scene_.rods);
    enter(any() ? begins_ : std::vector<double>{0.0}, world);
}

void Stages::begin_next(World& world) {
    std::vector<double> begins = begins_;
    begins.push_back(world.clock.time());
    enter(std::move(begins), world, true);
}

void Stages::enter(std::vector<double> begins, World& world, bool now) {
    const std::int64_t steps = world.plan.steps;
    std::vector<RodGroup> groups = groups_in_stage(scene_, begins, world.groups);
    Plan plan = plan_in_stage(scene_, begins, world.plan.dt, groups, world.plan.machine);
    plan.steps = steps;
    plan.stages = world.plan.stages;
    if (now) {
        refuse_new_walls(world, plan, scene_.stages[begins.size() - 1].name);
        if (has_rods_of_files(groups))
            if (const std::string fault = world.comm.first_text(fault_of_read_rods(plan, groups)); !fault.empty())
                throw InputError(fault);
    }
    world.change(std::move(groups), std::move(plan));
    if (any()) go_on(std::move(begins), world);
}

std::int64_t Stages::next(std::int64_t done) const {
    if (!any()) return Every::never;
    std::int64_t next = end_ > done ? end_ : Every::never;
    if (check_ > 0) next = std::min(next, begin_ + Every{check_}.next(done - begin_));
    return next;
}

void Stages::look(const World& world, Observation& observation) { over_ = end(world, observation); }

std::string Stages::end(const World& world, Observation& observation) const {
    const std::int64_t done = world.clock.done();
    if (!any() || done <= begin_) return {};
    if (world.plan.pseudo_time && world.ended() && !is_last()) return "all rods have settled";
    if (done >= end_) return fmt::format("{:g} s are over", spec().duration);
    if (check_ == 0 || !Every{check_}.due(done - begin_)) return {};
    const Condition& condition = *conditions_[number()];
    const double value = observation.sample()[condition.column];
    return condition.end.holds(value) ? fmt::format("{}, as it is {:.6g}", spec().until, value) : std::string();
}

} // namespace skein
