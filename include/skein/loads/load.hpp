// A load of the list (loads/load_list.hpp) as a value: the interface for scenes, plans and checks. A load is a plain
// struct with `kind` and `fields()`, and with `add()`, which the step calls (loads/load_pass.hpp). All other members
// are optional:
//   label                                name in plans, where `kind` is not plain enough
//   check(groups, objections) const      objections to its keys, or to the groups that it acts on
//   for_rigid_bodies, for_rings = false  kinds of rods that it does not apply to: such scenes are refused
//   use(names)                           receives the names for formulas of the scene, before all that follows
//   acts_on(rods) const                  false for groups that it does not affect, where it costs nothing
//   largest_rate(group) const            decay rate of a velocity, where it reads velocities: a limit of the step
//   largest_stiffness(group) const       stiffness against positions, over mass, 1/s^2: a limit of the step too
//   fault_at_start(group) const          fault of its values at the start, in words
//   refine(was, now)                     converts lists by element, node or vertex to rods of other elements; says how
//   predicted_ns() const                 time of one core for an element and step, where that is not about 1 ns
//   needs_whole_rods = true              it reads a rod from end to end, which strands do not have
//   tables_by_lane = true                tiles along have its tables of a group (bind_group) rod by rod
//   ignores_motion = true                its load does not change with places, frames and rates
//   feels_all_nodes = true               its load at a node depends on nodes far away
//   acts_last = true                     it reads all other loads: it acts after contacts and walls
// A member of one of these names that cannot be called like this does not compile.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/core/objections.hpp"
#include "skein/rod/rod_spec.hpp"

#include <array>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace skein {

class RodGroup;
struct FormulaScope;
struct Shape;
struct Step;
template <int W> struct RodTile;
template <int W> struct SlotLoad;
template <int W> struct Along;

template <class L>
concept HasFields = requires(L load, FieldVisitor& f) {
    std::string_view(L::kind);
    load.fields(f);
};
template <class L>
concept LoadStruct = HasFields<L> && std::copyable<L>;

/// Decay rate, or stiffness over mass, and the element that has it.
struct DragRate {
    double value = 0; ///< 1/s; 1/s^2
    int element = 0;
};

/// Groups of rods of a scene.
using RodSpecs = std::span<const RodSpec* const>;

/// True for loads with tables of their group.
template <class L> inline constexpr bool keeps_tables_of_group = requires(L l, const RodGroup& g) { l.bind_group(g); };

namespace detail {

template <class L> inline constexpr bool says_tables_by_lane = requires { requires L::tables_by_lane; };
template <class L> inline constexpr bool says_whole_rods = requires { requires L::needs_whole_rods; };
template <class L> inline constexpr bool says_ignores_motion = requires { requires L::ignores_motion; };
template <class L> inline constexpr bool says_all_nodes = requires { requires L::feels_all_nodes; };
template <class L> inline constexpr bool says_acts_last = requires { requires L::acts_last; };
template <class L> inline constexpr bool not_for_rigid_bodies = requires { requires !L::for_rigid_bodies; };
template <class L> inline constexpr bool not_for_rings = requires { requires !L::for_rings; };

template <class L> inline constexpr bool has_tile_data = requires { typename L::template TileData<2>; };
template <class L>
concept AddsAlong = requires(const L l, const RodTile<2>& t, SlotLoad<2>* s, const Step& step) {
    l.template add<2, Along<2>>(t, s, step);
};
template <class L, class Data>
concept AddsDataAlong = requires(const L l, const RodTile<2>& t, const Data& data, SlotLoad<2>* s, const Step& step) {
    l.template add<2, Along<2>>(t, data, s, step);
};
template <class L> consteval bool adds_along() {
    if constexpr (has_tile_data<L>) return AddsDataAlong<L, typename L::template TileData<2>>;
    else return AddsAlong<L>;
}

// Optional members by name, whatever their signature.
template <class L> inline constexpr bool names_label = requires { L::label; };
template <class L> inline constexpr bool names_check = requires { &L::check; };
template <class L> inline constexpr bool names_acts_on = requires { &L::acts_on; };
template <class L> inline constexpr bool names_largest_rate = requires { &L::largest_rate; };
template <class L> inline constexpr bool names_predicted_ns = requires { &L::predicted_ns; };
template <class L> inline constexpr bool names_refine = requires { &L::refine; };
template <class L> inline constexpr bool names_use = requires { &L::use; };
template <class L> inline constexpr bool names_largest_stiffness = requires { &L::largest_stiffness; };
template <class L> inline constexpr bool names_fault_at_start = requires { &L::fault_at_start; };

template <class L> inline constexpr auto words_of_kind = [] {
    std::array<char, L::kind.size()> text{};
    for (std::size_t i = 0; i < text.size(); ++i) text[i] = L::kind[i] == '_' ? ' ' : L::kind[i];
    return text;
}();
template <class L> constexpr std::string_view label_of() {
    if constexpr (names_label<L>) return L::label;
    else return {words_of_kind<L>.data(), words_of_kind<L>.size()};
}

} // namespace detail

