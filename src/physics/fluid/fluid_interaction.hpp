// The fluid as an interaction: it steps behind the rods, and is kept and shown with them.
#pragma once

#include "coupling/interaction.hpp"
#include "fluid/flow.hpp"
#include "immersion/immersion.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/fluid/mesh_records.hpp"
#include "time/coupling_schedule.hpp"

#include <limits>
#include <optional>

namespace skein {

/// A face of the box across x, y or z, and where it lies, m.
struct FluidFace {
    int direction = 0;
    bool upper = false;
    double at = 0;
};

class FluidInteraction final : public Interaction {
public:
    /// `plan`: outlives it. Throws InputError where this program has no fluid solver. Collective.
    FluidInteraction(const InteractionParts& parts, const FluidPlan& plan);

    void rebind(const InteractionParts& parts) override;
    bool couples() const override { return true; }
    std::int64_t next_coupling(std::int64_t done) const override;
    void begin(const Step& first, Timers& timers) override;
    std::int64_t meeting_after(std::int64_t done) const override {
        return groups_.empty() || !failure_.empty() ? Every::never : schedule_.end_of_stage(done);
    }
    void begin_again() override;
    bool ends_every_step() const override { return groups_.empty(); }
    void end_step(const Step& step, Timers& timers) override;
    std::string invalid() const override;
    void sum_figures() override {
        if (bodies_) bodies_->sum_loads();
    }
    std::vector<Figure> figures(const Sample&) const override;
    std::uint64_t digest() const override;
    std::string saved_name() const override { return "fluid"; }
    /// Rows are planes of cells.
    SavedNumbers saved() const override;
    void restore(const SavedNumbers& kept) override;

    /// Cells times steps of the fluid in this run.
    double cell_steps() const;
    /// With rods: what fluid.expected_speed, m/s, would have spared this run all steps of the fluid that had to be
    /// shorter than planned; 0: none had to.
    double speed_to_expect() const { return speed_to_expect_; }
    /// Settings with which a run that has failed goes on, or one whose rods feel the fluid and have failed.
    std::vector<std::string> remedies() const override;
    std::string likely_cause() const override {
        return "fluid and rods move faster than steps of the fluid were planned for";
    }
    /// Slip of two-way rods at the end of the last step over the largest speed then, and the largest of this run.
    struct SlipFigures {
        double slip = 0, share = 0, largest_share = 0, allowed = 0; ///< m/s; the others of the speed
    };
    std::optional<SlipFigures> slips() const;
    /// Warning of slips far above the allowed share although steps are as short as they can be; empty: none.
    std::string warning() const;
    const FlowSolver& flow() const { return *flow_; }
    /// Displacement of the box with the rods, m.
    Vec3d box_shift() const { return {static_cast<double>(moved_) * plan_.constants.grid.h, 0, 0}; }

private:
    /// From an end of a step of the run to the next, in steps that are as long as the fluid allows.
    void step_alone(const Step& step);
    /// With rods: how long the next step of the fluid is; false where none is short enough.
    bool choose_part(const Step& first);
    /// Bound of the next step by slip, s, where the largest speed is this. theory.md (95)
    double step_by_slip(double speed, double whole, double shortest) const;
    /// Largest difference of velocities at markers at the end of the last step, m/s.
    double slip() const { return steps_ == steps_before_ ? slip_before_ : bodies_->forcing().slip(); }
    /// Velocity of the flow on the faces of this rank.
    std::array<const double*, 3> velocities() const;
    /// Stage s of a step of the fluid that begins at 0, in steps of rods of dt.
    ForceBalance::Stage stage_of(int s, double dt) const;
    /// Adds the columns of probes.
    void add_probes(std::vector<Figure>& all) const;
    /// Adds the columns of forces and couples on obstacles, groups of rods, and single rods.
    void add_loads(std::vector<Figure>& all) const;
    /// Counts f as Phase::fluid, and what of that was spent at markers as Phase::markers.
    template <class F> void timed(Timers& timers, F&& f);
    /// A stage that rods are about to begin, or have come to the end of.
    void begin_stage(int s, const Step& first);
    void end_stage(int s, const Step& step);
    void fail_at(double limit, double dt);
    void fail_with_rods(double limit, double dt);
    /// The box moves by whole cells to where the middle of all nodes is. Collective.
    void follow_rods();
    void move_box_to(std::int64_t cells);
    static constexpr std::int64_t nobody = std::numeric_limits<std::int64_t>::max();
    /// Own rods as a step of the fluid begins.
    struct RodsInBox {
        double speed = 0; ///< largest sum of components of a node's velocity, or of a body's surface, m/s
        std::int64_t outside =
            nobody; ///< the first in the scene of which a node is beyond a face, if they feel the fluid
        std::size_t rod = 0, node = 0; ///< that one
        FluidFace face;
    };
    RodsInBox rods_in_box() const;
    /// Throws NumericalError on all ranks where the axis of a rod that feels the fluid has left its box. Collective.
    void stop_outside(const RodsInBox& mine, const Step& first) const;
    /// Message for a node of own rod i that is beyond a face.
    std::string text_outside(std::size_t i, std::size_t node, const FluidFace& face, const Step& first) const;

    const Communicator& comm_;
    const Threads& threads_;
    const FluidPlan& plan_;
    CouplingSchedule schedule_; ///< steps of the fluid, in steps of rods
    MeshRecords meshes_;
    std::unique_ptr<FlowSolver> flow_;
    std::span<const RodGroup> groups_;
    std::unique_ptr<Immersion> bodies_;         ///< null where there are none
    bool automatic_dt_;                         ///< the step of rods
    double lag_;                                ///< of positions of rods, s
    double to_ = 0;                             ///< s, end of the interval that forces on them are means of
    std::string failure_;                       ///< why it cannot go on; empty: it can
    std::int64_t steps_ = 0, steps_before_ = 0; ///< of the fluid since the start; of them, those before this run
    std::int64_t begun_ = -1;                   ///< step after which steps began last
    double slip_before_ = 0;                    ///< m/s, at the end of the last step before this run
    double last_length_ = 0;                    ///< s, of the last step; 0: there was none
    double speed_ = 0;                          ///< m/s, the largest when the present step began
    double largest_share_ = 0;                  ///< of slip over speed
    std::string needed_;                        ///< KEY=VALUE that a failure of its own asks for
    double speed_to_expect_ = 0;                ///< m/s
    std::int64_t moved_ = 0;                    ///< cells that the box has moved along x
    std::optional<double> middle_at_start_;     ///< x of the middle of all nodes, m
};

/// The fluid among them; null where there is none.
FluidInteraction* fluid_of(const Interactions& all);

} // namespace skein
