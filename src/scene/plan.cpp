#include "scene/plan.hpp"

#include "contact/contact_limits.hpp"
#include "contact/wall_contacts.hpp"
#include "core/share_text.hpp"
#include "immersion/fluid_loads.hpp"
#include "io/trajectory.hpp"
#include "io/vtk_series.hpp"
#include "joints/joint_limits.hpp"
#include "loads/formula_load.hpp"
#include "loads/gravity.hpp"
#include "mechanics/audit.hpp"
#include "mechanics/bending_shift.hpp"
#include "mechanics/law.hpp"
#include "neighbourhood/exposure.hpp"
#include "physics/fluid/fluid_doubts.hpp"
#include "physics/fluid/fluid_pressure.hpp"
#include "physics/fluid/stated_speeds.hpp"
#include "physics/group_names.hpp"
#include "physics/joints/assembly_check.hpp"
#include "physics/loads/loads_with_formulas.hpp"
#include "physics/loads/plane_numbers.hpp"
#include "physics/scene_spec.hpp"
#include "rod/body_shape.hpp"
#include "scene/doubts.hpp"
#include "scene/group_limits.hpp"
#include "scene/law_differences.hpp"
#include "scene/plan_steps.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"
#include "tiles/clusters.hpp"
#include "tiles/rods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

KickKind kick_of(const RodGroup& group, const DampingRates& rates, DampingScheme scheme) {
    if (group.law() == Law::elastica) return KickKind::elastica;
    if (rates.none()) return KickKind::undamped;
    if (!rates.follow_stretch()) return KickKind::constant_rates;
    switch (scheme) {
    case DampingScheme::midpoint:
        return KickKind::stretched_rates;
    case DampingScheme::exponential:
        return KickKind::stretched_exponential;
    case DampingScheme::after:
        break;
    }
    return KickKind::stretched_after;
}

/// The published law has the published order; kicks backwards need the exact flow.
DampingScheme damping_scheme_of(const RodGroup& group, const TimeSpec& time) {
    if (group.law() == Law::elastica) return DampingScheme::after;
    return time.integrator == Integrator::pefrl && time.damping == DampingScheme::midpoint ? DampingScheme::exponential
                                                                                           : time.damping;
}

std::vector<std::string> hints_for(const RodGroup& group) {
    std::vector<std::string> hints;
    if (!group.strained()) return hints;
    const Shape& shape = group.spec().shape;
    double length = group.element[0].rest_length, radius = group.element[0].radius;
    for (const ElementConstants& c : group.element)
        if (c.rest_length * radius < length * c.radius) {
            length = c.rest_length;
            radius = c.radius;
        }
    if (length < radius)
        hints.push_back(fmt::format(
            "elements are {:.2g} radii long; below 1 they cost time and gain little: elements = {} would do",
            length / radius, std::max(2L, static_cast<long>(static_cast<double>(shape.elements) * length / radius))));
    constexpr double longest_element = 1000; // radii; of hair in 20 elements 100
    if (length > longest_element * radius)
        hints.push_back(fmt::format(
            "elements are {:.2g} radii long, so that bends shorter than that are not seen; if the radius is right, "
            "elements = {:.2g} would have a hundred each",
            length / radius, static_cast<double>(shape.elements) * length / (100 * radius)));
    if (const auto told = law_differences(group)) hints.push_back(*told);
    if (group.spec().start == EndKind::clamped_frozen || group.spec().end == EndKind::clamped_frozen)
        hints.push_back("\"clamped_frozen\" is of first order, an error of about 1/elements; \"clamped\" is of second "
                        "order at the same cost");
    return hints;
}

/// Inertia that is no true one does not carry what is dragged along.
void refuse_drag(const GroupPlan& p, const RodGroup& group) {
    for (const Load& load : p.loads)
        if (load.largest_rate(group).value > 0)
            throw InputError(
                fmt::format("{}: a load of kind {} slows '{}' down, and time.relax has no motion that it could answer",
                            group.spec().source, load.kind(), group.name()));
}

