// Joints as an interaction: their forces act within visits to clusters (joints/cluster_joints.hpp); here their energy
// and the gaps that their springs leave are read.
#pragma once

#include "coupling/interaction.hpp"
#include "physics/joints/joint_plan.hpp"

namespace skein {

/// Energies of the joints of own rods, J, and the widest gap between their points, m.
struct JointsNow {
    std::vector<double> energies;
    double gap = 0;
    std::vector<double> motor_works, losses; ///< of free axes since the start, J
    std::vector<double> forces, gaps;        ///< largest of each table, N and m
};
/// `lag`: by which positions are behind the rates, s. This rank alone.
JointsNow joints_now(const JointPlan& plan, std::span<const RodGroup> groups, const Rods& all, const Sample& at_time);

class JointInteraction final : public Interaction {
public:
    JointInteraction(const InteractionParts& parts, const JointPlan& plan)
        : plan_(plan), groups_(parts.groups), rods_(&parts.rods) {}

    void rebind(const InteractionParts& parts) override { rods_ = &parts.rods; }
    std::vector<Figure> figures(const Sample& sample) const override;
    std::string saved_name() const override { return "joints"; }
    /// Joints remember nothing.
    SavedNumbers saved() const override { return {.name = saved_name(), .numbers = {}, .columns = 0, .rows = {}}; }
    void restore(const SavedNumbers&) override {}

private:
    const JointPlan& plan_;
    std::span<const RodGroup> groups_;
    const Rods* rods_;
};

} // namespace skein
