// Bodies at rest, compiled per level. Internal loads and their slopes come element by element (elastic_tangent.hpp).
// All other loads come from the passes of the plan and from its joints, which run over dual numbers: a colour of slots
// after another is moved along its six unknowns, such that no load feels two slots of one colour. Damping comes in the
// same way, by slots that are given rates.
#pragma once

#include "core/dual_rotation.hpp"
#include "formula/dual_functions.hpp"
// The above come before all templates over packs.
#include "contact/static_friction.hpp"
#include "joints/cluster_joints.hpp"
#include "kernels/elastic_tangent.hpp"
#include "kernels/make_rods_at.hpp"
#include "kernels/static_rods.hpp"
#include "loads/damping.hpp"
#include "loads/laplacian_filter.hpp"
#include "mechanics/moving_ends.hpp"
#include "tiles/slot_slopes.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace skein {

/// Makes the passes that add loads to a body by itself; none where another does.
class StaticPassMaker {
public:
    using Made = std::unique_ptr<TilePass<dual>>;
    StaticPassMaker(const RodGroup& group, const Surroundings& around, std::shared_ptr<WallContactTiles<dual>> walls)
        : group_(group), around_(around), walls_(std::move(walls)) {}

    Made operator()(const pass::Elastic& p) const {
        if (p.law != Law::elastica) return nullptr;
        return std::make_unique<ElasticaPass<dual>>(ends_of(group_));
    }
    Made operator()(const pass::ApplyLoad& p) const { return make_pass<dual, Across<dual>>(p.load, group_); }
    Made operator()(pass::Walls) const {
        return std::make_unique<WallPass<dual, RodNodes<dual>>>(around_.walls, group_, walls_);
    }
    Made operator()(pass::SurfaceWalls) const {
        return std::make_unique<WallPass<dual, SurfacePoints<dual>>>(around_.walls, group_, walls_);
    }
    template <class Other> Made operator()(const Other&) const { return nullptr; }

private:
    const RodGroup& group_;
    const Surroundings& around_;
    std::shared_ptr<WallContactTiles<dual>> walls_;
};

class StaticRodsAt final : public StaticRods {
public:
    StaticRodsAt(const Plan& plan, std::span<const RodGroup> groups, std::span<const LocalRod> owned,
                 Surroundings around)
        : dt_(plan.dt) {
        if (around.walls) {
            around.walls = std::make_shared<Walls>(*around.walls);
            for (Wall& wall : around.walls->wall) wall.law = wall.law.sticking_at_limit();
        }
        std::size_t slots = 0;
        for (const LocalRod& local : owned) {
            const RodGroup& group = nth(groups, local.group);
            Rod& rod = rods_.emplace_back();
            rod.local = local;
            if (group.heterogeneous()) rod.own = std::make_unique<RodGroup>(group.single(local.index));
            rod.group = rod.own ? rod.own.get() : &group;
            rod.first = slots;
            slots += to_index(rod.group->slots());
        }
        slots_ = slots;
        slot_.resize(slots + 1); // and the world
        load_.resize(slots);
        for (Rod& rod : rods_) make_passes(rod, plan, around);
        for (const GroupPlan& group : plan.groups) damping_.push_back(group.damping);
        if (around.joints) make_clusters(*around.joints, groups, owned);
        set_time(0);
    }

    std::size_t first_slot(std::size_t i) const override { return i < rods_.size() ? rods_[i].first : slots_; }
    std::span<const CommonNode> common_nodes() const override { return shared_; }

    void set_time(double time) override {
        step_ = {.index = 1,
                 .dt = dt_,
                 .drift = 0,
                 .kick = dt_,
                 .time = time,
                 .kick_length = 0,
                 .slot = 0,
                 .completes = true,
                 .last = true,
                 .begin = time};
        rubbing_step_ = step_;
        rubbing_step_.dt = rubbing_step_.kick = long_step;
        short_step_ = step_;
        short_step_.dt = short_step_.kick = short_step;
        prepare(step_, rubbing_step_);
    }

    void lead_ends(std::span<Slot<1>> state) const override {
        for (const Rod& rod : rods_) {
            if (!rod.group->spec().ends_move()) continue;
            const auto moving = std::make_shared<MovingEnds>(*rod.group);
            moving->prepare({&step_, 1});
            MoveEndsPass<1> pass(moving, std::make_shared<EndWalls<1>>(moving));
            RodTile<1> tile =
                tile_of(*rod.group, state.subspan(rod.first, to_index(rod.group->slots())), rod.local.index);
            pass.bind(tile);
            pass.run(tile, nullptr, step_);
        }
    }

    std::vector<Vec3d> strains(std::span<const Slot<1>> state) const override {
        std::vector<Vec3d> all(slots_, Vec3d{0, 0, 0});
        for (const Rod& rod : rods_) {
            if (!rod.group->strained()) continue;
            const Slot<1>* slot = state.data() + rod.first;
            for (int k = 0; k < rod.group->elements(); ++k)
                all[rod.first + to_index(k)] =
                    nth(rod.group->element, k).inv_rest_length *
                    (lane(slot[k].director, 0) * (lane(slot[k + 1].position, 0) - lane(slot[k].position, 0)));
        }
        return all;
    }