/// As stiff as any of a group's contacts is at the largest overlap that is allowed, on a node that touches four others.
RelaxationContacts relaxation_contacts(const RodGroup& group, const SceneSpec& scene) {
    constexpr double farthest_move = 0.2; // of the radius in a step
    constexpr int touching = 4;
    RelaxationContacts contacts;
    double radius = HUGE_VAL;
    for (const ElementConstants& e : group.element) radius = std::min(radius, e.radius);
    with_contact_laws(scene, group, [&](const ContactLaw& law, double share, double mass) {
        const double k = touching * tangent_stiffness(law.resolved(mass), share * 2 * radius);
        contacts.stiffness = std::max(contacts.stiffness, k);
        if (law.friction != ContactFriction::none) contacts.turning = std::max(contacts.turning, k * radius * radius);
        contacts.farthest_move = farthest_move * radius;
    });
    return contacts;
}

/// Fault in the values of a group's loads at the start of the rods that this rank knows; empty: none.
std::string fault_at_start(const SceneSpec& scene, const GroupPlan& plan, const RodGroup& group) {
    for (std::size_t i = 0; i < plan.loads.size(); ++i) {
        const LoadSpec& load = scene.loads[plan.load_numbers[i]];
        if (const std::string fault = plan.loads[i].fault_at_start(group); !fault.empty())
            return fmt::format("{}: {}", load.source.empty() ? scene.file : load.source, fault);
    }
    return {};
}

/// Bytes of a fluid's velocities and pressure, and of rates if the scheme continues with them.
double kept_bytes(const FlowConstants& fluid) {
    return (keeps_rates(fluid.scheme) ? 7 : 4) * sizeof(double) * static_cast<double>(fluid.grid.count());
}

GroupPlan plan_group(const SceneSpec& scene, const std::vector<Load>& loads, const RodGroup& group,
                     const JointBounds* joints, std::shared_ptr<const InertiaInFluid> inertia_in_fluid) {
    GroupPlan p{.name = group.name(), .rods = group.count(), .elements = group.elements()};
    if (const BodyShape* body = group.body())
        p.body = fmt::format("{:.4g} kg, J = ({:.4g}, {:.4g}, {:.4g}) kg m^2, {} part{}", body->mass, body->inertia.x,
                             body->inertia.y, body->inertia.z, body->part.size(), body->part.size() == 1 ? "" : "s");
    for (std::size_t i = 0; i < loads.size(); ++i) {
        const LoadSpec& l = scene.loads[i];
        if (!names_group(l.rods, group.name()) || !loads[i].acts_on(group.spec())) continue;
        p.loads.push_back(loads[i]);
        p.load_numbers.push_back(i);
    }
    if (!group.places().from_file()) // else each rank knows some of the rods: fault_of_read_rods
        if (const std::string fault = fault_at_start(scene, p, group); !fault.empty()) throw InputError(fault);
    for (const DampingSpec& d : scene.damping)
        if (names_group(d.rods, group.name())) p.damping.push_back(d.damping);
    p.damping_scheme = damping_scheme_of(group, scene.time);
    const DampingRates rates = damping_rates(group, p.damping);
    p.kick = kick_of(group, rates, p.damping_scheme);
    p.undamped = group.law() == Law::elastica ? p.damping.empty() : rates.none();
    p.walls = std::any_of(scene.walls.begin(), scene.walls.end(),
                          [&](const Wall& wall) { return wall.acts_on(group.name()); });
    p.program = program_of(group, {.loads = p.loads,
                                   .damping = p.damping,
                                   .kick = p.kick,
                                   .walls = p.walls,
                                   .coupled = scene.contact.has_value(),
                                   .joined = joints != nullptr,
                                   .audit = scene.output.audit,
                                   .relax = scene.time.relax,
                                   .feels_fluid = inertia_in_fluid != nullptr});
    for (std::size_t i = 0; i < p.program.size(); ++i) p.ns_per_element_step += predicted_ns(p.program[i]);
    if (scene.time.relax) {
        p.relaxation = relaxation_contacts(group, scene);
        refuse_drag(p, group);
    }
    p.inertia_in_fluid = std::move(inertia_in_fluid);
    find_limits(p, group, scene, joints);
    p.tension_limit = tension_limit(group);
    if (const auto& j = group.rotary_inertia_scale; !j.empty()) {
        const auto [least, largest] = std::minmax_element(j.begin(), j.end());
        p.least_rotary_scale = *least;
        p.largest_rotary_scale = *largest;
        p.bending_shift = bending_shift(group);
    }
    if (group.spec().placement.kind == PlacementKind::packing) {
        p.packed_fill = group.packed_fill();
        p.packed_top = group.packed_top();
    }
    p.hints = hints_for(group);
    const auto named = [](EndKind kind, const std::string& free) {
        return fmt::format("{}{}{}", nth(end_names, kind), free.empty() ? "" : ", free along ", free);
    };
    p.start = named(group.spec().start, group.spec().start_free);
    p.end = named(group.spec().end, group.spec().end_free);
    return p;
}