/// True for loads whose rods lie across: they say so, or their add() takes no mapping.
template <class L> inline constexpr bool needs_whole_rods = detail::says_whole_rods<L> || !detail::adds_along<L>();

class Load {
public:
    /// Makes the first load of the list, until a scene names another.
    Load();
    template <LoadStruct L> Load(L load) : held_(std::make_unique<Held<L>>(std::move(load))) {}
    Load(const Load& other) : held_(other.held_->copy()) {}
    Load(Load&&) noexcept = default;
    Load& operator=(const Load& other) { return *this = Load(other); }
    Load& operator=(Load&&) noexcept = default;

    /// Name in scenes.
    std::string_view kind() const { return held_->traits().kind; }
    /// Name in plain words.
    std::string_view label() const { return held_->traits().label; }
    /// Number in the list.
    int number() const;
    bool needs_whole_rods() const { return held_->traits().needs_whole_rods; }
    bool keeps_tables_of_group() const { return held_->traits().keeps_tables_of_group; }
    /// True where the step has a limit by its rate or stiffness over the masses of nodes.
    bool limits_step() const { return held_->traits().limits_step; }
    bool has_tables_by_lane() const { return held_->traits().has_tables_by_lane; }
    bool ignores_motion() const { return held_->traits().ignores_motion; }
    bool feels_all_nodes() const { return held_->traits().feels_all_nodes; }
    bool acts_last() const { return held_->traits().acts_last; }

    void fields(FieldVisitor& f) { held_->fields(f); }
    /// Adds objections to its keys, or to the `groups` that it acts on.
    void check(RodSpecs groups, Objections& objections) const;
    bool acts_on(const RodSpec& rods) const { return held_->acts_on(rods); }
    DragRate largest_rate(const RodGroup& group) const { return held_->largest_rate(group); }
    double predicted_ns() const { return held_->predicted_ns(); }
    void use(const FormulaScope& names) { held_->use(names); }
    DragRate largest_stiffness(const RodGroup& group) const { return held_->largest_stiffness(group); }
    std::string fault_at_start(const RodGroup& group) const { return held_->fault_at_start(group); }
    /// Converts lists to a rod of other elements. Returns a note for the author of the scene, or nothing. `was` and
    /// `now` are shapes of the first group that it acts on.
    std::string refine(const Shape& was, const Shape& now) { return held_->refine(was, now); }

    /// The load as an L, or null where it is of another kind.
    template <LoadStruct L> const L* get_if() const {
        return kind() == L::kind ? static_cast<const L*>(std::as_const(*held_).address()) : nullptr;
    }
    template <LoadStruct L> L* get_if() { return kind() == L::kind ? static_cast<L*>(held_->address()) : nullptr; }
    /// The load as an L, which it must be.
    template <LoadStruct L> L& as() { return *get_if<L>(); }
    template <LoadStruct L> const L& as() const { return *get_if<L>(); }

private:
    struct Traits {
        std::string_view kind, label;
        bool needs_whole_rods, keeps_tables_of_group, has_tables_by_lane, limits_step, ignores_motion, feels_all_nodes,
            acts_last, for_rigid_bodies, for_rings;
    };

    class AnyHeld {
    public:
        virtual ~AnyHeld() = default;
        virtual std::unique_ptr<AnyHeld> copy() const = 0;
        virtual const Traits& traits() const = 0;
        virtual void* address() = 0;
        virtual const void* address() const = 0;
        virtual void fields(FieldVisitor& f) = 0;
        virtual void check(RodSpecs groups, Objections& objections) const = 0;
        virtual bool acts_on(const RodSpec& rods) const = 0;
        virtual DragRate largest_rate(const RodGroup& group) const = 0;
        virtual double predicted_ns() const = 0;
        virtual void use(const FormulaScope& names) = 0;
        virtual DragRate largest_stiffness(const RodGroup& group) const = 0;
        virtual std::string fault_at_start(const RodGroup& group) const = 0;
        virtual std::string refine(const Shape& was, const Shape& now) = 0;
    };

