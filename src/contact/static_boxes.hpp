// Contacts with boxes at rest, over dual numbers: loads of an element and a box, and of two boxes, as contact_boxes.cpp
// and contact_box_pairs.cpp have them in a step.                                             theory.md (59e)-(59h),
// (97)
//   springs    of all features, and what changes with their shares
//   friction   at the mean place of what pushes, from a given spring on
#pragma once

#include "contact/moved_elements.hpp"
// The above comes before all templates over packs.
#include "contact/broad_phase.hpp"
#include "contact/response.hpp"

namespace skein {

/// Loads of a contact, and figures of it.
struct BoxLoads : ElementLoads {
    double energy = 0, overlap = 0; ///< J; m; of springs, and of the deepest feature
    double share[2] = {0, 0};       ///< mean places on the elements; 0 on boxes
};

struct BoxContactAtRest {
    ContactKinds kinds;
    const ContactNumbers<double>& numbers;
    const AttachedSlot* slot[2];                    ///< the first ones of both elements, of which one or both are boxes
    double radius[2];                               ///< of boxes that of their edges, m
    double shares[2];                               ///< of nodes that belong to the element at a box
    double weight = 0;                              ///< of friction; 0: that of all there is
    const FrictionSpring<double>* spring = nullptr; ///< null: no friction

    /// Springs alone over a step of `step` s, friction alone, or all.
    enum class Parts { springs, friction, all };
    BoxLoads load(const MovedElement& a, const MovedElement& b, double step, Parts parts) const;
};

/// Such a contact, and its elements.
struct BoxPairAtRest {
    BoxContactAtRest contact;
    ElementAtRest element[2];
};
/// `attached`: by slot of `bodies`; `numbers` must outlive it.
BoxPairAtRest box_contact_at(const Exposure& bodies, std::span<const AttachedSlot> attached, Pair pair,
                             std::span<const Slot<1>> state, std::span<const Slot<1>> then, ContactKinds kinds,
                             const ContactNumbers<double>& numbers);

} // namespace skein