bool can_lie_along(const GroupProgram& program) {
    return std::all_of(program.before.begin(), program.before.end(), may_lie_along) &&
           std::all_of(program.after.begin(), program.after.end(), may_lie_along);
}

/// Refuses passes that need constants of the group if rods have their own.
void refuse_in_heterogeneous(const GroupPlan& p, const RodGroup& group, bool can_lie_along) {
    const auto refuse = [&](const std::string& what) {
        throw InputError(
            fmt::format("{}: the rods of '{}' have lengths, radii or shapes of their own, by file '{}': {}",
                        group.spec().source, group.name(), group.spec().placement.file, what));
    };
    for (const Load& load : p.loads)
        if (load.keeps_tables_of_group() || load.needs_whole_rods())
            refuse(fmt::format("a load of kind {} cannot act on them yet", load.kind()));
    const auto has = [&]<class Pass>(Pass) {
        return std::any_of(p.program.after.begin(), p.program.after.end(),
                           [](const PassSpec& pass) { return std::holds_alternative<Pass>(pass); });
    };
    if (has(pass::FeelFluid{}))
        refuse("they do not feel a fluid yet; immersion.coupling = \"one_way\" has them move as if there were none");
    if (has(pass::Relax{}))
        refuse("time.relax solves along whole rods that are alike; give each size a group of its own");
    if (!can_lie_along)
        refuse("contact, walls, rings, rigid bodies, the law \"elastica\", moved ends, a clamp that slides at the last "
               "end (the first "
               "may), 'hold', the laplacian damping and audits need rods that are alike");
    if (group.spec().material.rotary_inertia_for_dt > 0) refuse("'rotary_inertia_for_dt' needs rods that are alike");
}

/// Groups with the same passes under the same loads; those whose loads keep tables of their group stand alone.
void find_families(Plan& plan, std::span<const RodGroup> groups) {
    std::vector<std::string> keys;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        GroupPlan& p = plan.groups[g];
        const bool can = can_lie_along(p.program);
        p.heterogeneous = groups[g].heterogeneous();
        if (p.heterogeneous) refuse_in_heterogeneous(p, groups[g], can);
        if (!can) continue;
        std::string key = fmt::format("{} of {}", fmt::join(p.program.names(), "|"), fmt::join(p.load_numbers, ","));
        for (const Load& load : p.loads)
            if (load.keeps_tables_of_group()) key += fmt::format(" in {}", g);
        if (p.heterogeneous) key += fmt::format(" in {}", g);
        const auto found = std::find(keys.begin(), keys.end(), key);
        p.family = static_cast<int>(found - keys.begin());
        if (found == keys.end()) keys.push_back(key);
    }
    plan.families = static_cast<int>(keys.size());
}