    template <class L> static constexpr Traits traits_of{.kind = L::kind,
                                                         .label = detail::label_of<L>(),
                                                         .needs_whole_rods = skein::needs_whole_rods<L>,
                                                         .keeps_tables_of_group = skein::keeps_tables_of_group<L>,
                                                         .has_tables_by_lane = detail::says_tables_by_lane<L>,
                                                         .limits_step = detail::names_largest_rate<L> ||
                                                                        detail::names_largest_stiffness<L>,
                                                         .ignores_motion = detail::says_ignores_motion<L>,
                                                         .feels_all_nodes = detail::says_all_nodes<L>,
                                                         .acts_last = detail::says_acts_last<L>,
                                                         .for_rigid_bodies = !detail::not_for_rigid_bodies<L>,
                                                         .for_rings = !detail::not_for_rings<L>};

    template <class L> class Held final : public AnyHeld {
    public:
        explicit Held(L load) : load_(std::move(load)) {}
        std::unique_ptr<AnyHeld> copy() const override { return std::make_unique<Held>(load_); }
        const Traits& traits() const override { return traits_of<L>; }
        void* address() override { return &load_; }
        const void* address() const override { return &load_; }
        void fields(FieldVisitor& f) override { load_.fields(f); }
        void check(RodSpecs groups, Objections& objections) const override {
            constexpr bool fits = requires { load_.check(groups, objections); };
            static_assert(fits || !detail::names_check<L>, "check(RodSpecs, Objections&) const");
            if constexpr (fits) load_.check(groups, objections);
        }
        bool acts_on(const RodSpec& rods) const override {
            constexpr bool fits = requires { static_cast<bool>(load_.acts_on(rods)); };
            static_assert(fits || !detail::names_acts_on<L>, "bool acts_on(const RodSpec&) const");
            if constexpr (fits) return load_.acts_on(rods);
            else return true;
        }
        DragRate largest_rate(const RodGroup& group) const override {
            constexpr bool fits = requires { DragRate(load_.largest_rate(group)); };
            static_assert(fits || !detail::names_largest_rate<L>, "DragRate largest_rate(const RodGroup&) const");
            if constexpr (fits) return load_.largest_rate(group);
            else return {};
        }
        double predicted_ns() const override {
            constexpr bool fits = requires { double(load_.predicted_ns()); };
            static_assert(fits || !detail::names_predicted_ns<L>, "double predicted_ns() const");
            if constexpr (fits) return load_.predicted_ns();
            else return 1;
        }
        void use([[maybe_unused]] const FormulaScope& names) override {
            constexpr bool fits = requires { load_.use(names); };
            static_assert(fits || !detail::names_use<L>, "use(const FormulaScope&)");
            if constexpr (fits) load_.use(names);
        }
        DragRate largest_stiffness([[maybe_unused]] const RodGroup& group) const override {
            constexpr bool fits = requires { DragRate(load_.largest_stiffness(group)); };
            static_assert(fits || !detail::names_largest_stiffness<L>,
                          "DragRate largest_stiffness(const RodGroup&) const");
            if constexpr (fits) return load_.largest_stiffness(group);
            else return {};
        }
        std::string fault_at_start([[maybe_unused]] const RodGroup& group) const override {
            constexpr bool fits = requires { std::string(load_.fault_at_start(group)); };
            static_assert(fits || !detail::names_fault_at_start<L>,
                          "std::string fault_at_start(const RodGroup&) const");
            if constexpr (fits) return load_.fault_at_start(group);
            else return {};
        }
        std::string refine([[maybe_unused]] const Shape& was, [[maybe_unused]] const Shape& now) override {
            constexpr bool fits = requires { std::string(load_.refine(was, now)); };
            static_assert(fits || !detail::names_refine<L>, "std::string refine(const Shape&, const Shape&)");
            if constexpr (fits) return load_.refine(was, now);
            else return {};
        }

    private:
        L load_;
    };

    std::unique_ptr<AnyHeld> held_;
};

/// Objects to rigid bodies among the groups; `what`, e.g. "a damping of kind \"legacy\"".
void object_to_rigid_bodies(const std::string& what, RodSpecs groups, Objections& objections);

/// Kinds of the loads that scenes know, in the order of the list.
std::span<const std::string_view> load_kinds();
/// Load of kind load_kinds()[number], with its defaults.
Load make_load(int number);

} // namespace skein