    void set_joint_memory(std::span<const double> memory) override {
        joint_memory_.assign(memory.begin(), memory.end());
    }
    std::vector<double> joint_memory_at(std::span<const Slot<1>> state, bool slips) override {
        std::vector<double> numbers;
        for (const Cluster& cluster : clusters_) {
            if (!remembers(cluster)) continue;
            place_all(cluster, state);
            lead_memory(cluster, slips);
            for (const P& number : memory_) numbers.push_back(number[0]);
        }
        return numbers;
    }
    std::span<const double> joint_memory() const override { return joint_memory_; }
    std::vector<double> joint_memory_of(std::size_t i) override {
        std::vector<double> numbers;
        if (const Cluster* cluster = cluster_of(i)) {
            recall(*cluster);
            if (joints_rub_) end_step(*cluster);
            else take_steps(*cluster);
            cluster->joints->append_memory(memory_.data(), true, joined_rod(i), numbers);
        }
        return numbers;
    }
    void set_joint_memory_of(std::size_t i, std::span<const double> numbers) override {
        const Cluster* cluster = cluster_of(i);
        if (!cluster) return;
        std::vector<double> own;
        const std::size_t packs = cluster->joints->memory_packs(true);
        memory_.assign(packs, P(0.0));
        cluster->joints->append_memory(memory_.data(), true, joined_rod(i), own);
        if (own.empty() || numbers.size() < own.size()) return;
        joint_memory_.resize(clusters_.back().memory + clusters_.back().joints->memory_packs(true));
        for (std::size_t n = 0; n < packs; ++n) memory_[n] = P(joint_memory_[cluster->memory + n]);
        cluster->joints->restore(memory_.data(), true, joined_rod(i), numbers.last(own.size()));
        for (std::size_t n = 0; n < packs; ++n) joint_memory_[cluster->memory + n] = memory_[n][0];
    }
    std::size_t turning_motors() const override { return turning_.size(); }
    Vec3d motor_angle(std::size_t i, double time) const override {
        return turning_[i].first.motors_at(time, turning_[i].second).value;
    }
    JointStiffness stiffest_joint() const override { return stiffest_; }

    bool rubs() const override { return !reference_.empty(); }
    bool joints_rub() const override { return joints_rub_; }
    void set_reference(std::span<const Slot<1>> state) override {
        if (std::any_of(rods_.begin(), rods_.end(), [](const Rod& rod) { return rod.rubbing != nullptr; }))
            reference_.assign(state.begin(), state.end());
        joints_rub_ = joints_have_friction_;
    }
    void take_friction(bool acts) override { rubs_ = acts; }
    void keep_springs() override {
        for (Rod& rod : rods_)
            if (rod.rubbing) rod.springs = memory_of(rod);
    }
    std::vector<double> wall_memory(std::size_t i) const override { return rods_[i].springs; }
    void set_wall_memory(std::size_t i, std::span<const double> numbers) override {
        if (rods_[i].rubbing) rods_[i].springs.assign(numbers.begin(), numbers.end());
    }

    void evaluate(std::span<const Slot<1>> state, std::span<const Vec3d> carried, bool with_stiffness,
                  StaticLoads& out) override {
        out.force.assign(slots_, Vec3d{0, 0, 0});
        out.couple.assign(slots_, Vec3d{0, 0, 0});
        out.force_size.assign(slots_, 0);
        out.couple_size.assign(slots_, 0);
        out.row.clear();
        out.couplings.clear();
        if (with_stiffness) out.row.resize(slots_);
        for (Rod& rod : rods_) {
            const bool asked = out.share.has(rod.first);
            if (asked) add_internal(rod, state, carried, out);
            // Memory at walls is kept for all rods.
            if (rod.passes.empty() || !(asked || rod.rubbing)) continue;
            if (!(asked && with_stiffness)) place(rod, state);
            add_passes(rod, state, asked && with_stiffness, out);
        }
        for (const Cluster& cluster : clusters_) add_joints(cluster, state, with_stiffness, out);
    }

    void evaluate_damping(std::span<const Slot<1>> state, StaticLoads& out) override {
        out.force.assign(slots_, Vec3d{0, 0, 0});
        out.couple.assign(slots_, Vec3d{0, 0, 0});
        out.force_size.assign(slots_, 0);
        out.couple_size.assign(slots_, 0);
        out.row.assign(slots_, StiffnessRow{});
        out.couplings.clear();
        prepare(short_step_, short_step_);
        for (const Rod& rod : rods_) place(rod, state);
        const std::vector<Vec3d> strain = strains(state);
        along_rates_ = true;
        for (Rod& rod : rods_) {
            add_rates_of_kicks(rod, strain, out);
            for (const pass::Filter& filter : rod.filters) add_filter(rod, filter, state, out);
            if (!rod.passes.empty()) add_passes(rod, state, true, out);
        }
        for (const Cluster& cluster : clusters_) add_joints(cluster, state, true, out);
        along_rates_ = false;
        prepare(step_, rubbing_step_);
    }

private:
    using P = Pack<dual>;

