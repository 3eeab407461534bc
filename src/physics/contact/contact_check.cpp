#include "physics/contact/law_check.hpp"

#include "core/nearest.hpp"
#include "physics/group_names.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace skein {

namespace {

void contact_pair(const SceneSpec& scene, const ContactPair& pair, Objections& objections) {
    if (pair.between.size() != 2) objections.add("between", "'between' names two groups, or one group twice");
    for (std::size_t i = 0; i < pair.between.size(); ++i)
        group_named(scene, pair.between[i], objections, fmt::format("between.{}", i));
    check_law(pair.law, scene.contact->overlap, objections);
    if (pair.law.normal != scene.contact->law.normal || pair.law.friction != scene.contact->law.friction)
        objections.add("", "'normal' and 'friction' must be those of [contact]; the numbers may differ");
}

} // namespace

void ContactTables::check(const SceneSpec& scene, Objections& objections) {
    if (scene.output.contacts > 0 && !scene.contact)
        objections.add("output.contacts", "'contacts' has no use without [contact]");
    if (!scene.contact) {
        for (std::size_t i = 0; i < scene.contact_pairs.size(); ++i)
            objections.add(fmt::format("contact_pair.{}", i), "a [[contact_pair]] needs [contact]");
        return;
    }
    TableObjections contact(objections, "contact");
    check_law(scene.contact->law, scene.contact->overlap, contact);
    if (scene.contact->law.friction == ContactFriction::anisotropic)
        contact.add("friction", "anisotropic friction is for walls");
    if (scene.contact->joined && scene.joints.empty() && scene.assemblies.empty())
        contact.add("joined", "'joined' has no use without [[joint]] or [[assembly]]");
    if (!scene.contact->self && !scene.contact->joined) contact.unused({"self_gap"}, "without 'self' or 'joined'");
    if (kicks_backwards(scene.time.integrator))
        contact.add("", "contact needs integrator = \"verlet\": the kicks of \"pefrl\" go backwards too");
    for (std::size_t i = 0; i < scene.contact_pairs.size(); ++i) {
        TableObjections pair(objections, fmt::format("contact_pair.{}", i));
        contact_pair(scene, scene.contact_pairs[i], pair);
    }
}

} // namespace skein
