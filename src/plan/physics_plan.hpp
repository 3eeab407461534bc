// One physics of a scene in the plan of a run: its passes and limits in each group, its effect on the step, its cost,
// its lines of the printed plan and its notes. A physics that acts in a run besides its passes is one of
// coupling/interaction.hpp too; one that shares data with passes, of kernels/surroundings.hpp.
#pragma once

#include "skein/rod/rod_group.hpp"

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skein {

struct CoreTables;
struct GroupPlan;
struct Plan;
struct PlanLine;
struct Scheme;

class PhysicsPlan {
public:
    virtual ~PhysicsPlan() = default;

    /// Its part of the plan's line of physics; empty: none.
    virtual std::string summary(const Plan&) const { return {}; }
    /// Its lines, in the order in which they are printed.
    virtual std::vector<PlanLine> describe(const Plan&) const;
    /// True if its lines include an output of the scene's [output].
    virtual bool describes([[maybe_unused]] std::string_view output) const { return false; }
    /// Doubts about what the scene asks for.
    virtual std::vector<std::string> notes(const Plan&, std::span<const RodGroup>) const { return {}; }

    /// Calls for each group, in the order of a plan: numbers that its kick depends on; passes, when it has those of its
    /// own; limits of the step by themselves; effect on those that are there.
    virtual void act_on(GroupPlan&, const RodGroup&) const {}
    virtual void add_passes(GroupPlan&, const RodGroup&) const {}
    virtual void add_limits(GroupPlan&, const RodGroup&) const {}
    virtual void tighten_limits(GroupPlan&, const RodGroup&, const Scheme&) const {}

    /// True if rods get loads from others by slot, for which they show themselves. Several may add them
    /// (SlotLoads::at); one that marks slots by itself comes first in the list.
    virtual bool acts_between_rods() const { return false; }
    /// Times at which rods of all ranks wait for it.
    enum class Coupling { none, at_events, every_step };
    virtual Coupling coupling() const { return Coupling::none; }

    /// Sets the step of a plan by itself, if true.
    virtual bool sets_step(Plan&, const CoreTables&) { return false; }
    /// Divides the interval between outputs, where an automatic step is at most `longest`, s, if true.
    virtual bool divides_interval(Plan&, const CoreTables&, [[maybe_unused]] double longest) { return false; }
    /// The scene gives the step. Throws InputError where that is too long.
    virtual void take_given_step(Plan&, const CoreTables&) {}
    /// Longest automatic step that it accepts, s.
    virtual double longest_step() const { return HUGE_VAL; }

    /// Intervals of outputs of its own, with their names, s.
    virtual std::vector<std::pair<std::string, double>> output_intervals() const { return {}; }
    /// Adds to the bytes of a plan whose step is known.
    virtual void add_bytes(Plan&, std::span<const RodGroup>) {}
    /// Time of one core for an element and step besides that of its passes, ns, and of the whole run, s.
    virtual double ns_per_element() const { return 0; }
    virtual double core_seconds(const Plan&) const { return 0; }
};

} // namespace skein
