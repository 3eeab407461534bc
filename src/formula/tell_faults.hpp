// Messages for the faults of a vector that a scene writes as formulas.
#pragma once

#include "formula/formula.hpp"
#include "skein/core/objections.hpp"

#include <span>
#include <string>

namespace skein {

/// Adds all faults of the formulas below `key` to the objections.
inline void tell_faults(const std::string& key, std::span<const FormulaFault> faults, Objections& objections) {
    for (const FormulaFault& fault : faults) {
        const std::string message = "'" + key + "': " + fault.message;
        if (fault.part.formula < 0) objections.add(key, message);
        else
            objections.add_within(key + "." + std::to_string(fault.part.formula), fault.part.begin, fault.part.length,
                                  message);
    }
}

} // namespace skein