/// Tiles of a rank's share, what they weigh, and how long its threads need for a step, ns.
double lay_out(Plan& plan) {
    const Machine& m = plan.machine;
    std::vector<std::int64_t> share;
    for (const GroupPlan& p : plan.groups) share.push_back((p.rods + m.ranks - 1) / m.ranks);
    const Tiling tiling = tiling_of(plan, share, plan.machine.lanes);
    double total = 0, longest = 0, slots = 0;
    int most_rows = 0;
    const auto add = [&](double tiles, int rows, double row_ns) {
        if (tiles == 0) return;
        total += tiles * rows * row_ns;
        longest = std::max(longest, rows * row_ns);
        most_rows = std::max(most_rows, rows);
        slots += tiles * (rows + 1) * m.lanes;
    };
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        GroupPlan& p = plan.groups[g];
        const std::int64_t along = share[g] - tiling.across[g];
        p.along = std::min(p.rods, along * m.ranks);
        p.tiles = Tiling::tiles(p.rods - p.along, m.lanes);
        add(static_cast<double>(Tiling::tiles(tiling.across[g], m.lanes)), p.elements,
            8 * p.ns_per_element_step); // narrow tiles take as long as wide ones
        int least = m.lanes, most = 1;
        for (const AlongTile& tile : tiling.along)
            for (const AlongTile::Part& part : tile.parts)
                if (part.group == static_cast<int>(g)) {
                    least = std::min(least, part.pieces);
                    most = std::max(most, part.pieces);
                }
        if (p.along > 0)
            p.pieces = most == 1       ? "whole"
                       : least == most ? fmt::format("in {} pieces each", most)
                                       : fmt::format("in {} to {} pieces", least, most);
    }
    double constants = 0;
    for (const AlongTile& tile : tiling.along) {
        const GroupPlan& p = nth(plan.groups, tile.parts.front().group);
        add(1, tile.rows, 8 * along_row * p.ns_per_element_step);
        constants += tile.rows * m.lanes * sizeof(Strands<1>::Element); // where rows repeat far less
    }
    plan.state_bytes += m.ranks * (slots * sizeof(Slot<1>) + constants) +
                        static_cast<double>(m.ranks) * m.threads * most_rows * sizeof(SlotLoad<1>) * m.lanes;
    return std::max(total / std::min(m.threads, m.cores), longest);
}

void list_absent(Plan& plan, const SceneSpec& scene) {
    const auto need = [&](bool present, const std::string& what) {
        if (!present) plan.absent.push_back(what);
    };
    need(!scene.damping.empty(), "damping");
    std::vector<bool> has(load_kinds().size(), false);
    for (const GroupPlan& g : plan.groups)
        for (const Load& load : g.loads) nth(has, load.number()) = true;
    for (std::size_t kind = 0; kind < has.size(); ++kind)
        need(has[kind], std::string(make_load(static_cast<int>(kind)).label()));
    need(plan.cadence.trajectory > 0, "trajectory");
    need(plan.cadence.tips > 0, "tips");
    need(plan.cadence.series > 0, "time series");
    need(!plan.walls.empty(), "walls");
    need(!plan.joints.empty(), "joints");
    need(plan.contact.has_value(), "coupling between rods (messages per step: 0)");
    need(plan.fluid.has_value(), "fluid");
}

/// Bytes of frames that wait to be written together: as many as a rank's buffer holds of its share, but one at least.
double waiting_bytes(double frames, double frame_bytes, int ranks) {
    if (frames == 0) return 0;
    const double most =
        std::max(1.0, std::floor(static_cast<double>(FrameWriter::default_buffer_bytes) * ranks / frame_bytes));
    return std::min(frames, most) * frame_bytes;
}

/// Law between two groups: that of a [[contact_pair]], or the common one.
const ContactLaw& law_between(const SceneSpec& scene, const std::string& a, const std::string& b) {
    for (const ContactPair& pair : scene.contact_pairs)
        if ((pair.between[0] == a && pair.between[1] == b) || (pair.between[0] == b && pair.between[1] == a))
            return pair.law;
    return scene.contact->law;
}

ContactLaws contact_laws(const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::vector<ContactLaw> laws;
    for (const RodGroup& a : groups)
        for (const RodGroup& b : groups)
            laws.push_back(law_between(scene, a.name(), b.name()).resolved(reduced_mass(a, b)));
    const bool alike = scene.contact_pairs.empty() && scene.contact->law.restitution == 0;
    return alike ? ContactLaws(laws.front()) : ContactLaws(groups.size(), std::move(laws));
}

