// Steps in a bed as an interaction: the parts that steps are cut into, and what the method takes and adds.
#pragma once

#include "coupling/interaction.hpp"
#include "implicit/bed_figures.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <vector>

namespace skein {

class BedInteraction final : public Interaction {
public:
    /// `allowed`: way of a node in a part of a step, m.
    BedInteraction(const InteractionParts& parts, double allowed);

    void rebind(const InteractionParts& parts) override {
        rods_ = &parts.rods;
        beds_ = parts.around.beds;
        walls_ = parts.around.walls;
    }
    PaceControl* pace_control() override { return &control_; }
    /// Speed of nodes after the last step, or of the states before the first one, and of walls.
    double fastest() const override;
    void end_step(const Step&, Timers&) override { known_ = now(); }
    std::vector<Figure> figures(const Sample&) const override;
    std::string progress() const override {
        return control_.parts() > 1 ? "  parts " + std::to_string(control_.parts()) : std::string();
    }
    void summarise(nlohmann::ordered_json& summary) const override {
        summary["implicit_bed"] = {{"most_parts", control_.most()}, {"parts", control_.made()}};
    }
    std::string advice() const override {
        return "bodies move too fast for steps of \"implicit_bed\": a smaller time.dt, softer starts or \"verlet\" may "
               "do";
    }
    std::string saved_name() const override { return "implicit_bed"; }
    SavedNumbers saved() const override;
    void restore(const SavedNumbers& saved) override;

private:
    double now() const;

    Communicator comm_;
    std::span<const RodGroup> groups_;
    const Rods* rods_;
    std::vector<std::shared_ptr<BedFigures>> beds_;
    std::shared_ptr<const Walls> walls_; ///< null where there are none
    PaceControl control_;
    double mass_ = 0;             ///< of all rods and bodies, kg
    std::optional<double> known_; ///< speed of the fastest node of this rank, m/s; none: to be found from the states
};

} // namespace skein