    struct Rod {
        LocalRod local{};
        std::unique_ptr<RodGroup> own; ///< of rods with sizes of their own
        const RodGroup* group = nullptr;
        std::size_t first = 0; ///< slot
        TilePasses<dual> passes;
        std::shared_ptr<WallContactTiles<dual>> walls;
        const TilePass<dual>* rubbing = nullptr; ///< the pass of walls with friction that has memory
        std::vector<double> springs;             ///< memory at walls in the reference state
        std::vector<pass::Filter> filters;
        int reach = 1;               ///< slots to each side of a load that it depends on
        bool far = false;            ///< some load depends on all of them
        std::size_t cluster = alone; ///< whose joints remember
    };
    static constexpr std::size_t alone = static_cast<std::size_t>(-1);
    /// Slots of a copy of an assembly, as its joints have them, and colours of those that are joined.
    struct Cluster {
        const JointsOfCluster<dual>* joints;
        std::vector<std::size_t> rods;                  ///< in the order of their tiles
        std::vector<std::size_t> slot;                  ///< of all rods, by slot of the cluster
        std::vector<std::vector<std::size_t>> partners; ///< slots of the cluster that a slot's loads depend on
        std::vector<int> colour;                        ///< by slot of the cluster; -1 where no joint is
        std::vector<std::size_t> joined;                ///< slots of the cluster that have partners
        int colours = 0;
        Slot<1> world;
        const RodGroup* group; ///< of its first rod
        std::int64_t copy = 0;
        std::size_t memory = 0; ///< first number of its joints' memory
    };

    /// A step over which springs of friction do not change, and regularised friction needs none.
    static constexpr double short_step = 1e-20;

    /// Prepares passes for a step, those of walls with friction that has memory for another.
    void prepare(const Step& step, const Step& rubbing) {
        for (const Rod& rod : rods_)
            for (const auto& pass : rod.passes) pass->prepare({pass.get() == rod.rubbing ? &rubbing : &step, 1});
        for (const auto& [assembly, joints] : joints_) joints->prepare({&step, 1});
    }

    RodTile<dual> tile(const Rod& rod) {
        return {slot_.data() + rod.first,  rod.group->element.data(),
                rod.group->voronoi.data(), rod.group,
                rod.group->elements(),     0,
                {rod.local.index},         1,
                rod.group->slots() - 1};
    }

    void make_passes(Rod& rod, const Plan& plan, const Surroundings& around) {
        const GroupProgram& program = nth(plan.groups, rod.local.group).program;
        if (program.find<pass::Walls>() || program.find<pass::SurfaceWalls>())
            rod.walls = std::make_shared<WallContactTiles<dual>>(*around.walls, *rod.group);
        const bool rubs = rod.walls && std::any_of(rod.walls->acting().begin(), rod.walls->acting().end(), [&](int w) {
                              return nth(around.walls->wall, w).law.friction == ContactFriction::memory;
                          });
        const StaticPassMaker maker(*rod.group, around, rod.walls);
        const RodTile<dual> own = tile(rod);
        if (rod.group->strained() && rod.group->law() == Law::elastica) rod.reach = 2;
        for (const PassSpec& spec : program) {
            if (const auto* filter = spec.get<pass::Filter>();
                filter && filter->rate > 0 && filter->time != FilterTime::before_step) // whose other half is after it
                rod.filters.push_back(*filter);
            std::unique_ptr<TilePass<dual>> pass = PassKinds::make(spec, maker);
            if (!pass) continue;
            if (const auto* apply = spec.get<pass::ApplyLoad>()) rod.far |= apply->load.feels_all_nodes();
            pass->expect(1);
            pass->bind(own);
            if (rubs && (spec.get<pass::Walls>() || spec.get<pass::SurfaceWalls>())) rod.rubbing = pass.get();
            rod.passes.push_back(std::move(pass));
        }
        if (rod.rubbing) rod.springs = memory_of(rod);
    }
    static std::vector<double> memory_of(const Rod& rod) {
        std::vector<double> numbers;
        rod.walls->of_tile(0).append_memory(0, numbers);
        return numbers;
    }

    // Clusters

    static bool turns_to_angles(const JointSpec& table) {
        return turns_freely(table.kind) && (table.axis_law.motor.kind == MotorKind::position ||
                                            table.about_second.motor.kind == MotorKind::position);
    }
    void make_clusters(const JointLists& lists, std::span<const RodGroup> groups, std::span<const LocalRod> owned) {
        for (const JointSpec& table : lists.tables) {
            joints_have_friction_ |= table.has_friction();
            stiffest_ = {std::max(stiffest_.along, table.law.stiffness),
                         std::max(stiffest_.about, table.law.torsional_stiffness)};
            if (turns_to_angles(table) && !table.motors_by_rod()) turning_.emplace_back(table, 0.0);
        }
        std::map<std::pair<int, std::int64_t>, std::size_t> rod_of; // by group and index
        for (std::size_t i = 0; i < owned.size(); ++i) rod_of[{owned[i].group, owned[i].index}] = i;
        for (const AssemblyGroups& assembly : assemblies_of(groups)) {
            const auto& joints = lists.of_assembly[to_index(assembly.assembly)];
            if (joints.empty()) continue;
            const Junctions junctions = junctions_of(lists.tables, joints, groups);
            KickGains gains = gains_by_mass(groups); // which moves of common nodes have, and none is made here
            gains.body = [](int, std::size_t) { return Vec3d{1, 1, 1}; };
            joints_[assembly.assembly] = std::make_unique<JointsOfCluster<dual>>(lists.tables, joints, groups,
                                                                                 assembly.assembly, junctions, gains);
            joints_[assembly.assembly]->hold_motors();
            const RodGroup& leader = *assembly.groups.front();
            for (std::int64_t copy = 0; copy < leader.assembly()->count(); ++copy) {
                if (!rod_of.contains({leader.id(), copy * leader.rods_per_copy()})) continue;
                add_cluster(assembly, copy, lists, joints, junctions, rod_of);
                for (const Joint& joint : joints)
                    if (const JointSpec& table = lists.tables[joint.table];
                        turns_to_angles(table) && table.motors_by_rod())
                        turning_.emplace_back(table, rod_number(joint, groups, copy));
            }
        }
    }