/// Boxes touch rods, spheres and capsules, not each other.
void refuse_boxes_that_meet(const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::int64_t bodies = 0;
    for (const RodGroup& group : groups) {
        if (!group.body() || !group.body()->has_boxes()) continue;
        bodies += group.count();
        if (bodies > 1)
            throw InputError(fmt::format(
                "{}: the body '{}': with [contact] one body of a scene may have boxes, as boxes do not touch each "
                "other yet, and there are {} so far: make others of spheres and capsules",
                group.spec().source.empty() ? scene.file : group.spec().source, group.name(), bodies));
    }
}

std::vector<AssemblyPlan> assemblies(const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::vector<AssemblyPlan> all;
    for (const AssemblyGroups& assembly : assemblies_of(groups)) {
        AssemblyPlan& p = all.emplace_back();
        p.name = assembly_name(scene, assembly.assembly);
        p.copies = assembly.groups.front()->assembly()->count();
        for (const RodGroup* group : assembly.groups) {
            p.rods += group->rods_per_copy();
            p.elements += group->rods_per_copy() * group->elements();
        }
        p.joints = joints_of(scene.joints, groups, assembly.assembly);
        p.joints_of_table.assign(scene.joints.size(), 0);
        for (const Joint& joint : p.joints) ++p.joints_of_table[joint.table];
    }
    return all;
}

void weigh(Plan& plan, std::span<const RodGroup> groups, const SceneSpec& scene) {
    for (const RodGroup& group : groups) {
        const double mass =
            static_cast<double>(group.count()) * std::accumulate(group.node_mass.begin(), group.node_mass.end(), 0.0);
        plan.mass += mass;
        plan.mass_radius += mass * group.element.front().radius;
    }
    if (!scene.contact && scene.walls.empty()) return;
    int found = 0;
    for (const LoadSpec& l : scene.loads)
        if (const auto* gravity = l.load.get_if<Gravity>(); gravity && ++found == 1 && l.rods.empty())
            plan.gravity = gravity->acceleration;
    if (found > 1) plan.gravity.reset();
}

} // namespace

bool is_coupled(const Plan& plan) {
    return plan.contact || plan.fluid ||
           std::any_of(plan.walls.begin(), plan.walls.end(), [](const Wall& wall) { return wall.servo.drives(); });
}

StepWatch step_watch(const Plan& plan) {
    if (plan.relax) return {}; // limits of motion do not hold
    double inertia = 1;
    std::vector<char> undamped;
    for (const GroupPlan& group : plan.groups) {
        inertia = std::min(inertia, group.effective_inertia());
        undamped.push_back(group.undamped && !group.inertia_in_fluid);
    }
    return {.dt = plan.dt,
            .stability = std::sqrt(inertia) * scheme_of(plan.integrator).stability,
            .stops = !plan.force_dt,
            .undamped = std::move(undamped)};
}

Tiling tiling_of(const Plan& plan, std::span<const std::int64_t> counts, int lanes) {
    std::vector<TilingGroup> groups;
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
        groups.push_back({counts[g], plan.groups[g].elements, plan.groups[g].family, plan.groups[g].heterogeneous});
    return choose_tiling(groups, lanes, plan.machine.threads, plan.machine.mapping);
}

bool has_rods_of_files(std::span<const RodGroup> groups) {
    return std::any_of(groups.begin(), groups.end(), [](const RodGroup& group) { return group.places().from_file(); });
}

std::string fault_of_read_rods(const SceneSpec& scene, const Plan& plan, std::span<const RodGroup> groups) {
    std::string fault;
    for (std::size_t g = 0; g < groups.size() && fault.empty(); ++g)
        if (groups[g].places().from_file()) fault = fault_at_start(scene, plan.groups[g], groups[g]);
    return fault;
}

