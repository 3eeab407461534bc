// Balance of bodies at rest as equations of free unknowns: residual and stiffness at a state, and corrections of it.
//                                                                                         theory.md (96)-(98)
#pragma once

#include "contact/static_contacts.hpp"
#include "equilibrium/assembly.hpp"
#include "equilibrium/factor.hpp"
#include "equilibrium/two_level_factor.hpp"
#include "equilibrium/unknowns.hpp"
#include "kernels/static_rods.hpp"

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skein {

/// State of all bodies of a rank, slot by slot, with the strains that Newton's iteration carries along, and with the
/// memory of joints in a state before, no more than half a turn away; empty: none is known.
struct StaticState {
    std::vector<Slot<1>> slot;
    std::vector<Vec3d> strain;
    std::vector<double> joint_memory;
};

/// Springs of friction with memory, and the state where they are known; all empty where none acts.
struct FrictionMemory {
    std::vector<Slot<1>> reference;
    std::vector<std::vector<double>> walls; ///< by rod
    std::vector<SavedContact> contacts;

    bool empty() const { return reference.empty(); }
};

/// Motions of pieces, which nothing connects to others, as rigid bodies, that change no load.
struct NeutralMotions {
    struct Piece {
        std::vector<int> unknowns;
        Eigen::MatrixXd motion; ///< of these unknowns: orthonormal columns

        Unknown part_of(const Unknown& all) const;
    };
    std::vector<Piece> pieces; ///< those that have some
    int asked_in_full = 0;     ///< pieces, or bodies of them, that needed all rows of their stiffness

    Eigen::Index count() const;
    /// As many unknowns, whose being held takes these motions and no other away.
    std::vector<int> pins() const;
    /// Projects these motions out.
    void take_out(Unknown& from) const;
};

class StaticSystem {
public:
    /// `contacts`: null where rods do not touch each other. `ranks`: that solve for these bodies together, see
    /// make_factor().
    StaticSystem(std::span<const RodGroup> groups, std::span<const LocalRod> rods, std::unique_ptr<StaticRods> at_rest,
                 std::unique_ptr<StaticContacts> contacts = nullptr, const Communicator* ranks = nullptr);

    int unknowns() const { return unknowns_.count(); }
    const Unknowns& map() const { return unknowns_; }
    std::size_t first_slot(std::size_t rod) const { return at_rest_->first_slot(rod); }
    std::span<const LocalRod> rods() const { return rods_; }
    const RodGroup& group(std::size_t rod) const { return nth(groups_, rods_[rod].group); }
    double length() const { return length_; } ///< the longest rod, or extent of a body, m

    void set_time(double time) {
        at_rest_->set_time(time);
        if (contacts_) contacts_->set_time(time);
    }
    /// Slot of a node that is more than `distance` away from where it is in `start`; none: -1.
    long gone(const StaticState& state, const StaticState& start, double distance) const;
    /// Diagonal of the box round all nodes, m.
    static double extent(const StaticState& state);
    const Communicator* ranks() const { return ranks_; }
    bool touches() const { return contacts_ != nullptr; }
    /// Many short rods that contacts alone couple, on one rank: iterations cost less than a direct factor.
    bool is_heap() const;
    RodMotions motions_of_rods(const StaticState& state) const;
    /// Friction with memory acts from here on: its springs are those of this state. Without, all friction is left out.
    void set_reference(const StaticState& state);
    /// The springs of friction go on from this state.
    void keep_springs(const StaticState& state);
    /// Joints count whole turns from this state on, and their dry friction has slipped as far as it does here.
    void keep_joints(StaticState& state) const;
    /// The springs of friction, known in this state, and those of another system of the same bodies, which act from
    /// here on.
    FrictionMemory friction_memory(const StaticState& state) const;
    void set_friction_memory(const FrictionMemory& memory);
    StaticRods& at_rest() { return *at_rest_; }
    StaticContacts* contacts() { return contacts_.get(); } ///< null where rods do not touch each other
    /// Held nodes and elements have the places of `start` from here on, to which lead_ends puts them: those of a scene
    /// of which a number has changed.
    void hold_at(const StaticState& start) { held_ = start.slot; }
    /// Puts held parts and moved ends to their places; strains are then those of the state.
    void lead_ends(StaticState& state) const;
    /// Time, `to` or earlier, up to which no end or motor turns by more than `most` rad from time `from` on: one
    /// that turns by more than half a turn at once would leave the rod with less twist, the joint with fewer turns.
    double lead_up_to(double from, double to, double most) const;
    void refresh(StaticState& state) const { state.strain = at_rest_->strains(state.slot); }

    struct Balance {
        Unknown residual;               ///< sum of loads on each free unknown, N and N m
        Stiffness* stiffness = nullptr; ///< until the next balance; null where none was asked for
        double asymmetry = 0;           ///< largest |K - K^T| over the largest |K|
        double force_size = 0;          ///< largest sum of the sizes of forces at a node, N
        double couple_size = 0;         ///< the same of couples at an element, N m
    };
    /// `convex`: the stiffness of contacts is never negative, see StaticContacts::make_convex().
    Balance balance(const StaticState& state, bool with_stiffness, bool convex = false);
    /// Takes [c]/2 of couples that are left beside the loads out of a stiffness without symmetry: those are constant.
    void leave_couples(Balance& balance, const Unknown& left) const;
    /// Forces on nodes and couples on elements as loads on the free unknowns.
    Unknown gathered(const StaticLoads& loads, const StaticState& state) const;
    /// The same in a reference state, where all contacts stick, with the symmetric part of the stiffness if friction
    /// alone has no potential: what is left out changes eigenvalues by its square. Second: its size, as `asymmetry`.
    std::pair<Balance, double> sticking_balance(const StaticState& state);
    bool rubs() const { return at_rest_->rubs() || (contacts_ && contacts_->rubs()); } ///< friction acts
    /// The balance depends on the way there: friction acts, or dry friction of joints.
    bool has_history() const { return rubs() || at_rest_->joints_rub(); }
    /// Largest residual: of forces over force_size, of couples over couple_size and over force times an element.
    double relative(const Balance& balance) const;

    /// Size of a correction: largest displacement over length(), or turn.
    double size(const Unknown& correction) const;
    /// Largest part, up to `share`, of a correction in which no bodies pass through each other.
    double clear_share(const StaticState& state, const Unknown& correction, double share) const;
    /// Displacement with which corrections begin that go downhill, m.
    double first_way() const { return first_way_; }
    /// Largest turn, rad.
    double turn(const Unknown& correction) const;
    void correct(StaticState& state, const Unknown& correction, double share) const;

    /// Masses of nodes and inertias of elements, as the unknowns have them.
    Stiffness mass(const StaticState& state) const;
    /// Minus the derivative of all loads at rest by the rates of the unknowns; entries that are not 0.   theory.md
    /// (107)
    Stiffness damping(const StaticState& state);
    /// Rates of the unknowns in which round rods spin about their own axes; empty where none does, or where they turn
    /// otherwise too.
    Unknown axial_spin(const StaticState& state) const;
    /// Gyroscopic couples of such a spin, by the rates of turns.                                        theory.md (109)
    Stiffness gyroscopic(const Unknown& spin) const;
    /// Eigenvalue well below that of the slowest bending of any rod by itself, 1/s^2.
    double slow_eigenvalue() const { return slow_eigenvalue_; }

    /// `sampled`: a few rows of the stiffness are asked first, which suffice where they resist all motions.
    NeutralMotions neutral(const StaticState& state, const Balance& balance, bool sampled = true) const;
    /// Names a neutral motion: a translation along, or a turn about, an axis, or that of a rod about its own.
    std::string name_of(const NeutralMotions::Piece& piece, const Unknown& along, const StaticState& state) const;
    std::string rod_name(std::size_t rod) const;

private:
    /// Adds a block, or its part between nodes: of the first `count` unknowns of a slot.
    void add_block(Assembly& to, std::size_t row, std::size_t column, const StiffnessBlock& block,
                   std::span<const Slot<1>> state, std::size_t count = slot_unknowns) const;
    void add_blocks(Assembly& to, const StaticState& state) const;
    void add_contacts(const StaticState& state, bool with_stiffness);
    /// Shares loads and stiffness among the ranks: rods without gaps, of about as many slots for each.
    void share_rods(const Communicator& ranks);
    /// Loads of all slots from those of each rank.
    void gather_loads();
    void add_body_turns(const StaticState& state);
    void add_turns_of_bearings(const StaticState& state);
    /// Unknowns of rods that stiffness connects.
    std::vector<std::vector<int>> pieces(const Stiffness& stiffness) const;
    /// A row for each unknown: seven motions, and 0 to fill registers.
    using Motions = Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>;
    using RigidMotions = Eigen::Matrix<double, 1, 7>;
    RigidMotions rigid_motions(int unknown, const Vec3d& middle, const StaticState& state) const;
    Eigen::MatrixXd rigid_motions(const std::vector<int>& piece, const StaticState& state) const;
    /// Forces that answer motions, rows of all unknowns, with sums of absolute values; rows that are not 0.
    struct Resistance {
        Motions resisted, terms;
        std::vector<int> rows;
        std::vector<std::uint8_t> met; ///< by unknown: it is among them
        std::vector<int> place;        ///< by unknown: in a sample; -1: it is not there
    };
    Unknowns::Moves moves(const Unknown& correction, const StaticState& state) const {
        return unknowns_.moves({correction.data(), static_cast<std::size_t>(correction.size())}, state.slot);
    }
    void choose_sample();
    /// True where rows of the sample alone show that stiffness resists all rigid motions of these unknowns.
    bool sample_resists(const std::vector<int>& piece, const StaticState& state, const Balance& balance,
                        Resistance& work) const;
    Eigen::MatrixXd sampled_resistance(const std::vector<int>& piece, const std::vector<int>& sample,
                                       const Vec3d& middle, const StaticState& state, const Balance& balance,
                                       Resistance& work) const;
    bool add_neutral(std::vector<int> piece, const StaticState& state, const Balance& balance, Resistance& work,
                     NeutralMotions& found) const;
    Vec3d centre(const std::vector<int>& piece, const StaticState& state) const;
    const Slot<1>& slot(int unknown, const StaticState& state) const {
        const auto place = unknowns_.place(unknown);
        return state.slot[first_slot(place.rod) + to_index(place.slot)];
    }

    std::span<const RodGroup> groups_;
    std::vector<LocalRod> rods_;
    std::unique_ptr<StaticRods> at_rest_;
    Unknowns unknowns_;
    std::vector<Slot<1>> held_; ///< places of held parts; empty: where they are
    std::unique_ptr<StaticContacts> contacts_;
    const Communicator* ranks_;
    StaticLoads loads_;
    StaticContactLoads touching_;
    SlotShare share_;                          ///< of this rank
    std::vector<std::int64_t> slots_of_ranks_; ///< empty: each rank has loads and stiffness of all rods
    Assembly assembly_;
    bool all_gripped_ = false;          ///< no rod moves as a rigid body
    std::vector<std::uint8_t> sampled_; ///< by unknown: near an end, or near what is held
    double length_ = 0, element_ = 0;
    double slow_eigenvalue_ = 0;
    double first_way_ = HUGE_VAL; ///< m
    double least_force_ = 0; ///< N: a thousandth of what bends the longest rod by its length; without rods, of joints
};

/// Bodies as a scene places them.
StaticState start_of(const StaticSystem& system, std::span<const RodGroup> groups, std::span<const LocalRod> rods);

} // namespace skein