    void add_cluster(const AssemblyGroups& assembly, std::int64_t copy, const JointLists& lists,
                     std::span<const Joint> joints, const Junctions& junctions,
                     const std::map<std::pair<int, std::int64_t>, std::size_t>& rod_of) {
        const std::size_t memory =
            clusters_.empty() ? 0 : clusters_.back().memory + clusters_.back().joints->memory_packs(true);
        Cluster& cluster = clusters_.emplace_back();
        cluster.memory = memory;
        cluster.copy = copy;
        cluster.joints = joints_.at(assembly.assembly).get();
        cluster.group = assembly.groups.front();
        cluster.world = world_of(*cluster.group, copy * cluster.group->rods_per_copy());
        std::map<std::pair<int, std::int64_t>, std::size_t> first; // slot of the cluster, by group and rod of the copy
        for (const RodGroup* group : assembly.groups)
            for (std::int64_t r = 0; r < group->rods_per_copy(); ++r) {
                first[{group->id(), r}] = cluster.slot.size();
                cluster.rods.push_back(rod_of.at({group->id(), copy * group->rods_per_copy() + r}));
                const Rod& rod = rods_[cluster.rods.back()];
                for (std::size_t k = 0; k < to_index(group->slots()); ++k) cluster.slot.push_back(rod.first + k);
            }
        cluster.partners.resize(cluster.slot.size());
        const auto joined = [&](const std::vector<std::size_t>& slots) {
            for (const std::size_t a : slots)
                for (const std::size_t b : slots) cluster.partners[a].push_back(b);
        };
        const auto element = [&](std::vector<std::size_t>& slots, int group, std::int64_t rod, int k) {
            const std::size_t at = first.at({group, rod}) + to_index(k);
            slots.push_back(at);
            const RodGroup& of = group_of(assembly, group);
            if (of.strained()) slots.push_back(at + 1);
        };
        for (const Joint& joint : joints) {
            const JointSpec& table = lists.tables[joint.table];
            if (!has_springs(table)) continue;
            std::vector<std::size_t> slots;
            for (const JointEnd* end : {&joint.first, &joint.second})
                if (!end->of_world()) element(slots, end->group, end->rod, end->element);
            joined(slots);
        }
        for (const Star& star : junctions.stars) {
            std::vector<std::size_t> slots;
            for (const Star::Member& m : star.members) element(slots, m.group, m.rod, m.element);
            joined(slots);
        }
        for (const Hub& hub : junctions.hubs) {
            const Hub::Member& master = hub.members.front();
            const std::size_t at = cluster.slot[first.at({master.group, master.rod}) + to_index(master.node)];
            for (std::size_t i = 1; i < hub.members.size(); ++i) {
                const Hub::Member& m = hub.members[i];
                shared_.push_back({cluster.slot[first.at({m.group, m.rod}) + to_index(m.node)], at, hub.body, m.arm});
            }
        }
        colour(cluster);
        if (!remembers(cluster)) return;
        for (const std::size_t rod : cluster.rods) rods_[rod].cluster = clusters_.size() - 1;
    }
    static const RodGroup& group_of(const AssemblyGroups& assembly, int id) {
        for (const RodGroup* group : assembly.groups)
            if (group->id() == id) return *group;
        throw std::logic_error("a joint to a group outside of its assembly");
    }

    /// Two slots that some load depends on have different colours.
    static void colour(Cluster& cluster) {
        cluster.colour.assign(cluster.slot.size(), -1);
        for (auto& partners : cluster.partners) {
            std::sort(partners.begin(), partners.end());
            partners.erase(std::unique(partners.begin(), partners.end()), partners.end());
        }
        std::vector<std::size_t> taken; // by colour: the last slot that refused it, plus 1
        for (std::size_t s = 0; s < cluster.slot.size(); ++s) {
            if (cluster.partners[s].empty()) continue;
            cluster.joined.push_back(s);
            for (const std::size_t row : cluster.partners[s])
                for (const std::size_t other : cluster.partners[row])
                    if (const int c = cluster.colour[other]; c >= 0) taken[to_index(c)] = s + 1;
            int free = 0;
            while (to_index(free) < taken.size() && taken[to_index(free)] == s + 1) ++free;
            if (to_index(free) == taken.size()) taken.push_back(0);
            cluster.colour[s] = free;
        }
        cluster.colours = static_cast<int>(taken.size());
    }

    // Loads

