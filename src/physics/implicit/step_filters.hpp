// Filters of rates beside steps that take the place of kicks: these are whole, and filters act before or after them.
#pragma once

#include "plan/plan.hpp"

#include <algorithm>
#include <vector>

namespace skein {

/// Takes the filters of a group from its program, and the second half of its kicks with what belongs to it.
inline std::vector<pass::Filter> take_filters(GroupPlan& p) {
    std::vector<pass::Filter> filters;
    for (const PassSpec& one : p.program)
        if (const auto* filter = one.get<pass::Filter>()) filters.push_back(*filter);
    for (const PassPlace place : {PassPlace::slide, PassPlace::filter, PassPlace::second_kick}) p.program.remove(place);
    return filters;
}

inline void add_filters(GroupPlan& p, PassPlace place, FilterTime time, const std::vector<pass::Filter>& filters) {
    for (pass::Filter filter : filters) {
        filter.time = time;
        p.program.add(place, filter);
    }
}

} // namespace skein
