#include "physics/contact/contact_interaction.hpp"

#include "parallel/exact_sum.hpp"
#include "physics/contact/contact_plan.hpp"
#include "rod/body_name.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>

namespace skein {

namespace {

constexpr std::size_t contact_size = 11; ///< two slots, status, memory
using Row = std::array<double, contact_size>;

template <class Row> std::vector<Row> rows_of(std::span<const std::byte> bytes) {
    std::vector<Row> rows(bytes.size() / sizeof(Row));
    if (!rows.empty()) std::memcpy(rows.data(), bytes.data(), bytes.size());
    return rows;
}

/// Least limit(rod, its law), s, of rods whose stiffness is proportional to their own masses. Beside a much heavier rod
/// a rod meets twice the stiffness that two alike have, and moves alone: the limit is that of two alike.
template <class Limit> double least_by_mass(const RodGroup& group, const ContactLaw& law, const Limit& limit) {
    double least = HUGE_VAL;
    const double mean = body_mass(group);
    for_each_kind(group, [&](const RodGroup& kind, double) {
        ContactLaw own = law;
        own.stiffness *= body_mass(kind) / mean;
        own.damping *= body_mass(kind) / mean;
        least = std::min(least, limit(kind, own));
    });
    return least;
}
/// Limit at an overlap of a whole diameter, s.
double limit_at_whole_overlap(const RodGroup& group, const ContactLaw& law) {
    const ContactMobility of = contact_mobility(group);
    return contact_limit(of, law, tangent_stiffness(law, of.diameter), 0, 1);
}
/// The limit at an overlap, over the diameter, over the one at a whole diameter.
double limit_over_whole_overlap(const ContactLaw& law, double overlap) {
    return law.normal == ContactNormal::linear ? 1 : 1 / std::sqrt(std::sqrt(std::max(overlap, 1e-12)));
}

/// True for laws that differ by rounding alone.
bool alike(const ContactLaw& a, const ContactLaw& b) {
    constexpr double rounding = 1e-12;
    const auto same = [](double x, double y) {
        return std::abs(x - y) <= rounding * std::max(std::abs(x), std::abs(y));
    };
    return a.by_mass == b.by_mass && same(a.stiffness, b.stiffness) && same(a.damping, b.damping) &&
           same(a.tangential_share, b.tangential_share) && same(a.tangential_damping, b.tangential_damping);
}

/// The laws between group g and any group, each once. Beside a heavier body one has up to twice the stiffness and moves
/// alone, so laws by mass are those of two bodies alike. `mass`: of bodies by group, kg.
std::vector<ContactLaw> laws_of(const ContactLaws& laws, std::span<const double> mass, std::size_t g) {
    std::vector<ContactLaw> found{laws.between(g, g)};
    for (std::size_t other = 0; laws.materials() > 1 && other < mass.size(); ++other) {
        ContactLaw law = laws.between(g, other);
        if (law.by_mass) {
            const double times = 0.5 * (1 + mass[g] / mass[other]); // reduced mass of two alike over that of both
            law.stiffness *= times;
            law.damping *= times;
        }
        if (std::none_of(found.begin(), found.end(), [&](const ContactLaw& one) { return alike(one, law); }))
            found.push_back(law);
    }
    return found;
}

} // namespace

ContactInteraction::ContactInteraction(const InteractionParts& parts, const ContactPlan& contact)
    : comm_(parts.comm), plan_(parts.plan), contact_(contact), groups_(parts.groups), exposure_(parts.around.exposure),
      loads_(parts.around.loads), all_rods_(exposure_->scene().bodies()),
      contacts_(
          kernels(plan_.machine.lanes)
              .make_contacts(contact_.scene(groups_, loads_->has_tangents, parts.around.meeting_zone), parts.threads)) {
    for (const RodGroup& group : groups_) mobility_.push_back(contact_mobility(group));
    const ContactLaws& laws = contact_.laws;
    const std::size_t materials = laws.materials();
    for (std::size_t i = 0; i < materials * materials; ++i)
        soft_until_ = std::max(soft_until_, laws.between(i / materials, i % materials).soft_until);
    std::vector<double> masses;
    for (const RodGroup& group : groups_) masses.push_back(materials > 1 ? body_mass(group) : 0);
    for (std::size_t g = 0; g < groups_.size(); ++g) add_guards(g, laws_of(laws, masses, g));
    contacts_->arrived_in(plan_.dt);
    overlap_ = {.of = "rods",
                .allowed = contact_.spec.overlap,
                .normal = laws.normal(),
                .stiffness = materials == 1 ? laws.between(0, 0).stiffness : 0};
}

void ContactInteraction::add_guards(std::size_t g, std::span<const ContactLaw> laws) {
    const RodGroup& group = groups_[g];
    const bool by_rod = group.heterogeneous() &&
                        std::any_of(laws.begin(), laws.end(), [](const ContactLaw& law) { return law.by_mass; });
    const auto planned = [&](const RodGroup& of, const ContactLaw& law) {
        return contact_time_limit(of, law, contact_.spec.overlap).dt;
    };
    for (const ContactLaw& law : laws) {
        const auto least = [&](const auto& limit) {
            return by_rod && law.by_mass ? least_by_mass(group, law, limit) : limit(group, law);
        };
        guards_.push_back({g, law, by_rod ? least(limit_at_whole_overlap) : 0});
        planned_limit_ = std::min(planned_limit_, least(planned));
    }
}

double ContactInteraction::begin_rebuild() {
    contacts_->prepare_rebuild(*exposure_);
    const double way = comm_.max(contacts_->largest_displacement(*exposure_));
    contacts_->set_largest_displacement(way);
    return std::max(contacts_->next_skin(), 2 * way);
}

void ContactInteraction::find_partners(const Exposure& near, std::span<std::uint8_t> wanted) {
    inactive_ = contacts_->search(near, wanted);
}

void ContactInteraction::settle(std::span<const std::uint32_t> slot) {
    loads_->load.resize(exposure_->slots());
    if (loads_->has_tangents) loads_->tangent.resize(exposure_->slots());
    contacts_->finish_rebuild(*exposure_, slot, comm_.sum(inactive_));
}

void ContactInteraction::rebind(const InteractionParts& parts) {
    exposure_ = parts.around.exposure;
    loads_ = parts.around.loads;
    follows_ = true;
}

void ContactInteraction::add_work(std::span<const LocalRod> own, std::span<double> work) const {
    const std::vector<double> by_window = contacts_->work(*exposure_);
    for (std::size_t i = 0; i < own.size(); ++i) work[i] += by_window[exposure_->number_of_own(i)];
}

OwnerDirectory ContactInteraction::directory() const {
    std::vector<std::int64_t> own;
    for (const Window& w : exposure_->window)
        if (w.own) own.push_back(w.gid);
    return OwnerDirectory(comm_, own, all_rods_);
}

std::int64_t ContactInteraction::element(std::size_t slot) const {
    const bool strained = nth(groups_, exposure_->at(slot).group).strained();
    return exposure_->element(slot) / (strained ? 1 : 2);
}

void ContactInteraction::begin(const Step&, Timers&) {
    if (before_) restore(SavedNumbers(before_->numbers));
}

void ContactInteraction::begin_evaluation() {
    if (before_) restore(SavedNumbers(before_->numbers));
    const ContactFigures f = contacts_->figures();
    before_ = Before{saved(), memory(), f.friction_work, f.viscous_work};
}

ContactFigures ContactInteraction::present_figures() const {
    ContactFigures f = contacts_->figures();
    if (before_) {
        f.friction_work = before_->friction_work;
        f.viscous_work = before_->viscous_work;
    }
    return f;
}

void ContactInteraction::add_own(const Step& step) {
    behind_ = step.ahead > 0 ? step.dt - step.ahead : 0;
    contacts_->arrived_in(step.drift);
    contacts_->set_tangents(loads_->tangent);
    contacts_->begin(*exposure_, step.time, step.kick, loads_->load, comm_.size() > 1);
}

void ContactInteraction::add_shared(const Step& step) {
    contacts_->finish(*exposure_, step.kick, loads_->load);
    loads_->touched = contacts_->touched();
    forces_lost_ = false;
    const auto changes = contacts_->side_changes();
    if (!changes.empty() && side_change_.empty()) take_side_change(changes.front(), step);
    if (step.time >= soft_until_) watch_overlap(step);
    if (!audit_begins_ || before_) return;
    const double shown = step.ahead > 0 ? step.ahead : step.drift; // since the state where the audit began
    start_bookings_.add(bookings(*audit_begins_ - shown));         // works are in it already
    audit_begins_.reset();
}

void ContactInteraction::keep(std::size_t place) {
    contacts_->keep(place, *exposure_);
    nth(kept_overlap_, place) = overlap_;
}

void ContactInteraction::go_back(std::size_t place) {
    contacts_->go_back(place, *exposure_);
    overlap_ = nth(kept_overlap_, place);
    side_change_.clear();
    cause_.clear();
    remedies_.clear();
    step_of_change_ = HUGE_VAL;
}

void ContactInteraction::Bookings::add(const Bookings& other) {
    energies.insert(energies.end(), other.energies.begin(), other.energies.end());
    totals.insert(totals.end(), other.totals.begin(), other.totals.end());
}

double ContactInteraction::sum(const Bookings& mine) const {
    double all = exact_sums(comm_, std::vector<std::vector<double>>{mine.energies}).front();
    for (const BinnedTotal& total : totals(comm_, mine.totals)) all += total.value();
    return all;
}

void ContactInteraction::begin_audit(double lag) {
    const ContactFigures f = contacts_->figures();
    audit_begins_ = lag;
    start_bookings_ = {.energies = {}, .totals = {f.friction_work, f.viscous_work}};
}

ContactInteraction::Bookings ContactInteraction::bookings(double after) const {
    const auto energies_at = [&](double time) {
        Exposure moved = *exposure_;
        for (std::size_t i = 0; i < moved.slots(); ++i) moved.node[i].position += time * moved.motion[i].velocity;
        return contacts_->normal_energies(moved);
    };
    Bookings all{.energies = energies_at(after), .totals = {}};
    if (contact_.laws.friction() == ContactFriction::none) return all;
    all.totals.push_back(
        contacts_->figures().elastic_energy); // less that of normal springs: what springs of friction store
    for (const double energy : energies_at(0)) all.energies.push_back(-energy);
    return all;
}

double ContactInteraction::booked(double lag) const {
    if (audit_begins_ || forces_lost_) return booked_at_start();
    const ContactFigures f = present_figures();
    Bookings all = bookings(lag + behind_);
    all.add({.energies = {}, .totals = {f.friction_work, f.viscous_work}});
    return sum(all);
}

double ContactInteraction::booked_at_start() const { return sum(start_bookings_); }

void ContactInteraction::watch_overlap(const Step& step) {
    constexpr double noticeably = 1.01;
    const double now = contacts_->figures().max_overlap;
    if (now > overlap_.allowed && now > noticeably * overlap_.overlap)
        overlap_.times = std::max(overlap_.times, stiffening());
    overlap_.take(now, step.index);
}

std::string ContactInteraction::place_of(std::size_t slot) const {
    const Window& w = exposure_->at(slot);
    const bool strained = nth(groups_, w.group).strained();
    return fmt::format("{} ({} {})", name_of_body(groups_, w.gid), strained ? "element" : "part", element(slot));
}

void ContactInteraction::take_side_change(const SideChange& change, const Step& step) {
    const auto [a, b] = change.pair;
    const auto group_a = static_cast<std::size_t>(exposure_->at(a).group),
               group_b = static_cast<std::size_t>(exposure_->at(b).group);
    const ContactLaw& law = contact_.laws.between(group_a, group_b);
    const double diameter = change.diameter, allowed = contact_.spec.overlap * diameter,
                 way = change.speed * step.drift, times = change.energy / energy_at(law, allowed);
    side_change_ =
        change.nearest == 0
            ? fmt::format("{} and {} have passed through each other at {:.3g} m/s", place_of(a), place_of(b),
                          change.speed)
            : fmt::format(
                  "{} and {} pass through each other at {:.3g} m/s, their axes {:.2g} of the sum of their radii apart,",
                  place_of(a), place_of(b), change.speed, change.nearest);
    cause_ = fmt::format("they move {:.2g} of the diameter against each other in a step", way / diameter);
    remedies_.clear();
    if (way > allowed) {
        step_of_change_ = plan_.dt * allowed / way;
        remedies_.push_back(fmt::format("time.dt={:.2g}", 0.9 * step_of_change_));
        cause_ += fmt::format("; with time.dt = {:.2g} that is less than contact.overlap = {:g}", 0.9 * step_of_change_,
                              contact_.spec.overlap);
    }
    if (times > 1) {
        const StifferLaw stiffer =
            stiffer_law(contact_.spec.law, law, reduced_mass(groups_[group_a], groups_[group_b]), times);
        if (!stiffer.setting.empty()) remedies_.push_back(stiffer.setting);
        cause_ += fmt::format("; {} would take up their energy within that overlap", stiffer.text);
    }
}

/// Factor by which contacts would have to be stiffer to take up the energy of those that are too deep now, of whole
/// bodies that approach each other, at the overlap that is allowed.
double ContactInteraction::stiffening() const {
    double most = 1;
    for (const Contact& contact : contacts_->active(*exposure_)) {
        if (!(contact.overlap > overlap_.allowed * contact.diameter)) continue;
        const auto a = static_cast<std::size_t>(exposure_->at(contact.pair.a).group),
                   b = static_cast<std::size_t>(exposure_->at(contact.pair.b).group);
        const ContactLaw& law = contact_.laws.between(a, b);
        const double approach = std::max(0.0, dot(contact.slip, contact.normal)),
                     mass = reduced_mass(groups_[a], groups_[b]);
        most = std::max(most, (energy_at(law, contact.overlap) + 0.5 * mass * approach * approach) /
                                  energy_at(law, overlap_.allowed * contact.diameter));
    }
    return most;
}

double ContactInteraction::longest_part() const {
    if (contacts_->figures().near == 0) return HUGE_VAL;
    return scheme_of(plan_.integrator).touching * std::min(step_limit(), planned_limit_);
}

std::string ContactInteraction::tightest_pair() const {
    if (contacts_->figures().near == 0) return {};
    const std::vector<Contact> all = contacts_->active(*exposure_);
    const auto deepest = std::max_element(all.begin(), all.end(), [](const Contact& x, const Contact& y) {
        return x.overlap / x.diameter < y.overlap / y.diameter;
    });
    if (deepest == all.end()) return "bodies are about to touch";
    return fmt::format("{} and {} overlap by {:.3g} m", place_of(deepest->pair.a), place_of(deepest->pair.b),
                       deepest->overlap);
}

double ContactInteraction::step_limit() const {
    double limit = HUGE_VAL;
    const ContactFigures f = contacts_->figures();
    for (const Guard& guard : guards_)
        limit = std::min(limit, guard.own_limit > 0
                                    ? guard.own_limit * limit_over_whole_overlap(guard.law, f.max_overlap)
                                    : contact_limit(mobility_[guard.group], guard.law, f.max_stiffness, 0, 1));
    return std::min(limit, step_of_change_);
}

std::string ContactInteraction::invalid() const {
    if (!side_change_.empty()) return side_change_;
    if (plan_.force_dt) return {};
    const ContactFigures f = contacts_->figures();
    const double limit = step_limit();
    if (plan_.dt <= limit) return {};
    return fmt::format(
        "contacts are as stiff as {:.4g} N/m, where rods overlap by {:.3g} of their diameter: the step of {:.4g} s "
        "is beyond the {:.4g} s that they leave",
        f.max_stiffness, f.max_overlap, plan_.dt, limit);
}

Touch ContactInteraction::strongest_touch(std::int64_t gid) const {
    Touch most;
    const Exposure& e = *exposure_;
    for (const Contact& contact : contacts_->active(e)) {
        const auto [a, b] = contact.pair;
        const bool first = e.at(a).gid == gid;
        if (!first && e.at(b).gid != gid) continue;
        const double force = norm(contact.force);
        if (force < most.force) continue; // a force that is not finite is told
        const std::uint32_t own = first ? a : b, other = first ? b : a;
        most = {force,
                fmt::format(
                    "its element {} and element {} of {} press each other with {:.3g} N, {:.3g} of the diameter deep",
                    element(own), element(other), name_of_body(groups_, e.at(other).gid), force,
                    contact.overlap / contact.diameter)};
    }
    return most;
}

std::vector<Figure> ContactInteraction::figures(const Sample&) const {
    using Of = Figure::Of;
    const ContactFigures f = present_figures();
    std::vector<Figure> all = {
        {"contacts[-]", Of::sum, {f.weight}},
        {"touching_pairs[-]", Of::sum, {static_cast<double>(f.active)}},
        {"coordination[-]", Of::sum, {f.weight}, 2, static_cast<double>(all_rods_)},
        {"max_overlap[-]", Of::largest, {f.max_overlap}},
        {.name = "contact_energy[J]", .of = Of::total, .terms = {}, .total = f.elastic_energy},
        {.name = "contact_friction_work[J]", .of = Of::total, .terms = {}, .total = f.friction_work},
        {.name = "contact_viscous_work[J]", .of = Of::total, .terms = {}, .total = f.viscous_work},
        {"candidates[-]", Of::sum, {static_cast<double>(f.candidates)}},
        {"rebuilds[-]", Of::largest, {static_cast<double>(f.rebuilds)}},
        {"skin[m]", Of::same, {f.skin}}};
    const auto works_and_search = std::span(all).last(5);
    for (Figure& figure : works_and_search) figure.of_steps = true;
    return all;
}

std::string ContactInteraction::table() const {
    const Exposure& c = *exposure_;
    using Line = std::array<double, 17>;
    std::vector<Line> mine;
    std::vector<std::int64_t> first_body;
    for (const Contact& contact : contacts_->active(c)) {
        const auto [a, b] = contact.pair;
        const Vec3d &place = contact.place, &normal = contact.normal, &slip = contact.slip, &f = contact.force;
        const double push = -dot(f, normal);
        mine.push_back({double(c.at(a).gid), double(element(a)), contact.s, double(c.at(b).gid), double(element(b)),
                        contact.t, place.x, place.y, place.z, f.x, f.y, f.z, push, norm(f + push * normal),
                        contact.overlap, norm(slip - dot(slip, normal) * normal), contact.weight});
        first_body.push_back(c.at(a).gid);
    }
    std::vector<Line> lines =
        rows_of<Line>(directory().to_blocks(std::as_bytes(std::span(mine)), sizeof(Line), first_body));
    std::sort(lines.begin(), lines.end(), [](const Line& x, const Line& y) {
        return std::tie(x[0], x[1], x[3], x[4]) < std::tie(y[0], y[1], y[3], y[4]);
    });
    std::string text;
    if (comm_.root())
        text = "rod_1,element_1,share_1,rod_2,element_2,share_2,x[m],y[m],z[m],force_x[N],force_y[N],force_z[N],normal["
               "N],friction[N],"
               "overlap[m],slip[m/s],weight\n";
    for (const Line& line : lines) text += fmt::format("{}\n", fmt::join(line, ","));
    return text;
}

void ContactInteraction::forces(std::int64_t gid, std::span<Vec3d> out) const {
    const double none = forces_lost_ ? std::numeric_limits<double>::quiet_NaN() : 0.0;
    std::fill(out.begin(), out.end(), Vec3d{none, none, none});
    const auto first = exposure_->find(exposure_->scene().first_slot(gid));
    if (forces_lost_ || !first || loads_->touched.empty() || !nth(loads_->touched, exposure_->window_of[*first]))
        return;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = loads_->load[*first + i].force;
}

SavedNumbers ContactInteraction::saved() const {
    if (before_) return before_->numbers;
    const ContactFigures f = contacts_->figures();
    std::vector<Row> mine;
    std::vector<std::int64_t> first_body;
    for (const SavedContact& c : contacts_->saved(*exposure_)) {
        const ContactMemory<double>& m = c.memory;
        mine.push_back({double(c.a), double(c.b), double(c.status), m.spring.x.x, m.spring.x.y, m.spring.x.z,
                        m.spring.stiffness, m.viscous_part.x, m.viscous_part.y, m.viscous_part.z, m.weight});
        first_body.push_back(exposure_->scene().gid_at(c.a));
    }
    std::vector<Row> rows =
        rows_of<Row>(directory().to_blocks(std::as_bytes(std::span(mine)), sizeof(Row), first_body));
    std::sort(rows.begin(), rows.end());
    SavedNumbers kept{.name = saved_name(), .numbers = {}, .columns = contact_size, .rows = {}};
    for (const BinnedTotal& work : totals(comm_, std::array{f.friction_work, f.viscous_work}))
        for (const double part : work.numbers()) kept.numbers.push_back(part);
    for (const Row& row : rows) kept.rows.insert(kept.rows.end(), row.begin(), row.end());
    return kept;
}

void ContactInteraction::restore(const SavedNumbers& kept) {
    forces_lost_ = true;
    before_.reset();
    if (!std::exchange(follows_, false)) {
        side_change_.clear();
        cause_.clear();
        step_of_change_ = HUGE_VAL;
    }
    std::vector<Row> mine;
    std::vector<std::int64_t> body;
    for (std::size_t i = 0; i + contact_size <= kept.rows.size(); i += contact_size) {
        Row row;
        std::copy_n(kept.rows.begin() + static_cast<std::ptrdiff_t>(i), contact_size, row.begin());
        for (const std::size_t end : {0, 1}) // to the owners of both
        {
            mine.push_back(row);
            body.push_back(exposure_->scene().gid_at(static_cast<std::int64_t>(row[end])));
        }
    }
    std::vector<Row> rows = rows_of<Row>(directory().to_owners(std::as_bytes(std::span(mine)), sizeof(Row), body));
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    std::vector<SavedContact> contacts;
    for (const Row& n : rows)
        contacts.push_back({static_cast<std::int64_t>(n[0]),
                            static_cast<std::int64_t>(n[1]),
                            static_cast<std::uint32_t>(n[2]),
                            {{{n[3], n[4], n[5]}, n[6]}, {n[7], n[8], n[9]}, n[10]}});
    const BinnedTotal none(contacts_->energy_bins());
    BinnedTotal friction = none, viscous = none;
    if (comm_.root()) { // works are those of all ranks
        constexpr std::size_t parts = BinnedTotal::parts;
        const std::span<const double> works = kept.numbers;
        if (works.size() == 2) { // in checkpoints of before version 8
            friction.add(works[0], contacts_->energy_bins());
            viscous.add(works[1], contacts_->energy_bins());
        } else {
            friction = none.of(works.first<parts>());
            viscous = none.of(works.last<parts>());
        }
    }
    contacts_->restore(contacts, friction, viscous);
}

void ContactInteraction::set_memory(std::span<const SavedContact> contacts) {
    forces_lost_ = true;
    const ContactFigures f = present_figures();
    before_.reset();
    contacts_->restore(contacts, f.friction_work, f.viscous_work);
}

ContactInteraction* contacts_of(const Interactions& all) {
    for (const auto& one : all)
        if (auto* contacts = dynamic_cast<ContactInteraction*>(one.get())) return contacts;
    return nullptr;
}

} // namespace skein