    /// The state without slopes.
    void place(const Rod& rod, std::span<const Slot<1>> state) {
        for (std::size_t s = rod.first; s < rod.first + to_index(rod.group->slots()); ++s) still(s, state[s]);
    }
    void still(std::size_t s, const Slot<1>& at) {
        slot_[s] = {broadcast<dual>(lane(at.position, 0)), broadcast<dual>(Vec3d{0, 0, 0}),
                    broadcast<dual>(lane(at.director, 0)), broadcast<dual>(Vec3d{0, 0, 0})};
    }
    /// Moves a slot along its unknowns, or along its rates, by a share of each. `element`: it has one.
    void move(std::size_t s, const Slot<1>& at, bool element, double share = 1) {
        still(s, at);
        Vec3<P>& node = along_rates_ ? slot_[s].velocity : slot_[s].position;
        node.x.d.set(0, share);
        node.y.d.set(1, share);
        node.z.d.set(2, share);
        if (!element) return;
        Vec3<P::Slopes> turn{P::Slopes(0.0), P::Slopes(0.0), P::Slopes(0.0)};
        turn.x.set(3, share);
        turn.y.set(4, share);
        turn.z.set(5, share);
        if (along_rates_) slot_[s].spin = {P(0.0, turn.x), P(0.0, turn.y), P(0.0, turn.z)};
        else slot_[s].director = turned_along(lane(at.director, 0), turn);
    }
    /// The couple of a load turns with its own slot.
    bool turns(bool own) const { return own && !along_rates_; }

    void add_internal(const Rod& rod, std::span<const Slot<1>> state, std::span<const Vec3d> carried,
                      StaticLoads& out) const {
        const RodGroup& group = *rod.group;
        if (!group.strained() || group.law() == Law::elastica) return;
        with_energy_law(group.law(), [&]<class L>(L) {
            ElasticTangent<L>::add(group,
                                   {start_wall_frame(group, rod.local.index, step_.time),
                                    end_wall_frame(group, rod.local.index, step_.time)},
                                   state.data() + rod.first, carried.data() + rod.first,
                                   {out.force.data() + rod.first, out.couple.data() + rod.first,
                                    out.force_size.data() + rod.first, out.couple_size.data() + rod.first,
                                    out.row.empty() ? nullptr : out.row.data() + rod.first});
        });
    }

    static void add_loads(StaticLoads& out, std::size_t slot, const Vec3d& force, const Vec3d& couple) {
        out.force[slot] = out.force[slot] + force;
        out.couple[slot] = out.couple[slot] + couple;
        out.force_size[slot] += norm(force);
        out.couple_size[slot] += norm(couple);
    }

