#include "scene/scene_check.hpp"

#include "core/nearest.hpp"
#include "formula/formula.hpp"
#include "physics/group_names.hpp"
#include "physics/rods/rods_check.hpp"
#include "physics/table_objections.hpp"
#include "rod/formulas_along.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_stages.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/core/objections.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace skein {

namespace {

class Checker final : public Objections {
public:
    Checker(const SceneSpec& scene, const std::set<std::string>& given) : scene_(scene), given_(given) {}

    std::vector<Contradiction> run() {
        groups();
        time_and_output();
        for (std::size_t i = 0; i < scene_.rods.size(); ++i) {
            TableObjections table(*this, path_of_group(scene_, i));
            check_rods(with_profiles(scene_.rods[i], table), table);
            motions(scene_.rods[i], table);
        }
        for (const auto& [path, message] : faults(names_for_formulas(scene_))) add(path, message);
        PhysicsTables::check(scene_, *this);
        check_stages(scene_, *this);
        if (found_.empty()) check_changes(scene_, *this);
        return std::move(found_);
    }

    void add(std::string_view path, const std::string& message) override {
        found_.push_back({std::string(path), message});
    }
    void add_within(std::string_view path, std::size_t begin, std::size_t length, const std::string& message) override {
        found_.push_back({std::string(path), message, begin, length});
    }
    bool given(std::string_view path) const override { return given_.contains(std::string(path)); }

private:
    /// The rods with the profiles that their formulas say.
    RodSpec with_profiles(const RodSpec& given, Objections& of_group) const {
        RodSpec rods = given;
        TableObjections section(of_group, "section");
        for (const SectionFault& found : read_section(rods, names_for_formulas(scene_)))
            section.add_within(found.key, found.fault.part.begin, found.fault.part.length,
                               fmt::format("'{}': {}", found.key, found.fault.message));
        if (rods.shape.rest_curvature_formula.empty()) return rods;
        TableObjections table(of_group, "shape");
        const std::string key = "rest_curvature_formula";
        table.unused({"rest_curvature", "rest_curvature_profile"}, "beside 'rest_curvature_formula'");
        add_faults(key, read_rest_curvature(rods.shape, names_for_formulas(scene_)), table);
        return rods;
    }

    /// Ends that move by formulas.
    void motions(const RodSpec& rods, Objections& of_group) const {
        for (const auto& [key, motion, free] : {std::tuple{"start_motion", &rods.start_motion, &rods.start_free},
                                                std::tuple{"end_motion", &rods.end_motion, &rods.end_free}}) {
            EndMotion read = *motion;
            read.use(names_for_formulas(scene_));
            TableObjections table(of_group, key);
            read.check_formulas(lab_directions(*free), table);
            const bool caught = (motion == &rods.start_motion ? rods.start_caught : rods.end_caught) > 0;
            if (!caught) jumps(read, rods.shape, table);
        }
    }
    /// Ends that are far from where they are held when their motion begins; smaller jumps are notes of the plan.
    static void jumps(const EndMotion& motion, const Shape& shape, Objections& table) {
        constexpr double most = 0.1; // of an element, and rad
        const double length = shape.length / static_cast<double>(std::max(1L, shape.elements)),
                     moved = norm(motion.displacement(0).value), turned = norm(motion.turn(0).value);
        const char *const displacement = !motion.translation_formula.empty() ? "translation_formula"
                                         : !motion.translation.empty()       ? "translation"
                                                                             : "phase",
                          *const turn = !motion.rotation_formula.empty() ? "rotation_formula"
                                        : !motion.rotation.empty()       ? "rotation"
                                                                         : "phase";
        const char* const remedy = "take off its value at 0, or let it rise from there";
        if (moved > most * length)
            table.add(
                displacement,
                fmt::format(
                    "the end would jump by {:.3g} m, {:.2g} of an element's length, as its motion begins at t = 0: {}",
                    moved, moved / length, remedy));
        if (turned > most)
            table.add(turn, fmt::format("the end would turn by {:.3g} rad at once as its motion begins at t = 0: {}",
                                        turned, remedy));
    }

    void groups() {
        std::string others;
        bool stands_alone = false;
        for_each_table(scene_, [&](const char* name, const auto& member, bool) {
            using Member = std::remove_cvref_t<decltype(member)>;
            if constexpr (is_optional_table<Member>)
                if constexpr (requires { requires Member::value_type::stands_alone; }) {
                    others += fmt::format(" or [{}]", name);
                    stands_alone |= member.has_value();
                }
        });
        if (scene_.rods.empty() && !stands_alone)
            add("", "the scene has no bodies: give at least one [[rods]], [[bodies]]" + others);
        for (std::size_t i = 0; i < scene_.rods.size(); ++i) {
            const std::string& name = scene_.rods[i].name;
            const std::string path = path_of_group(scene_, i) + ".name";
            if (!good_name(name))
                add(path, fmt::format("'{}' cannot name a group of rods: use letters, digits, _ and -", name));
            for (std::size_t j = 0; j < i; ++j)
                if (scene_.rods[j].name == name) {
                    add(path, fmt::format("two groups of rods are named '{}'", name));
                    break;
                }
        }
        count_rods();
    }

