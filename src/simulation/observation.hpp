// Observables of a run: sampled once per step, as outputs and the progress line ask for them.
#pragma once

#include "diagnostics/energy_audit.hpp"
#include "diagnostics/extra_observables.hpp"
#include "diagnostics/probes.hpp"
#include "physics/scene_spec.hpp"
#include "simulation/world.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

class Observation {
public:
    Observation(const World& world, const SceneSpec& scene);

    /// Columns of the series, with units.
    std::vector<std::string> names() const;
    /// Values of the present state. Collective.
    std::vector<double> values() const;
    /// Values of the present step, computed once. Collective.
    const std::vector<double>& sample();
    /// True where the last sample holds numbers.
    bool finite() const;
    /// Speed of the fastest node in the last sample, m/s.
    double speed() const;
    /// Largest turn of neighbouring elements, rad, and axial strain in the last sample; 0 without rods.
    double turn() const;
    double strain() const;

    /// Continues the energy audit of a checkpoint, or begins one here. Collective.
    void begin_audit(World& world, std::optional<double> audited_from);
    /// Before and after all is changed for a stage: the energy that this brings is booked, and the balance goes on.
    /// Collective.
    void leave_stage();
    /// Defect of the balance and energy of contacts now, J, and those of a run that has ended with a stage: a state
    /// does not know the forces of contacts. Collective.
    std::array<double, 2> left() const;
    void set_left(double defect, double contacts) { given_ = {defect, contacts}; }
    void enter_stage(World& world);
    /// Energy that stages have brought so far, J; that of contacts from the first step of a stage on. Collective.
    double stage_work() const;
    void set_stage_work(double work) { stage_work_ = work; }
    /// Energy that the audit began with, J, with that of contacts. Collective.
    std::optional<double> audited_from() const;

private:
    /// Energies and works now, with those of contacts.
    EnergyAudit audit(std::span<const double> observed, double lag) const;
    EnergyAudit audit() const;
    /// True where the audit has the work of a fluid.
    bool books_fluid() const;
    /// True where an audit has what implicit steps take.
    bool books_steps() const;

    const World& world_;
    ObservableSets sets_;
    std::vector<ProbeSpec> probes_;
    bool staged_, gravity_acts_;                 ///< in some stage
    std::optional<double> audited_from_;         ///< J
    double stage_work_ = 0;                      ///< J, without that of contacts as the present stage begins
    EnergyAudit left_;                           ///< as the stage before has ended
    double left_defect_ = 0;                     ///< J
    std::optional<std::array<double, 2>> given_; ///< left() of the run before
    std::optional<double> left_contacts_;        ///< J; none: no stage has begun in this process
    std::vector<double> last_;
    std::int64_t step_ = -1; ///< of last_
};

} // namespace skein
