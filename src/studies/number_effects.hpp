// What numbers of a scene change while its bodies stay where they are at rest: the loads, and quantities themselves.
//   a number by itself     loads of two scenes, with the number less and more
//   stiffness, rest shape  numbers whose changes act on different parts of rods are changed at the same time: 100
//                          values along a rod take a few pairs of scenes
#pragma once

#include "studies/static_slopes.hpp"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skein {

/// A number that is changed to either side.
struct ChangedNumber {
    std::string key;
    double value, step;
};

/// Scenes with a number less and more by these; one of the two is 0 where that side has no scene.
struct NumberSides {
    SceneSpec low, high;
    double less, more;
    double width() const { return more - less; }
};

/// Derivatives by a number, in the same state of the free unknowns.
struct NumberEffect {
    Unknown loads;
    Unknown quantity;
    bool jumps = false; ///< the loads jump at the number, or have another slope to each side: there are no derivatives
};

/// Throws NumericalError: loads jump at the value of a number.
[[noreturn]] void refuse_jump(const std::string& key, double value);
/// Throws InputError, with its key, where a scene accepts no change of a number to either side.
void require_changes(const StaticCase& one, std::span<const ChangedNumber> numbers, const Machine& machine,
                     double time);

class NumberEffects {
public:
    /// `coupled`: pattern of the stiffness in `state`. `time`: of loads and ends, s. All have to outlive it.
    NumberEffects(const Communicator& comm, const Threads& threads, const Machine& machine, double time,
                  const StaticCase& one, const StaticState& state, const Stiffness& coupled)
        : comm_(comm), threads_(threads), machine_(machine), time_(time), one_(one), state_(state), coupled_(coupled),
          friction_(one.system->friction_memory(state)) {}

    /// Effects of all numbers. `observed`: the case. Throws InputError where a scene accepts no change of one.
    std::vector<NumberEffect> find(std::span<const ChangedNumber> numbers, const RestQuantity& quantity,
                                   ObservedCase& observed);

private:
    /// Change of parts of rods.
    struct LocalChange {
        std::size_t number;
        std::vector<int> rows;        ///< unknowns whose loads change, sorted
        std::vector<double> energies; ///< slopes of the observables that are elastic energies
    };
    using Batch = std::vector<const LocalChange*>;

    Unknown residual(const StaticCase& at) const;
    /// True where loads do not change in proportion; `first`, `second`: their first and second difference.
    bool jumps(const Unknown& first, const Unknown& second) const;
    NumberEffect alone(const ChangedNumber& number) const;
    /// None where it changes more than stiffness and rest curvature, or where that acts beyond its place.
    std::unique_ptr<LocalChange> local_change(const ChangedNumber& number, std::size_t place) const;
    bool add_group(const std::string& key, const NumberSides& sides, std::size_t group, LocalChange& change) const;
    bool wants_energies() const;
    bool add_energies(const NumberSides& sides, const RodGroup& group, LocalChange& change) const;
    /// `changed`: slots of the rod.
    void add_rows(std::size_t rod, const std::vector<char>& changed, std::vector<int>& rows) const;
    std::vector<Batch> batches_of(std::span<const std::unique_ptr<LocalChange>> changes) const;
    /// Loads of numbers that change at the same time; false where they are not those of the numbers one by one.
    bool add_batch(const Batch& batch, std::span<const ChangedNumber> numbers, std::vector<NumberEffect>& all) const;

    const Communicator& comm_;
    const Threads& threads_;
    const Machine& machine_;
    double time_;
    const StaticCase& one_;
    const StaticState& state_;
    const Stiffness& coupled_;
    FrictionMemory friction_;
    RestQuantity quantity_;
    Eigen::Index size_ = 0;   ///< of the quantity
    std::size_t columns_ = 0; ///< of observables
};

} // namespace skein
