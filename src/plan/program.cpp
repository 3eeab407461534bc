#include "plan/program.hpp"

#include "mechanics/law.hpp"
#include "plan/plan.hpp"
#include "rod/bearing.hpp"

#include <algorithm>

namespace skein {

std::string_view pass::Elastic::name() const { return nth(elastic_names, law); }

void GroupProgram::add(PassSpec pass) {
    const auto after = std::upper_bound(passes_.begin(), passes_.end(), pass.place,
                                        [](PassPlace place, const PassSpec& other) { return place < other.place; });
    passes_.insert(after, std::move(pass));
}

std::size_t GroupProgram::before() const {
    return static_cast<std::size_t>(std::count_if(
        passes_.begin(), passes_.end(), [](const PassSpec& pass) { return pass.place <= PassPlace::expose; }));
}

std::vector<std::string_view> GroupProgram::names() const {
    std::vector<std::string_view> names;
    for (const PassSpec& pass : passes_) names.push_back(pass.name);
    return names;
}

bool GroupProgram::has(PassPlace place) const {
    return std::any_of(passes_.begin(), passes_.end(), [&](const PassSpec& pass) { return pass.place == place; });
}

bool GroupProgram::lies_along() const {
    return std::all_of(passes_.begin(), passes_.end(), [](const PassSpec& pass) { return pass.lies_along; });
}

GroupProgram program_of(const RodGroup& group, const GroupPlan& plan, bool acts_between) {
    const bool ring = group.closed(), body = !group.strained(), slides = group.spec().ends_slide(),
               bearings = !bearings_of(group).empty();
    const bool filtered = std::any_of(plan.damping.begin(), plan.damping.end(), is_filter);
    const double share = filtered ? 0.5 : 1.0; // of a kick: one before the filters, one after
    GroupProgram program;
    if (bearings) program.add(PassPlace::drift, pass::DriftOnBearings{gyration_of(group)});
    else program.add(PassPlace::drift, pass::Drift{gyration_of(group)});
    if (ring) program.add(PassPlace::ring, pass::CloseRing{});
    if (group.spec().ends_move()) program.add(PassPlace::ends, pass::MoveEnds{});
    program.add(PassPlace::frames, pass::Orthonormalise{});
    if (acts_between && body) program.add(PassPlace::expose, pass::ExposeSurface{});
    if (acts_between && !body) program.add(PassPlace::expose, pass::Expose{});
    if (body) program.add(PassPlace::internal, pass::Unstrained{});
    else program.add(PassPlace::internal, pass::Elastic{group.law()});
    if (acts_between && body) program.add(PassPlace::neighbours, pass::TakeSurfaceLoads{});
    if (acts_between && !body) program.add(PassPlace::neighbours, pass::TakeLoads{});
    if (ring) program.add(PassPlace::ring_sum, pass::FoldRing{});
    program.add(PassPlace::kick, pass::Kick{plan.kick, share});
    const pass::Slide slide{group.spec().end == EndKind::clamped && !group.spec().end_free.empty()};
    if (filtered && slides) program.add(PassPlace::slide, slide);
    if (filtered && bearings) program.add(PassPlace::slide, pass::Bearings{plan.kick, share});
    for (const Damping& d : plan.damping)
        if (is_filter(d)) program.add(PassPlace::filter, pass::Filter{d.order, d.rate});
    if (filtered) program.add(PassPlace::second_kick, pass::Kick{plan.kick, share});
    if (slides) program.add(PassPlace::last_slide, slide);
    if (group.spec().hold.any()) program.add(PassPlace::hold, pass::Hold{});
    if (bearings) program.add(PassPlace::bearings, pass::Bearings{plan.kick, share});
    return program;
}

} // namespace skein
