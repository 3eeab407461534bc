// Flow solver of one level of instructions (cmake/SkeinKernels.cmake).
#pragma once

#include "fluid/fast_helmholtz.hpp"
#include "fluid/flow.hpp"
#include "fluid/flow_boundary.hpp"
#include "fluid/iterated_poisson.hpp"
#include "fluid/pressure_gain.hpp"
#include "fluid/sweeps.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <optional>

namespace skein {

class BoxFlow final : public FlowSolver, public PressureInTime {
public:
    BoxFlow(const Communicator& comm, const Threads& threads, const FlowConstants& constants);

    const FlowConstants& constants() const override { return constants_; }
    const Pencils& pencils() const override { return pencils_; }
    using FlowSolver::set_velocity;
    void set_velocity(const VelocityRow& velocity) override;
    void set_forcing(StageForcing* forcing) override;
    void begin_stage(int s, double time, double dt) override;
    void end_stage(int s, double time, double dt) override;
    double step_limit(double courant) const override;
    double largest_speed() const override { return *std::max_element(speed_.begin(), speed_.end()); }
    std::vector<FlowFigures> figures() const override;
    void move_box(int cells) override;
    FieldLayout layout() const override { return layout_; }
    std::span<const double> velocity(int component) const override { return nth(now_, component); }
    std::span<const double> pressure() const override { return pressure_; }
    Gain pressure_gain() const override { return {implicit() ? gain_ : next_[0], keeps_gain_ ? gain_times_ : 0}; }
    void keep_pressure_gain() override;
    std::span<double> restore_pressure_gain(double times) override {
        gain_times_ = times;
        return implicit() ? gain_ : next_[0];
    }
    std::optional<double> pressure_time() const override { return pressure_time_; }
    void set_pressure_time(std::optional<double> time) override {
        pressure_time_ = time;
        gain_times_ = 0;
    }
    std::vector<std::span<double>> state() override;
    double time() const override { return time_; }
    void refresh(double time) override;
    std::size_t bytes() const override;

private:
    using P = Pack<8>;
    using Field = AlignedVector<double>;
    void go_to(double time) {
        time_ = time;
        boundary_.set_oscillation(oscillation(constants_, time));
    }
    /// Factor of second differences in rates, 1/s.
    double diffusion() const { return constants_.kinematic_viscosity / (constants_.grid.h * constants_.grid.h); }
    void fill_pressure(); ///< fills ghosts of the pressure. Collective
    Three<double*> velocities() { return {now_[0].data(), now_[1].data(), now_[2].data()}; }
    class ImplicitResponse;
    /// Stage s of a step from `time` on.
    struct StageOfStep {
        StageFactors factors;
        double whole, end; ///< length, and time at the end, s
        bool last;         ///< last stage of the step
    };
    StageOfStep stage_of_step(int s, double time, double dt) const;
    bool implicit() const { return constants_.scheme == FlowScheme::crank_nicolson; }
    /// Sets the time of the pressure after the last stage of a step.
    void note_pressure_time(double time, double dt);
    void add_to_gain(double times);
    /// Stage for the forcing by bodies.
    FlowStage forced_stage(const StageOfStep& stage, StageResponse* response = nullptr);
    /// Fills ghosts along x and y of velocities in the planes that `of_plane` selects.
    void fill_sides(const std::function<bool(int)>& of_plane);
    /// Applies the forcing by bodies after an explicit stage.
    void force(const FlowStage& stage);
    /// Sets the velocity to a function, made free of divergence. Collective.
    void sample(const VelocityRow& velocity);
    /// Sweeps velocities from now_ to next_ and swaps both. With viscosity of velocities, ghosts are not filled.
    template <Viscosity viscosity> void sweep(const StageFactors& factors, double diffusion);
    /// Solves (1 - b sum of second differences) u = f in place for three fields, the first of number `first`. It fills
    /// ghosts in their planes. Collective.
    void diffuse(Three<Field>& fields, int first, double b);
    void add_beyond_walls(int c, double* field, double b) const;
    void step_half_implicit(const StageOfStep& whole, double time, double dt);
    void pass_outflow(double dt);
    /// Makes velocities free of divergence by the gradient of next_[0], and adds that to the pressure with `keep`.
    /// Collective.
    void project(double dt, bool keep);
    /// Finds the correction for three fields number `first`, first + 1, ... Collective.
    void find_correction(Three<Field>& u, int first, double dt, Field& correction);
    /// Subtracts the gradient of the correction. Collective.
    void take_gradient(Three<Field>& u, int first, double dt, const Field& correction, bool keep);
    /// Adds `times` (1 - b sum of second differences) correction to the pressure without ghosts. diffuse() turns its
    /// gradient into that of the correction. theory.md (86)
    void keep_diffused(const Field& correction, double times, double b);
    template <class Body> void for_planes(int first, int end, Body&& body) const {
        threads_.for_each(to_index(end - first), [&](std::size_t k, int) { body(first + static_cast<int>(k)); });
    }
    /// Calls body(begin, end) with offsets of planes, including ghosts and planes of ghosts.
    template <class Body> void for_whole_planes(Body&& body) const {
        const std::size_t plane = to_index(layout_.plane);
        threads_.for_each(to_index(layout_.nz + 2 * FieldLayout::ghosts),
                          [&](std::size_t k, int) { body(k * plane, (k + 1) * plane); });
    }
    Communicator comm_;
    const Threads& threads_;
    FlowConstants constants_;
    Pencils pencils_;
    FieldLayout layout_;
    Three<Field> now_, next_, rate_;
    Field pressure_;
    Field correction_;                    ///< correction for pushes by bodies in implicit stages; empty without bodies
    Field gain_;                          ///< gain of the pressure in an implicit step; empty unless enabled
    std::optional<double> pressure_time_; ///< time of the pressure, s; absent if bodies began to act in the step
    bool keeps_gain_ = false;
    double gain_times_ = 0; ///< factor of Gain, whose field is next_[0] in explicit schemes
    std::optional<FastHelmholtz> direct_;
    std::vector<Helmholtz> equations_;                ///< pressure and, if viscosity is implicit, velocities
    std::optional<IteratedPoisson> iterated_poisson_; ///< in place of direct_
    FlowBoundary boundary_;
    std::vector<double> speed_; ///< largest speed of each plane, m/s
    double time_ = 0;           ///< time of ghosts, s
    StageForcing* forcing_ = nullptr;
    bool begun_ = false; ///< rates of the step before are known
};

} // namespace skein