    void add_passes(Rod& rod, std::span<const Slot<1>> state, bool with_stiffness, StaticLoads& out) {
        const RodGroup& group = *rod.group;
        const int nodes = group.nodes(), span = rod.far ? nodes : 2 * rod.reach + 1;
        const bool closed = group.closed(), body = !group.strained();
        // The slots that do not fill a round of a ring have colours of their own.
        const int extra = closed ? nodes % span : 0, colours = std::min(nodes, span + extra);
        const auto colour_of = [&](int k) { return k < nodes - extra ? k % span : span + k - (nodes - extra); };
        const bool dead = with_stiffness && none_depends_on_state(rod, state);
        if (dead) with_stiffness = false;
        for (int colour = 0; colour < (with_stiffness ? colours : 1); ++colour) {
            if (with_stiffness)
                for (int k = 0; k < nodes; ++k) {
                    const std::size_t s = rod.first + to_index(k);
                    if (colour_of(k) == colour) move(s, state[s], body || k < group.elements());
                    else still(s, state[s]);
                }
            if (closed) slot_[rod.first + to_index(nodes)] = slot_[rod.first];
            if (!dead) run_passes(rod);
            for (int k = 0; k < nodes; ++k) {
                const std::size_t s = rod.first + to_index(k);
                if (colour == 0) add_loads(out, s, lane(load_[s].force, 0), lane(load_[s].couple, 0));
                if (!with_stiffness) continue;
                if (rod.far) {
                    SlotCoupling& one = out.couplings.emplace_back(SlotCoupling{s, rod.first + to_index(colour), {}});
                    add_slopes(load_[s].force, load_[s].couple, turns(k == colour), one.block);
                    continue;
                }
                for (int offset = -rod.reach; offset <= rod.reach; ++offset) {
                    int column = k + offset;
                    if (closed) column = (column + nodes) % nodes;
                    if (column < 0 || column >= nodes || colour_of(column) != colour) continue;
                    add_slopes(load_[s].force, load_[s].couple, turns(offset == 0), out.row[s].at(offset));
                }
            }
        }
        if (clusters_.empty()) return; // nothing else looks at the slots
        for (int k = 0; k < nodes; ++k) still(rod.first + to_index(k), state[rod.first + to_index(k)]);
        if (closed) slot_[rod.first + to_index(nodes)] = slot_[rod.first];
    }
    /// True where the loads have no slopes as all slots move at once, each by a share of its own, and no couples, which
    /// turn with their elements. Leaves the loads.
    bool none_depends_on_state(Rod& rod, std::span<const Slot<1>> state) {
        const RodGroup& group = *rod.group;
        const int nodes = group.nodes();
        for (int k = 0; k < nodes; ++k) {
            const std::size_t s = rod.first + to_index(k);
            // Shares between 1 and 2 in no order.
            const double share = 1 + std::fmod(0.6180339887498949 * (k + 1), 1.0);
            move(s, state[s], !group.strained() || k < group.elements(), share);
        }
        if (group.closed()) slot_[rod.first + to_index(nodes)] = slot_[rod.first];
        run_passes(rod);
        for (int k = 0; k < nodes; ++k) {
            const SlotLoad<dual>& load = load_[rod.first + to_index(k)];
            if (turns(true) && !zero(lane(load.couple, 0))) return false;
            for (const P* x :
                 {&load.force.x, &load.force.y, &load.force.z, &load.couple.x, &load.couple.y, &load.couple.z})
                for (int j = 0; j < slot_unknowns; ++j)
                    if (x->d[j] != 0) return false;
        }
        return true;
    }
    void run_passes(const Rod& rod) {
        const RodTile<dual> own = tile(rod);
        SlotLoad<dual>* load = load_.data() + rod.first;
        for (int k = 0; k <= own.last; ++k)
            load[k] = {broadcast<dual>(Vec3d{0, 0, 0}), broadcast<dual>(Vec3d{0, 0, 0}), P(1.0)};
        for (const auto& pass : rod.passes) {
            if (along_rates_) {
                if (pass.get() == rod.rubbing) rod.walls->of_tile(0).restore(0, rod.springs);
                pass->run(own, load, short_step_);
            } else if (pass.get() == rod.rubbing && !reference_.empty()) rub(rod, own, load);
            else pass->run(own, load, step_);
        }
        if (rod.group->closed()) load[0].force += load[own.n].force;
    }
    /// Walls over the long step from the reference to the state.
    void rub(const Rod& rod, const RodTile<dual>& own, SlotLoad<dual>* load) {
        const P rate(rubs_ ? 1 / long_step : 0.0);
        const Vec3<P> none{P(0.0), P(0.0), P(0.0)};
        const int nodes = rod.group->nodes();
        for (int k = 0; k <= own.last; ++k) {
            const Slot<1>& then = reference_[rod.first + to_index(k < nodes ? k : 0)];
            own.slot[k].velocity = rate * (own.slot[k].position - broadcast<dual>(lane(then.position, 0)));
            own.slot[k].spin = rate * relative_rotation(own.slot[k].director, broadcast<dual>(lane(then.director, 0)));
        }
        rod.walls->of_tile(0).restore(0, rubs_ ? rod.springs : std::vector<double>(rod.springs.size()));
        rod.rubbing->run(own, load, rubbing_step_);
        for (int k = 0; k <= own.last; ++k) own.slot[k].velocity = own.slot[k].spin = none;
    }

    /// Damping at the rates nu of the kick.                                                           theory.md (24)
    void add_rates_of_kicks(const Rod& rod, std::span<const Vec3d> strain, StaticLoads& out) const {
        const RodGroup& group = *rod.group;
        const DampingRates rates = damping_rates(group, damping_[to_index(rod.local.group)]);
        if (rates.none()) return;
        const auto add = [&](int slot, std::size_t first, const Vec3d& c) {
            StiffnessBlock& block = out.row[rod.first + to_index(slot)].at(0);
            block[first][first] += c.x;
            block[first + 1][first + 1] += c.y;
            block[first + 2][first + 2] += c.z;
        };
        for (int i = 0; i < group.nodes(); ++i) {
            const double c = nth(group.node_mass, i) * nth(rates.node, i);
            add(i, 0, {c, c, c});
        }
        for (int k = 0; k < group.elements(); ++k) {
            const std::size_t s = rod.first + to_index(k);
            Vec3d nu = nth(rates.element, k);
            if (rates.follow_stretch()) {
                const double dilatation = group.law() == Law::elastica ? norm(strain[s]) : strain[s].z;
                nu = nu + dilatation * nth(rates.element_stretched, k);
            }
            add(k, 3, scale(nth(group.element, k).inertia, nu));
        }
    }
    /// Damping by a filter of the rates, which is linear in them: F^p v is the difference of what it leaves with the
    /// shares s = -1/2 and 1/2.                                                                      theory.md (41)
    void add_filter(Rod& rod, const pass::Filter& filter, std::span<const Slot<1>> state, StaticLoads& out) {
        const RodGroup& group = *rod.group;
        const int nodes = group.nodes(), reach = static_cast<int>(std::min<long>(filter.order, nodes)),
                  span = std::min(2 * reach + 1, nodes), extra = group.closed() ? nodes % span : 0;
        const auto colour_of = [&](int k) { return k < nodes - extra ? k % span : span + k - (nodes - extra); };
        const LaplacianFilterPass<dual> less(group, filter.order, filter.rate, std::log(2.0) / filter.rate),
            more(group, filter.order, filter.rate, -std::log(1.5) / filter.rate);
        const RodTile<dual> own = tile(rod);
        std::vector<Slot<dual>> left(to_index(nodes));
        for (int colour = 0; colour < span + extra; ++colour) {
            const auto run = [&](const LaplacianFilterPass<dual>& pass) {
                for (int k = 0; k < nodes; ++k) {
                    const std::size_t s = rod.first + to_index(k);
                    if (colour_of(k) == colour) move(s, state[s], k < group.elements());
                    else still(s, state[s]);
                }
                if (group.closed()) slot_[rod.first + to_index(nodes)] = slot_[rod.first];
                pass.run(own, nullptr, short_step_);
            };
            run(less);
            for (int k = 0; k < nodes; ++k) left[to_index(k)] = slot_[rod.first + to_index(k)];
            run(more);
            for (int k = 0; k < nodes; ++k) {
                const std::size_t s = rod.first + to_index(k);
                const Vec3<P> force =
                    P(-filter.rate * nth(group.node_mass, k)) * (slot_[s].velocity - left[to_index(k)].velocity);
                Vec3<P> couple{P(0.0), P(0.0), P(0.0)};
                if (k < group.elements())
                    couple = scale(broadcast<dual>(-filter.rate * nth(group.element, k).inertia),
                                   slot_[s].spin - left[to_index(k)].spin);
                const bool all = span == nodes;
                for (int at = all ? 0 : k - reach; at <= (all ? nodes - 1 : k + reach); ++at) {
                    const int column = group.closed() ? (at + nodes) % nodes : at;
                    if (column < 0 || column >= nodes || colour_of(column) != colour) continue;
                    SlotCoupling& one = out.couplings.emplace_back(SlotCoupling{s, rod.first + to_index(column), {}});
                    add_slopes(force, couple, false, one.block);
                }
            }
        }
        for (int k = 0; k < nodes; ++k) still(rod.first + to_index(k), state[rod.first + to_index(k)]);
        if (group.closed()) slot_[rod.first + to_index(nodes)] = slot_[rod.first];
    }

