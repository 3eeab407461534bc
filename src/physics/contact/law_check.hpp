// Contradictions in the law of a contact.
#pragma once

#include "contact/contact_law.hpp"
#include "skein/core/objections.hpp"

namespace skein {

/// `assumed`: the overlap that the time step allows for, over the diameter.
void check_law(const ContactLaw& law, double assumed, Objections& objections);

} // namespace skein
