// Joints of an assembly over a cluster of tiles (tiles/clusters.hpp), table by table. In a block of copies a joint is
// between the same slots in all lanes. In a copy by itself W joints are gathered from the lanes where their rods are.
// Each slot takes its loads in the order of the joints either way, so the bits are the same.
#pragma once

#include "joints/cluster_junctions.hpp"
#include "joints/joint_events.hpp"
#include "joints/joint_law.hpp"
#include "joints/joint_list.hpp"
#include "joints/joint_node_loads.hpp"
#include "joints/motors_by_rod.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace skein {

template <int W> class JointsOfCluster : public ClusterJoints<W> {
    using P = Pack<W>;
    static constexpr int lanes = lanes_of<W>;
    /// Bodies at rest run joints across, and never within a step: the rest is left out there, as it compiles for long.
    static constexpr bool in_steps = W != dual;

public:
    /// `gains`: of the kicks, where there are junctions.
    JointsOfCluster(std::span<const JointSpec> tables, std::span<const Joint> joints, std::span<const RodGroup> groups,
                    int assembly, const Junctions& junctions = {}, const KickGains& gains = {}) {
        for (const AssemblyGroups& one : assemblies_of(groups))
            if (one.assembly == assembly) lay_out(one, groups.size());
        if (std::any_of(joints.begin(), joints.end(), [](const Joint& joint) { return joint.second.of_world(); })) {
            world_ = true;
            for (Layout* layout : {&across_, &within_}) layout->world = layout->slots++;
        }
        memory_of_group_ = joint_memory_of_groups(tables, joints, groups.size());
        std::map<std::size_t, JointMemoryPlace> tearing; // by joint
        for (std::size_t j = 0; j < joints.size(); ++j) {
            const JointSpec& table = tables[joints[j].table];
            if (!has_springs(table) && !tears(table)) continue;
            if (runs_.empty() || joints[j].table != runs_.back().table) open(joints[j].table, table);
            add(joints[j]);
            if (tears(table)) tearing[j] = state_of_last();
        }
        place_motors_in_memory();
        if (!junctions.empty())
            junctions_.emplace(
                junctions, [&](int group, std::int64_t rod, int slot) { return place(groups, group, rod, slot); },
                gains, tearing);
    }

    bool has_world() const override { return world_; }
    bool shares_nodes() const override { return junctions_.has_value(); }
    bool wants_moments() const override { return junctions_ && junctions_->turns(); }
    void gather(Slot<W>* slot, const P* memory, bool across) const override {
        junctions_->gather(slot, memory, across);
    }
    void move_as_one(Slot<W>* slot, const P* memory, const Step& step, bool across) const override {
        junctions_->move_as_one(slot, memory, step, across);
    }

    void prepare(std::span<const Step> steps) override {
        for (Run& run : runs_)
            if (run.spec.has_motor())
                for (const Step& step : steps) {
                    nth(run.motor, step.slot) = run.motors.at(run.spec, step.time);
                    if (ends_) nth(run.motor_at_end, step.slot) = run.motors.at(run.spec, step.end());
                }
    }
    void use_ends() override { ends_ = true; }
    /// Motors hold the positions that they have at a time, and do not lead on.
    void hold_motors() { at_rest_ = true; }
    void set_rods(P* memory, bool across, std::span<const std::int64_t> copies) const override {
        for (const Run& run : runs_) {
            if (!run.motors.any()) continue;
            const std::size_t count = across ? run.end - run.first : run.end_pack - run.first_pack;
            for (std::size_t i = 0; i < count; ++i) {
                P rod(0.0);
                for (int l = 0; l < lanes; ++l) {
                    const std::size_t j =
                        run.first + (across ? i : std::min(i * to_index(lanes) + to_index(l), run.end - run.first - 1));
                    const std::int64_t copy = copies[across ? std::min(to_index(l), copies.size() - 1) : 0];
                    const auto [group, first] = first_of_[j];
                    rod.set(l, static_cast<double>(copy * nth(rods_of_, group) + first));
                }
                run.motors.place(rod, memory + run.first_place[across ? 0 : 1] + run.motors.places() * i);
            }
        }
    }
    /// f(memory, that of further axes or null, table) for the joints of a copy that remember, across.
    template <class F> void for_memories(P* memory, F&& f) const {
        for (const Run& run : runs_)
            for (std::size_t i = 0; run.numbers > 0 && i < run.end - run.first; ++i) {
                P* own = memory + run.first_memory + run.numbers * i;
                f(*reinterpret_cast<JointMemory<P>*>(own), axes_memory(own, run.more).more, run.spec);
            }
    }
    void run(const Slot<W>* slot, const EndMoments<W>* moments, const Step& step, P* memory, JoinedLoad<W>* load,
             bool across) const override {
        stop_where_left_out(!across);
        std::fill_n(load, across ? across_.slots : within_.slots, JoinedLoad<W>{});
        for (const Run& run : runs_) {
            const At at{slot, run.motor_of(step.slot), step.dt, step.time, memory, load, JointTime::staggered};
            if (across) (this->*run.across)(run, at);
            else (this->*run.within)(run, at);
        }
        if (junctions_) junctions_->add_loads(slot, moments, load, memory, step.dt, across, JointTime::staggered);
        if (!across) fill_spare_lanes(load);
    }
    std::vector<SharedSlot> shared_slots() const override {
        return junctions_ ? junctions_->shared_slots() : std::vector<SharedSlot>();
    }
    Mask<W> goes_along(std::size_t i, const P* memory) const override { return junctions_->goes_along(i, memory); }
    void try_state(const Slot<W>* slot, const EndMoments<W>* moments, const Step& step, const P* memory,
                   JoinedLoad<W>* load) const override {
        stop_where_left_out(true);
        std::fill_n(load, across_.slots, JoinedLoad<W>{});
        for (const Run& run : runs_)
            (this->*run.across)(run, {slot, run.motor_of(step.slot), step.dt, step.time, const_cast<P*>(memory), load,
                                      JointTime::trial});
        if (junctions_)
            junctions_->add_loads(slot, moments, load, const_cast<P*>(memory), step.dt, true, JointTime::trial);
    }
    void begin_step(const Slot<W>* slot, const Step& step, P* memory, JoinedLoad<W>* load) const override {
        for (const Run& run : runs_) {
            if (run.numbers == 0 || tears(run.spec) || step.begin < run.spec.events.from) continue;
            const bool over = is_over(run, step.begin);
            for (std::size_t j = run.first; j < run.end; ++j) {
                const std::size_t at = run.first_memory + run.numbers * (j - run.first);
                const auto is_zero = [](const P& numbers) { return !any(!(abs(numbers) <= P(0.0))); };
                const P& state = reinterpret_cast<const JointMemory<P>*>(memory + at)->state;
                const bool ends = over && any(state < P(1.5)); // with the stage before
                if (!ends && !std::all_of(memory + at, memory + at + run.numbers, is_zero)) continue;
                const MotorsAtTime motors = run.motors.at(run.spec, step.begin);
                Run alone = run;
                alone.first = j;
                alone.end = j + 1;
                alone.first_memory = at;
                alone.first_place[0] += run.motors.places() * (j - run.first);
                (this->*run.across)(alone, {slot, &motors, 0, step.begin, memory, load, JointTime::end});
            }
        }
    }
    void end_step(const Slot<W>* slot, const Step& step, P* memory, JoinedLoad<W>* load) const override {
        for (const Run& run : runs_)
            if (run.numbers > 0)
                (this->*run.across)(
                    run, {slot, run.motor_of(step.slot, true), step.dt, step.end(), memory, load, JointTime::end});
        if (junctions_ && junctions_->tears())
            junctions_->add_loads(slot, nullptr, load, memory, step.dt, true, JointTime::end);
    }
    std::vector<std::vector<std::uint32_t>> joined_slots() const override {
        std::vector<std::vector<std::uint32_t>> all;
        for (const Slots& s : slots_across_) {
            std::vector<std::uint32_t>& of = all.emplace_back(std::vector{s.a, s.a_next, s.b, s.b_next});
            std::sort(of.begin(), of.end());
            of.erase(std::unique(of.begin(), of.end()), of.end());
        }
        if (junctions_) junctions_->append_joined_slots(all);
        return all;
    }

    std::size_t memory_packs(bool across) const override { return packs_[across ? 0 : 1]; }
    void append_memory(const P* memory, bool across, JoinedRod rod, std::vector<double>& numbers) const override {
        const std::size_t end = numbers.size() + memory_of_group_[to_index(rod.group)];
        for_memory(across, rod, [&](std::size_t first, std::size_t count, int lane) {
            for (std::size_t n = first; n < first + count; ++n) numbers.push_back(memory[n][lane]);
        });
        numbers.resize(end, 0.0);
    }
    void restore(P* memory, bool across, JoinedRod rod, std::span<const double> numbers) const override {
        std::size_t at = 0;
        for_memory(across, rod, [&](std::size_t first, std::size_t count, int lane) {
            for (std::size_t n = first; n < first + count; ++n) memory[n].set(lane, numbers[at++]);
        });
    }

private:
    struct Run;
    /// Slots, motor and memory at a step, and the loads to add to.
    struct At {
        const Slot<W>* slot;
        const MotorsAtTime* motor; ///< null without motors
        double h;                  ///< s, since the last step
        double time;               ///< s
        P* memory;
        JoinedLoad<W>* load;
        JointTime state;
    };
    using Kernel = void (JointsOfCluster::*)(const Run&, const At&) const;
    /// Loads of W joints of a table with a memory, which may change it.
    using MemoryLaw = JointNodeLoads<P> (*)(const Run&, const AxisAt<P>&, const At&, const JoinedElement<P>&,
                                            const JoinedElement<P>&, const Quaternion<P>& rest, const P& length,
                                            P* memory);
    struct Run {
        std::size_t table;
        JointSpec spec;
        Kernel across, within;
        MemoryLaw law; ///< null without a memory
        MotorsByRod<W> motors;
        std::size_t first = 0, end = 0;                 ///< range of joints
        std::size_t first_pack = 0, end_pack = 0;       ///< range of packs of W joints
        std::size_t first_memory = 0, first_packed = 0; ///< packs of memory, across and within
        std::size_t numbers = 0, more = 0;              ///< of a joint's memory; of them besides the first axis
        std::array<std::size_t, 2> first_place{};       ///< pack of values that change with the rod, likewise
        std::vector<MotorsAtTime> motor;                ///< by slot of the step; empty: none
        std::vector<MotorsAtTime> motor_at_end;         ///< of implicit steps

        const MotorsAtTime* motor_of(int slot, bool at_end = false) const {
            return motor.empty() ? nullptr : &nth(at_end ? motor_at_end : motor, slot);
        }
    };
    /// Slots of a joint's elements: their nodes, of a body twice the same.
    struct Slots {
        std::uint32_t a, a_next, b, b_next;
    };
    using Lanes = std::array<std::uint8_t, lanes>;
    /// W joints of a copy by itself; the last one fills up.
    struct Gathered {
        std::array<Slots, lanes> slots;
        Lanes lane_a, lane_b;
        int count = 0;
        JointConstants<P> constants;
    };
    /// Layout of the slots of each group's rods in a cluster.
    struct Layout {
        std::vector<std::size_t> first; ///< slot, by group
        std::size_t slots = 0;
        std::size_t world = 0;               ///< slot of the world, the last one, where joints have it
        std::vector<std::size_t> first_tile; ///< by group
        std::size_t tiles = 0;
    };
    struct Spare {
        std::size_t first, slots; ///< range of a tile's slots
        int lanes;                ///< with rods of their own
    };

    void lay_out(const AssemblyGroups& assembly, std::size_t groups) {
        slots_of_.assign(groups, 0);
        rods_of_.assign(groups, 0);
        is_body_.assign(groups, false);
        for (Layout* layout : {&across_, &within_}) {
            layout->first.assign(groups, 0);
            layout->first_tile.assign(groups, 0);
        }
        for (const RodGroup* group : assembly.groups) {
            const std::size_t g = to_index(group->id()), slots = to_index(group->slots());
            const std::int64_t rods = group->rods_per_copy(), tiles = tiles_within(rods, lanes);
            slots_of_[g] = slots;
            rods_of_[g] = rods;
            is_body_[g] = !group->strained();
            for (const auto& [layout, count] : {std::pair(&across_, rods), std::pair(&within_, tiles)}) {
                layout->first[g] = layout->slots;
                layout->first_tile[g] = layout->tiles;
                layout->tiles += to_index(count);
                layout->slots += to_index(count) * slots;
            }
            if (const int taken = static_cast<int>(rods - (tiles - 1) * lanes); taken < lanes)
                spare_.push_back({within_.slots - slots, slots, taken});
        }
    }

protected:
    ClusterPlace place(std::span<const RodGroup> groups, int group, std::int64_t rod, int slot) const {
        const auto g = to_index(group), s = to_index(slot);
        const auto at = [&](const Layout& layout, std::size_t tile) {
            return layout.first[g] + tile * slots_of_[g] + s;
        };
        const auto alone = to_index(rod), shared = to_index(rod / lanes);
        const int l = static_cast<int>(rod % lanes);
        const bool last = rod + 1 == groups[g].rods_per_copy(); // spare lanes repeat it
        return {at(across_, alone),   at(within_, shared),           l,
                last ? lanes : l + 1, across_.first_tile[g] + alone, within_.first_tile[g] + shared};
    }

private:
    void open(std::size_t table, const JointSpec& spec) {
        Run run{table, spec, nullptr, nullptr, nullptr, MotorsByRod<W>(spec)};
        if (spec.has_motor()) {
            run.motor.resize(Clock::largest_batch);
            run.motor_at_end.resize(Clock::largest_batch);
        }
        if (!runs_.empty()) {
            run.first_memory = memory_end(runs_.back(), true);
            run.first_packed = memory_end(runs_.back(), false);
        }
        run.numbers = memory_numbers(spec);
        run.more = run.numbers > 0 ? more_memory_numbers(spec) : 0;
        if (tears(spec)) run.across = run.within = &JointsOfCluster::run_nothing; // the junctions tear
        else if (run.numbers > 0) {
            run.law = memory_law(spec);
            run.across = &JointsOfCluster::template run_memory<true>;
            if constexpr (in_steps) run.within = &JointsOfCluster::template run_memory<false>;
        } else
            with_joint(spec, [&]<JointTurn Turn, bool Damped, bool Repels>() {
                run.across = &JointsOfCluster::template run_springs<true, Turn, Damped, Repels>;
                if constexpr (in_steps)
                    run.within = &JointsOfCluster::template run_springs<false, Turn, Damped, Repels>;
            });
        run.first = run.end = slots_across_.size();
        run.first_pack = run.end_pack = gathered_.size();
        runs_.push_back(std::move(run));
    }
    static MemoryLaw memory_law(const JointSpec& spec) {
        MemoryLaw law = nullptr;
        if (spec.events.any())
            with_event(spec, [&]<JointForm Form, JointTurn Turn>() { law = &event_loads<Form, Turn>; });
        else with_form(spec, [&]<JointForm Form>() { law = &form_loads<Form>; });
        return law;
    }
    static void stop_where_left_out(bool in_step) {
        if (in_step && !in_steps) throw std::logic_error("joints within a step, of bodies at rest");
    }
    void run_nothing(const Run&, const At&) const {}
    /// True where joints of a table have come to their end at a time, to the rounding of times.
    static bool is_over(const Run& run, double time) {
        constexpr double rounding = 1e-12;
        return run.spec.events.until > 0 && time >= (1 - rounding) * run.spec.events.until;
    }
    /// Values of motors that change with the rod lie behind the memory of all joints.
    void place_motors_in_memory() {
        for (std::size_t layout = 0; layout < 2; ++layout) {
            packs_[layout] = runs_.empty() ? 0 : memory_end(runs_.back(), layout == 0);
            for (Run& run : runs_) {
                run.first_place[layout] = packs_[layout];
                packs_[layout] +=
                    run.motors.places() * (layout == 0 ? run.end - run.first : run.end_pack - run.first_pack);
            }
        }
    }
    /// Laws and motors of a run's joint i, or pack i of joints within.
    template <bool Across> AxisAt<P> laws(const Run& run, const At& at, std::size_t i) const {
        MotorsNow<P> motor;
        if (at.motor) {
            if (run.motors.any())
                motor = run.motors.now(run.spec, *at.motor,
                                       at.memory + run.first_place[Across ? 0 : 1] + run.motors.places() * i);
            else motor = MotorsByRod<W>::spread(at.motor->same);
            if (at_rest_ && at.state != JointTime::end) motor.rate = {P(0.0), P(0.0), P(0.0)};
        }
        return {run.spec.law, run.spec.axis_law, run.spec.about_second, motor, at.h, run.spec.to_world(), at.state};
    }
    /// Place of the memory of the last joint that was added.
    JointMemoryPlace state_of_last() const {
        const Run& run = runs_.back();
        const std::size_t i = run.end - run.first - 1;
        return {run.first_memory + run.numbers * i, run.first_packed + run.numbers * (i / lanes),
                static_cast<int>(i % lanes)};
    }
    /// Behind the memory of a run.
    static std::size_t memory_end(const Run& run, bool across) {
        return across ? run.first_memory + run.numbers * (run.end - run.first)
                      : run.first_packed + run.numbers * (run.end_pack - run.first_pack);
    }
    /// f(first, count, lane) for the memory of joints whose first side is this rod. Spare lanes are those of the last
    /// copy.
    template <class F> void for_memory(bool across, JoinedRod rod, F&& f) const {
        for (const Run& run : runs_) {
            if (run.numbers == 0) continue;
            for (std::size_t j = run.first; j < run.end; ++j) {
                if (first_of_[j] != std::pair(rod.group, rod.rod)) continue;
                const std::size_t i = j - run.first;
                if (!across) f(run.first_packed + run.numbers * (i / W), run.numbers, static_cast<int>(i % W));
                else f(run.first_memory + run.numbers * i, run.numbers, rod.lane);
            }
        }
    }
    void add(const Joint& joint) {
        Run& run = runs_.back();
        slots_across_.push_back(slots(joint, across_, 1));
        constants_.push_back(constants_of(joint));
        first_of_.emplace_back(joint.first.group, joint.first.rod);
        run.end = slots_across_.size();
        if (run.end_pack == run.first_pack || gathered_.back().count == lanes) {
            gathered_.emplace_back();
            ++run.end_pack;
        }
        Gathered& pack = gathered_.back();
        for (int l = pack.count; l < lanes; ++l) {
            const auto at = to_index(l);
            pack.slots[at] = slots(joint, within_, lanes);
            pack.lane_a[at] = static_cast<std::uint8_t>(joint.first.rod % lanes);
            pack.lane_b[at] = static_cast<std::uint8_t>(joint.second.rod % lanes);
            set(pack.constants, l, constants_.back());
        }
        ++pack.count;
    }

    Slots slots(const Joint& joint, const Layout& layout, std::int64_t rods_of_tile) const {
        const auto node = [&](const JointEnd& end, int next) {
            if (end.of_world()) return static_cast<std::uint32_t>(layout.world);
            const auto g = to_index(end.group);
            return static_cast<std::uint32_t>(layout.first[g] + to_index(end.rod / rods_of_tile) * slots_of_[g] +
                                              to_index(end.element) + (is_body_[g] ? 0u : static_cast<unsigned>(next)));
        };
        return {node(joint.first, 0), node(joint.first, 1), node(joint.second, 0), node(joint.second, 1)};
    }
    static void set(JointConstants<P>& all, int l, const JointConstants<double>& one) {
        all.share_a.set(l, one.share_a);
        all.share_before_a.set(l, one.share_before_a);
        all.share_b.set(l, one.share_b);
        all.share_before_b.set(l, one.share_before_b);
        set_lane(all.arm_a, l, one.arm_a);
        set_lane(all.axis_a, l, one.axis_a);
        set_lane(all.arm_b, l, one.arm_b);
        set_lane(all.axis_b, l, one.axis_b);
        set_lane(all.rest, l, one.rest);
        all.rest_distance.set(l, one.rest_distance);
    }

    /// An element of a joint. read(slot of Slots, field of Slot): a vector or a quaternion, W joints side by side.
    template <bool Damped, class Read>
    SKEIN_INLINE static JoinedElement<P> element(Read&& read, std::uint32_t Slots::*at, std::uint32_t Slots::*next,
                                                 const P& share, const P& before, const Vec3<P>& arm,
                                                 const Vec3<P>& axis) {
        JoinedElement<P> e{read(at, &Slot<W>::position),
                           read(next, &Slot<W>::position),
                           {},
                           {},
                           read(at, &Slot<W>::director),
                           {},
                           share,
                           before,
                           arm,
                           axis};
        if constexpr (Damped) {
            e.velocity = read(at, &Slot<W>::velocity);
            e.next_velocity = read(next, &Slot<W>::velocity);
            e.spin = read(at, &Slot<W>::spin);
        }
        return e;
    }
    /// Adds loads to the slots of a joint, in one order for all layouts: add_a and add_b (to, load).
    template <class AddA, class AddB> SKEIN_INLINE static void
    scatter(const JointNodeLoads<P>& loads, const Slots& s, JoinedLoad<W>* load, AddA&& add_a, AddB&& add_b) {
        add_a(load[s.a].force, loads.force_a);
        add_a(load[s.a_next].force, loads.force_a_next);
        add_a(load[s.a].couple, loads.couple_a);
        add_b(load[s.b].force, loads.force_b);
        add_b(load[s.b_next].force, loads.force_b_next);
        add_b(load[s.b].couple, loads.couple_b);
        if constexpr (W == dual) {
            const auto note = [](double& size, const Vec3<P>& part) { size += norm(lane(part, 0)); };
            note(load[s.a].force_size, loads.force_a);
            note(load[s.a_next].force_size, loads.force_a_next);
            note(load[s.a].couple_size, loads.couple_a);
            note(load[s.b].force_size, loads.force_b);
            note(load[s.b_next].force_size, loads.force_b_next);
            note(load[s.b].couple_size, loads.couple_b);
        }
    }

    /// Loads of all joints of a run across: law(number, first element, second element, constants).
    template <bool Damped, class Law> SKEIN_INLINE void for_across(const Run& run, const At& at, Law&& law) const {
        for (std::size_t j = run.first; j < run.end; ++j) {
            const Slots& s = slots_across_[j];
            const JointConstants<double>& c = constants_[j];
            const auto read = [&](std::uint32_t Slots::*of, auto field) -> const auto& {
                return at.slot[s.*of].*field;
            };
            const JointNodeLoads<P> loads =
                law(j - run.first,
                    element<Damped>(read, &Slots::a, &Slots::a_next, c.share_a, c.share_before_a, broadcast<W>(c.arm_a),
                                    broadcast<W>(c.axis_a)),
                    element<Damped>(read, &Slots::b, &Slots::b_next, c.share_b, c.share_before_b, broadcast<W>(c.arm_b),
                                    broadcast<W>(c.axis_b)),
                    broadcast<W>(c.rest), P(c.rest_distance));
            const auto add = [](Vec3<P>& to, const Vec3<P>& more) { to += more; };
            scatter(loads, s, at.load, add, add);
        }
    }
    /// Loads of a joint that may not be made yet, or have ended.
    template <JointForm Form, JointTurn Turn> [[gnu::noinline]] static JointNodeLoads<P>
    event_loads(const Run& run, const AxisAt<P>& laws, const At& at, const JoinedElement<P>& first_element,
                const JoinedElement<P>& second_element, const Quaternion<P>& rest, const P& length, P* packs) {
        JoinedElement<P> a = first_element, b = second_element;
        const P one(1.0);
        const JointEvents& events = run.spec.events;
        JointMemory<P>& memory = *reinterpret_cast<JointMemory<P>*>(packs);
        const AxesMemory<P> axes = axes_memory(packs, run.more);
        if (at.time < events.from) return {};
        if constexpr (in_steps)
            if (at.state == JointTime::trial) return tried_event_loads<Form, Turn>(run, laws, a, b, memory, axes);
        const Mask<W> fresh = memory.state < one;
        if (any(fresh)) { // of all copies at once; spare lanes after a restart too
            const JointRest<P> start{a.arm, a.axis, b.arm, b.axis, rest, length};
            memory.made = select_packs<W>(
                fresh, events.from > 0 ? made_here<Form, W>(a, b, run.spec.length > 0, length) : start, memory.made);
            memory.state = max(memory.state, one);
        }
        if (!any(memory.state < P(2.0))) return {};
        a.arm = memory.made.arm_a;
        a.axis = memory.made.axis_a;
        b.arm = memory.made.arm_b;
        b.axis = memory.made.axis_b;
        const AxisMemory<P> before = memory.axis;
        std::array<P, most_more_memory> more_before;
        std::copy_n(axes.more, run.more, more_before.begin());
        const JointNodeLoads<P> loads = [&] {
            if constexpr (Form == JointForm::spring)
                return node_loads<Turn, true, true, W>(run.spec.law, a, b, memory.made.rest, memory.made.length);
            else return node_loads<Form, W>(laws, a, b, memory.made.rest, memory.made.length, axes);
        }();
        const Mask<W> holds = memory.state < P(2.0);
        memory.axis = select_packs<W>(holds, memory.axis, before);
        for (std::size_t n = 0; n < run.more; ++n) axes.more[n] = select(holds, axes.more[n], more_before[n]);
        const P strongest(events.break_force > 0 ? events.break_force : HUGE_VAL);
        const Vec3<P> force = loads.force_a + loads.force_a_next;
        const bool over =
            at.state == JointTime::end ? is_over(run, at.time) : events.until > 0 && at.time >= events.until;
        const Mask<W> ends = over ? holds : holds & (dot(force, force) > strongest * strongest);
        if (any(ends)) { // what its springs hold as the step begins is lost: the step is made without it
            const double back = at.state == JointTime::staggered ? at.h : 0;
            const JoinedElement<P> first = half_a_step_before<W>(a, back), second = half_a_step_before<W>(b, back);
            JointFigures<P> figures;
            JointLoad<P> other;
            AxisMemory<P> last = before;
            AxisAt<P> laws_then = laws;
            laws_then.h = 0;
            const AxesMemory<P> then{last, run.more > 0 ? more_before.data() : nullptr};
            if constexpr (Form == JointForm::spring)
                joint_load<Turn, true, true, W>(run.spec.law, first, second, memory.made.rest, memory.made.length,
                                                other, &figures);
            else node_loads<Form, W>(laws_then, first, second, memory.made.rest, memory.made.length, then, &figures);
            last.lost_work = last.lost_work - figures.energy;
            memory.axis = select_packs<W>(ends, last, memory.axis);
            for (std::size_t n = 0; n < run.more; ++n) axes.more[n] = select(ends, more_before[n], axes.more[n]);
            memory.state = select(ends, P(2.0), memory.state);
        }
        return select_packs<W>(memory.state < P(2.0), loads, JointNodeLoads<P>{});
    }

    /// The same within an implicit step, in which joints are neither made nor ended.
    template <JointForm Form, JointTurn Turn> [[gnu::noinline]] static JointNodeLoads<P>
    tried_event_loads(const Run& run, const AxisAt<P>& laws, JoinedElement<P> a, JoinedElement<P> b,
                      const JointMemory<P>& memory, const AxesMemory<P>& axes) {
        const Mask<W> holds = (memory.state > P(0.5)) & (memory.state < P(1.5));
        if (!any(holds)) return {};
        a.arm = memory.made.arm_a;
        a.axis = memory.made.axis_a;
        b.arm = memory.made.arm_b;
        b.axis = memory.made.axis_b;
        const JointNodeLoads<P> loads = [&] {
            if constexpr (Form == JointForm::spring)
                return node_loads<Turn, true, true, W>(run.spec.law, a, b, memory.made.rest, memory.made.length);
            else return node_loads<Form, W>(laws, a, b, memory.made.rest, memory.made.length, axes);
        }();
        return select_packs<W>(holds, loads, JointNodeLoads<P>{});
    }

    /// Number of a lane that is known only as the program runs.
    SKEIN_INLINE static double& number(P& pack, int lane) {
        assert(0 <= lane && lane < lanes);
        return reinterpret_cast<double*>(&pack)[lane];
    }
    SKEIN_INLINE static double number(const P& pack, int lane) { return number(const_cast<P&>(pack), lane); }

    /// Lane l of the result is lane[l] of at(l).
    template <class At> SKEIN_INLINE static auto gathered(At&& at, const Lanes& lane) {
        using Field = std::remove_cvref_t<decltype(at(0))>;
        const auto part = [&](auto Field::*member) {
            return gathered(
                [&](std::size_t l) -> const auto& { return at(l).*member; }, lane);
        };
        if constexpr (std::is_same_v<Field, P>) {
            if constexpr (lanes == 1) return at(0);
            else {
                std::array<double, lanes> x;
                for (std::size_t l = 0; l < lanes; ++l) x[l] = number(at(l), lane[l]);
                return std::bit_cast<P>(x);
            }
        } else if constexpr (std::is_same_v<Field, Vec3<P>>) {
            return Field{part(&Field::x), part(&Field::y), part(&Field::z)};
        } else {
            return Field{part(&Field::w), part(&Field::v)};
        }
    }

    /// The same for runs within, W joints at a time.
    template <bool Damped, class Law> SKEIN_INLINE void for_within(const Run& run, const At& at, Law&& law) const {
        for (std::size_t i = run.first_pack; i < run.end_pack; ++i) {
            const Gathered& g = gathered_[i];
            const JointConstants<P>& c = g.constants;
            const auto read_by = [&](const Lanes& lane) {
                return [&](std::uint32_t Slots::*of, auto field) {
                    return gathered(
                        [&](std::size_t l) -> const auto& { return at.slot[g.slots[l].*of].*field; }, lane);
                };
            };
            const JointNodeLoads<P> loads = law(i - run.first_pack,
                                                element<Damped>(read_by(g.lane_a), &Slots::a, &Slots::a_next, c.share_a,
                                                                c.share_before_a, c.arm_a, c.axis_a),
                                                element<Damped>(read_by(g.lane_b), &Slots::b, &Slots::b_next, c.share_b,
                                                                c.share_before_b, c.arm_b, c.axis_b),
                                                c.rest, c.rest_distance);
            for (int l = 0; l < g.count; ++l) {
                const auto add_to = [l](int lane) {
                    return [l, lane](Vec3<P>& to, const Vec3<P>& more) {
                        number(to.x, lane) += more.x[l];
                        number(to.y, lane) += more.y[l];
                        number(to.z, lane) += more.z[l];
                    };
                };
                scatter(loads, nth(g.slots, l), at.load, add_to(nth(g.lane_a, l)), add_to(nth(g.lane_b, l)));
            }
        }
    }

    /// Memory of a run's joint i, or pack i of joints within.
    template <bool Across> static P* memory_of(const Run& run, const At& at, std::size_t i) {
        return at.memory + (Across ? run.first_memory : run.first_packed) + run.numbers * i;
    }
    template <bool Across, bool Damped, class Law>
    SKEIN_INLINE void for_joints(const Run& run, const At& at, Law&& law) const {
        if constexpr (Across) for_across<Damped>(run, at, law);
        else for_within<Damped>(run, at, law);
    }
    template <bool Across, JointTurn Turn, bool Damped, bool Repels>
    void run_springs(const Run& run, const At& at) const {
        for_joints<Across, Damped>(
            run, at,
            [&](std::size_t, const auto& a, const auto& b, const auto& rest, const P& length) __attribute__((
                always_inline)) { return node_loads<Turn, Damped, Repels, W>(run.spec.law, a, b, rest, length); });
    }
    template <JointForm Form> static JointNodeLoads<P> form_loads(const Run& run, const AxisAt<P>& laws, const At&,
                                                                  const JoinedElement<P>& a, const JoinedElement<P>& b,
                                                                  const Quaternion<P>& rest, const P& length,
                                                                  P* memory) {
        return node_loads<Form, W>(laws, a, b, rest, length, axes_memory(memory, run.more));
    }
    /// One piece of code for all tables with a memory, whose laws are called.
    template <bool Across> void run_memory(const Run& run, const At& at) const {
        for_joints<Across, true>(
            run, at,
            [&](std::size_t i, const auto& a, const auto& b, const auto& rest,
                const P& length) __attribute__((always_inline)) {
                return run.law(run, laws<Across>(run, at, i), at, a, b, rest, length, memory_of<Across>(run, at, i));
            });
    }

    /// Spare lanes of a tile do what its last rod does.
    void fill_spare_lanes(JoinedLoad<W>* load) const {
        for (const Spare& tile : spare_)
            for (std::size_t k = tile.first; k < tile.first + tile.slots; ++k)
                for (Vec3<P>* v : {&load[k].force, &load[k].couple})
                    for (P* pack : {&v->x, &v->y, &v->z})
                        for (int l = tile.lanes; l < lanes; ++l) number(*pack, l) = number(*pack, tile.lanes - 1);
    }

    bool world_ = false, at_rest_ = false, ends_ = false;
    std::vector<std::size_t> slots_of_;  ///< by group
    std::vector<std::int64_t> rods_of_;  ///< by group, in a copy
    std::array<std::size_t, 2> packs_{}; ///< of a cluster's memory, across and within
    std::vector<bool> is_body_;          ///< by group: its node has no next
    Layout across_, within_;
    std::vector<Spare> spare_;
    std::vector<Run> runs_;
    std::vector<Slots> slots_across_;
    std::vector<JointConstants<double>> constants_;
    std::vector<std::size_t> memory_of_group_;           ///< numbers
    std::vector<std::pair<int, std::int64_t>> first_of_; ///< group and rod of the first side, by joint
    AlignedVector<Gathered> gathered_;
    std::optional<ClusterJunctions<W>> junctions_;
};

} // namespace skein
