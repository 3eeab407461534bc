// The solver of one level of instructions (cmake/SkeinKernels.cmake).
#pragma once

#include "fluid/fast_helmholtz.hpp"
#include "fluid/flow.hpp"
#include "fluid/iterated_poisson.hpp"
#include "fluid/pressure_gain.hpp"
#include "fluid/sweeps.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <optional>

namespace skein {

/// Exchanges of ghosts of neighbouring ranks.
class GhostExchange;

class BoxFlow final : public FlowSolver, public PressureInTime {
public:
    BoxFlow(const Communicator& comm, const Threads& threads, const FlowConstants& constants);
    ~BoxFlow() override;

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
    /// Of the velocity component c, of the pressure (c = 3) or of changes of velocities (c - 4), in direction d, at the
    /// lower or the upper face.
    struct Edge {
        double mirrored; ///< ghost = mirrored * inner + fixed; of a normal velocity: fixed at the face itself
        double fixed;
        bool periodic, on_face;
    };
    Edge edge(int c, int d, bool upper) const;
    /// Ghosts that are filled from now on are those of a time, where walls move.
    void go_to(double time) {
        time_ = time;
        oscillation_ = oscillation(constants_, time);
    }
    LineEnds ends(int c, int d) const; ///< of lines of it in direction d
    /// Whether this rank has the lower or the upper end in direction d, where that is no period.
    bool has_end(int d, bool upper) const;
    /// What second differences are multiplied by in rates, 1/s.
    double diffusion() const { return constants_.kinematic_viscosity / (constants_.grid.h * constants_.grid.h); }
    /// Ghosts along x and y of a plane, but for rows of neighbours.
    void fill_plane(int c, double* field, int k) const;
    void fill_planes(int c, double* field) const; ///< beyond the box, along z
    /// All ghosts of velocities but those across periods between ranks. This rank alone.
    void fill_beyond_walls();
    /// Rows and planes of ghosts of fields of component `first` and the next ones, from neighbours and, of planes,
    /// beyond the box. Collective.
    void fill_ghosts(int first, std::span<double* const> fields);
    void fill_pressure(); ///< its ghosts. Collective
    Three<double*> velocities() { return {now_[0].data(), now_[1].data(), now_[2].data()}; }
    class ImplicitResponse;
    /// Stage s of a step from `time` on.
    struct StageOfStep {
        StageFactors factors;
        double whole, end; ///< s; its length, and the time at its end
        bool last;         ///< of the step
    };
    StageOfStep stage_of_step(int s, double time, double dt) const;
    bool implicit() const { return constants_.scheme == FlowScheme::crank_nicolson; }
    /// Behind the last stage of a step, whose pressure has been found.
    void note_pressure_time(double time, double dt);
    void add_to_gain(double times);
    /// A stage, as bodies see it.
    FlowStage forced_stage(const StageOfStep& stage, StageResponse* response = nullptr);
    /// Ghosts along x and y of velocities in those planes for which `of_plane` says so.
    void fill_sides(const std::function<bool(int)>& of_plane);
    /// Bodies in the fluid, after an explicit stage.
    void force(const FlowStage& stage);
    /// Sets the velocity to that of a function, made free of divergence. Collective.
    void sample(const VelocityRow& velocity);
    /// A stage: velocities from now_ to next_, which then change their names. Where viscosity is that of velocities,
    /// ghosts in its planes are left alone.
    template <Viscosity viscosity> void sweep(const StageFactors& factors, double diffusion);
    /// (1 - b sum of second differences) u = f of three fields of component `first` and the next ones, from f to u,
    /// with ghosts in its planes. Collective.
    void diffuse(Three<Field>& fields, int first, double b);
    void add_beyond_walls(int c, double* field, double b) const;
    void step_half_implicit(const StageOfStep& whole, double time, double dt);
    void pass_outflow(double dt);
    /// Makes velocities free of divergence by the gradient of next_[0], which is added to the pressure with `keep`.
    /// Collective.
    void project(double dt, bool keep);
    /// Its two parts, of three fields of component `first` and the next ones.
    void find_correction(Three<Field>& u, int first, double dt, Field& correction);
    void take_gradient(Three<Field>& u, int first, double dt, const Field& correction, bool keep);
    /// Adds so many times (1 - b sum of second differences) correction to the pressure but for its ghosts: what
    /// diffuse() makes of the pressure's gradient is that of the correction. theory.md (86)
    void keep_diffused(const Field& correction, double times, double b);
    template <class Body> void for_planes(int first, int behind, Body&& body) const {
        threads_.for_each(static_cast<std::size_t>(behind - first),
                          [&](std::size_t k, int) { body(first + static_cast<int>(k)); });
    }
    /// body(begin, end) of numbers of fields, of planes with their ghosts and of ghosts.
    template <class Body> void for_whole_planes(Body&& body) const {
        const auto plane = static_cast<std::size_t>(layout_.plane);
        threads_.for_each(static_cast<std::size_t>(layout_.nz + 2 * FieldLayout::ghosts),
                          [&](std::size_t k, int) { body(k * plane, (k + 1) * plane); });
    }
    Communicator comm_;
    const Threads& threads_;
    FlowConstants constants_;
    Pencils pencils_;
    FieldLayout layout_;
    Three<Field> now_, next_, rate_;
    Field pressure_, correction_;         ///< `correction_`: of what bodies push in implicit stages; none without them
    Field gain_;                          ///< of the pressure in an implicit step; none where nothing asks for it
    std::optional<double> pressure_time_; ///< s, of the pressure; none where bodies began to act in the step
    bool keeps_gain_ = false;
    double gain_times_ = 0;               ///< see Gain; of explicit schemes of next_[0], with which projections end
    std::optional<FastHelmholtz> direct_; ///< this or the next one
    std::vector<Helmholtz>
        equations_; ///< of `direct_`: of the pressure and, where viscosity is implicit, of velocities
    std::optional<IteratedPoisson> iterated_poisson_;
    std::unique_ptr<GhostExchange> ghosts_;
    std::vector<double> speed_; ///< of each plane, the largest
    double time_ = 0;           ///< of ghosts, s
    double oscillation_ = 1;    ///< of walls then
    StageForcing* forcing_ = nullptr;
    bool begun_ = false; ///< rates of a step before are known
};

} // namespace skein
