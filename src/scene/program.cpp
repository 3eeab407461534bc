#include "scene/program.hpp"

#include "mechanics/law.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

namespace {

// Medians of bench/micro at 8 lanes on a 2.5 GHz Cascade Lake core, ns per element-step.
constexpr double drift_ns = 3.2, elliptic_drift_ns = 9, elastic_ns = 5.6, kick_ns = 1, stretched_kick_ns = 1.6;
// Medians of bench/scenes/nest: contacts at its density, half a candidate per element, with their exposure; a box with
// floor and lid.
constexpr double contact_ns = 40, walls_ns = 8;
constexpr double joints_ns = 8;  // of the millipede: a joint to an element
constexpr double fluid_ns = 9;   // of 256 rods of 50 elements, by runs that feel a fluid and do not
constexpr double relax_ns = 400; // of 64 rods of 50 elements
constexpr double filter_ns = 9,
                 filter_order_ns = 1.5; // by the ratio of runs with and without a filter of order 1, 2 and 4

template <class... F> struct Overloaded : F... { using F::operator()...; };

} // namespace

std::string_view name_of(const PassSpec& pass) {
    return std::visit(Overloaded{[](const pass::Drift& p) { return nth(drift_names, p.top); },
                                 [](const pass::Elastic& p) { return nth(elastic_names, p.law); },
                                 [](const pass::ApplyLoad& p) { return p.kind; },
                                 [](const pass::Kick& p) { return nth(kick_names, p.kind); },
                                 []<class Named>(const Named&) { return Named::name; }},
                      pass);
}

bool may_lie_along(const PassSpec& pass) {
    return std::visit(
        Overloaded{[](const pass::Drift& p) { return p.top != Gyration::plain && p.top != Gyration::elliptic_each; },
                   [](pass::Orthonormalise) { return true; }, [](pass::Slide p) { return !p.clamped_last; },
                   [](const pass::Elastic& p) { return p.law != Law::elastica; },
                   [](const pass::ApplyLoad& p) { return !p.needs_whole_rods; },
                   [](const pass::Kick& p) { return p.kind != KickKind::elastica; }, [](const auto&) { return false; }},
        pass);
}

double predicted_ns(const PassSpec& pass) {
    return std::visit(
        Overloaded{[](const pass::Drift& p) { return p.top == Gyration::circular ? drift_ns : elliptic_drift_ns; },
                   [](pass::Elastic) { return elastic_ns; }, [](const pass::ApplyLoad& p) { return p.ns; },
                   [](pass::Walls) { return walls_ns; }, [](pass::SurfaceWalls) { return walls_ns; },
                   [](pass::TakeJoinedLoads) { return joints_ns; }, [](pass::FeelFluid) { return fluid_ns; },
                   [](const pass::Kick& p) {
                       const bool plain = p.kind == KickKind::undamped || p.kind == KickKind::constant_rates;
                       return p.share * (plain ? kick_ns : stretched_kick_ns);
                   },
                   [](pass::Relax) { return relax_ns; },
                   [](const pass::Filter& p) { return filter_ns + filter_order_ns * static_cast<double>(p.order); },
                   [](const auto&) { return 0.0; }},
        pass);
}

std::string_view name_of(const InteractionSpec& interaction) {
    return std::visit([]<class Named>(const Named&) { return Named::name; }, interaction);
}

double predicted_ns(const InteractionSpec& interaction) {
    return std::holds_alternative<interact::Contacts>(interaction) ? contact_ns : 0;
}

std::vector<std::string_view> GroupProgram::names() const {
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < size(); ++i) names.push_back(name_of((*this)[i]));
    return names;
}

GroupProgram program_of(const RodGroup& group, const ProgramNeeds& needs) {
    const bool moving = group.spec().ends_move(), ring = group.closed(), audit = needs.audit, body = !group.strained();
    const bool filtered = std::any_of(needs.damping.begin(), needs.damping.end(), is_filter);
    const double share = filtered ? 0.5 : 1.0; // of a kick: one before the filters, one after

    std::vector<PassSpec> before;
    before.push_back(pass::Drift{gyration_of(group)});
    if (ring) before.push_back(pass::CloseRing{});
    if (moving && audit) before.push_back(pass::AuditEnds{});
    if (moving) before.push_back(pass::MoveEnds{});
    before.push_back(pass::Orthonormalise{});
    const auto either = [&](bool first, const PassSpec& one, const PassSpec& other) { return first ? one : other; };
    if (needs.coupled) before.push_back(either(body, pass::ExposeSurface{}, pass::Expose{}));

    std::vector<PassSpec> after;
    const auto apply_loads = [&](bool that_act_last) {
        for (std::size_t i = 0; i < needs.loads.size(); ++i)
            if (const Load& load = needs.loads[i]; load.acts_last() == that_act_last)
                after.push_back(pass::ApplyLoad{i, load.kind(), load.needs_whole_rods(), load.predicted_ns()});
    };
    after.push_back(either(body, pass::Unstrained{}, pass::Elastic{group.law()}));
    if (audit) after.push_back(pass::AuditInner{});
    apply_loads(false);
    if (needs.relax && (needs.walls || needs.coupled)) after.push_back(pass::NoteForces{});
    if (needs.joined) after.push_back(pass::TakeJoinedLoads{});
    if (needs.walls) after.push_back(either(body, pass::SurfaceWalls{}, pass::Walls{}));
    if (needs.coupled && audit) after.push_back(pass::AuditLoads{});
    if (needs.coupled) after.push_back(either(body, pass::TakeSurfaceLoads{}, pass::TakeLoads{}));
    if (needs.coupled && audit) after.push_back(pass::AuditInner{});
    apply_loads(true);
    if (ring) after.push_back(pass::FoldRing{});
    if (audit) after.push_back(pass::AuditLoads{});
    if (needs.feels_fluid) after.push_back(pass::FeelFluid{});
    if (needs.relax) after.push_back(pass::Relax{group.law()});
    else after.push_back(pass::Kick{needs.kick, share});
    const bool slides = group.spec().ends_slide();
    const pass::Slide slide{group.spec().end == EndKind::clamped && !group.spec().end_free.empty()};
    if (filtered && slides) after.push_back(slide);
    for (const Damping& d : needs.damping)
        if (is_filter(d)) after.push_back(pass::Filter{d.order, d.rate});
    if (filtered) after.push_back(pass::Kick{needs.kick, share});
    if (slides) after.push_back(slide);
    if (group.spec().hold.any()) after.push_back(pass::Hold{});
    if (audit) after.push_back(pass::AuditBalance{});
    return {std::move(before), std::move(after)};
}

} // namespace skein
