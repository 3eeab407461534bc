// Rods that are joined, as contact sees them: their elements touch, but for those near a joint.
#pragma once

#include "neighbourhood/exposure.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace skein {

/// A place of a joint on one of the bodies of a copy.
struct JoinedPlace {
    int group;
    std::int64_t rod; ///< in the copy
    int element;
    double share; ///< of the element, before the place; of a body 0
    Vec3d arm;    ///< from there to the place, m
};

class JoinedGaps {
public:
    /// Elements of two rods that a joint connects touch where the way along both, over the joint, is longer than `gap`,
    /// m; 0: than half the way round their sections.
    JoinedGaps(std::span<const RodGroup> groups, double gap);
    void add(const JoinedPlace& a, const JoinedPlace& b);
    /// Behind the last joint: rods whose joints on a third one are nearer to each other than the gap meet as well.
    void settle();

    /// True where two elements of different bodies of one copy may touch.
    bool may_touch(const Exposure& bodies, std::size_t a, std::size_t b) const;

private:
    /// The rest state of a rod.
    struct Line {
        std::vector<double> arc = {}; ///< of each node, m; none of a body
        double half_round = 0;        ///< half the way round the widest section, m
    };
    struct Group {
        std::int64_t first_gid, rods_per_copy;
        std::vector<Line> lines; ///< one, or one of each rod
        bool closed;

        const Line& line(std::int64_t rod) const { return lines.size() == 1 ? lines.front() : nth(lines, rod); }
    };
    struct Arcs {
        double a, b;
    };
    /// Numbers of two bodies in the first copy, the lower one first.
    using Bodies = std::pair<std::int64_t, std::int64_t>;
    struct Met {
        int group;
        std::int64_t rod;
        double arc; ///< at rest, m; of a body 0
        Vec3d arm;
        std::size_t set;
    };
    Met met(const JoinedPlace& place, std::size_t set) const;
    bool near(const Met& a, const Met& b) const;
    double gap_of(const Line& a, const Line& b) const { return gap_ > 0 ? gap_ : std::max(a.half_round, b.half_round); }
    std::int64_t in_first_copy(int group, std::int64_t gid) const;
    static double way(const Line& line, bool closed, std::int64_t element, double arc);

    std::vector<Group> groups_;
    double gap_;
    std::vector<Met> met_; ///< places by the set of those that meet
    std::map<Bodies, std::vector<Arcs>> joints_;
};

} // namespace skein
