// Stages of a run: which one is under way, and where it ends.                                        docs/stages.md
#pragma once

#include "simulation/observation.hpp"
#include "simulation/world.hpp"
#include "time/every.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skein {

class Stages {
public:
    /// `groups`: with all of their rods, from which "auto" follows for all stages.
    Stages(const SceneSpec& scene, std::span<const RodGroup> groups);

    /// Finds the columns that conditions name. Throws InputError where the series has no such column.
    void find_columns(const std::vector<std::string>& names);
    /// Goes on in the stage of which these are the begins of all so far, s; the world is to be that of this stage.
    void go_on(std::vector<double> begins, const World& world);
    /// Changes the world to the scene of the stage. `now`: it begins with the present step, so that walls that it lets
    /// appear must stand clear of bodies, or InputError is thrown and the world stays. Collective.
    void enter(std::vector<double> begins, World& world, bool now = false);
    /// Holds and catches ends as those of these groups. Collective.
    void hold_ends(const std::vector<RodSpec>& like, World& world);
    /// Enters the stage after the present one. Collective.
    void begin_next(World& world);

    /// The scene as written, with numbers in place of "auto".
    const SceneSpec& scene() const { return scene_; }
    const std::vector<RodSpec>& rods() const { return scene_.rods; } ///< of the first stage
    bool any() const { return !scene_.stages.empty(); }
    bool is_last() const { return begins_.size() >= scene_.stages.size(); }
    const std::vector<double>& begins() const { return begins_; }
    std::size_t number() const { return begins_.size() - 1; }
    const StageSpec& spec() const { return scene_.stages[number()]; }

    /// First step after `done` at which its end is to be looked for.
    std::int64_t next(std::int64_t done) const;
    /// Notes whether the stage ends with the present step, as soon as it has been made: forces of the last step are no
    /// part of checkpoints. Collective where the stage has a condition.
    void look(const World& world, Observation& observation);
    /// Reason why the stage ends with the present step; empty: it goes on.
    const std::string& over() const { return over_; }
    void set_over(std::string reason) { over_ = std::move(reason); }

private:
    std::string end(const World& world, Observation& observation) const;

    struct Condition {
        StageEnd end;
        std::size_t column = 0;
    };
    SceneSpec scene_;
    std::vector<double> begins_;                       ///< s
    std::vector<std::optional<Condition>> conditions_; ///< by stage
    std::int64_t begin_ = 0, end_ = Every::never;      ///< steps of the present stage
    std::string over_;
    std::int64_t check_ = 0; ///< steps between two looks at its condition; 0: it has none
};

} // namespace skein
