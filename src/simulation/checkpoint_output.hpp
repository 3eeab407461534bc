// Checkpoints as an output: due at steps, by wall time, and at the end.
#pragma once

#include "simulation/checkpoint_clock.hpp"
#include "simulation/output.hpp"

namespace skein {

class CheckpointOutput final : public Output {
public:
    explicit CheckpointOutput(const OutputParts& parts);

    std::int64_t next(std::int64_t done) const override { return every_.next(done); }
    bool due(const Moment& now) const override;
    /// Flushes the outputs before it in the list, then writes the state. A second call at a step does nothing.
    void write(const Moment& now) override;
    void tick() override;
    bool needs_state_alone() const override { return false; }
    Phase phase() const override { return Phase::checkpoint; }

    void flush_others();
    /// True if a run with a time limit must write its last checkpoint now. Not collective.
    bool late();
    double every_wall() const { return clock_.every(); }
    /// Step and digest of the last checkpoint; -1: none.
    std::int64_t last() const { return last_; }
    std::uint64_t last_digest() const { return digest_; }
    /// After an I/O error: whole frames and the state. Returns a report of it. Collective.
    std::string rescue(const Moment& now);

private:
    void write_state(const Moment& now);

    World& world_;
    const Stages& stages_;
    const Observation& observation_;
    const Outputs& others_;
    const SceneTexts& texts_;
    const RunOptions& options_;
    CheckpointClock clock_;
    Every every_;
    double frames_wall_, flushed_ = 0; ///< s of wall time between flushes, and of the last
    bool save_now_ = false, flush_now_ = false, saving_ = false;
    std::int64_t last_ = -1;
    std::uint64_t digest_ = 0;
};

} // namespace skein
