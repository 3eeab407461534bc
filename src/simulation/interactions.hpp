// What rods do to each other and what moving walls make of what rods do to them: all that a step needs between its two halves.
#pragma once

#include "contact/contact_limits.hpp"
#include "contact/contact_solver.hpp"
#include "contact/servo.hpp"
#include "core/timer.hpp"
#include "io/checkpoint.hpp"
#include "kernels/kernels.hpp"
#include "parallel/communicator.hpp"
#include "rod/rods.hpp"

#include <memory>
#include <string>
#include <vector>

namespace skein {

/// What presses a rod.
struct Touch {
    double force = 0; ///< N
    std::string text; ///< with whom, and how
};

/// The largest overlap of contacts or with a wall so far.
struct LargestOverlap {
    std::string of;                  ///< "rods" or a wall's name
    double overlap = 0, allowed = 0; ///< over the diameter
    std::int64_t passed = -1;        ///< step that was the first beyond what the time step allows for; -1: none
    double times = 0;                ///< the stiffness, at which the same force would push no deeper than allowed
    double stiffness = 0;            ///< of the law; 0: there are several, or it is said otherwise

    /// What to tell of it, where it has been passed.
    std::string complaint() const;
};

class Interactions {
public:
    /// Collective. `groups`, `threads`, `plan` and `rods` must outlive it.
    Interactions(const Communicator& comm, const Threads& threads, const Plan& plan, std::span<const RodGroup> groups,
                 const Rods& rods, Surroundings around);

    /// When all rods have shown where they are: contacts. Collective, as all that follows.
    void meet(const Step& step, Timers& timers);
    /// After the kick: servos heed what rods did to their walls.
    void steer(const Step& step, Timers& timers);
    /// Every servo that ends the run has done its cycles.
    bool finished() const;

    /// Of this rank's contacts: none so stiff that the step is beyond its limit. Otherwise inspect throws NumericalError and says
    /// so.
    bool fit() const { return complaint().empty(); }
    void inspect(std::int64_t step) const;

    /// The longest step that contacts leave, s, as stiff as this rank's are.
    double step_limit() const;
    /// Of all that touch a rod at the last evaluation what presses it most; no text where nothing does. Collective.
    Touch strongest_touch(std::int64_t gid) const;
    /// Where walls are pressed now: to be told now and then, as contacts tell of themselves in every step.
    void look_at_walls(const Step& step);
    /// Of this rank: something has overlapped by more than the step allows for, and has not been told of.
    bool passed() const;
    /// What is to be told of that, a line for rods and for each wall, each once. Collective.
    std::string tell_of_overlaps();
    /// Of contacts, then of each wall: the largest overlap of this run, over the diameter, but of times with soft_until to come.
    /// Collective.
    std::vector<LargestOverlap> largest_overlaps() const;

    /// What the time series tells of contacts and walls, and of weight where there is any.
    std::vector<std::string> names() const;
    std::vector<double> values() const;

    /// Every contact of the scene, a line each, in order of pairs.
    std::string contact_table() const;

    /// Forces of the last step's contacts on the nodes of a rod of this rank, lab, N: zeros before the first step, and not numbers
    /// before the first one after a checkpoint, which does not keep them.
    void contact_forces(std::int64_t gid, std::span<Vec3d> out) const;
    bool rods_touch() const { return contacts_ != nullptr; }
    /// Null where there are none.
    const Walls* walls() const { return around_.walls.get(); }

    /// Springs of friction, accounts and places of walls, the same on any number of ranks: for checkpoints.
    std::vector<std::string> kept_names() const;
    std::vector<KeptNumbers> kept() const;
    void restore(std::span<const KeptNumbers> kept);

private:
    void know_all_rods();
    void exchange();
    std::string complaint() const;
    /// Sum over all rods, in their order, of their normal forces on a wall, N; or, with `along`, of their forces times that.
    double pressed(int wall, const Vec3d* along = nullptr);
    std::vector<double> contact_numbers() const;
    std::vector<double> wall_numbers() const;

    const Communicator comm_;
    const Plan& plan_;
    std::span<const RodGroup> groups_;
    const Rods& rods_;
    Surroundings around_;
    std::unique_ptr<ContactSolver> contacts_; ///< null where rods do not touch
    bool forces_lost_ = false;                ///< since a checkpoint was loaded
    std::vector<ContactMobility> mobility_;   ///< by group

    struct Deepest {
        double overlap = 0, allowed = 0;
        std::int64_t passed = -1;
        bool told = false;
        void take(double now, std::int64_t step);
    };
    double soft_until_ = 0;           ///< s; the last of the contacts' laws
    Deepest deepest_;                 ///< of contacts
    std::vector<Deepest> deepest_at_; ///< of each wall

    struct DrivenWall {
        int wall, watched;
        Servo servo;
    };
    std::vector<DrivenWall> driven_;
    std::vector<double> work_;   ///< of every wall on the rods since the start, J
    std::vector<double> of_rod_; ///< scratch: by gid

    // Of several ranks: rods of each, and their slots, in the order in which they are sent.
    std::vector<std::vector<std::int64_t>> rods_of_rank_;
    std::vector<std::int64_t> count_of_rank_, slots_of_rank_;
    std::vector<CapsuleSlot> sent_, received_;
};

} // namespace skein
