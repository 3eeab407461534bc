#include "simulation/interactions.hpp"

#include "parallel/exact_sum.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <tuple>

namespace skein {

namespace {

constexpr std::size_t contact_size = 11; ///< two slots, what, memory
constexpr const char* contacts_name = "contact_memory";
constexpr const char* walls_name = "walls";

/// Rows of numbers of all ranks, put in order.
template <std::size_t columns, class Before = std::less<>> std::vector<std::array<double, columns>>
gathered_rows(const Communicator& comm, const std::vector<std::array<double, columns>>& mine, Before before = {}) {
    const std::vector<double> all = comm.all_gather(std::span(mine.empty() ? nullptr : mine.front().data(), columns * mine.size()));
    std::vector<std::array<double, columns>> rows(all.size() / columns);
    for (std::size_t i = 0; i < all.size(); ++i) rows[i / columns][i % columns] = all[i];
    std::sort(rows.begin(), rows.end(), before);
    return rows;
}

} // namespace

Interactions::Interactions(const Communicator& comm, const Threads& threads, const Plan& plan, std::span<const RodGroup> groups,
                           const Rods& rods, Surroundings around)
    : comm_(comm), plan_(plan), groups_(groups), rods_(rods), around_(std::move(around)) {
    for (const RodGroup& group : groups_) mobility_.push_back(contact_mobility(group));
    std::size_t all_rods = 0;
    for (const RodGroup& group : groups_) all_rods += static_cast<std::size_t>(group.count());
    of_rod_.resize(all_rods);
    if (comm_.size() > 1) know_all_rods();
    if (around_.others) {
        std::vector<std::uint8_t> owned;
        if (comm_.size() > 1) {
            owned.assign(all_rods, 0);
            for (const LocalRod& rod : rods_.local()) owned[static_cast<std::size_t>(rod.gid)] = 1;
        }
        deepest_.allowed = plan_.contact->overlap;
        const std::size_t materials = plan_.contact_laws->materials();
        for (std::size_t i = 0; i < materials * materials; ++i)
            soft_until_ = std::max(soft_until_, plan_.contact_laws->between(i / materials, i % materials).soft_until);
        contacts_ =
            kernels(plan_.machine.lanes).make_contacts(around_.others->capsules, *plan_.contact_laws, threads, std::move(owned));
    }
    if (!around_.walls) return;
    work_.assign(around_.walls->count(), 0);
    deepest_at_.assign(around_.walls->count(), {.allowed = ContactSpec{}.overlap});
    for (std::size_t w = 0; w < around_.walls->count(); ++w) {
        const Wall& wall = around_.walls->wall[w];
        if (wall.servo.drives()) driven_.push_back({static_cast<int>(w), around_.walls->find(wall.servo.watch), Servo(wall)});
    }
}

void Interactions::know_all_rods() {
    std::vector<double> mine;
    for (const LocalRod& rod : rods_.local()) mine.push_back(static_cast<double>(rod.gid));
    count_of_rank_ = comm_.all_gather(static_cast<std::int64_t>(mine.size()));
    std::vector<double> all(of_rod_.size());
    comm_.all_gather(mine, count_of_rank_, all);
    std::size_t at = 0;
    for (const std::int64_t count : count_of_rank_) {
        std::vector<std::int64_t>& gids = rods_of_rank_.emplace_back();
        for (std::int64_t i = 0; i < count; ++i) gids.push_back(static_cast<std::int64_t>(all[at++]));
    }
    if (!around_.others) return;
    const Capsules& capsules = around_.others->capsules;
    for (const auto& gids : rods_of_rank_) {
        std::int64_t slots = 0;
        for (const std::int64_t gid : gids)
            slots += capsules.first_slot[static_cast<std::size_t>(gid) + 1] - capsules.first_slot[static_cast<std::size_t>(gid)];
        slots_of_rank_.push_back(slots);
    }
    sent_.resize(static_cast<std::size_t>(slots_of_rank_[static_cast<std::size_t>(comm_.rank())]));
    received_.resize(static_cast<std::size_t>(std::accumulate(slots_of_rank_.begin(), slots_of_rank_.end(), std::int64_t{0})));
}

void Interactions::meet(const Step& step, Timers& timers) {
    if (!contacts_) return;
    if (comm_.size() > 1) {
        const auto timing = timers.time(Phase::exchange);
        exchange();
    }
    const auto timing = timers.time(Phase::contacts);
    ContactView& view = *around_.others;
    const double searched = contacts_->figures().search_s;
    contacts_->evaluate(view.capsules, step.time, step.kick, view.load);
    timers.move(Phase::contacts, Phase::search, contacts_->figures().search_s - searched);
    view.touched = contacts_->touched_rods();
    forces_lost_ = false;
    if (step.time >= soft_until_) deepest_.take(contacts_->figures().deepest, step.index);
}

void Interactions::look_at_walls(const Step& step) {
    for (std::size_t w = 0; w < deepest_at_.size(); ++w) {
        if (step.time < around_.walls->wall[w].law.soft_until) continue;
        for (const auto& accounts : around_.accounts)
            if (accounts) deepest_at_[w].take(accounts->deepest(static_cast<int>(w)), step.index);
    }
}

void Interactions::Deepest::take(double now, std::int64_t step) {
    overlap = std::max(overlap, now);
    if (passed < 0 && now > allowed) passed = step;
}

bool Interactions::passed() const {
    const auto untold = [](const Deepest& d) { return d.passed >= 0 && !d.told; };
    return untold(deepest_) || std::any_of(deepest_at_.begin(), deepest_at_.end(), untold);
}

std::string Interactions::tell_of_overlaps() {
    std::string text;
    std::size_t at = 0;
    const std::vector<LargestOverlap> all = largest_overlaps();
    const auto tell = [&](Deepest& mine) {
        const std::string one = all[at++].complaint();
        if (mine.told || one.empty()) return;
        mine.told = true;
        text += (text.empty() ? "" : "\n  ") + one;
    };
    if (contacts_) tell(deepest_);
    for (Deepest& wall : deepest_at_) tell(wall);
    return text;
}

std::vector<LargestOverlap> Interactions::largest_overlaps() const {
    std::vector<LargestOverlap> all;
    const auto tell = [&](const std::string& of, const Deepest& mine, ContactNormal normal, double stiffness) {
        constexpr auto never = std::numeric_limits<std::int64_t>::max();
        const std::int64_t first = comm_.min(mine.passed < 0 ? never : mine.passed);
        LargestOverlap& one =
            all.emplace_back(LargestOverlap{of, comm_.max(mine.overlap), mine.allowed, first == never ? -1 : first});
        const double ratio = one.overlap / one.allowed;
        one.times = normal == ContactNormal::linear ? ratio : ratio * std::sqrt(ratio);
        one.stiffness = stiffness;
    };
    if (contacts_)
        tell("rods", deepest_, plan_.contact_laws->normal(),
             plan_.contact_laws->materials() == 1 ? plan_.contact_laws->between(0, 0).stiffness : 0);
    for (std::size_t w = 0; w < deepest_at_.size(); ++w) {
        const Wall& wall = around_.walls->wall[w];
        tell(wall.name, deepest_at_[w], wall.law.normal, wall.law.restitution > 0 ? 0 : wall.law.stiffness);
    }
    return all;
}

std::string LargestOverlap::complaint() const {
    if (passed < 0) return {};
    std::string text = fmt::format("{} overlap by {:.3g} of the diameter, since step {} by more than the {:g} that the time step "
                                   "allows for",
                                   of == "rods" ? "rods" : fmt::format("rods and wall '{}'", of), overlap, passed, allowed);
    if (stiffness > 0)
        text += fmt::format("; stiffness = {:.2g} in place of {:.4g} would hold them there", times * stiffness, stiffness);
    else text += fmt::format("; {:.2g} times the stiffness would hold them there", times);
    return text;
}

void Interactions::exchange() {
    Capsules& c = around_.others->capsules;
    const auto for_slots = [&](std::size_t rank, auto&& f) {
        for (const std::int64_t gid : rods_of_rank_[rank])
            for (auto slot = static_cast<std::size_t>(c.first_slot[static_cast<std::size_t>(gid)]);
                 slot < static_cast<std::size_t>(c.first_slot[static_cast<std::size_t>(gid) + 1]); ++slot)
                f(c.node[slot], c.motion[slot]);
    };
    const auto me = static_cast<std::size_t>(comm_.rank());
    CapsuleSlot* to = sent_.data();
    for_slots(me, [&](const CapsuleNode& node, const CapsuleMotion& motion) { *to++ = {node, motion}; });
    comm_.all_gather(std::as_bytes(std::span(sent_)), sizeof(CapsuleSlot), slots_of_rank_,
                     std::as_writable_bytes(std::span(received_)));
    const CapsuleSlot* from = received_.data();
    for (std::size_t rank = 0; rank < rods_of_rank_.size(); ++rank) {
        if (rank == me) {
            from += slots_of_rank_[rank];
            continue;
        }
        for_slots(rank, [&](CapsuleNode& node, CapsuleMotion& motion) {
            node = from->node, motion = from->motion;
            ++from;
        });
    }
}

double Interactions::pressed(int wall, const Vec3d* along) {
    std::fill(of_rod_.begin(), of_rod_.end(), 0.0);
    for (const auto& accounts : around_.accounts)
        if (accounts) along ? accounts->add_force(wall, *along, of_rod_) : accounts->add_normal(wall, of_rod_);
    if (comm_.size() > 1) {
        std::vector<double> mine, all(of_rod_.size());
        for (const LocalRod& rod : rods_.local()) mine.push_back(of_rod_[static_cast<std::size_t>(rod.gid)]);
        comm_.all_gather(mine, count_of_rank_, all);
        std::size_t at = 0;
        for (const auto& gids : rods_of_rank_)
            for (const std::int64_t gid : gids) of_rod_[static_cast<std::size_t>(gid)] = all[at++];
    }
    return std::accumulate(of_rod_.begin(), of_rod_.end(), 0.0);
}

void Interactions::steer(const Step& step, Timers& timers) {
    if (driven_.empty()) return;
    const auto timing = timers.time(Phase::exchange);
    for (DrivenWall& d : driven_) {
        const auto w = static_cast<std::size_t>(d.wall);
        const Vec3d velocity = around_.walls->state[w].velocity;
        if (d.servo.direction() != 0) work_[w] -= step.kick * pressed(d.wall, &velocity);
        d.servo.step(pressed(d.watched), step.kick);
        around_.walls->state[w] = d.servo.wall_state();
    }
}

bool Interactions::finished() const {
    bool any = false;
    for (const DrivenWall& d : driven_) {
        if (!around_.walls->wall[static_cast<std::size_t>(d.wall)].servo.ends_run) continue;
        if (!d.servo.finished()) return false;
        any = true;
    }
    return any;
}

double Interactions::step_limit() const {
    double limit = HUGE_VAL;
    if (!contacts_) return limit;
    const ContactFigures f = contacts_->figures();
    for (std::size_t g = 0; g < groups_.size(); ++g)
        limit = std::min(limit, contact_limit(mobility_[g], plan_.contact_laws->between(g, g), f.stiffest, 0, 1));
    return limit;
}

std::string Interactions::complaint() const {
    if (!contacts_ || plan_.force_dt) return {};
    const ContactFigures f = contacts_->figures();
    const double limit = step_limit();
    if (plan_.dt <= limit) return {};
    return fmt::format("contacts are as stiff as {:.4g} N/m, where rods overlap by {:.3g} of their diameter: the step of {:.4g} s "
                       "is beyond the {:.4g} s that they leave",
                       f.stiffest, f.deepest, plan_.dt, limit);
}

void Interactions::inspect(std::int64_t step) const {
    if (const std::string text = complaint(); !text.empty()) throw NumericalError(fmt::format("{} at step {}", text, step));
}

std::vector<std::string> Interactions::names() const {
    std::vector<std::string> names;
    if (contacts_)
        names = {"contacts[-]",       "coordination[-]",   "deepest_overlap[-]",
                 "contact_energy[J]", "contact_rubbed[J]", "contact_damped[J]",
                 "candidates[-]",     "renewals[-]",       "skin[m]"};
    if (!around_.walls) return names;
    for (const Wall& wall : around_.walls->wall) names.push_back(wall.name + "_force[N]");
    for (const DrivenWall& d : driven_)
        for (const char* what : {"_height[m]", "_work[J]", "_turns[-]"})
            names.push_back(around_.walls->wall[static_cast<std::size_t>(d.wall)].name + what);
    for (const char* what : {"wall_contacts[-]", "wall_overlap[-]", "wall_energy[J]", "wall_rubbed[J]", "wall_damped[J]"})
        names.emplace_back(what);
    return names;
}

std::vector<double> Interactions::values() const {
    std::vector<double> values;
    if (contacts_) {
        const ContactFigures f = contacts_->figures();
        const std::vector<std::vector<double>> mine = {
            {static_cast<double>(f.active)}, {f.stored}, {f.rubbed}, {f.damped}, {static_cast<double>(f.listed)}};
        const std::vector<double> all = exact_sums(comm_, mine);
        values = {all[0],
                  2 * all[0] / static_cast<double>(of_rod_.size()),
                  comm_.max(f.deepest),
                  all[1],
                  all[2],
                  all[3],
                  all[4],
                  static_cast<double>(comm_.max(f.renewals)),
                  f.skin};
    }
    if (!around_.walls) return values;
    const std::size_t count = around_.walls->count();
    enum { touching, stored, rubbed, damped, sums };
    std::vector<std::vector<double>> mine(count + sums);
    double deepest = 0;
    const auto local = rods_.local();
    for (std::size_t i = 0; i < local.size(); ++i)
        for (std::size_t w = 0; w < count; ++w) {
            const WallAccounts* accounts = around_.accounts[static_cast<std::size_t>(local[i].group)].get();
            if (!accounts) continue;
            const WallAccount a = accounts->account(rods_.place(i), static_cast<int>(w));
            mine[w].push_back(a.normal);
            mine[count + touching].push_back(a.touching);
            mine[count + stored].push_back(a.stored);
            mine[count + rubbed].push_back(a.rubbed);
            mine[count + damped].push_back(a.damped);
            deepest = std::max(deepest, a.deepest);
        }
    const std::vector<double> all = exact_sums(comm_, mine);
    values.insert(values.end(), all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
    for (const DrivenWall& d : driven_)
        for (const double x : {d.servo.height(), work_[static_cast<std::size_t>(d.wall)], static_cast<double>(d.servo.turns())})
            values.push_back(x);
    for (const double x :
         {all[count + touching], comm_.max(deepest), all[count + stored], all[count + rubbed], all[count + damped]})
        values.push_back(x);
    return values;
}

std::string Interactions::contact_table() const {
    const Capsules& c = around_.others->capsules;
    std::vector<std::array<double, 16>> mine;
    for (const Contact& contact : contacts_->active(c)) {
        const auto [a, b] = contact.pair;
        const auto rod = [&](std::uint32_t slot) { return c.rod[slot]; };
        const auto element = [&](std::uint32_t slot) {
            return static_cast<std::int32_t>(slot) - c.first_slot[static_cast<std::size_t>(c.rod[slot])];
        };
        const CapsuleNode &a0 = c.node[a], &a1 = c.node[a + 1], &b0 = c.node[b], &b1 = c.node[b + 1];
        const Vec3d at_a = a0.position + contact.s * (a1.position - a0.position),
                    at_b = b0.position + contact.t * (b1.position - b0.position);
        const Vec3d apart = at_b - at_a, normal = (1 / std::max(norm(apart), 1e-300)) * apart;
        const Vec3d arm_a = (a0.radius - 0.5 * contact.overlap) * normal, arm_b = -(b0.radius - 0.5 * contact.overlap) * normal;
        const auto velocity = [&](std::uint32_t slot, double share, const Vec3d& arm) {
            const CapsuleMotion &first = c.motion[slot], &second = c.motion[slot + 1];
            return first.velocity + share * (second.velocity - first.velocity) + cross(first.spin, arm);
        };
        const Vec3d slip = velocity(a, contact.s, arm_a) - velocity(b, contact.t, arm_b);
        const Vec3d place = at_a + arm_a, &f = contact.force;
        const double push = -dot(f, normal);
        mine.push_back({double(rod(a)), double(element(a)), contact.s, double(rod(b)), double(element(b)), contact.t, place.x,
                        place.y, place.z, f.x, f.y, f.z, push, norm(f + push * normal), contact.overlap,
                        norm(slip - dot(slip, normal) * normal)});
    }
    std::string text = "rod_1,element_1,share_1,rod_2,element_2,share_2,x[m],y[m],z[m],force_x[N],force_y[N],force_z[N],normal[N],"
                       "friction[N],overlap[m],slip[m/s]\n";
    const auto by_pair = [](const auto& x, const auto& y) {
        return std::tie(x[0], x[1], x[3], x[4]) < std::tie(y[0], y[1], y[3], y[4]);
    };
    for (const auto& row : gathered_rows(comm_, mine, by_pair)) text += fmt::format("{}\n", fmt::join(row, ","));
    return text;
}

void Interactions::contact_forces(std::int64_t gid, std::span<Vec3d> out) const {
    const ContactView& view = *around_.others;
    const auto rod = static_cast<std::size_t>(gid);
    const double none = forces_lost_ ? std::numeric_limits<double>::quiet_NaN() : 0.0;
    const bool touched = !forces_lost_ && rod < view.touched.size() && view.touched[rod];
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = touched ? view.load[view.first_slot(gid) + i].force : Vec3d{none, none, none};
}

std::vector<std::string> Interactions::kept_names() const {
    std::vector<std::string> names;
    if (contacts_) names.emplace_back(contacts_name);
    if (around_.walls) names.emplace_back(walls_name);
    return names;
}

std::vector<KeptNumbers> Interactions::kept() const {
    std::vector<KeptNumbers> all;
    if (contacts_) all.push_back({contacts_name, contact_numbers(), 2});
    if (around_.walls) all.push_back({walls_name, wall_numbers(), 0});
    return all;
}

/// Sums of the contacts' energies, then the memory of all ranks' contacts by pair.
std::vector<double> Interactions::contact_numbers() const {
    const ContactFigures f = contacts_->figures();
    std::vector<std::array<double, contact_size>> mine;
    for (const KeptContact& c : contacts_->kept()) {
        const ContactMemory<double>& m = c.memory;
        mine.push_back({double(c.a), double(c.b), double(c.what), m.x.x, m.x.y, m.x.z, m.stiffness, m.beside.x, m.beside.y,
                        m.beside.z, m.dashpot});
    }
    std::vector<double> numbers = exact_sums(comm_, std::vector<std::vector<double>>{{f.rubbed}, {f.damped}});
    for (const auto& r : gathered_rows(comm_, mine)) numbers.insert(numbers.end(), r.begin(), r.end());
    return numbers;
}

/// Per driven wall its work, how many numbers its servo has, and these.
std::vector<double> Interactions::wall_numbers() const {
    std::vector<double> numbers;
    for (const DrivenWall& d : driven_) {
        const std::vector<double> state = d.servo.state();
        numbers.push_back(work_[static_cast<std::size_t>(d.wall)]);
        numbers.push_back(static_cast<double>(state.size()));
        numbers.insert(numbers.end(), state.begin(), state.end());
    }
    return numbers;
}

void Interactions::restore(std::span<const KeptNumbers> kept) {
    forces_lost_ = true;
    for (const KeptNumbers& k : kept) {
        if (k.name == contacts_name) {
            std::vector<KeptContact> contacts;
            for (std::size_t i = 2; i + contact_size <= k.numbers.size(); i += contact_size) {
                const double* n = k.numbers.data() + i;
                contacts.push_back({static_cast<std::uint32_t>(n[0]),
                                    static_cast<std::uint32_t>(n[1]),
                                    static_cast<std::uint32_t>(n[2]),
                                    {{n[3], n[4], n[5]}, n[6], {n[7], n[8], n[9]}, n[10]}});
            }
            if (comm_.root()) contacts_->restore(contacts, k.numbers[0], k.numbers[1]); // sums of all ranks
            else contacts_->restore(contacts);
        } else if (k.name == walls_name) {
            std::size_t at = 0;
            for (DrivenWall& d : driven_) {
                work_[static_cast<std::size_t>(d.wall)] = k.numbers[at];
                const auto count = static_cast<std::size_t>(k.numbers[at + 1]);
                d.servo.restore({k.numbers.data() + at + 2, count});
                at += 2 + count;
                around_.walls->state[static_cast<std::size_t>(d.wall)] = d.servo.wall_state();
            }
        }
    }
}

} // namespace skein
