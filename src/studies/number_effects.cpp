#include "studies/number_effects.hpp"

#include "diagnostics/observables.hpp"
#include "physics/audit/audit_plan.hpp"
#include "rod/formulas_along.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

namespace skein {

namespace {

constexpr std::size_t first_energy = 2, energy_columns = 4; ///< of elastic energies: stretch, shear, bend, twist

bool is_digits(const std::string& part) {
    return !part.empty() && part.find_first_not_of("0123456789") == std::string::npos;
}

/// The key without numbers of items and names of rods: numbers that are alike have the same.
std::string kind_of(const std::string& key) {
    const bool of_rods = key.starts_with("rods.");
    std::string kind;
    for (std::size_t from = 0, place = 0; from <= key.size(); ++place) {
        const std::size_t dot = std::min(key.find('.', from), key.size());
        const std::string part = key.substr(from, dot - from);
        if (!(of_rods && place == 1) && !is_digits(part)) kind += part + ".";
        from = dot + 1;
    }
    return kind;
}

/// Groups whose constants may follow from the number of a key.
std::vector<std::size_t> groups_of(const std::string& key, const SceneSpec& scene) {
    std::vector<std::size_t> groups;
    const std::size_t dot = key.find('.');
    const std::string table = key.substr(0, dot), item = key.substr(dot + 1, key.find('.', dot + 1) - dot - 1);
    std::size_t place = 0; // among rods
    for (std::size_t g = 0; g < scene.rods.size(); ++g) {
        const RodSpec& rods = scene.rods[g];
        if (rods.body) continue;
        const bool by_formula = (table == "table" || table == "constants") &&
                                !(rods.shape.rest_curvature_formula.empty() && rods.section.radius_formula.empty() &&
                                  rods.section.radius_2_formula.empty()),
                   named = table == "rods" && (rods.name == item || std::to_string(place) == item);
        if (by_formula || named) groups.push_back(g);
        ++place;
    }
    return groups;
}

/// A group of a scene made again; none where its places are a matter of files or of chance.
std::optional<RodGroup> made_again(const SceneSpec& scene, const RodGroup& group) {
    RodSpec spec = nth(scene.rods, group.id());
    const PlacementKind kind = spec.placement.kind;
    if (kind == PlacementKind::packing || kind == PlacementKind::file || kind == PlacementKind::mask) return {};
    const FormulaScope names = names_for_formulas(scene);
    spec.start_motion.use(names);
    spec.end_motion.use(names);
    if (!read_rest_curvature(spec.shape, names).empty() || !read_section(spec, names).empty()) return {};
    RodGroup made(spec, group.id(), group.first_gid(), std::filesystem::path(scene.file).parent_path().string());
    if (group.assembly()) made.join(std::shared_ptr<const AssemblyCopies>(std::shared_ptr<void>{}, group.assembly()));
    return made;
}

bool equal(const Vec3d& a, const Vec3d& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool alike_but_stiffness(const ElementConstants& a, const ElementConstants& b) {
    return a.rest_length == b.rest_length && a.volume == b.volume && a.radius == b.radius &&
           equal(a.rest_strain, b.rest_strain) && equal(a.inertia, b.inertia);
}
bool alike_but_stiffness(const VoronoiConstants& a, const VoronoiConstants& b) {
    return a.inv_length == b.inv_length && a.share_before == b.share_before;
}
bool alike_but_stiffness(const RodGroup& a, const RodGroup& b) {
    const auto alike = [](const auto& one, const auto& other) { return alike_but_stiffness(one, other); };
    if (a.node_mass != b.node_mass || a.cell_weight != b.cell_weight || a.count() != b.count()) return false;
    if (!std::ranges::equal(a.element, b.element, alike) || !std::ranges::equal(a.voronoi, b.voronoi, alike))
        return false;
    // Held parts have places of the start shape.
    const RodSpec& spec = a.spec();
    const bool held = spec.end != EndKind::free || !spec.hold.nodes.empty() || !spec.hold.elements.empty();
    const auto same_frame = [](const Quaterniond& one, const Quaterniond& other) { return same_bits(one, other); };
    return !held || std::ranges::equal(a.start_directors(), b.start_directors(), same_frame);
}

bool same(const ElementConstants& a, const ElementConstants& b) { return equal(a.stiffness, b.stiffness); }
bool same(const VoronoiConstants& a, const VoronoiConstants& b) {
    return equal(a.stiffness, b.stiffness) && equal(a.rest_curvature, b.rest_curvature);
}

/// Slots that feel a change between two groups, by slot of a rod.
std::vector<char> changed_slots(const RodGroup& a, const RodGroup& b) {
    std::vector<char> changed(to_index(a.slots()), 0);
    const auto element = [&](int k) { nth(changed, k) = nth(changed, k + 1) = 1; };
    for (int k = 0; k < a.elements(); ++k)
        if (!same(nth(a.element, k), nth(b.element, k))) element(k);
    for (int k = 0; k < a.cells(); ++k)
        if (!same(nth(a.voronoi, k), nth(b.voronoi, k))) {
            element(k);
            element((k + 1) % a.elements());
        }
    if (!same(a.start_wall, b.start_wall)) element(0);
    if (!same(a.end_wall, b.end_wall)) element(a.elements() - 1);
    return changed;
}

/// The same where only the rest curvature has changed, by cell.
std::vector<char> changed_slots(const RodGroup& group, std::span<const Vec3d> before, std::span<const Vec3d> after) {
    std::vector<char> changed(to_index(group.slots()), 0);
    const auto element = [&](std::size_t k) { changed[k] = changed[k + 1] = 1; };
    const std::size_t n = to_index(group.elements());
    for (std::size_t k = 0; k < after.size(); ++k)
        if (!equal(before[k], after[k])) {
            element(k);
            element((k + 1) % n);
        }
    return changed;
}

/// Slots whose rest curvature differs in a scene whose formulas give nothing else; none where that is not sure.
std::optional<std::vector<char>> bent_slots(const SceneSpec& scene, const RodGroup& group, const std::string& key) {
    const RodSpec& spec = nth(scene.rods, group.id());
    const bool free = spec.end == EndKind::free && spec.hold.nodes.empty() && spec.hold.elements.empty();
    if (key.starts_with("rods.") || !spec.section.radius_formula.empty() || !spec.section.radius_2_formula.empty() ||
        !(free || spec.shape.start_curvature || !spec.shape.start_curvature_profile.empty()))
        return {};
    Shape shape = spec.shape;
    if (!read_rest_curvature(shape, names_for_formulas(scene)).empty()) return {};
    return changed_slots(group, group.spec().shape.rest_curvature_profile, shape.rest_curvature_profile);
}

NumberSides sides_of(const SceneSpec& scene, const ChangedNumber& number) {
    const auto at = [&](double by) { return with_number(scene, number.key, number.value + by); };
    try {
        NumberSides sides{at(-number.step), {}, -number.step, number.step};
        try {
            sides.high = at(number.step);
        } catch (const InputError&) {
            sides.high = scene;
            sides.more = 0;
        }
        return sides;
    } catch (const InputError&) {
        return {scene, at(number.step), 0, number.step};
    }
}

/// Cases with a number less and more; null where that side is the case as it is.
struct SideCases {
    std::unique_ptr<StaticCase> low, high;
    double less, more;
    double width() const { return more - less; }
};
SideCases cases_of(const StaticCase& one, const ChangedNumber& number, const Machine& machine, double time) {
    // A side that contradicts other keys is that of the scene as it is.
    const auto made = [&](const SceneSpec& scene, double& by, double other) -> std::unique_ptr<StaticCase> {
        if (by == 0) return nullptr;
        try {
            check_scene(scene);
            refuse_unsolvable(scene);
            return static_case(scene, machine, time);
        } catch (const InputError&) {
            if (other == 0) throw;
            by = 0;
            return nullptr;
        }
    };
    try {
        const NumberSides sides = sides_of(one.scene, number);
        SideCases cases{nullptr, nullptr, sides.less, sides.more};
        cases.low = made(sides.low, cases.less, cases.more);
        cases.high = made(sides.high, cases.more, cases.less);
        return cases;
    } catch (const InputError& error) {
        throw InputError(fmt::format("'{}' = {:g} cannot be varied, so that there are no slopes by it: {}", number.key,
                                     number.value, error.what()));
    }
}

} // namespace

void refuse_jump(const std::string& key, double value) {
    throw NumericalError(fmt::format("slopes by '{}' have no value: at {:g} the loads jump, or change otherwise to one "
                                     "side than to the other; slopes a little beside it may have one",
                                     key, value));
}

void require_changes(const StaticCase& one, std::span<const ChangedNumber> numbers, const Machine& machine,
                     double time) {
    for (const ChangedNumber& number : numbers) cases_of(one, number, machine, time);
}

Unknown NumberEffects::residual(const StaticCase& at) const {
    StaticState own = state_;
    at.system->set_friction_memory(friction_);
    at.system->lead_ends(own);
    return at.system->balance(own, false).residual;
}

bool NumberEffects::jumps(const Unknown& first, const Unknown& second) const {
    constexpr double rounding = 1e-10, alike = 0.5;
    StaticSystem::Balance balance = one_.system->balance(state_, false);
    const auto size = [&](const Unknown& difference) {
        balance.residual = difference;
        return one_.system->relative(balance);
    };
    return size(second) > std::max(rounding, alike * size(first));
}

NumberEffect NumberEffects::alone(const ChangedNumber& number) const {
    const SideCases cases = cases_of(one_, number, machine_, time_);
    const StaticCase &low = cases.low ? *cases.low : one_, &high = cases.high ? *cases.high : one_;
    const Unknown less = residual(low), more = residual(high);
    const auto quantity = [&](const StaticCase& at) {
        StaticState own = state_;
        at.system->lead_ends(own);
        ObservedCase observed(comm_, threads_, at, time_);
        observed.take_friction(friction_);
        return quantity_.at(observed, own);
    };
    NumberEffect effect{(more - less) / cases.width(), (quantity(high) - quantity(low)) / cases.width()};
    if (cases.low && cases.high) {
        effect.jumps = jumps(more - less, more - 2 * residual(one_) + less);
        return effect;
    }
    try { // of a bound, one side has no values
        const ChangedNumber twice{number.key, number.value, 2 * number.step};
        const SideCases beyond = cases_of(one_, twice, machine_, time_);
        if (beyond.high) effect.jumps = jumps(more - less, residual(*beyond.high) - 2 * more + less);
        else if (beyond.low) effect.jumps = jumps(more - less, residual(*beyond.low) - 2 * less + more);
    } catch (const InputError&) { // nor twice as far
    }
    return effect;
}

void NumberEffects::add_rows(std::size_t rod, const std::vector<char>& changed, std::vector<int>& rows) const {
    const StaticSystem& system = *one_.system;
    for (std::size_t k = 0; k < changed.size(); ++k) {
        if (!changed[k]) continue;
        for (const auto& parts : system.map().parts(system.first_slot(rod) + k, state_.slot))
            for (const UnknownPart& part : parts) {
                rows.push_back(part.unknown);
                for (Stiffness::InnerIterator at(coupled_, part.unknown); at; ++at) // joints pass it on
                    if (system.map().place(static_cast<int>(at.row())).rod != rod)
                        rows.push_back(static_cast<int>(at.row()));
            }
    }
}

bool NumberEffects::add_group(const std::string& key, const NumberSides& sides, std::size_t g,
                              LocalChange& change) const {
    const RodGroup& group = one_.groups[g];
    if (group.heterogeneous()) return false;
    const SceneSpec& scene = sides.more > 0 ? sides.high : sides.low;
    std::optional<std::vector<char>> changed = bent_slots(scene, group, key);
    if (!changed) {
        const std::optional<RodGroup> other = made_again(scene, group);
        if (!other || !alike_but_stiffness(*other, group)) return false;
        changed = changed_slots(*other, group);
    }
    for (std::int64_t i = 0; i < group.count(); ++i)
        add_rows(static_cast<std::size_t>(group.first_gid() + i), *changed, change.rows);
    return !wants_energies() || add_energies(sides, group, change);
}

bool NumberEffects::wants_energies() const {
    return std::ranges::any_of(quantity_.observables,
                               [](std::size_t o) { return o >= first_energy && o < first_energy + energy_columns; });
}

bool NumberEffects::add_energies(const NumberSides& sides, const RodGroup& group, LocalChange& change) const {
    const std::optional<RodGroup> low = made_again(sides.low, group), high = made_again(sides.high, group);
    if (!low || !high) return false;
    for (std::int64_t i = 0; i < group.count(); ++i) {
        const std::size_t first = one_.system->first_slot(static_cast<std::size_t>(group.first_gid() + i));
        const auto own = std::span(state_.slot).subspan(first, static_cast<std::size_t>(group.slots()));
        const RodEnergy less = rod_energy(*low, own, time_, i), more = rod_energy(*high, own, time_, i);
        const double by[energy_columns] = {more.stretch - less.stretch, more.shear - less.shear, more.bend - less.bend,
                                           more.twist - less.twist};
        for (std::size_t e = 0; e < energy_columns; ++e) change.energies[first_energy + e] += by[e] / sides.width();
    }
    return true;
}

std::unique_ptr<NumberEffects::LocalChange> NumberEffects::local_change(const ChangedNumber& number,
                                                                        std::size_t place) const {
    const std::vector<std::size_t> groups = groups_of(number.key, one_.scene);
    if (groups.empty() || one_.plan.has<AuditPlan>()) return nullptr;
    auto change = std::make_unique<LocalChange>();
    change->number = place;
    change->energies.assign(columns_, 0.0);
    try {
        const NumberSides sides = sides_of(one_.scene, number);
        for (const std::size_t g : groups)
            if (!add_group(number.key, sides, g, *change)) return nullptr;
    } catch (const InputError&) {
        return nullptr;
    }
    std::sort(change->rows.begin(), change->rows.end());
    change->rows.erase(std::unique(change->rows.begin(), change->rows.end()), change->rows.end());
    return change;
}

std::vector<NumberEffects::Batch>
NumberEffects::batches_of(std::span<const std::unique_ptr<LocalChange>> changes) const {
    std::vector<Batch> batches;
    std::vector<std::vector<char>> taken;
    for (const auto& change : changes) {
        std::size_t b = 0;
        const auto is_taken = [&](int row) { return taken[b][static_cast<std::size_t>(row)] != 0; };
        while (b < batches.size() && std::ranges::any_of(change->rows, is_taken)) ++b;
        if (b == batches.size()) {
            batches.emplace_back();
            taken.emplace_back(static_cast<std::size_t>(one_.system->unknowns()), 0);
        }
        for (const int row : change->rows) taken[b][static_cast<std::size_t>(row)] = 1;
        batches[b].push_back(change.get());
    }
    return batches;
}

bool NumberEffects::add_batch(const Batch& batch, std::span<const ChangedNumber> numbers,
                              std::vector<NumberEffect>& all) const {
    SceneSpec low = one_.scene, high = one_.scene;
    std::vector<double> width;
    std::vector<char> is_inner; // numbers with values on both sides
    for (const LocalChange* change : batch) {
        const ChangedNumber& number = numbers[change->number];
        const NumberSides sides = sides_of(one_.scene, number);
        width.push_back(sides.width());
        is_inner.push_back(sides.less < 0 && sides.more > 0);
        low = with_number(std::move(low), number.key, number.value + sides.less);
        high = with_number(std::move(high), number.key, number.value + sides.more);
    }
    Unknown difference, second;
    try {
        const Unknown more = residual(*static_case(std::move(high), machine_, time_)),
                      less = residual(*static_case(std::move(low), machine_, time_));
        difference = more - less;
        second = more - 2 * residual(one_) + less;
    } catch (const InputError&) {
        return false;
    }
    for (std::size_t i = 0; i < batch.size(); ++i) {
        NumberEffect& effect = all[batch[i]->number];
        Unknown first = Unknown::Zero(difference.size()), bend = first;
        for (const int row : batch[i]->rows) {
            first[row] = std::exchange(difference[row], 0.0);
            bend[row] = second[row];
        }
        effect.loads = first / width[i];
        effect.jumps = is_inner[i] && jumps(first, bend);
    }
    return (difference.array() == 0).all();
}

std::vector<NumberEffect> NumberEffects::find(std::span<const ChangedNumber> numbers, const RestQuantity& quantity,
                                              ObservedCase& observed) {
    quantity_ = quantity;
    size_ = quantity_.at(observed, state_).size();
    columns_ = quantity_.observables.empty() ? first_energy + energy_columns : observed.names().size();
    std::map<std::string, std::size_t> alike;
    for (const ChangedNumber& number : numbers) ++alike[kind_of(number.key)];

    std::vector<NumberEffect> all(numbers.size());
    std::map<std::string, bool> stays_local; // by kind, from the first number of it
    std::vector<std::unique_ptr<LocalChange>> changes;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const std::string kind = kind_of(numbers[i].key);
        const auto known = stays_local.find(kind);
        std::unique_ptr<LocalChange> change;
        if (alike[kind] > 1 && (known == stays_local.end() || known->second)) change = local_change(numbers[i], i);
        if (!change || known == stays_local.end()) all[i] = alone(numbers[i]);
        if (!change) {
            stays_local[kind] = false;
            continue;
        }
        if (known == stays_local.end()) {
            Unknown elsewhere = all[i].loads;
            for (const int row : change->rows) elsewhere[row] = 0;
            stays_local[kind] = (elsewhere.array() == 0).all();
            continue;
        }
        all[i].quantity = quantity_.of_observables(change->energies, size_);
        changes.push_back(std::move(change));
    }
    for (const Batch& batch : batches_of(changes))
        if (!add_batch(batch, numbers, all))
            for (const LocalChange* change : batch) all[change->number] = alone(numbers[change->number]);
    return all;
}

} // namespace skein