    /// Puts a slot of a cluster where the joints look for it.
    void put(const Cluster& cluster, std::size_t s, std::span<const Slot<1>> state, bool moves) {
        const std::size_t at = cluster.slot[s];
        if (moves) move(at, state[at], true);
        else still(at, state[at]);
        cluster_slot_[s] = slot_[at];
    }
    void make_place(const Cluster& cluster) {
        const std::size_t slots = cluster.slot.size();
        cluster_slot_.resize(slots + 1);
        joined_.resize(slots + 1);
        cluster_slot_[slots] = {broadcast<dual>(lane(cluster.world.position, 0)), broadcast<dual>(Vec3d{0, 0, 0}),
                                broadcast<dual>(lane(cluster.world.director, 0)), broadcast<dual>(Vec3d{0, 0, 0})};
    }
    void place_all(const Cluster& cluster, std::span<const Slot<1>> state) {
        make_place(cluster);
        for (std::size_t s = 0; s < cluster.slot.size(); ++s) put(cluster, s, state, false);
    }

    // Memory of joints

    static bool remembers(const Cluster& cluster) { return cluster.joints->memory_packs(true) > 0; }
    /// Null where no joint of the rod's cluster remembers.
    const Cluster* cluster_of(std::size_t rod) const {
        return rods_[rod].cluster == alone ? nullptr : &clusters_[rods_[rod].cluster];
    }
    JoinedRod joined_rod(std::size_t i) const {
        const LocalRod& local = rods_[i].local;
        return {local.group, local.index % rods_[i].group->rods_per_copy(), 0};
    }
    /// Calls f for each memory of free axes in memory_: of an angle or a way, or of a ball.
    template <class F> void for_axes(const Cluster& cluster, F&& f) {
        cluster.joints->for_memories(memory_.data(), [&](JointMemory<P>& own, P* more, const JointSpec& table) {
            f(own.axis);
            if (more && table.kind == JointKind::universal) f(*reinterpret_cast<AxisMemory<P>*>(more));
            if (more && table.kind == JointKind::spherical) f(*reinterpret_cast<BallMemory<P>*>(more));
        });
    }
    /// The memory of joints where it is known, in memory_, so long ago that nothing is left of rates.
    void recall(const Cluster& cluster) {
        constexpr double long_ago = 1e300; // s
        const std::size_t packs = cluster.joints->memory_packs(true);
        memory_.assign(packs, P(0.0));
        for (std::size_t n = 0; n < packs && !joint_memory_.empty(); ++n)
            memory_[n] = P(joint_memory_[cluster.memory + n]);
        cluster.joints->set_rods(memory_.data(), true, {&cluster.copy, 1});
        for_axes(cluster, [&](auto& axis) {
            axis.steps = min(axis.steps, P(1.0));
            axis.interval = P(long_ago);
        });
    }
    /// Memory that the joints in cluster_slot_ leave. None breaks at rest, and a spring of friction at its limit holds.
    void lead_memory(const Cluster& cluster, bool slips) {
        constexpr double margin = 1e-9;
        recall(cluster);
        AlignedVector<P> after = memory_;
        after.swap(memory_);
        run_joints(cluster, after);
        for_axes(cluster, [&](auto& axis) {
            using Axis = std::remove_cvref_t<decltype(axis)>;
            const Axis was = axis;
            axis = reinterpret_cast<const Axis&>(after[to_index(reinterpret_cast<P*>(&axis) - memory_.data())]);
            axis.motor_work = was.motor_work;
            axis.lost_work = was.lost_work;
            if (!slips && was.steps[0] > 0) axis.anchor = was.anchor;
            else if constexpr (std::is_same_v<Axis, AxisMemory<P>>) {
                const P at = detail::with_turns<dual>(axis.position, axis.turns);
                axis.anchor = axis.anchor + P(margin) * (at - axis.anchor);
            }
        });
    }
    /// The memory as a step at rest leaves it to a run.
    void end_step(const Cluster& cluster) {
        for_axes(cluster, [&](auto& axis) { axis.interval = P(dt_); });
    }
    void run_joints(const Cluster& cluster, AlignedVector<P>& memory) {
        cluster.joints->run(cluster_slot_.data(), end_moments(cluster), along_rates_ ? short_step_ : step_,
                            memory.data(), joined_.data(), true);
    }
    /// Takes steps and friction out of memory_, and leaves whole turns and works.
    void take_steps(const Cluster& cluster) {
        for_axes(cluster, [](auto& axis) {
            using Axis = std::remove_cvref_t<decltype(axis)>;
            const Axis was = axis;
            std::fill_n(reinterpret_cast<P*>(&axis), sizeof(Axis) / sizeof(P), P(0.0));
            axis.motor_work = was.motor_work;
            axis.lost_work = was.lost_work;
            if constexpr (std::is_same_v<Axis, AxisMemory<P>>) axis.turns = was.turns;
        });
    }