    void count_rods() {
        constexpr double most =
            1099511627776.0; // 2^40: rods are numbered in 64 bits, and shared among ranks by sums of them
        double rods = 0;
        for (std::size_t i = 0; i < scene_.rods.size(); ++i) {
            double here = 1;
            for (const long n : scene_.rods[i].placement.counts) here *= static_cast<double>(n);
            if (scene_.rods[i].placement.kind == PlacementKind::packing)
                here = static_cast<double>(scene_.rods[i].placement.packing.count);
            rods += here;
            if (rods <= most) continue;
            add(path_of_group(scene_, i) + ".placement.counts", fmt::format("{:.3g} rods are more than 2^40", rods));
            return;
        }
    }

    void time_and_output() {
        const double duration = scene_.time.duration;
        if (scene_.time.dt > duration)
            add("time.dt", fmt::format("'dt' of {} s is longer than 'duration' of {} s", scene_.time.dt, duration));
        const OutputSpec& out = scene_.output;
        for (const auto& [key, interval] : out.intervals())
            if (interval > duration)
                add(fmt::format("output.{}", key),
                    fmt::format("'{}' every {} s never comes due within 'duration' of {} s", key, interval, duration));
        if (scene_.start.from.empty()) TableObjections(*this, "start").unused({"time"}, "without 'from'");
        else start();
        if (out.trajectory == 0) TableObjections(*this, "output").unused({"paraview"}, "without 'trajectory' [s]");
        if (scene_.time.rest_speed > 0 && out.series == 0)
            add("time.rest_speed", "'rest_speed' is looked at in the rows of the series: give output.series [s]");
        for (std::size_t i = 0; i < out.observables.size(); ++i) {
            const std::string& set = out.observables[i];
            const std::string path = fmt::format("output.observables.{}", i);
            const std::vector<std::string_view> known(std::begin(observable_set_names), std::end(observable_set_names));
            if (std::find(known.begin(), known.end(), set) == known.end())
                add(path,
                    fmt::format("there are no observables '{}'{}", set, suggestion(set, known, "the choices are")));
            else if (std::find(out.observables.begin(), out.observables.begin() + static_cast<long>(i), set) !=
                     out.observables.begin() + static_cast<long>(i))
                add(path, fmt::format("'{}' is named twice", set));
        }
    }

    void start() {
        try {
            checkpoint_name(scene_.start.from);
        } catch (const InputError& e) {
            add("start.from", e.what());
        }
        for (const RodSpec& rods : scene_.rods)
            if (scene_.start.time == StartTime::zero && (rods.start_motion.moves() || rods.start_motion.turns() ||
                                                         rods.end_motion.moves() || rods.end_motion.turns()))
                add("start.time",
                    fmt::format("the ends of group '{}' are moved as functions of time: at time zero they would jump "
                                "back; let time continue",
                                rods.name));
    }

    const SceneSpec& scene_;
    const std::set<std::string>& given_;
    std::vector<Contradiction> found_;
};

/// "file:line: " of the table that a path starts with.
std::string source_prefix(const SceneSpec& scene, const std::string& path) {
    for (std::size_t i = 0; i < scene.rods.size(); ++i)
        if (const std::string table = path_of_group(scene, i); path == table || path.starts_with(table + "."))
            return (scene.rods[i].source.empty() ? table : scene.rods[i].source) + ": ";
    std::string prefix = scene.file.empty() ? "" : scene.file + ": ";
    for_each_list(scene, [&](const std::string& name, const auto& specs) {
        if (!path.starts_with(name + ".")) return;
        const std::string number = path.substr(name.size() + 1, path.find('.', name.size() + 1) - name.size() - 1);
        const std::string& source = specs.at(std::stoul(number)).source;
        prefix = (source.empty() ? name + "." + number : source) + ": ";
    });
    return prefix;
}

} // namespace

std::vector<Contradiction> contradictions(const SceneSpec& scene, const std::set<std::string>& given) {
    return Checker(as_it_begins(scene), given).run();
}

std::set<std::string> needed_keys(const SceneSpec& scene) {
    const std::set<std::string> changed = changed_keys(scene);
    std::set<std::string> needed;
    for (const Contradiction& c : contradictions(scene, changed))
        if (!changed.contains(c.path)) needed.insert(c.path);
    return needed;
}

void check_scene(const SceneSpec& scene) { refuse_contradictions(scene, changed_keys(scene)); }

void refuse_contradictions(const SceneSpec& scene, const std::set<std::string>& given) {
    std::string text;
    for (const Contradiction& c : contradictions(scene, given))
        text.append(text.empty() ? "" : "\n").append(source_prefix(scene, c.path) + c.message);
    if (!text.empty()) throw InputError(text);
}

} // namespace skein
