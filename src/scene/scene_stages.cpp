#include "scene/scene_stages.hpp"

#include "core/nearest.hpp"
#include "physics/table_objections.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_override.hpp"
#include "scene/scene_reader.hpp"
#include "scene/scene_rebuild.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <type_traits>
#include <utility>

namespace skein {

namespace {

/// Numbers of the first stage in which a table acts, and of the first after it in which it does not.
struct Span {
    std::size_t first = 0, end = 0;
    bool consecutive = true;
};
Span span_of(const std::vector<std::string>& named, const std::vector<StageSpec>& stages) {
    const auto acts = [&](const StageSpec& stage) { return acts_in(named, stage); };
    const auto first = std::find_if(stages.begin(), stages.end(), acts),
               end = std::find_if_not(first, stages.end(), acts);
    return {to_index(first - stages.begin()), to_index(end - stages.begin()), std::none_of(end, stages.end(), acts)};
}

ActingStages acting_stages(const std::vector<std::string>& named, const std::vector<StageSpec>& stages,
                           std::span<const double> begins) {
    const auto [first, end, consecutive] = span_of(named, stages);
    const auto time_of = [&](std::size_t stage) { return stage < begins.size() ? begins[stage] : ActingStages::never; };
    return {time_of(first), time_of(end), acts_in(named, stages[begins.size() - 1]),
            first == 0 && end == stages.size()};
}

/// When a stage surely lasts, s. Conditions end stages at times that none knows before, but for a begin that has come.
TimeSpan surely_lasts(const SceneSpec& scene, std::span<const double> begins) {
    constexpr TimeSpan unknown{ActingStages::never, 0};
    const std::size_t number = begins.size() - 1;
    const std::vector<double> nominal = nominal_begins(scene, number);
    for (std::size_t i = 0; i < number; ++i)
        if (!scene.stages[i].until.empty() && std::equal(begins.begin(), begins.end(), nominal.begin())) return unknown;
    const StageSpec& stage = scene.stages[number];
    const double begin = begins.back();
    if (!stage.until.empty()) return {begin, begin};
    return {begin, stage.duration > 0 ? begin + stage.duration : scene.time.duration};
}

/// Formulas of the scene act in this stage alone; those of tables with events, between these.
void let_formulas_act(SceneSpec& scene, const std::vector<StageSpec>& stages, const TimeSpan& lasts,
                      std::size_t stage) {
    scene.stage_lasts = lasts;
    for_each_list(scene, [&](const char*, auto& specs) {
        if constexpr (requires {
                          specs.front().stages;
                          specs.front().events;
                      })
            for (auto& spec : specs)
                if (!spec.stages.empty())
                    spec.events.from = acts_in(spec.stages, stages[stage]) ? 0 : ActingStages::never;
    });
}

/// Takes away the tables that do not act now, but for those whose physics keeps them.
template <class Spec>
void keep_acting(std::vector<Spec>& specs, const std::vector<StageSpec>& stages, std::span<const double> begins) {
    std::erase_if(specs, [&](Spec& spec) {
        const ActingStages acting = acting_stages(spec.stages, stages, begins);
        if constexpr (requires { stays_in_stage(spec, acting); }) return !stays_in_stage(spec, acting);
        else return !acting.now;
    });
}

bool same(const Vec3d& a, const Vec3d& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
bool same_vectors(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

bool same_motion(const EndMotion& a, const EndMotion& b) {
    return a.times == b.times && a.translation_formula == b.translation_formula &&
           a.rotation_formula == b.rotation_formula && a.smooth == b.smooth && a.period == b.period &&
           a.phase == b.phase && same_vectors(a.translation, b.translation) && same_vectors(a.rotation, b.rotation) &&
           same(a.amplitude, b.amplitude) && same(a.rotation_amplitude, b.rotation_amplitude);
}
bool same_start(const RodSpec& a, const RodSpec& b) {
    return a.start == b.start && a.start_free == b.start_free && same_motion(a.start_motion, b.start_motion);
}
bool same_end(const RodSpec& a, const RodSpec& b) {
    return a.end == b.end && a.end_free == b.end_free && same_motion(a.end_motion, b.end_motion);
}

/// True where a formula counts from the begin of the stage.
bool begins_anew(const EndMotion& motion) {
    const auto names_it = [](const std::string& formula) {
        return formula.find(stage_begin_name) != std::string::npos;
    };
    return std::any_of(motion.translation_formula.begin(), motion.translation_formula.end(), names_it) ||
           std::any_of(motion.rotation_formula.begin(), motion.rotation_formula.end(), names_it);
}

/// Ends that are held in another way than before are caught where they are.
void catch_ends(const std::vector<RodSpec>& before, std::vector<RodSpec>& rods, std::size_t stage) {
    for (std::size_t i = 0; i < rods.size(); ++i) {
        RodSpec& now = rods[i];
        if (now.start != EndKind::free && (!same_start(now, before[i]) || begins_anew(now.start_motion)))
            now.start_caught = stage;
        if (now.end != EndKind::free && (!same_end(now, before[i]) || begins_anew(now.end_motion)))
            now.end_caught = stage;
    }
}

/// State that the stage before has left. A physics compares each of its tables with what it was then.
void go_on_from(const SceneSpec& before, SceneSpec& now, std::size_t stage, double time) {
    catch_ends(before.rods, now.rods, stage);
    for_each_list(now, [&](std::string_view list, auto& specs) {
        using Specs = std::decay_t<decltype(specs)>;
        if constexpr (requires(typename Specs::value_type spec) { go_on_from(spec, spec, time); })
            for_each_list(before, [&](std::string_view name, const auto& were) {
                if constexpr (std::is_same_v<std::decay_t<decltype(were)>, Specs>)
                    for (std::size_t i = 0; name == list && i < specs.size(); ++i) go_on_from(were[i], specs[i], time);
            });
    });
}

Place place_of(const StageSpec& stage, const std::string& change) {
    const std::string where = stage.source.empty() ? "" : stage.source + ": ";
    return {std::make_shared<SourceText>(SourceText{fmt::format("{}stage '{}': {}", where, stage.name, change), {}})};
}

void change_for(SceneSpec& scene, const StageSpec& stage) {
    for (const std::string& change : stage.change) change_scene(scene, key_value(change, place_of(stage, change)));
}

/// Tables that stay in all stages, as the last of these sees them: at rest until the first in which they act.
void let_tables_begin(SceneSpec& scene, const std::vector<StageSpec>& stages, std::span<const double> begins) {
    for_each_list(scene, [&](const char*, auto& specs) {
        using Specs = std::decay_t<decltype(specs)>;
        if constexpr (requires(typename Specs::value_type spec, ActingStages acting) { stays_in_stage(spec, acting); })
            for (auto& spec : specs) stays_in_stage(spec, acting_stages(spec.stages, stages, begins));
    });
}

/// The scene with its changes, before tables that do not act are left out.
SceneSpec changed_scene(const SceneSpec& scene, std::span<const double> begins) {
    SceneSpec now = scene;
    for (std::size_t stage = 0; stage < begins.size(); ++stage) {
        SceneSpec before = now;
        change_for(now, scene.stages[stage]);
        if (stage == 0) continue;
        let_tables_begin(before, scene.stages, begins.first(stage));
        go_on_from(before, now, stage, begins[stage]);
    }
    return now;
}

} // namespace

bool ends_alike(const std::vector<RodSpec>& a, const std::vector<RodSpec>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const RodSpec& x, const RodSpec& y) {
        return same_start(x, y) && same_end(x, y) && x.start_caught == y.start_caught && x.end_caught == y.end_caught;
    });
}

void hold_ends_like(const std::vector<RodSpec>& others, std::vector<RodSpec>& rods) {
    for (std::size_t i = 0; i < rods.size(); ++i) {
        const RodSpec& other = others[i];
        RodSpec& now = rods[i];
        now.start = other.start;
        now.end = other.end;
        now.start_free = other.start_free;
        now.end_free = other.end_free;
        now.start_motion = other.start_motion;
        now.end_motion = other.end_motion;
        now.start_caught = other.start_caught;
        now.end_caught = other.end_caught;
    }
}

void catch_ends_of_branch(std::vector<RodSpec>& parent, std::vector<RodSpec>& branch) {
    constexpr std::size_t before = std::size_t{1} << 20, anew = before + 1; // beyond those of stages
    for (std::size_t i = 0; i < branch.size(); ++i) {
        RodSpec &was = parent[i], &now = branch[i];
        if (was.start_caught > 0) was.start_caught = before;
        if (was.end_caught > 0) was.end_caught = before;
        now.start_caught = now.start == EndKind::free || same_start(now, was) ? was.start_caught : anew;
        now.end_caught = now.end == EndKind::free || same_end(now, was) ? was.end_caught : anew;
    }
}

bool led_from_stage(const RodSpec& rods) {
    return (rods.start != EndKind::free && begins_anew(rods.start_motion)) ||
           (rods.end != EndKind::free && begins_anew(rods.end_motion));
}

SceneSpec with_changes(SceneSpec scene, std::size_t stage) {
    for (std::size_t i = 0; i <= stage; ++i) change_for(scene, StageSpec(scene.stages[i]));
    return scene;
}

SceneSpec stage_scene(const SceneSpec& scene, std::span<const double> begins) {
    if (scene.stages.empty()) return scene;
    SceneSpec now = changed_scene(scene, begins);
    for_each_list(now, [&](const char*, auto& specs) {
        if constexpr (requires { specs.front().stages; }) keep_acting(specs, scene.stages, begins);
    });
    now.stage_begin = begins.back();
    now.stage_lasts = surely_lasts(scene, begins);
    return now;
}

std::vector<double> nominal_begins(const SceneSpec& scene, std::size_t stage) {
    std::vector<double> begins(1, 0.0);
    for (std::size_t i = 0; i < stage; ++i)
        begins.push_back(std::min(scene.time.duration, begins.back() + scene.stages[i].duration));
    return begins;
}

std::vector<std::string> stage_changes(const SceneSpec& scene, std::size_t stage) {
    std::vector<std::string> all = scene.stages[stage].change;
    const auto tell = [&](const char* list, const std::string& name, const std::vector<std::string>& stages) {
        const bool now = acts_in(stages, scene.stages[stage]),
                   before = stage == 0 ? now : acts_in(stages, scene.stages[stage - 1]);
        if (now != before) all.push_back(fmt::format("{} '{}' {}", list, name, now ? "begins" : "ends"));
    };
    for_each_list(scene, [&](const char* list, const auto& specs) {
        if constexpr (requires { specs.front().stages; })
            for (const auto& spec : specs) tell(list, name_of_table(spec), spec.stages);
    });
    return all;
}

namespace {

/// Names of stages that tables act in.
void check_names(const SceneSpec& scene, Objections& objections) {
    std::vector<std::string_view> known;
    for (const StageSpec& stage : scene.stages) known.emplace_back(stage.name);
    for_each_list(scene, [&](const char* list, const auto& specs) {
        if constexpr (requires { specs.front().stages; })
            for (std::size_t i = 0; i < specs.size(); ++i) {
                const std::string path = fmt::format("{}.{}.stages", list, i);
                bool all_known = true;
                for (const std::string& name : specs[i].stages) {
                    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
                    all_known = false;
                    objections.add(path, known.empty()
                                             ? fmt::format("the scene has no [[stage]], so none is '{}'", name)
                                             : fmt::format("there is no stage '{}'{}", name,
                                                           suggestion(name, known, "the stages are")));
                }
                if (!all_known || specs[i].stages.empty()) continue;
                if (!span_of(specs[i].stages, scene.stages).consecutive)
                    objections.add(path, "a table acts in consecutive stages: give another table for the later ones");
            }
    });
}

void check_tables(const SceneSpec& scene, Objections& objections) {
    double sum = 0;
    for (std::size_t i = 0; i < scene.stages.size(); ++i) {
        const StageSpec& stage = scene.stages[i];
        TableObjections table(objections, fmt::format("stage.{}", i));
        for (std::size_t j = 0; j < i; ++j)
            if (scene.stages[j].name == stage.name)
                table.add("name", fmt::format("two stages are named '{}'", stage.name));
        if (!stage.until.empty() && !stage_end(stage.until))
            table.add("until", fmt::format("'{}' is no condition: expected a column of the series, < or >, and a "
                                           "number, as \"max_speed < 1e-4\"",
                                           stage.until));
        if (stage.until.empty()) table.unused({"check_every"}, "without 'until'");
        if (i == 0 && !stage.change.empty())
            table.add("change", "the first stage is the scene as it is: give its keys these values");
        if (i + 1 < scene.stages.size() && !stage.comes_to_an_end())
            table.add("duration", fmt::format("stage '{}' never ends, so '{}' never begins: give 'duration' [s] or "
                                              "'until'",
                                              stage.name, scene.stages[i + 1].name));
        if (sum >= scene.time.duration)
            table.add("", fmt::format("stage '{}' would begin at {:g} s, and time.duration ends the run at {:g} s",
                                      stage.name, sum, scene.time.duration));
        if (stage.until.empty()) sum += stage.duration;
    }
    for (const FormulaConstant& constant : scene.constants)
        if (!scene.stages.empty() && constant.name == stage_begin_name)
            objections.add(fmt::format("constants.{}", constant.name),
                           fmt::format("'{}' is the time at which the present stage has begun", constant.name));
}

} // namespace

void check_stages(const SceneSpec& scene, Objections& objections) {
    check_names(scene, objections);
    check_tables(scene, objections);
}

SceneSpec as_it_begins(SceneSpec scene) {
    if (scene.stages.empty()) return scene;
    const std::vector<StageSpec> stages = scene.stages;
    let_formulas_act(scene, stages, surely_lasts(scene, std::vector<double>{0.0}), 0);
    return scene;
}

namespace {

/// The scene of a stage with its tables as they are when they act, and without what is of the start alone.
SceneSpec without_stages(SceneSpec scene, std::span<const double> begins) {
    const std::size_t stage = begins.size() - 1;
    for (RodSpec& rods : scene.rods)
        if (stage > 0) rods.shape.velocity = rods.shape.angular_velocity = rods.shape.element_spin = {0, 0, 0};
    const std::vector<StageSpec> stages = scene.stages;
    let_formulas_act(scene, stages, surely_lasts(scene, begins), stage);
    scene.constants.push_back({stage_begin_name, begins.back(), "s"});
    scene.stages.clear();
    for_each_list(scene, [](const char*, auto& specs) {
        if constexpr (requires { specs.front().stages; })
            for (auto& spec : specs) spec.stages.clear();
    });
    return scene;
}

/// Contradictions of a scene that has been changed from another one.
std::string contradictions_of(const SceneSpec& changed, const SceneSpec& from) {
    std::set<std::string> given = changed_keys(changed);
    given.merge(needed_keys(from));
    std::string text;
    for (const Contradiction& c : contradictions(changed, given))
        text += fmt::format("{}{}: {}", text.empty() ? "" : "\n", c.path, c.message);
    return text;
}

/// Forbidden changes of a stage, and contradictions in the scene that it makes; empty: none.
std::string fault_of_stage(const SceneSpec& scene, std::size_t stage) {
    const std::vector<double> begins = nominal_begins(scene, stage);
    const std::span<const double> before = std::span(begins).first(std::max<std::size_t>(1, stage));
    try {
        const SceneSpec was = without_stages(stage == 0 ? scene : changed_scene(scene, before), begins);
        SceneSpec now = was;
        change_for(now, scene.stages[stage]);
        if (stage > 0) catch_ends(was.rods, now.rods, stage);
        if (const auto forbidden = forbidden_changes(physics_json(was, {}, 1), physics_json(now, {}, 1));
            stage > 0 && !forbidden.empty())
            return fmt::format("a stage has the rods, bodies and tables of the one before it, so it cannot change:{}",
                               text_of(forbidden));
        return contradictions_of(now, was);
    } catch (const InputError& error) {
        return error.what();
    }
}

} // namespace

void check_changes(const SceneSpec& scene, Objections& objections) {
    for (std::size_t i = 1; i < scene.stages.size(); ++i) {
        if (const std::string fault = fault_of_stage(scene, i); !fault.empty()) {
            const bool changes = !scene.stages[i].change.empty(); // else a formula has no value in it
            objections.add(changes ? fmt::format("stage.{}.change", i) : fmt::format("stage.{}", i),
                           changes ? fault : fmt::format("stage '{}': {}", scene.stages[i].name, fault));
            return; // later stages have it too
        }
    }
}

} // namespace skein
