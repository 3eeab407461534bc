// Implicit steps as an interaction: the number of parts that steps are cut into, from step to step and across restarts.
#pragma once

#include "coupling/interaction.hpp"

#include <nlohmann/json.hpp>

namespace skein {

class ImplicitInteraction final : public Interaction {
public:
    /// `allowed`: error of positions in a step, m; 0: none is asked for. `length`: largest of the scene, m.
    ImplicitInteraction(double allowed, double length) : control_(allowed), length_(length) {}

    void rebind(const InteractionParts&) override {}
    StepControl* step_control() override { return &control_; }
    std::string progress() const override {
        return control_.parts() > 1 ? "  parts " + std::to_string(control_.parts()) : std::string();
    }
    void summarise(nlohmann::ordered_json& summary) const override {
        summary["implicit"] = {{"parts", control_.parts()}, {"error_of_a_step", control_.error() / length_}};
    }
    std::string advice() const override {
        return "an implicit step does not converge: integrator = \"implicit_damped\", a larger time.tolerance, or a "
               "given, smaller time.dt may do";
    }
    std::string saved_name() const override { return "implicit"; }
    SavedNumbers saved() const override { return {.name = saved_name(), .numbers = control_.numbers()}; }
    void restore(const SavedNumbers& saved) override { control_.set(saved.numbers); }

private:
    StepControl control_;
    double length_;
};

} // namespace skein
