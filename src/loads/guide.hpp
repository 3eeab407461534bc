// Spring between the first node and a place beside the middle of its rod, which keeps published swimmers on course.
// theory.md (37a)
//   f_0 -= k D (x_0 - x - p(t)),  x = sum_i x_i/(n + 1)        [N] lab; D: directions of the spring
// Source: SophT's FishSwimmingCase, where k = E A of the first element. It has no reaction: momentum along D is not
// conserved. Cost: 3 flop per node.
#pragma once

#include "formula/formula.hpp"
#include "formula/vector_of_time.hpp"
#include "skein/core/error.hpp"
#include "skein/core/fields.hpp"
#include "skein/loads/load.hpp"
#include "skein/tiles/mapping.hpp"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct Guide {
    static constexpr std::string_view kind = "guide";
    static constexpr bool for_rigid_bodies = false, for_rings = false, feels_all_nodes = true;
    double stiffness = 0;           ///< k, N/m
    std::string along = "xyz";      ///< D
    std::vector<std::string> place; ///< p, m

    void fields(FieldVisitor& f) {
        f.visit({.name = "stiffness", .unit = "N/m", .text = "stiffness of the spring", .required = true, .above = 0},
                stiffness);
        f.visit({.name = "along", .text = "lab directions of the pull, such as \"y\" or \"xy\""}, along);
        f.visit({.name = "place",
                 .unit = "m",
                 .text = "three formulas of t: target position of the first node relative to the mean of all nodes of "
                         "its rod, lab frame",
                 .required = true},
                place);
    }
    void use(const FormulaScope& scope) { place_ = std::make_shared<VectorOfTime>(scope, place, "m"); }
    void check(RodSpecs, Objections& objections) const {
        if (along.empty() || along.find_first_not_of("xyz") != along.npos)
            objections.add("along", fmt::format("'{}' names no directions: give letters out of x, y and z", along));
        if (place_) add_faults("place", place_->faults(), objections);
    }
    DragRate largest_stiffness(const RodGroup& group) const { return {stiffness / group.node_mass.front(), 0}; }

    void prepare(std::span<const Step> steps) {
        if (!place_) throw InputError("a load of kind guide whose formulas have not been read");
        pull_ = stiffness * lab_directions(along);
        for (const Step& s : steps) at_[s.slot] = (*place_)(s.time).value;
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        if constexpr (Map::along) {
            for (const LaneRange& range : rod.strands->ranges()) {
                const auto [first, first_lane] = rod.strands->place(range.lane, 0);
                const auto node = [&](int slot) {
                    const auto [row, l] = rod.strands->place(range.lane, slot);
                    return lane(rod.slot[row].position, l);
                };
                const Vec3d pull = pull_on_first(range.group->elements(), node, step);
                set_lane(load[first].force, first_lane, lane(load[first].force, first_lane) - pull);
            }
        } else {
            load[0].force =
                load[0].force - pull_on_first(
                                    rod.n, [&](int i) -> const auto& { return rod.slot[i].position; }, step);
        }
    }

    /// Pull on the first of nodes 0 to n, towards its place beside the middle.
    template <class Node> auto pull_on_first(int n, Node&& node, const Step& step) const {
        auto sum = node(0);
        using V = decltype(sum);
        using N = decltype(sum.x);
        for (int i = 1; i <= n; ++i) sum = sum + node(i);
        const auto same = [](const Vec3d& v) { return V{N(v.x), N(v.y), N(v.z)}; };
        return scale(same(pull_), node(0) - N(1.0 / (n + 1)) * sum - same(at_[step.slot]));
    }

    std::shared_ptr<const VectorOfTime> place_;
    Vec3d at_[Clock::largest_batch];
    Vec3d pull_{0, 0, 0}; ///< k D
};

} // namespace skein
