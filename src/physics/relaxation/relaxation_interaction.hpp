// Relaxation as an interaction: a pass moves rods towards rest (relaxation/relaxation.hpp), and the run ends when all
// have settled.                                                                                       theory.md section
// 21
#pragma once

#include "coupling/interaction.hpp"
#include "relaxation/relaxation_estimate.hpp"

#include <cmath>
#include <memory>

namespace skein {

class RelaxationInteraction final : public Interaction {
public:
    RelaxationInteraction(const InteractionParts& parts, double tolerance)
        : comm_(parts.comm), plan_(parts.plan), residual_(parts.around.residual), tolerance_(tolerance) {}

    void rebind(const InteractionParts& parts) override { residual_ = parts.around.residual; }
    bool couples() const override { return true; }
    std::int64_t next_coupling(std::int64_t done) const override;
    /// Measures the largest correction at steps that are the same on any ranks.
    void end_step(const Step& step, Timers& timers) override;
    void begin_stage() override { correction_ = HUGE_VAL; }
    Ending ending() const override { return settled() ? Ending::now : Ending::not_yet; }
    bool fulfilled() const override { return settled(); }
    std::string progress() const override;
    void summarise(nlohmann::ordered_json& summary) const override;
    std::string report() const override;
    std::string final_warning() const override;
    std::string advice() const override;
    std::string saved_name() const override { return "relaxation"; }
    SavedNumbers saved() const override { return {.name = saved_name(), .numbers = {correction_}}; }
    void restore(const SavedNumbers& saved) override { correction_ = saved.numbers.front(); }

private:
    bool settled() const { return correction_ <= tolerance_; }
    std::string text() const;

    const Communicator& comm_;
    const Plan& plan_;
    std::shared_ptr<const RelaxationResidual> residual_;
    double tolerance_, correction_ = HUGE_VAL; ///< of all rods the largest, over the length and in rad
    std::int64_t step_ = 0;
};

} // namespace skein
