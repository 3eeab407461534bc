// Equilibrium of a scene's bodies: found by Newton's method, reported, and left in the world.
//   piece     a rod, or a copy of an assembly: nothing couples it to others, so that it is solved by itself, on any
//             rank and thread, with the same bits; all bodies, where they may touch each other
//   shared    piece of bodies of several ranks, or a large one: all ranks solve for it together
#pragma once

#include "equilibrium/newton.hpp"
#include "simulation/world.hpp"
#include "studies/shared_bodies.hpp"
#include "studies/solution_watch.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace skein {

/// Bodies that are solved together.
struct StaticPiece {
    std::vector<std::size_t> rods; ///< places in the world's local(); SharedBodies::elsewhere: another rank's
    bool shared = false;
    std::unique_ptr<StaticSystem> system;
    StaticState state;
};

/// Memory of joints by what a run keeps of each body.
std::vector<double> joint_memory_of(StaticRods& at_rest, std::span<const std::vector<double>> kept);
/// Leaves the present memory of joints, whose first side is body i, to rods where the body is at `place`.
void put_joints(StaticRods& at_rest, std::size_t i, Rods& rods, std::size_t place);

class StaticScene {
public:
    /// Bodies as they are now. Collective.
    explicit StaticScene(World& world);

    /// Shared ones first, in the same order on all ranks, then those of this rank.
    std::vector<StaticPiece>& pieces() { return pieces_; }
    const std::vector<StaticPiece>& pieces() const { return pieces_; }
    /// Puts the states into the world, at rest.
    void put_back() const;
    /// Puts them there with the figures of these states under loads of a time, s. `from`: the same bodies where springs
    /// of friction are known, which the states stretch; null: the states are it. Collective.
    void show(double time, const StaticScene* from = nullptr) const;
    /// Springs of friction are those of other pieces of the same bodies.
    void take_springs(const StaticScene& other);
    World& world() const { return world_; }
    /// True where figures of a piece are to be counted by this rank.
    bool counts(const StaticPiece& piece) const { return !piece.shared || world_.comm.root(); }

private:
    /// Adds a piece of these bodies of this rank, places in the world's local().
    void add(std::span<const std::size_t> own, std::span<const RodGroup> groups, bool shared);

    World& world_;
    std::shared_ptr<Walls> walls_;
    std::vector<RodGroup> groups_; ///< of shared pieces, with the places of all bodies
    std::vector<StaticPiece> pieces_;
};

/// Calls act(i) for every piece: for shared ones one after another, then for those of this rank on all threads.
void for_each_piece(StaticScene& scene, const std::function<void(std::size_t)>& act);

/// Equilibria of all pieces on all ranks, with their cost.
struct EquilibriumReport {
    bool found = true;
    double share = 1; ///< least, of the loads that are balanced
    std::int64_t pieces = 0, unknowns = 0;
    std::int64_t load_steps = 0, iterations = 0; ///< most of a piece
    double residual = 0;                         ///< largest, over the acting forces
    std::int64_t unstable = 0;                   ///< pieces whose energy falls in some direction
    double asymmetry = 0;                        ///< largest, of stiffnesses whose symmetric part counts
    std::int64_t unknown_stability = 0;          ///< pieces whose stiffness has no signs to count
    std::int64_t neutral = 0;                    ///< motions that change no load
    std::string neutral_names;                   ///< of the first few
    std::string factor;
    double factor_bytes = 0;      ///< largest of a piece
    std::vector<NewtonPass> last; ///< iterations of the last load step, of the piece with most
    std::string reason;           ///< of the first piece that has none
    double seconds = 0;
};
/// `shown`: prints the progress of a solution that takes long. Throws Stopped where a signal ends it. Collective.
EquilibriumReport find_equilibrium(StaticScene& scene, double time, const NewtonOptions& options, bool shown = false);
/// Makes one correction of each piece, for what it costs. Collective.
SolutionPlan plan_equilibrium(StaticScene& scene, double time, const NewtonOptions& options);
std::string to_text(const EquilibriumReport& report);
/// Reasons, with semicolons between them, each once.
std::string without_repetition(const std::string& reasons);
/// Throws an error of Exit::unstable where a piece is not stable, or not known to be.
void require_stable(const EquilibriumReport& report);

} // namespace skein
