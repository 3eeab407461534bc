// Wall time between checkpoints: when one is due, and when a run with a time limit must begin its last one.
#pragma once

#include <cstdint>

namespace skein {

/// Each rank has its own; root's, or the worst of all, is what they agree on.
class CheckpointClock {
public:
    /// `every`: s between checkpoints, 0: none by wall time. `began`: wall_seconds() at which the run's time limit
    /// began to count. `bytes`: of the state on this rank, by which a first checkpoint's time is guessed.
    CheckpointClock(double every, double began, double bytes);

    void begin_saving();
    void end_saving();
    /// To be called where ranks meet.
    void update();
    bool due() const;
    /// True if a run that is to end `limit` seconds after it began must stop now: a last checkpoint takes twice the
    /// last one's time, and it may be as long as ever until ranks meet again.
    bool late(double limit) const;
    double every() const { return every_; }

private:
    double every_, began_, last_saved_, last_look_;
    double saving_s_, longest_look_s_ = 0;
    double saving_began_ = 0;
};

} // namespace skein
