// Laws of the contacts that a group may have, with other rods and with walls.
#pragma once

#include "contact/contact_limits.hpp"
#include "contact/wall_contacts.hpp"
#include "physics/contact/contact_tables.hpp"
#include "physics/group_names.hpp"
#include "physics/walls/wall_tables.hpp"

namespace skein {

/// Calls f(law, largest overlap over the sum of radii, mass) for every contact that a group may have.
template <class F>
void with_contact_laws(const ContactTables& tables, const WallTables& walls, const RodGroup& group, F&& f) {
    if (tables.contact) f(tables.contact->law, tables.contact->overlap, reduced_mass(group, group));
    for (const ContactPair& pair : tables.contact_pairs)
        if (names_group(pair.between, group.name())) f(pair.law, tables.contact->overlap, reduced_mass(group, group));
    for (const Wall& wall : walls.walls)
        if (wall.acts_on(group.name())) f(wall.law, ContactSpec{}.overlap, mass_at_wall(group));
}

} // namespace skein