Plan make_plan(const SceneSpec& as_given, std::span<const RodGroup> groups, const Machine& machine) {
    const SceneSpec scene = with_plane_numbers(with_stiffnesses(as_given, groups), groups);
    Plan plan{.title = scene.title, .machine = machine};
    double frame_values = 0, tip_values = 0, nodes = 0, lines = 0; // the last two of poly data
    const std::vector<Load> loads = loads_with_formulas(scene);
    plan.assemblies = assemblies(scene, groups);
    plan.joints = scene.joints;
    std::vector<std::vector<Joint>> joints;
    for (const AssemblyPlan& assembly : plan.assemblies) joints.push_back(assembly.joints);
    const std::vector<JointBounds> bounds = joint_bounds(scene.joints, joints, groups);
    if (scene.fluid) plan.fluid = plan_fluid(scene, groups, loads);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const RodGroup& group = groups[g];
        const int assembly = group.assembly() ? group.assembly()->number : -1;
        const bool joined = assembly >= 0 && !nth(joints, assembly).empty();
        plan.groups.push_back(plan_group(scene, loads, group, joined ? &nth(bounds, group.id()) : nullptr,
                                         plan.fluid ? plan.fluid->rods[g].inertia : nullptr));
        plan.groups.back().assembly = assembly;
    }
    plan.contact = scene.contact;
    if (scene.contact) plan.contact_laws = contact_laws(scene, groups);
    plan.automatic_stiffness = as_given.contact && as_given.contact->law.stiffness_is_automatic();
    plan.walls = expanded(scene.walls);
    if (plan.contact || !plan.walls.empty()) {
        plan.estimate = contact_estimate(scene, plan.contact_laws ? &*plan.contact_laws : nullptr, groups);
        plan.speeds = speed_estimate(scene, plan.contact_laws ? &*plan.contact_laws : nullptr, groups);
    }
    if (plan.contact) refuse_boxes_that_meet(scene, groups);
    if (!scene.joints.empty()) plan.interactions.emplace_back(interact::Joints{});
    if (plan.contact) plan.interactions.emplace_back(interact::Contacts{});
    if (!plan.walls.empty()) plan.interactions.emplace_back(interact::Walls{});
    if (plan.fluid) plan.interactions.emplace_back(interact::Fluid{});
    find_families(plan, groups);
    weigh(plan, groups, scene);
    double ns = lay_out(plan);
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        const GroupPlan& p = plan.groups[g];
        const RodGroup& group = groups[g];
        plan.rods += p.rods;
        plan.elements += p.rods * p.elements;
        plan.state_bytes += static_cast<double>(p.rods) * sizeof(LocalRod);
        if (scene.output.audit)
            plan.state_bytes += static_cast<double>(p.tiles) * (p.elements + 1) *
                                (2 * sizeof(SlotLoad<1>) + sizeof(EnergyBudget<1>::Rates)) * machine.lanes;
        const auto of_all = [&](auto of_one) { return static_cast<double>(p.rods) * static_cast<double>(of_one); };
        const double slots = of_all(group.slots());
        plan.copy_bytes += slots * sizeof(Slot<1>);
        if (scene.contact)
            plan.state_bytes += of_all(group.exposed_slots()) * (Exposure::bytes_per_slot + SlotLoads::bytes_per_slot);
        if (p.walls) plan.state_bytes += of_all(wall_points(group) * plan.walls.size() * sizeof(ContactMemory<double>));
        frame_values += of_all(3 * group.slots() + (scene.output.directors ? 9 * p.elements + 3 * group.slots() : 0));
        nodes += of_all(group.body() ? 2 * group.body()->line.size() : static_cast<std::size_t>(group.slots()));
        lines += of_all(group.body() ? group.body()->line.size() : 1);
        tip_values += of_all(scene.output.both_ends ? 6 : 3);
    }
    for (const InteractionSpec& interaction : plan.interactions)
        ns += predicted_ns(interaction) * static_cast<double>(plan.elements) /
              (machine.ranks * std::min(machine.threads, machine.cores));
    if (plan.fluid) {
        plan.copy_bytes += kept_bytes(plan.fluid->constants);
        if (writes_pressure(*plan.fluid))
            plan.copy_bytes += sizeof(double) * static_cast<double>(plan.fluid->constants.grid.count());
    }
    if (plan.copy_bytes > machine.ranks * most_copied_bytes) plan.copy_bytes = 0;
    choose_step(plan, scene);
    plan.cadence = cadence_of(scene.output, plan);
    plan.keeping = {scene.output.keep, scene.output.milestones};
    tell_uneven_outputs(plan, scene);
    const auto note = [&](std::vector<std::string> all) {
        std::move(all.begin(), all.end(), std::back_inserter(plan.notes));
    };
    note(doubts(scene, groups, plan.dt));
    if (plan.fluid) note(fluid_doubts(*plan.fluid, groups));
    if (!plan.relax) {
        note(plan.speeds.doubts);
        note(plan.speeds.doubts_of_step(plan.dt));
    }
    if (scene.fluid) note(abrupt_starts(scene, groups, loads));
    for (std::size_t i = 0; i < loads.size(); ++i)
        if (const auto* formula = loads[i].get_if<FormulaLoad>(); formula && formula->couple_answers())
            plan.notes.push_back(fmt::format(
                "load.{}: its couple changes with places or velocities, which the limit of the step does not "
                "count: a run that breaks under it may need a shorter one",
                i));
    if (plan.force_dt && !plan.relax && plan.dt > plan.limit)
        plan.notes.push_back(fmt::format(
            "time.force_dt lets a step pass that is {} of its limit: what sets the limit may gain energy without "
            "end, and a run is stopped only where rods break or go through walls",
            share_text(plan.dt / plan.limit)));
    note(plane_doubts(scene, groups));
    note(slip_doubts(plan.estimate, plan.contact_laws ? &*plan.contact_laws : nullptr, plan.walls, groups, plan.dt));
    plan.audit = scene.output.audit;
    plan.observables = scene.output.observables;
    const auto frames = [&](std::int64_t every) {
        return every > 0 ? static_cast<double>(plan.steps / every + 1) : 0.0;
    };
    const double value_bytes = scene.output.precision == Precision::single ? 4 : 8;
    plan.output_bytes =
        value_bytes * (frames(plan.cadence.trajectory) * frame_values + frames(plan.cadence.tips) * tip_values);
    plan.vtp = scene.output.writes_vtp(static_cast<std::int64_t>(nodes));
    if (plan.vtp)
        plan.output_bytes += frames(plan.cadence.trajectory) *
                             VtkSeries::frame_bytes(scene.output, lines, nodes, plan.contact.has_value());
    plan.frame_bytes = waiting_bytes(frames(plan.cadence.trajectory), value_bytes * frame_values, machine.ranks) +
                       waiting_bytes(frames(plan.cadence.tips), value_bytes * tip_values, machine.ranks);
    if (plan.fluid) {
        const FluidGrid& grid = plan.fluid->constants.grid;
        for (const RodGroup& group : groups)
            if (plan.fluid->two_way())
                plan.state_bytes += static_cast<double>(group.count() * group.slots()) * FluidLoads::bytes_per_slot;
        plan.state_bytes += static_cast<double>(grid.count()) * plan.fluid->bytes_per_cell(machine.ranks);
        if (const std::string fault = unshared(plan.fluid->constants, machine.ranks); !fault.empty())
            plan.notes.push_back(fault);
        for (FluidOutput& output : plan.fluid->outputs) {
            output.every = whole_steps(output.interval, plan);
            (output.kind == FluidOutputKind::blocks ? plan.most_block_bytes : plan.output_bytes) +=
                frames(output.every) * output.most_bytes(grid);
        }
    }
    plan.predicted_s =
        ns * 1e-9 * static_cast<double>(scheme_of(plan.integrator).stages.size()) * static_cast<double>(plan.steps);
    if (plan.fluid)
        plan.predicted_s += plan.fluid->steps(plan.steps, plan.dt) * plan.fluid->step_seconds() /
                            (machine.ranks * std::min(machine.threads, machine.cores));
    list_absent(plan, scene);
    return plan;
}

} // namespace skein
