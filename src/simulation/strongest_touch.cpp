// Who presses a rod most: for those who ask why it came out unfit.
#include "simulation/interactions.hpp"

#include <fmt/format.h>

#include <cmath>

namespace skein {

namespace {

std::string name_of(std::span<const RodGroup> groups, std::int64_t gid) {
    for (const RodGroup& group : groups)
        if (gid < group.first_gid() + group.count()) return fmt::format("rod {} of '{}'", gid - group.first_gid(), group.name());
    return {};
}

} // namespace

Touch Interactions::strongest_touch(std::int64_t gid) const {
    Touch most;
    if (contacts_) {
        const Capsules& c = around_.others->capsules;
        for (const Contact& contact : contacts_->active(c)) {
            const auto [a, b] = contact.pair;
            const bool first = c.rod[a] == gid;
            if (!first && c.rod[b] != gid) continue;
            const double force = norm(contact.force);
            if (force < most.force) continue; // a force that is not finite is told
            const auto element = [&](std::uint32_t slot) {
                return static_cast<std::int64_t>(slot) - c.first_slot[static_cast<std::size_t>(c.rod[slot])];
            };
            const std::uint32_t own = first ? a : b, other = first ? b : a;
            const double diameter = 2 * std::min(c.node[a].radius, c.node[b].radius);
            most = {force,
                    fmt::format("its element {} and element {} of {} press each other with {:.3g} N, {:.3g} of the diameter deep",
                                element(own), element(other), name_of(groups_, c.rod[other]), force, contact.overlap / diameter)};
        }
    }
    const auto local = rods_.local();
    for (std::size_t i = 0; around_.walls && i < local.size(); ++i) {
        const WallAccounts* accounts = around_.accounts[static_cast<std::size_t>(local[i].group)].get();
        if (local[i].gid != gid || !accounts) continue;
        for (std::size_t w = 0; w < around_.walls->count(); ++w) {
            const WallAccount a = accounts->account(rods_.place(i), static_cast<int>(w));
            if (a.touching == 0 || norm(a.force) < most.force) continue;
            most = {norm(a.force), fmt::format("it presses the wall '{}' with {:.3g} N, {:.3g} of the diameter deep",
                                               around_.walls->wall[w].name, norm(a.force), a.deepest)};
        }
    }
    const double strongest = comm_.max(std::isnan(most.force) ? HUGE_VAL : most.force);
    const bool here = !most.text.empty() && !(most.force < strongest);
    return {strongest, comm_.first_text(here ? most.text : std::string())};
}

} // namespace skein
