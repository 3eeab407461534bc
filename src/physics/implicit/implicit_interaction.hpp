// Implicit steps as an interaction: the number of parts that steps are cut into and the companion that shows their
// error, from step to step and across restarts.
#pragma once

#include "coupling/interaction.hpp"

#include <nlohmann/json.hpp>

namespace skein {

class ImplicitInteraction final : public Interaction {
public:
    struct Needs {
        double tolerance = 0;     ///< error of places that is asked for, over the length; 0: none
        double length = 0;        ///< largest of the scene, m
        bool remembers = false;   ///< joints or walls do
        double way = HUGE_VAL;    ///< of a node in a part of a step, m; infinite where rods touch no others
        double period = HUGE_VAL; ///< shortest of a drive, s
    };
    ImplicitInteraction(const InteractionParts& parts, const Needs& needs);

    void rebind(const InteractionParts& parts) override {
        rods_ = &parts.rods;
        walls_ = parts.around.walls;
    }
    StepControl* step_control() override { return &control_; }
    double fastest() const override;
    std::string fastest_body() const override;
    double way_in_a_part() const override { return way_; }
    void begin_stage() override { companion_.begin_stage(); }
    Companion* companion() override { return tolerance_ > 0 ? &companion_ : nullptr; }
    std::string progress() const override {
        return control_.parts() > 1 ? "  parts " + std::to_string(control_.parts()) : std::string();
    }
    void summarise(nlohmann::ordered_json& summary) const override;
    std::string final_warning() const override;
    /// By what the last attempt failed.
    std::string advice() const override;
    std::string saved_name() const override { return "implicit"; }
    SavedNumbers saved() const override;
    void restore(const SavedNumbers& saved) override;

private:
    const Communicator& comm_;
    const Rods* rods_;
    StepControl control_;
    Companion companion_;
    std::span<const RodGroup> groups_;
    std::shared_ptr<const Walls> walls_; ///< null where there are none
    double tolerance_, length_, way_;
};

} // namespace skein
