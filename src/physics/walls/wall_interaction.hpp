// Walls as an interaction: rods push them in a pass of their own (contact/wall_pass.hpp); here servos answer, and their
// figures are read.
#pragma once

#include "contact/servo.hpp"
#include "coupling/interaction.hpp"
#include "skein/core/index.hpp"

namespace skein {

class WallInteraction final : public Interaction {
public:
    explicit WallInteraction(const InteractionParts& parts);

    void rebind(const InteractionParts& parts) override;
    bool couples() const override { return ends_every_step(); }
    bool ends_every_step() const override { return !driven_.empty(); }
    std::int64_t meeting_after(std::int64_t done) const override { return driven_.empty() ? Every::never : done + 1; }
    void begin(const Step& first, Timers&) override { walls_->state_time = first.begin + 0.5 * first.dt; }
    void end_step(const Step& step, Timers& timers) override;
    void watch(const Step& step) override;
    Ending ending() const override;
    std::string invalid() const override;
    Touch strongest_touch(std::int64_t gid) const override;
    std::span<OverlapWatch> overlaps() override { return overlaps_; }
    std::vector<Figure> figures(const Sample&) const override;
    std::string saved_name() const override { return "walls"; }
    /// Per driven wall its work, how many numbers its servo has, and these.
    SavedNumbers saved() const override;
    void restore(const SavedNumbers& kept) override;
    /// Memory of the rods' local()[i] at all walls; empty where none acts on it.
    std::vector<double> memory(std::size_t i) const;
    void set_memory(std::size_t i, std::span<const double> numbers);

private:
    struct DrivenWall {
        int wall, watched;
        Servo servo;
    };

    /// Those of local()[i]; null where no wall acts.
    WallContacts* contacts_of(std::size_t i) const { return wall_contacts_[rods_->place(i).program].get(); }
    const Wall& wall(const DrivenWall& driven) const { return nth(walls_->wall, driven.wall); }

    const Communicator comm_;
    const Rods* rods_;
    std::shared_ptr<Walls> walls_;
    std::vector<std::shared_ptr<WallContacts>> wall_contacts_; ///< by program; null where no wall acts
    std::vector<OverlapWatch> overlaps_;                       ///< by wall
    std::vector<DrivenWall> driven_;
    std::vector<double> work_; ///< of every wall on the rods since the start, J
    std::vector<std::vector<double>>
        pressing_; ///< scratch: per driven wall, forces on the watched one, then powers of its own
};

/// Walls among them; null where there are none.
WallInteraction* walls_of(const Interactions& all);

} // namespace skein
