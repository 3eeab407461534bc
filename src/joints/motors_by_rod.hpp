// Motors whose formulas hold the number of a rod, W joints side by side. Values that change with the rod alone are
// computed when the joints are laid out, values of time alone once a step, and the rest joint by joint.
#pragma once

#include "core/rotation.hpp"
#include "formula/evaluate.hpp"
#include "joints/joint_spec.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace skein {

/// The formula of a motor: its value and rate, three numbers each.
template <int W> class MotorByRod {
    using P = Pack<W>;

public:
    explicit MotorByRod(const FormulaProgram& program) : program_(program) {}

    /// Packs that a joint, or W of them side by side, keep.
    std::size_t places() const { return program().place.outputs.size(); }
    /// Computes the values that change with the rod alone, `to` [places()].
    void place(const P& rod, P* to) const {
        run(
            program().place, [&](int) -> const P* { return &rod; }, to);
    }
    /// Values of time alone.
    std::vector<double> at(double time) const {
        const P now(time);
        AlignedVector<P> packs(program().time.outputs.size());
        run(
            program().time, [&](int) -> const P* { return &now; }, packs.data());
        std::vector<double> values;
        for (const P& pack : packs) values.push_back(pack[0]);
        return values;
    }
    /// Value and rate at a time, from at() and place(); `to` [6].
    void values(const std::vector<double>& of_time, const P* places, P* to) const {
        std::array<P, InstructionList::most_sources> now;
        for (std::size_t i = 0; i < of_time.size(); ++i) now[i] = P(of_time[i]);
        run(
            program().state,
            [&](int input) {
                return input >= place_base ? places + (input - place_base) : &now[to_index(input - time_base)];
            },
            to);
    }

private:
    const FormulaProgram& program() const { return program_.get(); }
    /// Runs a list at one place: input(number) is where an input is.
    template <class Input> void run(const InstructionList& list, Input&& input, P* to) const {
        StripRegisters<W> registers;
        std::array<P, InstructionList::most_sources> same;
        std::array<Strided<W>, InstructionList::most_sources> source;
        spread_constants<W>(list, same.data(), source.data());
        for (std::size_t i = 0; i < list.inputs.size(); ++i)
            source[to_index(list.first_input()) + i] = {input(list.inputs[i]), 0};
        evaluate<W>(list, program().tables, source.data(), registers, 1);
        for (std::size_t o = 0; o < list.outputs.size(); ++o) to[o] = nth(source, list.outputs[o])[0];
    }

    std::reference_wrapper<const FormulaProgram> program_;
};

/// Motors of the joints of a table at a time, but for what changes from rod to rod.
struct MotorsAtTime {
    MotorsNow<double> same;                   ///< of axes whose motor is the same for all rods
    std::array<std::vector<double>, 2> parts; ///< values of time alone, of the first axis and the second
};

/// The motors of a table's joints: of the axis, and of the second axis of a universal joint.
template <int W> class MotorsByRod {
    using P = Pack<W>;

public:
    explicit MotorsByRod(const JointSpec& table) {
        const auto formula = [](const AxisSpec& axis) {
            const FormulaProgram* program = axis.motor.by_rod();
            return program ? std::optional<MotorByRod<W>>(*program) : std::nullopt;
        };
        of_ = {formula(table.axis_law), formula(table.about_second)};
    }

    bool any() const { return of_[0] || of_[1]; }
    std::size_t places() const { return places(0) + places(1); }
    void place(const P& rod, P* to) const {
        for (std::size_t axis = 0; axis < 2; ++axis)
            if (of_[axis]) of_[axis]->place(rod, to + (axis > 0 ? places(0) : 0));
    }
    MotorsAtTime at(const JointSpec& table, double time) const {
        MotorsAtTime now{.same = table.motors_at(time, 0), .parts = {}};
        for (std::size_t axis = 0; axis < 2; ++axis)
            if (of_[axis]) now.parts[axis] = of_[axis]->at(time);
        return now;
    }
    /// `places`: of the joints, from place().
    [[gnu::noinline]] MotorsNow<P> now(const JointSpec& table, const MotorsAtTime& time, const P* places_of) const {
        MotorsNow<P> now = spread(time.same);
        std::array<P, 6> v;
        if (of_[0]) {
            of_[0]->values(time.parts[0], places_of, v.data());
            if (table.kind == JointKind::spherical) return along_own_directions(table, v);
            now.value.x = v[0];
            now.rate.x = v[3];
        }
        if (of_[1]) {
            of_[1]->values(time.parts[1], places_of + places(0), v.data());
            now.value.y = v[0];
            now.rate.y = v[3];
        }
        if (turns_freely(table.kind)) {
            const Quaternion<P> turn = rotation(Vec3<P>{now.value.x, P(0.0), P(0.0)});
            now.cosine = turn.w;
            now.sine = turn.v.x;
        }
        return now;
    }
    /// The same motors in all lanes.
    SKEIN_INLINE static MotorsNow<P> spread(const MotorsNow<double>& one) {
        return {broadcast<W>(one.value), broadcast<W>(one.rate), P(one.cosine), P(one.sine)};
    }

private:
    std::size_t places(std::size_t axis) const { return of_[axis] ? of_[axis]->places() : 0; }
    static MotorsNow<P> along_own_directions(const JointSpec& table, const std::array<P, 6>& v) {
        MotorsNow<P> now;
        for (int l = 0; l < lanes_of<W>; ++l) {
            const MotorsNow<double> own =
                table.along_own_directions({{v[0][l], v[1][l], v[2][l]}, {v[3][l], v[4][l], v[5][l]}});
            set_lane(now.value, l, own.value);
            set_lane(now.rate, l, own.rate);
        }
        return now;
    }

    std::array<std::optional<MotorByRod<W>>, 2> of_;
};

} // namespace skein