    void add_joints(const Cluster& cluster, std::span<const Slot<1>> state, bool with_stiffness, StaticLoads& out) {
        place_all(cluster, state);
        recall(cluster);
        if (remembers(cluster) && (along_rates_ || !joints_rub_ || !rubs_)) {
            lead_memory(cluster, false);
            take_steps(cluster);
        }
        const AlignedVector<P> before = memory_;
        const auto asked = [&](std::size_t s) { return out.share.has(cluster.slot[s]); };
        for (int colour = 0; colour < std::max(1, with_stiffness ? cluster.colours : 1); ++colour) {
            const auto moves = [&](std::size_t s) { return with_stiffness && cluster.colour[s] == colour && asked(s); };
            if (colour > 0 && std::none_of(cluster.joined.begin(), cluster.joined.end(), moves)) continue;
            for (const std::size_t s : cluster.joined) put(cluster, s, state, moves(s));
            memory_ = before;
            run_joints(cluster, memory_);
            for (const std::size_t s : cluster.joined) {
                const std::size_t at = cluster.slot[s];
                if (colour == 0) add_joined(out, at, joined_[s]);
                if (!with_stiffness) continue;
                for (const std::size_t column : cluster.partners[s]) {
                    if (!moves(column)) continue;
                    SlotCoupling& coupling = out.couplings.emplace_back(SlotCoupling{at, cluster.slot[column], {}});
                    add_slopes(joined_[s].force, joined_[s].couple, turns(column == s), coupling.block);
                }
            }
        }
    }

    static void add_joined(StaticLoads& out, std::size_t slot, const JoinedLoad<dual>& load) {
        out.force[slot] = out.force[slot] + lane(load.force, 0);
        out.couple[slot] = out.couple[slot] + lane(load.couple, 0);
        out.force_size[slot] += load.force_size;
        out.couple_size[slot] += load.couple_size;
    }

    /// Moments of muscles at the ends of the cluster's rods; null where none act through its joints.
    const EndMoments<dual>* end_moments(const Cluster& cluster) {
        if (!cluster.joints->wants_moments()) return nullptr;
        moments_.assign(cluster.rods.size(), EndMoments<dual>{});
        bool some = false;
        for (std::size_t i = 0; i < cluster.rods.size(); ++i) {
            const Rod& rod = rods_[cluster.rods[i]];
            const RodTile<dual> own = tile(rod);
            for (const auto& pass : rod.passes)
                if (const auto* muscles = dynamic_cast<const MakesEndMoments<dual>*>(pass.get())) {
                    muscles->add_end_moments(own, step_, moments_[i]);
                    some = true;
                }
        }
        return some ? moments_.data() : nullptr;
    }

    double dt_;
    Step step_{}, rubbing_step_{}, short_step_{}; ///< the second of friction with memory, the last of damping
    bool rubs_ = true;
    bool joints_have_friction_ = false, joints_rub_ = false; ///< the second: it acts
    bool along_rates_ = false;                               ///< slots are moved along their rates
    std::vector<std::vector<Damping>> damping_;              ///< by group
    std::vector<Slot<1>> reference_; ///< where springs of friction are known; empty: it does not act
    std::vector<Rod> rods_;
    std::size_t slots_ = 0;
    std::map<int, std::unique_ptr<JointsOfCluster<dual>>> joints_; ///< by assembly
    std::vector<Cluster> clusters_;
    JointStiffness stiffest_;
    std::vector<std::pair<JointSpec, double>> turning_; ///< motors that turn joints to angles, and their rod
    std::vector<double> joint_memory_;                  ///< by cluster, in a state before; empty: none is known
    std::vector<CommonNode> shared_;
    AlignedVector<Slot<dual>> slot_, cluster_slot_;
    AlignedVector<SlotLoad<dual>> load_;
    AlignedVector<JoinedLoad<dual>> joined_;
    AlignedVector<P> memory_;
    AlignedVector<EndMoments<dual>> moments_;
};

} // namespace skein
