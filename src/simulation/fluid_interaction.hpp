// The fluid as an interaction: it steps behind the rods, and is kept and shown with them.
#pragma once

#include "fluid/flow.hpp"
#include "immersion/obstacle.hpp"
#include "simulation/interaction.hpp"

namespace skein {

class FluidInteraction final : public Interaction {
public:
    /// Throws InputError where this program has no fluid solver. Collective.
    explicit FluidInteraction(const InteractionParts& parts);

    void follow(const InteractionParts&) override {}
    void drive(const Step& step, Timers& timers) override;
    std::string invalid() const override;
    std::vector<Figure> figures(double lag) const override;
    std::uint64_t digest() const override;
    std::string kept_name() const override { return "fluid"; }
    /// Rows are planes of cells.
    KeptNumbers kept() const override;
    void recall(const KeptNumbers& kept) override;

    /// Of this run: cells times steps of the fluid.
    double cell_steps() const;
    const FlowSolver& flow() const { return *flow_; }

private:
    const Communicator& comm_;
    const Threads& threads_;
    const FluidPlan& plan_;
    std::unique_ptr<FlowSolver> flow_;
    std::unique_ptr<ObstacleForcing> obstacles_; ///< null where there are none
    double time_ = 0;                            ///< of the fluid, s
    std::string failure_;                        ///< why it cannot go on; empty: it can
    std::int64_t steps_ = 0, steps_before_ = 0;  ///< of the fluid since the start; of them, those before this run
};

/// The fluid among them; null where there is none.
FluidInteraction* fluid_of(const Interactions& all);

} // namespace skein
